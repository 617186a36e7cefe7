//! The judge of DP slaves: correct slaves are not accused, each mistake is found by the row that names it.

use profidrive::bench::Port;
use profidrive::host::Participant;
use profidrive::judge::device::slave::{Report, Row, Setup, simulated};
use profidrive::judge::{Requirement as _, Verdict};
use profidrive::profibus::dp::{Description, Fixed, Station};
use profidrive::profibus::fdl::Address;
use profidrive::time::BaudRate;

/// The slave of most tests: two words in and out.
pub(crate) fn station() -> Station<Fixed<'static>> {
    let description = Description { ident: 0x1234, sync_mode: true, freeze_mode: true, ..Description::PLAIN };
    let application = Fixed { configurations: &[&[0x21, 0x11]], ..Fixed::PLAIN };
    Station::new(Address::station(5).unwrap(), BaudRate::K500, None, description, application)
}

/// Judges what is on a line of its own.
pub(crate) fn judged(station: impl Participant, wanted: &[Row]) -> Report {
    let port = Port::new(BaudRate::K500);
    let address = station.address();
    port.line(|line| line.add(station).unwrap());
    let setup = Setup { moves_allowed: true, ..Setup::new(address) };
    simulated(&port, setup, wanted, None).unwrap()
}

fn failed(report: &Report) -> Vec<&'static str> {
    let failed =
        report.judgements.iter().filter(|judged| matches!(judged.verdict, Verdict::Fail | Verdict::Warn));
    failed.map(|judged| judged.row.id()).collect()
}

#[test]
fn a_correct_slave_is_not_accused() {
    let report = judged(station(), &Row::all());
    assert!(failed(&report).is_empty(), "{report}");
    println!("{report}");
}
