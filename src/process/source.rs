//! What a value follows over time.

use core::time::Duration;

use thiserror::Error;

use super::{Condition, Table};

/// How often a value that moves all the time is computed.
const TICK: Duration = Duration::from_millis(10);

/// What a value follows. Times count from the first call. `R` names values elsewhere: what it is, the bus knows.
#[derive(Clone, Debug, PartialEq)]
pub enum Source<R> {
    /// Always the same value.
    Constant(f64),
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
    /// `high`, then `low`, and so on.
    Square {
        /// The value at the beginning of a period.
        high: f64,
        /// The value of the rest.
        low: f64,
        /// From one rise to the next.
        period: Duration,
        /// How long it is high in each period.
        on: Duration,
        /// How far into a period it begins.
        phase: Duration,
    },
    /// Another value at random each time; the same values for the same seed.
    Random {
        /// No value is less.
        least: f64,
        /// No value is greater.
        most: f64,
        /// Between two values.
        every: Duration,
        /// Decides which values come.
        seed: u32,
    },
    /// The rows of a table.
    Table {
        /// Times and values.
        rows: Table,
        /// Starts anew when so much time is over; `None`: the last row holds.
        repeat: Option<Duration>,
    },
    /// A value elsewhere, some time later.
    Follow {
        /// Which.
        of: R,
        /// How much later, at most as many changes as are kept in between.
        delay: Duration,
    },
    /// A value elsewhere through a lag of first order: after `time` it is 63 % on its way.
    Lag {
        /// Which.
        of: R,
        /// The time constant.
        time: Duration,
    },
    /// `factor * value + offset` of a value elsewhere.
    Scale {
        /// Which.
        of: R,
        /// By which it is multiplied.
        factor: f64,
        /// Added to it.
        offset: f64,
    },
    /// 1 while a condition on a value elsewhere holds, else 0.
    Compare {
        /// Which.
        of: R,
        /// What must hold of it.
        condition: Condition,
    },
    /// 1 while a value elsewhere is 0, else 0.
    Not(R),
    /// 1 while none of these values is 0, else 0.
    And(Vec<R>),
    /// 1 while one of these values is not 0, else 0.
    Or(Vec<R>),
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
    /// No value between the limits.
    #[error("'least' is above 'most'")]
    Limits,
    /// A square wave that is never low.
    #[error("'on' is longer than 'period'")]
    On,
    /// Logic of nothing.
    #[error("'of' is empty; expected one value or more")]
    Nothing,
}

/// What a source says: a value, and when it may change next, both at a time from the first call on.
pub(super) struct Said {
    pub(super) value: f64,
    pub(super) next: Option<Duration>,
}

