//! What is odd on a bus of CANopen: said once, as a hint. A hint hides no event and changes nothing.

use core::fmt;

use crate::can_bus::can::{Frame, Id};
use crate::can_bus::canopen::{NodeId, cob_id};
use crate::face::hint::{PAUSE, is_due};
use crate::host::ranges::Ranges;
use crate::time::Instant;

/// So many numbers are told in a [`PAUSE`]; a master that asks more of them looks around.
const TOLD: u8 = 4;

/// Something odd about a bus. `Display` is one line of plain English: what, where, and what to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum BusHint {
    /// A master asks a node that is not there.
    NobodyThere {
        /// How.
        request: NodeRequest,
        /// Whom.
        asked: NodeId,
        /// Who is there.
        there: Numbers,
    },
    /// A frame for a node of ours has an identifier of 29 bits.
    Wide {
        /// The identifier.
        id: u32,
        /// The node whose it is with 11 bits.
        node: NodeId,
    },
    /// An NMT command whose two octets are exchanged.
    NmtExchanged {
        /// For which node.
        node: NodeId,
        /// The command.
        command: u8,
    },
    /// An NMT command for a node that cannot be.
    NmtNode {
        /// The command.
        command: u8,
        /// The number, above 127.
        node: u8,
    },
    /// NMT commands are remote frames.
    NmtRemote,
    /// An SDO request without a node number in its identifier.
    SdoWithoutNode {
        /// Who is there.
        there: Numbers,
    },
    /// A master sends with an identifier of a node of ours.
    OfNode {
        /// The identifier.
        id: u16,
        /// The node.
        node: NodeId,
        /// What a master has for that node instead.
        instead: u16,
    },
}

/// What a master wants of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum NodeRequest {
    /// Service data.
    Sdo,
    /// A command of network management.
    Nmt,
}

/// A set of node numbers. `Display`: `3, 5 to 8`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Numbers(u128);

/// What was heard of the nodes of a bus, and what was said of it. Its size is fixed.
#[derive(Clone, Debug)]
pub struct NodeWatch {
    /// So many requests without an answer are too many.
    patience: u8,
    /// Who was heard.
    heard: Numbers,
    /// Requests to each number since it was heard last.
    asked: [u8; 128],
    /// The numbers for which that was said.
    said: Numbers,
    /// How many of them since when.
    told: (u8, Instant),
    wide_said: Option<Instant>,
    exchanged_said: Option<Instant>,
    of_node_said: Option<Instant>,
}

impl Numbers {
    /// These.
    pub fn of(nodes: impl IntoIterator<Item = NodeId>) -> Self {
        let mut all = Self::default();
        nodes.into_iter().for_each(|node| all.0 |= bit(node));
        all
    }

    /// Whether this one is among them.
    pub(crate) const fn contains(self, node: NodeId) -> bool {
        self.0 & bit(node) != 0
    }

    const fn put(&mut self, node: NodeId, there: bool) {
        if there {
            self.0 |= bit(node);
        } else {
            self.0 &= !bit(node);
        }
    }
}

const fn bit(node: NodeId) -> u128 {
    1 << node.number()
}

impl NodeWatch {
    /// Of a bus in memory: who is not `there` is nowhere, and the first request says so.
    pub const fn inside() -> Self {
        Self::new(1)
    }

    /// Of a bus that goes on outside: other nodes may be there and not have been heard yet. The third request in vain says
    /// that nobody is.
    pub const fn outside() -> Self {
        Self::new(3)
    }

    const fn new(patience: u8) -> Self {
        let none = Numbers(0);
        Self {
            patience,
            heard: none,
            asked: [0; 128],
            said: none,
            told: (0, Instant::ZERO),
            wide_said: None,
            exchanged_said: None,
            of_node_said: None,
        }
    }

