//! The master's end of a drive on CANopen: its entries, its NMT state, and a travel by the state machine of CiA 402, as the
//! AG03/1 has it too.
//!
//! Control word and target go by SDO, so that each is acknowledged, is refused with its reason, and needs no mapping: a
//! travel of one command has the time. While it lasts, the client guards the node, with a life time that the node
//! supervises: a master that is gone lets the drive release its motor. What it changes for that (100Ch, 100Dh, 1017h), it
//! puts back.
//!
//! ```text
//! MoveTo:  NMT start ─▶ guarding ─▶ 6060h: 1 ─▶ 0006h ─▶ 0007h ─▶ 000Fh ─▶ 607Ah ─▶ 001Fh ─▶ bit 12 ─▶ 000Fh ─▶ bit 10
//! Stop:    0002h ─▶ standstill ─▶ 0000h
//! Leave:   0000h ─▶ 100Ch, 100Dh, 1017h as before ─▶ NMT as before
//! ```

use core::time::Duration;

use heapless::Deque;
use thiserror::Error;

use crate::can::Frame;
use crate::canopen::cob_id;
use crate::canopen::nmt::Command as Nmt;
use crate::canopen::sdo::client::{SdoClient, Step};
use crate::canopen::{Abort, Address, NmtState, NodeId};
use crate::cia402::{Controlword, State, Statusword};
use crate::time::Instant;

/// A drive on CANopen as its master sees it. After every call drain [`poll_transmit`](Self::poll_transmit), then ask
/// [`poll_outcome`](Self::poll_outcome); call [`handle_timeout`](Self::handle_timeout) when
/// [`poll_timeout`](Self::poll_timeout) has come.
#[derive(Clone, Debug)]
pub struct NodeClient {
    node: NodeId,
    limits: NodeLimits,
    sdo: SdoClient,
    task: Task,
    /// When the task must have gone on.
    due: Instant,
    /// When a status word is asked for next.
    look_at: Option<Instant>,
    nmt: Option<NmtState>,
    guard: Guard,
    status: Option<Statusword>,
    out: Deque<Frame, 8>,
    outcome: Option<NodeOutcome>,
}

/// How long what may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NodeLimits {
    /// An answer to SDO.
    pub answer: Duration,
    /// A state, an acknowledge.
    pub reaction: Duration,
    /// A travel, and running down.
    pub motion: Duration,
    /// The life time that the node supervises while the drive is enabled.
    pub life: Duration,
}

impl Default for NodeLimits {
    /// 500 ms, 2 s, 10 minutes, 1 s.
    fn default() -> Self {
        Self {
            answer: Duration::from_millis(500),
            reaction: Duration::from_secs(2),
            motion: Duration::from_secs(600),
            life: Duration::from_secs(1),
        }
    }
}

/// What is wanted of the drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NodeGoal {
    /// Its shaft at this position, standing.
    MoveTo(i32),
    /// Quick stop, standing, then without torque.
    Stop,
    /// Everything as before: no torque, no guarding, the NMT state.
    Leave,
}

/// What has come of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NodeOutcome {
    /// The value of an entry: octets, the first so many.
    Read([u8; MOST_OCTETS], usize),
    /// The entry has the value.
    Written,
    /// The goal is reached.
    Done,
    /// It cannot be done.
    Failed(NodeTrouble),
}

/// The most octets of a value that [`NodeOutcome::Read`] gives; longer ones are cut.
pub const MOST_OCTETS: usize = 64;

