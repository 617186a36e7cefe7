//! What a parameter can be tied to.

use core::fmt;

use super::{Drive, Event, Fault, FaultBuffer};

macro_rules! quantities {
    ($($(#[$doc:meta])* $variant:ident = $name:literal, $unit:literal, $settable:literal;)*) => {
        /// A quantity of the drive that a parameter shows, and sets if it is writable.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Quantity {
            $($(#[$doc])* $variant,)*
        }

        impl Quantity {
            /// Every quantity.
            pub const ALL: &'static [Self] = &[$(Self::$variant),*];

            /// Its name in a table of parameters.
            pub(crate) const fn name(self) -> &'static str {
                match self { $(Self::$variant => $name,)* }
            }

            /// The unit it is counted in; empty for a number.
            pub(crate) const fn unit(self) -> &'static str {
                match self { $(Self::$variant => $unit,)* }
            }

            /// Whether it can be set.
            pub(crate) const fn is_settable(self) -> bool {
                match self { $(Self::$variant => $settable,)* }
            }
        }
    };
}

impl Quantity {
    /// Whether it is a setting, which a drive keeps while it is switched off: nothing of the machine, no fault and no
    /// warning.
    pub(crate) const fn is_kept(self) -> bool {
        let is_event = matches!(self, Self::Fault | Self::FaultCount | Self::Warning);
        self.is_settable() && !is_event && !matches!(self, Self::Load | Self::RunUp)
    }
}

quantities! {
    /// The speed of a setpoint of 4000h.
    ReferenceSpeed = "reference-speed", "rpm", true;
    /// The highest speed.
    MaxSpeed = "max-speed", "rpm", true;
    /// The time from standstill to the reference speed.
    RampUp = "ramp-up-time", "s", true;
    /// The time from the reference speed to standstill.
    RampDown = "ramp-down-time", "s", true;
    /// The same with OFF3.
    QuickStop = "quick-stop-time", "s", true;
    /// Inching speed 1.
    Inching1 = "inching-speed-1", "rpm", true;
    /// Inching speed 2.
    Inching2 = "inching-speed-2", "rpm", true;
    /// The speed from which on "speed reached" is shown.
    ComparisonSpeed = "comparison-speed", "rpm", true;
    /// The current at rated torque.
    RatedCurrent = "rated-current", "A", true;
    /// The torque that the machine takes.
    Load = "load", "%", true;
    /// The inertia, as the time to the reference speed at rated torque.
    RunUp = "run-up-time", "s", true;
    /// What the ramp generator gives.
    SetpointSpeed = "setpoint-speed", "rpm", false;
    /// The speed of the shaft.
    ActualSpeed = "actual-speed", "rpm", false;
    /// The torque of the motor.
    Torque = "torque", "%", false;
    /// The current of the motor.
    Current = "current", "A", false;
    /// The number of the first fault not acknowledged; a write of another number than 0 raises it.
    Fault = "fault", "", true;
    /// An array of 64: the fault buffer.
    FaultBuffer = "fault-buffer", "", false;
    /// The fault message counter.
    FaultMessages = "fault-messages", "", false;
    /// The number of faults; writing 0 clears the buffer.
    FaultCount = "fault-count", "", true;
    /// The warning that was raised; a write raises it, 0 ends it.
    Warning = "warning", "", true;
    /// An array of 8: the last warnings.
    WarningBuffer = "warning-buffer", "", false;
}

/// Why a quantity is not set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SetError {
    /// It can only be read.
    ReadOnly,
    /// The value makes no sense for it.
    Value,
}

