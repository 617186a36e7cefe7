//! The master in this program on CANopen: a participant of the bus, with a client for each node that it was asked about.

use core::time::Duration;
use std::collections::{BTreeMap, VecDeque};

use super::commanded::in_words;
use super::number_of;
use crate::can_bus::can::{ErrorState, Frame};
use crate::can_bus::canopen::nmt::{Command, NmtState, Reset};
use crate::can_bus::canopen::{Abort, Address, NodeId, cob_id};
use crate::client::{NodeClient, NodeGoal, NodeLimits, NodeOutcome, NodeTrouble};
use crate::devices::CanopenEvent;
use crate::explain::hex;
use crate::face::operation::Verb;
use crate::host::can::CanParticipant;
use crate::host::inner_master::{Asked, InnerMaster, Order, Place};
use crate::time::Instant;

/// A master that has not spoken to a node for so long does not own it.
const GONE: Duration = Duration::from_secs(2);

/// Octets of an entry whose length nobody tells.
const USUAL_LENGTH: usize = 4;

/// The master on a bus of CAN. Its [`look`](Self::look) takes what it was asked.
pub(crate) struct InnerNodes {
    board: InnerMaster,
    nodes: Vec<Commanded>,
    out: VecDeque<Frame>,
    /// When another master spoke to a node last.
    others: BTreeMap<u8, Instant>,
}

/// A node that it was asked about.
struct Commanded {
    node: NodeId,
    client: NodeClient,
    order: Option<(u64, String)>,
    access: Option<Access>,
    /// It is let go when this is done.
    leaves: bool,
}

#[derive(Clone, Copy)]
enum Access {
    Read(Address),
    /// Read first: the answer tells the length.
    Write(Address, i64),
    Written(Address),
}

impl InnerNodes {
    /// A master that is silent until it is asked something.
    pub(crate) const fn new(board: InnerMaster) -> Self {
        Self { board, nodes: Vec::new(), out: VecDeque::new(), others: BTreeMap::new() }
    }

    /// Takes what it was asked.
    pub(crate) fn look(&mut self, now: Instant) {
        while let Some(order) = self.board.next() {
            self.carry_out(now, &order);
        }
        self.settle(now);
    }

    fn carry_out(&mut self, now: Instant, order: &Order) {
        let &Order { number, address, ref asked, .. } = order;
        let what = in_words(asked, |place| entry(place).to_string());
        let begun = self.begin(now, address, asked);
        let Some(commanded) = self.nodes.iter_mut().find(|one| one.node.number() == address) else {
            let outcome = begun.map(|done| done.unwrap_or_default());
            self.board.show(address, |shown| shown.end(number, what, outcome));
            return;
        };
        match begun {
            Ok(None) => {
                commanded.order = Some((number, what.clone()));
                self.board.show(address, |shown| {
                    shown.taken = true;
                    shown.doing = Some(what);
                });
            }
            Ok(Some(text)) => self.board.show(address, |shown| {
                shown.taken = true;
                shown.end(number, what, Ok(text));
            }),
            Err(why) => self.board.show(address, |shown| shown.end(number, what, Err(why))),
        }
    }

    /// Begins what is asked: what came of it if that is known at once.
    fn begin(&mut self, now: Instant, address: u8, asked: &Asked) -> Result<Option<String>, String> {
        let node = NodeId::new(address).map_err(|error| error.to_string())?;
        if let Some(heard) = self.others.get(&address)
            && now.saturating_since(*heard) < GONE
        {
            return Err(format!(
                "another master speaks to node {address}; end it, then ask again {} s later",
                GONE.as_secs()
            ));
        }
        if *asked == Asked::Leave {
            return Ok(self.leave(now, node));
        }
        let place = match self.nodes.iter().position(|one| one.node == node) {
            Some(place) => place,
            None => {
                let client = NodeClient::new(node, NodeLimits::default());
                self.nodes.push(Commanded { node, client, order: None, access: None, leaves: false });
                self.nodes.len() - 1
            }
        };
        let Some(commanded) = self.nodes.get_mut(place) else { return Ok(None) };
        match asked {
            Asked::Take => Ok(Some("nothing is sent until something is asked".into())),
            Asked::Leave => Ok(None),
            Asked::Outputs(_) => Err("a node has no outputs of its own: write its objects".into()),
            Asked::Act(act, value) => {
                let value = number_of(act, *value)?;
                match goal(act.verb, value) {
                    Ok(goal) => commanded.client.pursue(now, goal),
                    Err(Some(command)) => {
                        self.out.push_back(command.frame(Some(node)));
                        let text = format!("sent 000 {:02X} {:02X}", command.octet(), node.number());
                        self.board.show(address, |shown| {
                            shown.send(now, frame_in_words(&command.frame(Some(node))))
                        });
                        return Ok(Some(text));
                    }
                    Err(None) => return Err(format!("a node has no '{}'", act.key)),
                }
                Ok(None)
            }
            Asked::Read(place) => {
                let at = entry(*place);
                commanded.client.read(now, at);
                commanded.access = Some(Access::Read(at));
                Ok(None)
            }
            Asked::Write(place, value) => {
                let at = entry(*place);
                if value.fract() != 0.0 || !(-2f64.powi(63)..2f64.powi(63)).contains(value) {
                    return Err(format!("{at} takes a whole number, got {value}"));
                }
                #[expect(clippy::cast_possible_truncation, reason = "whole and within 64 bits")]
                let value = *value as i64;
                commanded.client.read(now, at);
                commanded.access = Some(Access::Write(at, value));
                Ok(None)
            }
        }
    }

