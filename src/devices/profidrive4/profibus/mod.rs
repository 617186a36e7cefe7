//! The drive on PROFIBUS: telegrams, parameters by record 47 over MS1 and MS2, identification.
//!
//! The telegram is that of the configuration which the master sent. What else a configuration and Set_Prm must be, the
//! station of a GSD judges.
//!
//! | file | holds |
//! | --- | --- |
//! | `signal`, `telegram` | the signals of process data, and which of them a telegram has |
//! | [`bits`], `words` | their bits; what they command and say |
//! | `free` | telegram 999, whose signals the master chooses |
//! | `family` | [`Family`]: the parameters that a drive begins with |
//! | `application` | [`TelegramOnly`]: a configuration must be a telegram |
//! | `table` | every parameter, as a row |
//! | `parameters`, `value` | their values, and the octets of them |
//! | `requests` | what is answered to a request in record 47 |
//! | `channel` | the same by PKW |
//! | `records`, `beside` | the records of the station; who is told of them |
//! | `memory` | what it keeps when it is stored |
//! | `description`, `why`, `event` | what it tells of itself |

mod application;
mod beside;
pub mod bits;
mod channel;
mod description;
mod event;
mod family;
mod free;
mod memory;
mod parameters;
mod records;
mod requests;
mod signal;
mod table;
mod telegram;
mod value;
mod why;
mod words;

pub use application::TelegramOnly;
pub use event::Event;
pub use family::Family;
pub(crate) use family::Settable;
pub use signal::Signal;
pub use telegram::Telegram;

use channel::Channel;
use parameters::{Effect, Known, Parameters};
use records::Pending;

use crate::devices::StationEvent;
use crate::devices::ag03::unit::{ApplicationCycle, Cycles};
use crate::devices::ppo_drive::profile::NotFollowed;
use crate::devices::profidrive4::{Command, Drive, Fault, Setting};
use crate::profibus::dp;
use crate::profibus::dp::{Application, Description};
use crate::profibus::dpv1::{self, Identification, LastRefused, Offer, PARAMETER_INDEX};
use crate::profibus::fdl::Address;
use crate::profibus::pkw;
use crate::profibus::ppo::{Pkw, Stw, Zsw};
use crate::time::{BaudRate, Instant};

/// The ident number of a drive that is nobody's in particular.
pub const IDENT_NUMBER: u16 = 0x5034;

/// Connections at once.
const CONNECTIONS: usize = 49;
/// It raises no alarms.
const ALARMS: usize = 0;
/// A sign of life counts from 1 to this.
const MOST_LIFE: u8 = 15;
/// The signs of life are not watched.
const NOT_WATCHED: f64 = 65535.0;

/// The drive on PROFIBUS: telegrams and time in, telegrams, news and a deadline out.
#[derive(Debug)]
pub struct ProfidriveDevice<A> {
    station: dp::Station<A>,
    acyclic: dpv1::Acyclic<CONNECTIONS, ALARMS>,
    parameters: Parameters,
    pending: Pending,
    refused: LastRefused,
    /// What of the last request of record 47 failed last.
    not_done: Option<Event>,
    identification: Identification,
    cycles: Cycles,
    /// The command in force, and STW1.
    command: (Command, u16),
    /// The outputs the drive was woken for, as counted by the slave.
    outputs_seen: u32,
    exchanging: bool,
    life: Life,
    channel: pkw::Engine,
    baud: BaudRate,
    /// What is in force from the next reset on.
    stored: Vec<((u16, u8), u32)>,
    /// What is to be stored was changed, for a host that keeps it.
    changed: bool,
    /// What is being stored.
    storing: Option<Vec<((u16, u8), u32)>>,
    is_kept: bool,
    /// News that wait for the next call.
    outbox: Vec<Event>,
}

/// The signs of life.
#[derive(Clone, Copy, Debug, Default)]
struct Life {
    master: u8,
    own: u8,
    failures: u32,
    /// Outputs counted when it was looked at last.
    seen: u32,
}

