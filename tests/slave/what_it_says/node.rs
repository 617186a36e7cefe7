//! The AG03/1 as a node on CANopen.

use std::time::Duration;

use profidrive::drive::{Fault, Inputs};

use super::row;
use crate::ag03_node::Rig;
use crate::said::compare;

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
            rig.node.why().map(|hindrance| hindrance.to_string()).collect()
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
        ],
    );
}
