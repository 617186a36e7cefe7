//! The AG03/1 on CANopen: NMT, error control, PDOs and ranges as the device has them, and what is on its housing: LEDs,
//! keys, DIP switches, supply, gear (`canopen-ag03.md` 1, 3, 5, 6, 17; page `docs/canopen-conformance.md`).

use profidrive::can_bus::can::{Frame, Id};
use profidrive::can_bus::canopen::dictionary;
use profidrive::can_bus::canopen::dictionary::{Access, Limits};
use profidrive::can_bus::canopen::{NmtState, NodeId};
use profidrive::devices::CanopenDevice;
use profidrive::devices::ag03::canopen::objects::objects;
use profidrive::devices::ag03::canopen::state::State;
use profidrive::devices::ag03::canopen::{Ag03Node, Config};
use profidrive::devices::ag03::param::Gear;
use profidrive::devices::ag03::unit::DipSwitches;

use crate::ag03_node::{Rig, config};

const STATES: [(u8, NmtState); 3] =
    [(0x01, NmtState::Operational), (0x02, NmtState::Stopped), (0x80, NmtState::PreOperational)];

/// A node in this state, with what entering it made it send taken.
fn in_state(command: u8) -> Rig {
    let mut rig = Rig::new();
    rig.nmt(command);
    rig
}

/// Frames of one identifier.
fn of(seen: &[String], id: &str) -> Vec<String> {
    seen.iter().filter(|frame| frame.starts_with(id)).cloned().collect()
}

#[test]
fn ao_05_the_ends_of_every_range_and_one_beyond() {
    let mut rows = 0;
    for gear in Gear::ALL {
        for object in objects(gear) {
            for entry in object.entries.iter().filter(|entry| entry.access == Access::Rw) {
                let (index, sub) = (object.index.0, entry.sub.0);
                // The others are identifiers and the control word.
                let (low, high) = match entry.limits {
                    Limits::Range(low, high) => (low, high),
                    Limits::Ranges(ranges) => (ranges[0].0, ranges[ranges.len() - 1].1),
                    Limits::Type | Limits::MaxLen(_) => continue,
                };
                let (least, most) = entry.data.range().unwrap();
                let len = entry.data.octets().unwrap() as u8;
                let mut rig = Rig::with(Config { gear, ..config() });
                if (index, sub) == (0x607D, 1) {
                    rig.write(0x607D, 2, 9_999_999, 4).unwrap();
                }
                if (index, sub) == (0x607D, 2) {
                    rig.write(0x607D, 1, -9_999_999, 4).unwrap();
                }
                let mask = u32::MAX >> (32 - 8 * u32::from(len));
                let before = rig.read(index, sub).unwrap();
                for beyond in [low - 1, high + 1].into_iter().filter(|number| (least..=most).contains(number))
                {
                    let answer = rig.write(index, sub, beyond as i32, len);
                    assert_eq!(answer, Err(0x0609_0030), "{index:04X}:{sub:02X} = {beyond}");
                    assert_eq!(rig.read(index, sub), Ok(before), "{index:04X}:{sub:02X} is as it was");
                }
                for end in [low, high] {
                    let answer = rig.write(index, sub, end as i32, len);
                    assert_eq!(answer, Ok(()), "{index:04X}:{sub:02X} = {end}");
                    assert_eq!(rig.read(index, sub), Ok(end as u32 & mask), "{index:04X}:{sub:02X} = {end}");
                }
                rows += 1;
            }
        }
    }
    assert_eq!(rows, 2 * 35, "rows with a range, of both gears");
}

#[test]
fn an_01_power_on_sends_one_boot_up_and_leads_to_pre_operational() {
    // The rig has seen the one of the first power-on, and nothing beside it.
    let mut rig = Rig::new();
    assert_eq!(rig.node.nmt_state(), Some(NmtState::PreOperational));
    assert_eq!(rig.pass_ms(2000), [""; 0], "heartbeats are off");
    rig.nmt(0x01);
    rig.node.power_off(rig.now);
    assert_eq!((rig.node.nmt_state(), rig.drain()), (None, vec![]));
    assert_eq!(rig.pass_ms(1000), [""; 0], "without supply it says nothing");
    assert_eq!(rig.sdo_answers([0x40, 0, 0x10, 0, 0, 0, 0, 0]), [[0; 8]; 0]);
    rig.node.power_on(rig.now);
    assert_eq!(rig.drain(), ["705#00"]);
    assert_eq!(rig.node.nmt_state(), Some(NmtState::PreOperational));
}

