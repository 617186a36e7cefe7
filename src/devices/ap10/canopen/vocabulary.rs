//! What the AP10 calls what it says on CANopen.

use super::objects::OBJECTS;
use super::unit::{BUS_OFF_RECOVERED, ERROR_PASSIVE, code as code_of};
use crate::can_bus::canopen::{Address, ErrorNames};
use crate::devices::Vocabulary;
use crate::devices::ap10::{ControlBit, Fault, StatusBit};

/// The words of the AP10.
pub const VOCABULARY: Vocabulary = Vocabulary {
    name: "AP10",
    objects: OBJECTS,
    complete: true,
    parameter: |_| None,
    choice: |_, _| None,
    bits,
    errors: ERRORS,
};

/// What it calls its errors.
pub(super) const ERRORS: ErrorNames = ErrorNames { emcy, ..ErrorNames::CIA_301 };

fn emcy(code: u16, more: [u8; 5]) -> Option<&'static str> {
    Some(match code {
        ERROR_PASSIVE => "CAN error passive",
        BUS_OFF_RECOVERED => "recovered from bus off",
        other => match Fault::ALL.into_iter().find(|fault| code_of(*fault) == other) {
            Some(fault) => fault.text(),
            None => return (ErrorNames::CIA_301.emcy)(other, more),
        },
    })
}

/// 5F1Bh:2 in alpha-numeric mode.
const ALPHANUMERIC: i64 = 3;

fn bits(at: Address, mode: i64) -> Option<[&'static str; 16]> {
    let mut names = [""; 16];
    let mut put = |number: u8, text: &'static str| {
        if let Some(name) = names.get_mut(usize::from(number)) {
            *name = text;
        }
    };
    match at.pair() {
        (0x5F0C, 0) => ControlBit::ALL.iter().for_each(|bit| put(*bit as u8, bit.name())),
        (0x5F19, 0) => {
            StatusBit::ALL.iter().for_each(|bit| put(*bit as u8, bit.name()));
            if mode == ALPHANUMERIC {
                put(StatusBit::ACKNOWLEDGED_1 as u8, "set point 1 acknowledged");
                put(StatusBit::ACKNOWLEDGED_2 as u8, "set point 2 acknowledged");
            }
        }
        (0.., 0..) => return None,
    }
    Some(names)
}
