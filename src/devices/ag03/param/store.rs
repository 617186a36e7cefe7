//! The values of one drive, and who may change them when.

use super::entry::{DefaultSet, Entry, Kind, LOAD_COMMANDS, Range, WritableWhen};
use super::table::{self, Parameter, Reading};
use super::{
    Effect, Gear, Model, NotNow, ParamError, Pnu, Quirks, Subindex, Value, Width, Write, WriteContext,
};

/// All stored parameters of one drive.
///
/// [`read`](Self::read) and [`write`](Self::write) are what PROFIDRIVE does: by number, checked like the device checks.
/// [`apply`](Self::apply) is what every bus does once it knows what a write means. [`value`](Self::value) and
/// [`set`](Self::set) are for programs: by name, in every operating state.
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
    pub(crate) const fn model(&self) -> Model {
        self.model
    }

    /// The drive's gear.
    pub(crate) const fn gear(&self) -> Gear {
        self.gear
    }

    /// What the factory fixed.
    pub(crate) const fn identity(&self) -> Identity {
        self.identity
    }

    /// Makes it the drive with another serial number, date or software.
    pub const fn set_identity(&mut self, identity: Identity) {
        self.identity = identity;
    }

    /// Which ranges hold where the manuals contradict themselves.
    pub(crate) const fn set_quirks(&mut self, quirks: Quirks) {
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
        self.check(parameter, value)?;
        self.put(parameter, value);
        Ok(())
    }

    /// Loads defaults; the bus address and the [`Identity`] are no part of them.
    pub(crate) fn load_defaults(&mut self, set: DefaultSet) {
        for parameter in Parameter::all() {
            let setting = parameter.setting();
            if set.contains(setting.group) {
                self.put(parameter, setting.default);
            }
        }
    }

    /// What switching the drive off and on does: values the EEPROM does not keep return to their defaults.
    pub(crate) fn power_on(&mut self) {
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

    /// Reads a parameter, or one element of an array.
    ///
    /// The load command (PNU 970) reads as 0 (`ag03.md` C-17). `show` is asked for what only the drive or the bus knows:
    /// the bits of the value, of an array those of the element.
    ///
    /// # Errors
    /// [`ParamError::UnknownParameter`], [`ParamError::IsArray`] and [`ParamError::NotAnArray`] if an element
    /// is missing or too much, [`ParamError::SubindexOutOfRange`].
    pub fn read(
        &self,
        pnu: Pnu,
        element: Option<Subindex>,
        show: impl FnOnce(Reading, Subindex) -> i32,
    ) -> Result<Value, ParamError> {
        let entry = self.entry(pnu)?;
        check_array(entry, element)?;
        let element = element.unwrap_or(Subindex(0));
        if let Some(count) = entry.elements.filter(|&count| element.0 >= count) {
            return Err(ParamError::SubindexOutOfRange { count, got: element });
        }
        let number = match entry.kind {
            Kind::Setting(setting) => self.value(setting.parameter),
            Kind::Reading(Reading::HardwareVersion) => self.gear.hardware_version().into(),
            Kind::Reading(Reading::SoftwareVersion) => self.identity.software_version.into(),
            Kind::Reading(Reading::SerialNumber) => self.identity.serial_number.cast_signed(),
            Kind::Reading(Reading::ProductionDate) => self.identity.production_date.cast_signed(),
            Kind::Reading(reading) => show(reading, element),
            Kind::LoadParameterSet => 0,
        };
        Ok(Value::of(entry.width, number))
    }

    /// Writes a parameter by its number, as PROFIDRIVE does: [`Store::meaning`], then [`Store::apply`]. A refused write
    /// changes nothing.
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
        self.meaning(pnu, element, value).and_then(|write| self.apply(write, context))
    }

    /// What a write by number means, as far as number, element and width tell.
    ///
    /// # Errors
    /// As [`Store::write`] up to the width, and [`ParamError::OutOfRange`] for a command that PNU 970 does not have.
    pub fn meaning(&self, pnu: Pnu, element: Option<Subindex>, value: Value) -> Result<Write, ParamError> {
        let entry = self.entry(pnu)?;
        check_array(entry, element)?;
        match entry.kind {
            Kind::Reading(_) => Err(ParamError::ReadOnly),
            Kind::Setting(setting) => Ok(Write::Set(setting.parameter, number(entry, value)?)),
            // `ag03.md` 3.3
            Kind::LoadParameterSet => match number(entry, value)? {
                1 => Ok(Write::Load(DefaultSet::All)),
                2 => Ok(Write::Load(DefaultSet::Standard)),
                3 => Ok(Write::Load(DefaultSet::Controller)),
                4 => Ok(Write::ClearFaults),
                5 => Ok(Write::Calibrate),
                got => Err(out_of_range(LOAD_COMMANDS, got)),
            },
        }
    }

    /// Executes a write if range and operating state (`ag03.md` 3.4) allow it; else nothing changes.
    ///
    /// # Errors
    /// [`ParamError::UnknownParameter`] if the model has no such parameter, [`ParamError::OutOfRange`],
    /// [`ParamError::NotNow`].
    pub fn apply(&mut self, write: Write, context: &WriteContext) -> Result<Effect, ParamError> {
        match write {
            Write::Set(parameter, value) => {
                self.check(parameter, value)?;
                check_state(self.writable(parameter), context)?;
                if self.quirks.calibrate_by_value && parameter == Parameter::CalibrationValue {
                    self.check_calibration(context)?;
                    self.put(parameter, value);
                    return Ok(Effect::Calibrate);
                }
                Ok(self.changed_by(|store| store.put(parameter, value)))
            }
            Write::Load(set) => {
                check_state(WritableWhen::Standstill, context)?;
                Ok(self.changed_by(|store| store.load_defaults(set)))
            }
            Write::ClearFaults => Ok(Effect::ClearFaults),
            Write::Calibrate => self.check_calibration(context).map(|()| Effect::Calibrate),
        }
    }

    /// The values that a write to a stored parameter may have.
    pub fn range(&self, parameter: Parameter) -> Range {
        parameter.setting().limits.range(self.model, self.gear, self.quirks)
    }

    /// The values that a write to a parameter of the table may have; `None` if it is read-only.
    pub(crate) fn range_of(&self, entry: &Entry) -> Option<Range> {
        entry.range(self.model, self.gear, self.quirks)
    }

    /// When a setting may be written under the quirks.
    fn writable(&self, parameter: Parameter) -> WritableWhen {
        if self.quirks.d_pos_without_job && parameter == Parameter::DPos {
            WritableWhen::NoJob
        } else {
            parameter.setting().writable
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

    fn check(&self, parameter: Parameter, got: i32) -> Result<(), ParamError> {
        self.entry(parameter.entry().pnu)?;
        let range = self.range(parameter);
        if range.contains(got) { Ok(()) } else { Err(out_of_range(range, got)) }
    }

    #[expect(clippy::indexing_slicing, reason = "one slot per variant")]
    pub(crate) const fn put(&mut self, parameter: Parameter, value: i32) {
        self.values[parameter as usize] = value;
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
    pub(crate) const fn of(model: Model) -> Self {
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

#[cfg(test)]
mod tests;