    /// Begins to let a node go.
    fn leave(&mut self, now: Instant, node: NodeId) -> Option<String> {
        let Some(commanded) = self.nodes.iter_mut().find(|one| one.node == node) else {
            return Some("the master has not spoken to it".into());
        };
        commanded.client.pursue(now, NodeGoal::Leave);
        commanded.access = None;
        commanded.leaves = true;
        None
    }

    /// Sends what waits, and tells what is over.
    fn settle(&mut self, now: Instant) {
        for commanded in &mut self.nodes {
            let address = commanded.node.number();
            loop {
                while let Some(frame) = commanded.client.poll_transmit() {
                    // Guarding comes again and again.
                    if !frame.is_remote() && !is_look(&frame) {
                        self.board.show(address, |shown| shown.send(now, frame_in_words(&frame)));
                    }
                    self.out.push_back(frame);
                }
                let Some(outcome) = commanded.client.poll_outcome() else { break };
                let Some(outcome) = commanded.over(now, outcome) else { continue };
                let Some((number, what)) = commanded.order.take() else { break };
                let leaves = commanded.leaves;
                self.board.show(address, |shown| {
                    shown.end(number, what, outcome);
                    shown.taken = !leaves;
                });
            }
        }
        self.nodes.retain(|commanded| !commanded.leaves || commanded.order.is_some());
    }
}

impl Commanded {
    /// What came of the order; `None`: it goes on.
    fn over(&mut self, now: Instant, outcome: NodeOutcome) -> Option<Result<String, String>> {
        let access = self.access.take();
        match (outcome, access) {
            (NodeOutcome::Read(octets, len), Some(Access::Write(at, value))) => {
                debug_assert!(len <= octets.len());
                self.write(now, at, value, len)
            }
            (
                NodeOutcome::Failed(NodeTrouble::Refused { code: Abort::WRITE_ONLY, .. }),
                Some(Access::Write(at, value)),
            ) => self.write(now, at, value, USUAL_LENGTH),
            (NodeOutcome::Read(octets, len), Some(Access::Read(at) | Access::Written(at))) => {
                Some(Ok(shown(at, octets.get(..len).unwrap_or_default())))
            }
            (NodeOutcome::Written, Some(Access::Written(at))) => Some(Ok(format!("{at} is written"))),
            (NodeOutcome::Failed(trouble), _) => Some(Err(trouble.to_string())),
            (NodeOutcome::Read(..) | NodeOutcome::Written | NodeOutcome::Done, _) => Some(Ok("done".into())),
        }
    }

    fn write(&mut self, now: Instant, at: Address, value: i64, len: usize) -> Option<Result<String, String>> {
        let octets = value.to_le_bytes();
        let (octets, rest) = octets.split_at(len.clamp(1, octets.len()));
        let negative = octets.last().is_some_and(|octet| octet & 0x80 != 0);
        let fits =
            rest.iter().all(|octet| *octet == 0) || negative && rest.iter().all(|octet| *octet == 0xFF);
        if !fits {
            return Some(Err(format!("{at} has {len} octets, {value} does not fit")));
        }
        self.client.write(now, at, octets);
        self.access = Some(Access::Written(at));
        None
    }
}

impl CanParticipant for InnerNodes {
    type Event = CanopenEvent;

    fn handle_frame(&mut self, now: Instant, frame: &Frame) {
        if let Some(node) = spoken_to(frame) {
            self.others.insert(node, now);
        }
        self.nodes.iter_mut().for_each(|commanded| commanded.client.handle_frame(now, frame));
        self.settle(now);
    }

    fn handle_timeout(&mut self, now: Instant) {
        self.nodes.iter_mut().for_each(|commanded| commanded.client.handle_timeout(now));
        self.settle(now);
    }

