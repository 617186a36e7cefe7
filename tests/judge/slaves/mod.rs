//! The judge of DP slaves: correct slaves are not accused, each mistake is found by the row that names it.

use profidrive::bench::Port;
use profidrive::host::Participant;
use profidrive::judge::device::slave::{Report, Row, Setup, simulated};
use profidrive::judge::{Requirement as _, Verdict};
use profidrive::profibus::dp::{Description, Fixed, Station};
use profidrive::profibus::fdl::Address;
use profidrive::time::BaudRate;

mod changed;
mod devices;
mod drives;
mod mistakes;
mod profile;
mod rates;
mod rig;
mod times;
mod troubles;
mod whole;

/// Judges what is on a line of its own.
fn judged(station: impl Participant) -> Report {
    let port = Port::new(BaudRate::K500);
    let address = station.address();
    port.line(|line| line.add(station).unwrap());
    let setup = Setup { moves_allowed: true, ..Setup::new(address) };
    simulated(&port, setup, &Row::all(), None).unwrap()
}

/// The rows that are broken.
fn broken(report: &Report) -> Vec<&'static str> {
    let broken =
        report.judgements.iter().filter(|judged| matches!(judged.verdict, Verdict::Fail | Verdict::Warn));
    broken.map(|judged| judged.row.id()).collect()
}

#[test]
fn a_station_of_the_library_is_not_accused() {
    let description = Description { ident: 0x1234, sync_mode: true, freeze_mode: true, ..Description::PLAIN };
    let application = Fixed { configurations: &[&[0x21, 0x11]], ..Fixed::PLAIN };
    let station = Station::new(Address::station(5).unwrap(), BaudRate::K500, None, description, application);
    let report = judged(station);
    assert!(broken(&report).is_empty(), "{report}");
    assert_eq!(report.outcome().status(), 0, "{report}");
}

#[test]
fn needs_are_rows_of_the_table_and_never_go_round() {
    let all = Row::all();
    fn depth(row: Row, all: &[Row], left: usize) {
        assert!(left > 0, "{row:?} needs itself");
        for id in row.needs() {
            let needed = all.iter().find(|row| row.id() == *id).unwrap_or_else(|| panic!("{row:?}: {id}"));
            depth(*needed, all, left - 1);
        }
    }
    for row in &all {
        depth(*row, &all, 20);
    }
    for (at, row) in all.iter().enumerate() {
        assert!(all[at + 1..].iter().all(|other| other.id() != row.id()), "{row:?} is there twice");
    }
}

/// The part of the page that this test writes begins here.
const ROWS: &str = "## The rows\n";

#[test]
fn the_page_names_every_row() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/judge-devices.md");
    let page = std::fs::read_to_string(file).unwrap();
    let (before, _) = page.split_once(ROWS).unwrap();
    let mut table = String::new();
    let mut group = "";
    for row in Row::all() {
        if row.group() != group {
            group = row.group();
            table.push_str(&format!(
                "\n### {group}\n\n| row | P | C | what must come | the reference |\n| --- | --- | --- | --- | --- |\n"
            ));
        }
        let how = match row.unseen() {
            Some(why) => format!("not judged: {why}"),
            None => row.rule().unwrap().into(),
        };
        let (id, priority, confidence, text) = (row.id(), row.priority(), row.confidence(), row.text());
        table.push_str(&format!("| {id} | {priority} | {confidence:?} | {text} | {how} |\n"));
    }
    let letters = "P: 1 mandatory, 2 expected of any slave, 3 good practice. C: A a page of the standard, B two manuals, C one device or trace, U open.";
    let expected = format!("{before}{ROWS}\n{letters}\n{table}");
    if std::env::var_os("PROFIDRIVE_REWRITE").is_some() {
        std::fs::write(file, &expected).unwrap();
    }
    let now = std::fs::read_to_string(file).unwrap();
    assert!(now == expected, "docs/judge-devices.md: PROFIDRIVE_REWRITE=1 writes its rows anew");
}
