# Sourced by run.sh, measure.sh and test.sh: the tools they need, how a firmware is built and started.

readonly target=thumbv7em-none-eabihf

# QEMU and the target of the compiler, if they are not there.
install_tools() {
    if ! command -v qemu-system-arm >/dev/null; then
        { apt-get update -qq && apt-get install -y -qq --no-install-recommends qemu-system-arm; } >&2 ||
            cannot "qemu-system-arm is missing and cannot be installed"
    fi
    rustup target list --installed | grep -qx "$target" || rustup target add "$target" >&2 ||
        cannot "the compiler has no target $target"
}

# Where cargo puts what it builds here.
folder() { echo "${CARGO_TARGET_DIR:-target}/$target/release"; }

build() { cargo build --quiet --release --locked --target "$target" "$@" >&2; }

# Runs a firmware with these further options. What it says comes on the standard output.
qemu() {
    exec qemu-system-arm -M mps2-an386 -display none -monitor none \
        -semihosting-config enable=on,target=native -kernel "$(folder)/$1" "${@:2}"
}
