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
    /// Keeps the event that `make` makes with its number, and returns it. If there is no room, the oldest that can be spared
    /// goes, so that noise pushes out noise.
    pub(super) fn keep(&mut self, make: impl FnOnce(u64) -> T, is_spare: impl Fn(&T) -> bool) -> T {
        self.told = self.told.saturating_add(1);
        let event = make(self.told);
        if self.events.len() >= MOST_EVENTS {
            let oldest = self.events.iter().position(is_spare).unwrap_or(0);
            self.events.remove(oldest);
        }
        self.events.push_back(event.clone());
        event
    }

    /// Those that are kept, oldest first.
    pub(super) fn iter(&self) -> impl Iterator<Item = &T> {
        self.events.iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_pushes_out_noise_only() {
        let mut newest = Newest::<(u64, bool)>::default();
        let is_noise = |event: &(u64, bool)| event.1;
        newest.keep(|number| (number, false), is_noise);
        for _ in 0..3 * MOST_EVENTS {
            newest.keep(|number| (number, true), is_noise);
        }
        assert_eq!((newest.iter().count(), newest.iter().next()), (MOST_EVENTS, Some(&(1, false))));
        for _ in 0..MOST_EVENTS {
            newest.keep(|number| (number, false), is_noise);
        }
        assert!(newest.iter().all(|event| !event.1) && newest.iter().count() == MOST_EVENTS);
        assert_eq!(newest.iter().next().map(|event| event.0), Some(3 * MOST_EVENTS as u64 + 2));
    }
}