/// Why something cannot be done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum NodeTrouble {
    /// The node refuses an entry.
    #[error("{at} is refused: {code}")]
    Refused {
        /// Which.
        at: Address,
        /// Why.
        code: Abort,
    },
    /// No answer to SDO.
    #[error("no answer to the access to {at}: is the node there, and not in STOPPED?")]
    NoAnswer {
        /// Which entry.
        at: Address,
    },
    /// The node does not follow NMT.
    #[error("the node does not become OPERATIONAL")]
    NotOperational,
    /// The drive has a fault.
    #[error("the drive has a fault, status word {status:04X}h: clear it first")]
    Fault {
        /// 6041h.
        status: u16,
    },
    /// The drive does not go to positions.
    #[error("the drive is in mode {mode}, which is none that goes to positions: write 1 to 6060h first")]
    Mode {
        /// 6060h.
        mode: i8,
    },
    /// A state did not come.
    #[error("the drive stays in '{state}', status word {status:04X}h: is its supply there?")]
    Stays {
        /// Where it is.
        state: State,
        /// 6041h.
        status: u16,
    },
    /// The travel is not begun.
    #[error(
        "the drive does not acknowledge the target, status word {status:04X}h: it may be beyond a limit, or the drive is not ready to travel"
    )]
    NotAcknowledged {
        /// 6041h.
        status: u16,
    },
    /// The target was not reached.
    #[error("the target was not reached in time, status word {status:04X}h")]
    NotReached {
        /// 6041h.
        status: u16,
    },
    /// The drive left operation during a travel.
    #[error("the drive has left operation and is in '{state}', status word {status:04X}h")]
    Ended {
        /// Where it is.
        state: State,
        /// 6041h.
        status: u16,
    },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Task {
    Idle,
    Read(Address),
    Write(Address),
    /// The state of the node is asked for; then guarding is set up.
    Enter(i32),
    /// A step of the preparation: which entry, and what follows.
    Prepare(i32, Preparation),
    /// Up to operation enabled; whether a control word is under way.
    Enable(i32),
    Target,
    Start,
    Acknowledged,
    Release,
    Travel,
    Halt,
    Halting,
    Coast,
    Leave(Preparation),
}

/// The entries of guarding, in the order in which they are read and written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Preparation {
    ReadHeartbeat,
    ReadGuardTime,
    ReadLifeFactor,
    Heartbeat,
    GuardTime,
    LifeFactor,
    ReadMode,
    Mode,
    Word,
}

#[derive(Clone, Copy, Debug, Default)]
struct Guard {
    /// When the node is asked next; `None` while it is not guarded.
    next: Option<Instant>,
    /// 1017h, 100Ch, 100Dh as they were.
    before: Option<[u16; 3]>,
    reading: [u16; 3],
    /// The NMT state before this client started the node.
    nmt: Option<NmtState>,
}

const HEARTBEAT: Address = Address::new(0x1017, 0);
const GUARD_TIME: Address = Address::new(0x100C, 0);
const LIFE_FACTOR: Address = Address::new(0x100D, 0);
const CONTROLWORD: Address = Address::new(0x6040, 0);
const STATUSWORD: Address = Address::new(0x6041, 0);
const MODE: Address = Address::new(0x6060, 0);
const TARGET: Address = Address::new(0x607A, 0);

/// Profile position; on the AG03/1 positioning.
const POSITION_MODE: i8 = 1;
const NO_MODE: i8 = 0;
/// Bits of the control words of the flow charts.
const SHUTDOWN: u16 = 0x0006;
const SWITCH_ON: u16 = 0x0007;
const ENABLE: u16 = 0x000F;
const QUICK_STOP: u16 = 0x0002;
const START: u16 = ENABLE | Controlword::NEW_SET_POINT;
/// How long between two status words.
const LOOK: Duration = Duration::from_millis(5);
/// The life time factor: so many guard times.
const FACTOR: u8 = 2;

impl NodeClient {
    /// A client for this node, which has sent nothing yet.
    pub fn new(node: NodeId, limits: NodeLimits) -> Self {
        Self {
            node,
            limits,
            sdo: SdoClient::new(node, limits.answer),
            task: Task::Idle,
            due: Instant::ZERO,
            look_at: None,
            nmt: None,
            guard: Guard::default(),
            status: None,
            out: Deque::new(),
            outcome: None,
        }
    }

    /// The NMT state as last heard.
    pub const fn nmt(&self) -> Option<NmtState> {
        self.nmt
    }

    /// The status word as last read for a goal.
    pub const fn status(&self) -> Option<Statusword> {
        self.status
    }

    /// Reads an entry. What was under way is forgotten.
    pub fn read(&mut self, now: Instant, at: Address) {
        self.begin(now, Task::Read(at), self.limits.reaction);
        self.ask(now, at);
    }

    /// Writes an entry. What was under way is forgotten. More than 256 octets or none are refused as a length.
    pub fn write(&mut self, now: Instant, at: Address, octets: &[u8]) {
        self.begin(now, Task::Write(at), self.limits.reaction);
        self.put(now, at, octets);
    }

