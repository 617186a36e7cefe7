//! The values of one drive, and who may change them when.

use super::entry::{DefaultSet, Entry, Kind, LOAD_COMMANDS, Range, Reading, Setting, WritableWhen};
use super::table::{self, Parameter};
use super::{
    Effect, FAULT_BUFFER_LEN, Gear, Live, Model, NotNow, ParamError, Pnu, Quirks, Subindex, Value, Width,
    WriteContext,
};

/// All stored parameters of one drive.
///
/// [`read`](Self::read) and [`write`](Self::write) are what a bus does: by number, checked like the device
/// checks. [`value`](Self::value) and [`set`](Self::set) are for programs: by name, in every operating state.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Store {
    model: Model,
    gear: Gear,
    identity: Identity,
    quirks: Quirks,
    values: [i32; Parameter::COUNT],
}

impl Store {
    /// Every parameter at its default.
    pub fn new(model: Model, gear: Gear) -> Self {
        let mut store = Self {
            model,
            gear,
            identity: Identity::of(model),
            quirks: Quirks::default(),
            values: [0; Parameter::COUNT],
        };
        store.load_defaults(DefaultSet::All);
        store
    }

    /// The drive's model.
    pub const fn model(&self) -> Model {
        self.model
    }

    /// The drive's gear.
    pub const fn gear(&self) -> Gear {
        self.gear
    }

    /// What the factory fixed.
    pub const fn identity(&self) -> Identity {
        self.identity
    }

    /// Makes it the drive with another serial number, date or software.
    pub const fn set_identity(&mut self, identity: Identity) {
        self.identity = identity;
    }

    /// Which ranges hold where the manuals contradict themselves.
    pub const fn set_quirks(&mut self, quirks: Quirks) {
        self.quirks = quirks;
    }

    /// The value of a stored parameter, in the units of the table (signed where the table says so).
    #[expect(clippy::indexing_slicing, reason = "one slot per variant")]
    pub const fn value(&self, parameter: Parameter) -> i32 {
        self.values[parameter as usize]
    }

    /// Stores a value whatever the drive is doing.
    ///
    /// # Errors
    /// [`ParamError::UnknownParameter`] if the model has no such parameter, [`ParamError::OutOfRange`]. The
    /// old value stays then.
    pub fn set(&mut self, parameter: Parameter, value: i32) -> Result<(), ParamError> {
        self.entry(parameter.entry().pnu)?;
        self.check_range(parameter, value)?;
        self.put(parameter, value);
        Ok(())
    }

    /// Loads defaults; the bus address and the [`Identity`] are no part of them.
    pub fn load_defaults(&mut self, set: DefaultSet) {
        for parameter in Parameter::all() {
            let setting = parameter.setting();
            if set.contains(setting.group) {
                self.put(parameter, setting.default);
            }
        }
    }

    /// What switching the drive off and on does: values the EEPROM does not keep return to their defaults.
    pub fn power_on(&mut self) {
        for parameter in Parameter::all() {
            if !parameter.entry().persistent {
                self.put(parameter, parameter.setting().default);
            }
        }
    }

