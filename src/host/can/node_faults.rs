//! The faults on purpose of a bus with nodes, to change them while it runs.

use std::vec::Vec;

use super::{Bus, NodeFault, Seat, StoredNode};
use crate::can_bus::canopen::NodeId;
use crate::can_bus::canopen::faults::TooMany;
use crate::devices::CanopenEvent;
use crate::time::Instant;

/// Every fault by its number. Those of frames act on the bus, those of nodes in each [`StoredNode`] they are for.
#[derive(Debug, Default)]
pub struct NodeFaults {
    active: Vec<Active>,
    /// The number of the newest.
    last: u32,
}

#[derive(Debug)]
struct Active {
    number: u32,
    fault: NodeFault,
    /// Its number among the faults of the bus, if it is one of frames.
    of_bus: Option<u32>,
}

impl NodeFaults {
    /// Adds a fault behind the others: to the nodes it is for and are there, and by [`join`](Self::join) to those that come.
    /// Returns its number, by which it is removed. A node named by the fault is the one that has this number now.
    ///
    /// # Errors
    /// [`TooMany`]; nothing is changed then.
    pub fn add(
        &mut self,
        now: Instant,
        bus: &mut Bus<CanopenEvent>,
        fault: NodeFault,
    ) -> Result<u32, TooMany> {
        if self.active.len() >= crate::can_bus::canopen::faults::MAX_FAULTS {
            return Err(TooMany);
        }
        self.last = self.last.saturating_add(1);
        let number = self.last;
        let seats = nodes(bus);
        let of_bus = fault.of_frames().map(|of_frames| {
            let from = fault.node.map(|node| seat_of(&seats, node));
            bus.faults_mut().add(super::fault::Fault { from, ..of_frames })
        });
        self.active.push(Active { number, fault, of_bus });
        if let Some(of_node) = fault.of_node() {
            for (seat, _) in seats.iter().filter(|(_, node)| fault.node.is_none_or(|wanted| wanted == *node))
            {
                // A node has those of this list only.
                let _ = bus.with(now, *seat, |node: &mut StoredNode, now| node.spoil(now, number, of_node));
            }
        }
        Ok(number)
    }

    /// Gives a node that is not on the bus yet what is for it, so that its boot-up is concerned.
    pub fn join(&self, now: Instant, node: &mut StoredNode) {
        let id = node.node_id();
        for Active { number, fault, .. } in &self.active {
            if let Some(of_node) = fault.of_node().filter(|_| fault.node.is_none_or(|wanted| wanted == id)) {
                let _ = node.spoil(now, *number, of_node);
            }
        }
    }

    /// Nodes have come, gone, or changed their numbers: faults of the frames of one are for whoever has its number now.
    pub fn reseat(&self, bus: &mut Bus<CanopenEvent>) {
        let seats = nodes(bus);
        for Active { fault, of_bus, .. } in &self.active {
            if let (Some(node), Some(of_bus)) = (fault.node, of_bus) {
                bus.faults_mut().is_of(*of_bus, seat_of(&seats, node));
            }
        }
    }

    /// Ends a fault. `None`: there is none of this number.
    pub fn remove(&mut self, now: Instant, bus: &mut Bus<CanopenEvent>, number: u32) -> Option<NodeFault> {
        let place = self.active.iter().position(|active| active.number == number)?;
        let Active { fault, of_bus, .. } = self.active.remove(place);
        match of_bus {
            Some(of_bus) => _ = bus.faults_mut().remove(of_bus),
            None => {
                for (seat, _) in nodes(bus) {
                    bus.with(now, seat, |node: &mut StoredNode, _| node.unspoil(number));
                }
            }
        }
        Some(fault)
    }

    /// Ends every fault.
    pub fn clear(&mut self, now: Instant, bus: &mut Bus<CanopenEvent>) {
        while let Some(number) = self.active.first().map(|active| active.number) {
            self.remove(now, bus, number);
        }
    }

    /// Each fault with its number and how often it was injected, in all nodes together.
    pub fn list(&self, bus: &Bus<CanopenEvent>) -> Vec<(u32, NodeFault, u32)> {
        let seats = nodes(bus);
        let injected = |active: &Active| match active.of_bus {
            Some(of_bus) => bus
                .faults()
                .iter()
                .find(|(number, ..)| *number == of_bus)
                .map_or(0, |(_, _, injected)| injected),
            None => {
                let of_node = |(seat, _): &(Seat, NodeId)| {
                    bus.participant::<StoredNode>(*seat).map_or(0, |node| node.injected(active.number))
                };
                seats.iter().map(of_node).fold(0, u32::saturating_add)
            }
        };
        self.active.iter().map(|active| (active.number, active.fault, injected(active))).collect()
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.active.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.active.is_empty()
    }
}

/// The seat of the node with that number.
fn seat_of(seats: &[(Seat, NodeId)], node: NodeId) -> Seat {
    seats.iter().find(|(_, there)| *there == node).map_or(Seat::NOBODY, |(seat, _)| *seat)
}

/// The nodes of a bus with the numbers they have now.
fn nodes(bus: &Bus<CanopenEvent>) -> Vec<(Seat, NodeId)> {
    bus.seats().filter_map(|seat| Some((seat, bus.participant::<StoredNode>(seat)?.node_id()))).collect()
}
