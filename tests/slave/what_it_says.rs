//! Ways to fail at a drive in virtual time, and the words that appear: sections of `docs/what-it-says.md`.

use crate::sentences::Row;

#[cfg(feature = "std")]
mod bus_hints;
mod control_word;
mod faults;
mod hints;
mod node;
mod parameters;
mod start_up;
mod why;

fn row<'a>(id: &'a str, done: &'a str, act: impl FnOnce() -> Vec<String> + 'a) -> Row<'a> {
    (id, done, Box::new(act))
}
