//! The table of slaves (`docs/reference/dp-v0.md` 13), group by group.

use super::Tester;
use crate::judge::device::row::{By, Entry, Group};
use crate::judge::requirement::Confidence;

mod addressing;
mod configuration;
mod control;
mod counting;
mod device_file;
mod diagnosis;
mod dpv1;
mod exchange;
mod framing;
mod parameters;
mod profile;
mod rates;
mod requests;
mod several;
mod start_up;
mod timing;
mod watchdog;

/// Every group, in the order of the table.
pub(super) fn groups() -> Vec<Group<Tester>> {
    let groups = [
        start_up::GROUP,
        framing::GROUP,
        requests::GROUP,
        counting::GROUP,
        parameters::GROUP,
        configuration::GROUP,
        diagnosis::GROUP,
        exchange::GROUP,
        control::GROUP,
        addressing::GROUP,
        watchdog::GROUP,
        timing::GROUP,
        several::GROUP,
        device_file::GROUP,
        rates::GROUP,
        profile::GROUP,
    ];
    groups.into_iter().chain(dpv1::groups()).collect()
}

/// A mandatory row of confidence B.
const fn row(
    id: &'static str,
    text: &'static str,
    rule: &'static str,
    needs: &'static [&'static str],
    by: By<Tester>,
) -> Entry<Tester> {
    Entry { id, priority: 1, confidence: Confidence::B, text, rule, needs, by }
}

/// The same row, expected but not mandatory, as sure as this.
const fn softer(entry: Entry<Tester>, priority: u8, confidence: Confidence) -> Entry<Tester> {
    entry.rated(priority, confidence)
}