    /// A frame that nodes do not send themselves ([`Event::Passed`](super::Event::Passed) by a port). `there`: the nodes of
    /// ours. A hint for a number comes once until a node with that number is there.
    pub fn heard(&mut self, now: Instant, frame: &Frame, there: impl Fn() -> Numbers) -> Option<BusHint> {
        let id = match frame.id() {
            Id::Base(id) => id,
            Id::Extended(_) => return self.wide(now, frame.id().number(), there),
        };
        if frame.is_remote() {
            let is_nmt = id.number() == cob_id::NMT;
            return (is_nmt && is_due(&mut self.exchanged_said, now)).then_some(BusHint::NmtRemote);
        }
        let service = id.number() & !0x7F;
        let [low, _] = id.number().to_le_bytes();
        let node = NodeId::new(low & 0x7F).ok();
        match (service, node) {
            (cob_id::SDO_CLIENT, Some(node)) => self.asked(now, NodeRequest::Sdo, node, there),
            (cob_id::NMT, None) => {
                let &[command, node] = frame.octets() else { return None };
                if let Some(hint) = exchanged([command, node], &there) {
                    return is_due(&mut self.exchanged_said, now).then_some(hint);
                }
                match NodeId::new(node) {
                    Ok(node) => self.asked(now, NodeRequest::Nmt, node, there),
                    Err(_) if node == 0 => None,
                    Err(_) => {
                        is_due(&mut self.exchanged_said, now).then_some(BusHint::NmtNode { command, node })
                    }
                }
            }
            (cob_id::SDO_CLIENT, None) => is_due(&mut self.of_node_said, now)
                .then(|| BusHint::SdoWithoutNode { there: Numbers(there().0 | self.heard.0) }),
            (cob_id::SDO_SERVER | cob_id::TPDO_1, Some(node)) if there().contains(node) => {
                let instead = if service == cob_id::SDO_SERVER { cob_id::SDO_CLIENT } else { cob_id::RPDO_1 };
                let instead = instead + u16::from(node.number());
                is_due(&mut self.of_node_said, now).then_some(BusHint::OfNode {
                    id: id.number(),
                    node,
                    instead,
                })
            }
            (cob_id::SDO_SERVER | cob_id::ERROR_CONTROL | cob_id::EMCY, Some(node)) => {
                self.heard.put(node, true);
                self.is_there(node);
                None
            }
            (_, Some(_) | None) => None,
        }
    }

    /// A frame of 29 bits is for no node of CANopen; one whose number is that of a service of ours was meant for it.
    #[cold]
    fn wide(&mut self, now: Instant, id: u32, there: impl FnOnce() -> Numbers) -> Option<BusHint> {
        let short = u16::try_from(id).ok().filter(|id| *id <= 0x7FF)?;
        let [low, _] = short.to_le_bytes();
        let node = NodeId::new(low & 0x7F).ok().filter(|node| there().contains(*node))?;
        is_due(&mut self.wide_said, now).then_some(BusHint::Wide { id, node })
    }

    fn asked(
        &mut self,
        now: Instant,
        request: NodeRequest,
        asked: NodeId,
        there: impl FnOnce() -> Numbers,
    ) -> Option<BusHint> {
        if self.heard.contains(asked) {
            return None;
        }
        let there = there();
        if there.contains(asked) {
            self.is_there(asked);
            return None;
        }
        let times = self.asked.get_mut(usize::from(asked.number()))?;
        *times = times.saturating_add(1);
        if *times < self.patience || self.said.contains(asked) || !self.may_tell(now) {
            return None;
        }
        self.said.put(asked, true);
        Some(BusHint::NobodyThere { request, asked, there: Numbers(there.0 | self.heard.0) })
    }

    /// What was said of this number is no longer so.
    fn is_there(&mut self, node: NodeId) {
        self.said.put(node, false);
        if let Some(times) = self.asked.get_mut(usize::from(node.number())) {
            *times = 0;
        }
    }

