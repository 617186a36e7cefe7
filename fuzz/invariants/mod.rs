//! What must hold for any input, one file a target. The fuzzer calls `check`, and so does `tests/fuzz_corpus.rs`,
//! which replays the corpora on a stable compiler.
#![allow(dead_code, reason = "each target uses its own file")]

#[cfg(feature = "std")]
pub(crate) mod decode_cli;
pub(crate) mod framer;
pub(crate) mod pkw_ops;
pub(crate) mod slave_ops;
pub(crate) mod telegram;