    /// Begins a goal. What was under way is forgotten.
    pub fn pursue(&mut self, now: Instant, goal: NodeGoal) {
        match goal {
            NodeGoal::MoveTo(target) => {
                self.begin(now, Task::Enter(target), self.limits.reaction);
                // What was heard before may be old: it is only what the node is taken back to.
                let heard = self.nmt.take();
                self.guard.nmt = self.guard.nmt.or(heard);
                self.ask_state();
                self.look_at = Some(now.saturating_add(LOOK));
            }
            NodeGoal::Stop => {
                self.begin(now, Task::Halt, self.limits.reaction);
                self.control(now, QUICK_STOP);
            }
            NodeGoal::Leave => {
                self.begin(now, Task::Leave(Preparation::Word), self.limits.reaction);
                self.control(now, 0);
            }
        }
    }

    /// A frame was received.
    pub fn handle_frame(&mut self, now: Instant, frame: &Frame) {
        if frame.id() == cob_id::of_node(cob_id::ERROR_CONTROL, self.node) && !frame.is_remote() {
            if let &[octet] = frame.octets() {
                self.nmt = match octet {
                    0 => Some(NmtState::PreOperational),
                    _ => NmtState::from_octet(octet),
                };
            }
            return;
        }
        let at = self.sdo_at();
        let mut value = [0; MOST_OCTETS];
        let answer = match self.sdo.handle_frame(now, frame) {
            Step::Wait => return,
            Step::Send(frame) => return self.send(frame),
            Step::Read(octets) => {
                for (place, octet) in value.iter_mut().zip(octets) {
                    *place = *octet;
                }
                Ok(octets.len().min(MOST_OCTETS))
            }
            Step::Written => Ok(0),
            Step::Refused(code) => Err(NodeTrouble::Refused { at, code }),
            Step::Failed { code, tell } => {
                self.send(tell);
                Err(NodeTrouble::Refused { at, code })
            }
        };
        match answer {
            Ok(len) => self.answered(now, value, len),
            Err(trouble) => self.refused(now, trouble),
        }
    }

    /// The deadline has come, or any other instant.
    pub fn handle_timeout(&mut self, now: Instant) {
        if self.guard.next.is_some_and(|next| next <= now) {
            self.ask_state();
            self.guard.next = Some(now.saturating_add(self.limits.life / 4));
        }
        let at = self.sdo_at();
        if let Step::Failed { tell, .. } = self.sdo.handle_timeout(now) {
            self.send(tell);
            self.refused(now, NodeTrouble::NoAnswer { at });
        }
        if self.look_at.is_some_and(|look| look <= now) {
            self.look_at = None;
            self.look(now);
        }
    }

    /// The next frame to send.
    #[must_use = "the frame is not offered again"]
    pub fn poll_transmit(&mut self) -> Option<Frame> {
        self.out.pop_front()
    }

    /// What has come of the request, once.
    pub const fn poll_outcome(&mut self) -> Option<NodeOutcome> {
        self.outcome.take()
    }

    /// When [`handle_timeout`](Self::handle_timeout) is to be called.
    pub fn poll_timeout(&self) -> Option<Instant> {
        let due = Instant::first_of(self.sdo.poll_timeout(), self.look_at);
        Instant::first_of(due, self.guard.next)
    }

    fn begin(&mut self, now: Instant, task: Task, limit: Duration) {
        self.outcome = None;
        self.look_at = None;
        self.go(now, task, limit);
    }

    fn go(&mut self, now: Instant, task: Task, limit: Duration) {
        self.task = task;
        self.due = now.saturating_add(limit);
    }

    fn end(&mut self, outcome: NodeOutcome) {
        self.task = Task::Idle;
        self.look_at = None;
        self.outcome = Some(outcome);
    }

    fn fail(&mut self, trouble: NodeTrouble) {
        self.end(NodeOutcome::Failed(trouble));
    }

    fn send(&mut self, frame: Frame) {
        // Drained after every call, it holds one SDO, one guarding request and one NMT command at most.
        let _ = self.out.push_back(frame);
    }

    fn ask(&mut self, now: Instant, at: Address) {
        let frame = self.sdo.read(now, at);
        self.send(frame);
    }

    fn put(&mut self, now: Instant, at: Address, octets: &[u8]) {
        match self.sdo.write(now, at, octets) {
            Some(frame) => self.send(frame),
            None => self.fail(NodeTrouble::Refused { at, code: Abort::LENGTH }),
        }
    }

