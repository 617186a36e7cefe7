//! Drives of PROFIdrive 3 and 4: a right one, and mistakes in its parameters by record 47.

use profidrive::bench::Port;
use profidrive::devices::profidrive4::profibus::{Family, ProfidriveDevice, TelegramOnly};
use profidrive::gsd;
use profidrive::host::{HostedProfidrive, Refusals};
use profidrive::judge::Requirement as _;
use profidrive::judge::device::slave::{Report, Row, Setup, simulated};
use profidrive::profibus::dpv1::Identification;
use profidrive::profibus::fdl::Address;
use profidrive::time::{BaudRate, Instant};

use super::broken;
use super::changed::{Change, Changed};

const BAUD: BaudRate = BaudRate::K500;

/// The group of these rows.
pub(crate) const GROUP: &str = "DP-V1: parameters of a drive (PROFIdrive)";

/// A drive whose replies are changed, alone on a line, and what the judge is told of it.
pub(crate) fn drive(baud: BaudRate, change: Change) -> (Port, Setup) {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/gsd/PDRV5034.GSD");
    let gsd = gsd::Gsd::read(&std::fs::read(file).unwrap()).unwrap();
    let station = gsd::Station::new(gsd.clone(), gsd::Policy::PROPOSED).unwrap();
    let parts = (station.description(), TelegramOnly { inner: station, only: None });
    let acyclic = (gsd.acyclic.offer(10), Identification::PLAIN);
    let family = Family::new(&[]).unwrap();
    let address = Address::station(7).unwrap();
    let drive = ProfidriveDevice::new(address, baud, parts, acyclic, family, Instant::ZERO);
    let drive = HostedProfidrive::new(drive, Refusals::default());
    let port = Port::new(baud);
    port.line(|line| line.add(Changed::new(drive, Some(51), change)).unwrap());
    let setup = Setup {
        cfg: Some(gsd.modules[0].identifiers.clone()),
        gsd: Some(Box::new(gsd)),
        modules: vec![0],
        profidrive: true,
        moves_allowed: true,
        writes_allowed: true,
        ..Setup::new(address)
    };
    (port, setup)
}

fn judged(rows: &[Row], change: Change) -> Report {
    let (port, setup) = drive(BAUD, change);
    simulated(&port, setup, rows, None).unwrap()
}

#[test]
fn the_drive_of_profidrive_4_is_right() {
    let report = judged(&Row::all(), |_, _| ());
    assert!(broken(&report).is_empty(), "{report}");
    assert_eq!(report.outcome().status(), 0, "{report}");
    let of_drive = report.judgements.iter().filter(|judged| judged.row.group() == GROUP);
    assert!(of_drive.clone().all(|judged| judged.applies), "{report}");
    assert_eq!(of_drive.count(), 8, "{report}");
}

/// The PNU that a Write of record 47 asks for first.
fn pnu(asked: &[u8]) -> u16 {
    if asked.len() < 12 || asked[0] != 0x5F || asked[2] != 47 {
        0
    } else {
        u16::from_be_bytes([asked[10], asked[11]])
    }
}

thread_local! {
    /// The last Write of record 47.
    static WRITTEN: core::cell::RefCell<Vec<u8>> = const { core::cell::RefCell::new(Vec::new()) };
}

/// Whether data are the response to a request of this service that asks for this PNU first.
fn is_response(asked: &[u8], data: &[u8], (service, of): (u8, u16)) -> bool {
    WRITTEN.with_borrow_mut(|written| {
        if pnu(asked) != 0 {
            *written = asked.to_vec();
        }
        data.len() > 7 && data[0] == 0x5E && data[2] == 47 && pnu(written) == of && written[5] == service
    })
}

const MISTAKES: &[(&str, &[&str], Change)] = &[
    ("the reference is not mirrored", &["V1-R88"], |asked, data| {
        if is_response(asked, data, (1, 922)) {
            data[4] = 0;
        }
    }),
    ("an unknown PNU has no such sub-index", &["V1-R89"], |asked, data| {
        if is_response(asked, data, (1, 65535)) {
            data[11] = 3;
        }
    }),
    ("what cannot be changed is not there", &["V1-D01"], |asked, data| {
        if is_response(asked, data, (2, 964)) {
            data[11] = 0;
        }
    }),
    ("one of three failed, and the response says all went well", &["V1-R90"], |asked, data| {
        if is_response(asked, data, (1, 922)) && data[7] == 3 {
            data[5] = 1;
        }
    }),
    ("a change that went well says that it failed", &["V1-D02"], |asked, data| {
        if is_response(asked, data, (2, 925)) && data.len() == 8 {
            data[5] = 0x82;
        }
    }),
    ("without a request there is no record 47", &["V1-R91"], |_, data| {
        if data[..3] == [0xDE, 0x80, 0xB5] {
            data[2] = 0xB0;
        }
    }),
    ("a description has 45 octets", &["V1-R92"], |asked, data| {
        if is_response(asked, data, (1, 922)) && data.len() == 56 {
            data[9] = 45;
        }
    }),
    ("a parameter of the list is not there", &["V1-D03"], |asked, data| {
        if is_response(asked, data, (1, 918)) && data.len() == 12 {
            data[5] = 0x81;
            data[8..].copy_from_slice(&[0x44, 1, 0, 0]);
        }
    }),
];

#[test]
fn each_mistake_of_a_drive_is_found_by_its_rows_and_by_no_other() {
    let rows: Vec<Row> = ["V1-*", "S-P01", "S-G01", "S-X01"].into_iter().flat_map(Row::matching).collect();
    let mut wrong = Vec::new();
    for (name, expected, change) in MISTAKES {
        let report = judged(&rows, *change);
        if broken(&report) != *expected {
            wrong.push(format!("{name}: {:?}, expected {expected:?}", broken(&report)));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    for row in rows.iter().filter(|row| row.group() == GROUP) {
        assert!(MISTAKES.iter().any(|(_, rows, _)| rows.contains(&row.id())), "{row:?}");
    }
}
