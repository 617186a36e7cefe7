#!/usr/bin/env bash
# Instructions of single calls, counted by callgrind: what no load of the machine changes. Needs valgrind.
# `benches/instructions.sh --profile release-lto` counts those of that profile.
set -euo pipefail
cd "$(dirname "$0")/.."

program=$(cargo bench --bench instructions --no-run "$@" 2>&1 | sed -n 's/.*(\(.*instructions-[0-9a-f]*\)).*/\1/p')
for path in decode_profidrive decode_profirust encode_profidrive encode_profirust turnaround application_cycle; do
    total=$(valgrind --tool=callgrind --callgrind-out-file=/dev/null --toggle-collect="instructions::$path" "$program" \
        2>&1 | awk '/Collected/ { print $4 }')
    printf '%-20s %6d instructions\n' "$path" $((total / 1000))
done
