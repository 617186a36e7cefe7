//! The AG03/1 on CANopen: objects, NMT, state machine, emergencies (`canopen-ag03.md` 13, 14, 17; page
//! `docs/canopen-conformance.md`).

use profidrive::can_bus::can::ErrorState;
use profidrive::can_bus::canopen::dictionary;
use profidrive::can_bus::canopen::dictionary::Access;
use profidrive::can_bus::canopen::{Address, NodeId};
use profidrive::devices::CanopenDevice;
use profidrive::devices::ag03::canopen::Ag03Node;
use profidrive::devices::ag03::canopen::objects::objects;
use profidrive::devices::ag03::canopen::state::State;
use profidrive::devices::ag03::drive::{Fault, Motor};
use profidrive::devices::ag03::param::Gear;
use profidrive::devices::ag03::unit::{Eeprom, NotStored};

use crate::ag03_node::{Rig, config};

/// The rows of `canopen-od.tsv` of this device: index, sub-index, type, access, default, range, PDO, EEPROM.
fn rows() -> Vec<(u16, u8, Vec<&'static str>)> {
    include_str!("../../docs/reference/canopen-od.tsv")
        .lines()
        .filter(|line| line.starts_with("ag03\t"))
        .map(|line| {
            let fields: Vec<_> = line.split('\t').collect();
            let index = u16::from_str_radix(fields[1], 16).unwrap();
            (index, u8::from_str_radix(fields[2], 16).unwrap(), fields)
        })
        .collect()
}

/// A default of the table at node 5; `None`: it says none.
fn default_of(text: &str) -> Option<u32> {
    if let Some(base) = text.strip_suffix("h+n") {
        return Some(u32::from_str_radix(base, 16).unwrap() + 5);
    }
    if let Some(number) = text.strip_suffix('h').filter(|number| number.len() == 8) {
        return Some(u32::from_str_radix(number, 16).unwrap());
    }
    if let Some(text) = text.strip_prefix('"') {
        return Some(u32::from_le_bytes(text.trim_end_matches('"').as_bytes().try_into().unwrap()));
    }
    text.parse::<i32>().ok().map(i32::cast_unsigned)
}

#[test]
fn ao_01_every_row_is_as_the_reference_has_it_and_reads_its_default() {
    let mut rig = Rig::new();
    let mut entries = 0;
    for (index, sub, fields) in rows() {
        let at = Address::new(index, sub);
        let entry =
            dictionary::entry(objects(Gear::Ratio48), at).unwrap_or_else(|_| panic!("{at} is missing"));
        entries += 1;
        let access = match fields[5] {
            "ro" => Access::Ro,
            "wo" => Access::Wo,
            _rw => Access::Rw,
        };
        assert_eq!(entry.access, access, "{at}");
        assert_eq!(entry.sendable() || entry.receivable(), fields[8] == "yes", "{at}");
        if access != Access::Ro {
            assert_eq!(entry.stored, fields[9] == "yes", "{at}");
        }
        if access == Access::Wo {
            continue;
        }
        let [a, b] = index.to_le_bytes();
        let [command, _, _, _, data @ ..] = rig.sdo([0x40, a, b, sub, 0, 0, 0, 0]);
        let expected = match fields[4] {
            "VS4" | "U32" | "I32" if (index, sub) != (0x607D, 0) => 0x43,
            "U16" | "I16" => 0x4B,
            _octet => 0x4F,
        };
        assert_eq!(command, expected, "{at}");
        let value = u32::from_le_bytes(data);
        // 2101h shows the switches of this node.
        match (index, default_of(fields[6])) {
            (0x2101, _) => assert_eq!(value, 5),
            (_, Some(default)) => {
                let mask = match command {
                    0x4F => 0xFF,
                    0x4B => 0xFFFF,
                    _four => u32::MAX,
                };
                assert_eq!(value, default & mask, "{at}");
            }
            (_, None) => {}
        }
    }
    let all: usize = objects(Gear::Ratio48).iter().map(|object| object.entries.len()).sum();
    assert_eq!((entries, all), (138, 138));
}

#[test]
fn ao_02_ao_03_ao_04_what_cannot_be_written_read_or_found() {
    let mut rig = Rig::new();
    for (index, sub, fields) in rows() {
        if fields[5] == "ro" {
            let len = dictionary::entry(objects(Gear::Ratio48), Address::new(index, sub)).unwrap();
            let len = len.data.octets().unwrap_or(4) as u8;
            assert_eq!(rig.write(index, sub, 0, len), Err(0x0601_0002), "{index:04X}:{sub:02X}");
        }
    }
    for sub in 1..=4 {
        assert_eq!(rig.read(0x1011, sub), Err(0x0601_0001));
    }
    for index in (0x1000..0x7000_u16).step_by(7) {
        if rows().iter().all(|row| row.0 != index) {
            assert_eq!(rig.read(index, 0), Err(0x0602_0000), "{index:04X}");
        }
    }
    let subs: Vec<_> = rows().iter().map(|row| (row.0, row.1)).collect();
    for index in [0x1000, 0x1003, 0x1011, 0x1018, 0x1400, 0x1601, 0x1800, 0x2410, 0x607D, 0x60FF] {
        for sub in 0..=u8::MAX {
            if !subs.contains(&(index, sub)) {
                assert_eq!(rig.read(index, sub), Err(0x0609_0011), "{index:04X}:{sub:02X}");
            }
        }
    }
}

