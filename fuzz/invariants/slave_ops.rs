//! Bus operations and time against a whole device: replies only to valid requests for us, mirrored, within the time
//! allowed, one a request; states and words only as documented; a deadline in the future after every drain.

use std::time::Duration;

use arbitrary::{Arbitrary, Unstructured};
use profidrive::device::{Config, Device, MAX_TELEGRAM_LEN, Timing, words};
use profidrive::fdl::telegram::{Decoded, Format, decode};
use profidrive::fdl::{Address, DataTelegram, Function, FunctionCode, Sap, Telegram};
use profidrive::time::{BaudRate, Instant};

const OWN: u8 = 5;

#[derive(Arbitrary, Debug)]
struct Session {
    rate: u8,
    every_exchange: bool,
    operations: Vec<Operation>,
}

#[derive(Arbitrary, Debug)]
enum Operation {
    /// Any octets.
    Octets(Vec<u8>),
    /// A telegram in order, with any fields.
    Telegram { to_us: bool, da: u8, sa: u8, dsap: Option<u8>, ssap: Option<u8>, fc: u8, data: Vec<u8> },
    /// A master that means it: the services of the start-up and Data_Exchange.
    Service { sa: u8, service: Service, repeat: bool },
    /// Time.
    Wait { micros: u32 },
    /// Much time.
    Sleep { seconds: u16 },
}

#[derive(Arbitrary, Clone, Copy, Debug)]
enum Service {
    SetPrm { status: u8, factors: [u8; 2], min_tsdr: u8, group: u8 },
    ChkCfg,
    SlaveDiag,
    GetCfg,
    RdInp,
    RdOutp,
    GlobalControl { command: u8, groups: u8 },
    DataExchange { pkw: [u8; 8], stw: u16, hsw: i32 },
}

pub(crate) fn check(data: &[u8]) {
    let Ok(session) = Session::arbitrary_take_rest(Unstructured::new(data)) else { return };
    let rate = BaudRate::ALL[usize::from(session.rate) % BaudRate::ALL.len()];
    let cycle = if session.every_exchange { Duration::ZERO } else { Duration::from_millis(1) };
    let address = Address::station(OWN).expect("below 127");
    let config =
        Config { baud: rate, timing: Timing::True, application_cycle: cycle, ..Config::new(address) };
    let mut bus =
        Bus { device: Device::new(config, Instant::ZERO), now: Instant::ZERO, rate, frame_count: false };
    for operation in session.operations.iter().take(200) {
        bus.carry_out(operation);
        bus.check_state();
    }
}

struct Bus {
    device: Device,
    now: Instant,
    rate: BaudRate,
    frame_count: bool,
}

impl Bus {
    fn carry_out(&mut self, operation: &Operation) {
        match operation {
            Operation::Octets(octets) => self.send(octets),
            Operation::Telegram { to_us, da, sa, dsap, ssap, fc, data } => {
                let da = if *to_us { OWN } else { *da };
                self.send(&telegram(da, *sa, *dsap, *ssap, *fc, data));
            }
            Operation::Service { sa, service, repeat } => {
                self.frame_count ^= !repeat;
                let fc = if self.frame_count { 0x7D } else { 0x5D };
                let (da, fc, sap, data) = match *service {
                    Service::SetPrm { status, factors, min_tsdr, group } => {
                        let data = vec![status, factors[0], factors[1], min_tsdr, 0x0A, 0xC5, group];
                        (OWN, fc, Some(61), data)
                    }
                    Service::ChkCfg => (OWN, fc, Some(62), vec![0xF3, 0xF2]),
                    Service::SlaveDiag => (OWN, fc, Some(60), vec![]),
                    Service::GetCfg => (OWN, fc, Some(59), vec![]),
                    Service::RdInp => (OWN, fc, Some(56), vec![]),
                    Service::RdOutp => (OWN, fc, Some(57), vec![]),
                    Service::GlobalControl { command, groups } => {
                        (127, 0x46, Some(58), vec![command, groups])
                    }
                    Service::DataExchange { pkw, stw, hsw } => {
                        let octets = [pkw.as_slice(), &stw.to_be_bytes(), &hsw.to_be_bytes()].concat();
                        (OWN, fc, None, octets)
                    }
                };
                self.send(&telegram(da, *sa, sap, sap.and(Some(62)), fc, &data));
            }
            Operation::Wait { micros } => self.wait(Duration::from_micros((*micros).into())),
            Operation::Sleep { seconds } => self.wait(Duration::from_secs((*seconds).into())),
        }
    }

