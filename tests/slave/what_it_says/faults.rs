//! Faults and warnings.

use std::time::Duration;

use profidrive::devices::ag03::drive::{Fault, Inputs};

use super::row;
use crate::drive_log::{CYCLE, Told};
use crate::sentences::{Row, compare};

/// A drive in this fault, operation was enabled.
fn in_fault(fault: Fault) -> Told {
    let mut told = Told::enabled();
    told.inputs(Inputs::default().provoking(fault));
    told.say(0x007B, 16_000, Duration::from_secs(8));
    assert!(told.line.device.status().fault.is_some(), "{fault:?}");
    told
}

#[test]
fn faults() {
    let provoked = |fault: Fault| {
        move || {
            let mut told = in_fault(fault);
            let texts = told.texts();
            texts.into_iter().filter(|text| text.starts_with("fault ")).collect()
        }
    };
    let said = |words: fn(&mut Told)| {
        move || {
            let mut told = in_fault(Fault::F);
            told.line.events.clear();
            words(&mut told);
            told.texts()
        }
    };
    let names: Vec<_> = Fault::ALL
        .into_iter()
        .filter(|fault| !matches!(fault, Fault::H | Fault::I))
        .enumerate()
        .map(|(number, fault)| {
            (fault, format!("F-{:02}", number + 1), format!("the cause of fault {fault:?} acts"))
        })
        .collect();
    let mut rows: Vec<Row<'_>> = Vec::new();
    for (fault, id, done) in &names {
        rows.push((id, done, Box::new(provoked(*fault))));
    }
    rows.push(row(
        "F-20",
        "acknowledged while the cause is still there",
        said(|told| told.say(0x00BB, 0, CYCLE)),
    ));
    rows.push(row(
        "F-21",
        "the cause goes",
        said(|told| {
            told.inputs(Inputs::default());
            told.say(0x007B, 0, CYCLE);
        }),
    ));
    rows.push(row("F-22", "a start in fault", said(|told| told.say(0x003B, 0, CYCLE))));
    rows.push(row(
        "F-23",
        "acknowledged with 047F held",
        said(|told| {
            told.inputs(Inputs::default());
            told.say(0x047F, 0, CYCLE);
            told.line.events.clear();
            told.say(0x04FF, 0, CYCLE);
        }),
    ));
    rows.push(row(
        "F-24",
        "enabled after the acknowledgement, without OFF1",
        said(|told| {
            told.inputs(Inputs::default());
            for stw in [0x0073, 0x00F3, 0x0073] {
                told.say(stw, 0, CYCLE);
            }
            told.line.events.clear();
            told.say(0x007B, 0, CYCLE);
        }),
    ));
    rows.push(row(
        "F-25",
        "acknowledged a second time",
        said(|told| {
            told.inputs(Inputs::default());
            for stw in [0x003B, 0x00BB, 0x003B] {
                told.say(stw, 0, CYCLE);
            }
            told.line.events.clear();
            told.say(0x00BB, 0, CYCLE);
        }),
    ));
    rows.push(row("F-26", "the battery has 2.4 V", || {
        let mut told = Told::enabled();
        told.inputs(Inputs { battery: 2.4, ..Inputs::default() });
        told.say(0x003B, 0, CYCLE);
        told.texts()
    }));
    compare("Faults and warnings", rows);
}
