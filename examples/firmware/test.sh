#!/usr/bin/env bash
# Lets masters of others run the firmwares under QEMU: pyprofibus and profirust the drive and the I/O station, our own master and
# judge the station of DP-V1, python-canopen and our own master the CANopen node.
#
#   examples/firmware/test.sh target/release/profidrive
#
# Exit status 0 if all went well, 1 with a line beginning with FAIL otherwise, 2 if it was called wrongly or cannot run here.
set -euo pipefail

here=$(realpath "$(dirname "${BASH_SOURCE[0]}")")
root=$(realpath "$here/../..")
. "$root/tests/helpers/emulator.sh"
. "$here/tools.sh"

[[ $# -eq 1 ]] || cannot "usage: $0 PATH-OF-PROFIDRIVE"
profidrive=$(program "$1")
python=${INTEROP_VENV:-${CARGO_TARGET_DIR:-$root/target}/interop-venv}/bin/python
[[ -x $python ]] || cannot "no $python: run tests/interop/run.sh first, it makes this environment"
canopen_python=${CANOPEN_VENV:-${CARGO_TARGET_DIR:-$root/target}/canopen-venv}/bin/python
[[ -x $canopen_python ]] || canopen_python=$python
line=$work/line

# Starts a firmware and waits for its ready line.
start() {
    local tenths
    : >"$work/ready"
    "$here/run.sh" --link "pty:$line" --program "$1" >"$work/ready" 2>"$work/emulator.log" &
    emulator_pid=$!
    for ((tenths = 0; ; tenths++)); do
        grep -q '^ready ' "$work/ready" && break
        kill -0 "$emulator_pid" 2>/dev/null || fail "$1: ended before it was ready"
        ((tenths < 3000)) || fail "$1: not ready within 300 s"
        sleep 0.1
    done
    grep -qx "ready link=$line $2" "$work/ready" || fail "$1: expected 'ready link=$line $2', got '$(cat "$work/ready")'"
    echo "== $(cat "$work/ready")"
}

# Every row of a slave or a node, on whatever machine: what takes long is left out.
judge() {
    "$profidrive" judge "$@" --quick >"$work/judged" 2>/dev/null \
        || fail "judge $*: $(grep -A8 '^FAIL' "$work/judged" || tail -3 "$work/judged")"
    grep ' passed, ' "$work/judged"
}

judge_slave() {
    judge --slave "$1" --link "$line" --slot 1000
}

stop() {
    kill -TERM "$emulator_pid"
    wait "$emulator_pid" || fail "firmware: expected exit status 0 after SIGTERM, got $?"
    emulator_pid=
    [[ ! -e $line ]] || fail "firmware: left the link $line behind"
}

# Once, so that the ready line comes at once; and QEMU is there.
install_tools
(cd "$here" && build --bins)

start ag03 drives=5
for run in "500000" "9600 --short" "9600 --short"; do
    # On a busy machine QEMU may be later with a reply than pyprofibus waits: not each time.
    for try in 1 2 3; do
        # shellcheck disable=SC2086 # the words of a run
        "$python" "$root/tests/interop/positioning.py" --port "$line" --gsd "$root/gsd/SIKO0AC5.GSD" --baud $run && break
        ((try < 3)) || fail "positioning.py at $run"
        sleep 0.5
    done
    # run.sh looks after the rate that a master leaves behind.
    sleep 0.5
done
"$profidrive" master --link "$line" --master-address 2 --address 5 move 800 --yes || fail "profirust: move"
judge_slave "5,gsd=$root/gsd/SIKO0AC5.GSD"
stop

start io stations=7
"$profidrive" gsd check "$root/gsd/PDRV494F.GSD" || fail "the GSD of the I/O station"
"$python" "$root/tests/interop/io_station.py" --port "$line" --gsd "$root/gsd/PDRV494F.GSD" || fail "io_station.py"
judge_slave "7,gsd=$root/gsd/PDRV494F.GSD"
stop

start dpv1 stations=7
v1=$here/dpv1.gsd
"$profidrive" gsd check "$v1" || fail "the GSD of the station of DP-V1"
record() { "$profidrive" master --link "$line" --address 7 record "$@" || fail "master record $*"; }
# "pump 1" and blanks.
record write 0 1 70756D70203120202020202020202020
record read 0 1 | tee "$work/record"
grep -q '70 75 6D 70 20 31' "$work/record" || fail "the name that was written is not read"
record read 1 2
"$profidrive" master --link "$line" --address 7 im | tee "$work/record"
grep -q 'IO 8/8 DP-V1' "$work/record" || fail "I&M0 says no order number"
judge_slave "7,gsd=$v1"
stop

start canopen nodes=5
"$profidrive" eds ag03-1 >"$work/ag03.eds"
"$canopen_python" "$root/tests/canopen/ag03_travel.py" "$line" "$work/ag03.eds" 5 || fail "ag03_travel.py"
"$profidrive" master --link "slcan-tty:$line" --node 5 move 0 --yes || fail "our master on CANopen: move"
judge --node "5,eds=$work/ag03.eds" --link "slcan-tty:$line"
stop
echo "OK: masters run the firmwares"
