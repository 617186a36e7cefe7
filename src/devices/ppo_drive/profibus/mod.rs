//! A drive of the profile on PROFIBUS, with the parameters of a table (feature `std`).
//!
//! The PPO is that of the configuration which the master sent: its octets, and whether they begin with the eight of the
//! parameter channel. So any application of the slave will do: [`Fixed`](crate::profibus::dp::Fixed) with the identifiers of
//! [`PpoType`], or the station of a GSD.
//!
//! | file | holds |
//! | --- | --- |
//! | `application` | [`PpoOnly`]: a configuration must be a PPO |
//! | `description` | what acts on it, and what it tells of itself |
//! | `event` | [`Event`]: news of such a drive |
//! | `family` | [`Family`]: how parameters are numbered on the bus |
//! | `memory` | what it keeps while it is switched off |
//! | `parameters` | the table as the parameter channel reaches it |
//! | `why` | what keeps it from turning |

mod application;
mod description;
mod event;
mod family;
mod memory;
mod parameters;
mod why;

use super::profile;
use crate::devices::StationEvent;
use crate::devices::ag03::unit::{ApplicationCycle, Cycles};
use crate::devices::ppo_drive::table::{Channel, Row, Table, Tie};
use crate::devices::ppo_drive::{Command, Drive, Fault, Quantity, SetError, Settings};
use crate::profibus::dp;
use crate::profibus::dp::chk_cfg::{Identifier, Units, identifiers};
use crate::profibus::dp::{Application, Description};
use crate::profibus::fdl::Address;
use crate::profibus::pkw;
use crate::profibus::pkw::{Engine, JobError, Value};
use crate::profibus::ppo::{Pkw, PpoType, Stw, Zsw};
use crate::time::{BaudRate, Instant};

pub use application::PpoOnly;
pub use event::Event;
pub use family::Family;

use memory::Memory;
use parameters::{Access, Known, View};

/// The ident number of a drive that is nobody's in particular.
pub const IDENT_NUMBER: u16 = 0x5044;

/// The configurations of all five types of PPO, for [`dp::Fixed`].
pub const CONFIGURATIONS: &[&[u8]] = &[
    PpoType::Ppo1.configuration(),
    PpoType::Ppo2.configuration(),
    PpoType::Ppo3.configuration(),
    PpoType::Ppo4.configuration(),
    PpoType::Ppo5.configuration(),
];

/// Octets of the parameter channel.
const PKW_LEN: usize = 8;

/// Words of process data behind the first two, of PPO 5.
const MORE_WORDS: usize = 8;

/// A drive of the profile on PROFIBUS: telegrams and time in, telegrams, news and a deadline out.
#[derive(Debug)]
pub struct PpoDrive<A> {
    station: dp::Station<A>,
    table: Table,
    drive: Drive,
    engine: Engine,
    cycles: Cycles,
    /// The command in force, and its control word.
    command: (Command, Stw),
    /// The outputs the drive was woken for, as counted by the slave.
    outputs_seen: u32,
    exchanging: bool,
    /// Of each word of process data from the third on: the parameter that refused it last, told once.
    refused: [Option<u16>; MORE_WORDS],
    /// The words of the parameter channel: what the master sent last, and the answer.
    channel: (Pkw, Pkw),
    memory: Option<Memory>,
}

impl<A: Application> PpoDrive<A> {
    /// A drive that is switched on at `now`.
    ///
    /// # Errors
    /// The parameter whose default the drive does not take.
    pub fn new(
        address: Address,
        baud: BaudRate,
        (description, application): (Description, A),
        table: Table,
        now: Instant,
    ) -> Result<Self, Row> {
        let mut drive = Drive::new(Settings::DEFAULT);
        table.set_up(&mut drive).map_err(Row::clone)?;
        // It is set up, nothing has changed.
        while drive.poll_event().is_some() {}
        let engine = Engine::new(Family::Profile.channel());
        Ok(Self {
            station: dp::Station::new(address, baud, None, description, application),
            table,
            drive,
            engine,
            cycles: Cycles::new(ApplicationCycle::DEFAULT, now),
            command: Default::default(),
            outputs_seen: 0,
            exchanging: false,
            refused: [None; MORE_WORDS],
            channel: (Pkw::ZERO, Pkw::ZERO),
            memory: None,
        })
    }

    /// The same drive, its parameters numbered on the bus as in this family.
    #[must_use]
    pub fn of_family(mut self, family: Family) -> Self {
        self.engine = Engine::new(family.channel());
        self
    }

    /// Its slave.
    pub const fn slave(&self) -> &dp::Slave<A> {
        self.station.slave()
    }

    /// The drive behind the bus.
    pub const fn drive(&self) -> &Drive {
        &self.drive
    }

