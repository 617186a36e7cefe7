//! Faults on purpose of a bus with nodes, as text: `sdo-late=20ms,node=5,at=100`.

use core::fmt;
use core::str::FromStr;
use core::time::Duration;
use std::string::String;

use thiserror::Error;

use super::fault;
use crate::can_bus::can::Id;
use crate::can_bus::canopen::faults;
use crate::can_bus::canopen::faults::{BootUpFault, HeartbeatFault, Kind, SdoFault, TpdoFault};
use crate::can_bus::canopen::{Abort, NodeId};
use crate::host::occasions::{Occasions, Reading, Wrong, duration, in_micros, misfit};

/// How a fault is written, see [`NodeFault`].
const FORM: &str = "FAULT[=VALUE][,node=ID][,id=HEX][,rate=P][,count=N][,at=N][,seed=N]";

/// A fault on purpose of a bus with nodes:
/// `FAULT[=VALUE][,node=ID][,id=HEX][,rate=P][,count=N][,at=N][,seed=N]`.
///
/// What a node does wrong, each node counting its own occasions:
///
/// | FAULT | an occasion is | what the master gets |
/// | --- | --- | --- |
/// | `boot-up-missing`, `boot-up-twice` | a boot-up | none, or two |
/// | `sdo-late=TIME`, `sdo-lost`, `sdo-twice` | an SDO answer | it so much later, not, twice |
/// | `sdo-other-index` | an SDO answer that is no segment | bit 0 of the index inverted |
/// | `sdo-wrong-toggle` | an SDO answer to a segment | its toggle bit inverted |
/// | `sdo-abort=CODE` | an SDO answer | this abort code (hexadecimal) in its place |
/// | `heartbeat-jitter=TIME` | every second heartbeat | it so much later |
/// | `heartbeat-lost`, `heartbeat-stuck=OCTET` | a heartbeat | none, or this octet (hexadecimal) |
/// | `guarding-toggle-stuck` | a guarding answer | bit 7 is 0 |
/// | `tpdo-short`, `tpdo-stale` | a TPDO | without its last octet; the data of the first one spoiled |
/// | `tpdo-swapped` | a TPDO | it comes behind the next TPDO |
/// | `emcy-storm=TIME` | such a period | EMCY FF00h |
/// | `pre-operational` | a TPDO | behind it the node goes to PRE-OPERATIONAL by itself |
/// | `brown-out=TIME` | a frame of the node | instead of it nothing for so long, then a boot-up |
///
/// What happens to frames on the bus, whoever sends them; `node` names the sender, `id` the identifier (hexadecimal, three
/// digits, or eight with 29 bits):
///
/// | FAULT | an occasion is | what happens |
/// | --- | --- | --- |
/// | `frame-lost`, `frame-late=TIME`, `frame-twice` | a frame | nobody hears it; it comes so much later; twice |
/// | `frame-damaged` | a frame, each repetition anew | an error frame, and its sender repeats it: 32 in a row take it off the bus |
/// | `frame-not-acknowledged` | a frame, each repetition anew | the same; 16 in a row make the sender error passive |
///
/// `rate`, `count`, `at`, `seed` as in [`host::link::fault::Fault`](crate::host::link::fault::Fault). Of the faults of a frame
/// the first given acts. `Display` writes what is read.
///
/// ```
/// use profidrive::can_bus::canopen::NodeId;
/// use profidrive::can_bus::canopen::faults::{Kind, SdoFault};
/// use profidrive::host::can::{NodeFault, Spoiled};
///
/// let fault: NodeFault = "sdo-late=20ms,node=5,at=100".parse()?;
/// assert_eq!((fault.node, fault.at, fault.count), (Some(NodeId::new(5)?), 100, Some(1)));
/// assert_eq!(fault.what, Spoiled::Node(Kind::Sdo(SdoFault::Late(core::time::Duration::from_millis(20)))));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeFault {
    /// What goes wrong.
    pub what: Spoiled,
    /// Of which node; `None`: every one, of frames also those of masters.
    pub node: Option<NodeId>,
    /// Only frames with this identifier; `None`: any. Of [`Spoiled::Frame`] only.
    pub id: Option<Id>,
    /// From which occasion on, counted from 1.
    pub at: u32,
    /// How often at most; `None`: without limit.
    pub count: Option<u32>,
    /// With which probability at each occasion, above 0 and at most 1.
    pub rate: f64,
    /// What chance begins with.
    pub seed: u64,
}

