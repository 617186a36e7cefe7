//! The unit as the node sees it: the control word asks, the unit steps, the status word and emergencies tell
//! (`canopen-ag03.md` 9, 10, 18).
//!
//! A control word is evaluated when it comes, by a step of the unit without length; time passes in application cycles.

use core::convert::Infallible;
use core::time::Duration;

use heapless::Deque;

use super::config::Config;
use super::errors;
use super::event::Event;
use super::objects::MAX_TARGET;
use super::quirks::Quirks;
use super::state::{self, State};
use super::words::{ControlWord, CwBit, is_active, status_word};
use crate::can_bus::can::ErrorState;
use crate::can_bus::canopen::emcy::COMMUNICATION;
use crate::can_bus::canopen::{Emergency, NmtState, NodeId, Notice, Request, Reset};
use crate::can_bus::cia402::Controlword;
use crate::devices::ag03::drive;
use crate::devices::ag03::drive::{Command, Direction, Fault, FaultSet, Inching, Mode, Operation};
use crate::devices::ag03::profibus::words;
use crate::devices::ag03::profibus::words::Words;
use crate::devices::ag03::unit::{Queue, Unit};
use crate::devices::servo::news::{News, Targets};

/// The bit rates of 2100h in bits per second, by code.
pub(super) const RATES: [u32; 12] =
    [15_625, 20_000, 25_000, 40_000, 50_000, 62_500, 100_000, 125_000, 200_000, 250_000, 500_000, 1_000_000];
/// The code of a drive from the factory.
const DEFAULT_RATE: u8 = 10;

/// What a control word asks for just now, besides its levels.
#[derive(Clone, Copy, Debug, Default)]
struct Edges {
    enable: bool,
    travel: bool,
    acknowledge: bool,
}

/// The unit with what CANopen adds to it.
#[derive(Clone, Debug)]
pub(super) struct Part {
    pub(super) unit: Unit,
    pub(super) quirks: Quirks,
    pub(super) node_id: NodeId,
    /// `None` while it is switched off.
    pub(super) nmt: Option<NmtState>,
    pub(super) state: State,
    /// 6040h.
    pub(super) word: ControlWord,
    /// A control word of an RPDO whose other entries may still come.
    pub(super) received: Option<ControlWord>,
    /// 607Ah.
    pub(super) target: i32,
    /// 60FFh.
    pub(super) velocity: i32,
    /// Velocity mode: a falling edge of CW.8 released the target.
    released: bool,
    inch_1: bool,
    inch_2: Option<Direction>,
    /// 6041h bit 12 in positioning mode.
    acknowledge: bool,
    mode: Mode,
    /// Jobs and faults as they were counted last.
    jobs: u8,
    pub(super) faults: u16,
    /// The bits of 1001h of the latched faults.
    register: u8,
    error_state: ErrorState,
    /// Error passive was reported by 8120h.
    passive_told: bool,
    /// 2100h, and as it was at the last initialisation.
    pub(super) rate: u8,
    rate_in_force: u8,
    /// 2100h before the write that waits for the EEPROM.
    pub(super) rate_before: Option<u8>,
    ssw: Words,
    requests: Deque<Request, 24>,
    events: Queue<Event, 16>,
    targets: Targets,
    changed: bool,
}

impl Part {
    pub(super) fn new(config: &Config, unit: Unit) -> Self {
        let ssw = Words::new(words::WordQuirks { paused_is_active: true, ..words::WordQuirks::default() });
        Self {
            quirks: config.quirks,
            node_id: unit.switches().node_id(),
            nmt: None,
            state: State::SwitchOnDisabled,
            word: ControlWord::default(),
            received: None,
            target: 0,
            velocity: 0,
            released: false,
            inch_1: false,
            inch_2: None,
            acknowledge: false,
            mode: unit.status().mode,
            jobs: unit.status().jobs,
            faults: unit.drive().faults().count(),
            register: 0,
            error_state: ErrorState::Active,
            passive_told: false,
            rate: DEFAULT_RATE,
            rate_in_force: DEFAULT_RATE,
            rate_before: None,
            ssw,
            requests: Deque::new(),
            events: Queue::default(),
            targets: Targets::default(),
            changed: true,
            unit,
        }
    }

