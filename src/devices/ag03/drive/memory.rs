//! What the drive keeps while it is switched off.

use super::motion::Motion;
use super::{Drive, FaultBuffer, Inputs};

/// What the drive keeps besides parameters: in its EEPROM faults and zero, in its battery-buffered encoder the shaft.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Memory {
    /// Fault buffer and fault counter.
    pub faults: FaultBuffer,
    /// Shaft angle at the user position 0, in increments; calibration sets it.
    pub zero: f64,
    /// Angle of the output shaft in increments.
    pub shaft: f64,
}

impl Inputs {
    /// The inputs with the control supplied with 24 V, or not at all.
    #[must_use]
    pub(crate) const fn with_control_supply(mut self, present: bool) -> Self {
        self.control_supply = if present { 24.0 } else { 0.0 };
        self
    }
}

impl Drive {
    /// Whether the control is supplied by the inputs as they are set.
    pub(crate) fn is_supplied(&self) -> bool {
        self.supplies.control
    }

    /// What it would keep if it were switched off now.
    pub(crate) fn memory(&self) -> Memory {
        Memory { faults: self.faults.clone(), zero: self.zero, shaft: self.shaft() }
    }

    /// Puts a drive that was just made where it was left: its shaft at rest, its faults in the buffer.
    pub(crate) fn recall(&mut self, memory: Memory) {
        let Memory { faults, zero, shaft } = memory;
        self.motion = Motion::at(shaft);
        self.set_zero(zero);
        self.faults = faults;
    }

    /// Sets the shaft angle at the user position 0, in increments. The shaft does not turn for it; the position may be
    /// another.
    pub(crate) fn set_zero(&mut self, zero: f64) {
        self.zero = zero;
        self.settled = false;
    }

    /// Undoes [`Drive::clear_faults`], unless a fault was entered since: that is not thrown away.
    pub(crate) fn restore_faults(&mut self, before: FaultBuffer) {
        if self.faults == FaultBuffer::default() {
            self.faults = before;
        }
    }

    /// The angle of the output shaft in increments, which the battery-buffered encoder always knows.
    pub(crate) fn shaft(&self) -> f64 {
        self.shaft_position()
    }
}
