//! A travelling drive, of which `cycle` measures the time and `instructions` counts instructions.
#![allow(dead_code, reason = "each bench uses its own part")]

use core::time::Duration;

use profidrive::devices::ag03::profibus::{Config, Device, MAX_TELEGRAM_LEN, Timing};
use profidrive::profibus::fdl::{Address, DataTelegram, FunctionCode, Sap};
use profidrive::time::{BaudRate, Instant};

const FAR_AWAY: i32 = 900_000;

/// A request of master 2 to station 5; `sap` is the DSAP, with SSAP 62.
fn telegram(fc: u8, sap: Option<u8>, data: &[u8]) -> Vec<u8> {
    let (dsap, ssap) = (sap.and_then(Sap::new), sap.and(Sap::new(62)));
    let telegram = DataTelegram {
        format: DataTelegram::customary_format(dsap, ssap, data),
        da: Address::from_octet(5),
        sa: Address::from_octet(2),
        dsap,
        ssap,
        fc: FunctionCode::from_octet(fc),
        data,
    };
    telegram.encode(&mut [0; MAX_TELEGRAM_LEN]).unwrap().to_vec()
}

/// A Data_Exchange with this control word.
pub(crate) fn exchange(fc: u8, stw: u16) -> Vec<u8> {
    telegram(fc, None, &[&[0; 8], &stw.to_be_bytes()[..], &FAR_AWAY.to_be_bytes()].concat())
}

/// A drive at address 5 on its way to a target minutes away, and the time.
pub(crate) struct Travelling {
    pub(crate) device: Device,
    pub(crate) now: Instant,
    pub(crate) buf: [u8; MAX_TELEGRAM_LEN],
}

impl Travelling {
    /// Parameterised, configured and started.
    pub(crate) fn new() -> Self {
        let address = Address::station(5).unwrap();
        let config = Config { baud: BaudRate::K12000, timing: Timing::True, ..Config::new(address) };
        let device = Device::new(config, Instant::ZERO);
        let mut bench = Self { device, now: Instant::ZERO, buf: [0; MAX_TELEGRAM_LEN] };
        bench.request(&telegram(0x6D, Some(61), &[0x80, 1, 1, 11, 0x0A, 0xC5, 0]));
        bench.request(&telegram(0x5D, Some(62), &[0xF3, 0xF2]));
        for (fc, stw) in [(0x7D, 0x0B), (0x5D, 0x0B), (0x7D, 0x3B), (0x5D, 0x3B), (0x7D, 0x7B), (0x5D, 0x7B)]
        {
            bench.request(&exchange(fc, stw));
        }
        bench.now = bench.now.saturating_add(Duration::from_secs(1));
        bench.device.handle_timeout(bench.now);
        assert!(bench.device.status().travelling);
        bench
    }

    fn request(&mut self, octets: &[u8]) {
        self.now = self.now.saturating_add(Duration::from_millis(1));
        assert_eq!(self.answer(octets), octets.len().min(23), "the reply is as long as its request, or SC");
        while self.device.poll_event().is_some() {}
    }

    /// Octets in, octets out. The time stands, so that no application cycle is in it.
    pub(crate) fn answer(&mut self, octets: &[u8]) -> usize {
        self.device.handle_bytes(self.now, octets);
        let due = self.now.saturating_add(Duration::from_nanos(917));
        let reply = self.device.poll_transmit(due, &mut self.buf).unwrap();
        if reply.len() == 1 { octets.len() } else { reply.len() }
    }
}
