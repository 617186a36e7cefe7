//! The AG03/1 as a node on CANopen.

use std::time::Duration;

use profidrive::devices::CanopenDevice;
use profidrive::devices::ag03::drive::{Fault, Inputs};
use profidrive::face::Why;

use super::row;
use crate::ag03_node::Rig;
use crate::sentences::compare;
use crate::{ap10_node, asda_a2_node};

#[test]
fn the_node() {
    let events = |rig: &mut Rig| -> Vec<String> {
        std::iter::from_fn(|| rig.node.poll_event()).map(|event| event.to_string()).collect()
    };
    let after = |act: fn(&mut Rig)| {
        move || {
            let mut rig = Rig::enabled();
            events(&mut rig);
            act(&mut rig);
            events(&mut rig)
        }
    };
    let why = |act: fn(&mut Rig)| {
        move || {
            let mut rig = Rig::new();
            act(&mut rig);
            let mut said = Vec::new();
            rig.node.each_reason(&mut |reason| said.push(reason.to_string()));
            said
        }
    };
    compare(
        "AG03/1 on CANopen",
        vec![
            row(
                "N-01",
                "a start above the upper limit",
                after(|rig| {
                    rig.travel(0x010F, 1_500_000);
                    rig.travel(0x011F, 1_500_000);
                    rig.pass(Duration::from_millis(20));
                }),
            ),
            row(
                "N-02",
                "a fault",
                after(|rig| {
                    rig.node.set_inputs(rig.now, Inputs::default().provoking(Fault::F));
                    rig.pass(Duration::from_millis(50));
                }),
            ),
            row(
                "N-03",
                "NMT stop during operation",
                after(|rig| {
                    rig.nmt(0x02);
                    rig.pass(Duration::from_millis(20));
                }),
            ),
            row("N-04", "why: after power-on", why(|_| {})),
            row("N-05", "why: in OPERATIONAL", why(|rig| _ = rig.nmt(0x01))),
            row(
                "N-06",
                "why: switched on",
                why(|rig| {
                    rig.nmt(0x01);
                    rig.word(0x0106);
                    rig.word(0x0107);
                    rig.pass(Duration::from_millis(20));
                }),
            ),
            row(
                "N-07",
                "why: a fault",
                why(|rig| {
                    rig.enable();
                    rig.node.set_inputs(rig.now, Inputs::default().provoking(Fault::F));
                    rig.pass(Duration::from_millis(50));
                }),
            ),
            row("N-08", "why: switched off", why(|rig| rig.node.power_off(rig.now))),
            row("N-09", "SDO: read an object that is not there", after(|rig| _ = rig.read(0x9999, 0))),
            row("N-10", "SDO: write the status word", after(|rig| _ = rig.write(0x6041, 0, 1, 2))),
            row("N-11", "SDO: write mode of operation 99", after(|rig| _ = rig.write(0x6060, 0, 99, 1))),
            row(
                "N-12",
                "SDO: another COB-ID for an RPDO in operation",
                after(|rig| _ = rig.write(0x1400, 1, 0x205, 4)),
            ),
            row(
                "N-13",
                "SDO: v-Pos (2410h:05) above its range",
                after(|rig| _ = rig.write(0x2410, 5, 201, 1)),
            ),
            row(
                "N-14",
                "SDO: a mode of operation in four octets",
                after(|rig| _ = rig.write(0x6060, 0, 1, 4)),
            ),
            row(
                "N-15",
                "SDO: the upper limit (607Dh:02) below the lower one",
                after(|rig| _ = rig.write(0x607D, 2, -2_000_000, 4)),
            ),
            row(
                "N-16",
                "SDO: the lower limit (607Dh:01) above the upper one",
                after(|rig| _ = rig.write(0x607D, 1, 2_000_000, 4)),
            ),
            row("N-17", "SDO: a spindle pitch out of range", after(|rig| _ = rig.write(0x2412, 0, 1001, 2))),
            row(
                "N-18",
                "SDO: a control word in PRE-OPERATIONAL",
                after(|rig| {
                    rig.nmt(0x80);
                    rig.pass(Duration::from_millis(20));
                    rig.events();
                    _ = rig.write(0x6040, 0, 6, 2);
                }),
            ),
            row(
                "N-19",
                "SDO: another mode of operation during a travel",
                after(|rig| {
                    rig.travel(0x000F, 100_000);
                    rig.travel(0x001F, 100_000);
                    rig.pass(Duration::from_millis(200));
                    rig.events();
                    _ = rig.write(0x6060, 0, 2, 1);
                }),
            ),
            row(
                "N-20",
                "SDO: load the defaults (1011h:01) without the signature",
                after(|rig| _ = rig.write(0x1011, 1, 1, 4)),
            ),
            row(
                "N-21",
                "SDO: calibrate (1011h:04) during a travel",
                after(|rig| {
                    rig.travel(0x000F, 100_000);
                    rig.travel(0x001F, 100_000);
                    rig.pass(Duration::from_millis(200));
                    rig.events();
                    _ = rig.write(0x1011, 4, 0x6461_6F6C, 4);
                }),
            ),
            row(
                "N-22",
                "SDO: write an object that is not there",
                after(|rig| _ = rig.write(0x9999, 0, 7, 2)),
            ),
            row("N-23", "NMT command 07h", after(|rig| _ = rig.nmt(0x07))),
            row(
                "N-24",
                "NMT start of a node that is switched off",
                after(|rig| {
                    rig.node.power_off(rig.now);
                    rig.events();
                    rig.nmt(0x01);
                }),
            ),
            row(
                "N-25",
                "SDO requests while the node is STOPPED",
                after(|rig| {
                    rig.nmt(0x02);
                    rig.events();
                    (0..9).for_each(|_| _ = rig.sdo_answers([0x40, 0, 0x10, 0, 0, 0, 0, 0]));
                }),
            ),
            row(
                "N-26",
                "SDO requests of 3 octets",
                after(|rig| (0..9).for_each(|_| _ = rig.data(0x605, &[0x40, 0, 0x10]))),
            ),
            row("N-27", "an NMT command of one octet", after(|rig| _ = rig.data(0, &[0x01]))),
            row(
                "N-28",
                "RPDOs in PRE-OPERATIONAL",
                after(|rig| {
                    rig.nmt(0x80);
                    rig.pass(Duration::from_millis(20));
                    rig.events();
                    (0..9).for_each(|_| _ = rig.data(0x205, &[0x06, 0]));
                }),
            ),
            row(
                "N-29",
                "control word 000Fh in SWITCH ON DISABLED",
                after(|rig| {
                    rig.word(0);
                    rig.events();
                    (0..9).for_each(|_| _ = rig.word(0x000F));
                }),
            ),
            row(
                "N-30",
                "another target while bit 4 is 1",
                after(|rig| {
                    rig.travel(0x001F, 100_000);
                    rig.pass(Duration::from_millis(200));
                    rig.events();
                    (0..9).for_each(|_| rig.travel(0x001F, 200_000));
                }),
            ),
            row("N-31", "an RPDO that is too short", after(|rig| _ = rig.data(0x405, &[6, 0]))),
            row(
                "N-32",
                "TPDO1 waits for SYNC, and none comes",
                after(|rig| {
                    rig.nmt(0x80);
                    _ = rig.write(0x1800, 2, 1, 1);
                    rig.nmt(0x01);
                    rig.events();
                    rig.pass(Duration::from_secs(5));
                }),
            ),
            row("N-33", "a control word with its octets exchanged", after(|rig| _ = rig.word(0x0600))),
            row(
                "N-34",
                "control word 000Bh in SWITCH ON DISABLED",
                after(|rig| {
                    rig.word(0);
                    rig.events();
                    rig.word(0x000B);
                }),
            ),
            row("N-35", "SDO: the octets of the index exchanged", after(|rig| _ = rig.read(0x4160, 0))),
            row(
                "N-36",
                "SDO: a segment without a transfer",
                after(|rig| _ = rig.sdo_answers([0x60, 0, 0, 0, 0, 0, 0, 0])),
            ),
            row(
                "N-37",
                "an RPDO with more octets than are mapped",
                after(|rig| (0..9).for_each(|_| _ = rig.data(0x205, &[0xF, 0, 0]))),
            ),
            row(
                "N-38",
                "node guarding stops",
                after(|rig| {
                    _ = rig.write(0x100C, 0, 100, 2);
                    _ = rig.write(0x100D, 0, 3, 1);
                    rig.remote(0x705, 1);
                    rig.events();
                    rig.pass(Duration::from_secs(1));
                }),
            ),
        ],
    );
}

