//! The words of refusals that an application makes at run time.
//!
//! An event is copied without an allocator and can carry a number only. The words wait here, so that they are told once,
//! beside the event, and also when the station has gone in the meantime.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use super::BusEvent;
use crate::devices::StationEvent;
use crate::profibus::dp;
use crate::profibus::dp::{CfgFault, PrmFault, Reason};
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
    number: u16,
    words: Arc<str>,
}

impl Refusals {
    /// Keeps the words of a refusal until so many have followed.
    pub(crate) fn keep(&self, address: Address, number: u16, words: String) {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.len() >= KEPT {
            kept.pop_front();
        }
        kept.push_back(Kept { address, number, words: words.into() });
    }

    /// The words that belong behind an event; `None` if it says everything itself.
    pub fn words(&self, event: &BusEvent) -> Option<Arc<str>> {
        let BusEvent::Station { address, event: StationEvent::Dp(event) } = event else { return None };
        let (dp::Event::PrmRejected { fault: PrmFault::UserPrm(refusal), .. }
        | dp::Event::CfgRejected { fault: CfgFault::Refused(refusal), .. }) = event
        else {
            return None;
        };
        let Reason::Numbered(number) = refusal.reason else { return None };
        let kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let ours = |kept: &&Kept| (kept.address, kept.number) == (*address, number);
        kept.iter().rev().find(ours).map(|kept| Arc::clone(&kept.words))
    }
}