impl<R> Source<R> {
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
            Self::Follow { .. } | Self::Not(_) => Ok(()),
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
            Self::Square { high, low, period, on, phase: _ } => {
                finite("'high'", *high)?;
                finite("'low'", *low)?;
                some("'period'", *period)?;
                if on > period { Err(SourceError::On) } else { Ok(()) }
            }
            Self::Random { least, most, every, seed: _ } => {
                finite("'least'", *least)?;
                finite("'most'", *most)?;
                some("'every'", *every)?;
                if least > most { Err(SourceError::Limits) } else { Ok(()) }
            }
            Self::Table { rows: _, repeat } => repeat.map_or(Ok(()), |time| some("'repeat'", time)),
            Self::Lag { of: _, time } => some("'time'", *time),
            Self::Scale { of: _, factor, offset } => {
                finite("'factor'", *factor)?;
                finite("'offset'", *offset)
            }
            Self::Compare { of: _, condition } => finite("the limit", condition.limit()),
            Self::And(all) | Self::Or(all) => {
                if all.is_empty() {
                    Err(SourceError::Nothing)
                } else {
                    Ok(())
                }
            }
        }
    }

    /// The least and the greatest value that it reaches; `None` where others decide. `elsewhere` says it of a value that it reads.
    pub(crate) fn extremes(&self, elsewhere: impl Fn(&R) -> Option<(f64, f64)>) -> Option<(f64, f64)> {
        Some(match self {
            Self::Constant(value) => (*value, *value),
            Self::Follow { of, .. } | Self::Lag { of, .. } => return elsewhere(of),
            Self::Scale { of, factor, offset } => {
                let (low, high) = elsewhere(of)?;
                let (one, other) = (factor * low + offset, factor * high + offset);
                (one.min(other), one.max(other))
            }
            Self::Count { from, to, step, .. } => {
                let last = from + step * libm::floor((to - from) / step + 1e-9);
                (from.min(last), from.max(last))
            }
            Self::Ramp { from, to, .. } => (from.min(*to), from.max(*to)),
            Self::Sine { mean, amplitude, .. } => (mean - amplitude.abs(), mean + amplitude.abs()),
            Self::Square { high, low, .. } => (low.min(*high), low.max(*high)),
            Self::Random { least, most, .. } => (*least, *most),
            Self::Table { rows, .. } => rows.extremes(),
            Self::Compare { .. } | Self::Not(_) | Self::And(_) | Self::Or(_) => (0.0, 1.0),
        })
    }

    /// The values elsewhere that it reads.
    pub(crate) fn read_values(&self) -> &[R] {
        match self {
            Self::Follow { of, .. }
            | Self::Lag { of, .. }
            | Self::Scale { of, .. }
            | Self::Compare { of, .. }
            | Self::Not(of) => core::slice::from_ref(of),
            Self::And(all) | Self::Or(all) => all,
            Self::Constant(_)
            | Self::Count { .. }
            | Self::Ramp { .. }
            | Self::Sine { .. }
            | Self::Square { .. }
            | Self::Random { .. }
            | Self::Table { .. } => &[],
        }
    }

    /// The same with other names for the values elsewhere.
    ///
    /// # Errors
    /// What `name` says, which gets the place in the list of an `and` or `or`.
    pub(crate) fn try_named<S, E>(
        self,
        mut name: impl FnMut(Option<usize>, R) -> Result<S, E>,
    ) -> Result<Source<S>, E> {
        let all = |all: Vec<R>, name: &mut dyn FnMut(Option<usize>, R) -> Result<S, E>| {
            all.into_iter().enumerate().map(|(at, of)| name(Some(at), of)).collect::<Result<Vec<S>, E>>()
        };
        Ok(match self {
            Self::Constant(value) => Source::Constant(value),
            Self::Count { from, to, step, every } => Source::Count { from, to, step, every },
            Self::Ramp { from, to, time, then } => Source::Ramp { from, to, time, then },
            Self::Sine { mean, amplitude, period, phase } => Source::Sine { mean, amplitude, period, phase },
            Self::Square { high, low, period, on, phase } => Source::Square { high, low, period, on, phase },
            Self::Random { least, most, every, seed } => Source::Random { least, most, every, seed },
            Self::Table { rows, repeat } => Source::Table { rows, repeat },
            Self::Follow { of, delay } => Source::Follow { of: name(None, of)?, delay },
            Self::Lag { of, time } => Source::Lag { of: name(None, of)?, time },
            Self::Scale { of, factor, offset } => Source::Scale { of: name(None, of)?, factor, offset },
            Self::Compare { of, condition } => Source::Compare { of: name(None, of)?, condition },
            Self::Not(of) => Source::Not(name(None, of)?),
            Self::And(of) => Source::And(all(of, &mut name)?),
            Self::Or(of) => Source::Or(all(of, &mut name)?),
        })
    }

    /// What it says at a time; `None` if that is no matter of time.
    pub(super) fn at(&self, time: Duration) -> Option<Said> {
        let ticking = Some(time.saturating_add(TICK));
        Some(match self {
            Self::Constant(value) => Said { value: *value, next: None },
            Self::Follow { .. }
            | Self::Lag { .. }
            | Self::Scale { .. }
            | Self::Compare { .. }
            | Self::Not(_)
            | Self::And(_)
            | Self::Or(_) => return None,
            Self::Count { from, to, step, every } => {
                let steps = libm::floor((to - from) / step + 1e-9) + 1.0;
                let (count, next) = count(time, *every);
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
            Self::Square { high, low, period, on, phase } => {
                let within = within(time.saturating_add(*phase), *period);
                let is_on = within < *on;
                let left = if is_on { *on } else { *period }.saturating_sub(within);
                Said { value: if is_on { *high } else { *low }, next: Some(time.saturating_add(left)) }
            }
            Self::Random { least, most, every, seed } => {
                let (count, next) = count(time, *every);
                Said { value: least + (most - least) * chance(*seed, count), next: next.or(ticking) }
            }
            Self::Table { rows, repeat: None } => {
                let (value, next) = rows.at(time);
                Said { value, next }
            }
            Self::Table { rows, repeat: Some(period) } => {
                let within = within(time, *period);
                let begun = time.saturating_sub(within);
                let (value, next) = rows.at(within);
                let next = next.filter(|next| next < period).unwrap_or(*period);
                Said { value, next: Some(begun.saturating_add(next)) }
            }
        })
    }

    /// How often it looks at values of which no change is told.
    pub(crate) const fn tick() -> Duration {
        TICK
    }
}

