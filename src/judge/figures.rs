//! The traffic of a judgement in figures: how long the cycle takes and how much that differs, how often a request is repeated,
//! how often a station is lost.

use core::time::Duration;

use crate::time::Instant;

/// So many parts of the time are told apart at most.
const MOST_PARTS: usize = 240;
/// A part is at least so long. When there are too many, two become one.
const LEAST_PART: Duration = Duration::from_millis(100);

/// How long something takes, over many times.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Spread {
    count: u64,
    shortest: Duration,
    longest: Duration,
    /// Nanoseconds.
    sum: u128,
    /// Their squares.
    squares: u128,
}

impl Spread {
    fn add(&mut self, time: Duration) {
        let sum = time.as_nanos();
        let squares = sum.saturating_mul(sum);
        self.join(&Self { count: 1, shortest: time, longest: time, sum, squares });
    }

    fn join(&mut self, other: &Self) {
        if other.count == 0 {
            return;
        }
        self.shortest = if self.count == 0 { other.shortest } else { self.shortest.min(other.shortest) };
        self.longest = self.longest.max(other.longest);
        self.count += other.count;
        self.sum = self.sum.saturating_add(other.sum);
        self.squares = self.squares.saturating_add(other.squares);
    }

    /// How often it was measured.
    pub const fn count(&self) -> u64 {
        self.count
    }

    /// The shortest time; zero if nothing was measured, as all times here.
    pub const fn shortest(&self) -> Duration {
        self.shortest
    }

    /// The longest time.
    pub const fn longest(&self) -> Duration {
        self.longest
    }

    /// The mean time.
    pub fn mean(&self) -> Duration {
        nanos(self.sum / u128::from(self.count.max(1)))
    }

    /// The standard deviation.
    pub fn deviation(&self) -> Duration {
        let count = u128::from(self.count.max(1));
        // In units of 1/count, so that nothing is rounded before the root.
        let variance = self.squares.saturating_mul(count).saturating_sub(self.sum.saturating_mul(self.sum));
        nanos(variance.isqrt() / count)
    }
}

fn nanos(nanos: u128) -> Duration {
    Duration::from_nanos(u64::try_from(nanos).unwrap_or(u64::MAX))
}

/// What there was in some time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Part {
    pub(super) cycle: Spread,
    pub(super) retries: u64,
    pub(super) losses: u64,
}

impl Part {
    fn join(&mut self, other: &Self) {
        self.cycle.join(&other.cycle);
        self.retries += other.retries;
        self.losses += other.losses;
    }
}

/// The traffic in figures.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Figures {
    begin: Option<Instant>,
    /// How long a part is.
    length: Duration,
    parts: Vec<Part>,
}

impl Default for Figures {
    fn default() -> Self {
        Self { begin: None, length: LEAST_PART, parts: Vec::new() }
    }
}

impl Figures {
    /// Times from one Data_Exchange to the next with the same station, where every station answered between them.
    pub fn cycle_time(&self) -> Spread {
        self.whole().cycle
    }

    /// Requests that were repeated.
    pub fn retries(&self) -> u64 {
        self.whole().retries
    }

    /// How often a station was given up because it did not answer.
    pub fn losses(&self) -> u64 {
        self.whole().losses
    }

    fn whole(&self) -> Part {
        let mut whole = Part::default();
        self.parts.iter().for_each(|part| whole.join(part));
        whole
    }

    /// Each part of the time, with its beginning.
    pub(super) fn parts(&self) -> impl Iterator<Item = (Duration, &Part)> {
        (0_u32..).zip(&self.parts).map(|(number, part)| (self.length * number, part))
    }

    /// How long a part is.
    pub(super) const fn part_length(&self) -> Duration {
        self.length
    }

    pub(super) fn took(&mut self, now: Instant, time: Duration) {
        self.part(now, |part| part.cycle.add(time));
    }

    pub(super) fn repeated(&mut self, now: Instant) {
        self.part(now, |part| part.retries += 1);
    }

    pub(super) fn lost(&mut self, now: Instant) {
        self.part(now, |part| part.losses += 1);
    }

    fn part(&mut self, now: Instant, change: impl FnOnce(&mut Part)) {
        let passed = now.saturating_since(*self.begin.get_or_insert(now));
        let mut number = self.number(passed);
        while number >= MOST_PARTS {
            self.halve();
            number = self.number(passed);
        }
        if self.parts.len() <= number {
            self.parts.resize(number + 1, Part::default());
        }
        if let Some(part) = self.parts.get_mut(number) {
            change(part);
        }
    }

    fn number(&self, passed: Duration) -> usize {
        usize::try_from(passed.as_nanos() / self.length.as_nanos().max(1)).unwrap_or(usize::MAX)
    }

    fn halve(&mut self) {
        self.length *= 2;
        let joined = self.parts.chunks(2).map(|two| {
            let mut part = Part::default();
            two.iter().for_each(|one| part.join(one));
            part
        });
        self.parts = joined.collect();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_spread_is_that_of_the_times() {
        let mut spread = Spread::default();
        for millis in [2, 4, 4, 4, 5, 5, 7, 9] {
            spread.add(Duration::from_millis(millis));
        }
        assert_eq!((spread.count(), spread.mean(), spread.deviation()), (8, MS * 5, MS * 2));
        assert_eq!((spread.shortest(), spread.longest()), (MS * 2, MS * 9));
        assert_eq!(
            (Spread::default().mean(), Spread::default().deviation()),
            (Duration::ZERO, Duration::ZERO)
        );
    }

    const MS: Duration = Duration::from_millis(1);

    #[test]
    fn a_long_time_is_told_in_longer_parts() {
        let mut figures = Figures::default();
        for second in 0..36_000 {
            let now = Instant::ZERO + Duration::from_secs(second);
            figures.took(now, MS * if second == 7 { 1 } else { 3 });
            figures.repeated(now);
        }
        figures.lost(Instant::ZERO + Duration::from_secs(35_999));
        let parts: Vec<_> = figures.parts().collect();
        assert!((MOST_PARTS / 2..=MOST_PARTS).contains(&parts.len()), "{}", parts.len());
        assert_eq!((figures.cycle_time().count(), figures.retries(), figures.losses()), (36_000, 36_000, 1));
        assert_eq!((figures.cycle_time().shortest(), figures.cycle_time().longest()), (MS, MS * 3));
        assert_eq!(parts.last().map(|(_, part)| part.losses), Some(1));
        assert_eq!(parts.first().map(|(_, part)| part.cycle.shortest()), Some(MS));
    }
}