    fn set_error_state(&mut self, _now: Instant, _state: ErrorState) {}

    fn poll_transmit(&mut self, _now: Instant) -> Option<Frame> {
        self.out.pop_front()
    }

    fn poll_event(&mut self) -> Option<CanopenEvent> {
        None
    }

    fn poll_timeout(&self) -> Option<Instant> {
        let due = |commanded: &Commanded| commanded.client.poll_timeout();
        self.nodes.iter().map(due).fold(None, Instant::first_of)
    }
}

/// The goal of an act, or the command of NMT that it is.
const fn goal(verb: Verb, value: i32) -> Result<NodeGoal, Option<Command>> {
    Err(Some(match verb {
        Verb::Enable => return Ok(NodeGoal::Enable),
        Verb::Disable => return Ok(NodeGoal::Leave),
        Verb::Acknowledge => return Ok(NodeGoal::Acknowledge),
        Verb::Stop => return Ok(NodeGoal::Stop),
        Verb::Move => return Ok(NodeGoal::MoveTo(value)),
        Verb::Home => return Ok(NodeGoal::Home),
        Verb::Turn(mode, target) => return Ok(NodeGoal::Turn { mode, target, velocity: value }),
        Verb::Inch(word) => return Ok(NodeGoal::Inch { word }),
        Verb::NmtStart => Command::Enter(NmtState::Operational),
        Verb::NmtStop => Command::Enter(NmtState::Stopped),
        Verb::NmtPreOperational => Command::Enter(NmtState::PreOperational),
        Verb::NmtResetNode => Command::Reset(Reset::Node),
        Verb::NmtResetCommunication => Command::Reset(Reset::Communication),
        Verb::JogPositive | Verb::JogNegative | Verb::Velocity | Verb::Speed => return Err(None),
    }))
}

fn entry(place: Place) -> Address {
    Address::new(place.number, place.sub.unwrap_or(0))
}

/// The node that a frame of a master is for.
fn spoken_to(frame: &Frame) -> Option<u8> {
    let id = u16::try_from(frame.id().number()).ok()?;
    let node = u8::try_from(id & 0x7F).ok()?;
    match (id & !0x7F, frame.octets()) {
        (cob_id::SDO_CLIENT, _) => Some(node),
        (cob_id::NMT, &[_, of]) if id == cob_id::NMT && of != 0 => Some(of),
        _ => None,
    }
}

/// Whether a frame only asks for a status word, which is done until a step is over.
fn is_look(frame: &Frame) -> bool {
    matches!(frame.octets(), [0x40, 0x41, 0x60, ..])
}

/// An SDO request or a command of NMT in words.
fn frame_in_words(frame: &Frame) -> String {
    let raw = format!("{:03X} {}", frame.id().number(), hex(frame.octets()));
    let meant = match *frame.octets() {
        [command, low, high, sub, ref data @ ..] => {
            let at = Address::new(u16::from_le_bytes([low, high]), sub);
            let free = usize::from(command >> 2 & 3);
            match command >> 5 {
                2 => format!("read {at}"),
                1 => {
                    let octets = data.get(..data.len().saturating_sub(free)).unwrap_or_default();
                    format!("{at} = {}h", number_in_hex(octets))
                }
                _ => "SDO".into(),
            }
        }
        [0x01, node] => format!("NMT start of node {node}"),
        [0x02, node] => format!("NMT stop of node {node}"),
        [0x80, node] => format!("NMT pre-operational of node {node}"),
        [0x81, node] => format!("NMT reset of node {node}"),
        [0x82, node] => format!("NMT reset communication of node {node}"),
        _ => return raw,
    };
    format!("{raw}  {meant}")
}

/// A number whose octets come low octet first.
fn number_in_hex(octets: &[u8]) -> String {
    octets.iter().rev().map(|octet| format!("{octet:02X}")).collect()
}

/// The value of an entry, low octet first.
fn shown(at: Address, octets: &[u8]) -> String {
    match octets.len() {
        1..=8 => {
            let number = octets.iter().rev().fold(0_u64, |number, octet| number << 8 | u64::from(*octet));
            let unused = 64 - 8 * octets.len();
            let signed = (number << unused).cast_signed() >> unused;
            let signed = if signed < 0 { format!(" or {signed}") } else { String::new() };
            format!("{at} = {number}{signed} ({}h)", number_in_hex(octets))
        }
        _ => {
            let text: String =
                octets.iter().map(|octet| char::from(*octet)).filter(|one| !one.is_control()).collect();
            format!("{at} = '{text}'")
        }
    }
}