    /// Its parameters.
    pub const fn table(&self) -> &Table {
        &self.table
    }

    /// The status word as it is offered to the master.
    pub fn zsw(&self) -> Zsw {
        profile::zsw(&self.drive.status())
    }

    /// The control word that was seen last; 0 without Data_Exchange.
    pub(crate) const fn stw(&self) -> Stw {
        self.command.1
    }

    /// What is commanded now: with bit 10 = 0 what was commanded before.
    pub(crate) const fn command(&self) -> &Command {
        &self.command.0
    }

    /// The words of the parameter channel: what the master sent last, and what the drive answers. Zero without one.
    pub(crate) const fn channel(&self) -> (Pkw, Pkw) {
        self.channel
    }

    /// A parameter as the channel would answer it: of an array the element from 1.
    ///
    /// # Errors
    /// [`JobError`]: no such parameter or element.
    pub fn read_parameter(&self, pnu: u16, element: Option<u8>) -> Result<Value, JobError> {
        View { table: &self.table, drive: &self.drive, known: self.known(self.ppo()) }.read(pnu, element)
    }

    /// Writes a parameter without the channel, by the same rules: no master sees it.
    ///
    /// # Errors
    /// [`JobError`]; nothing is changed then.
    pub fn write_parameter(
        &mut self,
        now: Instant,
        pnu: u16,
        element: Option<u8>,
        value: Value,
    ) -> Result<(), JobError> {
        let known = self.known(self.ppo());
        let held = self.memory.as_mut().and_then(Memory::held);
        let Self { table, drive, memory, .. } = self;
        let mut access = Access { table, drive, known, memory: memory.as_mut() };
        let written = pkw::Parameters::write(&mut access, pnu, element, value);
        if let Some(memory) = &mut self.memory {
            memory.hold(held.filter(|held| written.is_err() || held.at != (pnu, element)));
        }
        written?;
        self.cycles.wake(now);
        Ok(())
    }

    /// A fault with this number comes, from 1: the motor is released. 0 raises none.
    pub fn raise_fault(&mut self, now: Instant, number: u16) {
        if number != 0 {
            self.drive.raise(Fault::Raised(number));
            self.cycles.wake(now);
        }
    }

    /// A warning with this number stands from now on; 0 ends it.
    pub fn raise_warning(&mut self, now: Instant, number: u16) {
        // Every number of 16 bits is one.
        let _set: Result<(), SetError> = self.drive.set_quantity(Quantity::Warning, number.into());
        self.cycles.wake(now);
    }

    /// The machine takes this torque, in % of the rated torque, 0 and more.
    ///
    /// # Errors
    /// [`SetError::Value`] below 0 and for what is no number; nothing is changed then.
    pub fn set_load(&mut self, now: Instant, percent: f64) -> Result<(), SetError> {
        self.drive.set_quantity(Quantity::Load, percent)?;
        self.cycles.wake(now);
        Ok(())
    }

    /// The type of PPO in use; `None`: no configuration is accepted, or it has other octets.
    pub fn ppo(&self) -> Option<PpoType> {
        self.slave().accepted_configuration().and_then(ppo_of)
    }

    fn wake(&mut self, now: Instant) {
        let passed = self.slave().output_updates();
        let exchanging = self.slave().state() == dp::State::DataExch;
        if passed != self.outputs_seen || exchanging != self.exchanging {
            self.outputs_seen = passed;
            self.cycles.wake(now);
        }
    }

    /// Lets everything happen that is due until `now`: the watchdog and application cycles.
    fn advance(&mut self, now: Instant, news: &mut dyn FnMut(StationEvent)) {
        self.cycles.forfeit(now);
        loop {
            let cycle = self.cycles.next();
            let watchdog = self.station.watchdog_timeout();
            let Some(due) = Instant::first_of(watchdog, cycle).filter(|due| *due <= now) else { return };
            if watchdog == Some(due) {
                if let Some(event) = self.station.handle_timeout(due) {
                    news(StationEvent::Dp(event));
                }
                self.wake(due);
            } else {
                let at_rest = self.run_cycle(news);
                self.cycles.ran(due, at_rest);
            }
        }
    }

