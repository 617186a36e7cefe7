//! Frames of a CANopen network in words.
//!
//! | file | holds |
//! | --- | --- |
//! | `node` | what is known of one node: its device, what was written to it, what it was asked |
//! | `service` | which service of which node an identifier is |
//! | `management` | NMT, boot-up, heartbeat, guarding, SYNC, EMCY |
//! | `sdo` | requests and answers |
//! | `pdo` | the entries in a PDO |
//! | `entry` | one entry: name, value in words, bits |
//! | `text` | [`frame_in`]: frames written as text |
//!
//! ```
//! use profidrive::can_bus::canopen::NodeId;
//! use profidrive::devices::ag03::canopen::VOCABULARY;
//! use profidrive::explain::canopen::{Network, frame_in};
//!
//! let mut network = Network::default();
//! network.know(NodeId::new(5)?, &VOCABULARY);
//! let mut said = |line: &str| network.frame(&frame_in(line).unwrap().unwrap()).line();
//! assert_eq!(said("605#4041600000000000"), "605  SDO to 5: read 6041h:00 Statusword");
//! assert_eq!(
//!     said("t58584B41600070020000"),
//!     "585  SDO from 5: 6041h:00 Statusword = 0270h, switch on disabled, voltage enabled, remote",
//! );
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod entry;
mod management;
mod node;
mod pdo;
mod sdo;
mod service;
mod text;

use crate::map::Map;

use super::{Explanation, Field, Kind, Mark, Sender};
use crate::can_bus::can::{Frame, Id};
use crate::can_bus::canopen::{Address, NodeId};
use crate::devices::Vocabulary;
use node::Learned;
use service::Service;

pub use text::{FrameTextError, frame_in};

/// Explains frames one after the other, and remembers what helps with the next: which request an answer answers, the
/// identifiers and mappings of PDOs as they are written and read, NMT states, modes of operation.
///
/// Takes memory for at most 127 nodes, however long the stream.
#[derive(Clone, Debug, Default)]
pub struct Network {
    every: Option<&'static Vocabulary>,
    nodes: Map<u8, Learned>,
    /// Services whose identifier was heard to be another than CiA 301 gives them.
    moved: Map<Id, Service>,
}

impl Network {
    /// A network in which every node is this device, unless [`know`](Self::know) says another.
    pub fn of(every: &'static Vocabulary) -> Self {
        Self { every: Some(every), ..Self::default() }
    }

    /// Tells which device a node is: its names are used, and what it refuses is a
    /// [`Mistake`](Mark::Mistake).
    pub fn know(&mut self, node: NodeId, vocabulary: &'static Vocabulary) {
        self.node(node.number()).vocabulary = Some(vocabulary);
    }

    /// Explains one frame. Never panics.
    pub fn frame(&mut self, frame: &Frame) -> Explanation {
        let service = self.service(frame.id());
        let said = match service {
            Some(Service::Nmt) => management::nmt(self, frame),
            Some(Service::Sync) => management::sync(frame),
            Some(Service::Time) => management::time(frame),
            Some(Service::Emcy(node)) => management::emcy(self.node(node), node, frame),
            Some(Service::ErrorControl(node)) => management::error_control(self.node(node), node, frame),
            Some(Service::Tpdo(node, pdo)) => pdo::transmit(self.node(node), node, pdo, frame),
            Some(Service::Rpdo(node, pdo)) => pdo::rpdo(self.node(node), node, pdo, frame),
            Some(Service::SdoRequest(node)) => sdo::request(self.node(node), node, frame),
            Some(Service::SdoResponse(node)) => {
                let said = sdo::response(self.node(node), node, frame);
                if let Some(at) = self.node(node).take_changed() {
                    self.place(node, at);
                }
                said
            }
            None => Said::new("", "no service of CiA 301 has this identifier", frame),
        };
        said.explanation(frame)
    }

    /// An entry of a node by address and name: `6041h:00 Statusword`.
    pub(crate) fn named(&self, node: NodeId, at: Address) -> String {
        self.with_node(node, |node| entry::named(node, at))
    }

    /// The value of an entry in words: with its unit, what a number stands for, the bits that are 1.
    pub(crate) fn in_words(&self, node: NodeId, at: Address, octets: &[u8]) -> String {
        self.with_node(node, |node| entry::in_words(node, at, octets))
    }

    /// The same as a field, of a word of bits with a part for each bit.
    pub(crate) fn value(&self, node: NodeId, at: Address, octets: &[u8]) -> Field {
        self.with_node(node, |node| entry::field(node, at, 0, octets))
    }

    fn with_node<T>(&self, node: NodeId, say: impl FnOnce(&Learned) -> T) -> T {
        match self.nodes.get(&node.number()) {
            Some(learned) => say(learned),
            None => say(&Learned::new(self.every)),
        }
    }

    /// Explains an error frame, which has no identifier: `what` happened.
    pub(crate) fn error_frame(what: &str) -> Explanation {
        let field = Field::octets("error frame", 0, &[], what).marked(Mark::Trouble);
        Explanation::of_nobody(Kind::ErrorFrame, format!("error frame: {what}"), &[], Vec::from([field]))
    }

    /// Explains octets of a capture that are no frame of CAN 2.0: `why`.
    pub(crate) fn no_frame(octets: &[u8], why: &str) -> Explanation {
        let field = Field::octets("octets", 0, octets, why).marked(Mark::Invalid);
        Explanation::of_nobody(Kind::Noise, format!("invalid: {why}"), octets, Vec::from([field]))
    }

    fn node(&mut self, node: u8) -> &mut Learned {
        let every = self.every;
        self.nodes.or_insert_with(node & 0x7F, || Learned::new(every))
    }
}

/// What a service says, on its way to an explanation.
struct Said {
    service: &'static str,
    sender: Option<Sender>,
    node: Option<u8>,
    summary: String,
    fields: Vec<Field>,
}

impl Said {
    /// All of a frame under one name.
    fn new(service: &'static str, summary: impl Into<String>, frame: &Frame) -> Self {
        let fields = match frame.octets() {
            [] => Vec::new(),
            octets => Vec::from([Field::octets("data", 0, octets, "")]),
        };
        Self { service, sender: None, node: None, summary: summary.into(), fields }
    }

    fn with(self, fields: Vec<Field>) -> Self {
        Self { fields, ..self }
    }

    /// To a node.
    fn to(self, node: u8) -> Self {
        Self { sender: Some(Sender::Master), node: Some(node), ..self }
    }

    /// From a node.
    fn from(self, node: u8) -> Self {
        Self { sender: Some(Sender::Slave), node: Some(node), ..self }
    }

    /// Says that nobody takes this frame, and why.
    fn ignored(mut self, why: impl Into<String>) -> Self {
        let field = match self.fields.pop() {
            Some(field) => field,
            None => Field::octets("data", 0, &[], "none"),
        };
        self.fields.push(field.mistaken(why.into()));
        self
    }

    fn explanation(self, frame: &Frame) -> Explanation {
        let Self { service, sender, node, summary, fields } = self;
        let (from, to) = match sender {
            Some(Sender::Slave) => (node, None),
            Some(Sender::Master) | None => (None, node),
        };
        Explanation {
            kind: Kind::Frame,
            id: Some(frame.id()),
            sender,
            from,
            to,
            service: if service.is_empty() { None } else { Some(service) },
            summary,
            octets: frame.octets().into(),
            fields,
        }
    }
}

#[cfg(test)]
mod tests;
