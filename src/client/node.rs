//! The master's end of a drive on CANopen: its entries, its NMT state, and a travel by the state machine of CiA 402, as the
//! AG03/1 has it too.
//!
//! Control word and target go by SDO, so that each is acknowledged, is refused with its reason, and needs no mapping: a
//! travel of one command has the time. While it lasts, the client guards the node, with a life time that the node
//! supervises: a master that is gone lets the drive release its motor. What it changes for that (100Ch, 100Dh, 1017h), it
//! puts back.
//!
//! ```text
//! Enable:       NMT start ─▶ guarding ─▶ 0006h ─▶ 0007h ─▶ 000Fh
//! MoveTo:       NMT start ─▶ guarding ─▶ 6060h: 1 ─▶ 0006h ─▶ 0007h ─▶ 000Fh ─▶ 607Ah ─▶ 001Fh ─▶ bit 12 ─▶ 000Fh ─▶ bit 10
//! Home:         the same with 6060h: 6, without 607Ah, up to bit 12 (attained) or bit 13 (failed)
//! Turn:         the same with 6060h: 3 (of some drives 2), 60FFh ─▶ 010Fh ─▶ 000Fh ─▶ bit 10
//! Inch:         the same in mode 1 with the control word of the device
//! Acknowledge:  NMT start ─▶ 0000h ─▶ 0080h ─▶ no fault
//! Stop:         0002h ─▶ standstill ─▶ 0000h
//! Leave:        0000h ─▶ 100Ch, 100Dh, 1017h, 6060h as before ─▶ NMT as before
//! ```
//!
//! | file | holds |
//! | --- | --- |
//! | `outcome` | what is asked, and what comes of it |
//! | `course` | the steps to each goal |
//! | `pursuit` | a goal under way, step by step |
//! | `why` | what keeps the drive from moving |

mod course;
mod outcome;
mod pursuit;
mod why;

use core::time::Duration;

use crate::can_bus::can::Frame;
use crate::can_bus::canopen::cob_id;
use crate::can_bus::canopen::nmt;
use crate::can_bus::canopen::sdo::client::{SdoClient, Step};
use crate::can_bus::canopen::{Abort, Address, NmtState, NodeId};
use crate::can_bus::cia402::Statusword;
use crate::time::Instant;
use heapless::Deque;

use course::{Act, CONTROLWORD, Or};
pub(crate) use outcome::MOST_OCTETS;
pub use outcome::{NodeGoal, NodeLimits, NodeOutcome, NodeTrouble};
use pursuit::Before;
pub(crate) use why::NodeSigns;

use super::course::Course;

/// A drive on CANopen as its master sees it. After every call drain [`poll_transmit`](Self::poll_transmit), then ask
/// [`poll_outcome`](Self::poll_outcome); call [`handle_timeout`](Self::handle_timeout) when
/// [`poll_timeout`](Self::poll_timeout) has come.
#[derive(Clone, Debug)]
pub struct NodeClient {
    node: NodeId,
    limits: NodeLimits,
    sdo: SdoClient,
    task: Task,
    /// The entry that is accessed.
    at: Address,
    /// When the task must have gone on.
    due: Instant,
    /// When a status word is asked for next.
    look_at: Option<Instant>,
    nmt: Option<NmtState>,
    before: Before,
    status: Option<Statusword>,
    out: Deque<Frame, 8>,
    outcome: Option<NodeOutcome>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Task {
    Idle,
    Read,
    Write,
    Pursuing(Pursuit),
}

/// A goal under way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Pursuit {
    goal: NodeGoal,
    course: Course<Act, Or>,
}

impl Pursuit {
    const fn next(self) -> Self {
        Self { goal: self.goal, course: self.course.next() }
    }
}

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
            at: CONTROLWORD,
            due: Instant::ZERO,
            look_at: None,
            nmt: None,
            before: Before::default(),
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
        self.begin(Task::Read);
        self.ask(now, at);
    }

    /// Writes an entry. What was under way is forgotten. More than 256 octets or none are refused as a length.
    pub fn write(&mut self, now: Instant, at: Address, octets: &[u8]) {
        self.begin(Task::Write);
        self.put(now, at, octets);
    }

    /// Begins a goal. What was under way is forgotten.
    pub fn pursue(&mut self, now: Instant, goal: NodeGoal) {
        let pursuit = Pursuit { goal, course: goal.course() };
        self.begin(Task::Pursuing(pursuit));
        if pursuit.course.step().is_some_and(|step| step.act == Act::Start) {
            // What was heard before may be old: it is only what the node is taken back to.
            let heard = self.nmt.take();
            self.before.nmt = self.before.nmt.or(heard);
        }
        self.step(now, pursuit);
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
        let at = self.at;
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
        if self.before.next.is_some_and(|next| next <= now) {
            self.ask_state();
            self.before.next = Some(now.saturating_add(self.limits.life / 4));
        }
        let at = self.at;
        if let Step::Failed { tell, .. } = self.sdo.handle_timeout(now) {
            self.send(tell);
            self.refused(now, NodeTrouble::NoAnswer { at });
        }
        if self.look_at.is_some_and(|look| look <= now) {
            self.look_at = None;
            if let Task::Pursuing(pursuit) = self.task {
                self.look(now, pursuit);
            }
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
        Instant::first_of(due, self.before.next)
    }

    fn begin(&mut self, task: Task) {
        self.outcome = None;
        self.look_at = None;
        self.task = task;
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
        self.at = at;
        let frame = self.sdo.read(now, at);
        self.send(frame);
    }

    fn put(&mut self, now: Instant, at: Address, octets: &[u8]) {
        self.at = at;
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

    fn refused(&mut self, now: Instant, trouble: NodeTrouble) {
        match self.task {
            Task::Pursuing(pursuit) => self.step_refused(now, pursuit, trouble),
            Task::Idle | Task::Read | Task::Write => self.fail(trouble),
        }
    }

    /// An SDO answer has come; that to a write has no octets.
    fn answered(&mut self, now: Instant, value: [u8; MOST_OCTETS], len: usize) {
        let [low, high, ..] = value;
        match self.task {
            Task::Idle => {}
            Task::Read => self.end(NodeOutcome::Read(value, len)),
            Task::Write => self.end(NodeOutcome::Written),
            Task::Pursuing(pursuit) if len == 0 => self.confirmed(now, pursuit),
            Task::Pursuing(pursuit) => self.value_read(now, pursuit, u16::from_le_bytes([low, high])),
        }
    }
}
