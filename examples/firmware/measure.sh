#!/usr/bin/env bash
# What the firmwares cost: flash, RAM and stack in octets, and instructions, counted by QEMU.
#
#   examples/firmware/measure.sh            prints the numbers
#   examples/firmware/measure.sh --record   writes them to numbers.txt
#   examples/firmware/measure.sh --check    fails if one has grown by more than 5 %, or if a firmware could panic
set -euo pipefail

cannot() {
    echo "$0: $*" >&2
    exit 2
}

here=$(realpath "$(dirname "${BASH_SOURCE[0]}")")
. "$here/tools.sh"
install_tools
cd "$here"
build --bins

work=$(mktemp -d)
octets=
trap 'kill $octets 2>/dev/null || true; rm -rf "$work"' EXIT
# Some octets for the receive interrupt, nobody for the replies.
mkfifo "$work/line.in" "$work/line.out"
cat "$work/line.out" >/dev/null &
(while sleep 0.05 && printf .; do :; done) >"$work/line.in" 2>/dev/null &
octets=$!

firmwares=(ag03 io dpv1 canopen)
for firmware in "${firmwares[@]}"; do
    size -A "$(folder)/$firmware" | awk -v name="$firmware" '
        $1 == ".vector_table" || $1 == ".text" || $1 == ".rodata" || $1 == ".data" { flash += $2 }
        $1 == ".bss" || $1 == ".data" || $1 == ".uninit" { ram += $2 }
        END { print name "_flash", flash; print name "_ram", ram }'
done >"$work/numbers"
# An instruction takes 2^10 ns: the timer, 40 ns a tick, sees each.
(qemu measure -icount shift=10 -chardev "pipe,id=line,path=$work/line" -serial chardev:line) >>"$work/numbers" ||
    cannot "the measurement failed: $(cat "$work/numbers")"

case ${1:-} in
    "") cat "$work/numbers" ;;
    --record) tee numbers.txt <"$work/numbers" ;;
    --check)
        failed=0
        while read -r name before; do
            now=$(awk -v name="$name" '$1 == name { print $2 }' "$work/numbers")
            printf '%s: %s, %s recorded\n' "$name" "$now" "$before"
            if [[ -z $now ]] || ((now * 100 > before * 105)); then
                echo "$name has grown by more than 5 %; if it is worth it: examples/firmware/measure.sh --record" >&2
                failed=1
            fi
        done <numbers.txt
        # Where the linker found a way into the panic handler, it kept core's message functions.
        # Of dpv1 that is not shown yet.
        for firmware in ag03 io canopen; do
            if nm -C "$(folder)/$firmware" | grep 'core::panicking'; then
                echo "$firmware could panic" >&2
                failed=1
            fi
        done
        exit $failed
        ;;
    *) cannot "unknown: $1; usage: $0 [--record|--check]" ;;
esac
