//! Every device of this crate on PROFIBUS is judged: none is accused.

use std::path::{Path, PathBuf};

use profidrive::bench::{Line, Port};
use profidrive::devices::ag03::param::Model;
use profidrive::devices::ag03::profibus::Config;
use profidrive::devices::ppo_drive::profibus::{CONFIGURATIONS, IDENT_NUMBER, PpoDrive, PpoOnly};
use profidrive::devices::ppo_drive::table::Table;
use profidrive::gsd::{self, Gsd};
use profidrive::host::{GsdStation, HostedPpoDrive, PpoJudge, Refusals};
use profidrive::judge::Requirement as _;
use profidrive::judge::device::slave::{Report, Row, Setup, simulated};
use profidrive::profibus::dp::{Description, Fixed};
use profidrive::profibus::fdl::Address;
use profidrive::time::{BaudRate, Instant};

use super::broken;

const BAUD: BaudRate = BaudRate::K500;
const ADDRESS: u8 = 7;

fn address() -> Address {
    Address::station(ADDRESS).unwrap()
}

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

fn file(name: &str) -> Gsd {
    Gsd::read(&std::fs::read(path(name)).unwrap()).unwrap()
}

/// Judges what `add` puts on a line.
fn judged<T>(
    gsd: Option<Gsd>,
    modules: Vec<usize>,
    add: impl FnOnce(&mut Line<profidrive::bench::Attached>) -> T,
) -> Report {
    let port = Port::new(BAUD);
    port.line(add);
    let cfg = gsd.as_ref().filter(|_| !modules.is_empty()).map(|gsd| {
        modules.iter().flat_map(|place| gsd.modules[*place].identifiers.clone()).collect::<Vec<u8>>()
    });
    let setup = Setup { gsd: gsd.map(Box::new), cfg, modules, moves_allowed: true, ..Setup::new(address()) };
    simulated(&port, setup, &Row::all(), None).unwrap()
}

fn is_right(name: &str, report: &Report) {
    assert!(broken(report).is_empty(), "{name}: {report}");
    assert_eq!(report.outcome().status(), 0, "{name}: {report}");
}

#[test]
fn both_siko_drives() {
    for model in [Model::Ag03, Model::Ag03_1] {
        for gsd in [None, Some(file("gsd/SIKO0AC5.GSD"))] {
            let report = judged(gsd, Vec::new(), |line| {
                line.add_drive(Config { model, ..Config::new(address()) }).unwrap();
            });
            is_right(&format!("{model:?}"), &report);
        }
    }
}

#[test]
fn the_drive_of_the_profile() {
    let fixed = Fixed { configurations: CONFIGURATIONS, ..Fixed::PLAIN };
    let application = PpoOnly { inner: PpoJudge::Profile(fixed), only: None };
    let description = Description { ident: IDENT_NUMBER, ..Description::PLAIN };
    let drive =
        PpoDrive::new(address(), BAUD, (description, application), Table::profile(), Instant::ZERO).unwrap();
    let report = judged(None, Vec::new(), |line| {
        line.add(HostedPpoDrive::new(drive, Refusals::default())).unwrap();
    });
    is_right("PPO drive", &report);
}

/// A station of DP-V1 with records, alone on a line, and what the judge is told of it.
pub(crate) fn station_of_dpv1(baud: BaudRate) -> (Port, Setup) {
    let rates = "9.6_supp=1\n19.2_supp=1\nMaxTsdr_19.2=60\n";
    let gsd = super::rig::file(&format!("{}{rates}", super::mistakes::V1));
    let station = gsd::Station::new(gsd.clone(), gsd::Policy::PROPOSED).unwrap();
    let station =
        GsdStation::new(address(), baud, station, Refusals::default()).with_records(super::whole::known());
    let port = Port::new(baud);
    port.line(|line| line.add(station).unwrap());
    let setup = Setup {
        gsd: Some(Box::new(gsd)),
        records: Some(Box::new(super::whole::known())),
        writes_allowed: true,
        moves_allowed: true,
        ..Setup::new(address())
    };
    (port, setup)
}

#[test]
fn a_station_of_dp_v1_with_records() {
    let (port, setup) = station_of_dpv1(BAUD);
    let report = simulated(&port, setup, &Row::all(), None).unwrap();
    is_right("DP-V1", &report);
    let applies = report.judgements.iter().filter(|row| row.row.id().starts_with("V1-") && row.applies);
    assert_eq!(applies.count(), 66, "{report}");
}

#[test]
fn the_station_of_the_guide() {
    let slave = crate::own_station::slave(BAUD, profidrive::profibus::fdl::Resync::Idle(BAUD));
    let report = judged(Some(file("gsd/PDRV494F.GSD")), Vec::new(), |line| {
        line.add(slave.station().clone()).unwrap();
    });
    is_right("own station", &report);
}

/// Files, and the modules that are chosen where there is a choice.
const FILES: [(&str, &[usize]); 10] = [
    ("tests/gsd/compact.gsd", &[]),
    ("tests/gsd/dpv1.gsd", &[0]),
    ("tests/gsd/extended_prm.gsd", &[0]),
    ("tests/gsd/modular.gsd", &[0]),
    ("tests/gsd/preset.gsd", &[]),
    ("tests/gsd/remote_io.gsd", &[0]),
    ("tests/gsd/slots.gsd", &[0]),
    ("tests/gsd/twins.gsd", &[0]),
    ("tests/gsd/unit_diag.gsd", &[]),
    ("gsd/PDRV494F.GSD", &[]),
];

#[test]
fn stations_of_device_files() {
    for (name, modules) in FILES {
        let gsd = file(name);
        let station = gsd::Station::new(gsd.clone(), gsd::Policy::PROPOSED).unwrap();
        let station = GsdStation::new(address(), BAUD, station, Refusals::default());
        let report = judged(Some(gsd), modules.to_vec(), |line| line.add(station).unwrap());
        is_right(name, &report);
    }
}
