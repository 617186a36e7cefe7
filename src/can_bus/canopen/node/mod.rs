//! The node: frames and time in, frames, events and a deadline out.
//!
//! Every service is a file with its state and its part of [`Node`]; only they see inside of it.
//!
//! | file | holds |
//! | --- | --- |
//! | here | [`Node`]: where a frame goes, NMT, resets, what the device asks for |
//! | `sdo_server`, `sdo_block` | SDO transfers |
//! | `access` | the checks of a read and a write |
//! | `settings` | what a write of a communication object does |
//! | [`storage`] | 1010h, 1011h, images for the host |
//! | `rpdo`, `tpdo`, `sync` | process data, and what a SYNC does |
//! | `errors` | emergencies, error register, history |
//! | `guarding`, `heartbeat` | error control |
//! | `lss` | another number by identity |

use heapless::Deque;

use crate::can_bus::can::{Frame, Id};
use crate::can_bus::canopen::address::{Address, NodeId};
use crate::can_bus::canopen::application::{Application, NmtCause, Notice, Request};
use crate::can_bus::canopen::cob_id;
use crate::can_bus::canopen::cob_id::CobId;
use crate::can_bus::canopen::dictionary::{self, Home, Object};
use crate::can_bus::canopen::event::{Event, NoEffect};
use crate::can_bus::canopen::nmt::{Command, NmtState, Reset};
use crate::can_bus::canopen::parameter::{Communication, MAX_CONSUMERS};
use crate::can_bus::canopen::pdo::{PdoNumber, PerPdo};
use crate::can_bus::canopen::policy::Policy;
use crate::time::Instant;
use crate::untold::Untold;

mod access;
mod errors;
mod guarding;
mod heartbeat;
mod lss;
mod rpdo;
mod sdo_block;
mod sdo_server;
mod settings;
pub mod storage;
mod sync;
mod tpdo;

use errors::Errors;
use guarding::Guarding;
use heartbeat::Consumer;
use lss::Lss;
use rpdo::Rpdo;
use sdo_server::Server;
use storage::{Eeprom, Storage};
use sync::SyncWatch;
use tpdo::Tpdo;

/// Frames that wait for the host. What is more is lost and counted.
const MAX_FRAMES: usize = 32;

/// Events that wait for the user; the oldest make room.
const MAX_EVENTS: usize = 16;

/// Requests of a device in answer to one thing that happened. What is more waits for the next.
const MAX_REQUESTS: usize = 32;

/// What a frame of a node is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Service {
    /// The node began.
    BootUp,
    /// 1017h.
    Heartbeat,
    /// The answer to a guarding request.
    Guarding,
    /// The answer to an SDO request.
    SdoAnswer,
    /// An emergency.
    Emcy,
    /// Process data.
    Tpdo(PdoNumber),
}

