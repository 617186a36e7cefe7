//! NMT and boot-up (`canopen-link.md` 3; page `docs/canopen-conformance.md`).

use std::time::Duration;

use profidrive::can_bus::can::{Frame, Id};
use profidrive::can_bus::canopen::nmt::NmtState;
use profidrive::can_bus::canopen::nmt::NmtState::{Operational, PreOperational, Stopped};
use profidrive::can_bus::canopen::{Event, Notice, Policy, Reset};

use crate::canopen_device::Plain;
use crate::canopen_device::rig::Rig;

/// Command, and where it leads; `None` boots.
const COMMANDS: [(u8, Option<NmtState>); 5] = [
    (0x01, Some(Operational)),
    (0x02, Some(Stopped)),
    (0x80, Some(PreOperational)),
    (0x81, None),
    (0x82, None),
];

fn in_state(state: NmtState) -> Rig {
    let mut rig = Rig::new(Policy::CIA_301);
    match state {
        PreOperational => {}
        Operational => drop(rig.data(0, &[0x01, 5])),
        Stopped => drop(rig.data(0, &[0x02, 5])),
    }
    assert_eq!(rig.node.state(), Some(state));
    rig
}

#[test]
fn k_01_power_on_sends_one_boot_up_and_nothing_before_it() {
    let mut rig = Rig::off(Policy::CIA_301, Plain::new(5));
    assert_eq!(rig.node.state(), None);
    assert!(rig.sdo_frames([0x40, 0, 0x10, 0, 0, 0, 0, 0]).is_empty());
    assert!(rig.remote(0x705, 1).is_empty());
    assert!(rig.pass(Duration::from_secs(10)).is_empty());
    assert_eq!(rig.power_on(), ["705#00"]);
    assert_eq!(rig.node.state(), Some(PreOperational));
    assert!(rig.pass(Duration::from_secs(10)).is_empty());
    assert!(rig.drain().is_empty());
}

#[test]
fn k_02_k_03_the_whole_state_table_for_its_number_and_for_all() {
    for node in [5, 0] {
        for from in [Stopped, Operational, PreOperational] {
            for (command, to) in COMMANDS {
                let mut rig = in_state(from);
                rig.device.notices.clear();
                let seen = rig.data(0x000, &[command, node]);
                let boots = seen.iter().filter(|frame| **frame == "705#00").count();
                assert_eq!(rig.node.state(), Some(to.unwrap_or(PreOperational)), "{from} {command:02X}");
                assert_eq!(boots, usize::from(to.is_none()), "{from} {command:02X}: {seen:?}");
                if to == Some(from) {
                    assert!(rig.device.notices.is_empty() && seen.is_empty(), "no change, no effect");
                }
            }
        }
    }
}

#[test]
fn k_04_commands_for_others_have_no_effect() {
    for node in (1..=255).filter(|node| *node != 5) {
        let mut rig = in_state(Operational);
        for (command, _) in COMMANDS {
            assert!(rig.data(0x000, &[command, node]).is_empty());
            assert_eq!(rig.node.state(), Some(Operational), "{command:02X} {node}");
        }
    }
}

#[test]
fn a_command_that_is_ignored_is_told_once_until_one_is_followed() {
    let ignored = |rig: &mut Rig| -> Vec<(u8, bool)> {
        let of =
            |event| if let Event::NmtIgnored { command, off } = event { Some((command, off)) } else { None };
        rig.events().into_iter().filter_map(of).collect()
    };
    let mut rig = in_state(PreOperational);
    for octets in [[0x07, 5], [0x07, 5], [0x07, 0], [0x09, 6], [0x01, 6]] {
        rig.data(0x000, &octets);
    }
    assert_eq!(ignored(&mut rig), [(0x07, false)]);
    rig.data(0x000, &[0x00, 0]);
    assert_eq!(ignored(&mut rig), [(0x00, false)]);
    rig.data(0x000, &[0x01, 5]);
    rig.data(0x000, &[0x00, 5]);
    assert_eq!(ignored(&mut rig), [(0x00, false)], "again behind one that is followed");
    rig.node.power_off();
    for octets in [[0x01, 5], [0x01, 5], [0x80, 0], [0x81, 6]] {
        assert!(rig.data(0x000, &octets).is_empty());
    }
    assert_eq!(ignored(&mut rig), [(0x01, true), (0x80, true)]);
}

#[test]
fn k_05_malformed_commands_have_no_effect() {
    for from in [Stopped, Operational, PreOperational] {
        let mut rig = in_state(from);
        for octets in [&[][..], &[0x81], &[0x81, 5, 0], &[0x81, 5, 0, 0, 0, 0, 0, 0]] {
            assert!(rig.data(0x000, octets).is_empty());
        }
        for dlc in 0..=8 {
            assert!(rig.remote(0x000, dlc).is_empty());
        }
        assert!(rig.extended(0x000, &[0x81, 5]).is_empty());
        for command in (0..=255).filter(|command| COMMANDS.iter().all(|known| known.0 != *command)) {
            assert!(rig.data(0x000, &[command, 5]).is_empty());
        }
        assert_eq!(rig.node.state(), Some(from));
    }
}

#[test]
fn k_06_reset_node_brings_everything_back_and_reset_communication_only_its_objects() {
    for (command, reset, text) in [(0x81, Reset::Node, b"Hell"), (0x82, Reset::Communication, b"Good")] {
        let mut rig = Rig::new(Policy::CIA_301);
        rig.write(0x1017, 0, 100, 2).unwrap();
        let [a, b, c, d] = *b"Good";
        assert_eq!(rig.sdo([0x23, 0x00, 0x20, 0, a, b, c, d]), [0x60, 0x00, 0x20, 0, 0, 0, 0, 0]);
        assert_eq!(rig.data(0x000, &[command, 5]), ["705#00"]);
        assert!(rig.device.notices.contains(&Notice::Reset(reset)));
        assert_eq!(rig.read(0x1017, 0), Ok(0), "a communication object");
        let answer = rig.sdo([0x40, 0x00, 0x20, 0, 0, 0, 0, 0]);
        if answer[0] == 0x43 {
            assert_eq!(answer[4..], text[..], "kept over {command:02X}");
        } else {
            assert_eq!(answer[..5], [0x41, 0x00, 0x20, 0, 11], "the default again");
            assert_eq!(text, b"Hell");
        }
    }
}

#[test]
fn k_06_the_node_number_is_read_again_with_a_reset_and_not_before() {
    for command in [0x81, 0x82] {
        let mut rig = Rig::new(Policy::CIA_301);
        rig.device.node_id = profidrive::can_bus::canopen::NodeId::new(9).unwrap();
        assert_eq!(rig.read(0x1800, 1), Ok(0x185));
        assert_eq!(rig.data(0x000, &[command, 5]), ["709#00"]);
        assert_eq!(rig.read(0x1800, 1), Ok(0x189));
        assert_eq!(rig.read(0x1014, 0), Ok(0x089));
    }
}

#[test]
fn k_07_reset_of_all_boots_each_node_once_with_its_own_frame() {
    let mut rigs: Vec<Rig> = (1..=127)
        .map(|node| {
            let mut rig = Rig::off(Policy::CIA_301, Plain::new(node));
            rig.power_on();
            rig
        })
        .collect();
    let command = Frame::with(Id::base(0).unwrap(), [0x81, 0]);
    for (node, rig) in (1..).zip(&mut rigs) {
        assert_eq!(rig.frame(&command), [format!("{:03X}#00", 0x700 + node)]);
    }
}