    /// The entry of a number in the table of this model.
    ///
    /// # Errors
    /// [`ParamError::UnknownParameter`].
    pub fn entry(&self, pnu: Pnu) -> Result<&'static Entry, ParamError> {
        table::entry(self.model, pnu).ok_or(ParamError::UnknownParameter { got: pnu })
    }

    /// How many elements an array has.
    ///
    /// # Errors
    /// [`ParamError::UnknownParameter`], [`ParamError::NotAnArray`].
    pub fn element_count(&self, pnu: Pnu) -> Result<u8, ParamError> {
        self.entry(pnu)?.elements.ok_or(ParamError::NotAnArray)
    }

    /// Reads a parameter, or one element of an array.
    ///
    /// The load command (PNU 970) reads as 0 (`ag03.md` C-17).
    ///
    /// # Errors
    /// [`ParamError::UnknownParameter`], [`ParamError::IsArray`] and [`ParamError::NotAnArray`] if an element
    /// is missing or too much, [`ParamError::SubindexOutOfRange`].
    pub fn read(&self, pnu: Pnu, element: Option<Subindex>, live: &Live) -> Result<Value, ParamError> {
        let entry = self.entry(pnu)?;
        check_array(entry, element)?;
        match entry.kind {
            Kind::Setting(setting) => Ok(Value::of(entry.width, self.value(setting.parameter))),
            Kind::Reading(reading) => self.show(reading, element, live),
            Kind::LoadParameterSet => Ok(Value::Word(0)),
        }
    }

    /// Writes a parameter as a bus does. A refused write changes nothing.
    ///
    /// # Errors
    /// In this order: [`ParamError::UnknownParameter`], [`ParamError::IsArray`] or
    /// [`ParamError::NotAnArray`], [`ParamError::ReadOnly`], [`ParamError::WrongWidth`],
    /// [`ParamError::OutOfRange`], and last [`ParamError::NotNow`], so that a write that can never succeed
    /// does not ask the user to wait.
    pub fn write(
        &mut self,
        pnu: Pnu,
        element: Option<Subindex>,
        value: Value,
        context: &WriteContext,
    ) -> Result<Effect, ParamError> {
        let entry = self.entry(pnu)?;
        check_array(entry, element)?;
        match entry.kind {
            Kind::Reading(_) => Err(ParamError::ReadOnly),
            Kind::Setting(setting) => {
                let number = number(entry, value)?;
                self.check_range(setting.parameter, number)?;
                check_state(self.writable(setting), context)?;
                if self.quirks.calibrate_by_value && setting.parameter == Parameter::CalibrationValue {
                    self.check_calibration(context)?;
                    self.put(setting.parameter, number);
                    return Ok(Effect::Calibrate);
                }
                Ok(self.changed_by(|store| store.put(setting.parameter, number)))
            }
            Kind::LoadParameterSet => self.load(number(entry, value)?, context),
        }
    }

    /// PNU 970 (`ag03.md` 3.3, permissions 3.4).
    fn load(&mut self, command: i32, context: &WriteContext) -> Result<Effect, ParamError> {
        let set = match command {
            1 => DefaultSet::All,
            2 => DefaultSet::Standard,
            3 => DefaultSet::Controller,
            4 => return Ok(Effect::ClearFaults),
            5 => return self.check_calibration(context).map(|()| Effect::Calibrate),
            got => return Err(out_of_range(LOAD_COMMANDS, got)),
        };
        check_state(WritableWhen::Standstill, context)?;
        Ok(self.changed_by(|store| store.load_defaults(set)))
    }

    /// When a setting may be written under the quirks.
    fn writable(&self, setting: Setting) -> WritableWhen {
        if self.quirks.d_pos_without_job && setting.parameter == Parameter::DPos {
            WritableWhen::NoJob
        } else {
            setting.writable
        }
    }

    /// "Only when no travel job is active" (manual chapter 3); a shaft that runs out: C-39.
    fn check_calibration(&self, context: &WriteContext) -> Result<(), ParamError> {
        check_state(WritableWhen::NoJob, context)?;
        if self.quirks.calibrate_while_moving {
            Ok(())
        } else {
            check_state(WritableWhen::Standstill, context)
        }
    }

    fn changed_by(&mut self, change: impl FnOnce(&mut Self)) -> Effect {
        let before = self.values;
        change(self);
        if self.values == before { Effect::None } else { Effect::SettingsChanged }
    }

    fn check_range(&self, parameter: Parameter, got: i32) -> Result<(), ParamError> {
        let mut range = parameter.setting().limits.range(self.model, self.gear);
        let from_1 = match (parameter, self.model) {
            (Parameter::ControllerI, Model::Ag03_1) => self.quirks.i_gain_from_1,
            (Parameter::APos | Parameter::ARot | Parameter::AInch, Model::Ag03) => {
                self.quirks.acceleration_from_1
            }
            (_others, Model::Ag03 | Model::Ag03_1) => false,
        };
        range.low = if from_1 { 1 } else { range.low };
        if range.contains(got) { Ok(()) } else { Err(out_of_range(range, got)) }
    }

    #[expect(clippy::indexing_slicing, reason = "one slot per variant")]
    const fn put(&mut self, parameter: Parameter, value: i32) {
        self.values[parameter as usize] = value;
    }

    fn show(&self, reading: Reading, element: Option<Subindex>, live: &Live) -> Result<Value, ParamError> {
        Ok(match reading {
            Reading::Address => Value::Word(u16::from(live.address)),
            Reading::FaultBuffer => Value::Word(u16::from(fault(live, element)?)),
            Reading::FaultCount => Value::Word(live.fault_count),
            Reading::HardwareVersion => Value::Word(self.gear.hardware_version()),
            Reading::SoftwareVersion => Value::Word(self.identity.software_version),
            Reading::SystemStatus => Value::Word(live.system_status),
            Reading::Temperature => Value::Word(live.temperature.cast_unsigned()),
            Reading::MotorCurrent => Value::Word(live.motor_current.cast_unsigned()),
            Reading::GeneralStatus => Value::Word(live.general_status),
            Reading::SerialNumber => Value::Double(self.identity.serial_number),
            Reading::ProductionDate => Value::Double(self.identity.production_date),
            Reading::Position => Value::Double(live.position.cast_unsigned()),
            Reading::OutputStageVoltage => Value::Word(live.output_stage_voltage),
            Reading::ControlVoltage => Value::Word(live.control_voltage),
            Reading::BatteryVoltage => Value::Word(live.battery_voltage),
        })
    }
}