/// A CANopen node by CiA 301 without I/O.
///
/// After every `handle_*` drain [`poll_transmit`](Self::poll_transmit) and [`poll_event`](Self::poll_event), then wait
/// until a frame arrives or [`poll_timeout`](Self::poll_timeout) has come. Never panics, whatever frames it is given.
#[derive(Clone, Debug)]
pub struct Node {
    policy: Policy,
    objects: &'static [Object],
    node_id: NodeId,
    /// `None` while it is switched off.
    state: Option<NmtState>,
    values: Communication,
    sdo: Server,
    storage: Storage,
    errors: Errors,
    /// Entries of 1003h, 0 if the node does not keep it.
    history_len: usize,
    /// Whether 1003h survives power-off.
    history_stored: bool,
    has_error_behaviour: bool,
    guarding: Guarding,
    heartbeat_due: Option<Instant>,
    consumers: [Consumer; MAX_CONSUMERS],
    /// The first of them.
    consumer_due: Option<Instant>,
    lss: Lss,
    sync_window_ends: Option<Instant>,
    sync_watch: SyncWatch,
    /// When the node sends the next SYNC.
    sync_due: Option<Instant>,
    /// The counter of the last SYNC that it sent.
    syncs_sent: u8,
    /// In the order of their values.
    rpdos: PerPdo<Rpdo>,
    tpdos: PerPdo<Tpdo>,
    frames: Deque<Frame, MAX_FRAMES>,
    frames_lost: u32,
    events: Untold<Event, MAX_EVENTS>,
    /// The last NMT command that was not followed and told.
    ignored: Option<u8>,
    /// What had no effect and was told, one bit for each kind.
    without_effect: u64,
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
            storage: Storage::new(Eeprom::Internal),
            errors: Errors::NONE,
            history_len: 0,
            history_stored: false,
            has_error_behaviour: false,
            guarding: Guarding::FRESH,
            heartbeat_due: None,
            consumers: [Consumer::Waiting; MAX_CONSUMERS],
            consumer_due: None,
            lss: Lss::NONE,
            sync_window_ends: None,
            sync_watch: SyncWatch::NONE,
            sync_due: None,
            syncs_sent: 0,
            rpdos: PerPdo::new(),
            tpdos: PerPdo::new(),
            frames: Deque::new(),
            frames_lost: 0,
            events: Untold::new(),
            ignored: None,
            without_effect: 0,
        }
    }

    /// With what is stored kept there.
    #[must_use]
    pub fn with_memory(mut self, memory: Eeprom) -> Self {
        self.storage.memory = memory;
        self
    }

    /// The NMT state, `None` while the node is switched off.
    pub const fn state(&self) -> Option<NmtState> {
        self.state
    }

    /// The node number in force since the last reset.
    pub const fn node_id(&self) -> NodeId {
        self.node_id
    }

    /// What a frame that this node sent is.
    pub(crate) fn service_of(&self, frame: &Frame) -> Option<Service> {
        let id = frame.id();
        if id == cob_id::of_node(cob_id::SDO_SERVER, self.node_id) {
            Some(Service::SdoAnswer)
        } else if id == cob_id::of_node(cob_id::ERROR_CONTROL, self.node_id) {
            Some(match (frame.octets(), self.heartbeat_due) {
                ([0], _) => Service::BootUp,
                (_, Some(_)) => Service::Heartbeat,
                (_, None) => Service::Guarding,
            })
        } else if CobId(self.values.emcy_id).active() == Some(id) {
            Some(Service::Emcy)
        } else {
            let number = |place| self.values.tpdos.at(place).number;
            self.tpdo_of(id).map(|place| Service::Tpdo(number(place)))
        }
    }

    /// Switches the node on: it boots.
    pub fn power_on(&mut self, now: Instant, app: &mut dyn Application) {
        self.reset(now, Reset::PowerOn, app);
        self.settle(now, app);
    }

    /// Switches the node off: it is silent and deaf, and what is not stored is lost.
    pub fn power_off(&mut self) {
        self.state = None;
        self.ignored = None;
        self.sdo.end();
        self.storage.forget_answer();
        self.frames.clear();
    }

    /// A frame was received.
    pub fn handle_frame(&mut self, now: Instant, frame: &Frame, app: &mut dyn Application) {
        self.hear(now, frame, app);
    }

    /// The same; says whether it was for this node: then what the device wants is done, too.
    pub(crate) fn hear(&mut self, now: Instant, frame: &Frame, app: &mut dyn Application) -> bool {
        let Some(state) = self.state else {
            self.nmt_ignored(frame);
            return false;
        };
        // What was due before the frame came happens before it.
        if self.poll_timeout().is_some_and(|due| due <= now) {
            self.handle_timeout(now, app);
        }
        let is_own = self.dispatch(now, state, frame, app);
        if is_own {
            self.settle(now, app);
        }
        is_own
    }

    /// Whether the frame was for this node.
    fn dispatch(&mut self, now: Instant, state: NmtState, frame: &Frame, app: &mut dyn Application) -> bool {
        if let (Id::Base(id), data) = (frame.id(), !frame.is_remote()) {
            let own = u16::from(self.node_id.number());
            match (id.number(), data) {
                (cob_id::NMT, true) => {
                    self.nmt_command(now, frame, app);
                    return true;
                }
                (cob_id::NMT, false) => return false,
                (cob_id::LSS_MASTER, true) => {
                    self.lss_request(frame, app);
                    return true;
                }
                (id, data) if id == cob_id::SDO_CLIENT + own => {
                    match (data, state.serves_sdo()) {
                        (true, true) => self.sdo_request(now, frame, app),
                        (true, false) => self.no_effect(NoEffect::SdoStopped),
                        (false, _) => {}
                    }
                    return data;
                }
                (id @ 0x701..=0x77F, data) => {
                    match (id == cob_id::ERROR_CONTROL + own, data) {
                        (true, false) => self.guarding_request(now, app),
                        (false, true) => {
                            let [node, _] = (id & 0x7F).to_le_bytes();
                            self.heartbeat_heard(now, node, frame, app);
                        }
                        (true, true) | (false, false) => return false,
                    }
                    return true;
                }
                (_, true | false) => {}
            }
        }
        if state == NmtState::Operational {
            return self.dispatch_process_data(now, frame, app);
        }
        if let (Some(pdo), false) = (self.rpdo_meant(frame.id()), frame.is_remote()) {
            self.no_effect(NoEffect::RpdoState { pdo, state });
        }
        false
    }

    /// Tells of a frame without effect, of each kind once in a state.
    #[cold]
    fn no_effect(&mut self, what: NoEffect) {
        if self.without_effect & what.mask() == 0 {
            self.without_effect |= what.mask();
            self.tell(Event::NoEffect(what));
        }
    }

    fn dispatch_process_data(&mut self, now: Instant, frame: &Frame, app: &mut dyn Application) -> bool {
        let id = frame.id();
        if frame.is_remote() {
            if let Some(place) = self.tpdo_of(id) {
                self.tpdo_requested(place, app);
            } else if let Some(place) = self.rpdo_of(id) {
                self.rpdo_requested(place, app);
            } else {
                if let Some(pdo) = self.usual_pdo(cob_id::TPDO_1, id) {
                    self.no_effect(NoEffect::TpdoOff { pdo });
                }
                return false;
            }
        } else if CobId(self.values.sync_id).id() == Some(id) {
            self.sync(now, frame.octets().first().copied(), app);
        } else if let Some(place) = self.rpdo_of(id) {
            self.rpdo_received(now, place, frame, app);
        } else {
            if let Some(pdo) = self.usual_pdo(cob_id::RPDO_1, id) {
                self.no_effect(NoEffect::RpdoOff { pdo });
            } else {
                self.look_for_node_number(id);
            }
            return false;
        }
        true
    }

    /// The deadline of [`poll_timeout`](Self::poll_timeout) has come, or any other instant.
    pub fn handle_timeout(&mut self, now: Instant, app: &mut dyn Application) {
        if self.state.is_some() {
            self.guarding_timeout(now, app);
            self.consumer_timeout(now, app);
            self.emcy_timeout(now, app);
            self.heartbeat_timeout(now);
            self.sync_timeout(now, app);
            self.sync_watch_timeout(now, app);
            self.send_block(app);
            self.settle(now, app);
        }
    }

    /// The device went on: its values may have changed, it may have requests.
    pub fn handle_change(&mut self, now: Instant, app: &mut dyn Application) {
        if self.state.is_some() {
            self.settle(now, app);
        }
    }

    /// The next frame to send.
    pub fn poll_transmit(&mut self) -> Option<Frame> {
        self.frames.pop_front()
    }

    /// The next event.
    pub fn poll_event(&mut self) -> Option<Event> {
        self.events.pop()
    }

    /// When [`handle_timeout`](Self::handle_timeout) is to be called, `None` if nothing is due.
    pub fn poll_timeout(&self) -> Option<Instant> {
        let state = self.state?;
        let mut due = Instant::first_of(self.heartbeat_due, self.guarding.due());
        due = Instant::first_of(due, self.errors.due());
        due = Instant::first_of(due, self.sdo.due().filter(|_| self.frames.is_empty()));
        due = Instant::first_of(due, self.sync_due.filter(|_| state.serves_sdo()));
        due = Instant::first_of(due, self.consumer_due);
        due = Instant::first_of(due, self.sync_watch.due());
        if state == NmtState::Operational {
            for tpdo in self.tpdos.iter().filter(|tpdo| tpdo.id.is_some()) {
                due = Instant::first_of(due, tpdo.due());
            }
        }
        due
    }

    fn nmt_command(&mut self, now: Instant, frame: &Frame, app: &mut dyn Application) {
        match Command::decode(frame, self.node_id) {
            Some(Command::Enter(to)) => {
                self.ignored = None;
                self.enter(now, to, NmtCause::Master, app);
            }
            Some(Command::Reset(reset)) => self.reset(now, reset, app),
            None => self.nmt_ignored(frame),
        }
    }

    /// Tells of a command for this node that it does not follow; of the same one once until it follows one.
    fn nmt_ignored(&mut self, frame: &Frame) {
        let is_nmt = frame.id() == cob_id::NMT_ID && !frame.is_remote();
        let &[command, node] = frame.octets() else {
            if is_nmt && self.state.is_some() {
                self.no_effect(NoEffect::NmtLength { got: frame.octets().len() });
            }
            return;
        };
        let told = self.ignored == Some(command);
        if is_nmt && (node == 0 || node == self.node_id.number()) && !told {
            self.ignored = Some(command);
            self.tell(Event::NmtIgnored { command, off: self.state.is_none() });
        }
    }

    fn enter(&mut self, now: Instant, to: NmtState, cause: NmtCause, app: &mut dyn Application) {
        let Some(from) = self.state else { return };
        if from == to {
            return;
        }
        self.state = Some(to);
        self.without_effect = 0;
        if !from.serves_sdo() {
            self.restart_sync(now);
        }
        if !to.serves_sdo() {
            self.sdo.end();
            self.storage.forget_answer();
            self.errors.quiet();
        }
        self.rpdos.iter_mut().for_each(Rpdo::forget);
        self.sync_window_ends = None;
        self.watch_sync(now, to);
        self.tell(Event::State { from, to, cause });
        app.notice(now, Notice::Nmt { from: Some(from), to, cause });
        if to == NmtState::Operational {
            self.judge_identifiers();
            self.start_tpdos(now, app);
        }
    }

    fn reset(&mut self, now: Instant, reset: Reset, app: &mut dyn Application) {
        self.ignored = None;
        self.without_effect = 0;
        self.sdo.end();
        self.storage.forget_answer();
        self.frames.clear();
        app.notice(now, Notice::Reset(reset));
        self.objects = app.objects();
        self.node_id = app.node_id();
        self.values = self.values_after_reset();
        self.measure();
        self.errors.restart();
        self.lss = Lss::NONE;
        self.sync_watch = SyncWatch::NONE;
        match reset {
            Reset::PowerOn | Reset::Node if !self.history_stored => self.errors.clear_history(),
            Reset::PowerOn | Reset::Node | Reset::Communication => {}
        }
        self.guarding = Guarding::FRESH;
        self.state = Some(NmtState::PreOperational);
        self.send(Frame::with(cob_id::of_node(cob_id::ERROR_CONTROL, self.node_id), [0]));
        self.follow_all(now, app);
        self.tell(Event::BootUp { reset, node: self.node_id });
        let to = NmtState::PreOperational;
        app.notice(now, Notice::Nmt { from: None, to, cause: NmtCause::Start });
    }

    /// What the dictionary has of the objects that the node keeps.
    fn measure(&mut self) {
        let own = |index: u16, sub: u8| {
            dictionary::entry(self.objects, Address::new(index, sub))
                .ok()
                .filter(|entry| entry.home == Home::Node)
        };
        let history = (1..=u8::MAX).take_while(|sub| own(0x1003, *sub).is_some());
        self.history_len = history.count();
        self.history_stored = own(0x1003, 1).is_some_and(|entry| entry.stored);
        self.has_error_behaviour = own(0x1029, 1).is_some();
    }

    /// Does what the device wants after something happened, and sends what changed.
    fn settle(&mut self, now: Instant, app: &mut dyn Application) {
        for _ in 0..MAX_REQUESTS {
            match app.poll_request() {
                Some(Request::Emergency(emergency)) => self.emergency(now, emergency, app),
                Some(Request::ErrorRegister(register)) => self.errors.set_device(register),
                Some(Request::Nmt(to)) => self.enter(now, to, NmtCause::Application, app),
                Some(Request::Tpdo(pdo)) => {
                    let place = self.values.tpdos.place(pdo);
                    if let (Some(NmtState::Operational), Some(place)) = (self.state, place) {
                        self.tpdo_event(now, place, app);
                    }
                }
                Some(Request::Changed(at)) => {
                    if self.state == Some(NmtState::Operational) {
                        self.entry_changed(at);
                    }
                }
                Some(Request::Store) => self.storage.changed_by_device(),
                Some(Request::LoadDefaults(group)) => {
                    // Nobody can be answered: what is refused stays as it is.
                    let _ = self.load_defaults(now, group, app);
                }
                Some(Request::AnswerSdo(outcome)) => self.device_answers(outcome),
                Some(Request::Reset(reset)) => self.reset(now, reset, app),
                None => break,
            }
        }
        if self.state == Some(NmtState::Operational) {
            self.send_event_driven_tpdos(now, app);
        }
    }

    fn send(&mut self, frame: Frame) {
        if self.frames.push_back(frame).is_err() {
            self.frames_lost = self.frames_lost.saturating_add(1);
            self.tell(Event::FramesLost { count: self.frames_lost });
        }
    }

    fn tell(&mut self, event: Event) {
        self.events.push(event);
    }
}