    pub(super) fn bits_per_second(&self) -> u32 {
        RATES.get(usize::from(self.rate_in_force)).copied().unwrap_or_default()
    }

    pub(super) fn set_rate(&mut self, bits_per_second: u32) {
        let code = (0..).zip(RATES).find(|(_, rate)| *rate == bits_per_second);
        if let Some((code, _)) = code {
            (self.rate, self.rate_in_force) = (code, code);
        }
    }

    pub(super) fn rate_is_safe(&mut self) {
        self.rate_before = None;
    }

    pub(super) fn status_word(&self) -> u16 {
        let remote = matches!(self.nmt, Some(NmtState::Operational | NmtState::Stopped));
        status_word(self.state, self.unit.status(), remote, self.acknowledge)
    }

    /// 1002h.
    pub(super) fn system_status(&self) -> u16 {
        self.ssw.system_status(self.unit.status())
    }

    pub(super) const fn take_changed(&mut self) -> bool {
        core::mem::replace(&mut self.changed, false)
    }

    pub(super) const fn is_bus_off(&self) -> bool {
        matches!(self.error_state, ErrorState::BusOff)
    }

    pub(super) fn poll_event(&mut self) -> Option<Event> {
        self.events.pop().map(|event| event.unwrap_or_else(|events| Event::Lost { events }))
    }

    /// Emergencies wait until the bus works.
    pub(super) fn next_request(&mut self) -> Option<Request> {
        if self.is_bus_off() { None } else { self.requests.pop_front() }
    }

    pub(super) fn switched_off(&mut self) {
        self.nmt = None;
        self.begin_anew();
        // It steps no more that would tell them.
        self.take_events();
    }

    pub(super) fn switched_on(&mut self) {
        // SW1 to SW7 of a factory reset say which parameters, not which number.
        if self.unit.is_working() {
            self.node_id = self.unit.switches().node_id();
        }
        self.begin_anew();
    }

    /// As after power-on.
    fn begin_anew(&mut self) {
        self.state = State::SwitchOnDisabled;
        (self.word, self.received) = (ControlWord::default(), None);
        (self.target, self.velocity) = (0, 0);
        (self.released, self.inch_1, self.inch_2) = (false, false, None);
        self.acknowledge = false;
        self.mode = self.unit.status().mode;
        self.jobs = self.unit.status().jobs;
        self.faults = self.unit.drive().faults().count();
        (self.register, self.passive_told) = (0, false);
        self.rate_in_force = self.rate;
        self.requests.clear();
        self.want(Request::ErrorRegister(0));
        self.changed = true;
    }

    /// Whether the bus was off before.
    pub(super) fn set_error_state(&mut self, state: ErrorState) -> bool {
        let before = core::mem::replace(&mut self.error_state, state);
        if before == state {
            return false;
        }
        let causes = match state {
            ErrorState::Active => FaultSet::empty(),
            ErrorState::Passive if is_active(self.unit.status()) => Fault::H.into(),
            ErrorState::Passive => FaultSet::empty(),
            ErrorState::BusOff => Fault::I.into(),
        };
        self.unit.set_bus_causes(causes);
        let tell_passive = state == ErrorState::Passive && causes.is_empty();
        let was_told = core::mem::replace(&mut self.passive_told, tell_passive);
        self.evaluate();
        if tell_passive {
            self.emergency(errors::ERROR_PASSIVE);
        } else if before == ErrorState::BusOff {
            self.emergency(errors::BUS_OFF_RECOVERED);
        } else if was_told && self.state != State::Fault {
            self.want(Request::Emergency(Emergency::gone(0)));
        }
        before == ErrorState::BusOff
    }

    /// Time passes.
    pub(super) fn run(&mut self, dt: Duration) {
        self.step(dt, Edges::default());
    }

    /// Lets the drive notice what changed.
    pub(super) fn evaluate(&mut self) {
        self.step(Duration::ZERO, Edges::default());
        self.changed = true;
    }

    /// A control word came in OPERATIONAL.
    pub(super) fn on_word(&mut self, word: ControlWord) {
        let before = core::mem::replace(&mut self.word, word);
        let was = self.state;
        self.follow(word, before, was);
        let states = (was.of_profile(), self.state.of_profile());
        let words = (Controlword(word.0), Controlword(before.0));
        if News::<Infallible>::of_command(words, states, true).is_some() {
            self.events.push(Event::NoEffect { word: word.0, state: self.state });
        }
    }

