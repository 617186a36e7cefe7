//! Any node that an EDS or a DCF describes: a dictionary with memory (`eds.md` 4).
//!
//! | module | holds |
//! | --- | --- |
//! | `dictionary` | [`Dictionary`]: the tables of the node from the file |
//! | `memory` | the values of a node, and what it keeps over power-off |
//! | `application` | what is read and written |
//! | `drive` | CiA 402: which objects drive what, and what the bus does to it |
//! | `description` | values and inputs for people |
//! | `why` | what keeps a drive from moving |
//!
//! The node itself has the communication objects: PDOs, heartbeat, SYNC, EMCY. What is left are values: each object reads as
//! its file says, and an object that can be written keeps what was written. A file of a drive has one behind its objects.

mod application;
mod description;
mod dictionary;
mod drive;
mod memory;
mod why;

pub use dictionary::Dictionary;

use crate::can_bus::canopen::NodeId;
use crate::can_bus::canopen::node::storage::Eeprom;
use crate::devices::PlainNode;
use drive::Driven;
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
    /// Of a file of CiA 402.
    drive: Option<Driven>,
}

impl FromEds {
    /// The device on its node, switched off.
    pub fn on_node(dictionary: &'static Dictionary, node: NodeId, memory: Eeprom) -> PlainNode<Self> {
        let values = Memory::new(dictionary, node);
        PlainNode::new(
            dictionary.policy(),
            memory,
            Self { dictionary, node, next: node, kept: node, memory: values, drive: Driven::of(dictionary) },
        )
    }
}
