//! Alarms on the time line of a station.

use core::time::Duration;

use super::GsdStation;
use crate::profibus::dpv1::{AlarmType, Specifier};
use crate::time::Instant;

/// An alarm that comes by itself. Times count from the start of the station.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct TimedAlarm {
    pub(crate) at: Duration,
    /// Again after each such time; `None`: once.
    pub(crate) every: Option<Duration>,
    pub(crate) kind: AlarmType,
    pub(crate) slot: u8,
    pub(crate) specifier: Specifier,
    pub(crate) additional_ack: bool,
    pub(crate) data: Vec<u8>,
}

/// Those that are still to come, each with its time.
#[derive(Debug, Default)]
pub(super) struct TimedAlarms(Vec<(Instant, TimedAlarm)>);

impl TimedAlarms {
    /// When the next one comes.
    pub(super) fn next(&self) -> Option<Instant> {
        self.0.iter().map(|(at, _)| *at).min()
    }

    /// The next one that is due. One that comes again does so behind `now`, however late it is.
    fn take(&mut self, now: Instant) -> Option<TimedAlarm> {
        let place = self.0.iter().position(|(at, _)| *at <= now)?;
        let (at, alarm) = self.0.get_mut(place)?;
        let Some(every) = alarm.every else { return Some(self.0.remove(place).1) };
        let late = now.saturating_since(*at).as_nanos() / every.as_nanos().max(1);
        let steps = u32::try_from(late).unwrap_or(u32::MAX).saturating_add(1);
        *at = at.saturating_add(every.saturating_mul(steps));
        Some(alarm.clone())
    }
}

impl GsdStation {
    /// The same station with alarms that come by themselves, from `now` on.
    #[must_use]
    pub(crate) fn with_timed_alarms(mut self, now: Instant, alarms: Vec<TimedAlarm>) -> Self {
        let begin = |alarm: TimedAlarm| (now.saturating_add(alarm.at), alarm);
        self.timed_alarms = TimedAlarms(alarms.into_iter().map(begin).collect());
        self
    }

    /// Raises those that are due. What may not come is told and forgotten.
    pub(super) fn raise_timed(&mut self, now: Instant) {
        while let Some(alarm) = self.timed_alarms.take(now) {
            let TimedAlarm { kind, slot, specifier, additional_ack, ref data, .. } = alarm;
            let (raised, address) =
                (self.raise_alarm(kind, (slot, specifier, additional_ack), data), self.station.address());
            match raised {
                Ok(alarm) => tracing::info!("station {address}: by the time line raised the {alarm}"),
                Err(error) => {
                    tracing::warn!("station {address}: the {kind} of the time line does not come: {error}");
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn alarms_come_once_or_again_and_none_is_made_up_for() {
        let alarm = |at, every: Option<u64>| TimedAlarm {
            at: Duration::from_secs(at),
            every: every.map(Duration::from_secs),
            kind: AlarmType::Process,
            slot: 1,
            specifier: Specifier::None,
            additional_ack: false,
            data: Vec::new(),
        };
        let second = |second: u64| Instant::from_millis(1000 * second);
        let mut timed = TimedAlarms(vec![(second(5), alarm(5, None)), (second(2), alarm(2, Some(4)))]);
        assert_eq!((timed.next(), timed.take(second(1))), (Some(second(2)), None));
        assert_eq!(timed.take(second(2)).map(|alarm| alarm.at.as_secs()), Some(2));
        assert_eq!((timed.take(second(4)), timed.next()), (None, Some(second(5))));
        assert_eq!(timed.take(second(5)).map(|alarm| alarm.at.as_secs()), Some(5));
        // Of 6, 10 and 14 seconds one is told.
        assert!(timed.take(second(15)).is_some() && timed.take(second(15)).is_none());
        assert_eq!(timed.next(), Some(second(18)));
    }
}
