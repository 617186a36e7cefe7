//! The judge of CANopen nodes: correct nodes are not accused, each mistake is found by the row that names it.

use std::fs;
use std::path::Path;
use std::sync::{Arc, Mutex};

use profidrive::can_bus::can::{BitRate, Frame};
use profidrive::can_bus::canopen::node::storage::Eeprom;
use profidrive::can_bus::canopen::{Address, NodeId};
use profidrive::devices::from_eds::{Dictionary, FromEds};
use profidrive::devices::{CanopenDevice, CanopenEvent, ag03};
use profidrive::eds::Eds;
use profidrive::host::can::{Bus, CanEndpoint as _, Product, StoredNode};
use profidrive::host::list::Choices;
use profidrive::host::{Clock as _, Stop};
use profidrive::judge::device::node::{Port, Report, Row, Setup, simulated};
use profidrive::judge::{Outcome, Requirement as _, Verdict};
use profidrive::time::Instant;

#[path = "../../../examples/cia401_io.rs"]
mod cia401_io;
mod mistakes;
mod times;
mod troubles;
mod wrong;

use crate::virtual_time::is_long;
use mistakes::Mistake;
use wrong::{Hook, Mind, Wrong, base};

pub(crate) const NODE: u8 = 5;

pub(crate) fn node() -> NodeId {
    NodeId::new(NODE).unwrap()
}

/// What `drive.eds` lacks of the mode 7 that its 6502h offers.
const INTERPOLATION: &str = "
[60C1]
ParameterName=Interpolation data record
ObjectType=9
SubNumber=2

[60C1sub0]
ParameterName=Highest sub-index
ObjectType=7
DataType=5
AccessType=ro
DefaultValue=1
PDOMapping=0

[60C1sub1]
ParameterName=Next position
ObjectType=7
DataType=4
AccessType=rw
DefaultValue=0
PDOMapping=1
";

/// A file of `tests/eds`.
pub(crate) fn sheet(name: &str) -> Eds {
    let mut text = fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/eds").join(name)).unwrap();
    if name == "drive.eds" {
        let listed = String::from_utf8(text).unwrap();
        let listed = listed.replacen("SupportedObjects=52\n", "SupportedObjects=53\n", 1);
        text = listed.replacen("52=0x6502\n", "52=0x6502\n53=0x60C1\n", 1).into_bytes();
        text.extend(INTERPOLATION.as_bytes());
    }
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
    let right = Mistake { row: "", also: &[], what: "none", hear: same(), say: same(), every: None };
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
    let files = ["complete.eds", "terminal.eds", "pump.eds", "encoder.eds", "servo.dcf", "drive.eds"];
    let wronged = files.map(|name| wronged(name, Box::new(move || of_file(name)), sheet(name), &[]));
    assert!(wronged.iter().all(Option::is_none), "{wronged:#?}");
}

#[test]
fn a_text_without_octets_is_read_in_segments_and_shows_nothing() {
    let text = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/eds/complete.eds")).unwrap();
    let mut eds = Eds::read(text.replace("DefaultValue=Node with everything", "").as_bytes()).unwrap();
    eds.complete();
    let empty = eds.clone();
    let make = move || -> Box<dyn CanopenDevice> {
        Box::new(FromEds::on_node(Dictionary::hold(empty.clone()), node(), Eeprom::Internal))
    };
    assert_eq!(wronged("an empty name", Box::new(make), eds, &[]), None);
}

#[test]
fn a_node_of_ones_own_is_not_accused() {
    let mut text = String::new();
    profidrive::can_bus::canopen::eds::write(&cia401_io::SHEET, cia401_io::OBJECTS, &mut text).unwrap();
    let eds = Eds::read(text.as_bytes()).unwrap();
    let make = || -> Box<dyn CanopenDevice> { Box::new(cia401_io::Io::new(node()).on_node()) };
    assert_eq!(wronged("cia401_io", Box::new(make), eds, &[]), None);
}

/// The AG03/1 with one quirk more.
fn ag03(quirk: &'static [(&'static str, &'static str)]) -> Factory {
    Box::new(move || {
        let mut config = ag03::canopen::Config::new(node());
        for (name, value) in quirk {
            config.set_quirk(name, value).unwrap();
        }
        Box::new(ag03::canopen::Ag03Node::new(config, Instant::ZERO))
    })
}

