//! A slave of any description on a line in virtual time, and masters that speak to it.
#![allow(dead_code, reason = "each test file uses its part")]

use std::collections::HashMap;
use std::time::Duration;

use profidrive::profibus::dp::{Application, Description, Event, ExtDiag, Fixed, Policy, Station};
use profidrive::profibus::fdl::telegram::{Decoded, decode};
use profidrive::profibus::fdl::{Address, FrameCount, FunctionCode, Service, Telegram};
use profidrive::profibus::fdl::{Framer, Resync};
use profidrive::time::{BaudRate, Instant};

use crate::telegrams;

#[allow(unused_imports, reason = "each test file uses its part")]
pub(crate) use telegrams::{hex, telegram};

pub(crate) const SLAVE: u8 = 5;
pub(crate) const MASTER: u8 = 2;
pub(crate) const OTHER: u8 = 3;
pub(crate) const BAUD: BaudRate = BaudRate::K12000;

/// Four octets out, four octets in.
pub(crate) const IO: Description = Description {
    ident: 0x1234,
    max_diag_len: 244,
    sync_mode: true,
    freeze_mode: true,
    fail_safe: true,
    set_slave_add: true,
    ..Description::PLAIN
};

/// What [`IO`] accepts: four octets each way, or two.
pub(crate) const ACCEPTS: Fixed<'static> = accepting(&[&[0x23, 0x13], &[0x21, 0x11]]);

/// The application of a slave with these configurations.
pub(crate) const fn accepting(configurations: &'static [&'static [u8]]) -> Fixed<'static> {
    Fixed { configurations, ..Fixed::PLAIN }
}

/// Lock, watchdog off.
pub(crate) const PRM: [u8; 7] = [0x80, 1, 1, 11, 0x12, 0x34, 0];
pub(crate) const CFG: [u8; 2] = [0x23, 0x13];

/// What came back.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Answer {
    Silence,
    Sc,
    /// SD1 with this FC.
    Sd1(u8),
    /// DL.
    Low(Vec<u8>),
    /// DH.
    High(Vec<u8>),
}

pub(crate) const RS: Answer = Answer::Sd1(0x03);
pub(crate) const RR: Answer = Answer::Sd1(0x02);

/// The line, its clock and the slave on it.
#[derive(Clone)]
pub(crate) struct SlaveLine<A = Fixed<'static>> {
    pub(crate) station: Station<A>,
    pub(crate) now: Instant,
    pub(crate) events: Vec<Event>,
    framer: Framer,
    frame_counts: HashMap<(u8, u8), FrameCount>,
}

impl SlaveLine {
    pub(crate) fn new(description: Description) -> Self {
        Self::with(description, Policy::PROPOSED)
    }

    pub(crate) fn with(description: Description, policy: Policy) -> Self {
        Self::judged_by(ACCEPTS, description, policy)
    }

    /// The slave at this address, up to Data_Exchange.
    pub(crate) fn exchanging(description: Description, policy: Policy) -> Self {
        let mut line = Self::with(description, policy);
        line.start_up();
        line
    }
}

impl<A: Application> SlaveLine<A> {
    pub(crate) fn judged_by(application: A, description: Description, policy: Policy) -> Self {
        let (address, max_tsdr) = (Address::station(SLAVE).unwrap(), Some(BAUD.max_tsdr_bits()));
        Self::of(Station::new(address, BAUD, max_tsdr, description, application).with_policy(policy))
    }

    pub(crate) fn of(station: Station<A>) -> Self {
        Self {
            station,
            now: Instant::from_millis(1),
            events: Vec::new(),
            framer: Framer::new(Resync::Idle(BAUD)),
            frame_counts: HashMap::new(),
        }
    }

    pub(crate) fn start_up(&mut self) {
        assert_eq!(self.request(MASTER, Some(61), &PRM), Answer::Sc);
        assert_eq!(self.request(MASTER, Some(62), &CFG), Answer::Sc);
    }

    pub(crate) fn wait(&mut self, time: Duration) {
        let end = self.now.saturating_add(time);
        while let Some(due) = self.station.poll_timeout().filter(|due| *due <= end) {
            self.now = self.now.max(due);
            assert_eq!(self.station.poll_transmit(self.now), Ok(None), "a reply nobody asked for");
            let event = self.station.handle_timeout(self.now);
            assert!(event.is_some(), "a deadline with nothing to do");
            self.events.extend(event);
        }
        self.now = end;
    }