impl Quantity {
    /// The quantity of this name.
    pub(crate) fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|quantity| quantity.name() == name)
    }

    /// How many elements it has; `None`: it is a single value.
    pub(crate) const fn elements(self) -> Option<u8> {
        match self {
            Self::FaultBuffer => Some(FaultBuffer::LEN),
            Self::WarningBuffer => Some(8),
            Self::ReferenceSpeed
            | Self::MaxSpeed
            | Self::RampUp
            | Self::RampDown
            | Self::QuickStop
            | Self::Inching1
            | Self::Inching2
            | Self::ComparisonSpeed
            | Self::RatedCurrent
            | Self::Load
            | Self::RunUp
            | Self::SetpointSpeed
            | Self::ActualSpeed
            | Self::Torque
            | Self::Current
            | Self::Fault
            | Self::FaultMessages
            | Self::FaultCount
            | Self::Warning => None,
        }
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl Drive {
    /// A quantity in its unit; of an array the element from 1 on, 0 outside of it.
    pub fn quantity(&self, quantity: Quantity, element: u8) -> f64 {
        let Self { settings, motion, faults, warnings, .. } = self;
        match quantity {
            Quantity::ReferenceSpeed => settings.reference_speed,
            Quantity::MaxSpeed => settings.max_speed,
            Quantity::RampUp => settings.ramp_up,
            Quantity::RampDown => settings.ramp_down,
            Quantity::QuickStop => settings.quick_stop,
            Quantity::Inching1 => settings.inching_1,
            Quantity::Inching2 => settings.inching_2,
            Quantity::ComparisonSpeed => settings.comparison_speed,
            Quantity::RatedCurrent => settings.rated_current,
            Quantity::Load => settings.load,
            Quantity::RunUp => settings.run_up,
            Quantity::SetpointSpeed => motion.ramp,
            Quantity::ActualSpeed => motion.speed,
            Quantity::Torque => motion.torque * 100.0,
            Quantity::Current => motion.torque.abs() * settings.rated_current,
            Quantity::Fault => f64::from(faults.number(1).unwrap_or(0)),
            Quantity::FaultBuffer => f64::from(faults.number(element).unwrap_or(0)),
            Quantity::FaultMessages => f64::from(faults.messages()),
            Quantity::FaultCount => f64::from(faults.count()),
            Quantity::Warning => f64::from(warnings.raised),
            Quantity::WarningBuffer => {
                f64::from(element.checked_sub(1).and_then(|before| warnings.number(before)).unwrap_or(0))
            }
        }
    }

    /// Sets a quantity, in its unit.
    ///
    /// # Errors
    /// [`SetError`]; nothing is changed then.
    pub(crate) fn set_quantity(&mut self, quantity: Quantity, value: f64) -> Result<(), SetError> {
        if !value.is_finite() {
            return Err(SetError::Value);
        }
        let above_zero = value > 0.0;
        let from_zero = value >= 0.0;
        let settings = &mut self.settings;
        let (setting, allowed) = match quantity {
            Quantity::ReferenceSpeed => (&mut settings.reference_speed, above_zero),
            Quantity::MaxSpeed => (&mut settings.max_speed, above_zero),
            Quantity::RampUp => (&mut settings.ramp_up, from_zero),
            Quantity::RampDown => (&mut settings.ramp_down, from_zero),
            Quantity::QuickStop => (&mut settings.quick_stop, from_zero),
            Quantity::Inching1 => (&mut settings.inching_1, true),
            Quantity::Inching2 => (&mut settings.inching_2, true),
            Quantity::ComparisonSpeed => (&mut settings.comparison_speed, from_zero),
            Quantity::RatedCurrent => (&mut settings.rated_current, from_zero),
            Quantity::Load => (&mut settings.load, from_zero),
            Quantity::RunUp => (&mut settings.run_up, above_zero),
            Quantity::Fault => {
                let number = whole(value)?;
                if number != 0 {
                    self.raise(Fault::Raised(number));
                }
                return Ok(());
            }
            Quantity::Warning => {
                let number = whole(value)?;
                self.raise_warning(number);
                return Ok(());
            }
            Quantity::FaultCount if value == 0.0 => {
                self.faults.clear();
                return Ok(());
            }
            Quantity::FaultCount => return Err(SetError::Value),
            Quantity::SetpointSpeed
            | Quantity::ActualSpeed
            | Quantity::Torque
            | Quantity::Current
            | Quantity::FaultBuffer
            | Quantity::FaultMessages
            | Quantity::WarningBuffer => return Err(SetError::ReadOnly),
        };
        if !allowed {
            return Err(SetError::Value);
        }
        let before = core::mem::replace(setting, value);
        self.at_rest = false;
        if quantity == Quantity::Load && before != value {
            self.tell(Event::Load { from: before, to: value });
        }
        Ok(())
    }
}

/// A number of a fault or a warning.
fn whole(value: f64) -> Result<u16, SetError> {
    if !(0.0..=65535.0).contains(&value) {
        return Err(SetError::Value);
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the range")]
    let number = value as u16;
    Ok(number)
}
