#!/usr/bin/env bash
# Builds the firmwares for boards, and looks at what was linked: its size, the vector table at the place where the chip
# starts, the format of the sources.
set -euo pipefail
[ -z "${CARGO_TARGET_DIR:-}" ] || export CARGO_TARGET_DIR=$(realpath -m "$CARGO_TARGET_DIR")
cd "$(dirname "$0")"

# The word at an offset of a section, little-endian: word FILE SECTION OFFSET.
word() {
    local octets
    octets=$(readelf -x "$2" "$1" | awk '/^ +0x/ { for (i = 2; i < NF && i < 6; i++) printf "%s", $i }')
    octets=${octets:$(($3 * 2)):8}
    echo "$((16#${octets:6:2}${octets:4:2}${octets:2:2}${octets:0:2}))"
}

# check BOARD TARGET VECTOR_TABLE END_OF_RAM
check() {
    rustup target list --installed | grep -qx "$2" || rustup target add "$2"
    (cd "$1" && cargo build --quiet --release --locked --target "$2")
    local program=${CARGO_TARGET_DIR:-$1/target}/$2/release/profidrive-$1 flash table stack start
    flash=$(size -A "$program" | awk '$1 ~ /^[.](vector_table|boot2|text|rodata|data)$/ { sum += $2 } END { print sum }')
    table=$(size -A "$program" | awk '$1 == ".vector_table" { print $3 }')
    stack=$(word "$program" .vector_table 0)
    start=$(word "$program" .vector_table 4)
    printf '%s: %s octets of flash, vector table at 0x%x, stack from 0x%x, start at 0x%x\n' "$1" "$flash" "$table" "$stack" "$start"
    # A program that lacks its slave, its table or its entry is smaller or stands elsewhere.
    ((flash > 20000 && table == $3 && stack == $4 && start % 2 == 1 && start > table)) || {
        echo "$1: expected more than 20000 octets of flash, the table at $3 and the stack from $4" >&2
        exit 1
    }
}

check rp2040 thumbv6m-none-eabi $((0x10000100)) $((0x20040000))
check stm32f4 thumbv7em-none-eabihf $((0x08000000)) $((0x20020000))