    /// Whether one more may be told now; it counts as told then.
    fn may_tell(&mut self, now: Instant) -> bool {
        let (count, since) = &mut self.told;
        if *count == 0 || now.saturating_since(*since) >= PAUSE {
            self.told = (1, now);
            return true;
        }
        let may = *count < TOLD;
        *count += u8::from(may);
        may
    }
}

/// A command that is none, for a number that is one, where the command is a node of ours.
fn exchanged([command, node]: [u8; 2], there: &impl Fn() -> Numbers) -> Option<BusHint> {
    let is_command = |octet| matches!(octet, 0x01 | 0x02 | 0x80..=0x82);
    let meant = NodeId::new(command).ok().filter(|_| is_command(node) && !is_command(command))?;
    there().contains(meant).then_some(BusHint::NmtExchanged { node: meant, command: node })
}

impl fmt::Display for BusHint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (request, asked, there) = match self {
            Self::NobodyThere { request, asked, there } => (request, asked, there),
            Self::NmtExchanged { node, command } => {
                return write!(
                    f,
                    "hint: the octets of the NMT command {:02X} {command:02X} seem to be exchanged: {command:02X} {:02X} was \
                     meant, command and node {node}",
                    node.number(),
                    node.number()
                );
            }
            Self::NmtNode { command, node } => {
                return write!(
                    f,
                    "hint: NMT command {command:02X}h is for node {node}: expected 1 to 127, or 0 for all; send the number of a node"
                );
            }
            Self::NmtRemote => {
                return f.write_str(
                    "hint: a remote frame with the identifier of NMT (000h) is ignored: send a data frame of two octets, command and \
                     node",
                );
            }
            Self::SdoWithoutNode { there } => {
                f.write_str("hint: an SDO request with 600h has no node number; ")?;
                return match NodeId::new(u8::try_from(there.0.trailing_zeros()).unwrap_or(0)) {
                    Ok(first) => write!(
                        f,
                        "send {:03X}h for node {first}",
                        cob_id::SDO_CLIENT + u16::from(first.number())
                    ),
                    Err(_) => f.write_str("no node is on this bus"),
                };
            }
            Self::OfNode { id, node, instead } => {
                return write!(
                    f,
                    "hint: a master sends a frame with {id:03X}h, which is the identifier of a frame of node {node} itself; \
                     send {instead:03X}h"
                );
            }
            Self::Wide { id, node } => {
                return write!(
                    f,
                    "hint: node {node} ignores a frame with the identifier {id:08X}h of 29 bits: CANopen has identifiers of 11 \
                     bits; send {id:03X}h as a standard frame"
                );
            }
        };
        let what = match request {
            NodeRequest::Sdo => "is asked (SDO)",
            NodeRequest::Nmt => "is commanded (NMT)",
        };
        write!(f, "hint: node {asked} {what} but not there; ")?;
        if there.0 == 0 {
            return f.write_str("no node is on this bus");
        }
        write!(
            f,
            "nodes on this bus: {there}; change the node number in the master's project or that of the node"
        )
    }
}

impl fmt::Display for Numbers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        Ranges(self.0).fmt(f)
    }
}

#[cfg(test)]
mod tests {

    use super::*;

    const NOW: Instant = Instant::from_millis(1000);

    fn node(number: u8) -> NodeId {
        NodeId::new(number).unwrap()
    }

    fn ours() -> Numbers {
        Numbers::of([node(5), node(6)])
    }

    fn frame(id: u16, octets: &[u8]) -> Frame {
        Frame::data(Id::base(id).unwrap(), octets).unwrap()
    }

    fn said(watch: &mut NodeWatch, now: Instant, frame: &Frame) -> Option<String> {
        watch.heard(now, frame, ours).map(|hint| hint.to_string())
    }

    const HINT: &str = "but not there; nodes on this bus: 5, 6; change the node number in the master's project or that of the node";

