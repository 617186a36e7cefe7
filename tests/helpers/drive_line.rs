//! One emulated drive on a line in virtual time, and a scripted master that speaks to it.
//!
//! The master says, the slave answers, at this time. Every request is preceded by T_SYN, every reply is checked to
//! start between min and max T_SDR and to be a whole telegram.
#![allow(dead_code, reason = "each test file uses its part")]

use std::collections::HashMap;
use std::time::Duration;

use profidrive::devices::StationEvent;
use profidrive::devices::ag03::profibus::{
    ApplicationCycle, Config, Device, Event, MAX_TELEGRAM_LEN, Timing,
};
use profidrive::devices::ag03::unit;
use profidrive::profibus::fdl::telegram::{Decoded, decode};
use profidrive::profibus::fdl::{Address, FrameCount, FunctionCode, Sap, Service, Telegram};
use profidrive::time::{BaudRate, Instant};

use crate::telegrams;

#[allow(unused_imports, reason = "each test file uses its part")]
pub(crate) use telegrams::{hex, telegram};

pub(crate) const SLAVE: u8 = 5;
pub(crate) const MASTER: u8 = 2;
pub(crate) const IDENT: [u8; 2] = [0x0A, 0xC5];
pub(crate) const CFG: [u8; 2] = [0xF3, 0xF2];
pub(crate) const RS: Reply = Reply::Status(3);
pub(crate) const RR: Reply = Reply::Status(2);

/// What came back.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Reply {
    /// Nothing within the slot time.
    Silence,
    /// SC.
    Sc,
    /// SD1 with this status.
    Status(u8),
    /// Data with low priority.
    Data(Vec<u8>),
}

/// The line, its clock and the drive on it.
#[derive(Clone)]
pub(crate) struct Line {
    pub(crate) device: Device,
    pub(crate) now: Instant,
    pub(crate) baud: BaudRate,
    /// The earliest reply allowed, in T_bit.
    pub(crate) min_tsdr: u32,
    pub(crate) events: Vec<StationEvent<Event>>,
    /// The frame count of each master.
    frame_counts: HashMap<u8, FrameCount>,
}

/// What an event says about the unit.
pub(crate) fn of_unit(event: &StationEvent<Event>) -> Option<&unit::Event> {
    if let StationEvent::Device(Event::Unit { event, .. }) = event { Some(event) } else { None }
}

impl Line {
    /// Whether the unit has told this.
    pub(crate) fn has_told(&self, wanted: &unit::Event) -> bool {
        self.events.iter().filter_map(of_unit).any(|event| event == wanted)
    }

    pub(crate) fn new() -> Self {
        Self::at(BaudRate::K500)
    }

    pub(crate) fn at(baud: BaudRate) -> Self {
        let address = Address::station(SLAVE).unwrap();
        Self::with(Config { baud, timing: Timing::True, ..Config::new(address) })
    }

    /// A line on which the drive part runs once after each Data_Exchange.
    pub(crate) fn counting_exchanges() -> Self {
        let address = Address::station(SLAVE).unwrap();
        let config = Config {
            timing: Timing::True,
            application_cycle: ApplicationCycle::EACH_EXCHANGE,
            ..Config::new(address)
        };
        Self::with(config)
    }

    pub(crate) fn with(config: Config) -> Self {
        let now = Instant::from_millis(1);
        let device = Device::new(config, now);
        Self {
            device,
            now,
            baud: config.baud,
            min_tsdr: 11,
            events: Vec::new(),
            frame_counts: HashMap::new(),
        }
    }

    /// Lets time pass, waking the drive whenever it asks to be.
    pub(crate) fn wait(&mut self, time: Duration) {
        let end = self.now.saturating_add(time);
        while let Some(due) = self.device.poll_timeout().filter(|due| *due <= end) {
            assert!(due >= self.now, "a deadline in the past");
            self.now = due;
            self.device.handle_timeout(due);
            assert_eq!(self.drain(), None, "a reply nobody asked for");
            assert!(self.device.poll_timeout() > Some(due) || self.device.poll_timeout().is_none());
        }
        self.now = end;
    }

    /// Sends octets as one request and returns what comes back within the slot time.
    pub(crate) fn send(&mut self, octets: &[u8]) -> Option<Vec<u8>> {
        self.wait(self.baud.bit_times(33));
        self.wait(self.baud.octet_times(octets.len().try_into().unwrap()));
        let end = self.now;
        self.device.handle_bytes(end, octets);
        let latest = end.saturating_add(self.baud.bit_times(self.baud.max_tsdr_bits().into()));
        let mut reply = self.drain();
        while reply.is_none() {
            let Some(due) = self.device.poll_timeout().filter(|due| *due <= latest) else {
                self.now = latest;
                return None;
            };
            self.now = due;
            self.device.handle_timeout(due);
            reply = self.drain();
        }
        let earliest = end.saturating_add(self.baud.bit_times(self.min_tsdr));
        assert!(self.now >= earliest, "reply at {} before {earliest}", self.now);
        let reply = reply.unwrap();
        self.wait(self.baud.octet_times(reply.len().try_into().unwrap()));
        Some(reply)
    }

