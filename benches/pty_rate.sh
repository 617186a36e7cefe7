#!/usr/bin/env bash
# `emulate` against a trivial echo slave over a pseudo-terminal, with profirust and with pyprofibus as master: rates and
# their ratio. The environment for pyprofibus is that of tests/interop/run.sh, made if it is not there.
set -euo pipefail
cd "$(dirname "$0")/.."

venv=${INTEROP_VENV:-${CARGO_TARGET_DIR:-$PWD/target}/interop-venv}
if ! cmp -s tests/interop/requirements.txt "$venv/requirements.txt"; then
    "${PYTHON:-python3}" -m venv --clear "$venv"
    "$venv/bin/python" -m pip install --quiet --disable-pip-version-check -r tests/interop/requirements.txt
    cp tests/interop/requirements.txt "$venv/requirements.txt"
fi
PYPROFIBUS_PYTHON=$venv/bin/python cargo bench --features cli --bench pty_rate
