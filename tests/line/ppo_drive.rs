//! Drives of the profile and profirust 0.6.0 as their master, in simulated time.

use core::time::Duration;

use profidrive::devices::ppo_drive::profibus::{CONFIGURATIONS, IDENT_NUMBER, PpoDrive, PpoOnly};
use profidrive::devices::ppo_drive::table::Table;
use profidrive::host::{HostedPpoDrive, PpoJudge, Refusals};
use profidrive::master::{Profirust, baudrate};
use profidrive::profibus::dp::{Description, Fixed};
use profidrive::profibus::fdl::Address;
use profidrive::profibus::ppo::PpoType;
use profidrive::time::{BaudRate, Instant};
use profirust::dp::{DpMaster, Peripheral, PeripheralOptions};
use profirust::fdl::{FdlActiveStation, ParametersBuilder};

const BAUD: BaudRate = BaudRate::K500;
const KINDS: [PpoType; 5] = [PpoType::Ppo1, PpoType::Ppo2, PpoType::Ppo3, PpoType::Ppo4, PpoType::Ppo5];

fn drive(address: u8) -> HostedPpoDrive {
    let fixed = Fixed { configurations: CONFIGURATIONS, ..Fixed::PLAIN };
    let application = PpoOnly { inner: PpoJudge::Profile(fixed), only: None };
    let description = Description { ident: IDENT_NUMBER, ..Description::PLAIN };
    let address = Address::station(address).unwrap();
    let drive =
        PpoDrive::new(address, BAUD, (description, application), Table::profile(), Instant::ZERO).unwrap();
    HostedPpoDrive::new(drive, Refusals::default())
}

#[test]
fn profirust_turns_a_drive_of_each_ppo_on_one_line() {
    let mut dp = DpMaster::new(Vec::new());
    let handles = [0, 1, 2, 3, 4].map(|n: usize| {
        let kind = KINDS[n];
        let options = PeripheralOptions {
            ident_number: IDENT_NUMBER,
            user_parameters: Some(&[]),
            config: Some(kind.configuration()),
            max_tsdr: BAUD.max_tsdr_bits(),
            ..Default::default()
        };
        let address = u8::try_from(10 + n).unwrap();
        dp.add(Peripheral::new(address, options, vec![0; kind.len()], vec![0; kind.len()]))
    });
    dp.enter_operate();
    let mut fdl = FdlActiveStation::new(ParametersBuilder::new(2, baudrate(BAUD)).build_verified(&dp));
    fdl.set_online();
    let mut bus = Profirust::on_line(fdl, dp).unwrap();
    for n in 0..5 {
        bus.add(drive(10 + n)).unwrap();
    }
    let limit = Duration::from_secs(20);
    bus.run_until(limit, |bus| handles.iter().all(|handle| bus.master.dp.get_mut(*handle).is_running()))
        .unwrap();
    // OFF1, then run with 100 %: 1.5 s of a ramp of 10 s.
    for (stw, setpoint, time) in [(0x047E_u16, 0_u16, 300), (0x047F, 0x4000, 1500)] {
        for (handle, kind) in handles.iter().zip(KINDS) {
            let pzd = if kind.has_pkw() { 8 } else { 0 };
            let outputs = bus.master.dp.get_mut(*handle).pi_q_mut();
            outputs[pzd..pzd + 2].copy_from_slice(&stw.to_be_bytes());
            outputs[pzd + 2..pzd + 4].copy_from_slice(&setpoint.to_be_bytes());
        }
        bus.run_for(Duration::from_millis(time));
    }
    for (handle, kind) in handles.iter().zip(KINDS) {
        let pzd = if kind.has_pkw() { 8 } else { 0 };
        let inputs = bus.master.dp.get_mut(*handle).pi_i();
        let word = |at: usize| u16::from_be_bytes([inputs[at], inputs[at + 1]]);
        assert_eq!(word(pzd), 0x0337, "{kind}");
        assert!(word(pzd + 2).abs_diff(0x4000 / 20 * 3) < 120, "{kind}: {}", word(pzd + 2));
    }
}
