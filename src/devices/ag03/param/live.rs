//! What a drive shows that needs no more than this: for tests of what is made of it.

use super::{Reading, Subindex};

/// The fault buffer, newest first.
const FAULTS: &[u8; 10] = b"GFEABCD\0\0\0";

const SHOWN: [(Reading, i32); 10] = [
    (Reading::Address, 5),
    (Reading::FaultCount, 7),
    (Reading::SystemStatus, 0x2948),
    (Reading::Temperature, -25),
    (Reading::MotorCurrent, 1234),
    (Reading::GeneralStatus, 0x0010),
    (Reading::Position, -5000),
    (Reading::OutputStageVoltage, 240),
    (Reading::ControlVoltage, 238),
    (Reading::BatteryVoltage, 361),
];

/// What the drive shows; the store knows the rest.
pub(crate) fn live(reading: Reading, element: Subindex) -> i32 {
    if reading == Reading::FaultBuffer {
        return FAULTS[usize::from(element.0)].into();
    }
    let shown = SHOWN.into_iter().find(|(shown, _)| *shown == reading);
    shown.map(|(_, number)| number).unwrap_or_else(|| panic!("the store knows {reading:?}"))
}
