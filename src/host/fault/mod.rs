//! Faults on purpose, to test masters: one rule for lines of PROFIBUS, buses of CAN and CANopen nodes.
//!
//! ```text
//! "late=20ms,at=100,station=5" ──▶ Rule { kind, when, whom } ──▶ a list ──▶ where its kind acts
//! ```
//!
//! | where | kinds |
//! | --- | --- |
//! | [`link::fault`](super::link::fault) | requests and replies of a line of PROFIBUS |
//! | [`can::fault`](super::can::fault) | frames of a bus of CAN, whoever sends them |
//! | [`canopen::faults`](crate::can_bus::canopen::faults) | what a CANopen node sends |
//!
//! [`Row::all`] is the table of all of them, docs/faults.md says more. The stations are as they always are and know nothing
//! of it. Everything is deterministic: the same telegrams in the same order have the same faults.
//!
//! ```
//! use profidrive::host::fault::{BusKind, Rule};
//!
//! let rule: Rule = "late=20ms,station=5,at=100".parse()?;
//! assert_eq!((rule.bus(), rule.when.at, rule.when.count), (BusKind::Profibus, 100, Some(1)));
//! assert_eq!(rule.to_string(), "late=20ms,count=1,at=100,station=5");
//! # Ok::<(), profidrive::host::fault::RuleError>(())
//! ```

use thiserror::Error;

use crate::can_bus::can::Id;
use crate::can_bus::canopen::NodeId;
pub use crate::chance::When;
use crate::profibus::dp::{Service, State};
use crate::profibus::fdl::Address;

mod condition;
mod kinds;
mod list;
mod parameter;
mod text;

pub use condition::{Condition, Switch, While};
pub(crate) use kinds::Kind;
pub use kinds::{Row, Way};
pub(crate) use list::{Active, List, Listed};
#[cfg(all(test, feature = "emulator"))]
pub(crate) use parameter::TIME_PATTERN;
pub(crate) use parameter::{DiagOctets, FramePart};
pub(crate) use parameter::{duration, no_time};
pub use text::RuleError;

/// A fault on purpose: what, when, and of whom. It is written as `BusKind::form` says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rule {
    pub(crate) kind: Kind,
    /// On which occasions.
    pub when: When,
    /// Only while this holds of an input of a station.
    pub while_input: Option<While>,
    pub(crate) whom: Whom,
}

/// Of whom, and of what. `None`: of all.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Whom {
    /// An address on PROFIBUS, a node number on CAN.
    pub(crate) station: Option<u8>,
    /// Requests of this service and the replies to them.
    pub(crate) service: Option<Service>,
    /// In which state of the station.
    pub(crate) state: Option<State>,
    /// The repetition of a request and its reply, 0 the request itself.
    pub(crate) retry: Option<u32>,
    /// Frames with this identifier.
    pub(crate) id: Option<Id>,
}

/// The kind of a bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "panel", derive(serde::Serialize), serde(rename_all = "snake_case"))]
#[cfg_attr(all(test, feature = "panel"), derive(utoipa::ToSchema))]
pub enum BusKind {
    /// A line of PROFIBUS.
    Profibus,
    /// A bus of CAN with its nodes.
    #[cfg_attr(feature = "panel", serde(rename = "canopen"))]
    Can,
}

impl BusKind {
    /// How a fault is written.
    pub(crate) const fn form(self) -> &'static str {
        match self {
            Self::Profibus => {
                "FAULT[=VALUE][,rate=P][,count=N][,at=N][,seed=N][,station=ADDRESS][,service=NAME][,state=NAME]\
                 [,retry=N][,from=TIME][,until=TIME][,while=STATION/SLOT/OCTET/TYPE=VALUE]"
            }
            Self::Can => {
                "FAULT[=VALUE][,node=ID][,id=HEX][,rate=P][,count=N][,at=N][,seed=N][,from=TIME][,until=TIME]"
            }
        }
    }

    /// What it is called where a fault is on it.
    #[cfg(feature = "panel")]
    pub(crate) const fn name(self) -> &'static str {
        let [_, line] = self.words();
        line
    }

    /// What a station is called, and what it is on.
    const fn words(self) -> [&'static str; 2] {
        match self {
            Self::Profibus => ["station", "line"],
            Self::Can => ["node", "bus"],
        }
    }
}

impl Rule {
    /// Where it can act.
    pub fn bus(&self) -> BusKind {
        self.kind.way().bus()
    }

    /// The station that it is for; `None`: all, or it is for nodes.
    pub(crate) fn station(&self) -> Option<Address> {
        let number = self.whom.station.filter(|_| self.bus() == BusKind::Profibus)?;
        Address::station(number).ok()
    }

    /// The node that it is for; `None`: all, or it is for stations.
    pub(crate) fn node(&self) -> Option<NodeId> {
        let number = self.whom.station.filter(|_| self.bus() == BusKind::Can)?;
        NodeId::new(number).ok()
    }

    /// Whether the station or the node that this fault is for is one of `there`.
    ///
    /// # Errors
    /// [`NoStation`] if it is not: the fault would never act.
    pub(crate) fn check(&self, there: impl IntoIterator<Item = u8>) -> Result<(), NoStation> {
        let Some(station) = self.whom.station else {
            return Ok(());
        };
        let there: Vec<u8> = there.into_iter().collect();
        if there.contains(&station) {
            return Ok(());
        }
        Err(NoStation { fault: self.to_string(), bus: self.bus(), station, there })
    }
}

/// A fault is for a station or a node that is not there.
#[derive(Clone, Debug, PartialEq, Error)]
#[error(
    "fault '{fault}' is for {} {station}, which is not on the {}; expected {}",
    bus.words()[0],
    bus.words()[1],
    self.expected()
)]
pub struct NoStation {
    /// The fault, as it is written.
    pub fault: String,
    /// Where it acts.
    pub bus: BusKind,
    /// Its station.
    pub station: u8,
    /// The stations that are there.
    pub there: Vec<u8>,
}

impl NoStation {
    /// Who is there: `one of 5, 6`.
    pub(crate) fn expected(&self) -> String {
        let [station, line] = self.bus.words();
        let numbers: Vec<String> = self.there.iter().map(ToString::to_string).collect();
        match &numbers[..] {
            [] => std::format!("no {station} condition: the {line} has no {station}s"),
            [only] => std::format!("{station} {only}"),
            [..] => std::format!("one of {}", numbers.join(", ")),
        }
    }
}

#[cfg(test)]
mod tests;