#[test]
fn quirks_that_leave_the_standard_are_found_and_those_that_follow_it_are_not() {
    let eds = Eds::read(Product::named("ag03-1").unwrap().eds().as_bytes()).unwrap();
    let refused = ag03(&[("cob-id-change", "refused")]);
    assert_eq!(wronged("ag03-1", refused, eds.clone(), &["N-E04", "N-Y13", "N-Y17", "N-D09"]), None);
    let on_change = ag03(&[("tpdo-type-0", "on-change")]);
    assert_eq!(wronged("ag03-1", on_change, eds.clone(), &["N-E04", "N-Y17", "N-Y47", "N-D09"]), None);
    // It still takes type 253, which is for remote requests alone.
    let report = judged(ag03(&[("tpdo-rtr", "silent")]), setup(eds.clone()), &Row::all());
    let failed: Vec<_> =
        accused(&report).into_iter().filter(|(_, verdict, _)| *verdict == Verdict::Fail).collect();
    assert!(matches!(failed[..], [("N-Y04", ..)]), "{failed:?}");
    assert!(accused(&report).iter().any(|(id, ..)| *id == "N-Y33"));
    // An answer need not say its size.
    let no_size = ag03(&[("sdo-size", "42")]);
    assert_eq!(wronged("ag03-1", no_size, eds, &["N-E04", "N-Y13", "N-Y17", "N-Y47", "N-D09"]), None);
}

