//! What the thread of a bus of CAN lends to the threads of HTTP.

use axum::extract::FromRequestParts;
use axum::http::StatusCode;
use axum::http::request::Parts;

use super::super::faults::FaultAccess;
use super::super::inputs::{Acted, PowerName, Stations};
use super::super::problem::{PathOf, Problem};
use super::super::queue::{self, Lends};
use crate::can_bus::canopen::NodeId;
use crate::devices::{CanopenDevice, CanopenEvent};
use crate::face::Surroundings;
use crate::host::StateDir;
use crate::host::can::{Bus, Product, Seat, StoredNode};
use crate::host::fault::{BusKind, Rule};
use crate::host::list::Choices;
use crate::time::Instant;

/// A node and where it is on the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Seated {
    /// Its seat; a [`StoredNode`] is there.
    pub seat: Seat,
    /// Which device it is.
    pub product: &'static Product,
}

/// What the panel may see and change, lent by the thread of the bus between two frames.
pub struct NodeAccess<'a> {
    /// The time now.
    pub now: Instant,
    /// The bus.
    pub bus: &'a mut Bus<CanopenEvent>,
    /// The nodes on it.
    pub nodes: &'a mut Vec<Seated>,
    /// Where a node that is added keeps its EEPROM; `None`: in itself.
    pub state: Option<&'a StateDir>,
    /// What is chosen about every node that is added: its quirks.
    pub choose: &'a dyn Fn(&'static Product, &mut Choices),
}

/// The thread of a bus of CAN.
#[derive(Clone, Copy, Debug)]
pub(super) struct OfNodes;

impl Lends for OfNodes {
    type Access<'a> = NodeAccess<'a>;
}

/// The way to the thread of a bus of CAN.
pub(super) type Asking = queue::Asking<OfNodes>;

impl FaultAccess for NodeAccess<'_> {
    const BUS: BusKind = BusKind::Can;

    fn faults(&self) -> Result<Vec<(u32, Rule, u32)>, Problem> {
        Ok(self.bus.list_faults())
    }

    fn check_fault(&self, rule: &Rule) -> Result<(), Problem> {
        rule.check(self.numbers()).map_err(|error| Problem::value(error.to_string()))
    }

    fn add_fault(&mut self, rule: Rule) -> Result<u32, Problem> {
        self.bus.add_fault(self.now, rule).map_err(Problem::conflict)
    }

    fn remove_fault(&mut self, number: u32) -> Option<Rule> {
        self.bus.remove_fault(self.now, number)
    }
}

impl NodeAccess<'_> {
    /// The numbers of all nodes.
    pub(super) fn numbers(&self) -> impl Iterator<Item = u8> + '_ {
        self.devices().map(|(_, device)| device.node_id().number())
    }

    /// Every node, in the order of the command line.
    pub(super) fn devices(&self) -> impl Iterator<Item = (&'static Product, &dyn CanopenDevice)> {
        self.nodes.iter().filter_map(|Seated { seat, product }| {
            Some((*product, self.bus.participant::<StoredNode>(*seat)?.as_device()))
        })
    }

    /// The node with that number, by its EEPROM or its DIP switches; of two the first.
    ///
    /// # Errors
    /// 404 if there is none, with those that are there.
    pub(super) fn device(&self, node: NodeId) -> Result<(&'static Product, &dyn CanopenDevice), Problem> {
        self.devices().find(|(_, device)| device.node_id() == node).ok_or_else(|| self.no_node(node))
    }

    /// Does something to the node with that number.
    ///
    /// # Errors
    /// 404 if there is none; what `act` says.
    pub(super) fn act<R>(
        &mut self,
        node: NodeId,
        act: impl FnOnce(&'static Product, &mut dyn CanopenDevice, Instant) -> Result<R, Problem>,
    ) -> Result<R, Problem> {
        let is_it = |seated: &&Seated| {
            let there = self.bus.participant::<StoredNode>(seated.seat);
            there.is_some_and(|there| there.node_id() == node)
        };
        let Some(Seated { seat, product }) = self.nodes.iter().find(is_it) else {
            return Err(self.no_node(node));
        };
        let done = self.bus.with(self.now, *seat, |stored: &mut StoredNode, now| {
            stored.act(now, |device, now| act(product, device, now))
        });
        done.unwrap_or_else(|| Err(self.no_node(node)))
    }

    pub(super) fn no_node(&self, node: NodeId) -> Problem {
        let numbers: Vec<_> = self.devices().map(|(_, device)| device.node_id().to_string()).collect();
        Problem::not_found(format!(
            "there is no node {node} on this bus; the nodes are {}",
            numbers.join(", ")
        ))
    }
}

impl Stations for OfNodes {
    fn address(text: &str) -> Result<u8, Problem> {
        number(text).map(NodeId::number)
    }

    fn look<R>(
        access: &NodeAccess<'_>,
        address: u8,
        look: impl FnOnce(&dyn Surroundings) -> R,
    ) -> Result<R, Problem> {
        Ok(look(access.device(node(address)?)?.1))
    }

    fn act<R>(
        access: &mut NodeAccess<'_>,
        address: u8,
        act: impl Fn(&mut dyn Surroundings, &Acted<'_>) -> Result<R, Problem>,
    ) -> Result<R, Problem> {
        let acted = |product: &'static Product, device: &mut dyn CanopenDevice, now| {
            act(device, &Acted { now, device: product.name })
        };
        access.act(node(address)?, acted)
    }

    fn switch(access: &mut NodeAccess<'_>, address: u8, on: bool) -> Result<PowerName, Problem> {
        access.act(node(address)?, |_, device, now| {
            match (on, device.is_on()) {
                (true, false) => device.power_on(now),
                (false, true) => device.power_off(now),
                (true, true) | (false, false) => {}
            }
            Ok(power(device))
        })
    }
}

/// Whether a node is supplied.
pub(super) fn power(device: &dyn CanopenDevice) -> PowerName {
    if device.is_on() { PowerName::On } else { PowerName::Off }
}

fn node(address: u8) -> Result<NodeId, Problem> {
    NodeId::new(address).map_err(Problem::value)
}

/// The node that the path names.
#[derive(Clone, Copy, Debug)]
pub(super) struct Number(pub(super) NodeId);

/// The number in the path.
pub(super) fn number(text: &str) -> Result<NodeId, Problem> {
    let number = text.parse().ok().and_then(|number| NodeId::new(number).ok());
    number.ok_or_else(|| {
        Problem::new(StatusCode::BAD_REQUEST, format!("'{text}' is no node number; expected 1 to 127"))
    })
}

impl<S: Send + Sync> FromRequestParts<S> for Number {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        #[derive(serde::Deserialize)]
        struct OfNode {
            address: String,
        }
        let PathOf(OfNode { address }) = PathOf::from_request_parts(parts, state).await?;
        number(&address).map(Self)
    }
}
