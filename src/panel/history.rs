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

/// How many events of each weight keep their place whatever else comes; together they are all.
const SHARES: [usize; 3] = [200, 300, 500];

/// How much it matters that an event is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Weight {
    /// The octets of a line: noise makes very many of them.
    Noise,
    /// What a master can cause with every telegram.
    Traffic,
    /// Faults, and what changes the state of a station.
    State,
}

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
    /// Keeps the event that `make` makes with its number, and returns it. If there is no room, the oldest goes of those that
    /// have more than their share, the lightest first: noise pushes out no refusals, and refusals no faults.
    pub(super) fn keep(&mut self, make: impl FnOnce(u64) -> T, weight: impl Fn(&T) -> Weight) -> T {
        self.told = self.told.saturating_add(1);
        let event = make(self.told);
        self.events.push_back(event.clone());
        if self.events.len() > MOST_EVENTS {
            let mut counts = [0; SHARES.len()];
            for event in &self.events {
                if let Some(count) = counts.get_mut(weight(event) as usize) {
                    *count += 1;
                }
            }
            let has_too_many = |weight: Weight| counts.get(weight as usize) > SHARES.get(weight as usize);
            let lightest = [Weight::Noise, Weight::Traffic, Weight::State]
                .into_iter()
                .find(|weight| has_too_many(*weight));
            let oldest = self.events.iter().position(|event| Some(weight(event)) == lightest);
            self.events.remove(oldest.unwrap_or(0));
        }
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
    fn what_is_light_pushes_out_what_is_light() {
        let mut newest = Newest::<(u64, Weight)>::default();
        let mut keep = |times: usize, weight: Weight| {
            for _ in 0..times {
                newest.keep(|number| (number, weight), |event: &(u64, Weight)| event.1);
            }
            let count = |of: Weight| newest.iter().filter(|event| event.1 == of).count();
            [count(Weight::Noise), count(Weight::Traffic), count(Weight::State)]
        };
        assert_eq!(keep(1, Weight::State), [0, 0, 1]);
        assert_eq!(keep(3000, Weight::Noise), [999, 0, 1]);
        assert_eq!(keep(3000, Weight::Traffic), [200, 799, 1]);
        assert_eq!(keep(3000, Weight::State), [200, 300, 500]);
        assert_eq!(keep(3000, Weight::Noise), [200, 300, 500]);
        assert!(newest.iter().filter(|event| event.1 == Weight::State).all(|event| event.0 > 8501));
    }
}
