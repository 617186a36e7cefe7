//! Faults on purpose, to test masters: frames that are lost, late, doubled or damaged.
//!
//! The stations are as they always are and know nothing of it. What a station does wrong by itself is that station's.
//! Everything is deterministic: the same frames in the same order are struck in the same way.

use core::time::Duration;
use std::vec::Vec;

use super::bus::{Damage, Seat};
use crate::can_bus::can::{Frame, Id};
use crate::chance::Chance;

/// What happens to a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Kind {
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

/// One fault and when it is injected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fault {
    /// What happens.
    pub kind: Kind,
    /// From which frame on, counted from 1. A frame that is repeated after an error counts again.
    pub at: u32,
    /// How often at most; `None`: without limit.
    pub count: Option<u32>,
    /// With which probability at each frame, above 0 and at most 1.
    pub rate: f64,
    /// What chance begins with.
    pub seed: u64,
    /// Only frames with this identifier; `None`: any.
    pub id: Option<Id>,
    /// Only frames of this station; `None`: of any.
    pub from: Option<Seat>,
}

impl Fault {
    /// This fault at every frame.
    pub const fn always(kind: Kind) -> Self {
        Self { kind, at: 1, count: None, rate: 1.0, seed: 1, id: None, from: None }
    }

    /// This fault at one frame, counted from 1.
    pub const fn once(kind: Kind, at: u32) -> Self {
        Self { at, count: Some(1), ..Self::always(kind) }
    }

    /// This fault at frames with this identifier only.
    #[must_use]
    pub const fn of(self, id: Id) -> Self {
        Self { id: Some(id), ..self }
    }
}

/// The faults of a bus. Of those that strike one frame the first given acts.
#[derive(Debug, Default)]
pub struct Faults {
    active: Vec<Active>,
    /// The number of the newest.
    last: u32,
}

#[derive(Debug)]
struct Active {
    number: u32,
    fault: Fault,
    chance: Chance,
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
    /// Each fault with its number and how often it was injected.
    pub fn iter(&self) -> impl Iterator<Item = (u32, Fault, u32)> + '_ {
        self.active.iter().map(|active| (active.number, active.fault, active.chance.struck()))
    }

    /// Adds a fault behind the others. Returns its number, by which it is removed.
    pub fn add(&mut self, fault: Fault) -> u32 {
        self.last = self.last.saturating_add(1);
        self.active.push(Active { number: self.last, fault, chance: Chance::new(fault.seed) });
        self.last
    }

    /// Ends a fault. `None`: there is none of this number.
    pub fn remove(&mut self, number: u32) -> Option<Fault> {
        let place = self.active.iter().position(|active| active.number == number)?;
        Some(self.active.remove(place).fault)
    }

    /// The fault of that number is for the frames of this station now.
    pub(super) fn is_of(&mut self, number: u32, seat: Seat) {
        if let Some(active) = self.active.iter_mut().find(|active| active.number == number) {
            active.fault.from = Some(seat);
        }
    }

    /// Ends every fault.
    pub fn clear(&mut self) {
        self.active.clear();
    }

    /// What happens to the frame of `sender` that begins now.
    pub(super) fn strike(&mut self, frame: &Frame, sender: Seat) -> Strike {
        let mut strike = Strike::None;
        for Active { fault, chance, .. } in &mut self.active {
            let concerned =
                fault.id.is_none_or(|id| id == frame.id()) && fault.from.is_none_or(|from| from == sender);
            if concerned && chance.injected(fault.at, fault.count, fault.rate) && strike == Strike::None {
                strike = match fault.kind {
                    Kind::Lose => Strike::Lose,
                    Kind::Delay(delay) => Strike::Delay(delay),
                    Kind::Double => Strike::Double,
                    Kind::Damage => Strike::Damage(Damage::Bit),
                    Kind::NotAcknowledged => Strike::Damage(Damage::NotAcknowledged),
                };
            }
        }
        strike
    }
}