    /// A request by `sa` with the next frame count and its reply; None as `dsap` is Data_Exchange.
    pub(crate) fn request(&mut self, sa: u8, dsap: Option<u8>, data: &[u8]) -> Reply {
        let octets = self.srd(sa, dsap, data);
        self.reply_to(&octets, sa, dsap)
    }

    /// The octets of a request by `sa` with the next frame count.
    pub(crate) fn srd(&mut self, sa: u8, dsap: Option<u8>, data: &[u8]) -> Vec<u8> {
        let count = match self.frame_counts.get(&sa) {
            None => FrameCount::First,
            Some(FrameCount::First | FrameCount::Odd | FrameCount::Unused) => FrameCount::Even,
            Some(FrameCount::Even) => FrameCount::Odd,
        };
        self.frame_counts.insert(sa, count);
        telegram(SLAVE, sa, FunctionCode::request(Service::SrdHigh, count), dsap, data)
    }

    /// Sends a request by `sa` to `dsap` and checks that the reply mirrors it.
    pub(crate) fn reply_to(&mut self, octets: &[u8], sa: u8, dsap: Option<u8>) -> Reply {
        let Some(octets) = self.send(octets) else {
            return Reply::Silence;
        };
        let Decoded::Telegram { telegram, len } = decode(&octets) else { panic!("{octets:02X?}") };
        assert_eq!(len, octets.len());
        let data = match telegram {
            Telegram::ShortAcknowledge => return Reply::Sc,
            Telegram::Token { .. } => panic!("a slave passes no token"),
            Telegram::Data(data) => data,
        };
        assert_eq!((data.da.number(), data.sa.number()), (sa, SLAVE));
        if data.data.is_empty() {
            return Reply::Status(data.fc.octet());
        }
        assert_eq!(data.fc.octet(), 0x08, "DL");
        assert_eq!(
            (data.dsap, data.ssap),
            (dsap.and(Sap::new(62)), dsap.and_then(Sap::new)),
            "SAPs mirrored"
        );
        Reply::Data(data.data.to_vec())
    }

    /// Sends data without acknowledge and checks that nothing comes back.
    pub(crate) fn sdn(&mut self, sa: u8, da: u8, dsap: u8, data: &[u8]) {
        let fc = FunctionCode::request(Service::SdnHigh, FrameCount::Unused);
        assert_eq!(self.send(&telegram(da, sa, fc, Some(dsap), data)), None);
    }

    pub(crate) fn global_control(&mut self, command: u8, groups: u8) {
        self.sdn(MASTER, 127, 58, &[command, groups]);
    }

    pub(crate) fn diagnosis(&mut self, sa: u8) -> [u8; 6] {
        let Reply::Data(octets) = self.request(sa, Some(60), &[]) else { panic!("no diagnosis") };
        octets.try_into().unwrap()
    }

    /// Set_Prm and Chk_Cfg as a class 1 master does, then the diagnosis must be free of faults.
    pub(crate) fn start_up(&mut self) {
        self.start_up_with(&[0x80, 1, 1, 11, IDENT[0], IDENT[1], 0]);
    }

    pub(crate) fn start_up_with(&mut self, prm: &[u8]) {
        assert_eq!(self.request(MASTER, Some(61), prm), Reply::Sc);
        assert_eq!(self.request(MASTER, Some(62), &CFG), Reply::Sc);
        let [first, second, ..] = self.diagnosis(MASTER);
        assert_eq!((first, second & 0x07), (0x00, 0x04), "ready for Data_Exchange");
    }

    /// One Data_Exchange; the inputs were ready before the outputs were seen.
    pub(crate) fn exchange(&mut self, outputs: &[u8]) -> [u8; 14] {
        match self.request(MASTER, None, outputs) {
            Reply::Data(inputs) => inputs.try_into().unwrap(),
            reply @ (Reply::Silence | Reply::Sc | Reply::Status(_)) => panic!("no inputs but {reply:?}"),
        }
    }

    fn drain(&mut self) -> Option<Vec<u8>> {
        let mut buf = [0xA5; MAX_TELEGRAM_LEN];
        let reply = self.device.poll_transmit(self.now, &mut buf).map(<[u8]>::to_vec);
        assert_eq!(self.device.poll_transmit(self.now, &mut buf), None, "one reply to one request");
        while let Some(event) = self.device.poll_event() {
            self.events.push(event);
        }
        reply
    }
}