impl<A: Application> ProfidriveDevice<TelegramOnly<A>> {
    /// A drive that is switched on at `now`.
    pub fn new(
        address: Address,
        baud: BaudRate,
        (description, application): (Description, TelegramOnly<A>),
        (offer, identification): (Offer, Identification),
        Family(table): Family,
        now: Instant,
    ) -> Self {
        let mut this = Self {
            station: dp::Station::new(address, baud, None, description, application),
            acyclic: dpv1::Acyclic::new(offer),
            parameters: Parameters::new(Drive::new(now), table),
            pending: Pending::default(),
            refused: LastRefused::default(),
            not_done: None,
            identification,
            cycles: Cycles::new(ApplicationCycle::DEFAULT, now),
            command: Default::default(),
            outputs_seen: 0,
            exchanging: false,
            life: Life::default(),
            channel: pkw::Engine::new(channel::CONFIG),
            baud,
            stored: Vec::new(),
            changed: false,
            storing: None,
            is_kept: false,
            outbox: Vec::new(),
        };
        this.stored = this.parameters.kept(&this.known());
        this
    }

    /// Its slave.
    pub const fn slave(&self) -> &dp::Slave<TelegramOnly<A>> {
        self.station.slave()
    }

    /// The drive behind the bus.
    pub const fn drive(&self) -> &Drive {
        &self.parameters.drive
    }

    /// The telegram in force; `None`: no configuration is accepted.
    pub fn telegram(&self) -> Option<Telegram> {
        let only = self.slave().application().only;
        let configuration = self.slave().accepted_configuration()?;
        Some(self.parameters.free.fill(Telegram::of_configuration(configuration, only)?))
    }

    /// Control word 1 that was seen last; 0 without Data_Exchange.
    pub(crate) const fn stw1(&self) -> u16 {
        self.command.1
    }

    /// Status word 1 as it is offered to the master.
    pub fn zsw1(&self) -> u16 {
        words::zsw1(self.telegram().as_ref(), self.drive())
    }

    fn known(&self) -> Known {
        Known {
            address: self.station.address(),
            baud: self.baud,
            ident: self.slave().description().ident,
            telegram: self.telegram(),
            stw1: self.command.1,
            zsw1: self.zsw1(),
        }
    }

    /// A fault with this number comes. 0 raises none.
    pub(crate) fn raise_fault(&mut self, now: Instant, fault: Fault) {
        if fault.number() != 0 {
            self.parameters.drive.raise(fault, 0);
            self.cycles.wake(now);
        }
    }

    fn empty_outbox(&mut self, news: &mut dyn FnMut(StationEvent)) {
        self.outbox.drain(..).for_each(|event| news(StationEvent::Device(event).of_any()));
    }

    fn tell_acyclic(&mut self, news: &mut dyn FnMut(StationEvent)) {
        while let Some(event) = self.acyclic.poll_event() {
            self.pending.notice(&event);
            self.refused.notice(&event);
            if matches!(event, dpv1::Event::Written { index: PARAMETER_INDEX, .. }) {
                let failed = |event: &&Event| matches!(event, Event::Refused { .. });
                self.not_done = self.outbox.iter().rfind(failed).copied();
            }
            news(StationEvent::Acyclic(event));
        }
        if !self.acyclic.is_open() {
            self.pending.forget_owner();
        }
    }

    /// Carries out what a parameter asked for.
    fn carry_out(&mut self, now: Instant) {
        match self.parameters.effect.take() {
            Some(Effect::Store) => self.store(),
            Some(Effect::Reset) => self.reset(now),
            None => {}
        }
    }

    /// PNU 972: as if it were switched off and on.
    fn reset(&mut self, now: Instant) {
        self.outbox.push(Event::Reset);
        self.parameters.make_new();
        self.parameters.drive.restart(now);
        let stored = core::mem::take(&mut self.stored);
        self.parameters.recall(&self.known(), &stored);
        self.stored = stored;
        (self.command, self.life) = Default::default();
        self.cycles.wake(now);
    }

    fn wake(&mut self, now: Instant) {
        let passed = self.slave().output_updates();
        let exchanging = self.slave().state() == dp::State::DataExch;
        if passed != self.outputs_seen || exchanging != self.exchanging {
            self.outputs_seen = passed;
            self.cycles.wake(now);
        }
    }

    /// Lets everything happen that is due until `now`: watchdog, connections, application cycles.
    fn advance(&mut self, now: Instant, news: &mut dyn FnMut(StationEvent)) {
        self.empty_outbox(news);
        self.cycles.forfeit(now);
        loop {
            let cycle = self.cycles.next();
            let services = Instant::first_of(self.station.watchdog_timeout(), self.acyclic.poll_timeout());
            let Some(due) = Instant::first_of(services, cycle).filter(|due| *due <= now) else { return };
            if services == Some(due) {
                let Self { station, acyclic, .. } = self;
                if let Some(event) = acyclic.handle_timeout(station, due) {
                    news(StationEvent::Dp(event));
                }
                self.tell_acyclic(news);
                self.wake(due);
            } else {
                let at_rest = self.run_cycle(due, news);
                self.cycles.ran(due, at_rest);
                self.empty_outbox(news);
                self.carry_out(due);
                self.empty_outbox(news);
            }
        }
    }