/// What goes wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spoiled {
    /// What a node sends.
    Node(Kind),
    /// A frame on the bus.
    Frame(fault::Kind),
}

/// Why a text is no fault of a node.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum NodeFaultError {
    /// There is no such fault.
    #[error("'{got}' is no fault of a node; expected {}", NAMES.join(", "))]
    Unknown {
        /// The name found.
        got: String,
    },
    /// The value is missing, wrong, or one too many.
    #[error("{}; expected {expected}", misfit(key, got))]
    Value {
        /// Whose value.
        key: String,
        /// What fits.
        expected: &'static str,
        /// The value found.
        got: String,
    },
    /// There is no such condition.
    #[error("'{got}' is unknown; expected {FORM}")]
    UnknownKey {
        /// The name found.
        got: String,
    },
    /// A condition is given twice.
    #[error("'{key}' is given twice")]
    Twice {
        /// Which.
        key: String,
    },
    /// `id` is for faults of frames.
    #[error("id is only for faults of frames (frame-lost, ...); leave it out")]
    IdOfNode,
}

/// Every name, with what its value is.
const NAMES: &[&str] = &[
    "boot-up-missing",
    "boot-up-twice",
    "sdo-late=TIME",
    "sdo-lost",
    "sdo-twice",
    "sdo-other-index",
    "sdo-wrong-toggle",
    "sdo-abort=CODE",
    "heartbeat-jitter=TIME",
    "heartbeat-lost",
    "heartbeat-stuck=OCTET",
    "guarding-toggle-stuck",
    "tpdo-short",
    "tpdo-stale",
    "tpdo-swapped",
    "emcy-storm=TIME",
    "pre-operational",
    "brown-out=TIME",
    "frame-lost",
    "frame-late=TIME",
    "frame-twice",
    "frame-damaged",
    "frame-not-acknowledged",
];

const A_TIME: &str = "a time up to one hour, for example 20ms";

impl NodeFault {
    /// For the node, if it is one of a node.
    pub(super) const fn of_node(&self) -> Option<faults::Fault> {
        let &Self { what, at, count, rate, seed, .. } = self;
        match what {
            Spoiled::Node(kind) => Some(faults::Fault { kind, at, count, rate, seed }),
            Spoiled::Frame(_) => None,
        }
    }

    /// For the bus, if it is one of frames.
    pub(super) const fn of_frames(&self) -> Option<fault::Fault> {
        let &Self { what, id, at, count, rate, seed, .. } = self;
        match what {
            Spoiled::Node(_) => None,
            Spoiled::Frame(kind) => Some(fault::Fault { kind, at, count, rate, seed, id, from: None }),
        }
    }
}

impl FromStr for NodeFault {
    type Err = NodeFaultError;

    fn from_str(spec: &str) -> Result<Self, NodeFaultError> {
        let mut parts = spec.split(',');
        let what = Spoiled::parse(parts.next().unwrap_or_default())?;
        let (mut node, mut id, mut occasions) = (None, None, Reading::default());
        for part in parts {
            let (key, value) = part.split_once('=').unwrap_or((part, ""));
            let wrong = |expected| NodeFaultError::Value { key: key.into(), expected, got: value.into() };
            let again = match (key, occasions.take(key, value)) {
                (_, Some(Ok(()))) => false,
                (_, Some(Err(Wrong::Value(expected)))) => return Err(wrong(expected)),
                (_, Some(Err(Wrong::Twice))) => true,
                ("node", None) => {
                    let number = value.parse().ok().and_then(|number| NodeId::new(number).ok());
                    node.replace(number.ok_or_else(|| wrong("a node number, 1 to 127"))?).is_some()
                }
                ("id", None) => id
                    .replace(
                        identifier(value)
                            .ok_or_else(|| wrong("three hexadecimal digits, or eight with 29 bits"))?,
                    )
                    .is_some(),
                (_, None) => return Err(NodeFaultError::UnknownKey { got: part.into() }),
            };
            if again {
                return Err(NodeFaultError::Twice { key: key.into() });
            }
        }
        if let (Spoiled::Node(_), Some(_)) = (what, id) {
            return Err(NodeFaultError::IdOfNode);
        }
        let Occasions { at, count, rate, seed } = occasions.occasions();
        Ok(Self { what, node, id, at, count, rate, seed })
    }
}

