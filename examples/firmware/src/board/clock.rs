//! Free-running ticks as a clock, and a second timer as alarm.

use core::time::Duration;

use profidrive::time::Instant;

use super::registers::{
    ALARM_CTRL, ALARM_INT, ALARM_RELOAD, ALARM_VALUE, CLOCK_CTRL, CLOCK_RELOAD, CLOCK_VALUE, TIMER_INT,
    TIMER_ON,
};

/// 25 MHz.
pub const NANOS_PER_TICK: u64 = 40;

/// The 32 bit of the timer and how often they have come round: every 171 s. It must be read more often.
pub(super) struct Clock {
    ticks: u64,
}

impl Clock {
    pub(super) fn start() -> Self {
        CLOCK_RELOAD.write(u32::MAX);
        CLOCK_VALUE.write(u32::MAX);
        CLOCK_CTRL.write(TIMER_ON);
        Self { ticks: 0 }
    }

    pub(super) fn now(&mut self) -> Instant {
        let passed = ticks().wrapping_sub(self.ticks as u32);
        self.ticks += u64::from(passed);
        Instant::from_nanos(self.ticks * NANOS_PER_TICK)
    }

    /// When these ticks were read, not long ago.
    pub(super) fn at(&mut self, earlier: u32) -> Instant {
        let now = self.now().as_nanos();
        let ago = (self.ticks as u32).wrapping_sub(earlier);
        Instant::from_nanos(now.saturating_sub(u64::from(ago) * NANOS_PER_TICK))
    }

    /// One interrupt, so late that the time is over then.
    pub(super) fn alarm_in(&self, time: Duration) {
        let ticks = time.as_nanos() as u64 / NANOS_PER_TICK + 1;
        ALARM_CTRL.write(0);
        ALARM_RELOAD.write(u32::try_from(ticks).unwrap_or(u32::MAX));
        ALARM_VALUE.write(u32::try_from(ticks).unwrap_or(u32::MAX));
        ALARM_CTRL.write(TIMER_ON | TIMER_INT);
    }
}

/// The ticks now, modulo 2³².
pub fn ticks() -> u32 {
    !CLOCK_VALUE.read()
}

/// The time is over: it has woken the program, that was all.
pub(super) extern "C" fn alarm() {
    ALARM_CTRL.write(0);
    ALARM_INT.write(1);
}
