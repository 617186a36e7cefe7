//! The faults on purpose of a bus with nodes, to change them while it runs.

use super::{Bus, Seat, StoredNode};
use crate::can_bus::canopen::NodeId;
use crate::can_bus::canopen::faults::{MAX_FAULTS, TooMany};
use crate::devices::CanopenEvent;
use crate::host::fault::{Kind, Listed, Rule};
use crate::time::Instant;

/// The faults of a bus with nodes: those of frames act on the bus, those of nodes in each [`StoredNode`] they are for.
impl Bus<CanopenEvent> {
    /// Adds a fault behind the others: to the nodes it is for and are there, and by
    /// `add_faults_to` to those that come. Returns its number, by which it is removed. A node named
    /// by the fault is the one that has this number now.
    ///
    /// # Errors
    /// [`TooMany`]; nothing is changed then.
    pub fn add_fault(&mut self, now: Instant, rule: Rule) -> Result<u32, TooMany> {
        if self.faults().iter().count() >= MAX_FAULTS {
            return Err(TooMany);
        }
        let number = self.faults_mut().add(now, rule);
        self.reseat_faults();
        for (seat, _) in nodes(self) {
            // A node has those of this list only.
            let _ = self.with(now, seat, |node: &mut StoredNode, now| add(now, node, number, rule));
        }
        Ok(number)
    }

    /// Gives a node that is not on the bus yet what is for it, so that its boot-up is concerned, and the board of the bus.
    pub(crate) fn add_faults_to(&self, now: Instant, node: &mut StoredNode) {
        for Listed { number, rule, .. } in self.faults().iter() {
            add(now, node, number, rule);
        }
        if let Some(board) = &self.board {
            node.show_on(board.clone());
        }
    }

    /// Nodes have come, gone, or changed their numbers: faults of the frames of one are for whoever has its number now.
    pub(crate) fn reseat_faults(&mut self) {
        let seats = nodes(self);
        let seat_of =
            |node| seats.iter().find(|(_, there)| *there == node).map_or(Seat::NOBODY, |(seat, _)| *seat);
        self.faults_mut().seat(|rule| rule.node().map(seat_of));
    }

    /// Ends a fault. `None`: there is none of this number.
    pub(crate) fn remove_fault(&mut self, now: Instant, number: u32) -> Option<Rule> {
        let rule = self.faults_mut().remove(number)?;
        for (seat, _) in nodes(self) {
            self.with(now, seat, |node: &mut StoredNode, _| node.remove_fault(number));
        }
        Some(rule)
    }

    /// Each fault with its number and how often it was injected, on the bus and in all nodes together.
    pub(crate) fn list_faults(&self) -> Vec<Listed> {
        let seats = nodes(self);
        let in_nodes = |number| {
            let nodes = seats.iter().filter_map(|(seat, _)| self.participant::<StoredNode>(*seat));
            nodes.map(|node| node.injected(number)).fold(0, u32::saturating_add)
        };
        let all = |on_bus: Listed| {
            let injected = on_bus.injected.saturating_add(in_nodes(on_bus.number));
            Listed { injected, ..on_bus }
        };
        self.faults().iter().map(all).collect()
    }
}

/// Gives a node a fault that is for it.
fn add(now: Instant, node: &mut StoredNode, number: u32, rule: Rule) {
    let Kind::Node(kind) = rule.kind else { return };
    if rule.node().is_none_or(|wanted| wanted == node.node_id()) {
        let _ = node.add_fault(now, number, kind, rule.when);
    }
}

/// The nodes of a bus with the numbers they have now.
fn nodes(bus: &Bus<CanopenEvent>) -> Vec<(Seat, NodeId)> {
    bus.seats().filter_map(|seat| Some((seat, bus.participant::<StoredNode>(seat)?.node_id()))).collect()
}