impl fmt::Display for NodeFault {
    /// As it is written, with everything that differs from "always".
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let &Self { what, node, id, at, count, rate, seed } = self;
        write!(f, "{what}{}", Occasions { at, count, rate, seed })?;
        if let Some(node) = node {
            write!(f, ",node={node}")?;
        }
        match id {
            Some(id) => write!(f, ",id={id}"),
            None => Ok(()),
        }
    }
}

impl Spoiled {
    fn parse(text: &str) -> Result<Self, NodeFaultError> {
        let (name, value) = match text.split_once('=') {
            Some((name, value)) => (name, Some(value)),
            None => (text, None),
        };
        let wrong = |expected| NodeFaultError::Value {
            key: name.into(),
            expected,
            got: value.unwrap_or_default().into(),
        };
        let time =
            || -> Result<Duration, NodeFaultError> { value.and_then(duration).ok_or_else(|| wrong(A_TIME)) };
        let hexadecimal = |most: usize| {
            let digits = value.map(|value| value.trim_end_matches('h')).unwrap_or_default();
            let are_digits = digits.bytes().all(|octet| octet.is_ascii_hexdigit()) && digits.len() <= most;
            u32::from_str_radix(digits, 16).ok().filter(|_| are_digits)
        };
        if value.is_some() && NAMES.contains(&name) {
            return Err(wrong("no value"));
        }
        let kind = match name {
            "boot-up-missing" => Kind::BootUp(BootUpFault::Missing),
            "boot-up-twice" => Kind::BootUp(BootUpFault::Twice),
            "sdo-late" => Kind::Sdo(SdoFault::Late(time()?)),
            "sdo-lost" => Kind::Sdo(SdoFault::Lost),
            "sdo-twice" => Kind::Sdo(SdoFault::Twice),
            "sdo-other-index" => Kind::Sdo(SdoFault::OtherIndex),
            "sdo-wrong-toggle" => Kind::Sdo(SdoFault::WrongToggle),
            "sdo-abort" => {
                let code =
                    hexadecimal(8).ok_or_else(|| wrong("an abort code in hexadecimal, as 06090011"))?;
                Kind::Sdo(SdoFault::Abort(Abort::from_code(code)))
            }
            "heartbeat-jitter" => Kind::Heartbeat(HeartbeatFault::Jitter(time()?)),
            "heartbeat-lost" => Kind::Heartbeat(HeartbeatFault::Lost),
            "heartbeat-stuck" => {
                let octet = hexadecimal(2).and_then(|octet| u8::try_from(octet).ok());
                let octet = octet.ok_or_else(|| wrong("an octet in hexadecimal, as 7F"))?;
                Kind::Heartbeat(HeartbeatFault::Stuck(octet))
            }
            "guarding-toggle-stuck" => Kind::GuardingToggleStuck,
            "tpdo-short" => Kind::Tpdo(TpdoFault::Short),
            "tpdo-stale" => Kind::Tpdo(TpdoFault::Stale),
            "tpdo-swapped" => Kind::Tpdo(TpdoFault::Swapped),
            "emcy-storm" => Kind::EmcyStorm(time()?),
            "pre-operational" => Kind::LeaveOperational,
            "brown-out" => Kind::BrownOut(time()?),
            "frame-lost" => return Ok(Self::Frame(fault::Kind::Lose)),
            "frame-late" => return Ok(Self::Frame(fault::Kind::Delay(time()?))),
            "frame-twice" => return Ok(Self::Frame(fault::Kind::Double)),
            "frame-damaged" => return Ok(Self::Frame(fault::Kind::Damage)),
            "frame-not-acknowledged" => return Ok(Self::Frame(fault::Kind::NotAcknowledged)),
            _ => return Err(NodeFaultError::Unknown { got: name.into() }),
        };
        Ok(Self::Node(kind))
    }
}