    #[test]
    fn an_absent_node_is_told_once_for_each_number() {
        let mut watch = NodeWatch::inside();
        let sdo = frame(0x609, &[0x40, 0, 0x10, 0, 0, 0, 0, 0]);
        assert_eq!(said(&mut watch, NOW, &sdo), Some(format!("hint: node 9 is asked (SDO) {HINT}")));
        for _ in 0..1000 {
            assert_eq!(said(&mut watch, NOW, &sdo), None);
            assert_eq!(said(&mut watch, NOW, &frame(0, &[1, 9])), None, "the other way to ask it");
        }
        let nmt = said(&mut watch, NOW, &frame(0, &[1, 10]));
        assert_eq!(nmt, Some(format!("hint: node 10 is commanded (NMT) {HINT}")));
    }

    #[test]
    fn what_is_for_a_node_that_is_there_or_for_all_is_not_odd() {
        let mut watch = NodeWatch::inside();
        let remote = Frame::remote(Id::base(0x609).unwrap(), 8).unwrap();
        let long = Frame::data(Id::extended(0x609).unwrap(), &[0x40]).unwrap();
        for frame in [
            frame(0x605, &[0x40, 0, 0x10, 0, 0, 0, 0, 0]),
            frame(0, &[1, 6]),
            frame(0, &[1, 0]),
            frame(0, &[1]),
            frame(0x209, &[1, 2]),
            frame(0x080, &[]),
            frame(0x7E4, &[4]),
            remote,
            long,
        ] {
            assert_eq!(said(&mut watch, NOW, &frame), None, "{frame}");
        }
    }

    #[test]
    fn on_a_bus_that_goes_on_outside_the_third_request_in_vain_is_told() {
        let mut watch = NodeWatch::outside();
        let sdo = |number: u16| frame(0x600 + number, &[0x40]);
        let told: Vec<bool> = (0..5).map(|_| said(&mut watch, NOW, &sdo(9)).is_some()).collect();
        assert_eq!(told, [false, false, true, false, false]);
        // Node 10 answers late, node 11 boots, node 12 sends an emergency.
        for (number, answer) in [(10, 0x58A), (11, 0x70B), (12, 0x08C)] {
            assert_eq!(said(&mut watch, NOW, &sdo(number)), None);
            assert_eq!(said(&mut watch, NOW, &frame(answer, &[0; 8])), None);
            assert!((0..9).all(|_| said(&mut watch, NOW, &sdo(number)).is_none()));
        }
        let all = (0..3).filter_map(|_| said(&mut watch, NOW, &sdo(20))).next().unwrap();
        assert!(all.contains("nodes on this bus: 5, 6, 10 to 12;"), "{all}");
    }

    #[test]
    fn a_number_that_was_there_meanwhile_is_told_again() {
        let mut watch = NodeWatch::inside();
        let sdo = frame(0x609, &[0x40]);
        let nine = || Numbers::of([node(9)]);
        assert!(watch.heard(NOW, &sdo, ours).is_some());
        assert!(watch.heard(NOW, &sdo, nine).is_none());
        assert!(watch.heard(NOW, &sdo, ours).is_some());
    }

    #[test]
    fn of_a_master_that_looks_around_four_are_told_in_a_pause() {
        let mut watch = NodeWatch::inside();
        let mut scan = |now| {
            let told =
                (1..=127).filter(|number| said(&mut watch, now, &frame(0x600 + number, &[0x40])).is_some());
            told.count()
        };
        assert_eq!(scan(NOW), 4);
        assert_eq!(scan(NOW.saturating_add(PAUSE / 2)), 0);
        assert_eq!(scan(NOW.saturating_add(PAUSE)), 4);
    }

    #[test]
    fn a_bus_without_nodes_has_none_to_name() {
        let mut watch = NodeWatch::inside();
        let hint = watch.heard(NOW, &frame(0, &[0x81, 9]), Numbers::default).unwrap();
        assert_eq!(hint.to_string(), "hint: node 9 is commanded (NMT) but not there; no node is on this bus");
    }
}