    fn control(&mut self, now: Instant, word: u16) {
        self.put(now, CONTROLWORD, &word.to_le_bytes());
    }

    fn ask_state(&mut self) {
        if let Ok(frame) = Frame::remote(cob_id::of_node(cob_id::ERROR_CONTROL, self.node), 1) {
            self.send(frame);
        }
    }

    fn nmt_to(&mut self, state: NmtState) {
        self.send(Nmt::Enter(state).frame(Some(self.node)));
    }

    /// The entry that the answer waited for is about.
    const fn sdo_at(&self) -> Address {
        match self.task {
            Task::Read(at) | Task::Write(at) => at,
            Task::Prepare(_, step) | Task::Leave(step) => step.entry(),
            Task::Target => TARGET,
            Task::Start | Task::Release | Task::Halt | Task::Coast => CONTROLWORD,
            Task::Idle
            | Task::Enter(_)
            | Task::Enable(_)
            | Task::Acknowledged
            | Task::Travel
            | Task::Halting => STATUSWORD,
        }
    }

    fn refused(&mut self, now: Instant, trouble: NodeTrouble) {
        match self.task {
            // A drive that takes no control word in this state is not enabled: there is nothing to stop.
            Task::Halt if is_device_state(trouble) => self.end(NodeOutcome::Done),
            // What could not be put back does not keep from the rest.
            Task::Leave(step) => self.left(now, step),
            // A device without guarding or without the mode by this name goes without.
            Task::Prepare(target, step @ (Preparation::ReadHeartbeat | Preparation::Heartbeat)) => {
                self.prepared(now, target, step);
            }
            Task::Idle
            | Task::Read(_)
            | Task::Write(_)
            | Task::Enter(_)
            | Task::Prepare(..)
            | Task::Enable(_)
            | Task::Target
            | Task::Start
            | Task::Acknowledged
            | Task::Release
            | Task::Travel
            | Task::Halt
            | Task::Halting
            | Task::Coast => self.fail(trouble),
        }
    }

    /// An SDO answer has come.
    fn answered(&mut self, now: Instant, value: [u8; MOST_OCTETS], len: usize) {
        let [low, high, ..] = value;
        let word = u16::from_le_bytes([low, high]);
        match self.task {
            Task::Idle => {}
            Task::Read(_) => self.end(NodeOutcome::Read(value, len)),
            Task::Write(_) => self.end(NodeOutcome::Written),
            Task::Enter(_) => {}
            Task::Prepare(target, Preparation::ReadMode) => match low.cast_signed() {
                POSITION_MODE => self.prepared(now, target, Preparation::Mode),
                NO_MODE => self.prepare(now, target, Preparation::Mode),
                mode => self.fail(NodeTrouble::Mode { mode }),
            },
            Task::Prepare(target, step) => {
                if let Some(place) = step.place().and_then(|place| self.guard.reading.get_mut(place)) {
                    *place = word;
                }
                self.prepared(now, target, step);
            }
            Task::Enable(target) => self.enable(now, target, len, word),
            Task::Target => {
                self.go(now, Task::Start, self.limits.reaction);
                self.control(now, START);
            }
            Task::Start => self.watch(now, Task::Acknowledged, self.limits.reaction),
            Task::Release => self.watch(now, Task::Travel, self.limits.motion),
            Task::Halt => self.watch(now, Task::Halting, self.limits.motion),
            Task::Coast => self.end(NodeOutcome::Done),
            Task::Acknowledged | Task::Travel | Task::Halting => self.seen(now, Statusword(word)),
            Task::Leave(step) => self.left(now, step),
        }
    }

    /// Reads status words until the task has what it waits for.
    fn watch(&mut self, now: Instant, task: Task, limit: Duration) {
        self.go(now, task, limit);
        self.look_at = Some(now.saturating_add(LOOK));
    }

    /// It is time to look.
    fn look(&mut self, now: Instant) {
        match self.task {
            Task::Enter(target) => self.enter(now, target),
            Task::Enable(_) | Task::Acknowledged | Task::Travel | Task::Halting => self.ask(now, STATUSWORD),
            Task::Idle
            | Task::Read(_)
            | Task::Write(_)
            | Task::Prepare(..)
            | Task::Target
            | Task::Start
            | Task::Release
            | Task::Halt
            | Task::Coast
            | Task::Leave(_) => {}
        }
    }