#[test]
fn the_devices_of_this_crate_are_not_accused() {
    let devices = [
        ("ag03-1", &["N-E04", "N-Y13", "N-Y17", "N-Y47", "N-D09"][..]),
        ("ap10", &["N-X60", "N-E04", "N-Y17"]),
        ("asda-a2", &["N-X60", "N-Y33", "N-D20"]),
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

/// The rows by which a mistake is judged: with `PROFIDRIVE_LONG` every one, else those that it breaks, a share that goes
/// round, and what they need.
fn rows_for(number: usize, mistake: &Mistake) -> Vec<Row> {
    const SHARES: usize = 8;
    if is_long() {
        return Row::all();
    }
    let breaks = mistake.also.iter().map(|(row, _)| *row).chain([mistake.row]);
    let share = Row::all().into_iter().skip(number % SHARES).step_by(SHARES).map(|row| row.id());
    let mut rows: Vec<Row> = breaks.chain(share).flat_map(with_needs).collect();
    rows.sort();
    rows.dedup();
    rows
}

/// Those that are found by other rows than those that are named.
fn found_otherwise(
    list: fn() -> Vec<Mistake>,
    factory: fn() -> Box<dyn CanopenDevice>,
    setup: &Setup,
) -> Vec<String> {
    let judge = |number: usize, rows: &dyn Fn(&Mistake) -> Vec<Row>| {
        let mistake = list().swap_remove(number);
        let (row, also, what) = (mistake.row, mistake.also, mistake.what);
        assert!(also.iter().all(|(_, why)| why.len() > 10), "{what}: no reason");
        let rows = rows(&mistake);
        let report = judged_with(Box::new(factory), mistake, setup.clone(), &rows);
        let mut expected: Vec<&str> = also.iter().map(|(row, _)| *row).chain([row]).collect();
        let mut found: Vec<&str> = accused(&report).iter().map(|(id, ..)| *id).collect();
        expected.sort_unstable();
        found.sort_unstable();
        (found != expected).then(|| {
            let beside: Vec<_> =
                accused(&report).into_iter().filter(|(id, ..)| !expected.contains(id)).collect();
            let missed: Vec<_> = expected.into_iter().filter(|id| !found.contains(id)).collect();
            let of_row = report.judgements.iter().find(|judged| judged.row.id() == row).unwrap();
            format!(
                "{row} {what}: {:?} {}, beside: {beside:?}, missed: {missed:?}",
                of_row.verdict, of_row.reason
            )
        })
    };
    // What a mistake remembers may need rows that are not in the share.
    let wrong = |number: usize| {
        judge(number, &|mistake| rows_for(number, mistake)).and_then(|_| judge(number, &|_| Row::all()))
    };
    (0..list().len()).filter_map(wrong).collect()
}

#[test]
fn each_mistake_of_a_node_is_found_by_its_rows_and_by_no_other() {
    let eds = sheet("complete.eds");
    let wrong = found_otherwise(mistakes::of_nodes, || of_file("complete.eds"), &setup(eds));
    assert!(wrong.is_empty(), "{}:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn each_mistake_of_a_drive_is_found_by_its_rows_and_by_no_other() {
    let eds = sheet("drive.eds");
    let wrong = found_otherwise(mistakes::of_drives, || of_file("drive.eds"), &setup(eds));
    assert!(wrong.is_empty(), "{}:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn every_row_that_is_judged_has_a_mistake() {
    let all: Vec<Mistake> = mistakes::of_nodes().into_iter().chain(mistakes::of_drives()).collect();
    assert_eq!(all.len(), 192);
    for row in Row::all().into_iter().filter(|row| row.unseen().is_none()) {
        assert!(all.iter().any(|mistake| mistake.row == row.id()), "{row:?}");
    }
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

/// What is written to a node: requests to its SDO server that write, and RPDOs.
fn written(allowed: Setup) -> Vec<Frame> {
    let written = Arc::new(Mutex::new(Vec::new()));
    let seen = Arc::clone(&written);
    let hear = move |_: &mut Mind, frame: Frame| {
        let writes =
            frame.id() == base(0x605) && matches!(frame.octets().first(), Some(0x20..=0x3F | 0xC0..=0xDF));
        if writes && frame.octets().len() == 8 || frame.id() == base(0x205) && !frame.is_remote() {
            seen.lock().unwrap().push(frame);
        }
        vec![frame]
    };
    let mistake = Mistake {
        row: "",
        also: &[],
        what: "none",
        hear: Box::new(hear),
        say: Box::new(|_, frame| vec![frame]),
        every: None,
    };
    let report = judged_with(Box::new(|| of_file("complete.eds")), mistake, allowed, &Row::all());
    assert_eq!(report.outcome(), Outcome::Passed, "{report}");
    written.lock().unwrap().clone()
}

#[test]
fn without_write_nothing_is_written_and_without_moves_allowed_no_process_data() {
    let all = setup(sheet("complete.eds"));
    assert_eq!(written(Setup { write: false, moves_allowed: false, ..all.clone() }), []);
    let process_data = |frame: &Frame| frame.id() == base(0x205) || frame.octets()[2] == 0x21;
    let parameters = written(Setup { moves_allowed: false, ..all.clone() });
    assert!(!parameters.is_empty() && !parameters.iter().any(process_data), "{parameters:?}");
    assert!(written(all).iter().any(process_data));
}

#[test]
fn a_judgement_leaves_every_value_as_it_was() {
    let port: Port<CanopenEvent> = Port::new(BitRate::K500);
    let device = of_file("complete.eds");
    let seat = port.bus(|bus, now| bus.add(now, Box::new(StoredNode::new(device, now))));
    let report = simulated(&port, setup(sheet("complete.eds")), &Row::all(), None).unwrap();
    assert_eq!(report.outcome(), Outcome::Passed, "{report}");
    let eds = sheet("complete.eds");
    let listed = eds
        .objects
        .iter()
        .flat_map(|(index, object)| object.entries.iter().map(move |(sub, entry)| (*index, *sub, entry)));
    for (index, sub, entry) in
        listed.filter(|(_, _, entry)| entry.rights.is_writable() && entry.rights.is_readable())
    {
        let at = Address::new(index, sub);
        let held = port.bus(|bus, now| {
            bus.with(now, seat, |node: &mut StoredNode, now| {
                node.act(now, |device, _| {
                    device.application().read(at).map(|value| value.with_octets(<[u8]>::to_vec)).ok()
                })
            })
        });
        if let Some(Some(held)) = held {
            assert_eq!(held, entry.octets(node()), "{at}");
        }
    }
}

#[test]
fn a_heartbeat_is_not_taken_for_an_answer_to_guarding() {
    for offset in (0..1000).step_by(15) {
        let mut port: Port<CanopenEvent> = Port::new(BitRate::K500);
        let device = of_file("servo.dcf");
        port.bus(|bus, now| bus.add(now, Box::new(StoredNode::new(device, now))));
        let end = Instant::from_millis(offset);
        while port.now() < end {
            port.wait(Some(end.saturating_since(port.now())), &Stop::new().unwrap()).unwrap();
            port.receive().unwrap();
        }
        let report = simulated(&port, setup(sheet("servo.dcf")), &with_needs("N-K02"), None).unwrap();
        assert_eq!(report.outcome(), Outcome::Passed, "{offset} ms: {report}");
    }
}

/// `PROFIDRIVE_REWRITE=1` writes the tables anew.
#[test]
fn the_page_names_every_row() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/judge-nodes.md");
    let page = fs::read_to_string(&path).unwrap();
    let mut table = String::new();
    let mut group = "";
    for row in Row::all() {
        if row.group() != group {
            group = row.group();
            table += &format!(
                "\n### {group}\n\n| row | C | what must come | the reference |\n| --- | --- | --- | --- |\n"
            );
        }
        let how = row.unseen().map_or_else(|| row.rule().unwrap().into(), |why| format!("not judged: {why}"));
        table += &format!("| {} | {:?} | {} | {how} |\n", row.id(), row.confidence(), row.text());
    }
    let begin = page.find("\n### ").unwrap();
    if std::env::var_os("PROFIDRIVE_REWRITE").is_some() {
        fs::write(&path, page[..begin].to_owned() + &table).unwrap();
    } else {
        assert!(page[begin..] == table, "rewrite it with PROFIDRIVE_REWRITE=1");
    }
}