    /// One application cycle: newest outputs in, one step, new inputs out. Says whether another one under the same
    /// outputs would change nothing.
    fn run_cycle(&mut self, news: &mut dyn FnMut(StationEvent)) -> bool {
        self.exchanging = self.slave().state() == dp::State::DataExch;
        let ppo = self.ppo().filter(|_| self.exchanging);
        let outputs: Vec<u8> = ppo.map(|_| self.slave().outputs().to_vec()).unwrap_or_default();
        let pkw_len = if ppo.is_some_and(PpoType::has_pkw) { PKW_LEN } else { 0 };
        let (job, pzd) = outputs.split_at_checked(pkw_len).unwrap_or_default();
        let words: Vec<u16> = pzd.as_chunks().0.iter().map(|word| u16::from_be_bytes(*word)).collect();
        let settled = self.follow(ppo, &words, news);
        let job = job.first_chunk().map(|job| Pkw::from_octets(*job));
        let reply = self.run_job(ppo, job, news);
        self.channel = (job.unwrap_or(Pkw::ZERO), reply.unwrap_or(Pkw::ZERO));
        let mut inputs = Vec::from(reply.map(Pkw::to_octets).as_ref().map_or(&[][..], |octets| octets));
        for word in self.shown_words(ppo) {
            inputs.extend(word.to_be_bytes());
        }
        self.station.set_inputs(&inputs);
        while let Some(event) = self.drive.poll_event() {
            news(StationEvent::Device(Event::Drive(event)).of_any());
        }
        settled && self.drive.is_at_rest() && !job.is_some_and(|job| self.engine.has_work(job))
    }

    /// One step under these process data. Says whether they ask nothing new.
    fn follow(&mut self, ppo: Option<PpoType>, words: &[u16], news: &mut dyn FnMut(StationEvent)) -> bool {
        let before = self.command;
        match words {
            [stw, setpoint, more @ ..] => {
                let stw = Stw::from_raw(*stw);
                self.command.1 = stw;
                match profile::command(stw, setpoint.cast_signed()) {
                    Some(command) => self.command.0 = command,
                    // What was commanded holds. An edge in a word that is not looked at is none.
                    None => self.command.0.acknowledge = false,
                }
                if profile::StwBit::ByPlc.is_set(stw) {
                    self.set_more(ppo, more, news);
                }
                self.drive.step(self.cycles.step(), Some(&self.command.0));
                if let Some(word) = profile::NotFollowed::of(before.1, stw, self.zsw()) {
                    news(StationEvent::Device(Event::NotFollowed(word)).of_any());
                }
            }
            [_] | [] => {
                self.command = Default::default();
                self.drive.step(self.cycles.step(), None);
            }
        }
        self.command == before
    }

    /// Sets the parameters that PNU 915 ties to the words of process data from the third on. What a parameter refuses is
    /// not set: its value stays, which is told once until it takes one again.
    fn set_more(&mut self, ppo: Option<PpoType>, words: &[u16], news: &mut dyn FnMut(StationEvent)) {
        let assigned = self.assigned(Channel::PzdSetpoint);
        let before = core::mem::replace(&mut self.refused, [None; MORE_WORDS]);
        let mut words = words.iter().zip(assigned).enumerate().take(MORE_WORDS).peekable();
        while let Some((place, (word, (pnu, element)))) = words.next() {
            // Two words in a row that name the same parameter of two words are its high and its low word.
            let is_double = self.table.row(pnu).is_some_and(|row| row.kind.is_double());
            let low = words.next_if(|(_, (_, (next, _)))| is_double && *next == pnu);
            let value = match low {
                Some((_, (low, _))) => Value::Double(u32::from(*word) << 16 | u32::from(*low)),
                None => Value::Word(*word),
            };
            let mut access = self.access(ppo);
            // A write with the value it has would be one more.
            if pnu == 0 || pkw::Parameters::read(&access, pnu, element) == Ok(value) {
                continue;
            }
            if let Err(cause) = pkw::Parameters::write(&mut access, pnu, element, value) {
                let same = |refused: &[Option<u16>]| refused.get(place).copied().flatten() == Some(pnu);
                if !same(&before) {
                    news(StationEvent::Device(Event::NotSet { place, pnu, value: *word, cause }).of_any());
                }
                self.refused.iter_mut().skip(place).take(1).for_each(|refused| *refused = Some(pnu));
            }
        }
    }

    /// The words of process data: ZSW, the actual value, and what PNU 916 ties to those behind.
    fn shown_words(&self, ppo: Option<PpoType>) -> Vec<u16> {
        let Some(kind) = ppo else { return Vec::new() };
        let mut words = Vec::from([self.zsw().raw(), self.drive.status().actual.cast_unsigned()]);
        let assigned = self.assigned(Channel::PzdActual);
        let view = View { table: &self.table, drive: &self.drive, known: self.known(ppo) };
        // A parameter of two words has its high word in the first place that names it, its low word in the next.
        let mut low_of = None;
        for (pnu, element) in assigned.into_iter().take(kind.pzd_words().saturating_sub(2)) {
            let word = match view.read(pnu, element) {
                Ok(Value::Word(word)) => word,
                Ok(Value::Double(double)) => {
                    let [a, b, c, d] = double.to_be_bytes();
                    let is_low = low_of.take() == Some(pnu);
                    low_of = (!is_low).then_some(pnu);
                    u16::from_be_bytes(if is_low { [c, d] } else { [a, b] })
                }
                Err(_) => 0,
            };
            words.push(word);
        }
        words.resize(kind.pzd_words(), 0);
        words
    }

