//! Telegrams in words, and assertions that print them.

use core::fmt::{self, Display};
use core::time::Duration;

use super::{Damage, Line, Master, Passed};
use crate::explain::{Context, hex};

/// So many telegrams an assertion prints.
const SHOWN: usize = 16;

/// The last telegrams in words, one a line: time, sender, addresses and meaning, octets.
#[derive(Debug)]
pub struct Story<'a> {
    passed: &'a super::history::History,
    last: usize,
}

impl Display for Story<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut context = Context::default();
        let first = self.passed.iter().len().saturating_sub(self.last);
        for (place, passed) in self.passed.iter().enumerate() {
            // The context knows what is asked only if it has seen it.
            let Passed { at, sender, octets, damage, breach, .. } = passed;
            let words = match damage {
                Damage::Collision => None,
                Damage::None | Damage::Parity(_) => Some(context.telegram(octets).line()),
            };
            if place < first {
                continue;
            }
            let words = words.as_deref().unwrap_or("collision: no station can read it");
            write!(f, "{at} {sender:<7} {words}  [{}]", hex(octets))?;
            if let Damage::Parity(octet) = damage {
                write!(f, "  wrong parity in octet {octet}")?;
            }
            if let Some(breach) = breach {
                write!(f, "  <== {breach}")?;
            }
            writeln!(f)?;
        }
        Ok(())
    }
}

impl<M: Master> Line<M> {
    /// The last telegrams in words, at most as many as are [kept](Line::keep).
    pub const fn story(&self, last: usize) -> Story<'_> {
        Story { passed: &self.history, last }
    }

    /// [`Line::run_until`] that must succeed: returns how long it took.
    ///
    /// # Panics
    /// `condition` did not hold within `limit`: with `what`, and the last telegrams in words.
    #[track_caller]
    pub fn must(
        &mut self,
        limit: Duration,
        what: impl Display,
        condition: impl FnMut(&mut Self) -> bool,
    ) -> Duration {
        match self.run_until(limit, condition) {
            Ok(took) => took,
            Err(timed_out) => panic!("{what}: {timed_out}; the last telegrams:\n{}", self.story(SHOWN)),
        }
    }

    /// [`Line::run_for`] in which no telegram may pass for which `wrong` holds.
    ///
    /// # Panics
    /// One passed: with `what`, and the telegrams before it in words.
    #[track_caller]
    pub fn never(&mut self, time: Duration, what: impl Display, mut wrong: impl FnMut(&Passed) -> bool) {
        while self.poll_telegram().is_some() {}
        let mut found = false;
        // In vain is what is wanted.
        let _ = self.run_until(time, |line| {
            found = core::iter::from_fn(|| line.poll_telegram()).any(|passed| wrong(&passed));
            found
        });
        assert!(!found, "{what}: the last telegrams:\n{}", self.story(SHOWN));
    }

    /// # Panics
    /// `condition` is false: with `what`, and the last telegrams in words.
    #[track_caller]
    pub fn check(&self, condition: bool, what: impl Display) {
        assert!(condition, "{what}; the last telegrams:\n{}", self.story(SHOWN));
    }

    /// # Panics
    /// Somebody has broken a rule of the bus: with the first [`Breach`](super::Breach), and the telegrams kept that led to
    /// the newest.
    #[track_caller]
    pub fn assert_no_breach(&self) {
        if let Some(breach) = self.breaches().next() {
            panic!("{breach}; the last telegrams:\n{}", self.story(SHOWN));
        }
    }
}
