#!/usr/bin/env bash
# Compiles the firmwares for boards that are not simulated, and looks at the format of all of them.
set -euo pipefail
cd "$(dirname "$0")"

check() {
    rustup target list --installed | grep -qx "$2" || rustup target add "$2"
    (cd "$1" && cargo fmt --check && cargo check --quiet --locked --target "$2")
    echo "$1 compiles for $2"
}

(cd .. && cargo fmt --check)
check rp2040 thumbv6m-none-eabi
check stm32f4 thumbv7em-none-eabihf
