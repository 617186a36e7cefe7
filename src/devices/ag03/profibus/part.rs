//! The two machines of a device behind its framer: the DP part, which answers each telegram at once, and the drive part,
//! which runs once per application cycle.

use super::hint::Hint;
use super::hint::watch::Watch;
use super::parameters::{Channel, Shown};
use super::words::{self, Words};
use super::{Config, Event, MAX_EVENTS};
use crate::devices::StationEvent;
use crate::devices::ag03::param::Parameter;
use crate::devices::ag03::unit;
use crate::devices::ag03::unit::{Cycles, Power, Queue, Unit};
use crate::profibus::dp;
use crate::profibus::fdl::{FrameError, Telegram};
use crate::profibus::pkw::Engine;
use crate::profibus::ppo;
use crate::profibus::ppo::{Outputs, PPO_LEN, Pkw, Zsw};
use crate::time::Instant;

/// Everything behind the framer.
#[derive(Clone, Debug)]
pub(super) struct Parts {
    pub(super) config: Config,
    pub(super) unit: Unit,
    pub(super) shown: Shown,
    pub(super) station: dp::Station,
    pub(super) engine: Engine,
    pub(super) cycles: Cycles,
    /// The outputs the drive part was woken for, as counted by the slave.
    outputs_seen: u32,
    /// The last application cycle ran in Data_Exchange.
    exchanging: bool,
    /// Data_Exchange was left since the last application cycle.
    interrupted: bool,
    /// The outputs of the last application cycle, if they ask nothing new in the next: no edge in the command, the job
    /// answered.
    held: Option<[u8; PPO_LEN]>,
    /// The reply of the parameter channel offered to the master.
    pkw_reply: Pkw,
    /// The status word offered to the master under the same outputs as now, and what [`Unit::changes`] counted then.
    zsw: Option<(u32, Zsw)>,
    watch: Watch,
    /// Something has come of the octets taken last.
    pub(super) news: bool,
    pub(super) events: Queue<StationEvent<Event>, MAX_EVENTS>,
}

impl Parts {
    // Not inlined: made where it will lie, see `dp::Slave::under`.
    #[inline(never)]
    pub(super) fn new(config: Config, unit: Unit, now: Instant) -> Self {
        Self {
            config,
            unit,
            shown: Shown { address: config.switches.address(), words: Words::new(config.words) },
            station: config.station(),
            engine: Engine::new(config.pkw),
            cycles: Cycles::new(config.application_cycle, now),
            outputs_seen: 0,
            exchanging: false,
            interrupted: false,
            held: None,
            pkw_reply: Pkw::ZERO,
            zsw: None,
            watch: Watch::default(),
            news: false,
            events: Queue::default(),
        }
    }

    pub(super) fn start(&mut self, now: Instant) {
        self.watch.now = now;
        self.look_at_address();
        self.run_cycle();
    }

    /// The unit was switched on or off: a new station that has heard nothing yet.
    pub(super) fn restart(&mut self) {
        // SW1 to SW7 of a factory reset say which parameters, not which address (`ag03.md` 11).
        if self.unit.power() == Power::On {
            self.shown.address = self.config.switches.address();
        }
        self.shown.words = Words::new(self.config.words);
        self.station = self.config.station();
        self.outputs_seen = self.station.slave().output_updates();
        (self.exchanging, self.interrupted) = (false, false);
        self.engine.reset();
        (self.held, self.zsw) = (None, None);
        self.pkw_reply = Pkw::ZERO;
        self.publish();
        self.look_at_address();
    }

    /// At the address of stations that have none there is no Data_Exchange.
    fn look_at_address(&mut self) {
        if self.shown.address == dp::StoredAddress::DELIVERED.address && self.unit.power() == Power::On {
            let hint = self.watch.allow(Hint::AddressNotSet);
            self.hint(hint);
        }
    }

    fn hint(&mut self, hint: Option<Hint>) {
        if let Some(hint) = hint {
            self.events.push(StationEvent::Device(Event::Hint(hint)));
        }
    }

