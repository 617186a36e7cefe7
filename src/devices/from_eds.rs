//! Any node that an EDS or a DCF describes: a dictionary with memory (`eds.md` 4).
//!
//! | module | holds |
//! | --- | --- |
//! | `dictionary` | [`Dictionary`]: the tables of the node from the file |
//! | `memory` | the values of a node, and what it keeps over power-off |
//! | `application` | what is read and written |
//! | `description` | values and inputs for people |
//!
//! The node itself has the communication objects: PDOs, heartbeat, SYNC, EMCY. What is left are values: each object reads as
//! its file says, and an object that can be written keeps what was written.

mod application;
mod description;
mod dictionary;
mod memory;

pub use dictionary::Dictionary;

use crate::can_bus::canopen::NodeId;
use crate::can_bus::canopen::node::storage::Eeprom;
use crate::devices::PlainNode;
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
}

impl FromEds {
    /// The device on its node, switched off.
    pub fn on_node(dictionary: &'static Dictionary, node: NodeId, memory: Eeprom) -> PlainNode<Self> {
        let values = Memory::new(dictionary, node);
        PlainNode::new(
            dictionary.policy(),
            memory,
            Self { dictionary, node, next: node, kept: node, memory: values },
        )
    }
}