#[test]
fn an_02_every_command_from_every_state_for_it_for_all_and_for_others() {
    for (from_command, from) in STATES {
        for command in 0..=u8::MAX {
            for node in [5, 0, 6] {
                let mut rig = in_state(from_command);
                let seen = rig.data(0x000, &[command, node]);
                let meant = node != 6;
                let to = STATES.iter().find(|row| row.0 == command && meant).map_or(from, |row| row.1);
                let resets = meant && matches!(command, 0x81 | 0x82);
                let to = if resets { NmtState::PreOperational } else { to };
                assert_eq!(rig.node.nmt_state(), Some(to), "{command:02X} to {node} in {from}");
                let boots = if resets { vec!["705#00"] } else { vec![] };
                assert_eq!(of(&seen, "705"), boots, "{command:02X} to {node} in {from}");
            }
        }
        // CN-39: another length.
        for octets in [&[][..], &[0x81], &[0x81, 5, 0]] {
            let mut rig = in_state(from_command);
            assert_eq!(rig.data(0x000, octets), [""; 0]);
            assert_eq!(rig.node.nmt_state(), Some(from));
        }
    }
}

#[test]
fn an_03_in_stopped_sdo_and_pdos_are_silent_and_the_heartbeat_goes_on() {
    let mut rig = Rig::new();
    rig.write(0x1017, 0, 100, 2).unwrap();
    rig.nmt(0x02);
    assert_eq!(rig.sdo_answers([0x40, 0, 0x10, 0, 0, 0, 0, 0]), [[0; 8]; 0]);
    assert_eq!(rig.word(0x0006), [""; 0]);
    assert_eq!(rig.node.state(), State::SwitchOnDisabled, "the RPDO did nothing");
    assert_eq!(rig.remote(0x385, 6), [""; 0], "a TPDO is not sent on request");
    assert_eq!(rig.data(0x080, &[]), [""; 0], "nor after a SYNC");
    assert_eq!(rig.pass_ms(1000), vec!["705#04"; 10], "and nothing else");
}

#[test]
fn an_05_entry_into_operational_sends_each_tpdo_of_type_254_once() {
    let mut rig = Rig::new();
    for pdo in [0x1800, 0x1803] {
        rig.write(pdo, 2, 254, 1).unwrap();
        rig.write(pdo, 5, 0, 2).unwrap();
    }
    assert_eq!(rig.nmt(0x01), ["185#7002", "485#700200000000"], "and not TPDO 3, of type 253");
    assert_eq!(rig.pass_ms(1000), [""; 0], "nothing changes, no timer");
    rig.nmt(0x80);
    assert_eq!(rig.nmt(0x01).len(), 2, "with each entry");
}

#[test]
fn ae_01_the_heartbeat_has_its_period_in_every_state_and_0_ends_it() {
    for (period, count) in [(10, 100), (100, 10), (1000, 1)] {
        for (command, state) in STATES {
            let mut rig = Rig::new();
            rig.write(0x1017, 0, period, 2).unwrap();
            rig.nmt(command);
            let seen = of(&rig.pass_ms(1000), "705");
            assert_eq!(seen, vec![format!("705#{:02X}", state.octet()); count], "{period} ms in {state}");
        }
    }
    let mut rig = Rig::new();
    rig.write(0x1017, 0, 100, 2).unwrap();
    rig.write(0x1017, 0, 0, 2).unwrap();
    assert_eq!(rig.pass_ms(1000), [""; 0]);
}

#[test]
fn ae_02_guarding_answers_with_state_and_a_toggle_bit_that_starts_at_0() {
    let mut rig = Rig::new();
    let mut toggle = 0;
    for (command, state) in STATES.into_iter().cycle().take(300) {
        rig.nmt(command);
        let answer = format!("705#{:02X}", state.octet() | toggle);
        assert_eq!(of(&rig.remote(0x705, 1), "705"), [answer]);
        toggle ^= 0x80;
    }
    // CN-40: a reset begins anew.
    rig.remote(0x705, 1);
    rig.nmt(0x82);
    assert_eq!(rig.remote(0x705, 1), ["705#7F"]);
}

