//! The story of the AP10.

use core::time::Duration;

use crate::can_bus::canopen::Address;
use crate::devices::story::NodeAct::{
    self, Input, Look, Pass, Provoke, Read, Repair, Send, Text, Title, Wait, Write,
};
use crate::devices::story::PLACE;

const RPDO_1: u16 = 0x200 + PLACE as u16;

/// A set point, a hand at the shaft, a battery.
pub(crate) const STORY: &[NodeAct] = &[
    Read(Address::new(0x1000, 0), "1000h:00"),
    Read(Address::new(0x1008, 0), "AP10"),
    Text("Its display test is over."),
    Pass(Duration::from_millis(400)),
    Look("[0]"),
    Title("A set point: RPDO 1 is value and control word, row 2 shows it"),
    Text("TPDO 1 is sent every 100 ms; only changes are shown here."),
    Write(Address::new(0x1800, 5), &100_u16.to_le_bytes(), "written"),
    Send(0x000, &[0x01, PLACE]),
    Send(RPDO_1, &[0x64, 0, 0, 0, 0, 0, 0x04, 0]),
    Wait("set point 1 valid"),
    Look("100"),
    Title("A person turns the shaft in the direction of the arrow"),
    Input("shaft_revolutions", 50.0 / 880.0),
    Wait("50"),
    Look("[50]"),
    Input("shaft_revolutions", 100.0 / 880.0),
    Wait("100"),
    Look("[100]"),
    Title("The battery becomes low"),
    Provoke("battery-critical"),
    Wait("EMCY"),
    Wait("battery critical"),
    Look("battery critical"),
    Text("The battery is replaced."),
    Repair,
    Pass(Duration::from_millis(200)),
    Look("[100]"),
];
