//! What was, for who comes late: the events, curves and telegrams of the last minutes. All of it is bounded.
//!
//! | what | how much | when |
//! | --- | --- | --- |
//! | events | the newest [`MOST_EVENTS`] | always |
//! | curves of each station | five times a second, five minutes: [`mod@samples`] | always |
//! | telegrams | the newest 4 MiB: [`recording`] | while somebody watches telegrams |

mod recording;
mod routes;
mod samples;

use std::collections::VecDeque;

use recording::Recording;
use samples::Samples;

pub(super) use routes::*;
pub(super) use samples::{EVERY, Sampled};

/// Events kept.
const MOST_EVENTS: usize = 1000;

/// What was.
#[derive(Debug, Default)]
pub(super) struct History {
    pub(super) samples: Samples,
    pub(super) recording: Recording,
}

/// The newest events, numbered from 1 on.
#[derive(Debug)]
pub(super) struct Newest<T> {
    told: u64,
    events: VecDeque<T>,
}

impl<T> Default for Newest<T> {
    fn default() -> Self {
        Self { told: 0, events: VecDeque::new() }
    }
}

impl<T: Clone> Newest<T> {
    /// Keeps the event that `make` makes with its number, and returns it.
    pub(super) fn keep(&mut self, make: impl FnOnce(u64) -> T) -> T {
        self.told = self.told.saturating_add(1);
        let event = make(self.told);
        if self.events.len() >= MOST_EVENTS {
            self.events.pop_front();
        }
        self.events.push_back(event.clone());
        event
    }

    /// Those that are kept, oldest first.
    pub(super) fn iter(&self) -> impl Iterator<Item = &T> {
        self.events.iter()
    }
}
