#!/usr/bin/env bash
# Tests the HTTP API against its own description, by properties: no server error, no answer that is not described, no
# wrong value that is accepted; of drives, then of nodes. Takes about two minutes.
#
#     tests/panel/schemathesis.sh target/release/profidrive
#
# Not checked: that every value the description allows is accepted (a fault is written in a language of its own, and what
# a drive takes depends on its state); that what was deleted is gone (deleting plant inputs makes them nominal); the
# live stream, which does not end.
set -euo pipefail
here=$(realpath "$(dirname "${BASH_SOURCE[0]}")")
. "$here/../helpers/emulator.sh"

[[ $# -eq 1 ]] || cannot "usage: $0 PATH-OF-PROFIDRIVE"
emulator=$(program "$1")

python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check -r "$here/requirements.txt"

cd "$work"
judge() {
    start_emulator "$emulator" "$@" --panel 127.0.0.1:0
    url=$(sed -n 's/.* panel=//p' "$work/ready")
    "$work/venv/bin/schemathesis" --config-file "$here/schemathesis.toml" run "$url/api/v1/openapi.json" \
        --max-time "${SCHEMATHESIS_SECONDS:-45}" --max-examples 40 --continue-on-failure --no-color --warnings off \
        --request-timeout 10 --generation-database none --exclude-path /api/v1/events \
        --exclude-checks positive_data_acceptance,use_after_free
    kill -0 "$emulator_pid" || fail "the emulator has ended"
    stop_emulator
}
judge --drives 5-6 --drive 7,model=ag03,gear=24 --station "9,gsd=$here/../gsd/remote_io.gsd"
judge --node 5 --node 6,device=ap10 --node 7,device=asda-a2 --link slcan-tcp:127.0.0.1:0
