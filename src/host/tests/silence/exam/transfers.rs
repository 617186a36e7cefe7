//! Thirty more mistakes on CANopen: SDO, block transfer, mapping, identifiers, LSS, NMT, drives.

use core::time::Duration;

use super::bus::{OnBus, enable, operational};
use crate::can_bus::can::{Frame, Id};
use crate::host::tests::silence::nodes::{Bus, frame};
use crate::host::tests::silence::slaves::CYCLE;

/// Frames of a transfer, one after the other.
fn sdo(bus: &mut Bus, frames: &[[u8; 8]]) {
    for octets in frames {
        bus.sdo(octets);
    }
}

/// A PDO is taken off, and what was said of that with it.
fn off(bus: &mut Bus, communication: u16, id: i64) {
    bus.write(communication, 1, 0x8000_0000 | id, 4);
    bus.write(communication + 0x200, 0, 0, 1);
    bus.take_news();
}

fn lss(bus: &mut Bus, frames: &[[u8; 8]]) {
    for octets in frames {
        bus.send(&frame(0x7E5, octets));
    }
}

pub(super) const TRANSFERS: &[OnBus] = &[
    (
        "a block download that is too long for its object",
        "terminal",
        |bus| sdo(bus, &[[0xC2, 0x17, 0x10, 0, 200, 0, 0, 0]]),
        &["1017h:00", "200 octets", "expected 2"],
    ),
    (
        "a block upload with blocks of 0 segments",
        "terminal",
        |bus| sdo(bus, &[[0xA0, 0x08, 0x10, 0, 0, 0, 0, 0]]),
        &["1008h:00", "block size", "1 to 127 segments, got 0"],
    ),
    (
        "a block upload with blocks of 128 segments",
        "terminal",
        |bus| sdo(bus, &[[0xA0, 0x08, 0x10, 0, 128, 0, 0, 0]]),
        &["1008h:00", "block size", "1 to 127"],
    ),
    (
        "a block download whose check sum is wrong",
        "terminal",
        |bus| {
            let at = [[0xC6, 0x17, 0x10, 0, 2, 0, 0, 0], [0x81, 0xC8, 0, 0, 0, 0, 0, 0]];
            sdo(bus, &[at[0], at[1], [0xD5, 0x12, 0x34, 0, 0, 0, 0, 0]]);
        },
        &["1017h:00", "CRC"],
    ),
    (
        "a block download that begins with segment 2",
        "terminal",
        |bus| sdo(bus, &[[0xC2, 0x17, 0x10, 0, 2, 0, 0, 0], [0x82, 0xC8, 0, 0, 0, 0, 0, 0]]),
        &["1017h:00", "segment 1 is missing", "from 1"],
    ),
    (
        "a segmented download that is shorter than it was announced",
        "terminal",
        |bus| sdo(bus, &[[0x21, 0x17, 0x10, 0, 2, 0, 0, 0], [0x0D, 5, 0, 0, 0, 0, 0, 0]]),
        &["1017h:00", "1 octet", "expected 2"],
    ),
    (
        "a sub-index that the object does not have",
        "drive",
        |bus| _ = bus.write(0x6040, 1, 6, 2),
        &["6040h:01", "sub-index"],
    ),
    (
        "a control word is mapped with 32 bits",
        "drive",
        |bus| {
            off(bus, 0x1400, 0x205);
            bus.write(0x1600, 1, 0x6040_0020, 4);
        },
        &["1600h:01", "60400020h", "16"],
    ),
    (
        "the status word is mapped to an RPDO",
        "drive",
        |bus| {
            off(bus, 0x1400, 0x205);
            bus.write(0x1600, 1, 0x6041_0010, 4);
        },
        &["1600h:01", "60410010h", "cannot be mapped"],
    ),
    (
        "an object that is not there is mapped",
        "drive",
        |bus| {
            off(bus, 0x1800, 0x185);
            bus.write(0x1A00, 1, 0x5FFF_0010, 4);
        },
        &["1A00h:01", "5FFF0010h", "does not exist"],
    ),
    (
        "a mapping counts more objects than it has",
        "drive",
        |bus| {
            off(bus, 0x1400, 0x205);
            bus.write(0x1600, 1, 0x6040_0010, 4);
            for sub in 2..=8 {
                bus.write(0x1600, sub, 0, 4);
            }
            bus.take_news();
            bus.write(0x1600, 0, 2, 1);
        },
        &["1600h:00", "sub-index 2"],
    ),
    (
        "an identifier of 29 bits for a PDO",
        "asda-a2",
        |bus| {
            off(bus, 0x1400, 0x205);
            bus.write(0x1400, 1, 0x2000_0205, 4);
        },
        &["1400h:01", "20000205h", "29 bits"],
    ),
    (
        "transmission type 245",
        "drive",
        |bus| _ = bus.write(0x1800, 2, 245, 1),
        &["1800h:02", "got 245", "expected 0 to 240 or 252 to 255"],
    ),
    (
        "another identifier for a TPDO that is on",
        "drive",
        |bus| _ = bus.write(0x1800, 1, 0x285, 4),
        &["1800h:01", "the PDO is on", "bit 31"],
    ),
    (
        "an RPDO with the identifier of SYNC",
        "drive",
        |bus| {
            bus.write(0x1400, 1, 0x8000_0205, 4);
            bus.write(0x1400, 1, 0x80, 4);
            operational_with_news(bus);
        },
        &["RPDO1 (1400h:01)", "SYNC (1005h)", "080h"],
    ),
    (
        "the control word by SDO and by RPDO",
        "drive",
        |bus| {
            operational(bus);
            for word in [6, 7, 0xF] {
                for _ in 0..3 {
                    bus.send(&frame(0x205, &[0, 0, 0, 0, 0, 0, 0, 0]));
                    bus.wait(CYCLE);
                }
                bus.write(0x6040, 0, word, 2);
            }
            bus.send(&frame(0x205, &[0, 0, 0, 0, 0, 0, 0, 0]));
        },
        &["6040h:00", "SDO", "RPDO1", "1600h"],
    ),
    (
        "an RPDO with the identifier of node 0",
        "drive",
        |bus| {
            operational(bus);
            for _ in 0..5 {
                bus.send(&frame(0x200, &[6, 0]));
                bus.wait(CYCLE);
            }
        },
        &["200h", "205h", "node number"],
    ),
    (
        "an SDO with the identifier of node 0",
        "terminal",
        |bus| {
            for _ in 0..5 {
                bus.send(&frame(0x600, &[0x40, 0, 0x10, 0, 0, 0, 0, 0]));
                bus.wait(CYCLE);
            }
        },
        &["600h", "605h", "node number"],
    ),
    (
        "an NMT command for node 200",
        "terminal",
        |bus| _ = bus.send(&frame(0, &[1, 200])),
        &["NMT", "200", "1 to 127"],
    ),
    (
        "an NMT command as a remote frame",
        "terminal",
        |bus| _ = bus.send(&Frame::remote(Id::base(0).unwrap(), 2).unwrap()),
        &["NMT", "remote"],
    ),
    (
        "SYNC with another identifier",
        "drive",
        |bus| {
            bus.write(0x1800, 1, 0x8000_0185, 4);
            bus.write(0x1800, 2, 1, 1);
            bus.write(0x1800, 1, 0x185, 4);
            operational(bus);
            for _ in 0..100 {
                bus.send(&frame(0x90, &[]));
                bus.wait(CYCLE * 5);
            }
        },
        &["TPDO1", "SYNC", "080h (1005h)"],
    ),
    (
        "LSS gives node number 200",
        "terminal",
        |bus| lss(bus, &[[4, 1, 0, 0, 0, 0, 0, 0], [0x11, 200, 0, 0, 0, 0, 0, 0]]),
        &["LSS", "node number 200", "1 to 127"],
    ),
    (
        "LSS gives a rate that is not in the table",
        "terminal",
        |bus| lss(bus, &[[4, 1, 0, 0, 0, 0, 0, 0], [0x13, 0, 9, 0, 0, 0, 0, 0]]),
        &["LSS", "rate 9", "table 0"],
    ),
    (
        "EMCY gets another identifier while it is on",
        "terminal",
        |bus| _ = bus.write(0x1014, 0, 0x86, 4),
        &["1014h:00", "bit 31"],
    ),
    (
        "the history of errors is cleared with 1",
        "drive",
        |bus| _ = bus.write(0x1003, 0, 1, 1),
        &["1003h:00", "expected 0", "got 1"],
    ),
    (
        "a time of heartbeat for node 200",
        "asda-a2",
        |bus| _ = bus.write(0x1016, 1, 0x00C8_01F4, 4),
        &["1016h:01", "expected 0 to 8388607", "got 13107700"],
    ),
    (
        "a start behind a quick stop",
        "drive",
        |bus| {
            bus.write(0x6060, 0, 1, 1);
            enable(bus);
            bus.write(0x6040, 0, 0x0B, 2);
            bus.wait(CYCLE * 30);
            bus.write(0x607A, 0, 50_000, 4);
            bus.write(0x6040, 0, 0x1B, 2);
            bus.wait(CYCLE * 30);
        },
        &["bit 2", "quick stop", "0006h"],
    ),
    (
        "a target position in profile velocity",
        "drive",
        |bus| {
            bus.write(0x6060, 0, 3, 1);
            enable(bus);
            bus.write(0x607A, 0, 1000, 4);
            bus.write(0x6040, 0, 0x1F, 2);
            bus.wait(CYCLE * 100);
        },
        &["target velocity", "60FFh"],
    ),
    (
        "another mode during a travel",
        "ag03-1",
        |bus| {
            bus.write(0x6060, 0, 1, 1);
            enable(bus);
            bus.write(0x607A, 0, 1_000_000, 4);
            bus.write(0x6040, 0, 0x1F, 2);
            bus.wait(CYCLE * 5);
            bus.take_news();
            bus.write(0x6060, 0, 2, 1);
        },
        &["6060h:00", "the shaft is moving"],
    ),
    (
        "nobody fetches the rest of an upload",
        "terminal",
        |bus| {
            bus.sdo(&[0x40, 0x08, 0x10, 0, 0, 0, 0, 0]);
            bus.sdo(&[0x80, 0x08, 0x10, 0, 0, 0, 0x04, 0x05]);
            bus.wait(Duration::from_secs(2));
        },
        &["1008h:00", "client", "05040000h"],
    ),
];

/// Starts the node without forgetting what it says of that.
fn operational_with_news(bus: &mut Bus) {
    bus.take_news();
    bus.nmt(1);
}