    fn follow(&mut self, word: ControlWord, before: ControlWord, was: State) {
        if was == State::Fault {
            let acknowledge = word.rises(before, CwBit::FaultReset);
            self.step(Duration::ZERO, Edges { acknowledge, ..Edges::default() });
            // The drive's own turn-on disabled ends.
            return self.evaluate();
        }
        self.enter(was.after(state::Request::of(word)));
        let stays = was == State::OperationEnabled && self.state == was;
        if stays {
            // One that ran to its end (CN-50): the drive sees that it is over before it is asked again.
            if word.rises(before, CwBit::Inching1) {
                self.step(Duration::ZERO, Edges::default());
            }
            self.on_travel_bits(before);
        }
        self.released &= !word.has(CwBit::Stop);
        let enable = !stays && self.state == State::OperationEnabled;
        let travel = stays && self.mode == Mode::Positioning && word.rises(before, CwBit::NewSetpoint);
        let in_range = (-MAX_TARGET..=MAX_TARGET).contains(&self.target);
        if travel {
            self.targets.take(self.target.into());
        }
        if travel && !in_range {
            self.events.push(Event::TargetRefused { got: self.target });
        }
        self.step(Duration::ZERO, Edges { enable, travel: travel && in_range, acknowledge: false });
        self.changed = true;
    }

    /// A control word was taken: whether it misses a target. `at_once`: it came alone, by SDO.
    pub(super) fn look_at_target(&mut self, at_once: bool) {
        let (word, target) = (self.word, self.target);
        if self.state == State::OperationEnabled
            && self.mode == Mode::Positioning
            && self.targets.kept::<Infallible>(Controlword(word.0), target.into(), at_once).is_some()
        {
            self.events.push(Event::TargetNotTaken { word: word.0, target });
        }
    }

    /// Bits 8 and 13 to 15 in OPERATION ENABLED.
    fn on_travel_bits(&mut self, before: ControlWord) {
        let word = self.word;
        self.released |= self.mode == Mode::Velocity && word.falls(before, CwBit::Stop);
        let goes_on = self.quirks.inching_1_runs_to_its_end
            && self.unit.status().state == drive::State::Inching(Inching::One);
        self.inch_1 =
            word.rises(before, CwBit::Inching1) || self.inch_1 && (word.has(CwBit::Inching1) || goes_on);
        self.inch_2 = word
            .inching_2()
            .filter(|(bit, direction)| word.rises(before, *bit) || self.inch_2 == Some(*direction))
            .map(|(_, direction)| direction);
    }

    pub(super) fn on_notice(&mut self, notice: Notice) {
        match notice {
            Notice::Reset(Reset::PowerOn) => self.begin_anew(),
            Notice::Reset(Reset::Node | Reset::Communication) => {
                self.unit.restart();
                self.begin_anew();
                self.evaluate();
            }
            Notice::Nmt { to, .. } => {
                self.nmt = Some(to);
                match to {
                    NmtState::PreOperational | NmtState::Stopped => self.drop_out(),
                    NmtState::Operational => self.evaluate(),
                }
            }
            Notice::RpdoTaken(_) => match self.received.take() {
                Some(word) => {
                    self.on_word(word);
                    self.look_at_target(false);
                }
                None => self.evaluate(),
            },
            Notice::LifeGuardingExpired(_) => self.drop_out(),
            Notice::NotStored => {
                self.rate = self.rate_before.take().unwrap_or(self.rate);
            }
            Notice::Sync
            | Notice::RpdoRefused { .. }
            | Notice::RpdoLength { .. }
            | Notice::LifeGuardingBack
            | Notice::HeartbeatLost(_)
            | Notice::HeartbeatBack(_)
            | Notice::SyncMissing(_)
            | Notice::HistoryCleared => {}
        }
    }

    /// To SWITCH ON DISABLED: the motor is released. A latched fault stays.
    fn drop_out(&mut self) {
        if self.state != State::Fault {
            self.enter(State::SwitchOnDisabled);
        }
        self.evaluate();
    }

