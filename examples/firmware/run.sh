#!/usr/bin/env bash
# Builds a firmware, runs it under QEMU, and has its serial port on a pseudo-terminal.
#
#   examples/firmware/run.sh --link pty:PATH [--program ag03|io|dpv1|canopen]
#
# Prints one line when a master may come: `ready link=PATH drives=5`, for the I/O stations `stations=7`, for the CANopen node
# `nodes=5`. Ends with 0 on SIGTERM or SIGINT; 1 if the firmware panics or QEMU fails, 2 if it is called wrongly or cannot run here.
# QEMU (Debian: qemu-system-arm) and the target of the compiler are installed if they are missing.
set -euo pipefail

cannot() {
    echo "$0: $*" >&2
    exit 2
}

program=ag03
link=
while (($#)); do
    case $1 in
        --link) link=${2:-} && shift ;;
        --program) program=${2:-} && shift ;;
        *) cannot "unknown: $1; usage: $0 --link pty:PATH [--program ag03|io|dpv1|canopen]" ;;
    esac
    shift
done
case $program in
    ag03) who=drives=5 ;;
    io | dpv1) who=stations=7 ;;
    canopen) who=nodes=5 ;;
    *) cannot "no program $program: ag03, io, dpv1 or canopen" ;;
esac
[[ $link == pty:?* ]] || cannot "--link pty:PATH says where the terminal is to be"
path=${link#pty:}
[[ ! -e $path || -L $path ]] || cannot "$path exists and is no link"
path=$(realpath -ms "$path")

here=$(realpath "$(dirname "${BASH_SOURCE[0]}")")
. "$here/tools.sh"
install_tools
cd "$here"
build --bin "$program"

work=$(mktemp -d)
qemu_pid=
cleanup() {
    [[ -z $qemu_pid ]] || kill "$qemu_pid" 2>/dev/null || true
    # Only our own link: another run may have replaced it.
    [[ -z ${terminal:-} || $(readlink "$path") != "$terminal" ]] || rm -f "$path"
    rm -rf "$work"
}
trap cleanup EXIT
trap 'exit 0' TERM INT

qemu "$program" -chardev pty,id=line -serial chardev:line >"$work/out" 2>&1 &
qemu_pid=$!
for ((tenths = 0; ; tenths++)); do
    grep -q '^ready' "$work/out" && break
    kill -0 "$qemu_pid" 2>/dev/null || { cat "$work/out" >&2; exit 1; }
    ((tenths < 100)) || { cat "$work/out" >&2; echo "$0: not ready within 10 s" >&2; exit 1; }
    sleep 0.1
done
terminal=$(sed -n 's/^char device redirected to \(.*\) (label line)$/\1/p' "$work/out")
# Held open here, so that QEMU never takes the line for cut when a master goes.
exec 9<>"$terminal"
# It looks once a second whether somebody has the terminal open, and passes nothing before.
sleep 1.2
ln -sfn "$terminal" "$path"
echo "ready link=$path $who"

# Debian's C library lets a program with even parity open a pseudo-terminal only if its rate changes, and pyprofibus opens every
# port at 9600 first: a master that used 9600 must not leave it behind. The rate means nothing here.
while kill -0 "$qemu_pid" 2>/dev/null; do
    [[ $(stty -F "$terminal" speed) != 9600 ]] || stty -F "$terminal" 38400
    # A signal ends the wait at once, not the sleep.
    sleep 0.02 &
    wait $! || true
done
cat "$work/out" >&2
echo "$0: the firmware has ended" >&2
qemu_pid=
exit 1
