//! A station that the judge plays: a slave, and beside it the services of DP-V1 that it has.

use core::fmt;
use core::time::Duration;
use std::collections::BTreeMap;

use super::setup::Slave;
use crate::devices::StationEvent;
use crate::gsd;
use crate::host::Participant;
use crate::profibus::dp::application::Expected;
use crate::profibus::dp::{self, Application, Event, ExtDiag, Reason, Refusal, Service};
use crate::profibus::dpv1::{
    Acyclic, AlarmType, ErrorCode, Failure, Identification, Job, MS1_SAP, NotDone, PARAMETER_INDEX, Records,
    Specifier, identification,
};
use crate::profibus::fdl::{Address, MAX_TELEGRAM_LEN, Rates, Telegram};
use crate::time::{BaudRate, Instant};

/// Connections at once, and alarms that wait.
const CONNECTIONS: usize = 4;
const ALARMS: usize = 32;

/// Alarms raised at once: a master that takes one of each type has two to tell apart.
const RAISED: usize = 2;

/// The slot of an alarm, and what the manufacturer says about it.
const ALARM_SLOT: u8 = 1;
const ALARM_DATA: [u8; 1] = [0x50];

/// What is in a record that no master has written.
const UNWRITTEN: [u8; 4] = [0x11, 0x22, 0x33, 0x44];

/// The types of alarms in the order in which they are tried.
const ALARM_TYPES: [AlarmType; 7] = [
    AlarmType::Process,
    AlarmType::Diagnostic,
    AlarmType::Status,
    AlarmType::Update,
    AlarmType::Pull,
    AlarmType::Plug,
    AlarmType::Manufacturer(32),
];

/// A station under the judge.
#[derive(Debug)]
pub(super) struct Played {
    station: dp::Station<Judged>,
    services: Option<Box<Services>>,
    /// The next reply of a service of DP-V1 is lost.
    loses: bool,
    /// The reply that waits is one.
    is_of_services: bool,
}

/// DP-V1 beside the slave.
#[derive(Debug)]
struct Services {
    acyclic: Acyclic<CONNECTIONS, ALARMS>,
    records: Answering,
}

/// How jobs are carried out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Mood {
    /// At once.
    #[default]
    Usual,
    /// Each takes so long.
    Slow(Duration),
    /// None ends.
    Stuck,
    /// Each is refused.
    Refusing,
}

/// Records that keep what a master writes, at every slot and index.
#[derive(Debug, Default)]
struct Answering {
    written: BTreeMap<(u8, u8), Vec<u8>>,
    mood: Mood,
}

impl Played {
    pub(super) fn new(slave: &Slave, station: dp::Station<Judged>) -> Self {
        let offer = slave.offer();
        let services = || Box::new(Services { acyclic: Acyclic::new(offer), records: Answering::default() });
        let services = (!offer.is_none()).then(services);
        Self { station, services, loses: false, is_of_services: false }
    }

    pub(super) const fn slave(&self) -> &dp::Slave<Judged> {
        self.station.slave()
    }

    pub(super) fn abort(&mut self) {
        self.station.abort();
    }

    pub(super) fn file_diagnosis(&mut self, diagnosis: &ExtDiag) {
        match &mut self.services {
            Some(services) => services.acyclic.file_diagnosis(&mut self.station, diagnosis),
            None => self.station.file_diagnosis(diagnosis),
        }
    }

    /// How jobs are carried out from now on.
    pub(super) fn set_mood(&mut self, mood: Mood) {
        if let Some(services) = &mut self.services {
            services.records.mood = mood;
        }
    }

    /// The next reply of a service of DP-V1 is not sent.
    pub(super) const fn lose_response(&mut self) {
        self.loses = true;
    }

    /// Raises alarms that the master takes, one with a fault and one without.
    pub(super) fn raise_alarms(&mut self) {
        let Self { station, services: Some(services), .. } = self else { return };
        let mut specifiers = [Specifier::Appears, Specifier::None].iter().cycle();
        let mut raise = |kind| {
            let specifier = specifiers.next().copied().unwrap_or(Specifier::None);
            services.acyclic.raise(station, kind, (ALARM_SLOT, specifier, false), &ALARM_DATA).is_ok()
        };
        let kinds = ALARM_TYPES.iter().chain(&ALARM_TYPES);
        let _raised = kinds.filter(|kind| raise(**kind)).take(RAISED).count();
    }

    pub(super) fn handle(&mut self, now: Instant, telegram: &Telegram<'_>) -> dp::Outcome {
        let is_service = |sap: u8| sap <= MS1_SAP;
        if let Telegram::Data(data) = telegram
            && data.da == self.station.address()
        {
            let known = Service::of(data.dsap, data.ssap).is_some();
            self.is_of_services = !known && data.dsap.is_some_and(|sap| is_service(sap.number()));
        }
        match &mut self.services {
            Some(services) => {
                let Services { acyclic, records } = &mut **services;
                let outcome = acyclic.handle_telegram(&mut self.station, records, now, telegram);
                while acyclic.poll_event().is_some() {}
                outcome
            }
            None => self.station.handle_telegram(now, telegram),
        }
    }

