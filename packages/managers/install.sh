#!/bin/sh
# Installs the command profidrive @VERSION@ for this machine, with its manual pages and completions:
#
#   curl -fsSL @RELEASE@/install.sh | sh
#
# PREFIX says where, ~/.local by default: PREFIX/bin, PREFIX/share/man/man1, and completions in PREFIX/share. The archive is
# compared with its checksum first; nothing is installed if that differs.
set -eu

main() {
    prefix=${PREFIX:-$HOME/.local}
    release=${PROFIDRIVE_RELEASE:-@RELEASE@}
    target=$(target)
    case $target in
    x86_64-unknown-linux-gnu) wanted="@SHA256 x86_64-unknown-linux-gnu@" ;;
    aarch64-unknown-linux-gnu) wanted="@SHA256 aarch64-unknown-linux-gnu@" ;;
    x86_64-apple-darwin) wanted="@SHA256 x86_64-apple-darwin@" ;;
    aarch64-apple-darwin) wanted="@SHA256 aarch64-apple-darwin@" ;;
    esac
    folder=profidrive-@VERSION@-$target

    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
    fetch "$release/$folder.tgz" "$work/archive.tgz" || stop "cannot fetch $release/$folder.tgz"
    got=$(checksum "$work/archive.tgz")
    [ "$got" = "$wanted" ] || stop "the checksum of $folder.tgz is $got, expected $wanted: fetch it again"

    tar -xzf "$work/archive.tgz" -C "$work"
    "$work/$folder/profidrive" --version >/dev/null ||
        stop "the program does not run on this machine; on Linux it needs glibc 2.35 or newer"
    mkdir -p "$prefix/bin" "$prefix/share/man/man1" "$prefix/share/bash-completion/completions" \
        "$prefix/share/zsh/site-functions" "$prefix/share/fish/vendor_completions.d"
    cp "$work/$folder"/man/*.1 "$prefix/share/man/man1/"
    cp "$work/$folder/completions/profidrive.bash" "$prefix/share/bash-completion/completions/profidrive"
    cp "$work/$folder/completions/profidrive.zsh" "$prefix/share/zsh/site-functions/_profidrive"
    cp "$work/$folder/completions/profidrive.fish" "$prefix/share/fish/vendor_completions.d/"
    # Under a name of its own first: one that runs now is replaced, not written into.
    cp "$work/$folder/profidrive" "$prefix/bin/.profidrive.new"
    mv "$prefix/bin/.profidrive.new" "$prefix/bin/profidrive"
    echo "installed: $prefix/bin/profidrive @VERSION@"
    case :$PATH: in
    *":$prefix/bin:"*) ;;
    *) echo "$prefix/bin is not in PATH: add it, or run the program by its full name" ;;
    esac
}

# The name that the release has for this machine.
target() {
    system=$(uname -s)
    processor=$(uname -m)
    case $system:$processor in
    Linux:x86_64) echo x86_64-unknown-linux-gnu ;;
    Linux:aarch64 | Linux:arm64) echo aarch64-unknown-linux-gnu ;;
    Darwin:x86_64) echo x86_64-apple-darwin ;;
    Darwin:arm64) echo aarch64-apple-darwin ;;
    *) stop "there is no built program for $system on $processor; with a Rust compiler: cargo install --locked profidrive --features cli" ;;
    esac
}

fetch() {
    if command -v curl >/dev/null; then
        curl -fsSL -o "$2" "$1"
    else
        wget -qO "$2" "$1"
    fi
}

checksum() {
    if command -v sha256sum >/dev/null; then
        sha256sum "$1" | cut -d ' ' -f 1
    else
        shasum -a 256 "$1" | cut -d ' ' -f 1
    fi
}

stop() {
    echo "install.sh: $*" >&2
    exit 1
}

# At the end: a script that came in half does nothing.
main
