#!/usr/bin/env bash
# Drive a CAN bus and CANopen devices of ours with python-can, python-canopen and canopen-asyncio over slcan, and have
# python-canopen and the dcf-tools of Lely CANopen read their data sheets:
#
#   tests/canopen/run.sh [PATH-OF-PROFIDRIVE]
#
# Without a path the command is built.
#
# Needs cargo, python3 with venv, and once a package index for pip. CANOPEN_VENV says where the virtual environment is
# kept, default target/canopen-venv; PYTHON names another interpreter. Exit status 0 if every step passed, 1 with a line
# beginning with FAIL if one did not, 2 if the script cannot run here.
set -euo pipefail
here=$(realpath "$(dirname "${BASH_SOURCE[0]}")")
root=$(realpath "$here/../..")
. "$here/../helpers/emulator.sh"

target=${CARGO_TARGET_DIR:-$root/target}
venv=${CANOPEN_VENV:-$target/canopen-venv}
python=${PYTHON:-python3}
"$python" -c 'import ensurepip, venv' 2>/dev/null || cannot "$python has no venv; install it or set PYTHON"

# The environment is complete once the copy of the requirements is in it.
if ! cmp -s "$here/requirements.txt" "$venv/requirements.txt"; then
    "$python" -m venv --clear "$venv" || cannot "cannot make a virtual environment in $venv"
    "$venv/bin/python" -m pip install --quiet --disable-pip-version-check -r "$here/requirements.txt" ||
        cannot "pip cannot install $here/requirements.txt; is a package index within reach?"
    cp "$here/requirements.txt" "$venv/requirements.txt"
fi
if [[ $# -eq 0 ]]; then
    cargo build --quiet --manifest-path "$root/Cargo.toml" --features cli --bin profidrive
    set -- "$target/debug/profidrive"
fi
profidrive=$(program "$1")
cargo build --quiet --manifest-path "$root/Cargo.toml" --example can_node --example asda_a2_node
"$venv/bin/python" "$here/slcan.py" "$target/debug/examples/can_node"
"$venv/bin/python" "$here/asda_402.py" "$target/debug/examples/asda_a2_node"
for device in ag03-1 ap10 asda-a2; do
    "$venv/bin/python" "$here/nodes.py" "$profidrive" "$device"
    "$venv/bin/python" "$here/sheets.py" "$profidrive" "$device"
done
"$venv/bin/python" "$here/ros2_bus.py" "$profidrive"
for file in pump.eds servo.dcf; do
    "$venv/bin/python" "$here/nodes.py" "$profidrive" "$root/tests/eds/$file"
done
# Every service of CiA 301 that a master uses, heard on the bus. Nothing that was not heard is right.
"$venv/bin/python" "$here/any_master.py" "$profidrive" "$venv/bin/python" "$here/python_master.py"
if "$venv/bin/python" "$here/any_master.py" "$profidrive" true >"$work/nothing" || grep -q '^ok' "$work/nothing"; then
    fail "any_master.py: a master that does nothing passes"
fi
# Nodes of others: what the judge finds in them.
"$venv/bin/python" "$here/judged.py" "$profidrive"
# A folder with files of manufacturers, which are not here, is tried file by file.
"$venv/bin/python" "$here/file_drive.py" "$profidrive" "$root"/tests/eds/{asda-a2,two-axes}.eds ${PROFIDRIVE_EDS_FOLDER:+"$PROFIDRIVE_EDS_FOLDER"}
if command -v npm >/dev/null; then
    peers=${CANOPEN_NPM:-$target/canopen-npm}
    mkdir -p "$peers"
    cp "$here/package.json" "$here/npm_master.js" "$peers"
    npm install --silent --no-audit --no-fund --prefix "$peers" || cannot "npm cannot install canopen; is a registry within reach?"
    start_emulator "$profidrive" --node "5,eds=$root/tests/eds/asda-a2.eds" --link slcan-tcp:127.0.0.1:0
    link=$(sed -n 's/^ready link=slcan-tcp:\([^ ]*\) .*/\1/p' "$work/ready")
    node "$peers/npm_master.js" "$link" 5
    stop_emulator
else
    echo "npm is not here: node-canopen is left out"
fi

"$profidrive" eds asda-a2 >"$work/asda-a2.eds"
"$profidrive" eds ag03-1 >"$work/ag03-1.eds"
start_emulator "$profidrive" --node 4 --node 5,device=asda-a2 --node 6 --link slcan-tcp:127.0.0.1:0
link=$(sed -n 's/^ready link=\([^ ]*\) .*/\1/p' "$work/ready")
"$venv/bin/python" "$here/asda_402.py" --running "$link" "$work/asda-a2.eds" 5
"$venv/bin/python" "$here/ag03_travel.py" "$link" "$work/ag03-1.eds" 4
"$venv/bin/python" "$here/async_fleet.py" "$link" "$work/ag03-1.eds" 4 6
"$profidrive" eds ap10 >"$work/ap10.eds"
stop_emulator
start_emulator "$profidrive" --node 4 --node 6,device=ap10 --node 7,device=asda-a2 --link slcan-tcp:127.0.0.1:0 \
    --panel 127.0.0.1:0
link=$(sed -n 's/^ready link=\([^ ]*\) .*/\1/p' "$work/ready")
panel=$(sed -n 's/.* panel=//p' "$work/ready")
"$venv/bin/python" "$here/bench.py" "$link" "$panel" "$work/ag03-1.eds" "$work/ap10.eds" "$work/asda-a2.eds"
