//! Tests that have a long version run it with `PROFIDRIVE_LONG=1`.
#![allow(dead_code, reason = "each test file uses its part")]

use proptest::prelude::ProptestConfig;

pub(crate) fn long() -> bool {
    std::env::var_os("PROFIDRIVE_LONG").is_some()
}

/// Each of them in the long version; else the one whose turn it is.
pub(crate) fn one_in_turn<T: Copy, const N: usize>(turn: usize, of: [T; N]) -> Vec<T> {
    if long() { of.to_vec() } else { vec![of[turn % N]] }
}

/// So many cases of a property, and in the long version so many times as many.
pub(crate) fn cases(cases: u32, times: u32) -> ProptestConfig {
    ProptestConfig { cases: if long() { times * cases } else { cases }, ..ProptestConfig::default() }
}
