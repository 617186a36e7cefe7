//! What a node asks of the device behind it: the one trait between bus and device.

use core::time::Duration;

use super::abort::Abort;
use super::address::{Address, NodeId, Sub};
use super::dictionary::Object;
use super::emcy::{Emergency, ErrorNames};
use super::event::AwaitsSync;
use super::nmt::{NmtState, Reset};
use super::pdo::PdoNumber;
use super::refusal::Rule;
use super::value::Value;
use crate::time::Instant;

/// The most octets that a device keeps beside its dictionary.
pub(crate) const MAX_BESIDE: usize = 32;

/// A device on CANopen.
///
/// The node keeps the communication objects with [`Home::Node`](super::dictionary::Home::Node) and judges every access by
/// the tables: existence, access, length, range and NMT state. What gets here is left to the device.
pub trait Application {
    /// The object dictionary, sorted. Asked at power-on and with every reset of the node.
    fn objects(&self) -> &'static [Object];

    /// The node number in force. Asked at power-on and with every reset, also of the communication.
    fn node_id(&self) -> NodeId;

    /// Reads an entry with [`Home::Application`](super::dictionary::Home::Application). The value has the type of the
    /// entry; another one is answered with 06040047h.
    ///
    /// # Errors
    /// The abort code to answer with.
    fn read(&self, at: Address) -> Result<Value<'_>, Abort>;

    /// Writes an entry with `Home::Application`.
    ///
    /// # Errors
    /// The abort code to answer with; nothing has changed then. From a PDO it becomes
    /// [`Notice::RpdoRefused`], as nobody can be answered.
    fn write(
        &mut self,
        now: Instant,
        at: Address,
        value: Value<'_>,
        source: Source,
    ) -> Result<Written, Abort>;

    /// Writes a part of a value of an entry whose values may have more than 256 octets; the value acts with its last part.
    /// Shorter values come so, too, where a client sends them in segments.
    ///
    /// # Errors
    /// The abort code to answer with; the value is as before then.
    fn write_part(&mut self, now: Instant, at: Address, part: Part<'_>) -> Result<Written, Abort> {
        let _ = (now, at, part);
        Err(Abort::MEMORY)
    }

    /// A client has read an entry of up to four octets by SDO.
    fn read_by_client(&mut self, at: Address) {
        let _ = at;
    }

    /// Whether a change of an entry is an event for TPDOs only when the device says so by [`Request::Changed`].
    fn tells_changes(&self, at: Address) -> bool {
        let _ = at;
        false
    }

    /// The rule that `value` breaks, for people: asked when [`write`](Self::write), [`store`](Self::store) or
    /// [`load_defaults`](Self::load_defaults) has refused it.
    fn rule(&self, at: Address, value: Value<'_>) -> Option<Rule> {
        let _ = (at, value);
        None
    }

    /// What a number in an entry counts, for people; empty if it counts nothing, or what is not known.
    fn unit(&self, at: Address) -> &'static str {
        let _ = at;
        ""
    }

    /// What it calls its errors, for people.
    fn error_names(&self) -> &'static ErrorNames {
        &ErrorNames::CIA_301
    }

    /// Something happened on the bus.
    fn notice(&mut self, now: Instant, notice: Notice);

    /// What moves or measures by itself goes on up to `now`. Called before everything else.
    fn advance(&mut self, now: Instant) {
        let _ = now;
    }

    /// When [`advance`](Self::advance) is due; `None`: nothing goes on by itself.
    fn poll_timeout(&self) -> Option<Instant> {
        None
    }

    /// The supply is switched off.
    fn power_off(&mut self) {}

    /// What the device wants of its node, oldest first. Asked after everything the node does.
    fn poll_request(&mut self) -> Option<Request> {
        None
    }

    /// 1010h:`group` was written with the signature `save`. The communication objects are the node's business.
    ///
    /// # Errors
    /// The abort code to answer with, as 06060000h.
    fn store(&mut self, now: Instant, group: Sub) -> Result<Written, Abort> {
        let _ = (now, group);
        Ok(Written::Done)
    }

    /// 1011h:`group` was written with the signature `load`.
    ///
    /// # Errors
    /// The abort code to answer with, as 08000022h.
    fn load_defaults(&mut self, now: Instant, group: Sub) -> Result<Written, Abort> {
        let _ = (now, group);
        Ok(Written::Done)
    }

    /// An RPDO is read by remote request ([`Policy::rpdo_rtr`](super::Policy)): changes octets of the answer where the
    /// device says something else there than in the entries.
    fn complete_rtr_answer(&self, pdo: PdoNumber, octets: &mut [u8; 8]) {
        let _ = (pdo, octets);
    }

    /// The rates that a master may choose by LSS, by their number in the table of CiA 305; `None`: the node has no LSS.
    fn lss_rates(&self) -> Option<[bool; 9]> {
        None
    }

    /// A master gave the node another number by LSS, which acts with the next reset. Whether it is taken.
    fn change_node_id(&mut self, node: NodeId) -> bool {
        let _ = node;
        false
    }

    /// That number is kept over power-off.
    fn keep_node_id(&mut self) {}

    /// The name of the product, as `ap10`: it goes into every image, and an image of another product is refused.
    fn product(&self) -> &str {
        "node"
    }

    /// The value of an entry as it would be after power-off and power-on: what goes into an image. Differs from
    /// [`read`](Self::read) where values live in RAM until they are stored.
    ///
    /// # Errors
    /// If the entry has none: it is left out of the image.
    fn kept(&self, at: Address) -> Result<Value<'_>, Abort> {
        self.read(at)
    }

    /// What a device keeps over power-off that its dictionary does not show, as a battery-buffered count: goes into an
    /// image as it is. Says how many octets it has; at most `MAX_BESIDE` count.
    fn kept_beside(&self, into: &mut [u8; MAX_BESIDE]) -> usize {
        let _ = into;
        0
    }

    /// What [`kept_beside`](Self::kept_beside) gave, before power-on. Octets that the device does not understand it
    /// leaves alone: an image may be older than it.
    fn recall_beside(&mut self, octets: &[u8]) {
        let _ = octets;
    }
}

