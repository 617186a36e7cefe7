//! What a node tells its user.

use core::fmt;
use core::time::Duration;

use super::abort::Abort;
use super::address::{Address, Index, NodeId};
use super::application::NmtCause;
use super::emcy::ErrorNames;
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
        /// Who wanted it.
        cause: NmtCause,
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
        /// What the device adds.
        octets: [u8; 5],
        /// What the device calls it.
        names: &'static ErrorNames,
    },
    /// The master did not guard the node for the life time, which is the product of both.
    LifeGuardingExpired {
        /// 100Ch.
        guard_time: Duration,
        /// 100Dh.
        factor: u8,
    },
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
    /// Segments of a block download were not in order: the client has to send them again.
    SegmentsMissed {
        /// What it is about.
        at: Address,
        /// Those that were taken.
        taken: u8,
        /// The number of the last one that came.
        number: u8,
    },
    /// A request of LSS to configure the node was refused.
    LssRefused(LssRefusal),
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
    /// An RPDO with more octets than its mapping needs: the others count for nothing.
    RpdoLong {
        /// The PDO.
        pdo: PdoNumber,
        /// Octets its mapping needs.
        expected: u8,
        /// Octets received.
        got: u8,
    },
    /// A PDO that waits for a SYNC that does not come.
    SyncMissing {
        /// The PDO.
        pdo: AwaitsSync,
        /// The identifier of SYNC (1005h).
        sync: u32,
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
    /// A remote request with the usual identifier of a TPDO, which is off or has another one.
    TpdoOff {
        /// The PDO.
        pdo: PdoNumber,
    },
    /// A guarding request of a node that answers none now.
    Guarding {
        /// It produces heartbeats; if not, a time of guarding is 0.
        heartbeat: bool,
    },
    /// A frame with the usual identifier of an RPDO, but for the node number, which is missing.
    RpdoWithoutNode {
        /// The PDO.
        pdo: PdoNumber,
        /// The identifier.
        got: u16,
        /// That of the RPDO.
        usual: u16,
    },
    /// What an SDO has written was put back by the next RPDO, which carries the same entry.
    SdoOverwritten {
        /// The PDO.
        pdo: PdoNumber,
        /// The entry.
        at: Address,
    },
    /// Two services of the node have one identifier.
    SameIdentifier {
        /// One of them.
        pdo: Identified,
        /// The other one.
        other: Identified,
        /// The identifier.
        id: u32,
    },
}

/// A service of a node whose identifier can be written. `Display`: the service, and the entry that holds its identifier.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Identified {
    /// SYNC.
    Sync,
    /// EMCY.
    Emcy,
    /// An RPDO.
    Rpdo(PdoNumber),
    /// A TPDO.
    Tpdo(PdoNumber),
}

impl fmt::Display for Identified {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sync => f.write_str("SYNC (1005h)"),
            Self::Emcy => f.write_str("EMCY (1014h)"),
            Self::Rpdo(pdo) => write!(f, "RPDO{pdo} ({}:01)", pdo.object(0x1400)),
            Self::Tpdo(pdo) => write!(f, "TPDO{pdo} ({}:01)", pdo.object(0x1800)),
        }
    }
}

/// A request of LSS that was refused. `Display`: what was asked, what was expected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LssRefusal {
    /// Another node number.
    Node {
        /// The number.
        got: u8,
    },
    /// Another rate.
    Rate {
        /// The table of rates.
        table: u8,
        /// The place in the table.
        place: u8,
        /// One bit for each place of table 0 whose rate the node has.
        known: u16,
    },
}

impl fmt::Display for LssRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Node { got } => write!(
                f,
                "LSS request for node number {got} refused (11h, error 1): expected 1 to 127; send another number"
            ),
            Self::Rate { table, place, known } => {
                write!(
                    f,
                    "LSS request for rate {place} of table {table} refused (13h, error 1): expected table 0 and one of"
                )?;
                (0..u16::BITS)
                    .filter(|place| known >> place & 1 == 1)
                    .try_for_each(|place| write!(f, " {place}"))?;
                f.write_str(", the rates of the device")
            }
        }
    }
}

/// A PDO that waits for SYNC. `Display`: what does not happen because of that.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum AwaitsSync {
    /// What came in an RPDO is not taken.
    Rpdo(PdoNumber),
    /// A TPDO is not sent.
    Tpdo(PdoNumber),
}

impl AwaitsSync {
    /// What helps.
    pub(crate) const fn cure(self) -> SyncCure {
        SyncCure(match self {
            Self::Rpdo(pdo) => pdo.object(0x1400),
            Self::Tpdo(pdo) => pdo.object(0x1800),
        })
    }
}

/// What helps a PDO that waits for SYNC, with its communication object.
pub(crate) struct SyncCure(Index);

impl fmt::Display for SyncCure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "send SYNC, or set the transmission type of the PDO to 255 ({}:02)", self.0)
    }
}

impl fmt::Display for AwaitsSync {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Rpdo(pdo) => write!(f, "RPDO{pdo} is not taken: it waits for SYNC"),
            Self::Tpdo(pdo) => write!(f, "TPDO{pdo} is not sent: it waits for SYNC"),
        }
    }
}

