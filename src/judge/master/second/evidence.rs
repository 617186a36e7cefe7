//! What the second master has seen of a row.

use crate::judge::master::findings::Weight;
use crate::judge::master::rows::Row;

/// What was seen of a row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::judge) enum Evidence {
    /// It held.
    Held(Row),
    /// It was broken.
    Broken(Row, Weight, String),
    /// There was an occasion, and it was missed.
    Missed(Row, String),
    /// The master gave none.
    NoOccasion(Row, String),
}
