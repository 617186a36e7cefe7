//! `judge --soak`: rows that held are tried again in random order, for hours.

use core::time::Duration;

/// How long rows are tried again when each was tried once, and which: the same number, the same ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Soak {
    /// So long.
    pub lasts: Duration,
    /// Chooses the rows.
    pub seed: u64,
}
