#!/usr/bin/env bash
# Links a firmware with one slave, one drive, one CANopen node, and AG03/1, AP10 and ASDA-A2 as nodes for a Cortex-M4F, and
# compares what they take of flash and RAM with sizes.txt: more than 5 % more is a failure. `check.sh --record` writes sizes.txt instead.
#
# flash: .text, .rodata and .data, less those of a firmware with neither. ram: .bss and .data; the stack comes on top.
set -euo pipefail
cd "$(dirname "$0")"

target=thumbv7em-none-eabihf
rustup target list --installed | grep -qx "$target" || rustup target add "$target"
folder="${CARGO_TARGET_DIR:-target}"

# Octets of flash and of RAM in a firmware with this feature.
sizes() {
    cargo build --quiet --release --locked --target "$target" --features "$1"
    size -A "$folder/$target/release/small-target" | awk '
        $1 == ".text" || $1 == ".rodata" || $1 == ".data" { flash += $2 }
        $1 == ".bss" || $1 == ".data" { ram += $2 }
        END { print flash, ram }'
}

read -r frame _ < <(sizes "")
measured=""
for part in slave drive node ag03_node ap10_node asda_a2_node; do
    read -r flash ram < <(sizes "$part")
    measured+="$part flash $((flash - frame))"$'\n'"$part ram $ram"$'\n'
done

if [ "${1:-}" = --record ]; then
    printf '%s' "$measured" | tee sizes.txt
    exit
fi
failed=0
while read -r part kind octets; do
    before=$(awk -v part="$part" -v kind="$kind" '$1 == part && $2 == kind { print $3 }' sizes.txt)
    printf '%s: %s octets of %s, %s recorded\n' "$part" "$octets" "$kind" "$before"
    if [ $((octets * 100)) -gt $((before * 105)) ]; then
        printf '%s has grown by more than 5 %%; if it is worth it: tests/small-target/check.sh --record\n' "$part" >&2
        failed=1
    fi
done <<< "${measured%$'\n'}"
exit $failed
