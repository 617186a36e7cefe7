//! Test: random walks of wrong masters. A request, word or frame that is not acted upon, is answered with less than was asked
//! for, or makes the drive do nothing, leaves a word where a person sees it (an event or hint above detail) or is in the list
//! of silences of docs/what-it-says.md. And where a drive could move and does not, `why` names the reason; who follows the
//! advice makes it move. For more walks set `PROFIDRIVE_LONG`.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::cast_possible_truncation,
    clippy::std_instead_of_core,
    clippy::wildcard_enum_match_arm,
    reason = "a test may panic, and has std"
)]

use std::collections::BTreeMap;

mod advice;
pub(crate) mod deeds;
mod exam;
pub(crate) mod flood;
mod habits;
mod nodes;
mod slaves;
mod walk;
mod words;

/// What was told on this walk, by what for.
#[derive(Debug, Default)]
struct Told(BTreeMap<String, bool>);

impl Told {
    /// Whether a step may stay without a word: it was told before for the same. `news` are the words of the step.
    fn covers(&mut self, what: &str, news: &[String]) -> bool {
        let told = self.0.entry(what.to_owned()).or_default();
        *told |= !news.is_empty();
        *told
    }
}

/// How many walks of each kind.
fn walks() -> u64 {
    if std::env::var_os("PROFIDRIVE_LONG").is_some() { 2000 } else { 40 }
}

/// Fails with every silence that was found, each once with an example of it.
fn expect_none(silences: &BTreeMap<String, String>) {
    let text: Vec<_> = silences.iter().map(|(what, example)| format!("{what}\n{example}")).collect();
    assert!(silences.is_empty(), "{} silences:\n{}", silences.len(), text.join("\n\n"));
}