/// What the factory fixed in a drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Identity {
    /// PNU 1033.
    pub serial_number: u32,
    /// PNU 1034 in BCD: 0x15072009 is 15 July 2009.
    pub production_date: u32,
    /// PNU 965: 0x0101 is 1.01.
    pub software_version: u16,
}

impl Identity {
    /// Serial number and date are the examples of the manual (PNU 1033, 1034). The software is 1.01 for an
    /// AG03/1, the manual's example, and 3.00 for an AG03, the first its manual holds for.
    pub const fn of(model: Model) -> Self {
        let software_version = match model {
            Model::Ag03 => 0x0300,
            Model::Ag03_1 => 0x0101,
        };
        Self { serial_number: 1_234_567, production_date: 0x1507_2009, software_version }
    }
}

const fn out_of_range(Range { low, high }: Range, got: i32) -> ParamError {
    ParamError::OutOfRange { low, high, got }
}

fn check_array(entry: &Entry, element: Option<Subindex>) -> Result<(), ParamError> {
    match (entry.elements, element) {
        (None, None) | (Some(_), Some(_)) => Ok(()),
        (Some(count), None) => Err(ParamError::IsArray { count }),
        (None, Some(_)) => Err(ParamError::NotAnArray),
    }
}

fn check_state(writable: WritableWhen, context: &WriteContext) -> Result<(), ParamError> {
    match writable {
        WritableWhen::Standstill if context.moving => Err(ParamError::NotNow(NotNow::Moving)),
        WritableWhen::NoJob if context.job_active => Err(ParamError::NotNow(NotNow::JobActive)),
        WritableWhen::Always | WritableWhen::Standstill | WritableWhen::NoJob => Ok(()),
    }
}

/// The number a value of the right width stands for: writable words are unsigned, double words signed.
fn number(entry: &Entry, value: Value) -> Result<i32, ParamError> {
    match (entry.width, value) {
        (Width::Word, Value::Word(word)) => Ok(i32::from(word)),
        (Width::Double, Value::Double(double)) => Ok(double.cast_signed()),
        (Width::Word, Value::Double(_)) | (Width::Double, Value::Word(_)) => {
            Err(ParamError::WrongWidth { expected: entry.width, got: value.width() })
        }
    }
}

fn fault(live: &Live, element: Option<Subindex>) -> Result<u8, ParamError> {
    let count = FAULT_BUFFER_LEN;
    let got = element.ok_or(ParamError::IsArray { count })?;
    live.fault_buffer.get(usize::from(got.0)).copied().ok_or(ParamError::SubindexOutOfRange { count, got })
}

#[cfg(test)]
mod tests;
