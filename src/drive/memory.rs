//! What the drive keeps while it is switched off.

use super::motion::Motion;
use super::{Drive, FaultBuffer, Inputs};

/// What the drive keeps in its EEPROM besides parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Memory {
    /// Fault buffer and fault counter, PNU 945 and 952.
    pub faults: FaultBuffer,
    /// Shaft angle at the user position 0, in increments; calibration sets it.
    pub zero: f64,
}

impl Inputs {
    /// The inputs with the control supplied with 24 V, or not at all.
    #[must_use]
    pub const fn with_control_supply(mut self, present: bool) -> Self {
        self.control_supply = if present { 24.0 } else { 0.0 };
        self
    }
}

impl Drive {
    /// Whether the control is supplied by the inputs as they are set.
    pub fn is_supplied(&self) -> bool {
        self.supplies.control
    }

    /// What the EEPROM holds besides parameters.
    pub fn memory(&self) -> Memory {
        Memory { faults: self.faults.clone(), zero: self.zero }
    }

    /// Takes over what the EEPROM holds. The shaft does not turn for it; the position it has may be another.
    pub fn set_memory(&mut self, memory: Memory) {
        let Memory { faults, zero } = memory;
        self.faults = faults;
        self.zero = zero;
        self.settled = false;
    }

    /// The angle of the output shaft in increments, which the battery-buffered encoder always knows.
    pub fn shaft(&self) -> f64 {
        self.shaft_position()
    }

    /// Puts the shaft at an angle in increments, at rest: where it is found when the drive is made.
    pub fn set_shaft(&mut self, angle: f64) {
        self.motion = Motion::at(angle);
        self.settled = false;
    }
}
