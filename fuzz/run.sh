#!/usr/bin/env bash
# Fuzzes each target for some seconds: fuzz/run.sh [SECONDS [TARGET...]], 10 seconds and all targets by default.
#
# Needs neither cargo-fuzz nor a nightly compiler: the coverage that libFuzzer steers by comes from LLVM, and the
# targets hold no unsafe code for a sanitizer to watch. Inputs found are thrown away unless CORPUS names a folder to
# keep them in; an input that fails is left in fuzz/artifacts. SEED makes a run of the same build the same again.
# COMPARES=0 leaves out what libFuzzer learns from comparisons: for long runs, whose corpus has learnt it; an execution of
# dpv1 takes half of the time then, and is judged by the same invariants.
set -euo pipefail
cd "$(dirname "$0")"

seconds=${1:-10}
shift || true
targets=("$@")
if [ ${#targets[@]} -eq 0 ]; then
    for file in fuzz_targets/*.rs; do targets+=("$(basename "$file" .rs)"); done
fi

host=$(rustc -vV | sed -n 's/^host: //p')
coverage="-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4"
coverage+=" -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table"
coverage+=" -Cllvm-args=-simplifycfg-branch-fold-threshold=0"
build="${CARGO_TARGET_DIR:-../target}/fuzz"
if [ "${COMPARES:-1}" = 0 ]; then
    build+="-without-compares"
else
    coverage+=" -Cllvm-args=-sanitizer-coverage-trace-compares"
fi
RUSTFLAGS="$coverage --cfg fuzzing -Cdebug-assertions -Ccodegen-units=1" \
    cargo build --quiet --release --bins --target "$host" --target-dir "$build"

found=${CORPUS:-$(mktemp -d)}
mkdir -p artifacts
fuzz() {
    local target=$1 log=$found/$1.log
    mkdir -p "$found/$target"
    if ! "$build/$host/release/$target" -max_total_time="$seconds" -seed="${SEED:-0}" -max_len=512 -print_final_stats=1 \
        -artifact_prefix="artifacts/$target-" "$found/$target" "corpus/$target" >"$log" 2>&1; then
        tail -n 40 "$log" >&2
        printf 'fuzz/run.sh: %s failed; the input is in fuzz/artifacts, docs/fuzzing.md says what to do with it\n' "$target" >&2
        return 1
    fi
    printf '%s: %s executions, %s\n' "$target" \
        "$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")" \
        "$(grep -o 'cov: [0-9]* ft: [0-9]*' "$log" | tail -n 1)"
}
# As many at a time as there are processors.
running=0
for target in "${targets[@]}"; do
    if [ "$running" -ge "$(nproc)" ]; then
        wait -n
        running=$((running - 1))
    fi
    fuzz "$target" &
    running=$((running + 1))
done
for ((; running > 0; running--)); do wait -n; done