    /// Sends octets after T_SYN and checks what comes back.
    fn send(&mut self, octets: &[u8]) {
        self.wait(self.rate.bit_times(33));
        self.wait(self.rate.octet_times(u32::try_from(octets.len()).expect("few octets")));
        let end = self.now;
        self.device.handle_bytes(end, octets);
        let reply_due = last_request(octets);
        let latest = end.saturating_add(self.rate.bit_times(self.rate.max_tsdr_bits().into()));
        let mut replies = 0;
        loop {
            let mut buf = [0; MAX_TELEGRAM_LEN];
            if let Some(reply) = self.device.poll_transmit(self.now, &mut buf) {
                replies += 1;
                assert!(self.now >= end.saturating_add(self.rate.bit_times(11)), "before min T_SDR");
                assert!(self.now <= latest, "after max T_SDR");
                let sa = reply_due.expect("a reply nobody asked for");
                match decode(reply) {
                    Decoded::Telegram { telegram: Telegram::ShortAcknowledge, len: 1 } => {}
                    Decoded::Telegram { telegram: Telegram::Data(data), len } => {
                        assert_eq!((data.da, data.sa.number(), len), (sa, OWN, reply.len()));
                        assert!(matches!(data.fc.function(), Function::Response(..)));
                    }
                    other => panic!("{other:?}"),
                }
            }
            while self.device.poll_event().is_some() {}
            let Some(due) = self.device.poll_timeout().filter(|due| *due <= latest) else { break };
            assert!(due > self.now, "a deadline that has passed, after a drain");
            self.now = due;
            self.device.handle_timeout(due);
        }
        assert!(replies <= 1, "{replies} replies");
        self.now = latest;
    }

    fn wait(&mut self, time: Duration) {
        self.now = self.now.saturating_add(time);
        self.device.handle_timeout(self.now);
        let mut buf = [0; MAX_TELEGRAM_LEN];
        assert!(self.device.poll_transmit(self.now, &mut buf).is_none(), "a reply nobody waits for");
        while self.device.poll_event().is_some() {}
    }

    fn check_state(&self) {
        assert!(self.device.poll_timeout().is_none_or(|due| due > self.now));
        let zsw = words::zsw(self.device.status()).raw();
        // ZSW.5, 9 and 11 are fixed; operation is never enabled in fault or turn-on disabled.
        assert_eq!(zsw & 0x0A20, 0x0A20);
        assert!(zsw & 0x0004 == 0 || zsw & 0x0048 == 0, "{zsw:04X}");
        assert_eq!(words::system_status(self.device.status()) & 0x0007, 0);
    }
}

/// Who waits for a reply to the last request to station 5 that these octets may hold at any place.
fn last_request(octets: &[u8]) -> Option<Address> {
    (0..octets.len()).rev().find_map(|at| match decode(&octets[at..]) {
        Decoded::Telegram { telegram: Telegram::Data(data), .. } if data.da.number() == OWN => {
            matches!(data.fc.function(), Function::Request(..)).then_some(data.sa)
        }
        _ => None,
    })
}

fn telegram(da: u8, sa: u8, dsap: Option<u8>, ssap: Option<u8>, fc: u8, data: &[u8]) -> Vec<u8> {
    let (dsap, ssap) = (dsap.and_then(Sap::new), ssap.and_then(Sap::new));
    let data = &data[..data.len().min(244)];
    let format = DataTelegram::customary_format(dsap, ssap, data);
    let format = if data.len() == 8 && dsap.is_none() && ssap.is_none() { Format::Sd3 } else { format };
    let (da, sa, fc) = (Address::from_octet(da), Address::from_octet(sa), FunctionCode::from_octet(fc));
    let telegram = DataTelegram { format, da, sa, dsap, ssap, fc, data };
    telegram.encode(&mut [0; MAX_TELEGRAM_LEN]).expect("at most 244 octets").to_vec()
}