#[test]
fn ae_04_beside_heartbeats_a_guarding_request_is_not_answered() {
    let mut rig = Rig::new();
    rig.write(0x1017, 0, 1000, 2).unwrap();
    assert_eq!(rig.remote(0x705, 1), [""; 0]);
    rig.write(0x1017, 0, 0, 2).unwrap();
    assert_eq!(rig.remote(0x705, 1), ["705#7F"]);
    let mut config = config();
    config.set_quirk("guarding-and-heartbeat", "answered").unwrap();
    let mut rig = Rig::with(config);
    rig.write(0x1017, 0, 1000, 2).unwrap();
    assert_eq!(rig.remote(0x705, 1), ["705#7F"], "CN-09 the other way");
}

#[test]
fn ap_01_transmission_types_timers_and_bits_of_the_tpdos() {
    // Type 0 and 1 after every SYNC, type n after every n-th since entry.
    for (kind, every) in [(0, 1), (1, 1), (2, 2), (7, 7), (240, 240)] {
        let mut rig = Rig::new();
        rig.write(0x1800, 2, kind, 1).unwrap();
        rig.nmt(0x01);
        for sync in 1..=480 {
            let sent = usize::from(sync % every == 0);
            assert_eq!(of(&rig.data(0x080, &[]), "185").len(), sent, "type {kind}, SYNC {sync}");
        }
        assert_eq!(rig.pass_ms(1000), [""; 0], "no timer");
    }
    // 253 on request only; 254 with a change, apart by the inhibit time, and by its timer; 255 by its timer only.
    for (kind, on_change, timed) in [(253, 0, 0), (254, 1, 10), (255, 0, 10)] {
        let mut rig = Rig::new();
        rig.write(0x1800, 2, kind, 1).unwrap();
        rig.nmt(0x01);
        rig.pass_ms(50);
        let mut changed = rig.word(0x0006);
        changed.extend(rig.pass_ms(20));
        assert_eq!(changed.len(), on_change, "type {kind}");
        rig.pass_ms(200);
        assert_eq!(rig.pass_ms(1000).len(), timed, "type {kind}");
        assert_eq!(rig.remote(0x185, 2), ["185#3102"], "type {kind} is answered on request (CN-07)");
    }
    // Bit 30: no RTR. Bit 31: no PDO.
    for (bits, answered, timed) in [(0x4000_0000_u32, 0, 10), (0x8000_0000, 0, 0), (0, 1, 10)] {
        let mut rig = Rig::new();
        rig.write(0x1800, 1, (bits | 0x185).cast_signed(), 4).unwrap();
        rig.nmt(0x01);
        assert_eq!(rig.remote(0x185, 2).len(), answered, "{bits:08X}");
        assert_eq!(rig.pass_ms(1000).len(), timed, "{bits:08X}");
    }
}

#[test]
fn ap_02_rpdos_of_types_0_to_240_act_at_the_next_sync_only() {
    for kind in 0..=240 {
        let mut rig = Rig::new();
        rig.write(0x1400, 2, kind, 1).unwrap();
        rig.nmt(0x01);
        rig.word(0x0006);
        assert_eq!(rig.node.state(), State::SwitchOnDisabled, "type {kind} before the SYNC");
        rig.data(0x080, &[]);
        assert_eq!(rig.node.state(), State::ReadyToSwitchOn, "type {kind} at the SYNC");
    }
    for kind in [254, 255] {
        let mut rig = Rig::new();
        rig.write(0x1400, 2, kind, 1).unwrap();
        rig.nmt(0x01);
        rig.word(0x0006);
        assert_eq!(rig.node.state(), State::ReadyToSwitchOn, "type {kind} at once");
    }
    // CN-54: of each PDO the newest, in the order 1, 3, 4.
    let mut rig = Rig::new();
    for pdo in [0x1400, 0x1402] {
        rig.write(pdo, 2, 1, 1).unwrap();
    }
    rig.nmt(0x01);
    rig.travel(0x0007, 4000);
    rig.word(0x0000);
    rig.word(0x0006);
    rig.data(0x080, &[]);
    assert_eq!(rig.node.state(), State::SwitchedOn, "shutdown of RPDO 1, then switch on of RPDO 3");
    assert_eq!(rig.read(0x607A, 0), Ok(4000));
    rig.nmt(0x80);
    rig.nmt(0x01);
    rig.data(0x080, &[]);
    assert_eq!(rig.node.state(), State::SwitchOnDisabled, "nothing of before is left");
}

