//! What must hold of an input of a station while a fault acts.

use core::fmt;
use core::str::FromStr;
use core::sync::atomic::{AtomicBool, Ordering};
use std::sync::Arc;

pub use crate::process::Condition;
use crate::process::Point;
use crate::profibus::fdl::Address;

/// What somebody else turns on and off. A clone is the same switch. It is off at first.
#[derive(Clone, Debug, Default)]
pub struct Switch(Arc<AtomicBool>);

impl Switch {
    /// Turns it on or off.
    pub(crate) fn set(&self, on: bool) {
        self.0.store(on, Ordering::Relaxed);
    }

    /// Whether it is on.
    pub(crate) fn is_on(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// Whether nobody else has it any more.
    pub(crate) fn is_abandoned(&self) -> bool {
        Arc::strong_count(&self.0) == 1
    }
}

/// A condition on an input of a station that a GSD describes, written `STATION/SLOT/OCTET/TYPE=VALUE`, or with `>` or `<`:
/// `7/1/0/bit0=1`, `7/2/0/unsigned16>1000`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct While {
    /// The station.
    pub station: Address,
    /// Its input.
    pub point: Point,
    /// What must hold of it.
    pub condition: Condition,
}

impl fmt::Display for While {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { station, point: Point { slot, offset, kind }, condition } = self;
        let (sign, value) = match condition {
            Condition::Is(value) => ('=', value),
            Condition::Above(value) => ('>', value),
            Condition::Below(value) => ('<', value),
        };
        write!(f, "{station}/{slot}/{offset}/{kind}{sign}{value}")
    }
}

impl FromStr for While {
    type Err = ();

    /// As it is written; no more is said of what is none.
    fn from_str(text: &str) -> Result<Self, ()> {
        let sign = text.find(['=', '>', '<']).ok_or(())?;
        let (input, comparison) = text.split_at(sign);
        let mut parts = input.split('/');
        let mut part = || parts.next().ok_or(());
        let station = part()?.parse().ok().and_then(|number| Address::station(number).ok()).ok_or(())?;
        let slot = part()?.parse().map_err(drop)?;
        let offset = usize::from(part()?.parse::<u8>().map_err(drop)?);
        let kind = part()?.parse().map_err(drop)?;
        let (sign, value) = comparison.split_at_checked(1).ok_or(())?;
        let value: f64 = value.parse().map_err(drop)?;
        let condition = match sign {
            "=" => Condition::Is(value),
            ">" => Condition::Above(value),
            _ => Condition::Below(value),
        };
        let ends = parts.next().is_none() && value.is_finite();
        if ends { Ok(Self { station, point: Point { slot, offset, kind }, condition }) } else { Err(()) }
    }
}
