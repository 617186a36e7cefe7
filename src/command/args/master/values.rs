//! What stands behind the options of `master`: addresses, times, velocities.

use core::convert::Infallible;
use core::ops::RangeInclusive;
use core::str::FromStr;
use core::time::Duration;

use crate::can_bus::canopen::NodeId;
use crate::command::args::link::BaudSpec;
use crate::host::list::named::ParameterSpec;
use crate::profibus::fdl::Address;

/// A parameter or an entry, as it was written: the link says which.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Asked(pub(crate) String);

impl FromStr for Asked {
    type Err = Infallible;

    fn from_str(text: &str) -> Result<Self, Infallible> {
        Ok(Self(text.into()))
    }
}

impl Asked {
    /// On PROFIBUS.
    pub(crate) fn parameter(&self) -> Result<ParameterSpec, String> {
        self.0.parse().map_err(|reason| format!("invalid value '{}' for '<PNU[.SUB]>': {reason}", self.0))
    }
}

/// Addresses to look at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct AddressRange {
    pub(crate) first: Address,
    pub(crate) last: Address,
}

impl FromStr for AddressRange {
    type Err = String;

    fn from_str(range: &str) -> Result<Self, String> {
        let (first, last) = range.split_once('-').unwrap_or((range, range));
        let (first, last) = (station(first)?, station(last)?);
        if last < first {
            return Err(format!("the range {range} is empty; expected FIRST-LAST"));
        }
        Ok(Self { first, last })
    }
}

/// Which way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Direction {
    Positive,
    Negative,
}

impl FromStr for Direction {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "+" => Ok(Self::Positive),
            "-" => Ok(Self::Negative),
            _ => Err("expected + or -".into()),
        }
    }
}

pub(super) fn station(text: &str) -> Result<Address, String> {
    let number = text.parse().ok().and_then(|number| Address::station(number).ok());
    number.ok_or_else(|| "expected an address from 0 to 126".into())
}

pub(super) fn master(text: &str) -> Result<Address, String> {
    let address = station(text).ok().filter(|address| address.number() <= 125);
    address.ok_or_else(|| "expected an address from 0 to 125".into())
}

pub(super) fn node(text: &str) -> Result<NodeId, String> {
    let number = text.parse().ok().and_then(|number| NodeId::new(number).ok());
    number.ok_or_else(|| "expected a node number from 1 to 127".into())
}

pub(super) fn rate(text: &str) -> Result<BaudSpec, String> {
    match text.parse() {
        Ok(rate @ (BaudSpec::Fixed(_) | BaudSpec::Other(_))) => Ok(rate),
        Ok(BaudSpec::Auto | BaudSpec::OfFile) => {
            Err("a master sets the rate; expected a number such as 19200".into())
        }
        Err(error) => Err(error.replace("auto or ", "")),
    }
}

/// `500ms`, `2s`, `1.5s`.
pub(super) fn time(text: &str) -> Result<Duration, String> {
    let (number, unit) = match text.strip_suffix("ms") {
        Some(number) => (number, 0.001),
        None => (text.strip_suffix('s').unwrap_or("x"), 1.0),
    };
    let seconds = number.parse::<f64>().ok().map(|number| number * unit);
    seconds
        .and_then(|seconds| Duration::try_from_secs_f64(seconds).ok())
        .ok_or_else(|| "expected a time such as 500ms or 2s".into())
}

pub(super) fn watchdog(text: &str) -> Result<Duration, String> {
    let range = Duration::from_millis(10)..=Duration::from_secs(650);
    time_within(text, range, "expected a time from 10ms to 650s, such as 500ms")
}

pub(super) fn slot_time(text: &str) -> Result<Duration, String> {
    let range = Duration::from_millis(1)..=Duration::from_secs(10);
    time_within(text, range, "expected a time from 1ms to 10s, such as 100ms")
}

fn time_within(text: &str, range: RangeInclusive<Duration>, expected: &str) -> Result<Duration, String> {
    time(text).ok().filter(|time| range.contains(time)).ok_or_else(|| expected.into())
}

/// A velocity in whole rpm, with its unit if one is written.
pub(super) fn rpm(text: &str) -> Result<i32, String> {
    let number = text.strip_suffix("rpm").unwrap_or(text).trim_end();
    number
        .parse()
        .map_err(|_| format!("'{text}' is no velocity; expected whole rpm such as 30, -30 or 30rpm"))
}

#[cfg(test)]
mod tests;
