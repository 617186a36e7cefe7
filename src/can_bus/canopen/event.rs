//! What a node tells its user.

use core::fmt;
use core::time::Duration;

use super::abort::Abort;
use super::address::{Address, NodeId};
use super::nmt::{NmtState, Reset};
use super::pdo::PdoNumber;
use super::refusal::{Change, Octets, Refusal};

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
    /// A frame for this node had no effect. Each kind is told once, until the NMT state changes.
    NoEffect(NoEffect),
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
    Written(Change),
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
    HeartbeatLost {
        /// Who.
        node: NodeId,
        /// For longer than this.
        time: Duration,
        /// The sub-index of 1016h that says so.
        sub: u8,
    },
    /// It is heard again.
    HeartbeatBack(NodeId),
    /// Frames were not taken in time by the host and are lost.
    FramesLost {
        /// How many since the node was made.
        count: u32,
    },
}

/// Why a frame for a node has no effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum NoEffect {
    /// An SDO request while the node is STOPPED.
    SdoStopped,
    /// An SDO request that has not 8 octets.
    SdoLength {
        /// Octets received.
        got: usize,
    },
    /// A frame of the NMT master that has not 2 octets.
    NmtLength {
        /// Octets received.
        got: usize,
    },
    /// An RPDO outside OPERATIONAL.
    RpdoState {
        /// The PDO.
        pdo: PdoNumber,
        /// The state of the node.
        state: NmtState,
    },
    /// An RPDO that carries nothing: it has no mapping.
    RpdoEmpty {
        /// The PDO.
        pdo: PdoNumber,
    },
    /// A synchronous RPDO that came too late for its SYNC (1007h).
    RpdoLate {
        /// The PDO.
        pdo: PdoNumber,
    },
    /// A synchronous RPDO whose values wait for a SYNC that does not come.
    RpdoWaits {
        /// The PDO.
        pdo: PdoNumber,
    },
    /// A frame with the usual identifier of an RPDO, which is off or has another one.
    RpdoOff {
        /// The PDO.
        pdo: PdoNumber,
    },
    /// A remote request of a TPDO that answers none.
    TpdoRequest {
        /// The PDO.
        pdo: PdoNumber,
    },
    /// A guarding request of a node that answers none now.
    Guarding {
        /// It produces heartbeats; if not, a time of guarding is 0.
        heartbeat: bool,
    },
}

impl NoEffect {
    /// One bit for each kind.
    pub(super) const fn mask(self) -> u16 {
        1 << match self {
            Self::SdoStopped => 0,
            Self::SdoLength { .. } => 1,
            Self::NmtLength { .. } => 2,
            Self::RpdoState { .. } => 3,
            Self::RpdoLate { .. } => 4,
            Self::RpdoWaits { .. } => 5,
            Self::RpdoEmpty { .. } => 6,
            Self::RpdoOff { .. } => 7,
            Self::TpdoRequest { .. } => 8,
            Self::Guarding { .. } => 9,
        }
    }
}

impl fmt::Display for NoEffect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::SdoStopped => f.write_str(
                "SDO request ignored: the node is STOPPED; send NMT 80h (pre-operational) or 01h (start) first",
            ),
            Self::SdoLength { got } => write!(f, "SDO request of {} ignored: expected 8", Octets(*got)),
            Self::NmtLength { got } => {
                write!(f, "NMT command of {} ignored: expected 2, command and node", Octets(*got))
            }
            Self::RpdoState { pdo, state } => {
                write!(f, "RPDO{pdo} ignored: the node is {state}; send NMT 01h (start) first")
            }
            Self::RpdoEmpty { pdo } => write!(
                f,
                "RPDO{pdo} ignored: no object is mapped to it; write its mapping ({}) before NMT 01h (start)",
                pdo.object(0x1600)
            ),
            Self::RpdoOff { pdo } => write!(
                f,
                "RPDO{pdo} ignored: it is off or has another identifier; write its COB-ID ({}:01), or send the one that it has",
                pdo.object(0x1400)
            ),
            Self::TpdoRequest { pdo } => write!(
                f,
                "remote request of TPDO{pdo} ignored: bit 30 of its COB-ID ({}:01) is 1, or the device answers none; send \
                 SYNC, or set its transmission type to 255 ({}:02)",
                pdo.object(0x1800),
                pdo.object(0x1800)
            ),
            Self::Guarding { heartbeat: true } => f.write_str(
                "guarding request ignored: the node produces heartbeats (1017h is not 0); take those, or write 1017h = 0",
            ),
            Self::Guarding { heartbeat: false } => f.write_str(
                "guarding request ignored: guard time or life time factor is 0 (100Ch, 100Dh); write both",
            ),
            Self::RpdoLate { pdo } => {
                write!(f, "RPDO{pdo} ignored: it came after the window behind SYNC (1007h); send it earlier")
            }
            Self::RpdoWaits { pdo } => write!(
                f,
                "RPDO{pdo} waits for SYNC (1005h), and none comes; send SYNC, or set the transmission type of the PDO to 255 \
                 ({}:02)",
                pdo.object(0x1400)
            ),
        }
    }
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
            Self::NoEffect(what) => what.fmt(f),
            Self::SdoRefused(refusal) => write!(f, "SDO request for {refusal}"),
            Self::SdoAbortedByClient { at, code } => write!(f, "client aborted the SDO for {at}: {code}"),
            Self::Written(change) => change.fmt(f),
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
            Self::HeartbeatLost { node, time, sub } => write!(
                f,
                "heartbeat of node {node} is missing: none came within {time:?} (1016h:{sub:02X}); check that it runs, and that its \
                 period (1017h) is shorter"
            ),
            Self::HeartbeatBack(node) => write!(f, "heartbeat of node {node} is back"),
            Self::FramesLost { count } => write!(f, "{count} frames were not taken in time and are lost"),
        }
    }
}
