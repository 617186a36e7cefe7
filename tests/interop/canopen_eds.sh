#!/usr/bin/env bash
# Show the data sheet of the plain CANopen test device to python-canopen.
#
#   tests/interop/canopen_eds.sh
#
# Needs cargo, python3 with venv, and once a package index for pip. INTEROP_VENV as in run.sh. Exit status 0 if
# python-canopen reads what the tables say, 1 with a line beginning with FAIL for each difference, 2 if it cannot run.
set -euo pipefail

here=$(realpath "$(dirname "${BASH_SOURCE[0]}")")
root=$(realpath "$here/../..")
target=${CARGO_TARGET_DIR:-$root/target}
venv=${INTEROP_VENV:-$target/interop-venv}
sheets=$target/tmp/canopen-eds

if ! cmp -s "$here/requirements.txt" "$venv/requirements.txt"; then
    python3 -m venv --clear "$venv" || exit 2
    "$venv/bin/python" -m pip install --quiet --disable-pip-version-check -r "$here/requirements.txt" || exit 2
    cp "$here/requirements.txt" "$venv/requirements.txt"
fi
cargo test --quiet --manifest-path "$root/Cargo.toml" --all-features --test slave the_sheet_is_written_for_python_canopen
"$venv/bin/python" "$here/check_eds.py" "$sheets/plain.eds" "$sheets/plain.tsv"
