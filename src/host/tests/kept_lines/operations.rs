//! What happens to the devices, and what each of them has that is kept.

use proptest::prelude::*;

use super::faulty_disk::Failing;
use crate::can_bus::canopen;
use crate::host::list::Group;

/// The object that is written: the heartbeat time, or v-Pos of an AG03/1, which does not keep that.
pub(super) fn object(which: usize) -> canopen::Address {
    if which == NO_1010H { canopen::Address::new(0x2410, 5) } else { canopen::Address::new(0x1017, 0) }
}

/// The object with the number of a node that is given one over the bus, and the command of a download that sets it.
pub(super) fn number_object(which: usize) -> Option<(canopen::Address, u8)> {
    match which {
        AP10 => Some((canopen::Address::new(0x5F0A, 1), 0x2F)),
        ASDA_A2 => Some((canopen::Address::new(0x2300, 0), 0x2B)),
        _ => None,
    }
}

pub(super) const AP10: usize = 6;
pub(super) const ASDA_A2: usize = 7;

/// It keeps what is stored with PNU 971.
pub(super) const PROFIDRIVE: usize = 9;
pub(super) const STORE: u16 = 971;

/// What a device keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Part {
    /// The parameter or object that is written, or the address of a station.
    Value,
    /// The node number, if it is an object.
    Number,
}

pub(super) const PARTS: [Part; 2] = [Part::Value, Part::Number];

/// SW8 and the pattern of SW1 to SW7 that resets everything.
pub(super) const RESET_ALL: u16 = 0x81;

/// The AG03/1 on CANopen has no "save": it keeps by itself what is written.
pub(super) const NO_1010H: usize = 5;
/// Frames of SDOs to and from a node.
pub(super) const TO_NODE: u16 = 0x600;
pub(super) const FROM_NODE: u16 = 0x580;
/// "save" to 1010h:1.
pub(super) const SAVE: [u8; 8] = [0x23, 0x10, 0x10, 0x01, 0x73, 0x61, 0x76, 0x65];
pub(super) const SAVED: [u8; 8] = [0x60, 0x10, 0x10, 0x01, 0, 0, 0, 0];
/// There is no 1010h: it keeps what is written by itself.
pub(super) const NO_SAVE: [u8; 8] = [0x80, 0x10, 0x10, 0x01, 0, 0, 0x02, 0x06];

/// A device of each kind, with what it is given by. Of stations the addresses behind the first are free.
pub(super) static KINDS: &[(Group, &str)] = &[
    (Group::Drive, "10"),
    (Group::Drive, "20,model=ag03"),
    (Group::PpoDrive, "30,parameters=TABLE"),
    (Group::Station, "40,gsd=GSD"),
    (Group::Station, "50,gsd=GSD"),
    (Group::Node, "1"),
    (Group::Node, "2,device=ap10"),
    (Group::Node, "3,device=asda-a2"),
    (Group::Node, "4,eds=EDS"),
    (Group::Profidrive, "60,parameters=OWN"),
];

#[derive(Clone, Copy, Debug)]
pub(super) enum Op {
    Add(usize),
    Remove(usize),
    /// Off and on again.
    Switch(usize),
    /// A parameter, an object, or the address.
    Write(usize),
    /// Another node number over the bus.
    Renumber(usize),
    /// Another address or node number by the DIP switches.
    Readdress(usize),
    /// Everything from the factory by the DIP switches, which have their positions again behind that.
    Reset(usize),
    /// 1010h:1 of a node.
    Save(usize),
    Disk(Failing),
    /// So many images are written.
    Writer(u8),
    /// Everything that waits is written by a disk that works.
    Settle,
    Kill {
        calls: u32,
        power: Option<usize>,
    },
    /// Ended properly.
    Restart,
}

pub(super) fn op() -> impl Strategy<Value = Op> {
    let of = 0..KINDS.len();
    let failing = (any::<bool>(), any::<bool>(), any::<bool>(), any::<bool>())
        .prop_map(|(write, sync, rename, sync_names)| Failing { write, sync, rename, sync_names });
    prop_oneof![
        6 => of.clone().prop_map(Op::Add),
        2 => of.clone().prop_map(Op::Remove),
        2 => of.clone().prop_map(Op::Switch),
        12 => of.clone().prop_map(Op::Write),
        4 => of.clone().prop_map(Op::Renumber),
        2 => of.clone().prop_map(Op::Readdress),
        1 => of.clone().prop_map(Op::Reset),
        6 => of.prop_map(Op::Save),
        2 => failing.prop_map(Op::Disk),
        2 => Just(Op::Disk(Failing::default())),
        6 => (1..4_u8).prop_map(Op::Writer),
        2 => Just(Op::Settle),
        1 => (0..12_u32, proptest::option::of(any::<usize>())).prop_map(|(calls, power)| Op::Kill { calls, power }),
        1 => Just(Op::Restart),
    ]
}
