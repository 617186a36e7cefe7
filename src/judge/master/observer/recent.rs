//! The sendings that can still be shown.

use std::collections::VecDeque;

use crate::judge::moment::{Moment, Side};
use crate::profibus::fdl::telegram::{Decoded, decode};
use crate::profibus::fdl::{Address, Telegram};

/// So many are kept.
const KEPT: usize = 512;
/// So many of them show one breach.
const SHOWN: usize = 12;

/// The newest sendings of everybody, numbered from 1 on.
#[derive(Debug, Default)]
pub(super) struct Recent {
    moments: VecDeque<Moment>,
    newest: u64,
}

impl Recent {
    /// Keeps one, and numbers it.
    pub(super) fn keep(&mut self, moment: Moment) -> u64 {
        if self.moments.len() == KEPT {
            self.moments.pop_front();
        }
        self.moments.push_back(moment);
        self.newest += 1;
        self.newest
    }

    /// The number of the newest.
    pub(super) const fn newest(&self) -> u64 {
        self.newest
    }

    pub(super) fn last(&self) -> Option<&Moment> {
        self.moments.back()
    }

    /// The newest first.
    pub(super) fn backwards(&self) -> impl DoubleEndedIterator<Item = &Moment> + ExactSizeIterator {
        self.moments.iter().rev()
    }

    /// Those from one number on, those about `station` if there are many.
    pub(super) fn since(&self, number: u64, station: Option<Address>) -> Vec<Moment> {
        let count = usize::try_from(self.newest.saturating_sub(number)).unwrap_or(KEPT) + 1;
        let newest = self.moments.iter().skip(self.moments.len().saturating_sub(count));
        let concerns = |moment: &&Moment| {
            let Some(station) = station else { return true };
            match (moment.side, decode(&moment.octets)) {
                (Side::Other(_), _) => true,
                (Side::Station(from), _) => from == Some(station) || from.is_none(),
                (Side::Master, Decoded::Telegram { telegram: Telegram::Data(data), .. }) => {
                    data.da == station || data.da.is_broadcast()
                }
                (Side::Master, Decoded::Telegram { .. } | Decoded::Incomplete | Decoded::Invalid { .. }) => {
                    false
                }
            }
        };
        let all: Vec<Moment> = newest.filter(concerns).cloned().collect();
        if all.len() <= SHOWN {
            return all;
        }
        let half = SHOWN / 2;
        let (front, back) = (all.iter().take(half), all.iter().skip(all.len() - half));
        front.chain(back).cloned().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::time::Instant;

    #[test]
    fn only_the_newest_sendings_are_kept() {
        let mut recent = Recent::default();
        for at in 0..2000 {
            recent.keep(Moment::new(Instant::from_nanos(at), Side::Master, &[0xDC, 2, 2]));
        }
        assert_eq!((recent.moments.len(), recent.newest()), (KEPT, 2000));
        assert_eq!(recent.since(1, None).len(), SHOWN);
    }
}
