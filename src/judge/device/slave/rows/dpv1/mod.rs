//! DP-V1 (`docs/reference/dp-v1.md` 11), group by group.

mod alarms;
mod channel;
mod connections;
mod drive;
mod identification;
mod life;
mod parameters;
mod records;

use super::row;
use super::{configuration, softer, watchdog};
use crate::judge::device::row::{Entry, Group};
use crate::judge::device::slave::Tester;
use crate::judge::requirement::Confidence;

/// Every group, in the order of the table.
pub(super) fn groups() -> [Group<Tester>; 8] {
    [
        channel::GROUP,
        records::GROUP,
        life::GROUP,
        parameters::GROUP,
        alarms::GROUP,
        connections::GROUP,
        identification::GROUP,
        drive::GROUP,
    ]
}

/// A mandatory row of one source.
const fn likely(entry: Entry<Tester>) -> Entry<Tester> {
    softer(entry, 1, Confidence::C)
}

/// A row that is expected, of which the sources are not sure.
const fn open(entry: Entry<Tester>) -> Entry<Tester> {
    softer(entry, 2, Confidence::U)
}

/// A row that is expected.
const fn expected(entry: Entry<Tester>) -> Entry<Tester> {
    softer(entry, 2, Confidence::B)
}
