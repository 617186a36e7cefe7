//! The node: frames and time in, frames, events and a deadline out.

use heapless::Deque;

use super::address::NodeId;
use super::application::{Application, NmtCause, Notice, Request};
use super::cob_id;
use super::dictionary::Object;
use super::event::Event;
use super::nmt::{Command, NmtState, Reset};
use super::parameter::Communication;
use super::policy::Policy;
use super::sdo::server::Server;
use crate::can::{Frame, Id};
use crate::time::Instant;

/// Frames that wait for the host. What is more is lost and counted.
const MAX_FRAMES: usize = 32;

/// Events that wait for the user; the oldest make room.
const MAX_EVENTS: usize = 16;

/// Requests of a device in answer to one thing that happened. What is more waits for the next.
const MAX_REQUESTS: usize = 32;

/// A CANopen node by CiA 301 without I/O.
///
/// After every `handle_*` drain [`poll_transmit`](Self::poll_transmit) and [`poll_event`](Self::poll_event), then wait
/// until a frame arrives or [`poll_timeout`](Self::poll_timeout) has come. Never panics, whatever frames it is given.
#[derive(Clone, Debug)]
pub struct Node {
    pub(super) policy: Policy,
    pub(super) objects: &'static [Object],
    pub(super) node_id: NodeId,
    /// `None` while it is switched off.
    pub(super) state: Option<NmtState>,
    pub(super) values: Communication,
    pub(super) sdo: Server,
    frames: Deque<Frame, MAX_FRAMES>,
    frames_lost: u32,
    events: Deque<Event, MAX_EVENTS>,
}

impl Node {
    /// A node that is switched off.
    pub const fn new(policy: Policy) -> Self {
        Self {
            policy,
            objects: &[],
            node_id: NodeId::MIN,
            state: None,
            values: Communication::OFF,
            sdo: Server::IDLE,
            frames: Deque::new(),
            frames_lost: 0,
            events: Deque::new(),
        }
    }

    /// The NMT state, `None` while the node is switched off.
    pub const fn state(&self) -> Option<NmtState> {
        self.state
    }

    /// The node number in force since the last reset.
    pub const fn node_id(&self) -> NodeId {
        self.node_id
    }

    /// Switches the node on: it boots.
    pub fn power_on(&mut self, now: Instant, app: &mut dyn Application) {
        self.reset(now, Reset::PowerOn, app);
        self.settle(now, app);
    }

    /// Switches the node off: it is silent and deaf, and what is not stored is lost.
    pub fn power_off(&mut self) {
        self.state = None;
        self.sdo.end();
        self.frames.clear();
    }

    /// A frame was received.
    pub fn handle_frame(&mut self, now: Instant, frame: &Frame, app: &mut dyn Application) {
        let Some(state) = self.state else { return };
        let Id::Base(id) = frame.id() else { return };
        if id.number() == cob_id::NMT && !frame.is_remote() {
            self.nmt_command(now, frame, app);
        } else if frame.id() == cob_id::of_node(cob_id::SDO_CLIENT, self.node_id)
            && !frame.is_remote()
            && state.serves_sdo()
        {
            self.sdo_request(now, frame, app);
        } else {
            return;
        }
        self.settle(now, app);
    }

    /// The deadline of [`poll_timeout`](Self::poll_timeout) has come, or any other instant.
    pub fn handle_timeout(&mut self, now: Instant, app: &mut dyn Application) {
        if self.state.is_some() {
            self.settle(now, app);
        }
    }

    /// The device went on: its values may have changed, it may have requests.
    pub fn handle_change(&mut self, now: Instant, app: &mut dyn Application) {
        self.handle_timeout(now, app);
    }

    /// The next frame to send.
    pub fn poll_transmit(&mut self) -> Option<Frame> {
        self.frames.pop_front()
    }

    /// The next event.
    pub fn poll_event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }

    /// When [`handle_timeout`](Self::handle_timeout) is to be called, `None` if nothing is due.
    pub fn poll_timeout(&self) -> Option<Instant> {
        None
    }

    fn nmt_command(&mut self, now: Instant, frame: &Frame, app: &mut dyn Application) {
        match Command::decode(frame, self.node_id) {
            Some(Command::Enter(to)) => self.enter(now, to, NmtCause::Master, app),
            Some(Command::Reset(reset)) => self.reset(now, reset, app),
            None => {}
        }
    }

    pub(super) fn enter(&mut self, now: Instant, to: NmtState, cause: NmtCause, app: &mut dyn Application) {
        let Some(from) = self.state else { return };
        if from == to {
            return;
        }
        self.state = Some(to);
        if !to.serves_sdo() {
            self.sdo.end();
        }
        self.tell(Event::State { from, to });
        app.notice(now, Notice::Nmt { from: Some(from), to, cause });
    }

    fn reset(&mut self, now: Instant, reset: Reset, app: &mut dyn Application) {
        self.sdo.end();
        self.frames.clear();
        app.notice(now, Notice::Reset(reset));
        self.objects = app.objects();
        self.node_id = app.node_id();
        self.values = Communication::defaults(self.objects, self.node_id);
        self.state = Some(NmtState::PreOperational);
        self.send(Frame::with(cob_id::of_node(cob_id::ERROR_CONTROL, self.node_id), [0]));
        self.tell(Event::BootUp { reset, node: self.node_id });
        app.notice(now, Notice::Nmt { from: None, to: NmtState::PreOperational, cause: NmtCause::Start });
    }

    /// Does what the device wants after something happened.
    fn settle(&mut self, now: Instant, app: &mut dyn Application) {
        for _ in 0..MAX_REQUESTS {
            match app.poll_request() {
                Some(Request::Nmt(to)) => self.enter(now, to, NmtCause::Application, app),
                Some(Request::Reset(reset)) => self.reset(now, reset, app),
                Some(Request::AnswerSdo(outcome)) => self.answer_held(outcome),
                Some(Request::Emergency(_) | Request::ErrorRegister(_) | Request::Tpdo(_)) => {}
                None => break,
            }
        }
    }

    pub(super) fn send(&mut self, frame: Frame) {
        if self.frames.push_back(frame).is_err() {
            self.frames_lost = self.frames_lost.saturating_add(1);
        }
    }

    pub(super) fn tell(&mut self, event: Event) {
        if self.events.is_full() {
            self.events.pop_front();
        }
        let _ = self.events.push_back(event);
    }
}
