//! What was, for who comes late: the events, curves and telegrams of the last minutes. All of it is bounded.
//!
//! | what | how much | when |
//! | --- | --- | --- |
//! | events | the newest [`MOST_EVENTS`] | always |
//! | samples of each drive | five times a second, five minutes: [`mod@samples`] | always |
//! | telegrams | the newest 4 MiB: [`recording`] | while somebody watches telegrams |

mod recording;
mod routes;
mod samples;

use std::collections::VecDeque;
use std::prelude::v1::*;

use super::stream::NewsEvent;
use crate::time::Instant;
use recording::Recording;
use samples::Samples;

pub(super) use routes::*;
pub(super) use samples::{EVERY, Sampled};

/// Events kept.
pub(super) const MOST_EVENTS: usize = 1000;

/// What was.
#[derive(Debug, Default)]
pub(super) struct History {
    told: u64,
    events: VecDeque<(Instant, NewsEvent)>,
    pub(super) samples: Samples,
    pub(super) recording: Recording,
}

impl History {
    /// The number of the next event.
    pub(super) const fn next_number(&mut self) -> u64 {
        self.told = self.told.saturating_add(1);
        self.told
    }

    pub(super) fn keep(&mut self, at: Instant, news: NewsEvent) {
        if self.events.len() >= MOST_EVENTS {
            self.events.pop_front();
        }
        self.events.push_back((at, news));
    }

    /// The events that are kept, oldest first.
    pub(super) fn events(&self) -> impl Iterator<Item = &(Instant, NewsEvent)> {
        self.events.iter()
    }
}
