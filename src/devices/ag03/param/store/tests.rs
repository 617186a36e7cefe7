use proptest::prelude::*;

use super::*;
use crate::devices::ag03::param::live::live;

const STILL: WriteContext = WriteContext { moving: false, job_active: false };
const INCHING: WriteContext = WriteContext { moving: true, job_active: false };
const PAUSED: WriteContext = WriteContext { moving: false, job_active: true };
const TRAVELLING: WriteContext = WriteContext { moving: true, job_active: true };

fn pnu(number: u16) -> Pnu {
    Pnu::new(number).unwrap()
}

/// A store none of whose values is a default.
fn changed_store() -> Store {
    let mut store = Store::new(Model::Ag03_1, Gear::Ratio48);
    for parameter in Parameter::all() {
        let range = store.range(parameter);
        let value = if parameter.setting().default == range.low { range.high } else { range.low };
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
        100, 5, 0, 50, 30, 50, 50, 30, 10, 1, 1, 0, 0, 1_000_000, -1_000_000, 1600, 0, 0, 2, 0, 0, 800, 125,
        100, 101,
    ];
    assert_eq!(values, expected);
}

#[test]
fn every_default_set_loads_its_group_and_keeps_the_other() {
    let controller = [1, 2, 3, 4, 5, 6, 8, 9, 31];
    let standard = [10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 25, 26, 27, 29, 30];
    assert!(at_default(&changed_store()).is_empty());
    for (command, expected) in
        [(1, [&controller[..], &standard].concat()), (2, standard.to_vec()), (3, controller.to_vec())]
    {
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
    assert_eq!(store.write(pnu(1000), None, Value::Word(100), &STILL), Ok(Effect::None));
    assert_eq!(store.write(pnu(1000), None, Value::Word(101), &STILL), Ok(Effect::SettingsChanged));
    assert_eq!(store.write(pnu(970), None, Value::Word(2), &STILL), Ok(Effect::None));
    assert_eq!(store.write(pnu(970), None, Value::Word(4), &TRAVELLING), Ok(Effect::ClearFaults));
    assert_eq!(store.write(pnu(970), None, Value::Word(5), &STILL), Ok(Effect::Calibrate));
}

#[test]
fn the_operating_state_decides_as_in_the_reference() {
    // `ag03.md` 3.4: PNU, a value in range, and whether still, inching, paused, travelling allow it.
    let moving = Some(NotNow::Moving);
    let job = Some(NotNow::JobActive);
    let rows = [
        (1008, 31, [None, moving, None, moving]),
        (1035, 50, [None; 4]),
        (970, 5, [None, moving, job, job]),
        (970, 1, [None, moving, None, moving]),
        (970, 2, [None, moving, None, moving]),
        (970, 3, [None, moving, None, moving]),
        (970, 4, [None; 4]),
        (930, 1, [None, moving, None, moving]),
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
fn quirk_c38_d_pos_is_written_at_any_time_or_without_travel_job() {
    for (d_pos_without_job, refusal) in [(false, None), (true, Some(ParamError::NotNow(NotNow::JobActive)))] {
        for context in [PAUSED, TRAVELLING] {
            let mut store = changed_store();
            store.set_quirks(Quirks { d_pos_without_job, ..Quirks::default() });
            assert_eq!(store.write(pnu(1039), None, Value::Word(50), &context).err(), refusal);
        }
    }
}

#[test]
fn quirk_c39_calibration_needs_standstill_or_only_that_no_job_is_active() {
    for (calibrate_while_moving, refusal) in [(false, Some(ParamError::NotNow(NotNow::Moving))), (true, None)]
    {
        let mut store = changed_store();
        store.set_quirks(Quirks { calibrate_while_moving, ..Quirks::default() });
        let running_out = WriteContext { moving: true, job_active: false };
        assert_eq!(store.write(pnu(970), None, Value::Word(5), &running_out).err(), refusal);
        let travelling = store.write(pnu(970), None, Value::Word(5), &TRAVELLING);
        assert_eq!(travelling.err(), Some(ParamError::NotNow(NotNow::JobActive)));
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
        (1008, None, double, ParamError::WrongWidth { expected: Width::Word, got: Width::Double }),
        (1016, None, word, ParamError::WrongWidth { expected: Width::Double, got: Width::Word }),
        (1008, None, word, ParamError::OutOfRange { low: 1, high: 100, got: 0 }),
        (970, None, word, ParamError::OutOfRange { low: 1, high: 5, got: 0 }),
    ] {
        assert_eq!(store.write(pnu(number), element, value, &TRAVELLING), Err(expected), "PNU {number}");
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
    let buffer = *b"JABCDEFG\0\0";
    let own = [(Reading::FaultCount, 65_535), (Reading::Temperature, -10), (Reading::MotorCurrent, -1)];
    let live = |reading, element: Subindex| {
        if reading == Reading::FaultBuffer {
            return buffer[usize::from(element.0)].into();
        }
        let own = own.into_iter().find(|(known, _)| *known == reading);
        own.map_or_else(|| live(reading, element), |(_, number)| number)
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
        (1041, Value::Word(238)),
        (1042, Value::Word(361)),
    ];
    let mut store = Store::new(Model::Ag03_1, Gear::Ratio48);
    for (number, value) in expected {
        assert_eq!(store.read(pnu(number), None, live), Ok(value), "PNU {number}");
    }
    for (subindex, code) in (0..).zip(buffer) {
        let element = store.read(pnu(945), Some(Subindex(subindex)), live);
        assert_eq!(element, Ok(Value::Word(u16::from(code))));
    }
    let too_far = ParamError::SubindexOutOfRange { count: 10, got: Subindex(10) };
    assert_eq!(store.read(pnu(945), Some(Subindex(10)), live), Err(too_far));
    assert_eq!(store.read(pnu(945), None, live), Err(ParamError::IsArray { count: 10 }));

    store.set_identity(Identity { serial_number: 7, ..store.identity() });
    assert_eq!(store.read(pnu(1033), None, live), Ok(Value::Double(7)));
    let ag03 = Store::new(Model::Ag03, Gear::Ratio24);
    assert_eq!(ag03.read(pnu(965), None, live), Ok(Value::Word(0x0300)));
    assert_eq!(ag03.read(pnu(961), None, live), Ok(Value::Word(2)));
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
                prop_assert_eq!(store.read(pnu(number), element, |_, _| 0), Ok(value));
            }
            Ok(Effect::None) => {
                prop_assert_eq!(store.read(pnu(number), element, |_, _| 0), Ok(value));
                prop_assert_eq!(store, before);
            }
            Ok(Effect::ClearFaults | Effect::Calibrate) | Err(_) => prop_assert_eq!(store, before),
        }
    }
}
