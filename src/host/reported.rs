//! What the diagnosis of a station from a GSD reports besides what its slave does: what is raised by hand, what the time line
//! of a line file raises, and modules that are not those of the configuration.

use core::time::Duration;
use std::collections::BTreeMap;

use crate::gsd::{ModuleState, Placed, Raised, Station};

/// What is plugged in a slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum InSlot {
    /// The module of the configuration.
    Expected,
    /// Another one.
    Other,
    /// None.
    Empty,
}

/// What is reported for some time. Times count from the start of the station.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Timed {
    pub(crate) from: Duration,
    /// `None`: to the end.
    pub(crate) until: Option<Duration>,
    pub(crate) raised: Raised,
    /// What is plugged meanwhile, by the number of the slot.
    pub(crate) slots: BTreeMap<u16, InSlot>,
}

/// Everything that is to be reported.
#[derive(Debug, Default)]
pub(super) struct Reported {
    pub(super) by_hand: Raised,
    /// What is plugged by hand.
    pub(super) slots: BTreeMap<u16, InSlot>,
    pub(super) timed: Vec<Timed>,
}

impl Timed {
    fn acts(&self, after: Duration) -> bool {
        self.from <= after && self.until.is_none_or(|until| after < until)
    }
}

impl Reported {
    /// The rows of the time line that act so long after the start.
    fn acting(&self, after: Duration) -> impl Iterator<Item = &Timed> {
        self.timed.iter().filter(move |timed| timed.acts(after))
    }

    /// How long after the start something begins or ends next.
    pub(super) fn next(&self, after: Duration) -> Option<Duration> {
        let times = self.timed.iter().flat_map(|timed| [Some(timed.from), timed.until]);
        times.flatten().filter(|time| *time > after).min()
    }

    /// The slots whose module is not that of the configuration.
    pub(super) fn unlike(
        &self,
        station: &Station,
        layout: &[Placed],
        after: Duration,
    ) -> BTreeMap<u16, ModuleState> {
        let state = |(place, placed): (usize, &Placed)| {
            let number = placed.slot.number;
            let timed = self.acting(after).filter_map(|timed| timed.slots.get(&number)).last();
            let in_slot = self.slots.get(&number).or(timed).copied();
            let is_empty = placed.modules.is_empty()
                || (placed.slot.inputs.is_empty() && placed.slot.outputs.is_empty());
            let state = match in_slot.unwrap_or_else(|| of_modules(station, place, placed)) {
                InSlot::Expected => return None,
                InSlot::Other => ModuleState::Wrong,
                InSlot::Empty if is_empty => return None,
                InSlot::Empty => ModuleState::Missing,
            };
            Some((number, state))
        };
        layout.iter().enumerate().filter_map(state).collect()
    }

    /// Everything as one diagnosis.
    pub(super) fn all(
        &self,
        station: &Station,
        layout: &[Placed],
        after: Duration,
        unlike: &BTreeMap<u16, ModuleState>,
    ) -> Raised {
        let mut all = self.by_hand.clone();
        for timed in self.acting(after) {
            all.join(&timed.raised.clone().within(layout));
        }
        all.identifiers.extend(unlike.keys());
        if station.gsd().has_module_status() {
            for (slot, state) in unlike {
                all.modules.entry(*slot).or_insert(*state);
            }
        }
        all
    }
}

/// What is in a slot of a station whose modules are named.
fn of_modules(station: &Station, place: usize, placed: &Placed) -> InSlot {
    match station.in_slot(place) {
        None => InSlot::Expected,
        Some(None) => InSlot::Empty,
        Some(Some(module)) if placed.modules.contains(&module) => InSlot::Expected,
        Some(Some(_)) => InSlot::Other,
    }
}

impl InSlot {
    /// The names of what can be made of a slot, as `slot2-missing`.
    pub(super) const NAMED: [(&'static str, Self); 2] = [("missing", Self::Empty), ("wrong", Self::Other)];

    /// What is made of which slot.
    pub(super) fn named(name: &str) -> Option<(u16, Self)> {
        let (slot, what) = name.strip_prefix("slot")?.split_once('-')?;
        let (_, what) = Self::NAMED.iter().find(|(known, _)| *known == what)?;
        Some((slot.parse().ok()?, *what))
    }
}
