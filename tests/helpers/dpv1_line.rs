//! A slave of DP-V1 on a line in virtual time, its records, and the masters of both classes that ask it.
#![allow(dead_code, reason = "each test file uses its part")]

use std::collections::HashMap;
use std::time::Duration;

use profidrive::profibus::dp::{self, Description, Fixed, Station};
use profidrive::profibus::dpv1::{
    Acyclic, AlarmHead, AlarmOffer, AlarmType, Event, Ms2Offer, NotRaised, Offer, Specifier,
};
use profidrive::profibus::fdl::telegram::{Decoded, decode};
use profidrive::profibus::fdl::{Address, DataTelegram, FrameCount, FunctionCode, Sap, Service};
use profidrive::time::{BaudRate, Instant};

pub(crate) use crate::record_table::{Record, Table};
use crate::slave_line::{Answer, answer};

pub(crate) const SLAVE: u8 = 7;
pub(crate) const OWNER: u8 = 2;
pub(crate) const OTHER: u8 = 3;
const BAUD: BaudRate = BaudRate::K1500;

/// Everything on.
pub(crate) const FULL: Offer = Offer {
    ms1: Some(240),
    ms2: Some(Ms2Offer { connections: 2, max_data: 240, max_initiate: 52, min_send_timeout: 10 }),
    alarms: AlarmOffer { types: 0xFC, sequence: 8, extra_sap: true },
};

pub(crate) const DEVICE: Description = Description {
    ident: 0xC0DE,
    dpv1_status: Some([0xFB, 0xFF, 0xFF]),
    max_diag_len: 244,
    ..Description::PLAIN
};

/// Lock, watchdog of a second; DP-V1, all alarms, Alarm_Mode 0.
pub(crate) const PRM: [u8; 10] = [0x88, 10, 10, 11, 0xC0, 0xDE, 0, 0x80, 0xFC, 0x00];
pub(crate) const CFG: [u8; 1] = [0x31];

/// The line and its clock.
#[derive(Clone)]
pub(crate) struct V1Line {
    pub(crate) station: Station<Fixed<'static>>,
    pub(crate) acyclic: Acyclic<2, 8>,
    pub(crate) records: Table,
    pub(crate) now: Instant,
    pub(crate) events: Vec<Event>,
    pub(crate) dp_events: Vec<dp::Event>,
    /// When the last telegram was heard.
    pub(crate) heard: Instant,
    frame_counts: HashMap<u8, FrameCount>,
    last: Vec<u8>,
}

/// What a master sends to the slave and wants a reply to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Request {
    pub(crate) sa: u8,
    /// DSAP and SSAP; Data_Exchange has none.
    pub(crate) saps: Option<(u8, u8)>,
    pub(crate) service: Service,
    pub(crate) count: FrameCount,
    pub(crate) data: Vec<u8>,
}

impl Request {
    pub(crate) fn octets(&self) -> Vec<u8> {
        telegram((SLAVE, self.sa), self.saps, FunctionCode::request(self.service, self.count), &self.data)
    }
}

fn telegram((da, sa): (u8, u8), saps: Option<(u8, u8)>, fc: FunctionCode, data: &[u8]) -> Vec<u8> {
    let (dsap, ssap) = saps.map(|(dsap, ssap)| (Sap::new(dsap), Sap::new(ssap))).unwrap_or_default();
    let format = DataTelegram::customary_format(dsap, ssap, data);
    let (da, sa) = (Address::from_octet(da), Address::from_octet(sa));
    DataTelegram { format, da, sa, dsap, ssap, fc, data }.encode(&mut [0; 255]).unwrap().to_vec()
}

/// Global_Control of a master to all.
pub(crate) fn global_control(master: u8, command: u8) -> Vec<u8> {
    let fc = FunctionCode::request(Service::SdnHigh, FrameCount::Unused);
    telegram((Address::BROADCAST.number(), master), Some((58, 62)), fc, &[command, 0])
}

impl V1Line {
    /// Switched on, with a record of four octets at slot 1, index 10.
    pub(crate) fn new(offer: Offer) -> Self {
        Self::of(DEVICE, offer)
    }

    /// The same of another device.
    pub(crate) fn of(device: Description, offer: Offer) -> Self {
        let application = Fixed { configurations: &[&CFG], ..Fixed::PLAIN };
        let address = Address::station(SLAVE).unwrap();
        let mut records = Table::default();
        let record = |data: &[u8]| Record { data: data.to_vec(), ..Record::default() };
        records.records.insert((1, 10), record(&[0x11, 0x22, 0x33, 0x44]));
        Self {
            station: Station::new(address, BAUD, None, device, application),
            acyclic: Acyclic::new(offer),
            records,
            now: Instant::from_millis(1),
            events: Vec::new(),
            dp_events: Vec::new(),
            heard: Instant::ZERO,
            frame_counts: HashMap::new(),
            last: Vec::new(),
        }
    }

    /// In data exchange with the owner.
    pub(crate) fn exchanging(offer: Offer) -> Self {
        let mut line = Self::new(offer);
        line.start(OWNER, &PRM);
        line
    }

