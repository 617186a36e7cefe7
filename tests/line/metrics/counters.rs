//! Counters only grow, whatever happens on the lines.

use std::collections::{BTreeMap, BTreeSet};

use profidrive::can_bus::can::{ErrorState, Frame, Id};
use profidrive::can_bus::canopen::NmtState;
use profidrive::can_bus::canopen::nmt::Command;
use profidrive::devices::ag03::profibus::Device;
use profidrive::host::can::{Seat, StoredNode};
use proptest::prelude::*;

use super::text::{is_counter, series};
use super::{Rig, address, status_request};

/// Something that happens on the lines of a rig.
#[derive(Clone, Debug)]
enum Act {
    AddDrive(u8),
    RemoveDrive(u8),
    PowerDrive(u8, bool),
    FaultOfDrive(u8),
    Ask(u8),
    /// Set_Prm that is refused.
    WrongPrm(u8),
    Noise(u8),
    AddNode(u8),
    RemoveNode(usize),
    PowerNode(usize, bool),
    FaultOfNode(usize),
    Sdo(u8),
    Operational,
    BusOff(usize),
    Pass(u64),
}

fn act() -> impl Strategy<Value = Act> {
    let drive = 3..6_u8;
    let node = 1..4_u8;
    prop_oneof![
        drive.clone().prop_map(Act::AddDrive),
        drive.clone().prop_map(Act::RemoveDrive),
        (drive.clone(), any::<bool>()).prop_map(|(drive, on)| Act::PowerDrive(drive, on)),
        drive.clone().prop_map(Act::FaultOfDrive),
        drive.clone().prop_map(Act::Ask),
        drive.prop_map(Act::WrongPrm),
        any::<u8>().prop_map(Act::Noise),
        node.clone().prop_map(Act::AddNode),
        (0..4_usize).prop_map(Act::RemoveNode),
        (0..4_usize, any::<bool>()).prop_map(|(node, on)| Act::PowerNode(node, on)),
        (0..4_usize).prop_map(Act::FaultOfNode),
        node.prop_map(Act::Sdo),
        Just(Act::Operational),
        (0..4_usize).prop_map(Act::BusOff),
        (1..20_u64).prop_map(Act::Pass),
    ]
}

/// Who is on the lines: each has a number that nobody had before.
#[derive(Default)]
struct Known {
    next: u32,
    drives: BTreeMap<u8, u32>,
    /// By seat, in the order of the nodes.
    nodes: Vec<(Seat, u32)>,
}

impl Known {
    fn fresh(&mut self) -> u32 {
        self.next += 1;
        self.next
    }
}

impl Rig {
    fn act(&mut self, known: &mut Known, act: &Act) {
        let now = self.now;
        let seat = |known: &Known, at: usize| known.nodes.get(at).map(|(seat, _)| *seat);
        match *act {
            Act::AddDrive(drive) if known.drives.contains_key(&drive) => {}
            Act::AddDrive(drive) => {
                self.add_drive(drive);
                let fresh = known.fresh();
                known.drives.insert(drive, fresh);
            }
            Act::RemoveDrive(drive) => {
                assert_eq!(self.bus.remove(address(drive)).is_some(), known.drives.remove(&drive).is_some());
            }
            Act::PowerDrive(drive, on) => {
                self.bus.with(
                    address(drive),
                    |device: &mut Device| {
                        if on { device.power_on(now) } else { device.power_off(now) }
                    },
                );
            }
            Act::FaultOfDrive(drive) => {
                for fault in [true, false] {
                    self.bus.with(address(drive), |device: &mut Device| {
                        let inputs = profidrive::devices::ag03::drive::Inputs {
                            internal_fault: fault,
                            ..*device.inputs()
                        };
                        device.set_inputs(self.now, inputs);
                    });
                    self.pass(5);
                }
            }
            Act::Ask(drive) => self.request(&status_request(drive)),
            Act::WrongPrm(drive) => {
                // Ident number 0.
                let body = [drive | 0x80, 0x82, 0x6D, 61, 62, 0x80, 1, 1, 11, 0, 0, 0];
                let sum = body.iter().fold(0_u8, |sum, octet| sum.wrapping_add(*octet));
                let mut telegram = vec![0x68, 12, 12, 0x68];
                telegram.extend(body);
                telegram.extend([sum, 0x16]);
                self.request(&telegram);
            }
            Act::Noise(octet) => self.request(&[octet; 3]),
            Act::AddNode(number) => {
                if known.nodes.len() < 4 {
                    let seat = self.add_node(number, "ap10");
                    let fresh = known.fresh();
                    known.nodes.push((seat, fresh));
                }
            }
            Act::RemoveNode(at) => {
                if let Some(seat) = seat(known, at) {
                    self.can.remove(now, seat);
                    self.nodes.remove(at);
                    known.nodes.remove(at);
                }
            }
            Act::PowerNode(at, on) => {
                if let Some(seat) = seat(known, at) {
                    self.can.with(now, seat, |node: &mut StoredNode, now| {
                        node.act(now, |device, now| match on {
                            true if !device.is_on() => device.power_on(now),
                            true => {}
                            false => device.power_off(now),
                        });
                    });
                }
            }
            Act::FaultOfNode(at) => {
                if let Some(seat) = seat(known, at) {
                    self.can.with(now, seat, |node: &mut StoredNode, now| {
                        node.act(now, |device, now| {
                            device.act(now, &mut |device| {
                                // Refused while it is off.
                                let _ = device.provoke(now, "battery-empty");
                                device.make_nominal(now);
                            });
                        });
                    });
                }
            }
            Act::Sdo(number) => {
                let id = Id::base(0x600 + u16::from(number)).unwrap();
                // An object that there is not.
                self.send(Frame::with(id, [0x40, 0xFF, 0x5F, 0, 0, 0, 0, 0]));
            }
            Act::Operational => self.send(Command::Enter(NmtState::Operational).frame(None)),
            Act::BusOff(at) => {
                if let Some(seat) = seat(known, at) {
                    self.can.provoke(now, seat, ErrorState::BusOff);
                }
            }
            Act::Pass(milliseconds) => self.pass(milliseconds),
        }
        self.pass(1);
    }
}

