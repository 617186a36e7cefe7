//! Faults on purpose as text: what nodes do wrong, as `sdo-late=20ms,node=5`.

use core::str::FromStr;
use core::time::Duration;
use std::string::String;
use std::vec::Vec;

use thiserror::Error;

use crate::canopen::faults::{BootUpFault, Faults, HeartbeatFault, SdoFault, TpdoFault};
use crate::canopen::{Abort, NodeId};
use crate::host::link::fault::duration;

/// What nodes do wrong: `FAULT[=VALUE][,node=ID]`.
///
/// ```
/// use profidrive::canopen::{NodeId, faults::SdoFault};
/// use profidrive::host::can::NodeFault;
///
/// let fault: NodeFault = "sdo-late=20ms,node=5".parse()?;
/// assert_eq!(fault.node, Some(NodeId::new(5)?));
/// assert_eq!(fault.faults.sdo, Some(SdoFault::Late(core::time::Duration::from_millis(20))));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NodeFault {
    /// Which node; `None`: every one.
    pub node: Option<NodeId>,
    /// What it does wrong.
    pub faults: Faults,
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
    #[error("'{got}' does not fit {key}; expected {expected}")]
    Value {
        /// Whose value.
        key: String,
        /// What fits.
        expected: &'static str,
        /// The value found.
        got: String,
    },
    /// There is no such selector.
    #[error("'{got}' is unknown; expected FAULT[=VALUE][,node=ID]")]
    UnknownKey {
        /// The name found.
        got: String,
    },
    /// Two faults of the same frames of one node.
    #[error("two faults of the same frames of one node: only one can act")]
    Twice,
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
    "emcy-storm=TIME",
];

const A_TIME: &str = "a time up to one hour, for example 20ms";

impl FromStr for NodeFault {
    type Err = NodeFaultError;

    fn from_str(spec: &str) -> Result<Self, NodeFaultError> {
        let mut parts = spec.split(',');
        let faults = faults(parts.next().unwrap_or_default())?;
        let mut node = None;
        for part in parts {
            let (key, value) = part.split_once('=').unwrap_or((part, ""));
            if key != "node" || node.is_some() {
                return Err(NodeFaultError::UnknownKey { got: part.into() });
            }
            let number = value.parse().ok().and_then(|number| NodeId::new(number).ok());
            node = Some(number.ok_or_else(|| NodeFaultError::Value {
                key: key.into(),
                expected: "a node number, 1 to 127",
                got: value.into(),
            })?);
        }
        Ok(Self { node, faults })
    }
}

fn faults(text: &str) -> Result<Faults, NodeFaultError> {
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
    let none = Faults::NONE;
    let takes_value = NAMES.iter().any(|known| known.split_once('=').is_some_and(|(known, _)| known == name));
    if value.is_some() && !takes_value && NAMES.contains(&name) {
        return Err(wrong("no value"));
    }
    Ok(match name {
        "boot-up-missing" => Faults { boot_up: Some(BootUpFault::Missing), ..none },
        "boot-up-twice" => Faults { boot_up: Some(BootUpFault::Twice), ..none },
        "sdo-late" => Faults { sdo: Some(SdoFault::Late(time()?)), ..none },
        "sdo-lost" => Faults { sdo: Some(SdoFault::Lost), ..none },
        "sdo-twice" => Faults { sdo: Some(SdoFault::Twice), ..none },
        "sdo-other-index" => Faults { sdo: Some(SdoFault::OtherIndex), ..none },
        "sdo-wrong-toggle" => Faults { sdo: Some(SdoFault::WrongToggle), ..none },
        "sdo-abort" => {
            let code = hexadecimal(8).ok_or_else(|| wrong("an abort code in hexadecimal, as 06090011"))?;
            Faults { sdo: Some(SdoFault::Abort(Abort::from_code(code))), ..none }
        }
        "heartbeat-jitter" => Faults { heartbeat: Some(HeartbeatFault::Jitter(time()?)), ..none },
        "heartbeat-lost" => Faults { heartbeat: Some(HeartbeatFault::Lost), ..none },
        "heartbeat-stuck" => {
            let octet = hexadecimal(2).and_then(|octet| u8::try_from(octet).ok());
            let octet = octet.ok_or_else(|| wrong("an octet in hexadecimal, as 7F"))?;
            Faults { heartbeat: Some(HeartbeatFault::Stuck(octet)), ..none }
        }
        "guarding-toggle-stuck" => Faults { guarding_toggle_stuck: true, ..none },
        "tpdo-short" => Faults { tpdo: Some(TpdoFault::Short), ..none },
        "tpdo-stale" => Faults { tpdo: Some(TpdoFault::Stale), ..none },
        "emcy-storm" => Faults { emcy_storm: Some(time()?), ..none },
        _ => return Err(NodeFaultError::Unknown { got: name.into() }),
    })
}