/// A part of a long value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part<'a> {
    /// Where it begins; 0 begins a new value.
    pub offset: usize,
    /// Its octets.
    pub octets: &'a [u8],
    /// The value ends with it.
    pub last: bool,
}

/// How a write came.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Source {
    /// By SDO.
    Sdo,
    /// In a PDO; [`Notice::RpdoTaken`] follows when all of its entries are written.
    Rpdo(PdoNumber),
    /// From an image, before power-on ([`Node::recall`](super::Node::recall)).
    Image,
}

/// What became of a write that was accepted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Written {
    /// The value is in effect; the client is answered at once.
    Done,
    /// The value is in effect, but the client is answered only after [`Request::AnswerSdo`]: something has to be
    /// stored first, or a person has to act.
    Held,
}

/// What happened on the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Notice {
    /// A reset begins, before the node reads [`Application::node_id`]. [`Reset::Communication`] leaves the application
    /// as it is; the others bring it to its state after power-on.
    Reset(Reset),
    /// The NMT state changed. After a reset `from` is `None`.
    Nmt {
        /// The state before.
        from: Option<NmtState>,
        /// The state now.
        to: NmtState,
        /// Who wanted it.
        cause: NmtCause,
    },
    /// SYNC in OPERATIONAL, after the synchronous RPDOs were taken and before the TPDOs are sampled.
    Sync,
    /// A PDO waits for SYNC in OPERATIONAL, and none comes. [`Notice::Sync`] ends it.
    SyncMissing(AwaitsSync),
    /// Every entry of an RPDO was written.
    RpdoTaken(PdoNumber),
    /// An entry of an RPDO was refused; the other entries were written all the same.
    RpdoRefused {
        /// The PDO.
        pdo: PdoNumber,
        /// The entry.
        at: Address,
        /// Why.
        abort: Abort,
    },
    /// An RPDO had the wrong length.
    RpdoLength {
        /// The PDO.
        pdo: PdoNumber,
        /// Octets its mapping needs.
        expected: u8,
        /// Octets received.
        got: u8,
    },
    /// The master did not guard the node for the life time.
    LifeGuardingExpired(Duration),
    /// The master guards the node again.
    LifeGuardingBack,
    /// A node under heartbeat supervision was silent.
    HeartbeatLost(NodeId),
    /// It is heard again.
    HeartbeatBack(NodeId),
    /// 1003h:0 was written with 0.
    HistoryCleared,
    /// The host could not keep the newest image: what was stored since the last one is not kept.
    NotStored,
}

/// Who wanted a change of the NMT state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum NmtCause {
    /// Power-on or a reset.
    Start,
    /// A command of the NMT master.
    Master,
    /// The device, by [`Request::Nmt`].
    Application,
    /// 1029h after a communication error.
    ErrorBehaviour,
}

/// What a device wants of its node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request {
    /// An event for the error register, the error history and the EMCY service.
    Emergency(Emergency),
    /// Sets the device's bits of the error register without telling anybody.
    ErrorRegister(u8),
    /// Change the NMT state.
    Nmt(NmtState),
    /// Send an event-driven TPDO, under its inhibit time.
    Tpdo(PdoNumber),
    /// An entry of [`Application::tells_changes`] has changed: an event for every TPDO that carries it.
    Changed(Address),
    /// What the device keeps changed without `save`: an image is offered to the host. A held SDO is answered when the
    /// host has it.
    Store,
    /// As 1011h:`group` with the signature `load`: acts with the next reset.
    LoadDefaults(Sub),
    /// Answer the SDO held by [`Written::Held`].
    AnswerSdo(Result<(), Abort>),
    /// Begin anew, as after the NMT command.
    Reset(Reset),
}
