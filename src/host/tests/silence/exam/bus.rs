//! Thirty mistakes on CANopen.

use core::time::Duration;

use crate::can_bus::can::{Frame, Id};
use crate::host::tests::silence::nodes::{Bus, frame};
use crate::host::tests::silence::slaves::CYCLE;

/// A mistake: what it is, at which target, what is sent, and words that are read of it in the log or by `why`.
pub(super) type OnBus = (&'static str, &'static str, fn(&mut Bus), &'static [&'static str]);

pub(super) fn operational(bus: &mut Bus) {
    bus.nmt(1);
    bus.take_news();
}

pub(in crate::host::tests::silence) fn enable(bus: &mut Bus) {
    operational(bus);
    for word in [6, 7, 0xF] {
        bus.write(0x6040, 0, word, 2);
        bus.wait(CYCLE * 10);
    }
    bus.take_news();
}

pub(super) const ON_BUS: &[OnBus] = &[
    (
        "an SDO with the octets of the index exchanged",
        "drive",
        |bus| {
            bus.sdo(&[0x40, 0x60, 0x40, 0, 0, 0, 0, 0]);
        },
        &["4060h", "6040h", "exchanged"],
    ),
    (
        "SDO requests with the identifier of the answers",
        "drive",
        |bus| {
            for _ in 0..5 {
                bus.send(&frame(0x585, &[0x40, 0, 0x10, 0, 0, 0, 0, 0]));
                bus.wait(CYCLE);
            }
        },
        &["585h", "605h"],
    ),
    (
        "process data with the identifier of TPDO1",
        "drive",
        |bus| {
            operational(bus);
            for _ in 0..5 {
                bus.send(&frame(0x185, &[0x06, 0]));
                bus.wait(CYCLE);
            }
        },
        &["185h", "205h"],
    ),
    (
        "an NMT command with its octets exchanged",
        "drive",
        |bus| {
            bus.send(&frame(0, &[5, 1]));
        },
        &["NMT", "exchanged"],
    ),
    (
        "an NMT command of eight octets",
        "drive",
        |bus| {
            bus.send(&frame(0, &[1, 5, 0, 0, 0, 0, 0, 0]));
        },
        &["NMT command of 8 octets", "expected 2"],
    ),
    (
        "a control word with its octets exchanged",
        "drive",
        |bus| {
            operational(bus);
            for word in [0x0600, 0x0700, 0x0F00] {
                bus.write(0x6040, 0, word, 2);
                bus.wait(CYCLE * 10);
            }
        },
        &["6040h = 0600h", "exchanged", "0006h"],
    ),
    (
        "no mode of operation",
        "drive",
        |bus| {
            bus.write(0x6060, 0, 0, 1);
            enable(bus);
            bus.write(0x607A, 0, 5000, 4);
            bus.write(0x6040, 0, 0x1F, 2);
            bus.wait(CYCLE * 10);
        },
        &["6060h"],
    ),
    (
        "a profile velocity of 0",
        "asda-a2",
        |bus| {
            bus.write(0x6060, 0, 1, 1);
            enable(bus);
            bus.write(0x6081, 0, 0, 4);
            bus.write(0x607A, 0, 5000, 4);
            bus.write(0x6040, 0, 0x1F, 2);
            bus.wait(CYCLE * 30);
        },
        &["6081h"],
    ),
    (
        "a velocity in profile position",
        "drive",
        |bus| {
            bus.write(0x6060, 0, 1, 1);
            enable(bus);
            bus.write(0x60FF, 0, 500, 4);
            bus.wait(CYCLE * 10);
        },
        &["607Ah", "001Fh"],
    ),
    (
        "halt from the first word on",
        "drive",
        |bus| {
            bus.write(0x6060, 0, 1, 1);
            operational(bus);
            bus.write(0x607A, 0, 50_000, 4);
            for word in [6, 7, 0x10F, 0x11F] {
                bus.write(0x6040, 0, word, 2);
                bus.wait(CYCLE * 10);
            }
        },
        &["bit 8", "halt"],
    ),
    (
        "a start of homing in profile position",
        "drive",
        |bus| {
            bus.write(0x6060, 0, 1, 1);
            enable(bus);
            bus.write(0x6098, 0, 35, 1);
            bus.write(0x6040, 0, 0x1F, 2);
            bus.wait(CYCLE * 10);
        },
        &["607Ah"],
    ),
    (
        "a target beyond 607Dh",
        "drive",
        |bus| {
            bus.write(0x6060, 0, 1, 1);
            bus.write(0x607D, 1, -1000, 4);
            bus.write(0x607D, 2, 1000, 4);
            enable(bus);
            bus.write(0x607A, 0, 90_000, 4);
            bus.write(0x6040, 0, 0x1F, 2);
            bus.wait(CYCLE * 300);
        },
        &["607Dh"],
    ),
    (
        "a mapping is written while the PDO is on",
        "drive",
        |bus| {
            bus.write(0x1600, 0, 0, 1);
        },
        &["1600h:00", "the PDO is on", "1400h:01"],
    ),
    (
        "a mapping is written while sub-index 0 is not 0",
        "terminal",
        |bus| {
            bus.write(0x1400, 1, 0x8000_0205, 4);
            bus.take_news();
            bus.write(0x1600, 1, 0x6200_0108, 4);
        },
        &["1600h:01", "sub-index 0", "0"],
    ),
    (
        "an object that cannot be mapped",
        "drive",
        |bus| {
            bus.write(0x1400, 1, 0x8000_0205, 4);
            bus.write(0x1600, 0, 0, 1);
            bus.take_news();
            bus.write(0x1600, 1, 0x1018_0120, 4);
        },
        &["1600h:01", "cannot be mapped", "10180120h"],
    ),
    (
        "more than eight octets in a PDO",
        "drive",
        |bus| {
            bus.write(0x1400, 1, 0x8000_0205, 4);
            bus.write(0x1600, 0, 0, 1);
            bus.write(0x1600, 1, 0x6040_0010, 4);
            bus.write(0x1600, 2, 0x607A_0020, 4);
            bus.write(0x1600, 3, 0x60FF_0020, 4);
            bus.take_news();
            bus.write(0x1600, 0, 3, 1);
        },
        &["1600h:00", "eight octets"],
    ),
    (
        "a reserved identifier for an RPDO",
        "drive",
        |bus| {
            bus.write(0x1400, 1, 0x8000_0205, 4);
            bus.take_news();
            bus.write(0x1400, 1, 0x701, 4);
        },
        &["1400h:01", "00000701h", "reserved"],
    ),
    (
        "TPDO1 of transmission type 1, and nobody sends SYNC",
        "drive",
        |bus| {
            bus.write(0x1800, 1, 0x8000_0185, 4);
            bus.write(0x1800, 2, 1, 1);
            bus.write(0x1800, 1, 0x185, 4);
            operational(bus);
            bus.wait(Duration::from_secs(10));
        },
        &["TPDO1", "SYNC", "080h", "1800h:02"],
    ),
    (
        "a heartbeat consumer that is faster than the producer",
        "terminal",
        |bus| {
            bus.write(0x1016, 1, 0x0001_0064, 4);
            operational(bus);
            for _ in 0..5 {
                bus.send(&frame(0x701, &[5]));
                bus.wait(Duration::from_millis(300));
            }
        },
        &["heartbeat of node 1", "100ms", "1016h:01", "1017h"],
    ),
    (
        "the toggle bit of a segment does not alternate",
        "terminal",
        |bus| {
            bus.sdo(&[0x40, 0x08, 0x10, 0, 0, 0, 0, 0]);
            for _ in 0..2 {
                bus.sdo(&[0x60, 0, 0, 0, 0, 0, 0, 0]);
            }
            bus.sdo(&[0x60, 0, 0, 0, 0, 0, 0, 0]);
        },
        &["toggle"],
    ),
    (
        "a segment without a transfer",
        "drive",
        |bus| {
            bus.sdo(&[0x60, 0, 0, 0, 0, 0, 0, 0]);
        },
        &["no transfer"],
    ),
    (
        "1003h:01 is read without an error",
        "drive",
        |bus| {
            bus.sdo(&[0x40, 0x03, 0x10, 1, 0, 0, 0, 0]);
        },
        &["1003h:01", "no data"],
    ),
    (
        "bit 7 is 1 all the time",
        "drive",
        |bus| {
            bus.write(0x6060, 0, 1, 1);
            enable(bus);
            bus.write(0x6040, 0, 0x8F, 2);
            bus.provoke();
            bus.wait(CYCLE * 100);
            bus.make_nominal();
            bus.wait(CYCLE * 10);
        },
        &["bit 7 from 0 to 1"],
    ),
    (
        "quick stop is given in all words",
        "drive",
        |bus| {
            operational(bus);
            for word in [2, 3, 0xB] {
                bus.write(0x6040, 0, word, 2);
                bus.wait(CYCLE * 10);
            }
        },
        &["bit 2", "6040h"],
    ),
    (
        "an RPDO of eight octets where two are mapped",
        "ag03-1",
        |bus| {
            operational(bus);
            for _ in 0..3 {
                bus.send(&frame(0x205, &[6, 0, 0, 0, 0, 0, 0, 0]));
                bus.wait(CYCLE);
            }
        },
        &["RPDO1", "8 octets", "1600h"],
    ),
    (
        "an RPDO of one octet",
        "ag03-1",
        |bus| {
            operational(bus);
            bus.send(&frame(0x205, &[6]));
        },
        &["RPDO1", "1 octet", "expected 2", "1600h"],
    ),
    (
        "a remote request of a TPDO that is off",
        "drive",
        |bus| {
            operational(bus);
            bus.send(&Frame::remote(Id::base(0x485).unwrap(), 8).unwrap());
        },
        &["remote request of TPDO4", "1803h:01"],
    ),
    (
        "interpolated position without SYNC",
        "asda-a2",
        |bus| {
            bus.write(0x6060, 0, 7, 1);
            enable(bus);
            bus.write(0x6040, 0, 0x1F, 2);
            bus.write(0x60C1, 1, 5000, 4);
            bus.wait(Duration::from_secs(4));
        },
        &["SYNC"],
    ),
    (
        "a guarding request of a node that produces heartbeats",
        "pump",
        |bus| {
            bus.write(0x1017, 0, 200, 2);
            let remote = Frame::remote(Id::base(0x705).unwrap(), 1).unwrap();
            for _ in 0..3 {
                bus.send(&remote);
            }
        },
        &["guarding", "heartbeats", "1017h"],
    ),
    (
        "a value beyond the limits of its object",
        "pump",
        |bus| {
            bus.write(0x1017, 0, 70_000, 4);
        },
        &["1017h", "expected 2 octets", "4 octets"],
    ),
];