    fn pass(&mut self, now: Instant) -> Option<Event> {
        match &mut self.services {
            Some(services) => services.acyclic.handle_timeout(&mut self.station, now),
            None => self.station.handle_timeout(now),
        }
    }
}

impl Participant for Played {
    fn address(&self) -> Address {
        self.station.address()
    }

    fn set_baud(&mut self, baud: BaudRate) {
        self.station.set_baud(baud);
    }

    fn rates(&self) -> Rates {
        Participant::rates(&self.station)
    }

    fn handle_telegram(&mut self, now: Instant, telegram: &Telegram<'_>, news: &mut dyn FnMut(StationEvent)) {
        if let Some(event) = self.handle(now, telegram).event {
            news(StationEvent::Dp(event));
        }
    }

    fn handle_timeout(&mut self, now: Instant, news: &mut dyn FnMut(StationEvent)) {
        if let Some(event) = self.pass(now) {
            news(StationEvent::Dp(event));
        }
    }

    fn poll_transmit(
        &mut self,
        now: Instant,
        buf: &mut [u8; MAX_TELEGRAM_LEN],
        news: &mut dyn FnMut(StationEvent),
    ) -> Option<usize> {
        let len = Participant::poll_transmit(&mut self.station, now, buf, news)?;
        let is_lost = self.is_of_services && core::mem::take(&mut self.loses);
        (!is_lost).then_some(len)
    }

    fn poll_timeout(&self) -> Option<Instant> {
        let of_services = self.services.as_ref().and_then(|services| services.acyclic.poll_timeout());
        Instant::first_of(self.station.poll_timeout(), of_services)
    }

    fn watchdog_on(&self) -> bool {
        self.station.slave().watchdog_on()
    }
}

impl Answering {
    /// What becomes of a job now; `None`: it is carried out.
    fn held_up(&self, job: &Job) -> Option<NotDone> {
        match self.mood {
            Mood::Usual => None,
            Mood::Slow(takes) => (job.now.saturating_since(job.since) < takes).then_some(NotDone::Yet),
            Mood::Stuck => Some(NotDone::Yet),
            Mood::Refusing => Some(NotDone::refused(ErrorCode::INVALID_INDEX)),
        }
        // A station that is no drive.
        .or((job.index == PARAMETER_INDEX).then_some(NotDone::refused(ErrorCode::INVALID_INDEX)))
    }
}

impl Records for Answering {
    fn read(&mut self, job: &Job, out: &mut [u8]) -> Result<usize, NotDone> {
        if let Some(not_done) = self.held_up(job) {
            return Err(not_done);
        }
        let data = self.written.get(&(job.slot, job.index)).map_or(&UNWRITTEN[..], Vec::as_slice);
        for (place, octet) in out.iter_mut().zip(data) {
            *place = *octet;
        }
        Ok(data.len())
    }

    fn write(&mut self, job: &Job, data: &[u8]) -> Result<(), NotDone> {
        if let Some(not_done) = self.held_up(job) {
            return Err(not_done);
        }
        self.written.insert((job.slot, job.index), data.to_vec());
        Ok(())
    }

    fn identification(&mut self, _: u8, block: u16) -> Result<[u8; identification::LEN], Failure> {
        match block {
            0 => Ok(Identification::PLAIN.octets()),
            1.. => Err(Failure::of(ErrorCode::INVALID_INDEX)),
        }
    }
}

/// Who judges Set_Prm and Chk_Cfg of a station.
#[derive(Clone, Debug)]
pub(super) enum Judged {
    /// This configuration, and any user parameters: what is wrong with them the rows say.
    Numbers(Vec<u8>),
    /// What its device file says.
    Gsd(Box<gsd::Station>),
}

impl Application for Judged {
    fn judge_prm(&self, user_prm: &[u8]) -> Result<(), Refusal> {
        match self {
            Self::Numbers(_) => Ok(()),
            Self::Gsd(station) => station.judge_prm(user_prm),
        }
    }

    fn judge_cfg(&self, configuration: &[u8], user_prm: &[u8]) -> Result<(), Refusal> {
        match self {
            Self::Numbers(cfg) if cfg == configuration => Ok(()),
            Self::Numbers(cfg) => {
                let index = cfg.iter().zip(configuration).take_while(|(one, other)| one == other).count();
                let expected = cfg.get(index).map_or(Expected::End, |octet| Expected::Octet(*octet));
                let reason = Reason::Text("the configuration that the judge was given");
                Err(Refusal { index, expected, got: configuration.get(index).copied(), reason })
            }
            Self::Gsd(station) => station.judge_cfg(configuration, user_prm),
        }
    }

    fn configuration<'a>(&'a self, accepted: Option<&'a [u8]>) -> &'a [u8] {
        match self {
            Self::Numbers(cfg) => accepted.unwrap_or(cfg),
            Self::Gsd(station) => station.configuration(accepted),
        }
    }

    fn words(&self, number: u16, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Numbers(_) => Ok(()),
            Self::Gsd(station) => station.words(number, f),
        }
    }
}
