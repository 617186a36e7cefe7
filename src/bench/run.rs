//! Letting time pass, and sending as the test.

use core::time::Duration;

use thiserror::Error;

use super::line::Step;
use super::{Breach, Line, Master, Sender};
use crate::time::{Instant, SYN_BITS};

/// What was waited for did not come.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("not within {limit:?}")]
pub struct TimedOut {
    /// How long was waited, in virtual time.
    pub limit: Duration,
}

/// The master under test works by itself.
impl<M: Master> Line<M> {
    /// Goes to the next point in time at which something happens, and lets it happen. `false`: nothing ever does, and
    /// time stands.
    pub fn step(&mut self) -> bool {
        self.drain_master();
        self.next().is_some_and(|next| self.step_until(next) != Step::Nothing)
    }

    /// Lets `duration` pass.
    pub fn run_for(&mut self, duration: Duration) {
        self.drain_master();
        let end = self.now.saturating_add(duration);
        while self.step_until(end) != Step::Nothing {}
    }

    /// Steps until `condition` holds after a step, at most for `limit`. Says how long it took.
    ///
    /// # Errors
    /// [`TimedOut`]; the time is then `limit` later.
    pub fn run_until(
        &mut self,
        limit: Duration,
        mut condition: impl FnMut(&mut Self) -> bool,
    ) -> Result<Duration, TimedOut> {
        let start = self.now;
        let end = start.saturating_add(limit);
        self.drain_master();
        while self.step_until(end) != Step::Nothing {
            if condition(self) {
                return Ok(self.now.saturating_since(start));
            }
            // The condition may have commanded the master.
            self.drain_master();
        }
        Err(TimedOut { limit })
    }
}

/// The test sends. An error is the first [`Breach`] during the call; time is then as if it had not been one.
impl<M: Master> Line<M> {
    /// Sends `octets` as soon as the rules allow, T_SYN after the last octet; returns when they have been heard, with the
    /// time of their end.
    ///
    /// # Errors
    /// The first [`Breach`].
    pub fn send(&mut self, octets: &[u8]) -> Result<Instant, Breach> {
        let before = self.breach_count;
        self.let_finish();
        let earliest = self.idle_since.saturating_add(self.baud.bit_times(SYN_BITS));
        let end = self.send_from(self.now.max(earliest), octets);
        self.unless_breach(before, end)
    }

    /// Sends `octets` from `at` on, or from now if that is later, whether the rules allow it or not; returns when they
    /// have been heard, with the time of their end.
    ///
    /// # Errors
    /// The first [`Breach`].
    pub fn send_at(&mut self, at: Instant, octets: &[u8]) -> Result<Instant, Breach> {
        let before = self.breach_count;
        let end = self.send_from(at, octets);
        self.unless_breach(before, end)
    }

    /// Lets time pass until somebody has said something, or until `until`: the octets, as they are heard.
    ///
    /// # Errors
    /// The first [`Breach`].
    pub fn listen(&mut self, until: Instant) -> Result<Option<&[u8]>, Breach> {
        let before = self.breach_count;
        let heard = self.hear_until(until);
        self.unless_breach(before, ())?;
        Ok(heard.then_some(self.octets.as_slice()))
    }

    /// Lets time pass.
    ///
    /// # Errors
    /// The first [`Breach`].
    pub fn wait(&mut self, time: Duration) -> Result<(), Breach> {
        let before = self.breach_count;
        self.run_for(time);
        self.unless_breach(before, ())
    }

    /// [`Line::send`], and what comes back within the slot time: `None` if nothing does. What comes back may be
    /// damaged if the line is disturbed.
    ///
    /// # Errors
    /// The first [`Breach`].
    pub fn request(&mut self, octets: &[u8]) -> Result<Option<&[u8]>, Breach> {
        let before = self.breach_count;
        let end = self.send(octets)?;
        // A reply must have begun within the slot time; then it is heard to its end.
        let mut until = end.saturating_add(self.slot_time);
        let mut heard = self.hear_until(until);
        while let (false, Some(speaking)) = (heard, self.speaking) {
            until = speaking.end;
            heard = self.hear_until(until);
        }
        self.unless_breach(before, ())?;
        Ok(heard.then_some(self.octets.as_slice()))
    }

    /// Whether somebody came to an end of what he said before `until`.
    fn hear_until(&mut self, until: Instant) -> bool {
        loop {
            match self.step_until(until) {
                Step::Nothing => return false,
                Step::Something => {}
                Step::Ended => return true,
            }
        }
    }

    /// Begins to send as another master, whoever else sends.
    pub(crate) fn speak(&mut self, octets: &[u8]) {
        self.begin(Sender::Test, None, octets, false);
    }

    /// Whether somebody sends now.
    pub(crate) const fn is_speaking(&self) -> bool {
        self.speaking.is_some()
    }

    fn send_from(&mut self, at: Instant, octets: &[u8]) -> Instant {
        while self.step_until(at) != Step::Nothing {}
        self.begin(Sender::Test, None, octets, false);
        let end = self.speaking.map_or(self.now, |speaking| speaking.end);
        self.let_finish();
        end
    }

    /// Lets whoever sends come to an end.
    fn let_finish(&mut self) {
        while let Some(speaking) = self.speaking {
            self.step_until(speaking.end);
        }
    }

    fn unless_breach<T>(&self, before: usize, value: T) -> Result<T, Breach> {
        self.breach_after(before).map_or(Ok(value), Err)
    }
}