impl NoEffect {
    /// One bit for each kind, and for each of the first four PDOs; the others share that of the fourth.
    pub(super) const fn mask(self) -> u64 {
        let (kind, pdo) = match self {
            Self::SdoStopped => (0, PdoNumber::P1),
            Self::SdoLength { .. } => (1, PdoNumber::P1),
            Self::NmtLength { .. } => (2, PdoNumber::P1),
            Self::Guarding { .. } => (3, PdoNumber::P1),
            Self::RpdoState { pdo, .. } => (4, pdo),
            Self::RpdoLate { pdo } => (5, pdo),
            Self::RpdoEmpty { pdo } => (6, pdo),
            Self::RpdoOff { pdo } => (7, pdo),
            Self::RpdoLong { pdo, .. } => (8, pdo),
            Self::TpdoRequest { pdo } => (9, pdo),
            Self::TpdoOff { pdo } => (10, pdo),
            Self::SyncMissing { pdo: AwaitsSync::Rpdo(pdo), .. } => (11, pdo),
            Self::SyncMissing { pdo: AwaitsSync::Tpdo(pdo), .. } => (12, pdo),
            Self::SdoOverwritten { pdo, .. } => (13, pdo),
            Self::SameIdentifier { .. } => (14, PdoNumber::P1),
            Self::RpdoWithoutNode { pdo, .. } => (15, pdo),
        };
        let place = match pdo.number() {
            number @ 0..=3 => number.saturating_sub(1),
            4.. => 3,
        };
        1 << (kind * 4 + place)
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
            Self::TpdoOff { pdo } => write!(
                f,
                "remote request of TPDO{pdo} ignored: it is off or has another identifier; write its COB-ID ({}:01), or ask the \
                 one that it has",
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
            Self::RpdoLong { pdo, expected, got } => write!(
                f,
                "hint: RPDO{pdo} has {}, its mapping needs {expected} ({}): the others have no effect; map what they are for",
                Octets(usize::from(*got)),
                pdo.object(0x1600)
            ),
            Self::RpdoWithoutNode { pdo, got, usual } => write!(
                f,
                "hint: a frame with {got:03X}h, the identifier of RPDO{pdo} without a node number, has no effect; send {usual:03X}h"
            ),
            Self::SdoOverwritten { pdo, at } => write!(
                f,
                "hint: {at} was written by SDO, and RPDO{pdo}, which carries it ({}), has put the old value back; write it by one \
                 of them only",
                pdo.object(0x1600)
            ),
            Self::SameIdentifier { pdo, other, id } => write!(
                f,
                "hint: {pdo} and {other} have the same identifier {id:03X}h: receivers cannot tell their frames apart; write another \
                 COB-ID to one of them"
            ),
            Self::SyncMissing { pdo, sync } => {
                write!(f, "{pdo}, and none comes with the identifier {sync:03X}h (1005h); {}", pdo.cure())
            }
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
            Self::State { from, to, cause } => {
                write!(f, "NMT state {from} -> {to}")?;
                match cause {
                    NmtCause::Start | NmtCause::Master => Ok(()),
                    NmtCause::Application => f.write_str(": the device wants it"),
                    NmtCause::ErrorBehaviour => f.write_str(
                        ": its reaction to a communication error (1029h:01); remove the error, then send NMT 01h (start)",
                    ),
                }
            }
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
                write!(
                    f,
                    "RPDO{pdo} ignored: it has {}, expected {expected} by its mapping ({}); send {}, or map fewer objects",
                    Octets(usize::from(*got)),
                    pdo.object(0x1600),
                    Octets(usize::from(*expected))
                )
            }
            Self::RpdoRefused { pdo, refusal } => write!(f, "RPDO{pdo}: {refusal}"),
            Self::Emergency { code, register, octets, names } => {
                write!(f, "EMCY {code:04X}h sent")?;
                if let Some(name) = (names.emcy)(*code, *octets) {
                    write!(f, ", {name}")?;
                }
                write!(f, "; error register {register:02X}h")?;
                names.set_in(*register).try_for_each(|name| write!(f, ", {name}"))
            }
            Self::LifeGuardingExpired { guard_time, factor } => write!(
                f,
                "node guarding lost: no guarding request came within {:?} (guard time 100Ch: {guard_time:?}, life time factor \
                 100Dh: {factor}); let the master send one each {guard_time:?}, or write 100Ch = 0",
                guard_time.saturating_mul(u32::from(*factor))
            ),
            Self::LifeGuardingBack => f.write_str("guarding requests come again"),
            Self::HeartbeatLost { node, time, sub } => write!(
                f,
                "heartbeat of node {node} is missing: none came within {time:?} (1016h:{sub:02X}); check that it runs, and that its \
                 period (1017h) is shorter"
            ),
            Self::HeartbeatBack(node) => write!(f, "heartbeat of node {node} is back"),
            Self::SegmentsMissed { at, taken, number } => write!(
                f,
                "SDO block download of {at}: segment {} is missing, the last one that came has the number {number}; number them from \
                 1 in each block, and send those behind {taken} again",
                taken.saturating_add(1)
            ),
            Self::LssRefused(refusal) => refusal.fmt(f),
            Self::FramesLost { count } => write!(f, "{count} frames were not taken in time and are lost"),
        }
    }
}