#[test]
fn other_devices() {
    let ap10 = |act: fn(&mut ap10_node::Rig)| {
        move || {
            let mut rig = ap10_node::Rig::operational();
            while rig.device.poll_event().is_some() {}
            act(&mut rig);
            std::iter::from_fn(|| rig.device.poll_event()).map(|event| event.to_string()).collect()
        }
    };
    let asda = |act: fn(&mut asda_a2_node::Rig)| {
        move || {
            let mut rig = asda_a2_node::Rig::full();
            while rig.device.poll_event().is_some() {}
            act(&mut rig);
            let told = std::iter::from_fn(|| rig.device.poll_event()).map(|event| event.to_string());
            told.filter(|text| !text.contains(" written: ")).collect()
        }
    };
    let written = || {
        let mut rig = asda_a2_node::Rig::full();
        while rig.device.poll_event().is_some() {}
        for (index, value) in [(0x6040, 6), (0x607A, -1000)] {
            _ = rig.write(index, 0, value);
        }
        let told = std::iter::from_fn(|| rig.device.poll_event()).map(|event| event.to_string());
        told.filter(|text| text.contains(" written: ")).collect()
    };
    compare(
        "AP10 and ASDA-A2 on CANopen",
        vec![
            row("O-01", "AP10: calibrate (2002h) with 5", ap10(|rig| _ = rig.write(0x2002, 0, 5, 1))),
            row("O-02", "AP10: node number 0 (5F0Ah:02)", ap10(|rig| _ = rig.write(0x5F0A, 2, 0, 1))),
            row("O-03", "AP10: the position (6004h)", ap10(|rig| _ = rig.write(0x6004, 0, 5, 4))),
            row("O-04", "ASDA-A2: CAN rate 5 (P3-01, 2301h)", asda(|rig| _ = rig.write(0x2301, 0, 0x0503))),
            row("O-05", "ASDA-A2: mode of operation 99", asda(|rig| _ = rig.write(0x6060, 0, 99))),
            row(
                "O-06",
                "ASDA-A2: another COB-ID for an RPDO that is on",
                asda(|rig| _ = rig.write(0x1400, 1, 0x22F)),
            ),
            row(
                "O-07",
                "ASDA-A2: control word 000Fh at once",
                asda(|rig| (0..9).for_each(|_| _ = rig.write(0x6040, 0, 0x000F))),
            ),
            row(
                "O-08",
                "ASDA-A2: homing with method 0",
                asda(|rig| {
                    _ = rig.write(0x6060, 0, 6);
                    [6, 7, 15, 31].into_iter().for_each(|word| _ = rig.write(0x6040, 0, word));
                }),
            ),
            row(
                "O-09",
                "ASDA-A2: another target while bit 4 is 1",
                asda(|rig| {
                    _ = rig.write(0x6060, 0, 1);
                    [6, 7, 15].into_iter().for_each(|word| _ = rig.write(0x6040, 0, word));
                    for target in [1000, 2000, 3000] {
                        _ = rig.write(0x607A, 0, target);
                        _ = rig.write(0x6040, 0, 31);
                    }
                }),
            ),
            row(
                "O-10",
                "ASDA-A2: the heartbeat of node 1 is missing for 100 ms (1016h:01)",
                asda(|rig| {
                    _ = rig.write(0x1016, 1, 0x0001_0064);
                    rig.data(0x701, &[5]);
                    rig.pass(Duration::from_millis(200));
                }),
            ),
            row("O-11", "ASDA-A2: what was written, with `-v`", written),
        ],
    );
}