/// How often a time is over, and when it is next.
fn count(time: Duration, every: Duration) -> (u128, Option<Duration>) {
    let count = time.as_nanos() / every.as_nanos().max(1);
    (count, u32::try_from(count + 1).ok().and_then(|count| every.checked_mul(count)))
}

/// How far a time is into a period.
fn within(time: Duration, period: Duration) -> Duration {
    nanos(time.as_nanos() % period.as_nanos().max(1))
}

/// A number from 0 to 1, the same for the same seed and count (SplitMix64).
#[expect(clippy::cast_possible_truncation, reason = "the low bits of a count are enough")]
#[expect(clippy::cast_precision_loss, reason = "53 bits fit")]
fn chance(seed: u32, count: u128) -> f64 {
    let start = (u64::from(seed) << 32) ^ count as u64;
    let mixed = start.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let mixed = (mixed ^ mixed >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((mixed ^ mixed >> 31) >> 11) as f64 / ((1_u64 << 53) - 1) as f64
}

/// A duration of so many nanoseconds, the longest one where they do not fit.
fn nanos(nanos: u128) -> Duration {
    u64::try_from(nanos).map_or(Duration::MAX, Duration::from_nanos)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// No value elsewhere.
    type Source = super::Source<()>;

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
        let square = |on, phase| Source::Square { high: 5.0, low: -1.0, period: s(4), on, phase };
        assert_eq!(values(&square(s(1), s(0)), &[0, 999, 1000, 3999, 4000]), [5.0, 5.0, -1.0, -1.0, 5.0]);
        assert_eq!(values(&square(s(1), s(3)), &[0, 1000, 2000]), [-1.0, 5.0, -1.0]);
    }

    #[test]
    fn random_values_lie_between_their_limits_and_are_those_of_their_seed() {
        let every = Duration::from_secs(1);
        let random = |seed| Source::Random { least: -2.0, most: 6.0, every, seed };
        let times: std::vec::Vec<u64> = (0..1000).map(|second| second * 1000).collect();
        let all = values(&random(1), &times);
        assert!(all.iter().all(|value| (-2.0..=6.0).contains(value)));
        let mean = all.iter().sum::<f64>() / 1000.0;
        assert!((1.5..2.5).contains(&mean), "{mean}");
        assert!(all.iter().any(|value| *value < -1.5) && all.iter().any(|value| *value > 5.5));
        assert_eq!(values(&random(1), &times), all);
        assert_ne!(values(&random(2), &times), all);
        assert_eq!(values(&random(1), &[0, 999]), [all[0], all[0]]);
    }

    #[test]
    fn each_says_when_it_may_change() {
        let (s, ms) = (Duration::from_secs, Duration::from_millis);
        let next = |source: Source, at: Duration| source.at(at).unwrap().next;
        assert_eq!(next(Source::Constant(0.0), s(1)), None);
        let count = Source::Count { from: 0.0, to: 9.0, step: 1.0, every: s(2) };
        assert_eq!(next(count, ms(4500)), Some(s(6)));
        let random = Source::Random { least: 0.0, most: 9.0, every: s(2), seed: 7 };
        assert_eq!(next(random, ms(4500)), Some(s(6)));
        let square = Source::Square { high: 1.0, low: 0.0, period: s(4), on: s(1), phase: s(3) };
        assert_eq!((next(square.clone(), ms(500)), next(square, s(1))), (Some(s(1)), Some(s(2))));
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
            (
                Source::Square { high: 1.0, low: 0.0, period: some, on: some * 2, phase: none },
                SourceError::On,
            ),
            (Source::Random { least: 1.0, most: 0.0, every: some, seed: 0 }, SourceError::Limits),
            (Source::Random { least: 0.0, most: 1.0, every: none, seed: 0 }, SourceError::Time("'every'")),
            (Source::Lag { of: (), time: none }, SourceError::Time("'time'")),
            (Source::Scale { of: (), factor: f64::NAN, offset: 0.0 }, SourceError::Number("'factor'")),
            (Source::Or(std::vec::Vec::new()), SourceError::Nothing),
        ] {
            assert_eq!(source.check(), Err(error));
        }
        assert_eq!(Source::Constant(0.0).at(Duration::MAX).unwrap().next, None);
        assert!(count(1.0, some).at(Duration::MAX).unwrap().value < 3.0);
    }
}
