//! profirust 0.6.0, unmodified, judged in virtual time.

use core::time::Duration;

use profidrive::judge::{Row, Setup, Slave, Verdict, simulated};
use profidrive::master::{Profirust, baudrate};
use profidrive::profibus::fdl::Address;
use profidrive::time::BaudRate;
use profirust::dp::{DpMaster, Peripheral, PeripheralOptions};
use profirust::fdl::{FdlActiveStation, ParametersBuilder};

const BAUD: BaudRate = BaudRate::K500;

/// What it gets wrong, each checked by reading the telegrams.
const KNOWN: &[&str] =
    &["M-F04", "M-T06", "M-C07", "M-D02", "M-D03", "M-D07", "M-L05", "M-E03", "M-E04", "M-E13", "M-E15"];

#[test]
fn profirust_is_accused_of_nothing_but_what_it_does() {
    let mut dp = DpMaster::new(Vec::new());
    let mut images = [([0_u8; 4], [0x55_u8; 4]), ([0; 4], [0x66; 4])];
    for ((inputs, outputs), address) in images.iter_mut().zip([5_u8, 6]) {
        let options = PeripheralOptions {
            ident_number: 0x1234,
            config: Some(&[0x23, 0x13]),
            user_parameters: Some(&[]),
            groups: 1,
            max_tsdr: 100,
            fail_safe: false,
            ..PeripheralOptions::default()
        };
        dp.add(Peripheral::new(address, options, &mut inputs[..], &mut outputs[..]));
    }
    dp.enter_operate();
    let parameters = ParametersBuilder::new(2, baudrate(BAUD))
        .watchdog_timeout(profirust::time::Duration::from_millis(1000))
        .max_retry_limit(3)
        .highest_station_address(16)
        .build_verified(&dp);
    let slave = |address| Slave {
        groups: Some(1),
        ..Slave::new(Address::station(address).unwrap(), 0x1234, vec![0x23, 0x13])
    };
    let setup = Setup {
        stations: vec![slave(5), slave(6)],
        master: Address::station(2).ok(),
        watchdog: Some(Duration::from_millis(1000)),
        retries: Some(3),
        hsa: Address::station(16).ok(),
        ..Setup::default()
    };
    let mut fdl = FdlActiveStation::new(parameters);
    fdl.set_online();
    let mut line = Profirust::on_line(fdl, dp).unwrap();
    let report = simulated(&mut line, setup, Row::ALL);
    let failed: Vec<_> = report
        .judgements
        .iter()
        .filter(|judged| judged.verdict == Verdict::Fail)
        .map(|judged| judged.row.id())
        .collect();
    println!("{report}");
    assert_eq!(failed, KNOWN, "{report}");
}
