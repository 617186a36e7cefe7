//! The words of refusals that an application makes at run time.
//!
//! An event is copied without an allocator and can carry a number only. The words wait here, so that they are told once,
//! beside the event, and also when the station has gone in the meantime.

use core::fmt;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use super::{BusEvent, ByHand};
use crate::devices::StationEvent;
use crate::profibus::dp;
use crate::profibus::dp::Application;
use crate::profibus::fdl::Address;

/// Words kept: an event is told soon after it came.
const KEPT: usize = 256;

/// The words of the last refusals of all stations of a bus. A clone is the same store.
#[derive(Clone, Debug, Default)]
pub struct Refusals(Arc<Mutex<VecDeque<Kept>>>);

/// A refusal that waits to be told.
#[derive(Clone, Debug)]
struct Kept {
    address: Address,
    /// Of a raised diagnosis, and its number among those.
    raised: bool,
    number: u16,
    words: Arc<str>,
}

impl Refusals {
    /// Keeps the words of what the application of a station refuses with an event, until so many have followed.
    pub(super) fn learn(&self, address: Address, event: &dp::Event, application: &impl Application) {
        let Some(number) = event.refused_number() else { return };
        let words = Words(application, number).to_string().into();
        self.keep(Kept { address, raised: false, number, words });
    }

    /// Keeps the texts of a raised diagnosis.
    pub(super) fn raised(&self, address: Address, number: u16, words: &str) {
        self.keep(Kept { address, raised: true, number, words: words.into() });
    }

    fn keep(&self, one: Kept) {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.len() >= KEPT {
            kept.pop_front();
        }
        kept.push_back(one);
    }

    /// The words that belong behind an event; `None` if it says everything itself.
    pub fn words(&self, event: &BusEvent) -> Option<Arc<str>> {
        let (address, raised, number) =
            if let BusEvent::ByHand { address, what: ByHand::Raised { number } } = event {
                (*address, true, *number)
            } else if let BusEvent::Station { address, event: StationEvent::Dp(event) } = event {
                (*address, false, event.refused_number()?)
            } else {
                return None;
            };
        let kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let ours = |kept: &&Kept| (kept.address, kept.raised, kept.number) == (address, raised, number);
        kept.iter().rev().find(ours).map(|kept| Arc::clone(&kept.words))
    }
}

/// The words of a refusal.
struct Words<'a, A>(&'a A, u16);

impl<A: Application> fmt::Display for Words<'_, A> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.words(self.1, f)
    }
}