impl fmt::Display for Spoiled {
    /// As it is written.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, value) = match *self {
            Self::Node(Kind::BootUp(BootUpFault::Missing)) => ("boot-up-missing", None),
            Self::Node(Kind::BootUp(BootUpFault::Twice)) => ("boot-up-twice", None),
            Self::Node(Kind::Sdo(SdoFault::Late(time))) => ("sdo-late", Some(in_micros(time))),
            Self::Node(Kind::Sdo(SdoFault::Lost)) => ("sdo-lost", None),
            Self::Node(Kind::Sdo(SdoFault::Twice)) => ("sdo-twice", None),
            Self::Node(Kind::Sdo(SdoFault::OtherIndex)) => ("sdo-other-index", None),
            Self::Node(Kind::Sdo(SdoFault::WrongToggle)) => ("sdo-wrong-toggle", None),
            Self::Node(Kind::Sdo(SdoFault::Abort(code))) => {
                ("sdo-abort", Some(std::format!("{:08X}", code.code())))
            }
            Self::Node(Kind::Heartbeat(HeartbeatFault::Jitter(time))) => {
                ("heartbeat-jitter", Some(in_micros(time)))
            }
            Self::Node(Kind::Heartbeat(HeartbeatFault::Lost)) => ("heartbeat-lost", None),
            Self::Node(Kind::Heartbeat(HeartbeatFault::Stuck(octet))) => {
                ("heartbeat-stuck", Some(std::format!("{octet:02X}")))
            }
            Self::Node(Kind::GuardingToggleStuck) => ("guarding-toggle-stuck", None),
            Self::Node(Kind::Tpdo(TpdoFault::Short)) => ("tpdo-short", None),
            Self::Node(Kind::Tpdo(TpdoFault::Stale)) => ("tpdo-stale", None),
            Self::Node(Kind::Tpdo(TpdoFault::Swapped)) => ("tpdo-swapped", None),
            Self::Node(Kind::EmcyStorm(period)) => ("emcy-storm", Some(in_micros(period))),
            Self::Node(Kind::LeaveOperational) => ("pre-operational", None),
            Self::Node(Kind::BrownOut(time)) => ("brown-out", Some(in_micros(time))),
            Self::Frame(fault::Kind::Lose) => ("frame-lost", None),
            Self::Frame(fault::Kind::Delay(time)) => ("frame-late", Some(in_micros(time))),
            Self::Frame(fault::Kind::Double) => ("frame-twice", None),
            Self::Frame(fault::Kind::Damage) => ("frame-damaged", None),
            Self::Frame(fault::Kind::NotAcknowledged) => ("frame-not-acknowledged", None),
        };
        match value {
            Some(value) => write!(f, "{name}={value}"),
            None => f.write_str(name),
        }
    }
}

fn identifier(text: &str) -> Option<Id> {
    if !text.bytes().all(|digit| digit.is_ascii_hexdigit()) {
        return None;
    }
    let number = u32::from_str_radix(text, 16).ok()?;
    match text.len() {
        3 => Id::base(u16::try_from(number).ok()?).ok(),
        8 => Id::extended(number).ok(),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;

    #[test]
    fn every_name_is_read_and_written_and_what_is_wrong_is_said() {
        for name in NAMES {
            let spec = name.replace("TIME", "5ms").replace("CODE", "06090011").replace("OCTET", "05");
            let fault: NodeFault = spec.parse().unwrap();
            assert_eq!((fault.node, fault.at, fault.count), (None, 1, None), "{name}");
            assert_eq!(fault.to_string(), spec);
        }
        for spec in [
            "sdo-lost,rate=0.5,count=3,at=7,seed=2,node=5",
            "frame-lost,node=5,id=185",
            "frame-damaged,count=32,id=00000185",
            "sdo-lost,count=1,at=9",
        ] {
            assert_eq!(spec.parse::<NodeFault>().unwrap().to_string(), spec);
        }
        for (spec, says) in [
            ("no-reply", "'no-reply' is no fault of a node; expected boot-up-missing, "),
            ("sdo-late", "sdo-late has no value; expected a time"),
            ("sdo-late=0ms", "'0ms' does not fit sdo-late"),
            ("sdo-lost=1", "'1' does not fit sdo-lost; expected no value"),
            ("sdo-abort=060900111", "does not fit sdo-abort"),
            ("heartbeat-stuck=100", "does not fit heartbeat-stuck"),
            ("sdo-lost,node=0", "'0' does not fit node; expected a node number"),
            ("sdo-lost,rate=0", "'0' does not fit rate; expected a probability"),
            ("sdo-lost,count=1,count=2", "'count' is given twice"),
            ("sdo-lost,node=1,node=2", "'node' is given twice"),
            ("sdo-lost,station=5", "'station=5' is unknown; expected FAULT"),
            ("sdo-lost,id=585", "id is only for faults of frames"),
            ("frame-lost,id=800", "'800' does not fit id; expected three hexadecimal digits"),
            ("frame-lost,id=+85", "does not fit id"),
            ("", "'' is no fault of a node"),
        ] {
            let error = spec.parse::<NodeFault>().unwrap_err().to_string();
            assert!(error.contains(says), "{spec}: {error}");
        }
    }
}