#[test]
fn ap_03_reserved_transmission_types_are_refused() {
    let mut rig = Rig::new();
    for (pdos, reserved, default) in [
        ([0x1400, 0x1402, 0x1403], 241..=253, [255, 255, 255]),
        ([0x1800, 0x1802, 0x1803], 241..=252, [255, 253, 253]),
    ] {
        for (pdo, default) in pdos.into_iter().zip(default) {
            for kind in reserved.clone() {
                assert_eq!(rig.write(pdo, 2, kind, 1), Err(0x0609_0030), "{pdo:04X}h, type {kind}");
            }
            assert_eq!(rig.read(pdo, 2), Ok(default));
        }
    }
}

#[test]
fn ap_04_a_short_rpdo_is_ignored_and_of_a_long_one_the_first_octets_count() {
    let mut rig = Rig::new();
    rig.nmt(0x01);
    for octets in [&[][..], &[0x06]] {
        assert_eq!(rig.data(0x205, octets), [""; 0], "no EMCY");
    }
    assert_eq!(rig.data(0x405, &[0x06, 0x00, 1, 2, 3]), [""; 0]);
    assert_eq!((rig.node.state(), rig.read(0x607A, 0)), (State::SwitchOnDisabled, Ok(0)));
    rig.data(0x205, &[0x06, 0x00, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF]);
    assert_eq!(rig.node.state(), State::ReadyToSwitchOn);
    let mut config = config();
    config.set_quirk("rpdo-short", "emcy").unwrap();
    let mut rig = Rig::with(config);
    rig.nmt(0x01);
    assert_eq!(of(&rig.data(0x205, &[6]), "085").len(), 1, "CN-36 the other way");
}

#[test]
fn ap_05_identifiers_of_29_bits() {
    let mut rig = Rig::new();
    let long = |number: u32| (0x2000_0000 | number).cast_signed();
    rig.write(0x1005, 0, long(0x0080_0001), 4).unwrap();
    rig.write(0x1014, 0, long(0x0080_0002), 4).unwrap();
    rig.write(0x1400, 1, long(0x0080_0003), 4).unwrap();
    rig.write(0x1800, 1, long(0x0080_0004), 4).unwrap();
    rig.write(0x1800, 2, 1, 1).unwrap();
    assert_eq!(rig.read(0x1400, 1), Ok(0x2080_0003));
    rig.nmt(0x01);
    rig.word(0x0006);
    assert_eq!(rig.node.state(), State::SwitchOnDisabled, "not by 11 bits any more");
    let extended = |number, octets: &[u8]| Frame::data(Id::extended(number).unwrap(), octets).unwrap();
    rig.frame(&extended(0x0080_0003, &[0x06, 0x00]));
    assert_eq!(rig.node.state(), State::ReadyToSwitchOn);
    assert_eq!(rig.data(0x080, &[]), [""; 0], "nor the SYNC");
    assert_eq!(rig.frame(&extended(0x0080_0001, &[])), ["00800004#3102"]);
    let seen = rig.input(|inputs| inputs.stage_temperature = Some(95.0));
    assert_eq!(seen, ["00800002#1043090000000000"]);
}

#[test]
fn leds_show_nmt_state_and_fault() {
    let lit = |rig: &mut Rig, millis: u64| {
        (0..millis).filter(|_| rig.pass_ms(1).len() < usize::MAX && rig.node.leds(rig.now).bus).count()
    };
    let mut rig = Rig::new();
    assert!(rig.node.leds(rig.now).status, "both supplies are there");
    // 200 ms on, 200 ms off; on; 200 ms on, 1000 ms off (CN-42).
    assert_eq!(lit(&mut rig, 4000), 2000, "PRE-OPERATIONAL");
    rig.nmt(0x01);
    assert_eq!(lit(&mut rig, 1000), 1000, "OPERATIONAL");
    rig.nmt(0x02);
    assert_eq!(lit(&mut rig, 12_000), 2000, "STOPPED");
    rig.input(|inputs| inputs.stage_temperature = Some(95.0));
    let mut blinks = 0;
    let mut before = false;
    for _ in 0..20_000 {
        rig.pass_ms(1);
        let now = rig.node.leds(rig.now).status;
        blinks += usize::from(now && !before);
        before = now;
    }
    assert!(blinks >= 8, "fault D blinks: {blinks}");
    rig.node.power_off(rig.now);
    let leds = rig.node.leds(rig.now);
    assert!(!leds.status && !leds.bus);
}