    fn enter(&mut self, to: State) {
        let from = core::mem::replace(&mut self.state, to);
        if from != to {
            self.events.push(Event::State { from, to });
        }
        if to != State::OperationEnabled {
            (self.released, self.inch_1, self.inch_2) = (false, false, None);
        }
    }

    fn step(&mut self, dt: Duration, edges: Edges) {
        let command = self.command(edges);
        self.unit.step(dt, &command);
        self.observe();
    }

    /// What state and control word want of the drive.
    fn command(&self, Edges { enable, travel, acknowledge }: Edges) -> Command {
        let operation = match self.nmt {
            None | Some(NmtState::PreOperational) => return Command::UNATTENDED,
            Some(NmtState::Stopped) => Operation::Release,
            Some(NmtState::Operational) => match self.state {
                State::SwitchOnDisabled | State::ReadyToSwitchOn | State::SwitchedOn | State::Fault => {
                    Operation::Release
                }
                State::OperationEnabled => Operation::Run,
                State::QuickStopActive => Operation::BrakeAndHold,
            },
        };
        let positioning = self.mode == Mode::Positioning;
        Command {
            operation,
            enable,
            travel,
            turn: !positioning && self.released && self.velocity != 0,
            setpoint: if positioning { self.target } else { self.velocity },
            stop: false,
            pause: positioning && self.word.has(CwBit::Stop),
            inch_1: positioning && self.inch_1,
            inch_2: self.inch_2.filter(|_| positioning),
            acknowledge,
            rearm: true,
            keys: false,
        }
    }

    /// Takes note of what the step has made of the command.
    fn observe(&mut self) {
        let status = *self.unit.status();
        self.tell_faults();
        match (status.fault, self.state) {
            // 13
            (
                Some(_),
                State::SwitchOnDisabled
                | State::ReadyToSwitchOn
                | State::SwitchedOn
                | State::OperationEnabled
                | State::QuickStopActive,
            ) => self.enter(State::Fault),
            // 14
            (None, State::Fault) => {
                self.enter(State::SwitchOnDisabled);
                self.register = 0;
                self.want(Request::Emergency(Emergency::gone(self.register())));
            }
            (Some(_), State::Fault) => {}
            (None, State::OperationEnabled | State::QuickStopActive)
                if self.quirks.supply_loss_disables && !status.output_stage_ok =>
            {
                self.enter(State::SwitchOnDisabled);
            }
            (
                None,
                State::SwitchOnDisabled
                | State::ReadyToSwitchOn
                | State::SwitchedOn
                | State::OperationEnabled
                | State::QuickStopActive,
            ) => {}
        }
        if status.mode != self.mode {
            self.mode = status.mode;
            (self.released, self.inch_1, self.inch_2) = (false, false, None);
        }
        let accepted = core::mem::replace(&mut self.jobs, status.jobs) != status.jobs;
        let ended = !self.word.has(CwBit::NewSetpoint) && !is_active(&status);
        self.acknowledge = (self.acknowledge || accepted) && !ended;
        self.inch_1 &= self.word.has(CwBit::Inching1) || status.state == drive::State::Inching(Inching::One);
        self.take_events();
    }

    fn take_events(&mut self) {
        while let Some(event) = self.unit.poll_event() {
            self.events.push(Event::Unit(event));
        }
    }

    /// One EMCY for each fault that was entered, in the order of detection.
    fn tell_faults(&mut self) {
        let buffer = self.unit.drive().faults();
        let (codes, count) = (buffer.codes(), buffer.count());
        let before = core::mem::replace(&mut self.faults, count);
        let new = usize::from(count.saturating_sub(before)).min(codes.len());
        let newest = codes.get(..new).unwrap_or_default();
        for fault in newest.iter().rev().filter_map(|code| Fault::of_code(*code)) {
            self.register |= errors::register(fault);
            self.emergency(errors::code(fault));
        }
    }

    fn emergency(&mut self, code: u16) {
        let emergency = Emergency { in_history: false, ..Emergency::new(code, self.register()) };
        self.want(Request::Emergency(emergency));
    }

    const fn register(&self) -> u8 {
        self.register | if self.passive_told { COMMUNICATION } else { 0 }
    }

    pub(super) fn want(&mut self, request: Request) {
        // More than this many emergencies in one step do not happen; 1003h has them all the same.
        let _ = self.requests.push_back(request);
    }
}
