//! The judge of CANopen nodes: correct nodes are not accused, each mistake is found by the row that names it.

use std::fs;
use std::path::Path;

use profidrive::can_bus::can::BitRate;
use profidrive::can_bus::canopen::NodeId;
use profidrive::can_bus::canopen::node::storage::Eeprom;
use profidrive::devices::from_eds::{Dictionary, FromEds};
use profidrive::devices::{CanopenDevice, CanopenEvent};
use profidrive::eds::Eds;
use profidrive::host::can::{Bus, Product, StoredNode};
use profidrive::host::list::Choices;
use profidrive::judge::device::node::{Port, Report, Row, Setup, simulated};
use profidrive::judge::{Outcome, Requirement as _, Verdict};
use profidrive::time::Instant;

mod mistakes;
mod wrong;

use mistakes::Mistake;
use wrong::{Hook, Wrong};

pub(crate) const NODE: u8 = 5;

pub(crate) fn node() -> NodeId {
    NodeId::new(NODE).unwrap()
}

/// A file of `tests/eds`.
pub(crate) fn sheet(name: &str) -> Eds {
    let text = fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/eds").join(name)).unwrap();
    let mut eds = Eds::read(&text).unwrap();
    eds.complete();
    eds
}

/// Everything may be done to it.
pub(crate) fn setup(eds: Eds) -> Setup {
    Setup { eds: Some(Box::new(eds)), write: true, moves_allowed: true, quick: true, ..Setup::new(node()) }
}

/// A node that a file describes.
pub(crate) fn of_file(name: &str) -> Box<dyn CanopenDevice> {
    Box::new(FromEds::on_node(Dictionary::hold(sheet(name)), node(), Eeprom::Internal))
}

/// Makes a device as delivered.
pub(crate) type Factory = Box<dyn Fn() -> Box<dyn CanopenDevice>>;

/// Judges a device with somebody beside it.
pub(crate) fn judged(factory: Factory, setup: Setup, rows: &[Row]) -> Report {
    let same = || -> Hook { Box::new(|_, frame| vec![frame]) };
    let right = Mistake { row: "", what: "none", hear: same(), say: same(), every: None };
    judged_with(factory, right, setup, rows)
}

/// Judges a device that makes a mistake.
fn judged_with(factory: Factory, mistake: Mistake, setup: Setup, rows: &[Row]) -> Report {
    let port: Port<CanopenEvent> = Port::new(BitRate::K500);
    let Mistake { hear, say, every, .. } = mistake;
    let add = |bus: &mut Bus<CanopenEvent>, now| {
        let node = StoredNode::new(factory(), now);
        bus.add(now, Box::new(Wrong::new(node, hear, say, every)))
    };
    let seat = port.bus(add);
    let hands = port.clone();
    let attendant = move |action: &str| {
        let act = |wrong: &mut Wrong, now: Instant| match action {
            "power-cycle" => {
                wrong.node().act(now, |device, now| {
                    device.power_off(now);
                    device.power_on(now);
                });
                Some(())
            }
            "new-device" => {
                *wrong.node() = StoredNode::new(factory(), now);
                Some(())
            }
            _ => None,
        };
        hands.bus(|bus, now| bus.with(now, seat, act)).flatten().map(|()| String::new())
    };
    simulated(&port, setup, rows, Some(Box::new(attendant))).unwrap()
}

/// The rows that failed or warned, with their reasons.
pub(crate) fn accused(report: &Report) -> Vec<(&'static str, Verdict, String)> {
    let accused = report.judgements.iter().filter(|one| matches!(one.verdict, Verdict::Fail | Verdict::Warn));
    accused.map(|one| (one.row.id(), one.verdict, one.reason.clone())).collect()
}

/// What is wrong with a judgement of a correct node: nothing may fail, all that applies is judged, and these rows warn.
fn wronged(name: &str, factory: Factory, eds: Eds, warned: &[&str]) -> Option<String> {
    let report = judged(factory, setup(eds), &Row::all());
    println!("{name}\n{report}");
    let accused = accused(&report);
    let warnings: Vec<&str> = accused.iter().map(|(id, ..)| *id).collect();
    let is_right = report.outcome() == Outcome::Passed && warnings == warned;
    (!is_right).then(|| format!("{name}: {:?} {accused:#?}", report.outcome()))
}

