//! What is known of the node under test, and what may be done to it.

use core::time::Duration;

use crate::can_bus::canopen::NodeId;
use crate::eds::Eds;
use crate::judge::device::Soak;

/// The node under test, and how it is judged.
#[derive(Clone, Debug)]
pub struct Setup {
    /// Its number.
    pub node: NodeId,
    /// Its data sheet; `None`: what it says itself is all that is known.
    pub eds: Option<Box<Eds>>,
    /// Whether its objects may be written: communication parameters, and values that no PDO carries. What is written is
    /// written back.
    pub write: bool,
    /// Whether something may move: process data are written, a drive is enabled.
    pub moves_allowed: bool,
    /// Whether what takes long is left out.
    pub quick: bool,
    /// How long rows are tried again at random; `None`: each is tried once.
    pub soak: Option<Soak>,
    /// The whole may take so long.
    pub limit: Option<Duration>,
}

impl Setup {
    /// A node of which nothing is known but its number, that is only read.
    pub const fn new(node: NodeId) -> Self {
        Self { node, eds: None, write: false, moves_allowed: false, quick: false, soak: None, limit: None }
    }
}
