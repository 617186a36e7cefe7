//! The telegrams that somebody watched.

use std::collections::VecDeque;

use crate::host::link::tap::{Batch, Direction};
use crate::time::Instant;

/// Octets of memory at most.
const MOST_OCTETS: usize = 4 << 20;

/// What one telegram takes besides its octets.
const EACH: usize = 64;

/// The newest telegrams that somebody watched.
#[derive(Debug, Default)]
pub(in crate::panel) struct Recording {
    telegrams: VecDeque<(Instant, Direction, Box<[u8]>)>,
    octets: usize,
}

impl Recording {
    pub(in crate::panel) fn keep(&mut self, at: Instant, direction: Direction, octets: &[u8]) {
        self.octets += EACH + octets.len();
        self.telegrams.push_back((at, direction, octets.into()));
        while self.octets > MOST_OCTETS {
            let Some((_, _, oldest)) = self.telegrams.pop_front() else { break };
            self.octets = self.octets.saturating_sub(EACH + oldest.len());
        }
    }

    /// All of them.
    pub(in crate::panel) fn batch(&self) -> Batch {
        let mut batch = Batch::default();
        for (at, direction, octets) in &self.telegrams {
            batch.push(*at, *direction, octets);
        }
        batch
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_are_kept_in_bounded_memory() {
        let mut recording = Recording::default();
        for number in 0..40_000_u32 {
            recording.keep(Instant::from_millis(number.into()), Direction::Sent, &[0x55; 100]);
            assert!(recording.octets <= MOST_OCTETS);
        }
        assert_eq!(recording.telegrams.len(), MOST_OCTETS / 164);
        assert_eq!(recording.telegrams.back().map(|(at, ..)| *at), Some(Instant::from_millis(39_999)));
    }
}
