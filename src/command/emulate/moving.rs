//! Lines of the log about motion: of a machine that moves all the time the first are logged, the others counted.

use core::time::Duration;

use tracing::info;

use crate::time::Instant;

/// So many lines about motion are logged in a [`SPAN`].
const MOST: u32 = 20;
/// How long they are counted together; a machine that says nothing about motion for so long stands.
const SPAN: Duration = Duration::from_secs(10);
/// Of a machine that goes on the count is told this often.
const REPORT: Duration = Duration::from_secs(600);

/// What was logged about motion lately.
#[derive(Debug, Default)]
pub(super) struct Moving {
    /// When the span began, when the last line came, and when the count was told.
    times: Option<Times>,
    lines: u32,
    /// Lines that were not logged.
    unsaid: u64,
}

#[derive(Clone, Copy, Debug)]
struct Times {
    span: Instant,
    last: Instant,
    told: Instant,
}

impl Moving {
    /// Whether a line about motion is logged; one that is not is for `debug`.
    pub(super) fn may_say(&mut self, now: Instant) -> bool {
        self.look(now);
        let times = self.times.get_or_insert(Times { span: now, last: now, told: now });
        times.last = now;
        if now.saturating_since(times.span) >= SPAN {
            times.span = now;
            // A machine that moves on is not new in the next span.
            self.lines = if self.lines > MOST { MOST } else { 0 };
        }
        if now.saturating_since(times.told) >= REPORT {
            times.told = now;
            self.say_count(", and it goes on");
        }
        self.lines = self.lines.saturating_add(1);
        let says = self.lines <= MOST;
        self.unsaid += u64::from(!says);
        says
    }

    /// Something happened: a motion that has ended meanwhile is told.
    pub(super) fn look(&mut self, now: Instant) {
        if self.times.is_some_and(|times| now.saturating_since(times.last) >= SPAN) {
            self.end();
        }
    }

    /// Tells what was not logged.
    pub(super) fn end(&mut self) {
        self.say_count("");
        *self = Self::default();
    }

    fn say_count(&mut self, rest: &str) {
        let unsaid = core::mem::take(&mut self.unsaid);
        if unsaid > 0 {
            info!("{unsaid} more lines about motion{rest}; -v logs each of them");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_a_plant_that_moves_all_the_time_a_few_lines_are_logged() {
        let mut moving = Moving::default();
        // An hour, ten lines a second.
        let logged: Vec<u64> = (0..36_000)
            .map(|tenth| tenth * 100)
            .filter(|at| moving.may_say(Instant::from_millis(*at)))
            .collect();
        assert_eq!(logged.len(), 20);
        assert!(logged.iter().all(|at| *at < 2000));
        assert_eq!(moving.unsaid, 36_000 - 30_000, "those behind the last report");
        // It stood for a minute.
        let again = Instant::from_millis(3_660_000);
        moving.look(again);
        assert!((0..20).all(|_| moving.may_say(again)) && !moving.may_say(again));
    }

    #[test]
    fn of_a_plant_that_moves_now_and_then_every_line_is_logged() {
        let mut moving = Moving::default();
        assert!((0..10_000).all(|second| moving.may_say(Instant::from_millis(second * 1000))));
        assert_eq!(moving.unsaid, 0);
    }
}
