//! The master's end of a drive on CANopen: its entries, its NMT state, and a travel by the state machine of CiA 402, as the
//! AG03/1 has it too.
//!
//! Control word and target go by SDO, so that each is acknowledged, is refused with its reason, and needs no mapping: a
//! travel of one command has the time. While it lasts, the client guards the node, with a life time that the node
//! supervises: a master that is gone lets the drive release its motor. What it changes for that (100Ch, 100Dh, 1017h), it
//! puts back.
//!
//! ```text
//! MoveTo:       NMT start ─▶ guarding ─▶ 6060h: 1 ─▶ 0006h ─▶ 0007h ─▶ 000Fh ─▶ 607Ah ─▶ 001Fh ─▶ bit 12 ─▶ 000Fh ─▶ bit 10
//! Home:         the same with 6060h: 6, without 607Ah, up to bit 12 (attained) or bit 13 (failed)
//! Acknowledge:  NMT start ─▶ 0000h ─▶ 0080h ─▶ no fault
//! Stop:         0002h ─▶ standstill ─▶ 0000h
//! Leave:        0000h ─▶ 100Ch, 100Dh, 1017h, 6060h as before ─▶ NMT as before
//! ```
//!
//! | file | holds |
//! | --- | --- |
//! | `outcome` | what is asked, and what comes of it |
//! | `guarding` | what is set up before a travel and put back behind it |
//! | `travel` | a travel, a homing, a stop, from status word to status word |
//! | `why` | what keeps the drive from moving |

mod guarding;
mod outcome;
mod travel;
mod why;

use core::time::Duration;

use crate::can_bus::can::Frame;
use crate::can_bus::canopen::cob_id;
use crate::can_bus::canopen::nmt;
use crate::can_bus::canopen::sdo::client::{SdoClient, Step};
use crate::can_bus::canopen::{Abort, Address, NmtState, NodeId};
use crate::can_bus::cia402::{Controlword, Statusword};
use crate::time::Instant;
use heapless::Deque;

use guarding::{Guard, Preparation};
pub use outcome::{MOST_OCTETS, NodeGoal, NodeLimits, NodeOutcome, NodeTrouble};
pub use why::{NodeHindrance, NodeSigns};

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

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Task {
    Idle,
    Read(Address),
    Write(Address),
    /// The state of the node is asked for; then guarding is set up.
    Enter(Errand),
    /// A step of the preparation: which entry, and what follows.
    Prepare(Errand, Preparation),
    /// Up to operation enabled; whether a control word is under way.
    Enable(Errand),
    Target,
    Start,
    Acknowledged,
    Release,
    Travel,
    StartHoming,
    Homing,
    /// The control word before the rising edge of bit 7.
    Clear,
    Acknowledge,
    Acknowledging,
    Halt,
    Halting,
    Coast,
    Leave(Preparation),
}

/// What a drive is enabled for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Errand {
    MoveTo(i32),
    Home,
    /// Not enabled: a fault is acknowledged.
    Acknowledge,
}

const CONTROLWORD: Address = Address::new(0x6040, 0);
const STATUSWORD: Address = Address::new(0x6041, 0);
const MODE: Address = Address::new(0x6060, 0);
const TARGET: Address = Address::new(0x607A, 0);

/// Bits of the control words of the flow charts.
const SHUTDOWN: u16 = 0x0006;
const SWITCH_ON: u16 = 0x0007;
const ENABLE: u16 = 0x000F;
const QUICK_STOP: u16 = 0x0002;
const FAULT_RESET: u16 = Controlword::FAULT_RESET;
const START: u16 = ENABLE | Controlword::NEW_SET_POINT;
/// How long between two status words.
const LOOK: Duration = Duration::from_millis(5);

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
            NodeGoal::MoveTo(target) => self.set_out(now, Errand::MoveTo(target)),
            NodeGoal::Home => self.set_out(now, Errand::Home),
            NodeGoal::Acknowledge => self.set_out(now, Errand::Acknowledge),
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

    fn set_out(&mut self, now: Instant, errand: Errand) {
        self.begin(now, Task::Enter(errand), self.limits.reaction);
        // What was heard before may be old: it is only what the node is taken back to.
        let heard = self.nmt.take();
        self.guard.nmt = self.guard.nmt.or(heard);
        self.ask_state();
        self.look_at = Some(now.saturating_add(LOOK));
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
        self.send(nmt::Command::Enter(state).frame(Some(self.node)));
    }

    /// The entry that the answer waited for is about.
    const fn sdo_at(&self) -> Address {
        match self.task {
            Task::Read(at) | Task::Write(at) => at,
            Task::Prepare(_, step) | Task::Leave(step) => step.entry(),
            Task::Target => TARGET,
            Task::Start
            | Task::StartHoming
            | Task::Clear
            | Task::Acknowledge
            | Task::Release
            | Task::Halt
            | Task::Coast => CONTROLWORD,
            Task::Idle
            | Task::Enter(_)
            | Task::Enable(_)
            | Task::Acknowledged
            | Task::Travel
            | Task::Homing
            | Task::Acknowledging
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
            Task::Prepare(errand, step @ (Preparation::ReadHeartbeat | Preparation::Heartbeat)) => {
                self.prepared(now, errand, step);
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
            | Task::StartHoming
            | Task::Homing
            | Task::Clear
            | Task::Acknowledge
            | Task::Acknowledging
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
            Task::Prepare(errand, Preparation::ReadMode) => self.mode_read(now, errand, low.cast_signed()),
            Task::Prepare(errand, step) => {
                if let Some(place) = step.place().and_then(|place| self.guard.reading.get_mut(place)) {
                    *place = word;
                }
                self.prepared(now, errand, step);
            }
            Task::Enable(errand) => self.enable(now, errand, len, word),
            Task::Target => {
                self.go(now, Task::Start, self.limits.reaction);
                self.control(now, START);
            }
            Task::Start => self.watch(now, Task::Acknowledged, self.limits.reaction),
            Task::Release => self.watch(now, Task::Travel, self.limits.motion),
            Task::StartHoming => self.watch(now, Task::Homing, self.limits.motion),
            Task::Clear => {
                self.go(now, Task::Acknowledge, self.limits.reaction);
                self.control(now, FAULT_RESET);
            }
            Task::Acknowledge => self.watch(now, Task::Acknowledging, self.limits.reaction),
            Task::Halt => self.watch(now, Task::Halting, self.limits.motion),
            Task::Coast => self.end(NodeOutcome::Done),
            Task::Acknowledged | Task::Travel | Task::Homing | Task::Acknowledging | Task::Halting => {
                self.seen(now, Statusword(word));
            }
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
            Task::Enter(errand) => self.enter(now, errand),
            Task::Enable(_)
            | Task::Acknowledged
            | Task::Travel
            | Task::Homing
            | Task::Acknowledging
            | Task::Halting => self.ask(now, STATUSWORD),
            Task::Idle
            | Task::Read(_)
            | Task::Write(_)
            | Task::Prepare(..)
            | Task::Target
            | Task::Start
            | Task::StartHoming
            | Task::Clear
            | Task::Acknowledge
            | Task::Release
            | Task::Halt
            | Task::Coast
            | Task::Leave(_) => {}
        }
    }
}

fn is_device_state(trouble: NodeTrouble) -> bool {
    matches!(trouble, NodeTrouble::Refused { code: Abort::DEVICE_STATE, .. })
}