#[test]
fn keys_turn_the_shaft_in_pre_operational_only() {
    for (command, turns) in [(0x80, true), (0x01, false), (0x02, false)] {
        let mut rig = in_state(command);
        rig.input(|inputs| inputs.key_clockwise = true);
        rig.pass_ms(1000);
        assert_eq!(rig.position() != 0, turns, "after NMT {command:02X}h");
    }
    let mut rig = Rig::new();
    rig.input(|inputs| inputs.key_clockwise = true);
    rig.pass_ms(500);
    assert!(rig.position() < 0, "key 1 is clockwise: it counts down");
    rig.nmt(0x01);
    rig.pass_ms(500);
    let at = rig.position();
    rig.pass_ms(500);
    assert_eq!(rig.position(), at, "entering OPERATIONAL stops it");
}

#[test]
fn dip_switches_give_number_and_factory_reset_when_it_is_switched_on() {
    for (switches, number) in [(0, 1), (1, 1), (42, 42), (127, 127)] {
        let config = Config { switches: DipSwitches::from_bits(switches), ..config() };
        let node = Ag03Node::new(config, profidrive::time::Instant::ZERO);
        assert_eq!(node.node_id(), NodeId::new(number).unwrap());
    }
    let mut rig = Rig::new();
    rig.node.set_switches(DipSwitches::from_bits(9));
    rig.nmt(0x81);
    assert_eq!(rig.node.node_id().number(), 5, "not with a reset");
    rig.node.power_off(rig.now);
    rig.node.power_on(rig.now);
    assert_eq!(rig.drain(), ["709#00"]);
    rig.data(0x609, &[0x40, 0x01, 0x21, 0, 0, 0, 0, 0]);
}

#[test]
fn the_supply_of_the_output_stage_is_seen_and_missed() {
    let mut rig = Rig::enabled();
    assert_eq!(rig.sw() & 0x10, 0x10);
    rig.input(|inputs| inputs.output_supply = 0.0);
    assert_eq!(rig.sw() & 0x0110, 0, "bits 4 and 8");
    assert_eq!(rig.node.state(), State::OperationEnabled, "CN-43: the state is kept");
    assert_eq!(rig.read(0x1002, 0).unwrap() & 0x0480, 0x0480, "1002h: supply missing, motor released");
    rig.input(|inputs| inputs.output_supply = 24.0);
    rig.pass_ms(5);
    assert_eq!(rig.sw() & 0x0110, 0x0110);
    let mut config = config();
    config.set_quirk("supply-loss", "disabled").unwrap();
    let mut rig = Rig::with(config);
    rig.enable();
    rig.input(|inputs| inputs.output_supply = 0.0);
    assert_eq!(rig.node.state(), State::SwitchOnDisabled);
}

#[test]
fn the_gear_24_is_told_and_turns_twice_as_fast() {
    for (gear, code, rpm) in [(Gear::Ratio24, 2, 200), (Gear::Ratio48, 3, 100)] {
        let mut rig = Rig::with(Config { gear, ..config() });
        assert_eq!(rig.read(0x2102, 0), Ok(code));
        rig.write(0x2410, 5, rpm, 1).unwrap();
        assert_eq!(rig.write(0x2410, 5, rpm + 1, 1), Err(0x0609_0030));
        rig.write(0x6060, 0, 2, 1).unwrap();
        rig.enable();
        rig.turn(0x000F, 1000);
        rig.pass_ms(3000);
        assert_eq!(rig.read(0x60FF, 0), Ok(rpm.cast_unsigned()), "CN-35: limited to the most of the gear");
        assert_eq!(rig.read(0x606C, 0), Ok(rpm.cast_unsigned()));
    }
    let at = profidrive::can_bus::canopen::Address::new(0x2410, 5);
    let limits = |gear| dictionary::entry(objects(gear), at).unwrap().limits;
    assert_eq!(limits(Gear::Ratio24), Limits::Range(1, 200));
}
