//! Slaves that answer with what they were sent, on a line in simulated time that checks the rules of the bus.
//!
//! The long versions of the tests that use it:
//! `PROFIDRIVE_LONG=1 cargo test --release --all-features --test line -- many_stations line_errors --nocapture`.
#![allow(dead_code, reason = "each test file uses its part")]

use profidrive::bench::{Answer, Line, ScriptedMaster as Master};
use profidrive::devices::StationEvent;
use profidrive::devices::ag03::profibus::{MAX_TELEGRAM_LEN, Timing};
use profidrive::host::{Bus, Participant};
use profidrive::profibus::dp;
use profidrive::profibus::dp::{Description, State};
use profidrive::profibus::fdl::{Address, ReplyStatus, Sap, Telegram};
use profidrive::time::{BaudRate, Instant};

pub(crate) use crate::long::long;

pub(crate) const BAUD: BaudRate = BaudRate::K12000;

/// 122 words of outputs and of inputs: 244 octets each, in two identifiers with two length octets.
pub(crate) const LARGE: &[u8] = &[0xC0, 0x7F, 0x7F, 0xC0, 0x79, 0x79];
pub(crate) const LARGE_LEN: usize = 244;
/// 8 octets of each.
pub(crate) const SMALL: &[u8] = &[0x37];
pub(crate) const SMALL_LEN: usize = 8;
pub(crate) const IDENT: u16 = 0x1234;

pub(crate) fn address(number: u8) -> Address {
    Address::station(number).unwrap()
}

/// A slave whose inputs are its outputs of the exchange before, each octet with the address, and behind the first
/// four octets the number of exchanges it has carried out.
pub(crate) struct Mirror {
    pub(crate) station: dp::Station,
    pub(crate) exchanges: u32,
}

impl Mirror {
    pub(crate) fn new(number: u8, configurations: &'static [&'static [u8]]) -> Self {
        let description =
            Description { ident: IDENT, sync_mode: true, freeze_mode: true, ..Description::default() };
        let max_tsdr = Some(BAUD.max_tsdr_bits());
        let application = dp::Fixed { configurations, ..dp::Fixed::PLAIN };
        let station = dp::Station::new(address(number), BAUD, max_tsdr, description, application);
        Self { station, exchanges: 0 }
    }

    pub(crate) fn state(&self) -> State {
        self.station.slave().state()
    }
}

impl Participant for Mirror {
    fn address(&self) -> Address {
        self.station.address()
    }
    fn set_baud(&mut self, baud: BaudRate) {
        self.station.set_baud(baud);
    }
    fn handle_telegram(&mut self, now: Instant, telegram: &Telegram<'_>, news: &mut dyn FnMut(StationEvent)) {
        let outcome = self.station.handle_telegram(now, telegram);
        if let Some(event) = outcome.event {
            news(StationEvent::Dp(event));
        }
        if outcome.exchanged {
            self.exchanges += 1;
            let mut inputs = [0; LARGE_LEN];
            let outputs = self.station.slave().outputs();
            let number = self.station.address().number();
            for (input, output) in inputs.iter_mut().zip(outputs) {
                *input = output ^ number;
            }
            let len = outputs.len();
            inputs[4..8].copy_from_slice(&self.exchanges.to_be_bytes());
            self.station.set_inputs(&inputs[..len]);
        }
    }
    fn handle_timeout(&mut self, now: Instant, news: &mut dyn FnMut(StationEvent)) {
        Participant::handle_timeout(&mut self.station, now, news);
    }
    fn poll_transmit(
        &mut self,
        now: Instant,
        buf: &mut [u8; MAX_TELEGRAM_LEN],
        news: &mut dyn FnMut(StationEvent),
    ) -> Option<usize> {
        Participant::poll_transmit(&mut self.station, now, buf, news)
    }
    fn poll_timeout(&self) -> Option<Instant> {
        self.station.poll_timeout()
    }
    fn watchdog_on(&self) -> bool {
        self.station.watchdog_on()
    }
}

pub(crate) fn line(numbers: impl IntoIterator<Item = u8>, configurations: &'static [&'static [u8]]) -> Line {
    let mut bus = Bus::on(BAUD, Timing::True);
    for number in numbers {
        bus.add(Mirror::new(number, configurations)).unwrap();
    }
    let mut line = Line::new(BAUD);
    line.connect(bus);
    line
}

pub(crate) fn mirror(line: &Line, number: u8) -> &Mirror {
    line.bus(0).unwrap().station(address(number)).unwrap()
}

/// Set_Prm with a watchdog of one second, Chk_Cfg, and a diagnosis that says ready.
pub(crate) fn start_up(line: &mut Line, master: &mut Master, number: u8, group: u8, cfg: &[u8]) {
    let [high, low] = IDENT.to_be_bytes();
    let prm = [0xB8, 10, 10, 11, high, low, group];
    for (sap, data) in [(61, &prm[..]), (62, cfg)] {
        assert_eq!(
            master.srd(line, address(number), Sap::new(sap), data),
            Ok(Answer::ShortAcknowledge),
            "{number}"
        );
    }
    let ready = [0x00, 0x0C, 0x00, master.address().number(), high, low];
    let diagnosis = master.srd(line, address(number), Sap::new(60), &[]);
    assert_eq!(diagnosis, Ok(Answer::Data(ReplyStatus::DataLow, &ready)), "{number}");
}

/// Outputs of an exchange that no other exchange has, as far as its first four octets go.
pub(crate) fn outputs(number: u8, round: u32) -> [u8; LARGE_LEN] {
    let mut octets = [0; LARGE_LEN];
    for (at, octet) in octets.iter_mut().enumerate() {
        *octet = (at as u8).wrapping_mul(7).wrapping_add(round as u8) ^ number;
    }
    octets[..4].copy_from_slice(&(round ^ u32::from(number) << 24).to_be_bytes());
    octets
}

/// The inputs that belong to the outputs of the exchange before; the first exchange has none.
pub(crate) fn inputs(number: u8, round: u32) -> [u8; LARGE_LEN] {
    if round == 0 {
        return [0; LARGE_LEN];
    }
    let mut octets = outputs(number, round - 1);
    for octet in &mut octets {
        *octet ^= number;
    }
    octets[4..8].copy_from_slice(&round.to_be_bytes());
    octets
}