    /// One application cycle: newest outputs in, one step, new inputs out. Says whether another one under the same outputs
    /// would change nothing.
    fn run_cycle(&mut self, due: Instant, news: &mut dyn FnMut(StationEvent)) -> bool {
        self.exchanging = self.slave().state() == dp::State::DataExch;
        let telegram = self.telegram().filter(|_| self.exchanging);
        let before = self.command;
        let mut is_new = false;
        match &telegram {
            Some(telegram) => {
                let outputs = self.slave().outputs().to_vec();
                is_new = self.watch_life(telegram, &outputs);
                let drive = &mut self.parameters.drive;
                let word =
                    |signal| telegram.setpoint(&outputs, signal).and_then(|word| u16::try_from(word).ok());
                self.command.1 = word(Signal::Stw1).unwrap_or_default();
                match words::command(telegram, &outputs, drive.settings()) {
                    Some(command) => self.command.0 = command,
                    // What was commanded holds. An edge in a word that is not looked at is none.
                    None => self.command.0.control.acknowledge = false,
                }
                if let Some(word) = word(Signal::G1Stw) {
                    drive.command_encoder(words::encoder_command(word));
                }
                drive.step(due, Some(&self.command.0));
                let [before, stw, zsw] = [before.1, self.command.1, words::zsw1(Some(telegram), drive)];
                let word = NotFollowed::of(Stw::from_raw(before), Stw::from_raw(stw), Zsw::from_raw(zsw));
                if let Some(word) = word {
                    news(StationEvent::Device(Event::NotFollowed(word)).of_any());
                }
            }
            None => {
                (self.command, self.life) = Default::default();
                self.channel.reset();
                self.parameters.drive.step(due, None);
            }
        }
        if let Some(telegram) = &telegram {
            let reply = self.answer(telegram);
            let (drive, life) = (&self.parameters.drive, self.life.own);
            let inputs = telegram.inputs(reply, |signal| words::actual(telegram, drive, life, signal));
            self.station.set_inputs(&inputs);
        }
        while let Some(event) = self.parameters.drive.poll_event() {
            news(StationEvent::Device(Event::Drive(event)).of_any());
        }
        !is_new && before == self.command && self.drive().is_at_rest()
    }

    /// What PKW answers.
    fn answer(&mut self, telegram: &Telegram) -> Pkw {
        let Some(job) = telegram.job(self.slave().outputs()) else { return Pkw::ZERO };
        let known = self.known();
        let Self { channel, parameters, outbox, .. } = self;
        let mut of_drive = Channel { parameters, known: &known, told: outbox };
        let pkw::Outcome { reply, refusal } = channel.cycle(job, &mut of_drive);
        outbox.extend(refusal.map(Event::JobRefused));
        reply
    }

    /// Counts the sign of life of the drive, and watches that of the master in each new Data_Exchange. Says whether one came.
    fn watch_life(&mut self, telegram: &Telegram, outputs: &[u8]) -> bool {
        let Some(word) = telegram.setpoint(outputs, Signal::Stw2).and_then(|word| u16::try_from(word).ok())
        else {
            return false;
        };
        let updates = self.slave().output_updates();
        if updates == self.life.seen {
            return false;
        }
        self.life.seen = updates;
        let (before, now) = (self.life.master, words::life(word));
        self.life.master = now;
        // 0: the master does not use it.
        if now == 0 {
            self.life.own = 0;
            self.life.failures = 0;
            return before != 0;
        }
        self.life.own = self.life.own % MOST_LIFE + 1;
        let follows = before == 0 || now == before % MOST_LIFE + 1;
        self.life.failures = if follows { 0 } else { self.life.failures.saturating_add(1) };
        let tolerated = self.drive().settings().of(Setting::SignOfLifeFailures);
        if tolerated < NOT_WATCHED && f64::from(self.life.failures) > tolerated {
            let failures = i32::try_from(self.life.failures).unwrap_or(i32::MAX);
            self.parameters.drive.raise(Fault::SignOfLife, failures);
            self.life.failures = 0;
        }
        true
    }
}
