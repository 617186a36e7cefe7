//! What a node tells its user.

use core::fmt;

use super::abort::Abort;
use super::address::{Address, NodeId};
use super::nmt::{NmtState, Reset};
use super::pdo::PdoNumber;
use super::refusal::Refusal;

/// What happened at a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Event {
    /// The node booted.
    BootUp {
        /// Why.
        reset: Reset,
        /// Under this number.
        node: NodeId,
    },
    /// The NMT state changed.
    State {
        /// The state before.
        from: NmtState,
        /// The state now.
        to: NmtState,
    },
    /// A command of the NMT master for this node was not followed.
    NmtIgnored {
        /// Its first octet.
        command: u8,
        /// Whether the node was off; if not, there is no such command.
        off: bool,
    },
    /// An SDO request was refused.
    SdoRefused(Refusal),
    /// The client ended a transfer.
    SdoAbortedByClient {
        /// What it was about.
        at: Address,
        /// Its reason.
        code: Abort,
    },
    /// A value was written by SDO.
    Written {
        /// Where.
        at: Address,
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
    /// An entry of an RPDO was refused.
    RpdoRefused {
        /// The PDO.
        pdo: PdoNumber,
        /// The entry, and why.
        refusal: Refusal,
    },
    /// An EMCY message was sent.
    Emergency {
        /// Its code.
        code: u16,
        /// The error register with it.
        register: u8,
    },
    /// The master did not guard the node for the life time.
    LifeGuardingExpired,
    /// The master guards the node again.
    LifeGuardingBack,
    /// A node under heartbeat supervision was silent.
    HeartbeatLost(NodeId),
    /// It is heard again.
    HeartbeatBack(NodeId),
    /// Frames were not taken in time by the host and are lost.
    FramesLost {
        /// How many since the node was made.
        count: u32,
    },
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::BootUp { reset, node } => {
                let why = match reset {
                    Reset::PowerOn => "power-on",
                    Reset::Node => "reset node",
                    Reset::Communication => "reset communication",
                };
                write!(f, "boot-up as node {node} after {why}")
            }
            Self::State { from, to } => write!(f, "NMT state {from} -> {to}"),
            Self::NmtIgnored { command, off: true } => {
                write!(
                    f,
                    "NMT command {command:02X}h ignored: the node is switched off; switch its supply on"
                )
            }
            Self::NmtIgnored { command, off: false } => write!(
                f,
                "NMT command {command:02X}h ignored: there is no such command; send 01h (start), 02h (stop), 80h \
                 (pre-operational), 81h (reset node) or 82h (reset communication)"
            ),
            Self::SdoRefused(refusal) => write!(f, "SDO request for {refusal}"),
            Self::SdoAbortedByClient { at, code } => write!(f, "client aborted the SDO for {at}: {code}"),
            Self::Written { at } => write!(f, "{at} written"),
            Self::RpdoLength { pdo, expected, got } => {
                write!(f, "RPDO{pdo} has {got} octets, its mapping needs {expected}")
            }
            Self::RpdoRefused { pdo, refusal } => write!(f, "RPDO{pdo}: {refusal}"),
            Self::Emergency { code, register } => {
                write!(f, "EMCY {code:04X}h sent, error register {register:02X}h")
            }
            Self::LifeGuardingExpired => {
                f.write_str("node guarding lost: no guarding request within the life time (100Ch x 100Dh)")
            }
            Self::LifeGuardingBack => f.write_str("guarding requests come again"),
            Self::HeartbeatLost(node) => write!(f, "heartbeat of node {node} is missing"),
            Self::HeartbeatBack(node) => write!(f, "heartbeat of node {node} is back"),
            Self::FramesLost { count } => write!(f, "{count} frames were not taken in time and are lost"),
        }
    }
}
