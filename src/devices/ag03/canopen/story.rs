//! The story of the AG03/1 on CANopen.

use crate::can_bus::canopen::Address;
use crate::devices::story::NodeAct::{self, Provoke, Read, Repair, Send, Text, Title, Wait, Write};
use crate::devices::story::PLACE;

const RPDO_1: u16 = 0x200 + PLACE as u16;
const RPDO_3: u16 = 0x400 + PLACE as u16;

/// Parameters, enabling, a travel job, a fault.
pub(crate) const STORY: &[NodeAct] = &[
    Read(Address::new(0x1000, 0), "1000h:00"),
    Read(Address::new(0x1008, 0), "AG03"),
    Title("Parameters by SDO"),
    Text("The calibration value becomes the position of the standing shaft."),
    Write(Address::new(0x607C, 0), &2_500_i32.to_le_bytes(), "written"),
    Read(Address::new(0x6064, 0), "2500"),
    Text("A control word before the node is started is refused, with the code of the reason."),
    Write(Address::new(0x6040, 0), &[0x06, 0x01], "08000022h"),
    Title("Enabling: control words by RPDO 1, the status word by TPDO 1"),
    Send(0x000, &[0x01, PLACE]),
    Wait("switch on disabled"),
    Send(RPDO_1, &[0x06, 0x01]),
    Wait("ready to switch on"),
    Send(RPDO_1, &[0x07, 0x01]),
    Wait("switched on"),
    Send(RPDO_1, &[0x0F, 0x01]),
    Wait("operation enabled"),
    Title("A travel job: RPDO 3 is control word and target position"),
    Send(RPDO_3, &[0x1F, 0x00, 0x88, 0x13, 0x00, 0x00]),
    Wait("target reached"),
    Read(Address::new(0x6064, 0), "5000"),
    Title("A fault, and how to leave it"),
    Text("An internal error is simulated: EMCY, error register and state show it."),
    Provoke("F"),
    Wait("EMCY"),
    Wait("fault"),
    Read(Address::new(0x1003, 1), "1003h:01"),
    Text("The cause is removed. Bit 7 of the control word resets the fault."),
    Repair,
    Send(RPDO_1, &[0x80, 0x00]),
    Wait("switch on disabled"),
];
