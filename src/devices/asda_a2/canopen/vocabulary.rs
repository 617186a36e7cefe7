//! What the ASDA-A2 calls what it says on CANopen.

use super::objects;
use crate::can_bus::canopen::ErrorNames;
use crate::devices::Vocabulary;
use crate::devices::asda_a2::{Alarm, Level};
use crate::devices::vocabulary::{cia_402_bits, cia_402_choice};

/// The words of the ASDA-A2 that follows CiA 402.
pub const VOCABULARY: Vocabulary = Vocabulary {
    name: "ASDA-A2",
    objects: objects::of(Level::Full, true),
    complete: true,
    parameter: |_| None,
    choice: cia_402_choice,
    bits: cia_402_bits,
    errors: ERRORS,
};

/// What it calls its errors.
pub(super) const ERRORS: ErrorNames = ErrorNames { emcy, ..ErrorNames::CIA_301 };

/// Several alarms share a code; the number on the panel follows it.
fn emcy(code: u16, more: [u8; 5]) -> Option<&'static str> {
    let [low, high, ..] = more;
    let alarm = Alarm::of(u16::from_le_bytes([low, high])).filter(|alarm| alarm.code() == code);
    alarm.map(Alarm::text).or_else(|| (ErrorNames::CIA_301.emcy)(code, more))
}
