//! Faults on purpose, to test masters: frames that are lost, late, doubled or damaged.
//!
//! The stations are as they always are and know nothing of it. What a station does wrong by itself is that station's.
//! [`host::fault`](crate::host::fault) says how they are written.

use core::time::Duration;

use super::bus::{Damage, Seat};
use crate::can_bus::can::Frame;
use crate::host::fault::{Kind, List, Listed, Rule};
use crate::time::Instant;

/// What happens to a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FrameFault {
    /// Its sender takes it for sent, and nobody hears it.
    Lose,
    /// It is on the bus so much later; other frames may come first.
    Delay(Duration),
    /// It is on the bus twice.
    Double,
    /// It ends in an error frame, and its sender repeats it: 32 times in a row take the sender off the bus.
    Damage,
    /// Nobody acknowledges it, and its sender repeats it: 16 times in a row make the sender error passive.
    NotAcknowledged,
}

/// The faults of a bus. Of those that strike one frame the first given acts. A frame that is repeated after an error counts
/// again. Faults of nodes are in the list, too, and act in the nodes.
#[derive(Debug, Default)]
pub(crate) struct Faults {
    list: List<Option<Seat>>,
}

/// What a frame comes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Strike {
    None,
    Lose,
    Delay(Duration),
    Double,
    Damage(Damage),
}

impl Faults {
    /// Each fault with what has become of it on the bus.
    pub(crate) fn iter(&self) -> impl Iterator<Item = Listed> + '_ {
        self.list.iter()
    }

    /// Whether there is none.
    pub(super) fn is_empty(&self) -> bool {
        self.list.active.is_empty()
    }

    /// Which may act at `now`.
    pub(super) fn look(&mut self, now: Instant) {
        self.list.look(now, |_| true);
    }

    /// When to look again.
    pub(super) fn next_change(&self) -> Option<Instant> {
        self.list.next_change()
    }

    /// Adds a fault behind the others, for the frames of whoever sends. Returns its number, by which it is removed.
    pub(crate) fn add(&mut self, now: Instant, rule: Rule) -> u32 {
        self.list.add(now, rule, None)
    }

    /// Ends a fault. `None`: there is none of this number.
    pub(crate) fn remove(&mut self, number: u32) -> Option<Rule> {
        self.list.remove(number)
    }

    /// Whose frames each fault is for: `None` for all, else the seat of its node.
    pub(super) fn seat(&mut self, of: impl Fn(&Rule) -> Option<Seat>) {
        for active in &mut self.list.active {
            active.seen = of(&active.rule);
        }
    }

    /// What happens at `now` to the frame of `sender`.
    pub(super) fn strike(&mut self, now: Instant, frame: &Frame, sender: Seat) -> Strike {
        let mut strike = Strike::None;
        for active in &mut self.list.active {
            let Kind::Frame(fault) = active.rule.kind else { continue };
            let concerned = active.rule.whom.id.is_none_or(|id| id == frame.id())
                && active.seen.is_none_or(|from| from == sender)
                && active.chance.is_open(now);
            if concerned && active.strikes() && strike == Strike::None {
                strike = match fault {
                    FrameFault::Lose => Strike::Lose,
                    FrameFault::Delay(delay) => Strike::Delay(delay),
                    FrameFault::Double => Strike::Double,
                    FrameFault::Damage => Strike::Damage(Damage::Bit),
                    FrameFault::NotAcknowledged => Strike::Damage(Damage::NotAcknowledged),
                };
            }
        }
        strike
    }
}
