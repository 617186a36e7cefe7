//! The values of one drive, and who may change them when.

use super::entry::{DefaultSet, Entry, Kind, Reading, WritableWhen};
use super::table::{self, Parameter};
use super::{Effect, Gear, Live, Model, NotNow, ParamError, Pnu, Subindex, Value, Width, WriteContext};

/// All stored parameters of one drive.
///
/// [`read`](Self::read) and [`write`](Self::write) are what a bus does: by number, checked like the device
/// checks. [`value`](Self::value) and [`set`](Self::set) are for programs: by name, in every operating state.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Store {
    model: Model,
    gear: Gear,
    identity: Identity,
    values: [i32; Parameter::COUNT],
}

impl Store {
    /// Every parameter at its default.
    pub fn new(model: Model, gear: Gear) -> Self {
        let mut store = Self {
            model,
            gear,
            identity: Identity::of(model),
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
                check_state(setting.writable, context)?;
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
            5 => return check_state(WritableWhen::NoJob, context).map(|()| Effect::Calibrate),
            got => return Err(ParamError::OutOfRange { low: 1, high: 5, got }),
        };
        check_state(WritableWhen::Standstill, context)?;
        Ok(self.changed_by(|store| store.load_defaults(set)))
    }

    fn changed_by(&mut self, change: impl FnOnce(&mut Self)) -> Effect {
        let before = self.values;
        change(self);
        if self.values == before {
            Effect::None
        } else {
            Effect::SettingsChanged
        }
    }

    fn check_range(&self, parameter: Parameter, got: i32) -> Result<(), ParamError> {
        let range = parameter.setting().limits.range(self.model, self.gear);
        if range.contains(got) {
            Ok(())
        } else {
            Err(ParamError::OutOfRange {
                low: range.low,
                high: range.high,
                got,
            })
        }
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
        Self {
            serial_number: 1_234_567,
            production_date: 0x1507_2009,
            software_version,
        }
    }
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
        (Width::Word, Value::Double(_)) | (Width::Double, Value::Word(_)) => Err(ParamError::WrongWidth {
            expected: entry.width,
            got: value.width(),
        }),
    }
}