/// Whose a series is: the number of the drive, or of the node. `None`: of the line.
fn owner(series: &str, known: &Known, rig: &Rig, twins: &mut BTreeMap<(u8, u8), u32>) -> Option<u32> {
    let label = |name: &str| -> Option<u8> {
        let (_, rest) = series.split_once(&format!("{name}=\""))?;
        rest.split('"').next()?.parse().ok()
    };
    let address = label("address")?;
    if label("line") == Some(1) {
        return Some(known.drives[&address]);
    }
    // Which twin is which shows in nothing but its counters. One alone is itself.
    let of = |(seat, number): &(Seat, u32)| {
        let node = rig.can.participant::<StoredNode>(*seat)?;
        (node.node_id().number() == address).then_some(*number)
    };
    let same: Vec<u32> = known.nodes.iter().filter_map(of).collect();
    let twin = label("twin").unwrap_or(0);
    // Who had this place and is there still has it; who is new has the first that is free.
    if let Some(kept) = twins.get(&(address, twin)).filter(|kept| same.contains(kept)) {
        return Some(*kept);
    }
    let taken: Vec<u32> = twins
        .iter()
        .filter(|((at, _), number)| *at == address && same.contains(number))
        .map(|(_, number)| *number)
        .collect();
    let fresh = same.iter().find(|number| !taken.contains(number)).copied();
    let fresh = fresh.unwrap_or_else(|| panic!("{series}: nobody is there"));
    twins.insert((address, twin), fresh);
    Some(fresh)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 16, ..ProptestConfig::default() })]

    /// Whoever comes, goes, is switched, or fails: a counter of one that stays never falls, one that comes begins at 0, and
    /// one that goes leaves nothing behind.
    #[test]
    fn no_counter_of_a_living_station_ever_falls(acts in prop::collection::vec(act(), 1..40)) {
        let (mut rig, mut known) = (Rig::new(), Known::default());
        let (mut twins, mut before) = (BTreeMap::new(), BTreeMap::<(String, Option<u32>), f64>::new());
        for act in core::iter::once(Act::Pass(1)).chain(acts) {
            rig.act(&mut known, &act);
            let text = rig.scrape();
            let mut now = BTreeMap::new();
            for (name, value) in series(&text).into_iter().filter(|(name, _)| is_counter(name)) {
                let owner = owner(&name, &known, &rig, &mut twins);
                now.insert((name, owner), value);
            }
            for (key, value) in &now {
                match before.get(key) {
                    Some(earlier) => prop_assert!(value >= earlier, "{key:?}: {earlier} to {value} by {act:?}"),
                    // A node boots when it is made, and its fault may be there at once: that is counted.
                    None => prop_assert!(*value <= 1.0, "{key:?} begins at {value}"),
                }
            }
            let owners: BTreeSet<u32> = now.keys().filter_map(|(_, owner)| *owner).collect();
            prop_assert_eq!(owners.len(), known.drives.len() + known.nodes.len());
            before = now;
        }
    }
}
