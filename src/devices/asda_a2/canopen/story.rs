//! The story of the ASDA-A2.

use crate::can_bus::canopen::Address;
use crate::can_bus::canopen::cob_id::CobId;
use crate::devices::story::NodeAct::{
    self, Look, Provoke, Read, Repair, Send, SyncUntil, Text, Title, Wait, Write,
};
use crate::devices::story::PLACE;

/// 180h plus the node number, the identifier of TPDO 1.
const TPDO_1: u32 = 0x180 + PLACE as u32;
const CONTROLWORD: Address = Address::new(0x6040, 0);

/// Mapping, enabling, profile position, an alarm.
pub(crate) const STORY: &[NodeAct] = &[
    Read(Address::new(0x1000, 0), "1000h:00"),
    Read(Address::new(0x1018, 2), "1018h:02"),
    Title("Mapping: TPDO 1 is to be status word and position, after every SYNC"),
    Write(Address::new(0x1800, 1), &(TPDO_1 | CobId::INVALID).to_le_bytes(), "written"),
    Write(Address::new(0x1A00, 0), &[0], "written"),
    Write(Address::new(0x1A00, 1), &0x6041_0010_u32.to_le_bytes(), "written"),
    Write(Address::new(0x1A00, 2), &0x6064_0020_u32.to_le_bytes(), "written"),
    Write(Address::new(0x1A00, 0), &[2], "written"),
    Write(Address::new(0x1800, 2), &[1], "written"),
    Write(Address::new(0x1800, 1), &TPDO_1.to_le_bytes(), "written"),
    Send(0x000, &[0x01, PLACE]),
    Title("Enabling: the state machine of CiA 402, by SDO here"),
    Write(Address::new(0x6060, 0), &[1], "written"),
    Write(CONTROLWORD, &[0x06, 0], "written"),
    SyncUntil("ready to switch on"),
    Write(CONTROLWORD, &[0x07, 0], "written"),
    SyncUntil("switched on"),
    Write(CONTROLWORD, &[0x0F, 0], "written"),
    SyncUntil("operation enabled"),
    Title("Profile position: a target, then the rising edge of bit 4"),
    Write(Address::new(0x6081, 0), &1_000_000_u32.to_le_bytes(), "written"),
    Write(Address::new(0x607A, 0), &500_000_i32.to_le_bytes(), "written"),
    Write(CONTROLWORD, &[0x1F, 0], "written"),
    SyncUntil("set-point acknowledge"),
    Write(CONTROLWORD, &[0x0F, 0], "written"),
    SyncUntil("target reached"),
    Title("An alarm, and how to leave it"),
    Text("The encoder fails: EMCY says which alarm, the panel shows it, the servo is off."),
    Provoke("011"),
    Wait("EMCY"),
    Look("011"),
    SyncUntil("fault"),
    Read(Address::new(0x603F, 0), "7305h"),
    Text("The cause is removed. Bit 7 of the control word resets the alarm."),
    Repair,
    Write(CONTROLWORD, &[0x80, 0], "written"),
    SyncUntil("switch on disabled"),
];