    /// Lets everything happen that is due until `now`: application cycles and the watchdog, in the order of time.
    #[inline(always)]
    pub(super) fn advance(&mut self, now: Instant) {
        self.watch.now = now;
        if let Some(due) = self.first_due(now) {
            self.catch_up(now, due);
        }
    }

    /// As [`Parts::advance`], when something is due, the first of it at `due`. The watchdog comes before a cycle of the
    /// same moment.
    #[inline(never)]
    fn catch_up(&mut self, now: Instant, due: Instant) {
        self.news = true;
        let mut next = if self.cycles.forfeit(now) { self.first_due(now) } else { Some(due) };
        while let Some(due) = next {
            if self.station.watchdog_timeout() == Some(due) {
                self.expire_watchdog(due);
            } else {
                self.run_cycle();
                self.cycles.ran(due, self.is_at_rest());
            }
            next = self.first_due(now);
        }
    }

    /// When what comes next was due, if that is not behind `now`.
    #[inline(always)]
    fn first_due(&self, now: Instant) -> Option<Instant> {
        Instant::first_of(self.station.watchdog_timeout(), self.cycles.next()).filter(|due| *due <= now)
    }

    fn expire_watchdog(&mut self, due: Instant) {
        if let Some(event) = self.station.handle_timeout(due) {
            if let dp::Event::WatchdogExpired { master, after } = event {
                self.watch.expired(due, master, after);
            }
            self.events.push(StationEvent::Dp(event));
        }
        self.wake_for_outputs(due);
    }

    /// A telegram or a refusal from the line.
    pub(super) fn hear(&mut self, now: Instant, result: Result<Telegram<'_>, FrameError>) {
        self.news = true;
        let telegram = match result {
            Ok(telegram) => telegram,
            Err(error) => return self.events.push(StationEvent::TelegramRefused(error)),
        };
        let outcome = self.station.handle_telegram(now, &telegram);
        if let Some(event) = outcome.event {
            self.events.push(StationEvent::Dp(event));
        }
        self.wake_for_outputs(now);
        if !outcome.exchanged {
            if self.watch.awaits_master() {
                self.look_at_request(&telegram);
            }
            return;
        }
        if self.cycles.is_manual() {
            self.run_cycle();
        }
    }

    /// A request for us after a watchdog expired: its master is not gone.
    #[inline(never)]
    fn look_at_request(&mut self, telegram: &Telegram<'_>) {
        match telegram {
            Telegram::Data(request) if request.da == self.shown.address => {
                let hint = self.watch.asked(request.sa);
                self.hint(hint);
            }
            Telegram::Data(_) | Telegram::Token { .. } | Telegram::ShortAcknowledge => {}
        }
    }

    /// Wakes the drive part if outputs were passed that it has not seen. Returns whether there were any.
    #[inline]
    fn wake_for_outputs(&mut self, now: Instant) -> bool {
        let passed = self.station.slave().output_updates();
        if self.outputs_seen == passed {
            return false;
        }
        self.outputs_seen = passed;
        if self.station.slave().state() != dp::State::DataExch && self.exchanging {
            self.exchanging = false;
            self.interrupted = true;
            if self.cycles.is_manual() {
                self.run_cycle();
            }
        }
        self.cycles.wake(now);
        true
    }

    /// One application cycle: newest outputs in, one step, new inputs out.
    fn run_cycle(&mut self) {
        // A break in Data_Exchange is seen for one cycle even if it was shorter.
        self.exchanging = self.station.slave().state() == dp::State::DataExch && !self.interrupted;
        self.interrupted = false;
        let octets =
            self.station.slave().outputs().first_chunk::<PPO_LEN>().copied().filter(|_| self.exchanging);
        // Most cycles: a master repeats itself until the drive is there.
        if octets.is_some() && octets == self.held {
            self.unit.hold(self.cycles.step());
            self.shown.words.accept(self.unit.status());
            return self.publish();
        }
        self.pkw_reply = self.follow_outputs(octets);
        self.publish();
        self.watch.note(self.shown.words.stw());
    }