impl NodeFault {
    /// Everything that node does wrong.
    ///
    /// # Errors
    /// [`NodeFaultError::Twice`].
    pub fn of(node: NodeId, faults: &[Self]) -> Result<Faults, NodeFaultError> {
        let of_node = |fault: &&Self| fault.node.is_none_or(|of| of == node);
        let faults: Vec<_> = faults.iter().filter(of_node).map(|fault| fault.faults).collect();
        let mut all = Faults::NONE;
        for fault in faults {
            add(&mut all.boot_up, fault.boot_up)?;
            add(&mut all.sdo, fault.sdo)?;
            add(&mut all.heartbeat, fault.heartbeat)?;
            add(&mut all.tpdo, fault.tpdo)?;
            add(&mut all.emcy_storm, fault.emcy_storm)?;
            all.guarding_toggle_stuck |= fault.guarding_toggle_stuck;
        }
        Ok(all)
    }
}

fn add<T>(all: &mut Option<T>, one: Option<T>) -> Result<(), NodeFaultError> {
    match (&all, one) {
        (_, None) => Ok(()),
        (None, one) => {
            *all = one;
            Ok(())
        }
        (Some(_), Some(_)) => Err(NodeFaultError::Twice),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;

    #[test]
    fn every_name_is_read_and_what_is_wrong_is_said() {
        for name in NAMES {
            let spec = name.replace("TIME", "5ms").replace("CODE", "06090011").replace("OCTET", "05");
            let fault: NodeFault = spec.parse().unwrap();
            assert_ne!(fault.faults, Faults::NONE, "{name}");
            assert_eq!(fault.node, None);
        }
        for (spec, says) in [
            ("no-reply", "'no-reply' is no fault of a node; expected boot-up-missing, "),
            ("sdo-late", "'' does not fit sdo-late; expected a time"),
            ("sdo-late=0ms", "'0ms' does not fit sdo-late"),
            ("sdo-lost=1", "'1' does not fit sdo-lost; expected no value"),
            ("sdo-abort=060900111", "does not fit sdo-abort"),
            ("heartbeat-stuck=100", "does not fit heartbeat-stuck"),
            ("sdo-lost,node=0", "'0' does not fit node; expected a node number"),
            ("sdo-lost,rate=0.1", "'rate=0.1' is unknown"),
            ("", "'' is no fault of a node"),
        ] {
            let error = spec.parse::<NodeFault>().unwrap_err().to_string();
            assert!(error.contains(says), "{spec}: {error}");
        }
    }

    #[test]
    fn the_faults_of_a_node_are_those_of_all_and_its_own() {
        let read =
            |specs: &[&str]| specs.iter().map(|spec| spec.parse().unwrap()).collect::<Vec<NodeFault>>();
        let five = NodeId::new(5).unwrap();
        let all = NodeFault::of(five, &read(&["sdo-lost,node=5", "tpdo-short", "sdo-twice,node=6"])).unwrap();
        assert_eq!((all.sdo, all.tpdo), (Some(SdoFault::Lost), Some(TpdoFault::Short)));
        assert_eq!(NodeFault::of(five, &read(&["sdo-lost", "sdo-twice,node=5"])), Err(NodeFaultError::Twice));
    }
}