    pub(crate) fn start(&mut self, master: u8, prm: &[u8]) {
        assert_eq!(self.dp(master, 61, prm), Answer::Sc);
        assert_eq!(self.dp(master, 62, &CFG), Answer::Sc);
        assert_eq!(self.station.slave().state(), dp::State::DataExch);
    }

    pub(crate) fn put(&mut self, slot: u8, index: u8, record: Record) {
        self.records.records.insert((slot, index), record);
    }

    pub(crate) fn wait(&mut self, time: Duration) {
        let end = self.now.saturating_add(time);
        loop {
            let due = Instant::first_of(self.station.poll_timeout(), self.acyclic.poll_timeout());
            let Some(due) = due.filter(|due| *due <= end) else { break };
            self.now = self.now.max(due);
            self.dp_events.extend(self.acyclic.handle_timeout(&mut self.station, self.now));
            self.take_events();
        }
        self.now = end;
    }

    fn take_events(&mut self) {
        while let Some(event) = self.acyclic.poll_event() {
            self.events.push(event);
        }
    }

    /// Sends octets and returns those that come back.
    pub(crate) fn send(&mut self, octets: &[u8]) -> Option<Vec<u8>> {
        self.wait(BAUD.bit_times(100));
        self.heard = self.now;
        let Decoded::Telegram { telegram, .. } = decode(octets) else { panic!("{octets:02X?}") };
        let Self { station, acyclic, records, now, .. } = self;
        self.dp_events.extend(acyclic.handle_telegram(station, records, *now, &telegram).event);
        self.take_events();
        self.last = octets.to_vec();
        let due =
            self.station.poll_timeout().filter(|due| *due <= self.now.saturating_add(BAUD.bit_times(60)))?;
        let reply = self.station.poll_transmit(due).unwrap().map(<[u8]>::to_vec)?;
        self.now = due;
        Some(reply)
    }

    /// The telegram of before again.
    pub(crate) fn retry(&mut self) -> Answer {
        let octets = self.last.clone();
        answer(self.send(&octets))
    }

    /// A request from one SAP to another.
    pub(crate) fn srd(
        &mut self,
        master: u8,
        saps: Option<(u8, u8)>,
        service: Service,
        data: &[u8],
    ) -> Answer {
        let count = match self.frame_counts.get(&master) {
            None => FrameCount::First,
            Some(FrameCount::First | FrameCount::Odd | FrameCount::Unused) => FrameCount::Even,
            Some(FrameCount::Even) => FrameCount::Odd,
        };
        self.frame_counts.insert(master, count);
        let request = Request { sa: master, saps, service, count, data: data.to_vec() };
        answer(self.send(&request.octets()))
    }

    /// A service of DP-V0.
    pub(crate) fn dp(&mut self, master: u8, sap: u8, data: &[u8]) -> Answer {
        self.srd(master, Some((sap, 62)), Service::SrdHigh, data)
    }

    /// Global_Control of the owner to all.
    pub(crate) fn control(&mut self, command: u8) {
        let octets = global_control(OWNER, command);
        assert_eq!(self.send(&octets), None);
        assert!(self.dp_events.iter().any(|event| matches!(event, dp::Event::Controlled { .. })));
    }

    pub(crate) fn exchange(&mut self) -> Answer {
        self.srd(OWNER, None, Service::SrdHigh, &[0, 0])
    }

    /// The owner at SAP 51.
    pub(crate) fn ms1(&mut self, data: &[u8]) -> Answer {
        self.srd(OWNER, Some((51, 51)), Service::SrdLow, data)
    }

    /// The owner asks at SAP 51 and polls until there is an answer.
    pub(crate) fn ask(&mut self, data: &[u8]) -> Vec<u8> {
        assert_eq!(self.ms1(data), Answer::Sc);
        match self.ms1(&[]) {
            Answer::Low(octets) => octets,
            answer => panic!("polled: {answer:?}"),
        }
    }

    /// A master of class 2.
    pub(crate) fn ms2(&mut self, master: u8, sap: u8, data: &[u8]) -> Answer {
        self.srd(master, Some((sap, 50)), Service::SrdLow, data)
    }

    /// The same with an answer.
    pub(crate) fn ask_ms2(&mut self, master: u8, sap: u8, data: &[u8]) -> Vec<u8> {
        assert_eq!(self.ms2(master, sap, data), Answer::Sc);
        match self.ms2(master, sap, &[]) {
            Answer::Low(octets) => octets,
            answer => panic!("polled: {answer:?}"),
        }
    }

    pub(crate) fn diagnosis(&mut self, master: u8) -> Vec<u8> {
        match self.dp(master, 60, &[]) {
            Answer::Low(octets) => octets[6..].to_vec(),
            answer => panic!("Slave_Diag: {answer:?}"),
        }
    }

    pub(crate) fn raise(&mut self, kind: AlarmType, data: &[u8]) -> Result<AlarmHead, NotRaised> {
        self.acyclic.raise(&mut self.station, kind, (1, Specifier::Appears, false), data)
    }
}
