//! What is being tried.

use core::time::Duration;

/// What is being tried.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Progress {
    /// The number of the scenario, from 1 on; above [`Progress::of`] those that a soak repeats.
    pub number: usize,
    /// How many different ones there are.
    pub of: usize,
    /// What is tried.
    pub name: String,
    /// How long all that is left takes, about.
    pub left: Duration,
}