    /// To OPERATIONAL: the state tells whether the node has followed.
    fn enter(&mut self, now: Instant, target: i32) {
        match self.nmt {
            Some(NmtState::Operational) => {
                self.guard.nmt.get_or_insert(NmtState::Operational);
                self.prepare(now, target, Preparation::ReadHeartbeat);
                return;
            }
            Some(other @ (NmtState::PreOperational | NmtState::Stopped)) => {
                self.guard.nmt.get_or_insert(other);
                self.nmt_to(NmtState::Operational);
            }
            // With heartbeats the request is not answered; some nodes answer neither.
            None => self.nmt_to(NmtState::Operational),
        }
        if now >= self.due {
            return self.fail(NodeTrouble::NotOperational);
        }
        self.ask_state();
        self.look_at = Some(now.saturating_add(LOOK * 4));
    }

    fn prepare(&mut self, now: Instant, target: i32, step: Preparation) {
        self.go(now, Task::Prepare(target, step), self.limits.reaction);
        let guard_time = u16::try_from(self.limits.life.as_millis() / u128::from(FACTOR)).unwrap_or(u16::MAX);
        match step {
            Preparation::ReadHeartbeat
            | Preparation::ReadGuardTime
            | Preparation::ReadLifeFactor
            | Preparation::ReadMode => {
                self.ask(now, step.entry());
            }
            Preparation::Heartbeat => self.put(now, HEARTBEAT, &[0, 0]),
            Preparation::GuardTime => self.put(now, GUARD_TIME, &guard_time.to_le_bytes()),
            Preparation::LifeFactor => self.put(now, LIFE_FACTOR, &[FACTOR]),
            Preparation::Mode => self.put(now, MODE, &POSITION_MODE.to_le_bytes()),
            Preparation::Word => {}
        }
    }

    fn prepared(&mut self, now: Instant, target: i32, step: Preparation) {
        let next = match step {
            Preparation::ReadHeartbeat => Preparation::ReadGuardTime,
            Preparation::ReadGuardTime => Preparation::ReadLifeFactor,
            Preparation::ReadLifeFactor => {
                self.guard.before.get_or_insert(self.guard.reading);
                Preparation::Heartbeat
            }
            Preparation::Heartbeat => Preparation::GuardTime,
            Preparation::GuardTime => Preparation::LifeFactor,
            Preparation::LifeFactor => {
                self.guard.next = Some(now);
                Preparation::ReadMode
            }
            Preparation::ReadMode | Preparation::Mode | Preparation::Word => {
                return self.watch(now, Task::Enable(target), self.limits.reaction);
            }
        };
        self.prepare(now, target, next);
    }

    /// One step on the way to operation enabled; an answer of no octets is that of a control word.
    fn enable(&mut self, now: Instant, target: i32, len: usize, word: u16) {
        let look = |this: &mut Self| this.look_at = Some(now.saturating_add(LOOK));
        if len == 0 {
            return look(self);
        }
        self.status = Some(Statusword(word));
        let state = State::of(Statusword(word)).unwrap_or(State::NotReadyToSwitchOn);
        let command = match state {
            State::Fault | State::FaultReactionActive => {
                return self.fail(NodeTrouble::Fault { status: word });
            }
            State::OperationEnabled => {
                self.go(now, Task::Target, self.limits.reaction);
                return self.put(now, TARGET, &target.to_le_bytes());
            }
            State::NotReadyToSwitchOn => None,
            State::SwitchOnDisabled => Some(SHUTDOWN),
            State::ReadyToSwitchOn => Some(SWITCH_ON),
            State::SwitchedOn => Some(ENABLE),
            State::QuickStopActive => Some(0),
        };
        if now >= self.due {
            return self.fail(NodeTrouble::Stays { state, status: word });
        }
        match command {
            Some(command) => self.control(now, command),
            None => look(self),
        }
    }