#[test]
fn ao_06_what_is_only_written_in_pre_operational() {
    let mut rig = Rig::new();
    let rows: Vec<_> = rows().into_iter().filter(|row| row.2[5] == "rwP").collect();
    assert!(rows.len() > 15);
    for operational in [false, true] {
        if operational {
            rig.nmt(0x01);
        }
        for (index, sub, fields) in &rows {
            let len = match fields[4] {
                "U32" => 4,
                "U16" => 2,
                _octet => 1,
            };
            let value = default_of(fields[6]).unwrap().cast_signed();
            let expected = if operational { Err(0x0800_0022) } else { Ok(()) };
            assert_eq!(rig.write(*index, *sub, value, len), expected, "{index:04X}:{sub:02X}");
        }
    }
}

#[test]
fn ao_07_ao_08_ao_10_printed_and_derived_telegrams() {
    let mut rig = Rig::new();
    rig.write(0x607C, 0, 2500, 4).unwrap();
    let telegrams: [([u8; 8], [u8; 8]); 13] = [
        // S1 to S4; S2 with 43h (CN-03)
        ([0x40, 0x7C, 0x60, 0, 0, 0, 0, 0], [0x43, 0x7C, 0x60, 0, 0xC4, 0x09, 0, 0]),
        ([0x23, 0x7D, 0x60, 2, 0x80, 0x84, 0x1E, 0], [0x60, 0x7D, 0x60, 2, 0, 0, 0, 0]),
        ([0x40, 0x00, 0x10, 0, 0, 0, 0, 0], [0x43, 0x00, 0x10, 0, 0x92, 0x01, 0, 0]),
        ([0x40, 0x08, 0x10, 0, 0, 0, 0, 0], [0x43, 0x08, 0x10, 0, 0x41, 0x47, 0x30, 0x33]),
        ([0x23, 0x11, 0x10, 1, 0x6C, 0x6F, 0x61, 0x64], [0x60, 0x11, 0x10, 1, 0, 0, 0, 0]),
        ([0x40, 0x11, 0x10, 1, 0, 0, 0, 0], [0x80, 0x11, 0x10, 1, 0x01, 0x00, 0x01, 0x06]),
        ([0x2F, 0x00, 0x21, 0, 0x0C, 0, 0, 0], [0x80, 0x00, 0x21, 0, 0x30, 0x00, 0x09, 0x06]),
        ([0x40, 0x10, 0x24, 7, 0, 0, 0, 0], [0x80, 0x10, 0x24, 7, 0x11, 0x00, 0x09, 0x06]),
        ([0x40, 0x41, 0x60, 0, 0, 0, 0, 0], [0x4B, 0x41, 0x60, 0, 0x70, 0, 0, 0]),
        ([0x2F, 0x60, 0x60, 0, 3, 0, 0, 0], [0x80, 0x60, 0x60, 0, 0x30, 0x00, 0x09, 0x06]),
        ([0x2F, 0x03, 0x10, 0, 0, 0, 0, 0], [0x60, 0x03, 0x10, 0, 0, 0, 0, 0]),
        ([0x2F, 0x03, 0x10, 0, 1, 0, 0, 0], [0x80, 0x03, 0x10, 0, 0x30, 0x00, 0x09, 0x06]),
        ([0x23, 0x00, 0x18, 1, 0x85, 0x01, 0x00, 0x80], [0x60, 0x00, 0x18, 1, 0, 0, 0, 0]),
    ];
    for (request, answer) in telegrams {
        assert_eq!(rig.sdo(request), answer, "{request:02X?}");
    }
    rig.write(0x607D, 2, 200_000, 4).unwrap();
    let answer = rig.sdo([0x23, 0x7D, 0x60, 1, 0x90, 0xD0, 0x03, 0]);
    assert_eq!(answer, [0x80, 0x7D, 0x60, 1, 0x36, 0x00, 0x09, 0x06]);
    assert_eq!(rig.write(0x607D, 1, 200_000, 4), Ok(()), "equal limits switch the monitoring off");
}