    /// What outputs ask for that are new, or ask more than the command they asked before.
    fn follow_outputs(&mut self, octets: Option<[u8; PPO_LEN]>) -> Pkw {
        let outputs = octets.as_ref().map(Outputs::new);
        let asked = outputs.map(|outputs| (outputs.stw(), outputs.hsw()));
        let held = self.shown.words.is_held(asked);
        if held {
            self.unit.hold(self.cycles.step());
        } else {
            let command = self.shown.words.command(asked);
            let hint = self.watch.commanded(self.shown.words.stw(), self.unit.status());
            self.hint(hint);
            self.unit.step(self.cycles.step(), &command);
            self.zsw = None;
        }
        self.shown.words.accept(self.unit.status());
        // Behind the step, so that a parameter that shows the drive agrees with ZSW and HIW.
        let job = outputs.map(Outputs::pkw);
        let reply = self.run_job(job);
        self.held = octets.filter(|_| held && job.is_some_and(|job| self.engine.is_settled(job)));
        reply
    }

    /// Offers new inputs to the master and what has happened in the unit to the host.
    #[inline]
    fn publish(&mut self) {
        let (status, changes) = (self.unit.status(), self.unit.changes());
        let zsw = match self.zsw {
            Some((shown, zsw)) if shown == changes => zsw,
            Some(_) | None => self.shown.words.zsw(status),
        };
        self.zsw = Some((changes, zsw));
        let inputs = ppo::Inputs::octets(self.pkw_reply, zsw, words::hiw(status));
        self.station.set_inputs(&inputs);
        self.pass_events();
    }

    /// Passes on what has happened in the unit.
    #[inline(always)]
    pub(super) fn pass_events(&mut self) {
        if let Some(event) = self.unit.poll_event() {
            self.pass_waiting(event);
        }
    }

    #[inline(never)]
    fn pass_waiting(&mut self, first: unit::Event) {
        let mut next = Some(first);
        while let Some(event) = next {
            let hint = self.hint_of(&event);
            if let Some(event) = Event::of_unit(event, &self.shown.words, self.exchanging) {
                self.events.push(StationEvent::Device(event));
            }
            self.hint(hint);
            next = self.unit.poll_event();
        }
    }

    fn hint_of(&mut self, event: &unit::Event) -> Option<Hint> {
        let unit::Event::Drive(event) = event else { return None };
        let limit = |limit| self.unit.parameters().value(limit);
        let limits = (limit(Parameter::Limit1), limit(Parameter::Limit2));
        let mode = self.unit.status().mode;
        self.watch.told(event, self.shown.words.stw(), mode, limits)
    }

    /// Runs the parameter channel; `None` outside Data_Exchange.
    fn run_job(&mut self, job: Option<Pkw>) -> Pkw {
        let Some(job) = job else {
            self.engine.reset();
            return Pkw::ZERO;
        };
        if self.watch.is_other_job(job) {
            let hint = self.watch.other_job(job, self.station.slave().output_updates());
            self.hint(hint);
        }
        let Self { unit, config, shown, engine, events, .. } = self;
        let outcome = engine.cycle(job, &mut Channel { unit, quirks: config.parameters, shown });
        if let Some(refusal) = outcome.refusal {
            events.push(StationEvent::Device(Event::JobRefused(refusal)));
        }
        outcome.reply
    }

    /// Whether another application cycle with the same outputs would change nothing.
    fn is_at_rest(&self) -> bool {
        if !self.unit.is_at_rest() {
            return false;
        }
        let job = self.station.slave().outputs().first_chunk().map(|outputs| Outputs::new(outputs).pkw());
        let job_waits = self.exchanging && job.is_some_and(|job| self.engine.has_work(job));
        let exchanging = self.station.slave().state() == dp::State::DataExch;
        !job_waits && self.exchanging == exchanging
    }
}