    /// A status word of a travel or a stop.
    fn seen(&mut self, now: Instant, status: Statusword) {
        self.status = Some(status);
        let word = status.0;
        let late = now >= self.due;
        let state = State::of(status).unwrap_or(State::NotReadyToSwitchOn);
        let enabled = state == State::OperationEnabled;
        match self.task {
            Task::Acknowledged | Task::Travel if !enabled => {
                return self.fail(match state {
                    State::Fault | State::FaultReactionActive => NodeTrouble::Fault { status: word },
                    State::NotReadyToSwitchOn
                    | State::SwitchOnDisabled
                    | State::ReadyToSwitchOn
                    | State::SwitchedOn
                    | State::OperationEnabled
                    | State::QuickStopActive => NodeTrouble::Ended { state, status: word },
                });
            }
            Task::Acknowledged if status.has(Statusword::SET_POINT_ACKNOWLEDGE) => {
                self.go(now, Task::Release, self.limits.reaction);
                return self.control(now, ENABLE);
            }
            Task::Acknowledged if late => return self.fail(NodeTrouble::NotAcknowledged { status: word }),
            Task::Travel
                if status.has(Statusword::TARGET_REACHED)
                    && !status.has(Statusword::SET_POINT_ACKNOWLEDGE) =>
            {
                return self.end(NodeOutcome::Done);
            }
            Task::Travel if late => return self.fail(NodeTrouble::NotReached { status: word }),
            // Standing or no longer in quick stop: nothing holds it there but this client.
            Task::Halting
                if state != State::QuickStopActive || status.has(Statusword::TARGET_REACHED) || late =>
            {
                self.go(now, Task::Coast, self.limits.reaction);
                return self.control(now, 0);
            }
            Task::Idle
            | Task::Read(_)
            | Task::Write(_)
            | Task::Enter(_)
            | Task::Prepare(..)
            | Task::Enable(_)
            | Task::Target
            | Task::Start
            | Task::Acknowledged
            | Task::Release
            | Task::Travel
            | Task::Halt
            | Task::Halting
            | Task::Coast
            | Task::Leave(_) => {}
        }
        self.look_at = Some(now.saturating_add(LOOK));
    }

    /// One step of leaving is done, or cannot be done.
    fn left(&mut self, now: Instant, step: Preparation) {
        let [heartbeat, guard_time, factor] = self.guard.before.unwrap_or_default();
        let next = match (step, self.guard.before) {
            (Preparation::Word, Some(_)) => Preparation::GuardTime,
            (Preparation::GuardTime, _) => Preparation::LifeFactor,
            (Preparation::LifeFactor, _) => Preparation::Heartbeat,
            (
                Preparation::ReadHeartbeat
                | Preparation::ReadGuardTime
                | Preparation::ReadLifeFactor
                | Preparation::Heartbeat
                | Preparation::ReadMode
                | Preparation::Mode
                | Preparation::Word,
                _,
            ) => {
                if let Some(state) = self.guard.nmt.filter(|state| *state != NmtState::Operational) {
                    self.nmt_to(state);
                    self.nmt = Some(state);
                }
                self.guard = Guard::default();
                return self.end(NodeOutcome::Done);
            }
        };
        self.go(now, Task::Leave(next), self.limits.reaction);
        match next {
            Preparation::GuardTime => self.put(now, GUARD_TIME, &guard_time.to_le_bytes()),
            Preparation::LifeFactor => self.put(now, LIFE_FACTOR, &factor.to_le_bytes()[..1]),
            Preparation::ReadHeartbeat
            | Preparation::ReadGuardTime
            | Preparation::ReadLifeFactor
            | Preparation::Heartbeat
            | Preparation::ReadMode
            | Preparation::Mode
            | Preparation::Word => self.put(now, HEARTBEAT, &heartbeat.to_le_bytes()),
        }
    }
}

fn is_device_state(trouble: NodeTrouble) -> bool {
    matches!(trouble, NodeTrouble::Refused { code: Abort::DEVICE_STATE, .. })
}

impl Preparation {
    const fn entry(self) -> Address {
        match self {
            Self::ReadHeartbeat | Self::Heartbeat => HEARTBEAT,
            Self::ReadGuardTime | Self::GuardTime => GUARD_TIME,
            Self::ReadLifeFactor | Self::LifeFactor => LIFE_FACTOR,
            Self::ReadMode | Self::Mode => MODE,
            Self::Word => CONTROLWORD,
        }
    }

    /// Where what is read is kept.
    const fn place(self) -> Option<usize> {
        match self {
            Self::ReadHeartbeat => Some(0),
            Self::ReadGuardTime => Some(1),
            Self::ReadLifeFactor => Some(2),
            Self::Heartbeat
            | Self::GuardTime
            | Self::LifeFactor
            | Self::ReadMode
            | Self::Mode
            | Self::Word => None,
        }
    }
}