#[test]
fn ao_09_load_brings_back_the_defaults_of_its_group() {
    let mut rig = Rig::new();
    for (group, v_pos, window) in [(2, 77, 10), (3, 30, 55), (1, 30, 10)] {
        rig.write(0x2410, 5, 77, 1).unwrap();
        rig.write(0x6067, 0, 55, 2).unwrap();
        rig.write(0x2100, 0, 7, 1).unwrap();
        assert_eq!(rig.write(0x1011, group, 0x6461_6F6D, 4), Err(0x0609_0030));
        assert_eq!(rig.read(0x2410, 5), Ok(77));
        rig.write(0x1011, group, 0x6461_6F6C, 4).unwrap();
        assert_eq!((rig.read(0x2410, 5), rig.read(0x6067, 0)), (Ok(v_pos), Ok(window)), "{group}");
        assert_eq!(rig.read(0x2100, 0), Ok(7), "the rate is no part of it");
    }
}

#[test]
fn an_04_leaving_operational_releases_the_motor() {
    for command in [0x80, 0x02] {
        let mut rig = Rig::enabled();
        rig.travel(0x001F, 50_000);
        rig.pass_ms(1000);
        rig.nmt(command);
        assert_eq!(rig.node.state(), State::SwitchOnDisabled);
        assert_eq!(rig.node.status().motor, Motor::Released);
        assert!(rig.node.status().moving, "it runs out");
        rig.nmt(0x01);
        assert_eq!(rig.sw() & 0x7F, 0x70, "OPERATIONAL brings no state back");
    }
}

#[test]
fn ae_03_life_guarding_drops_the_drive_and_not_the_node() {
    let mut rig = Rig::enabled();
    rig.write(0x100C, 0, 100, 2).unwrap();
    rig.write(0x100D, 0, 2, 1).unwrap();
    assert_eq!(rig.remote(0x705, 1), ["705#05"]);
    rig.pass_ms(150);
    assert_eq!(rig.remote(0x705, 1), ["705#85"]);
    assert_eq!(rig.node.state(), State::OperationEnabled);
    let seen = rig.pass_ms(400);
    assert!(seen.iter().all(|frame| frame.starts_with("185#")), "no EMCY: {seen:?}");
    assert_eq!(rig.node.state(), State::SwitchOnDisabled);
    assert_eq!(rig.remote(0x705, 1), ["705#05"]);
}

#[test]
fn ap_01_tpdo_3_answers_a_request_and_tpdo_1_its_timer() {
    let mut rig = Rig::enabled();
    rig.travel(0x001F, 5000);
    rig.until("target", |node| node.status_word() == 0x1737);
    rig.word(0x000F);
    assert_eq!(rig.remote(0x385, 6), ["385#370788130000"]);
    let seen = rig.pass_ms(1000);
    assert_eq!(seen, vec!["185#3707"; 10]);
}

#[test]
fn as_02_a_control_word_in_pre_operational_is_refused() {
    let mut rig = Rig::new();
    assert_eq!(rig.write(0x6040, 0, 6, 2), Err(0x0800_0022));
    assert_eq!(rig.node.state(), State::SwitchOnDisabled);
    rig.nmt(0x01);
    assert_eq!(rig.write(0x6040, 0, 6, 2), Ok(()));
    assert_eq!(rig.node.state(), State::ReadyToSwitchOn);
}

#[test]
fn as_03_a_fault_is_told_kept_and_acknowledged_when_its_cause_is_gone() {
    let mut rig = Rig::enabled();
    let seen = rig.input(|inputs| inputs.stage_temperature = Some(95.0));
    assert_eq!(seen, ["085#1043090000000000"]);
    assert_eq!(rig.sw() & 0x4F, 0x08);
    assert_eq!(rig.read(0x1001, 0), Ok(0x09));
    assert_eq!(rig.sdo([0x40, 0x03, 0x10, 1, 0, 0, 0, 0]), [0x43, 0x03, 0x10, 1, 0x10, 0x43, 0, 0]);
    assert_eq!(rig.word(0x0080), [""; 0], "the cause is there");
    assert_eq!(rig.node.state(), State::Fault);
    rig.input(|inputs| inputs.stage_temperature = None);
    rig.pass_ms(5);
    rig.word(0x0000);
    assert_eq!(rig.word(0x0080), ["085#0000000000000000"]);
    assert_eq!(rig.sw(), 0x0270);
    assert_eq!((rig.read(0x1001, 0), rig.read(0x1003, 0)), (Ok(0), Ok(1)));
}

