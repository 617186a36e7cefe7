#!/bin/bash -eu
# Builds every target with the sanitizer that ClusterFuzzLite asks for, and packs its corpus beside it.
cd "$SRC/profidrive"
cargo fuzz build -O --debug-assertions
for file in fuzz/fuzz_targets/*.rs; do
    target=$(basename "$file" .rs)
    cp "fuzz/target/x86_64-unknown-linux-gnu/release/$target" "$OUT/"
    zip -q -j "$OUT/${target}_seed_corpus.zip" "fuzz/corpus/$target"/*
done
