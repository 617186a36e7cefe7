//! Any node that an EDS, a DCF or an XDD describes: a dictionary with memory (`eds.md` 4).
//!
//! | module | holds |
//! | --- | --- |
//! | `dictionary` | [`Dictionary`]: the tables of the node from the file |
//! | `memory` | the values of a node, and what it keeps over power-off |
//! | `application` | what is read and written |
//! | `drive` | CiA 402: which objects drive what, and what the bus does to it |
//! | `io` | CiA 401: inputs and outputs |
//! | `encoder` | CiA 406: an encoder |
//! | `description` | values and inputs for people |
//! | `names` | what a further axis of a drive calls them |
//! | `why` | what keeps a drive from moving |
//!
//! The node itself has the communication objects: PDOs, heartbeat, SYNC, EMCY. What is left are values: each object reads as
//! its file says, and an object that can be written keeps what was written. A file of a drive has one behind its objects.

mod application;
mod description;
mod dictionary;
mod drive;
mod encoder;
mod io;
mod memory;
mod names;
mod why;

pub use dictionary::Dictionary;

use crate::can_bus::canopen::node::storage::Eeprom;
use crate::can_bus::canopen::{NodeId, Value};
use crate::devices::PlainNode;
use crate::eds::Profile;
use crate::time::Instant;
use dictionary::{Role, Row};
use drive::Driven;
use encoder::Encoder;
use io::Io;
use memory::Memory;

/// The values behind a node from a file.
#[derive(Clone, Debug)]
pub struct FromEds {
    dictionary: &'static Dictionary,
    node: NodeId,
    /// From the next reset on.
    next: NodeId,
    /// After power-on.
    kept: NodeId,
    memory: Memory,
    behaviour: Behaviour,
}

/// What is behind the values.
#[derive(Clone, Debug)]
enum Behaviour {
    /// Nothing: they are a memory.
    Memory,
    /// CiA 402.
    Drive(Box<Driven>),
    /// CiA 401.
    Io(Box<Io>),
    /// CiA 406.
    Encoder(Encoder),
}

impl Behaviour {
    fn of(dictionary: &Dictionary) -> Self {
        match dictionary.profile {
            Profile::Drive => Self::Drive(Box::new(Driven::of(dictionary))),
            Profile::InputsOutputs => Self::Io(Box::new(Io::new())),
            Profile::Encoder => Self::Encoder(Encoder::default()),
            Profile::Other(_) | Profile::None => Self::Memory,
        }
    }
}

impl FromEds {
    /// The device on its node, switched off.
    pub fn on_node(dictionary: &'static Dictionary, node: NodeId, memory: Eeprom) -> PlainNode<Self> {
        let values = Memory::new(dictionary, node);
        let behaviour = Behaviour::of(dictionary);
        let mut device = Self { dictionary, node, next: node, kept: node, memory: values, behaviour };
        device.make_inputs_nominal(Instant::ZERO);
        PlainNode::new(dictionary.policy(), memory, device)
    }

    const fn driven(&self) -> Option<&Driven> {
        match &self.behaviour {
            Behaviour::Drive(driven) => Some(driven),
            Behaviour::Memory | Behaviour::Io(_) | Behaviour::Encoder(_) => None,
        }
    }

    const fn driven_mut(&mut self) -> Option<&mut Driven> {
        match &mut self.behaviour {
            Behaviour::Drive(driven) => Some(driven),
            Behaviour::Memory | Behaviour::Io(_) | Behaviour::Encoder(_) => None,
        }
    }

    /// What the device behind the values tells in this entry.
    fn told(&self, row: &Row) -> Option<Value<'static>> {
        match (row.role, &self.behaviour) {
            (Role::Actual(axis, actual), Behaviour::Drive(driven)) => {
                driven.axis(axis)?.value(actual, row.table.data)
            }
            (Role::Io(point), Behaviour::Io(io)) => io.read(point, row),
            (Role::Encoder(part), Behaviour::Encoder(encoder)) => {
                self.encoder_value(encoder, part, row.table.data)
            }
            (Role::Value | Role::Setting(..) | Role::Actual(..) | Role::Io(_) | Role::Encoder(_), _) => None,
        }
    }
}