#[test]
fn as_03_faults_h_and_i_come_from_the_bus() {
    let mut rig = Rig::enabled();
    rig.node.handle_error_state(rig.now, ErrorState::Active, ErrorState::Passive);
    assert_eq!(rig.drain(), ["085#2081110000000000"]);
    rig.node.handle_error_state(rig.now, ErrorState::Passive, ErrorState::Active);
    assert_eq!(rig.drain(), ["085#0000000000000000"]);
    rig.travel(0x001F, 50_000);
    rig.pass_ms(300);
    rig.node.handle_error_state(rig.now, ErrorState::Active, ErrorState::Passive);
    assert_eq!(rig.drain(), ["085#02FF110000000000"]);
    assert_eq!(rig.node.status().fault, Some(Fault::H));
    rig.node.handle_error_state(rig.now, ErrorState::Passive, ErrorState::BusOff);
    assert_eq!(rig.pass_ms(500), [""; 0], "the node is mute");
    rig.node.handle_error_state(rig.now, ErrorState::BusOff, ErrorState::Active);
    assert_eq!(rig.drain(), ["085#03FF110000000000", "085#4081110000000000"]);
    rig.word(0x0000);
    assert_eq!(rig.word(0x0080), ["085#0000000000000000"]);
    assert_eq!((rig.read(0x1003, 1), rig.read(0x1003, 2)), (Ok(0xFF03), Ok(0xFF02)));
}

#[test]
fn ax_01_what_the_eeprom_keeps_comes_back_and_nothing_else() {
    let mut rig = Rig::new();
    rig.write(0x2410, 5, 77, 1).unwrap();
    rig.write(0x2450, 0, 50, 1).unwrap();
    rig.write(0x1800, 5, 250, 2).unwrap();
    rig.write(0x1802, 5, 250, 2).unwrap();
    rig.write(0x2100, 0, 7, 1).unwrap();
    rig.write(0x607C, 0, 1234, 4).unwrap();
    assert_eq!(rig.node.bits_per_second(), 500_000);
    let octets = rig.node.image();
    let node = Ag03Node::restore(config(), &octets, rig.now).unwrap();
    let mut restored = Rig { now: rig.now, node };
    restored.drain();
    rig.nmt(0x81);
    for rig in [&mut restored, &mut rig] {
        for (index, sub, value) in [
            (0x2410, 5, 77),
            (0x2450, 0, 100),
            (0x1800, 5, 250),
            (0x1802, 5, 100),
            (0x2100, 0, 7),
            (0x6064, 0, 1234),
        ] {
            assert_eq!(rig.read(index, sub), Ok(value), "{index:04X}:{sub:02X}");
        }
        assert_eq!(rig.node.bits_per_second(), 125_000);
        assert_eq!(rig.node.node_id(), NodeId::new(5).unwrap());
    }
}

#[test]
fn ax_01_an_answer_waits_until_the_value_is_safe_or_refuses_it() {
    let mut config = config();
    config.eeprom = Eeprom::Host;
    let mut rig = Rig::with(config);
    stored(&mut rig, Ok(()));
    for (request, index, sub, old) in [
        ([0x2F, 0x10, 0x24, 5, 77, 0, 0, 0], 0x2410, 5, 30),
        ([0x2B, 0x00, 0x18, 5, 250, 0, 0, 0], 0x1800, 5, 100),
        ([0x2F, 0x00, 0x21, 0, 7, 0, 0, 0], 0x2100, 0, 10),
    ] {
        assert_eq!(rig.sdo_answers(request), [[0; 8]; 0], "{index:04X}h");
        stored(&mut rig, Err(NotStored));
        let [_, a, b, c, ..] = request;
        assert_eq!(rig.answers(), [[0x80, a, b, c, 0, 0, 0x06, 0x06]]);
        if index != 0x1800 {
            assert_eq!(rig.read(index, sub), Ok(old));
        }
        assert_eq!(rig.sdo_answers(request), [[0; 8]; 0]);
        stored(&mut rig, Ok(()));
        assert_eq!(rig.answers(), [[0x60, a, b, c, 0, 0, 0, 0]]);
    }
}

#[test]
fn ax_02_607c_and_1011_4_make_the_position_the_value() {
    let mut rig = Rig::new();
    rig.write(0x607C, 0, 2500, 4).unwrap();
    assert_eq!(rig.read(0x6064, 0), Ok(2500));
    rig.enable();
    rig.travel(0x001F, 4000);
    rig.pass_ms(300);
    assert_eq!(rig.write(0x607C, 0, 0, 4), Err(0x0800_0022));
    assert_eq!(rig.write(0x1011, 4, 0x6461_6F6C, 4), Err(0x0800_0022));
    rig.until("target", |node| node.status_word() & 0x4000 == 0);
    rig.write(0x1011, 4, 0x6461_6F6C, 4).unwrap();
    assert_eq!(rig.read(0x6064, 0), Ok(2500));
}

/// What becomes of the image that is on offer.
fn stored(rig: &mut Rig, outcome: Result<(), NotStored>) {
    let mut room = [0; 16 * 1024];
    let generation = rig.node.poll_image(&mut room).unwrap().unwrap().generation;
    rig.node.handle_stored(rig.now, generation, outcome);
}
