//! When a fault on purpose is injected, as text: `rate=P`, `count=N`, `at=N`, `seed=N`; and numbers and times as faults have
//! them.

use core::fmt;
use core::time::Duration;
use std::format;
use std::string::String;

const DEFAULT_SEED: u64 = 1;

/// The longest time that can be asked for.
const LONGEST: Duration = Duration::from_secs(3600);

/// On which occasions a fault is injected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Occasions {
    /// From which on, counted from 1.
    pub(super) at: u32,
    /// How often at most; `None`: without limit.
    pub(super) count: Option<u32>,
    /// With which probability at each, above 0 and at most 1.
    pub(super) rate: f64,
    /// What chance begins with.
    pub(super) seed: u64,
}

impl Occasions {
    /// Every one.
    pub(super) const ALWAYS: Self = Self { at: 1, count: None, rate: 1.0, seed: DEFAULT_SEED };
}

impl fmt::Display for Occasions {
    /// As they are written behind a fault, with everything that differs from "always".
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { at, count, rate, seed } = self;
        if *rate < 1.0 {
            write!(f, ",rate={rate}")?;
        }
        match count {
            Some(count) => write!(f, ",count={count}")?,
            // A lone `at` would mean that one only.
            None if *at > 1 && *rate >= 1.0 => write!(f, ",count={}", u32::MAX)?,
            None => {}
        }
        if *at > 1 {
            write!(f, ",at={at}")?;
        }
        if *seed != DEFAULT_SEED {
            write!(f, ",seed={seed}")?;
        }
        Ok(())
    }
}

/// Conditions while they are read, one after the other.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Reading {
    rate: Option<f64>,
    count: Option<u32>,
    at: Option<u32>,
    seed: Option<u64>,
}

/// Why a condition cannot be taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wrong {
    /// What its value must be.
    Value(&'static str),
    /// It was there already.
    Twice,
}

impl Reading {
    /// Takes a condition. `None`: it is none of these.
    pub(super) fn take(&mut self, key: &str, value: &str) -> Option<Result<(), Wrong>> {
        let positive = number(value).ok_or(Wrong::Value("a number, 1 or more"));
        let again = match key {
            "rate" => {
                let probability = decimal(value).filter(|rate| *rate > 0.0 && *rate <= 1.0);
                probability
                    .ok_or(Wrong::Value("a probability above 0 and up to 1"))
                    .map(|rate| self.rate.replace(rate).is_some())
            }
            "count" => positive.map(|count| self.count.replace(count).is_some()),
            "at" => positive.map(|at| self.at.replace(at).is_some()),
            "seed" => digits(value)
                .and_then(|value| value.parse().ok())
                .ok_or(Wrong::Value("a number"))
                .map(|seed| self.seed.replace(seed).is_some()),
            _ => return None,
        };
        Some(again.and_then(|again| if again { Err(Wrong::Twice) } else { Ok(()) }))
    }

    /// All of them.
    pub(super) fn occasions(self) -> Occasions {
        // "At the hundredth" means that one; "at random from the hundredth on" does not.
        let once = self.at.is_some() && self.rate.is_none();
        Occasions {
            at: self.at.unwrap_or(1),
            count: self.count.or(once.then_some(1)),
            rate: self.rate.unwrap_or(1.0),
            seed: self.seed.unwrap_or(DEFAULT_SEED),
        }
    }
}

/// A text of digits only: numbers have no sign here.
pub(super) fn digits(text: &str) -> Option<&str> {
    (!text.is_empty() && text.bytes().all(|octet| octet.is_ascii_digit())).then_some(text)
}

/// A number from 1 on.
pub(super) fn number(text: &str) -> Option<u32> {
    digits(text)?.parse().ok().filter(|number| *number > 0)
}

/// A number such as 0.01; no exponents, no names.
fn decimal(text: &str) -> Option<f64> {
    let (whole, fraction) = text.split_once('.').unwrap_or((text, "0"));
    digits(whole)?;
    digits(fraction)?;
    text.parse().ok()
}

/// A time as faults have it: a whole number of `us`, `ms` or `s`, above 0 and at most an hour. `None`: it is none.
pub fn duration(text: &str) -> Option<Duration> {
    let unit = text.find(|c: char| !c.is_ascii_digit())?;
    let (value, unit) = text.split_at(unit);
    let value: u64 = value.parse().ok()?;
    let duration = match unit {
        "us" => Duration::from_micros(value),
        "ms" => Duration::from_millis(value),
        "s" => Duration::from_secs(value),
        _ => return None,
    };
    (!duration.is_zero() && duration <= LONGEST).then_some(duration)
}

/// A time as it is written.
pub(super) fn in_micros(time: Duration) -> String {
    let micros = time.as_micros();
    match (micros % 1_000_000, micros % 1_000) {
        (0, _) => format!("{}s", micros / 1_000_000),
        (_, 0) => format!("{}ms", micros / 1_000),
        (_, _) => format!("{micros}us"),
    }
}

/// What is wrong with a value: it is missing, or another one is expected.
pub(crate) fn misfit(key: &str, got: &str) -> String {
    if got.is_empty() {
        std::format!("{key} has no value")
    } else {
        std::format!("'{got}' does not fit {key}")
    }
}
