//! How long a judgement takes on a link, in virtual time: what passes on the line, and what is waited for. An operating system
//! adds its own.

use std::time::Duration;

use profidrive::bench::Port;
use profidrive::devices::ag03::profibus::Config;
use profidrive::gsd::Gsd;
use profidrive::host::{Clock as _, Stop};
use profidrive::judge::Requirement as _;
use profidrive::judge::device::Ending;
use profidrive::judge::device::slave::{Live, Row, Setup, Sight, live};
use profidrive::profibus::fdl::Address;
use profidrive::time::BaudRate;

use super::{broken, devices, drives};

fn siko(baud: BaudRate) -> (Port, Setup) {
    let address = Address::station(7).unwrap();
    let port = Port::new(baud);
    port.line(|line| line.add_drive(Config::new(address)).unwrap());
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/gsd/SIKO0AC5.GSD");
    let gsd = Gsd::read(&std::fs::read(file).unwrap()).unwrap();
    (port, Setup { gsd: Some(Box::new(gsd)), moves_allowed: true, ..Setup::new(address) })
}

/// An AG03, a station of DP-V1, a drive of PROFIdrive.
const DEVICES: [fn(BaudRate) -> (Port, Setup); 3] =
    [siko, devices::station_of_dpv1, |baud| drives::drive(baud, |_, _| ())];

fn take_at_most(sight: Sight, baud: BaudRate, quick: bool, most: Duration) {
    for (number, device) in DEVICES.iter().enumerate() {
        let (port, setup) = device(baud);
        let line = Live {
            link: Box::new(port.clone()),
            clock: Box::new(port.clone()),
            sight,
            rate: baud,
            stop: Stop::new().unwrap(),
        };
        let report = live(Setup { quick, ..setup }, &Row::all(), line, None, &mut |_| ());
        println!("{number} {sight:?} {baud} quick {quick}: {:?}", report.took);
        // The devices of this line see its times: to them a telegram in pieces is none.
        assert!(broken(&report).iter().all(|row| *row == "S-F08"), "{number}: {report}");
        assert_eq!(report.ending, Ending::Done, "{number}: {report}");
        assert!(report.took <= most && port.now().as_nanos() > 0, "{number}: {:?}\n{report}", report.took);
    }
}

#[test]
fn a_terminal_takes_less_than_a_minute_and_quickly_a_quarter_of_that() {
    take_at_most(Sight::Untimed, BaudRate::K500, false, Duration::from_secs(45));
    take_at_most(Sight::Untimed, BaudRate::K500, true, Duration::from_secs(15));
}

#[test]
fn a_serial_line_of_19200_takes_less_than_ten_minutes() {
    take_at_most(Sight::Measured, BaudRate::K19_2, false, Duration::from_secs(600));
}
