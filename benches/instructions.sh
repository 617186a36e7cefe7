#!/usr/bin/env bash
# Instructions of single calls, counted by callgrind: what no load of the machine changes. Needs valgrind.
#
# benches/instructions.sh                         prints the counts
# benches/instructions.sh --profile release-lto   prints those of that profile
# benches/instructions.sh --check                 compares with instructions.txt: more than 3 % more is a failure
# benches/instructions.sh --record                writes instructions.txt instead
set -euo pipefail
cd "$(dirname "$0")/.."

command -v valgrind >/dev/null || {
    echo "valgrind is missing: apt-get install valgrind" >&2
    exit 1
}
what=print
case "${1:-}" in
    --check | --record) what=${1#--} && shift ;;
esac

# The program of a bench.
program() {
    cargo bench --features eds --bench "$@" --no-run 2>&1 | sed -n 's/.*(\(.*-[0-9a-f]*\)).*/\1/p'
}

# Instructions below a function, divided by how often it is called.
count() {
    local function=$1 calls=$2 total
    shift 2
    total=$(valgrind --tool=callgrind --callgrind-out-file=/dev/null --toggle-collect="$function" "$@" 2>&1 |
        awk '/Collected/ { print $4 }')
    printf '%s %d\n' "${node:+${node}_}${function##*::}" $((total / calls))
}

calls=$(program instructions "$@")
bus=$(program full_bus "$@")
counts=$(
    for path in decode_profidrive decode_profirust encode_profidrive encode_profirust turnaround application_cycle cycle_of_new_outputs; do
        count "instructions::$path" 1000 "$calls"
    done
    # The nodes of CAN, and a drive from a file.
    for node in ag03-1 ap10 asda-a2 eds; do
        count instructions::node::sdo_answer 1000 "$calls" "$node"
        count instructions::node::sync_to_last_tpdo 1000 "$calls" "$node"
    done
    node=
    # 8 rounds of 125 drives.
    count full_bus::counted_rounds 1000 "$bus" --bench --count 8
)

recorded=benches/instructions.txt
failed=0
case $what in
    print) printf '%s\n' "$counts" | awk '{ printf "%-20s %6d instructions\n", $1, $2 }' ;;
    record) printf '%s\n' "compiler $(rustc --version | cut -d ' ' -f 2)" "$counts" | tee "$recorded" ;;
    check)
        while read -r path now; do
            before=$(awk -v path="$path" '$1 == path { print $2 }' "$recorded")
            printf '%s: %s instructions, %s recorded\n' "$path" "$now" "${before:-none}"
            case $path in
                # Not ours: what we are compared with.
                *_profirust) ;;
                *) [ -n "$before" ] && [ $((now * 100)) -le $((before * 103)) ] || {
                    printf '%s needs over 3 %% more instructions than recorded (%s, not %s).\n' \
                        "$path" "$now" "${before:-none}" >&2
                    failed=1
                } ;;
            esac
        done <<< "$counts"
        if [ $failed = 1 ]; then
            printf '%s\n' \
                "Recorded with rustc $(awk '$1 == "compiler" { print $2 }' "$recorded"), counted with $(rustc --version | cut -d ' ' -f 2)." \
                "If the change is worth it, or the compiler is another: benches/instructions.sh --record" >&2
        fi
        ;;
esac
exit $failed