fn fault(live: &Live, element: Option<Subindex>) -> Result<u8, ParamError> {
    let count = 10;
    let got = element.ok_or(ParamError::IsArray { count })?;
    live.fault_buffer
        .get(usize::from(got.0))
        .copied()
        .ok_or(ParamError::SubindexOutOfRange { count, got })
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use proptest::prelude::*;

    use super::*;

    const STILL: WriteContext = WriteContext {
        moving: false,
        job_active: false,
    };
    const INCHING: WriteContext = WriteContext {
        moving: true,
        job_active: false,
    };
    const PAUSED: WriteContext = WriteContext {
        moving: false,
        job_active: true,
    };
    const TRAVELLING: WriteContext = WriteContext {
        moving: true,
        job_active: true,
    };

    fn pnu(number: u16) -> Pnu {
        Pnu::new(number).unwrap()
    }

    /// A store none of whose values is a default.
    fn changed_store() -> Store {
        let mut store = Store::new(Model::Ag03_1, Gear::Ratio48);
        for parameter in Parameter::all() {
            let range = parameter.setting().limits.range(store.model, store.gear);
            let value = if parameter.setting().default == range.low {
                range.high
            } else {
                range.low
            };
            store.set(parameter, value).unwrap();
        }
        store
    }

    fn at_default(store: &Store) -> Vec<u8> {
        Parameter::all()
            .map(|parameter| *parameter.setting())
            .filter(|setting| store.value(setting.parameter) == setting.default)
            .map(|setting| setting.number)
            .collect()
    }

    #[test]
    fn a_new_drive_has_the_defaults_of_manual_chapter_6() {
        let store = Store::new(Model::Ag03, Gear::Ratio24);
        let values: Vec<i32> = Parameter::all().map(|parameter| store.value(parameter)).collect();
        let expected = [
            100, 5, 0, 50, 30, 50, 50, 30, 10, 1, 1, 0, 0, 1_000_000, -1_000_000, 1600, 0, 0, 2, 0, 0, 800,
            125, 100, 101,
        ];
        assert_eq!(values, expected);
    }

    #[test]
    fn every_default_set_loads_its_group_and_keeps_the_other() {
        let controller = [1, 2, 3, 4, 5, 6, 8, 9, 31];
        let standard = [10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 25, 26, 27, 29, 30];
        assert_eq!(at_default(&changed_store()), []);
        for (command, expected) in [
            (1, [&controller[..], &standard].concat()),
            (2, standard.to_vec()),
            (3, controller.to_vec()),
        ] {
            let mut store = changed_store();
            let effect = store.write(pnu(970), None, Value::Word(command), &STILL);
            assert_eq!(effect, Ok(Effect::SettingsChanged));
            let mut loaded = at_default(&store);
            loaded.sort_unstable();
            let mut expected = expected;
            expected.sort_unstable();
            assert_eq!(loaded, expected, "970 = {command}");
        }
    }

    #[test]
    fn power_on_forgets_only_the_offset_of_inching_2() {
        let mut store = changed_store();
        store.power_on();
        assert_eq!(at_default(&store), [30]);
    }

    #[test]
    fn a_write_that_changes_nothing_has_no_effect() {
        let mut store = Store::new(Model::Ag03_1, Gear::Ratio48);
        assert_eq!(
            store.write(pnu(1000), None, Value::Word(100), &STILL),
            Ok(Effect::None)
        );
        assert_eq!(
            store.write(pnu(1000), None, Value::Word(101), &STILL),
            Ok(Effect::SettingsChanged)
        );
        assert_eq!(
            store.write(pnu(970), None, Value::Word(2), &STILL),
            Ok(Effect::None)
        );
        assert_eq!(
            store.write(pnu(970), None, Value::Word(4), &TRAVELLING),
            Ok(Effect::ClearFaults)
        );
        assert_eq!(
            store.write(pnu(970), None, Value::Word(5), &STILL),
            Ok(Effect::Calibrate)
        );
    }

    #[test]
    fn the_operating_state_decides_as_in_the_reference() {
        // `ag03.md` 3.4: PNU, a value in range, and whether still, inching, paused, travelling allow it.
        let moving = Some(NotNow::Moving);
        let job = Some(NotNow::JobActive);
        let rows = [
            (1008, 31, [None, moving, None, moving]),
            (1035, 50, [None; 4]),
            (970, 5, [None, None, job, job]),
            (970, 1, [None, moving, None, moving]),
            (970, 2, [None, moving, None, moving]),
            (970, 3, [None, moving, None, moving]),
            (970, 4, [None; 4]),
            (930, 1, [None, moving, None, moving]),
            (1039, 50, [None, None, job, job]),
            (1010, 2, [None, moving, None, moving]),
            (1011, 2, [None, moving, None, moving]),
            (1012, 2, [None, moving, None, moving]),
            (1013, 1, [None, moving, None, moving]),
        ];
        for entry in table::parameters(Model::Ag03_1) {
            let number = entry.pnu.number();
            let listed = rows.iter().filter(|(pnu, ..)| *pnu == number);
            let unlisted = match entry.kind {
                // "controller parameters in general: accepted during positioning", and all that no row names
                Kind::Setting(setting) => Some((number, setting.default, [None; 4])),
                Kind::Reading(_) | Kind::LoadParameterSet => None,
            };
            let expected: Vec<_> = if listed.clone().count() > 0 {
                listed.copied().collect()
            } else {
                unlisted.into_iter().collect()
            };
            for (number, value, refusals) in expected {
                for (context, refusal) in [STILL, INCHING, PAUSED, TRAVELLING].iter().zip(refusals) {
                    let mut store = changed_store();
                    let result = store.write(pnu(number), None, Value::of(entry.width, value), context);
                    let expected = refusal.map(ParamError::NotNow);
                    assert_eq!(result.err(), expected, "PNU {number} = {value}, {context:?}");
                }
            }
        }
    }

    #[test]
    fn what_can_never_be_written_is_said_before_what_cannot_be_written_now() {
        let mut store = Store::new(Model::Ag03, Gear::Ratio48);
        let element = Some(Subindex(0));
        let (word, double) = (Value::Word(0), Value::Double(0));
        for (number, element, value, expected) in [
            (1039, None, word, ParamError::UnknownParameter { got: pnu(1039) }),
            (1008, element, word, ParamError::NotAnArray),
            (945, None, word, ParamError::IsArray { count: 10 }),
            (945, Some(Subindex(10)), double, ParamError::ReadOnly),
            (918, None, double, ParamError::ReadOnly),
            (
                1008,
                None,
                double,
                ParamError::WrongWidth {
                    expected: Width::Word,
                    got: Width::Double,
                },
            ),
            (
                1016,
                None,
                word,
                ParamError::WrongWidth {
                    expected: Width::Double,
                    got: Width::Word,
                },
            ),
            (
                1008,
                None,
                word,
                ParamError::OutOfRange {
                    low: 1,
                    high: 100,
                    got: 0,
                },
            ),
            (
                970,
                None,
                word,
                ParamError::OutOfRange {
                    low: 1,
                    high: 5,
                    got: 0,
                },
            ),
        ] {
            assert_eq!(
                store.write(pnu(number), element, value, &TRAVELLING),
                Err(expected),
                "PNU {number}"
            );
        }
    }

    #[test]
    fn an_ag03_has_no_d_pos() {
        let mut store = Store::new(Model::Ag03, Gear::Ratio48);
        let unknown = Err(ParamError::UnknownParameter { got: pnu(1039) });
        assert_eq!(store.set(Parameter::DPos, 50), unknown);
        assert_eq!(store.value(Parameter::DPos), 101);
    }

    #[test]
    fn readings_come_from_the_drive_and_the_factory() {
        let live = Live {
            address: 5,
            fault_buffer: *b"JABCDEFG\0\0",
            fault_count: 65_535,
            system_status: 0x2948,
            temperature: -10,
            motor_current: -1,
            general_status: 0x0010,
            position: -5000,
            output_stage_voltage: 240,
            control_voltage: 241,
            battery_voltage: 360,
        };
        let expected = [
            (918, Value::Word(5)),
            (952, Value::Word(65_535)),
            (961, Value::Word(3)),
            (965, Value::Word(0x0101)),
            (970, Value::Word(0)),
            (1020, Value::Word(0x2948)),
            (1027, Value::Word(0xFFF6)),
            (1029, Value::Word(0xFFFF)),
            (1031, Value::Word(0x0010)),
            (1033, Value::Double(1_234_567)),
            (1034, Value::Double(0x1507_2009)),
            (1036, Value::Double(0xFFFF_EC78)),
            (1040, Value::Word(240)),
            (1041, Value::Word(241)),
            (1042, Value::Word(360)),
        ];
        let mut store = Store::new(Model::Ag03_1, Gear::Ratio48);
        for (number, value) in expected {
            assert_eq!(store.read(pnu(number), None, &live), Ok(value), "PNU {number}");
        }
        for (subindex, code) in (0..).zip(live.fault_buffer) {
            let element = store.read(pnu(945), Some(Subindex(subindex)), &live);
            assert_eq!(element, Ok(Value::Word(u16::from(code))));
        }
        let too_far = ParamError::SubindexOutOfRange {
            count: 10,
            got: Subindex(10),
        };
        assert_eq!(store.read(pnu(945), Some(Subindex(10)), &live), Err(too_far));
        assert_eq!(
            store.read(pnu(945), None, &live),
            Err(ParamError::IsArray { count: 10 })
        );

        store.set_identity(Identity {
            serial_number: 7,
            ..store.identity()
        });
        assert_eq!(store.read(pnu(1033), None, &live), Ok(Value::Double(7)));
        let ag03 = Store::new(Model::Ag03, Gear::Ratio24);
        assert_eq!(ag03.read(pnu(965), None, &live), Ok(Value::Word(0x0300)));
        assert_eq!(ag03.read(pnu(961), None, &live), Ok(Value::Word(2)));
    }

    proptest! {
        #[test]
        fn a_write_is_taken_over_whole_or_changes_nothing(
            number in prop_oneof![1000_u16..=1045, Just(930), Just(970), 0_u16..=2047],
            element in proptest::option::weighted(0.1, (0_u8..12).prop_map(Subindex)),
            bits in prop_oneof![0_u32..300, any::<u32>()],
            double: bool,
            moving: bool,
            job_active: bool,
        ) {
            let mut store = changed_store();
            let before = store.clone();
            let value = if double { Value::Double(bits) } else { Value::of(Width::Word, bits.cast_signed()) };
            let context = WriteContext { moving, job_active };
            match store.write(pnu(number), element, value, &context) {
                Ok(Effect::SettingsChanged) if number == 970 => prop_assert!(store != before),
                Ok(Effect::SettingsChanged) => {
                    prop_assert!(store != before);
                    prop_assert_eq!(store.read(pnu(number), element, &Live::default()), Ok(value));
                }
                Ok(Effect::None) => {
                    prop_assert_eq!(store.read(pnu(number), element, &Live::default()), Ok(value));
                    prop_assert_eq!(store, before);
                }
                Ok(Effect::ClearFaults | Effect::Calibrate) | Err(_) => prop_assert_eq!(store, before),
            }
        }
    }
}