#[test]
fn nodes_from_files_are_not_accused() {
    let files = ["complete.eds", "terminal.eds", "pump.eds", "encoder.eds", "servo.dcf"];
    let wronged = files.map(|name| wronged(name, Box::new(move || of_file(name)), sheet(name), &[]));
    assert!(wronged.iter().all(Option::is_none), "{wronged:#?}");
}

#[test]
fn the_devices_of_this_crate_are_not_accused() {
    let devices = [
        ("ag03-1", &["N-E04", "N-Y13", "N-Y17", "N-Y47"][..]),
        ("ap10", &["N-X60", "N-E04", "N-Y17"]),
        ("asda-a2", &["N-X60", "N-Y33"]),
    ];
    let wronged = devices.map(|(name, warned)| {
        let product = Product::named(name).unwrap();
        let eds = Eds::read(product.eds().as_bytes()).unwrap();
        let make = || product.make(node(), &Choices::default(), Eeprom::Internal, Instant::ZERO);
        wronged(name, Box::new(make), eds, warned)
    });
    assert!(wronged.iter().all(Option::is_none), "{wronged:#?}");
}

/// A row and those that it needs.
fn with_needs(id: &str) -> Vec<Row> {
    let row = Row::named(id).unwrap_or_else(|| panic!("there is no row {id}"));
    let mut rows = vec![row];
    for needed in row.needs() {
        rows.extend(with_needs(needed));
    }
    rows.sort();
    rows.dedup();
    rows
}

/// Those that the row that names them does not find.
fn missed(list: Vec<Mistake>, factory: fn() -> Box<dyn CanopenDevice>, eds: &Eds) -> Vec<String> {
    let judge = |mistake: Mistake| {
        let (row, what) = (mistake.row, mistake.what);
        let report = judged_with(Box::new(factory), mistake, setup(eds.clone()), &with_needs(row));
        let found = accused(&report).iter().any(|(id, ..)| *id == row);
        (!found).then(|| {
            let of_row = report.judgements.iter().find(|judged| judged.row.id() == row).unwrap();
            format!("{row} {what}: {:?} {}, accused: {:?}", of_row.verdict, of_row.reason, accused(&report))
        })
    };
    list.into_iter().filter_map(judge).collect()
}

#[test]
fn each_mistake_of_a_node_is_found_by_the_row_that_names_it() {
    let list = mistakes::of_nodes();
    assert!(list.len() >= 60, "{}", list.len());
    let missed = missed(list, || of_file("complete.eds"), &sheet("complete.eds"));
    assert!(missed.is_empty(), "{missed:#?}");
}

fn servo() -> Box<dyn CanopenDevice> {
    let product = Product::named("asda-a2").unwrap();
    product.make(node(), &Choices::default(), Eeprom::Internal, Instant::ZERO)
}

#[test]
fn each_mistake_of_a_drive_is_found_by_the_row_that_names_it() {
    let eds = Eds::read(Product::named("asda-a2").unwrap().eds().as_bytes()).unwrap();
    let missed = missed(mistakes::of_drives(), servo, &eds);
    assert!(missed.is_empty(), "{missed:#?}");
}

#[test]
fn a_node_that_dies_or_floods_ends_in_a_verdict() {
    for mistake in mistakes::that_end() {
        let (row, what) = (mistake.row, mistake.what);
        let factory = Box::new(|| of_file("complete.eds"));
        let report = judged_with(factory, mistake, setup(sheet("complete.eds")), &Row::all());
        assert_eq!(report.outcome(), Outcome::Failed, "{what}: {report}");
        assert!(!report.ending.to_string().contains("everything"), "{what}: {}", report.ending);
        if row == "N-O03" {
            assert!(accused(&report).iter().any(|(id, ..)| *id == row), "{what}: {:?}", accused(&report));
        }
        let not_tried = report.judgements.iter().filter(|judged| judged.reason == "not tried").count();
        assert!(not_tried > 20, "{what}: {not_tried}");
    }
}

#[test]
fn nobody_is_no_pass() {
    let port: Port<CanopenEvent> = Port::new(BitRate::K500);
    let report = simulated(&port, Setup::new(node()), &Row::all(), None).unwrap();
    assert!(matches!(report.outcome(), Outcome::NoExchange(_)), "{report}");
}
