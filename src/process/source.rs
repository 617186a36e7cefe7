//! What an input follows over time.

use core::time::Duration;

use thiserror::Error;

use super::{Point, Table};
use crate::profibus::fdl::Address;

/// How often an input that moves all the time is computed.
const TICK: Duration = Duration::from_millis(10);

/// What an input follows. Times count from the first call.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    /// Always the same value.
    Constant(f64),
    /// An output of the same slave.
    Mirror(Point),
    /// From `from` on by `step` each time; behind `to` it begins anew.
    Count {
        /// The first value.
        from: f64,
        /// The last value.
        to: f64,
        /// Added each time; negative to count down.
        step: f64,
        /// Between two values.
        every: Duration,
    },
    /// Evenly from one value to another.
    Ramp {
        /// The first value.
        from: f64,
        /// The last value.
        to: f64,
        /// How long it takes.
        time: Duration,
        /// What follows.
        then: AtEnd,
    },
    /// `mean + amplitude * sin(2 pi (time + phase) / period)`.
    Sine {
        /// The value it swings around.
        mean: f64,
        /// How far it swings.
        amplitude: f64,
        /// From one crest to the next.
        period: Duration,
        /// How far into a period it begins.
        phase: Duration,
    },
    /// The rows of a table.
    Table {
        /// Times and values.
        rows: Table,
        /// Starts anew when so much time is over; `None`: the last row holds.
        repeat: Option<Duration>,
    },
    /// An output of another slave, some time later.
    Follow {
        /// The other slave.
        station: Address,
        /// Its output.
        of: Point,
        /// How much later, at most as many changes as are kept in between.
        delay: Duration,
    },
}

/// What a ramp does at its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AtEnd {
    /// Stays.
    Hold,
    /// Begins anew.
    Repeat,
    /// Goes back the same way, and so on.
    Return,
}

