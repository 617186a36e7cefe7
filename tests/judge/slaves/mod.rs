//! The judge of DP slaves: correct slaves are not accused, each mistake is found by the row that names it.

use profidrive::bench::Port;
use profidrive::host::Participant;
use profidrive::judge::device::slave::{Report, Row, Setup, simulated};
use profidrive::judge::{Requirement as _, Verdict};
use profidrive::profibus::dp::{Description, Fixed, Station};
use profidrive::profibus::fdl::Address;
use profidrive::time::BaudRate;

mod devices;
mod mistakes;
mod profile;
mod rig;

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

#[test]
fn the_page_names_every_row() {
    let page = include_str!("../../../docs/judge-devices.md");
    for row in Row::all() {
        let how = match row.unseen() {
            Some(why) => format!("not judged: {why}"),
            None => row.rule().unwrap().into(),
        };
        let line = format!(
            "| {} | {} | {:?} | {} | {how} |",
            row.id(),
            row.priority(),
            row.confidence(),
            row.text()
        );
        assert!(page.contains(&line), "docs/judge-devices.md has not:\n{line}");
    }
}
