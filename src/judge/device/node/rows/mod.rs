//! The table of nodes, group by group: `docs/reference/canopen-link.md` 14 (K, O, Y, E, R) and `docs/reference/eds.md` 6 (X,
//! with the numbers of its E rows).

use super::Tester;
use crate::judge::device::row::{By, Entry, Group};
use crate::judge::requirement::Confidence;

mod counter;
mod drive;
mod error_control;
mod identifiers;
mod load;
mod lss;
mod mapping;
mod nmt;
mod objects;
mod process_data;
mod received;
mod sdo;
mod segments;
mod storage;
mod troubles;

/// Every group, in the order of the table.
pub(super) fn groups() -> Vec<Group<Tester>> {
    let before = [
        nmt::GROUP,
        sdo::GROUP,
        segments::GROUP,
        objects::GROUP,
        error_control::GROUP,
        troubles::GROUP,
        process_data::GROUP,
        identifiers::GROUP,
        counter::GROUP,
        received::GROUP,
        mapping::GROUP,
        storage::GROUP,
        lss::GROUP,
    ];
    before.into_iter().chain(drive::GROUPS).chain([load::GROUP]).collect()
}

/// A mandatory row of confidence A.
const fn row(
    id: &'static str,
    text: &'static str,
    rule: &'static str,
    needs: &'static [&'static str],
    by: By<Tester>,
) -> Entry<Tester> {
    Entry { id, priority: 1, confidence: Confidence::A, text, rule, needs, by }
}

/// The same row, as sure as this.
const fn sure(entry: Entry<Tester>, confidence: Confidence) -> Entry<Tester> {
    let priority = entry.priority;
    entry.rated(priority, confidence)
}
