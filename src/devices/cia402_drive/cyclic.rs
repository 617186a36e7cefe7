//! Positions from cycle to cycle: a straight line from one to the next.

use core::time::Duration;

use super::settings::{Setting, Settings};
use crate::devices::servo::profile::Demand;
use crate::time::Instant;

/// A master that sent no SYNC for so long sends positions without.
const WITHOUT_SYNC: Duration = Duration::from_millis(500);
/// Two positions further from each other are no cycle.
const LONGEST: Duration = Duration::from_millis(500);
/// The cycle until one is known.
const FIRST: Duration = Duration::from_millis(10);
const SHORTEST: Duration = Duration::from_micros(100);

/// The way of this cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Cyclic {
    way: Option<Way>,
    last_sync: Option<Instant>,
    last_point: Option<Instant>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Way {
    begin: Instant,
    cycle: Duration,
    from: f64,
    to: f64,
}

impl Cyclic {
    /// What was sent before does not count.
    pub(super) const fn begin_anew(&mut self) {
        self.way = None;
        self.last_point = None;
    }

    /// Whether a position that is written acts at once: no SYNC comes.
    pub(super) fn is_without_sync(&self, now: Instant) -> bool {
        self.last_sync.is_none_or(|sync| now.saturating_since(sync) > WITHOUT_SYNC)
    }

    pub(super) const fn sync(&mut self, now: Instant) {
        self.last_sync = Some(now);
    }

    /// The next position. A master that is slower than 60C2h says is believed.
    pub(super) fn point(&mut self, now: Instant, demand: Demand, to: f64, settings: &Settings) {
        let since = self.last_point.map(|last| now.saturating_since(last)).filter(|since| *since <= LONGEST);
        let cycle = match (period(settings), since) {
            (Some(period), Some(since)) => period.max(since),
            (Some(period), None) => period,
            (None, since) => since.unwrap_or(FIRST),
        };
        self.last_point = Some(now);
        self.way = Some(Way { begin: now, cycle: cycle.max(SHORTEST), from: demand.position, to });
    }

    /// The demand at `now`; `None` while the master has given nothing.
    pub(super) fn demand(&self, now: Instant) -> Option<Demand> {
        let way = self.way?;
        let cycle = way.cycle.as_secs_f64();
        let part = now.saturating_since(way.begin).as_secs_f64() / cycle;
        Some(if part >= 1.0 {
            Demand { position: way.to, velocity: 0.0 }
        } else {
            let velocity = (way.to - way.from) / cycle;
            Demand { position: way.from + (way.to - way.from) * part, velocity }
        })
    }

    /// Whether the way of this cycle is done.
    pub(super) fn is_done(&self, now: Instant) -> bool {
        self.way.is_none_or(|way| now.saturating_since(way.begin) >= way.cycle)
    }
}

/// 60C2h.
fn period(settings: &Settings) -> Option<Duration> {
    let units = settings.of(Setting::CycleUnits);
    let exponent = settings.of(Setting::CycleExponent).clamp(-9, 0) as f64;
    let seconds = units as f64 * libm::pow(10.0, exponent);
    (units > 0).then(|| Duration::from_secs_f64(seconds.min(10.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_line_in_the_cycle_of_60c2h_or_of_the_master() {
        let mut settings = Settings::new();
        let mut cyclic = Cyclic::default();
        let at = Instant::from_millis;
        assert_eq!(cyclic.demand(at(0)), None);
        cyclic.point(at(0), Demand::default(), 100.0, &settings);
        assert_eq!(cyclic.demand(at(5)), Some(Demand { position: 50.0, velocity: 10_000.0 }));
        assert_eq!(cyclic.demand(at(10)), Some(Demand { position: 100.0, velocity: 0.0 }));
        // 20 ms later: that is its cycle.
        cyclic.point(at(20), Demand { position: 100.0, velocity: 0.0 }, 200.0, &settings);
        assert_eq!(cyclic.demand(at(30)).map(|demand| demand.position), Some(150.0));
        settings.set(Setting::CycleUnits, 4);
        cyclic.begin_anew();
        cyclic.point(at(40), Demand::default(), 8.0, &settings);
        assert_eq!(cyclic.demand(at(42)).map(|demand| demand.position), Some(4.0));
        assert!(!cyclic.is_done(at(43)) && cyclic.is_done(at(44)));
    }

    #[test]
    fn a_written_position_waits_for_sync_where_there_is_one() {
        let mut cyclic = Cyclic::default();
        assert!(cyclic.is_without_sync(Instant::from_millis(1)));
        cyclic.sync(Instant::from_millis(1));
        assert!(!cyclic.is_without_sync(Instant::from_millis(400)));
        assert!(cyclic.is_without_sync(Instant::from_millis(600)));
    }
}
