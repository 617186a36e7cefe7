//! The parameters of the profile that every drive has (`profidrive-v2.md` 7).

use super::{Channel, Kind, Row, Tie};
use crate::devices::ppo_drive::Quantity;

/// Number, name, kind, tie, and whether a master can write it.
const ROWS: [(u16, &str, Kind, Tie, bool); 25] = [
    (915, "PZD assignment setpoint", Kind::Uint16, Tie::Channel(Channel::PzdSetpoint), true),
    (916, "PZD assignment actual", Kind::Uint16, Tie::Channel(Channel::PzdActual), true),
    (917, "spontaneous messages", Kind::Uint16, Tie::None, true),
    (918, "node address", Kind::Uint16, Tie::Channel(Channel::Address), false),
    (927, "operator control rights", Kind::Uint16, Tie::None, true),
    (928, "control priority", Kind::Uint16, Tie::None, true),
    (929, "selected PPO type", Kind::Uint16, Tie::Channel(Channel::PpoType), false),
    (930, "operating mode", Kind::Uint16, Tie::None, false),
    (944, "fault message counter", Kind::Uint16, Tie::Drive(Quantity::FaultMessages), false),
    (945, "fault code", Kind::Uint16, Tie::Drive(Quantity::FaultBuffer), false),
    (947, "fault number", Kind::Uint16, Tie::Drive(Quantity::FaultBuffer), false),
    (952, "number of faults", Kind::Uint16, Tie::Drive(Quantity::FaultCount), true),
    (953, "last warning", Kind::Uint16, Tie::Drive(Quantity::WarningBuffer), false),
    (954, "second-last warning", Kind::Uint16, Tie::Drive(Quantity::WarningBuffer), false),
    (955, "third-last warning", Kind::Uint16, Tie::Drive(Quantity::WarningBuffer), false),
    (956, "fourth-last warning", Kind::Uint16, Tie::Drive(Quantity::WarningBuffer), false),
    (957, "fifth-last warning", Kind::Uint16, Tie::Drive(Quantity::WarningBuffer), false),
    (958, "sixth-last warning", Kind::Uint16, Tie::Drive(Quantity::WarningBuffer), false),
    (959, "seventh-last warning", Kind::Uint16, Tie::Drive(Quantity::WarningBuffer), false),
    (960, "eighth-last warning", Kind::Uint16, Tie::Drive(Quantity::WarningBuffer), false),
    (965, "profile number", Kind::Bits16, Tie::None, false),
    (967, "control word", Kind::Bits16, Tie::Channel(Channel::ControlWord), false),
    (968, "status word", Kind::Bits16, Tie::Channel(Channel::StatusWord), false),
    (971, "store parameters", Kind::Uint16, Tie::Channel(Channel::Store), true),
    (980, "list of parameters", Kind::Uint16, Tie::Channel(Channel::List), false),
];

/// The first of the eight parameters of one warning each.
const FIRST_WARNING: u16 = 953;

/// The element of the warning buffer that a single parameter of the profile shows, from 1.
pub(super) fn single_element(pnu: u16, tie: Tie) -> Option<u8> {
    let is_warning = tie == Tie::Drive(Quantity::WarningBuffer);
    let place = pnu.checked_sub(FIRST_WARNING).filter(|place| is_warning && *place < 8)?;
    u8::try_from(place + 1).ok()
}

/// What a master may write where this drive has no choice: no spontaneous messages, writes and process data allowed.
const fn limits(pnu: u16) -> Option<(f64, f64)> {
    match pnu {
        917 => Some((0.0, 0.0)),
        927 | 928 => Some((1.0, 1.0)),
        971 => Some((0.0, 1.0)),
        _ => None,
    }
}

const fn default(pnu: u16) -> Option<f64> {
    match pnu {
        // 930: speed control.
        927 | 928 | 930 => Some(1.0),
        // Profile 3, drives; version 2.0.
        965 => Some(0x0314 as f64),
        _ => None,
    }
}

pub(super) fn rows() -> Vec<Row> {
    let row = |(pnu, name, kind, tie, writable): (u16, &str, Kind, Tie, bool)| {
        let (low, high) = limits(pnu).unwrap_or(kind.range());
        let single = single_element(pnu, tie).is_some();
        let elements = tie.elements().filter(|_| !single);
        let default = default(pnu).map(|default| [default].to_vec());
        let (name, unit) = (name.to_owned(), Default::default());
        Row { pnu, name, kind, elements, low, high, default, unit, scale: 1.0, writable, tie }
    };
    ROWS.into_iter().map(row).collect()
}
