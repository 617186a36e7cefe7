#!/usr/bin/env bash
# Reads the metrics of a running emulator with the OpenMetrics parser of the Python client of Prometheus: a text that breaks a
# rule of the format fails. Takes about three seconds.
#
#     tests/metrics/run.sh target/release/profidrive
#
# Needs python3 with venv, and once a package index for pip. METRICS_VENV says where the virtual environment is kept, default
# target/metrics-venv.
set -euo pipefail
here=$(realpath "$(dirname "${BASH_SOURCE[0]}")")
root=$(realpath "$here/../..")
. "$here/../helpers/emulator.sh"

[[ $# -eq 1 ]] || cannot "usage: $0 PATH-OF-PROFIDRIVE"
emulator=$(program "$1")
venv=${METRICS_VENV:-${CARGO_TARGET_DIR:-$root/target}/metrics-venv}
# The environment is complete once the copy of the requirements is in it.
if ! cmp -s "$here/requirements.txt" "$venv/requirements.txt"; then
    python3 -m venv --clear "$venv" || cannot "cannot make a virtual environment in $venv"
    "$venv/bin/python" -m pip install --quiet --disable-pip-version-check -r "$here/requirements.txt" ||
        cannot "pip cannot install $here/requirements.txt; is a package index within reach?"
    cp "$here/requirements.txt" "$venv/requirements.txt"
fi

# A link whose name must be escaped.
link="$work/a \"bus\" of \\mine"
cat >"$work/line.toml" <<END
metrics = "127.0.0.1:0"
[[line]]
link = 'pty:$link'
[[line.drive]]
address = 5
[[line.station]]
address = 9
gsd = '$root/tests/gsd/remote_io.gsd'
[[line.ppo-drive]]
address = 7
[[line]]
link = "slcan-tcp:127.0.0.1:0"
node = [{ id = 5 }, { id = 6, device = "ap10" }, { id = 7, device = "asda-a2" }]
END
start_emulator "$emulator" --line "$work/line.toml"
# The parser of others and nothing else: what the numbers are, tests/command/metrics.rs compares.
"$venv/bin/python" "$here/check.py" "$(sed -n '1s/.* metrics=//p' "$work/ready")" "$link"
stop_emulator
