//! Reading and writing the parameters of a unit, and what a write did.

use super::{Event, Unit, Writer};
use crate::devices::ag03::drive::Settings;
use crate::devices::ag03::param::{
    Effect, Lengths, ParamError, Parameter, Pnu, Reading, Subindex, Value, Write, WriteContext,
};

/// What a write did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub struct Written {
    /// What was written.
    pub write: Write,
    /// What it changed.
    pub effect: Effect,
    /// The value before, of a stored parameter.
    pub before: Option<i32>,
    /// It must be safe in the EEPROM before it is acknowledged: wait for what
    /// [`Unit::handle_stored`](super::Unit::handle_stored) says.
    pub waits: bool,
}

/// A parameter that each bus shows in its own way.
#[derive(Clone, Copy, Debug)]
pub(crate) enum OfBus {
    /// PNU 918.
    Address,
    /// PNU 945.
    FaultBuffer,
    /// PNU 1020.
    SystemStatus,
    /// PNU 1031.
    GeneralStatus,
}

impl Unit {
    /// Reads a parameter by its PROFIDRIVE number. `show` is asked for what only the bus knows: its address and the words
    /// in which it puts the [status](Unit::status).
    ///
    /// # Errors
    /// As [`Store::read`](crate::devices::ag03::param::Store::read).
    pub(crate) fn read(
        &self,
        pnu: Pnu,
        element: Option<Subindex>,
        show: impl FnOnce(OfBus, Subindex) -> i32,
    ) -> Result<Value, ParamError> {
        self.store.read(pnu, element, |reading, element| {
            self.measure(reading).unwrap_or_else(|of_bus| show(of_bus, element))
        })
    }

    /// What the unit itself measures and counts.
    ///
    /// # Errors
    /// The bus knows how it is shown.
    pub(crate) fn measure(&self, reading: Reading) -> Result<i32, OfBus> {
        let measured = self.drive.measured();
        Ok(match reading {
            Reading::FaultCount => self.drive.faults().count().into(),
            Reading::Temperature => measured.temperature.into(),
            Reading::MotorCurrent => measured.current.into(),
            Reading::Position => self.status.position,
            Reading::OutputStageVoltage => measured.output_supply.into(),
            Reading::ControlVoltage => measured.control_supply.into(),
            Reading::BatteryVoltage => measured.battery.into(),
            Reading::HardwareVersion => self.store.gear().hardware_version().into(),
            Reading::SoftwareVersion => self.store.identity().software_version.into(),
            Reading::SerialNumber => self.store.identity().serial_number.cast_signed(),
            Reading::ProductionDate => self.store.identity().production_date.cast_signed(),
            Reading::Address => return Err(OfBus::Address),
            Reading::FaultBuffer => return Err(OfBus::FaultBuffer),
            Reading::SystemStatus => return Err(OfBus::SystemStatus),
            Reading::GeneralStatus => return Err(OfBus::GeneralStatus),
        })
    }

    /// Writes without the bus, by its rules: nothing waits for the EEPROM.
    ///
    /// # Errors
    /// As [`Store::apply`](crate::devices::ag03::param::Store::apply); nothing is changed then.
    pub fn write(&mut self, write: Write) -> Result<Written, ParamError> {
        self.execute(write, Writer::Host)
    }

    /// Writes for a bus that acknowledges only what is safe: see [`Written::waits`].
    ///
    /// # Errors
    /// As [`Store::apply`](crate::devices::ag03::param::Store::apply); nothing is changed then.
    pub(crate) fn write_safely(&mut self, write: Write) -> Result<Written, ParamError> {
        self.execute(write, Writer::Bus)
    }

    /// What the operating state allows to be written now.
    pub(crate) const fn write_context(&self) -> WriteContext {
        WriteContext { moving: self.status.moving, job_active: self.status.job_active }
    }

    fn execute(&mut self, write: Write, by: Writer) -> Result<Written, ParamError> {
        let context = self.write_context();
        let (before, memory) = (self.store.clone(), self.drive.memory());
        let effect = self.store.apply(write, &context)?;
        match effect {
            Effect::None => {}
            Effect::SettingsChanged => self.settings = Settings::read(&self.store),
            Effect::ClearFaults => self.drive.clear_faults(),
            // Not during a travel job: the store has refused it by the same status.
            Effect::Calibrate => {
                let value = self.store.value(Parameter::CalibrationValue);
                let _refused = self.drive.calibrate(value);
            }
        }
        self.parameters_acted |= effect != Effect::None;
        if effect != Effect::None {
            self.refresh_status();
        }
        let before_value = match write {
            Write::Set(parameter, _) => Some(before.value(parameter)),
            Write::Load(_) | Write::ClearFaults | Write::Calibrate => None,
        };
        let lengths = Lengths::of_spindle_pitch(self.settings.word(Parameter::SpindlePitch).into());
        self.events.push(Event::Written { write, before: before_value, effect, lengths, by });
        let waits = self.note_write(write, &before, &memory, by == Writer::Bus);
        Ok(Written { write, effect, before: before_value, waits })
    }
}