/// Why nothing can be followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum SourceError {
    /// Infinity or no number.
    #[error("{0} is no finite number")]
    Number(&'static str),
    /// A time of 0.
    #[error("{0} is 0; expected more")]
    Time(&'static str),
    /// A count that never gets there.
    #[error("a step of 0 or away from 'to' counts nothing")]
    Step,
}

/// What a source says: a value, and when it may change next, both at a time from the first call on.
pub(super) struct Said {
    pub(super) value: f64,
    pub(super) next: Option<Duration>,
}

impl Source {
    /// Whether it can be followed.
    ///
    /// # Errors
    /// [`SourceError`].
    pub(crate) fn check(&self) -> Result<(), SourceError> {
        let finite =
            |name, value: f64| if value.is_finite() { Ok(()) } else { Err(SourceError::Number(name)) };
        let some = |name, time: Duration| if time.is_zero() { Err(SourceError::Time(name)) } else { Ok(()) };
        match self {
            Self::Constant(value) => finite("the value", *value),
            Self::Mirror(_) | Self::Follow { .. } => Ok(()),
            Self::Count { from, to, step, every } => {
                finite("'from'", *from)?;
                finite("'to'", *to)?;
                finite("'step'", *step)?;
                some("'every'", *every)?;
                if (to - from) * step <= 0.0 { Err(SourceError::Step) } else { Ok(()) }
            }
            Self::Ramp { from, to, time, then: _ } => {
                finite("'from'", *from)?;
                finite("'to'", *to)?;
                some("'time'", *time)
            }
            Self::Sine { mean, amplitude, period, phase: _ } => {
                finite("'mean'", *mean)?;
                finite("'amplitude'", *amplitude)?;
                some("'period'", *period)
            }
            Self::Table { rows: _, repeat } => repeat.map_or(Ok(()), |time| some("'repeat'", time)),
        }
    }

    /// The least and the greatest value that it reaches; `None` where others decide.
    pub(crate) fn extremes(&self) -> Option<(f64, f64)> {
        Some(match self {
            Self::Constant(value) => (*value, *value),
            Self::Mirror(_) | Self::Follow { .. } => return None,
            Self::Count { from, to, step, .. } => {
                let last = from + step * libm::floor((to - from) / step + 1e-9);
                (from.min(last), from.max(last))
            }
            Self::Ramp { from, to, .. } => (from.min(*to), from.max(*to)),
            Self::Sine { mean, amplitude, .. } => (mean - amplitude.abs(), mean + amplitude.abs()),
            Self::Table { rows, .. } => rows.extremes(),
        })
    }

    /// What it says at a time; `None` if that is no matter of time.
    pub(super) fn at(&self, time: Duration) -> Option<Said> {
        let ticking = Some(time.saturating_add(TICK));
        Some(match self {
            Self::Constant(value) => Said { value: *value, next: None },
            Self::Mirror(_) | Self::Follow { .. } => return None,
            Self::Count { from, to, step, every } => {
                let steps = libm::floor((to - from) / step + 1e-9) + 1.0;
                let count = time.as_nanos() / every.as_nanos().max(1);
                let next = u32::try_from(count + 1).ok().and_then(|count| every.checked_mul(count));
                Said { value: from + step * libm::fmod(count as f64, steps), next: next.or(ticking) }
            }
            Self::Ramp { from, to, time: whole, then } => {
                let part = time.as_secs_f64() / whole.as_secs_f64();
                let (part, next) = match then {
                    AtEnd::Hold if part >= 1.0 => (1.0, None),
                    AtEnd::Hold => (part, ticking),
                    AtEnd::Repeat => (libm::fmod(part, 1.0), ticking),
                    AtEnd::Return => (1.0 - libm::fabs(libm::fmod(part, 2.0) - 1.0), ticking),
                };
                Said { value: from + (to - from) * part, next }
            }
            Self::Sine { mean, amplitude, period, phase } => {
                let turns = time.saturating_add(*phase).as_secs_f64() / period.as_secs_f64();
                let angle = libm::fmod(turns, 1.0) * core::f64::consts::TAU;
                Said { value: mean + amplitude * libm::sin(angle), next: ticking }
            }
            Self::Table { rows, repeat: None } => {
                let (value, next) = rows.at(time);
                Said { value, next }
            }
            Self::Table { rows, repeat: Some(period) } => {
                let period_nanos = period.as_nanos().max(1);
                let within = nanos(time.as_nanos() % period_nanos);
                let begun = time.saturating_sub(within);
                let (value, next) = rows.at(within);
                let next = next.filter(|next| next < period).unwrap_or(*period);
                Said { value, next: Some(begun.saturating_add(next)) }
            }
        })
    }

    /// How often it looks at outputs of others.
    pub(super) const fn tick() -> Duration {
        TICK
    }
}

/// A duration of so many nanoseconds, the longest one where they do not fit.
fn nanos(nanos: u128) -> Duration {
    u64::try_from(nanos).map_or(Duration::MAX, Duration::from_nanos)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(source: &Source, ms: &[u64]) -> std::vec::Vec<f64> {
        source.check().unwrap();
        let value = |ms: &u64| source.at(Duration::from_millis(*ms)).unwrap().value;
        ms.iter().map(value).map(|value| libm::round(value * 1000.0) / 1000.0).collect()
    }

    #[test]
    fn every_source_over_time() {
        let s = Duration::from_secs;
        let count = |from, to, step| Source::Count { from, to, step, every: s(1) };
        assert_eq!(
            values(&count(0.0, 2.0, 1.0), &[0, 999, 1000, 2000, 3000, 4000]),
            [0.0, 0.0, 1.0, 2.0, 0.0, 1.0]
        );
        assert_eq!(values(&count(3.0, 1.0, -1.0), &[0, 1000, 2000, 3000]), [3.0, 2.0, 1.0, 3.0]);
        assert_eq!(values(&count(0.0, 2.5, 1.0), &[2000, 3000]), [2.0, 0.0]);
        let ramp = |then| Source::Ramp { from: 10.0, to: 20.0, time: s(1), then };
        assert_eq!(values(&ramp(AtEnd::Hold), &[0, 500, 1000, 1500]), [10.0, 15.0, 20.0, 20.0]);
        assert_eq!(values(&ramp(AtEnd::Repeat), &[500, 1000, 1500]), [15.0, 10.0, 15.0]);
        assert_eq!(
            values(&ramp(AtEnd::Return), &[500, 1000, 1500, 2000, 2500]),
            [15.0, 20.0, 15.0, 10.0, 15.0]
        );
        let sine = |phase| Source::Sine { mean: 5.0, amplitude: 2.0, period: s(4), phase };
        assert_eq!(values(&sine(s(0)), &[0, 1000, 2000, 3000, 4000]), [5.0, 7.0, 5.0, 3.0, 5.0]);
        assert_eq!(values(&sine(s(1)), &[0]), [7.0]);
        let rows = Table::read("0;1\n1;2").unwrap();
        let table = |repeat| Source::Table { rows: rows.clone(), repeat };
        assert_eq!(values(&table(None), &[0, 1000, 5000]), [1.0, 2.0, 2.0]);
        assert_eq!(values(&table(Some(s(3))), &[0, 1000, 2999, 3000, 4000]), [1.0, 2.0, 2.0, 1.0, 2.0]);
        assert_eq!(values(&Source::Constant(-7.0), &[0, 9000]), [-7.0, -7.0]);
    }

    #[test]
    fn each_says_when_it_may_change() {
        let (s, ms) = (Duration::from_secs, Duration::from_millis);
        let next = |source: Source, at: Duration| source.at(at).unwrap().next;
        assert_eq!(next(Source::Constant(0.0), s(1)), None);
        let count = Source::Count { from: 0.0, to: 9.0, step: 1.0, every: s(2) };
        assert_eq!(next(count, ms(4500)), Some(s(6)));
        let ramp = Source::Ramp { from: 0.0, to: 1.0, time: s(1), then: AtEnd::Hold };
        assert_eq!((next(ramp.clone(), s(0)), next(ramp, s(1))), (Some(ms(10)), None));
        let table = Source::Table { rows: Table::read("0;1\n2;2").unwrap(), repeat: Some(s(3)) };
        assert_eq!((next(table.clone(), s(3)), next(table, s(5))), (Some(s(5)), Some(s(6))));
    }

    #[test]
    fn what_cannot_be_followed_is_refused() {
        let (none, some) = (Duration::ZERO, Duration::from_secs(1));
        let count = |step, every| Source::Count { from: 0.0, to: 2.0, step, every };
        for (source, error) in [
            (Source::Constant(f64::NAN), SourceError::Number("the value")),
            (count(0.0, some), SourceError::Step),
            (count(-1.0, some), SourceError::Step),
            (count(1.0, none), SourceError::Time("'every'")),
            (Source::Ramp { from: 0.0, to: 1.0, time: none, then: AtEnd::Hold }, SourceError::Time("'time'")),
            (
                Source::Sine { mean: 0.0, amplitude: f64::INFINITY, period: some, phase: none },
                SourceError::Number("'amplitude'"),
            ),
            (
                Source::Table { rows: Table::read("0;1").unwrap(), repeat: Some(none) },
                SourceError::Time("'repeat'"),
            ),
        ] {
            assert_eq!(source.check(), Err(error));
        }
        assert_eq!(Source::Constant(0.0).at(Duration::MAX).unwrap().next, None);
        assert!(count(1.0, some).at(Duration::MAX).unwrap().value < 3.0);
    }
}