    /// The parameters that an assignment names, of arrays their first element; 0: none.
    fn assigned(&self, channel: Channel) -> Vec<(u16, Option<u8>)> {
        let Some(row) = self.table.tied(Tie::Channel(channel)) else { return Vec::new() };
        let places = 0..usize::from(row.elements.unwrap_or(1));
        let pnu =
            |place| self.table.kept(row.pnu, place).and_then(|bits| u16::try_from(bits).ok()).unwrap_or(0);
        let element = |pnu| self.table.row(pnu).and_then(|row| row.elements).map(|_| 1);
        places.map(pnu).map(|pnu| (pnu, element(pnu))).collect()
    }

    fn known(&self, ppo: Option<PpoType>) -> Known {
        Known { address: self.station.address(), ppo, stw: self.command.1, zsw: self.zsw() }
    }

    fn access(&mut self, ppo: Option<PpoType>) -> Access<'_> {
        let known = self.known(ppo);
        Access { table: &mut self.table, drive: &mut self.drive, known, memory: None }
    }

    /// Runs the parameter channel; `None` without one.
    fn run_job(
        &mut self,
        ppo: Option<PpoType>,
        job: Option<Pkw>,
        news: &mut dyn FnMut(StationEvent),
    ) -> Option<Pkw> {
        let Some(job) = job else {
            self.engine.reset();
            return None;
        };
        let known = self.known(ppo);
        let Self { table, drive, engine, memory, .. } = self;
        let mut access = Access { table, drive, known, memory: memory.as_mut() };
        let outcome = engine.cycle(job, &mut access);
        if let Some(refusal) = outcome.refusal {
            news(StationEvent::Device(Event::JobRefused(refusal)).of_any());
        }
        Some(outcome.reply)
    }
}

/// The type of PPO that a configuration has.
pub(crate) fn ppo_of(configuration: &[u8]) -> Option<PpoType> {
    Shape::of(configuration).ppo()
}

/// What decides which PPO a configuration is: its octets in each direction, and whether they begin with those of the parameter
/// channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Shape {
    inputs: usize,
    outputs: usize,
    /// `None`: it has no octets.
    begins_with_pkw: Option<bool>,
}

impl Shape {
    /// That of a configuration, or of a part of one.
    pub(crate) fn of(configuration: &[u8]) -> Self {
        let read = identifiers(configuration).filter_map(|octets| Identifier::read(octets).ok());
        read.fold(Self::default(), |whole, (identifier, _)| {
            let octets = |units: Option<Units>| units.map_or(0, Units::octets);
            let (inputs, outputs) = (octets(identifier.inputs), octets(identifier.outputs));
            let begins_with_pkw =
                ((inputs, outputs) != (0, 0)).then_some((inputs, outputs) == (PKW_LEN, PKW_LEN));
            whole.and(Self { inputs, outputs, begins_with_pkw })
        })
    }

    /// With another part behind it.
    pub(crate) fn and(self, behind: Self) -> Self {
        Self {
            inputs: self.inputs + behind.inputs,
            outputs: self.outputs + behind.outputs,
            begins_with_pkw: self.begins_with_pkw.or(behind.begins_with_pkw),
        }
    }

    /// Whether the longest PPO has room for it.
    pub(crate) fn fits(self) -> bool {
        self.inputs.max(self.outputs) <= PpoType::Ppo5.len()
    }

    /// The PPO that it is.
    pub(crate) fn ppo(self) -> Option<PpoType> {
        PpoType::ALL.into_iter().find(|kind| {
            *kind != PpoType::SevenWords
                && (self.inputs, self.outputs) == (kind.len(), kind.len())
                && Some(kind.has_pkw()) == self.begins_with_pkw
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_configuration_tells_its_ppo() {
        for (kind, identifiers) in PpoType::ALL.into_iter().zip(CONFIGURATIONS) {
            assert_eq!(ppo_of(identifiers), Some(kind));
        }
        // As GSDs write it: special identifiers, empty slots, the process data word by word.
        assert_eq!(ppo_of(&[0xC0, 0xC3, 0xC3, 0xC0, 0xC1, 0xC1]), Some(PpoType::Ppo1));
        assert_eq!(ppo_of(&[0x00, 0xF3, 0x70, 0x70]), Some(PpoType::Ppo1));
        assert_eq!(ppo_of(&[0x75]), Some(PpoType::Ppo4));
        for other in [&[][..], &[0x00], &[0xF2], &[0xF3, 0xF2], &[0xC0]] {
            assert_eq!(ppo_of(other), None, "{other:02X?}");
        }
    }
}