    /// Sends octets as one request and returns what comes back.
    pub(crate) fn send(&mut self, octets: &[u8]) -> Option<Vec<u8>> {
        self.wait(BAUD.bit_times(33));
        self.framer.handle_timeout(self.now, |_, _| {});
        self.wait(BAUD.octet_times(octets.len().try_into().unwrap()));
        let Self { station, events, framer, .. } = self;
        framer.handle_bytes(self.now, octets, |at, result| {
            if let Ok(telegram) = result {
                events.extend(station.handle_telegram(at, &telegram).event);
            }
        });
        let end = self.now.saturating_add(BAUD.bit_times(BAUD.max_tsdr_bits().into()));
        let due = self.station.poll_timeout().filter(|due| *due <= end)?;
        let reply = self.station.poll_transmit(due).unwrap().map(<[u8]>::to_vec)?;
        self.now = due.saturating_add(BAUD.octet_times(reply.len().try_into().unwrap()));
        Some(reply)
    }

    pub(crate) fn request(&mut self, sa: u8, dsap: Option<u8>, data: &[u8]) -> Answer {
        self.request_to(SLAVE, sa, dsap, data)
    }

    /// A request with the next frame count and its reply; None as `dsap` is Data_Exchange.
    pub(crate) fn request_to(&mut self, da: u8, sa: u8, dsap: Option<u8>, data: &[u8]) -> Answer {
        let octets = self.srd(da, sa, dsap, data);
        answer(self.send(&octets))
    }

    /// The octets of a request with the next frame count.
    pub(crate) fn srd(&mut self, da: u8, sa: u8, dsap: Option<u8>, data: &[u8]) -> Vec<u8> {
        let count = match self.frame_counts.get(&(da, sa)) {
            None => FrameCount::First,
            Some(FrameCount::First | FrameCount::Odd | FrameCount::Unused) => FrameCount::Even,
            Some(FrameCount::Even) => FrameCount::Odd,
        };
        self.frame_counts.insert((da, sa), count);
        telegram(da, sa, FunctionCode::request(Service::SrdHigh, count), dsap, data)
    }

    pub(crate) fn sdn(&mut self, sa: u8, da: u8, dsap: u8, data: &[u8]) {
        let fc = FunctionCode::request(Service::SdnHigh, FrameCount::Unused);
        assert_eq!(self.send(&telegram(da, sa, fc, Some(dsap), data)), None);
    }

    pub(crate) fn diagnosis(&mut self, sa: u8) -> Vec<u8> {
        match self.request(sa, Some(60), &[]) {
            Answer::Low(octets) => octets,
            answer => panic!("Slave_Diag answered {answer:?}"),
        }
    }

    pub(crate) fn exchange(&mut self, outputs: &[u8]) -> Answer {
        self.request(MASTER, None, outputs)
    }

    pub(crate) fn file(&mut self, diagnosis: &ExtDiag) {
        self.station.file_diagnosis(diagnosis);
    }

    pub(crate) fn outputs(&self) -> &[u8] {
        self.station.slave().outputs()
    }

    pub(crate) fn happened(&self, wanted: impl Fn(&Event) -> bool) -> usize {
        self.events.iter().filter(|event| wanted(event)).count()
    }
}

pub(crate) fn answer(octets: Option<Vec<u8>>) -> Answer {
    let Some(octets) = octets else { return Answer::Silence };
    let Decoded::Telegram { telegram, len } = decode(&octets) else { panic!("{octets:02X?}") };
    assert_eq!(len, octets.len());
    let data = match telegram {
        Telegram::ShortAcknowledge => return Answer::Sc,
        Telegram::Token { .. } => panic!("a slave passes no token"),
        Telegram::Data(data) => data,
    };
    match (data.data.is_empty(), data.fc.octet()) {
        (true, fc) => Answer::Sd1(fc),
        (false, 0x08) => Answer::Low(data.data.to_vec()),
        (false, 0x0A) => Answer::High(data.data.to_vec()),
        (false, fc) => panic!("data with FC {fc:02X}"),
    }
}
