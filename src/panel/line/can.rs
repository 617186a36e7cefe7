//! What the thread of a bus of CAN lends to the threads of HTTP.

use core::any::Any;
use std::collections::BTreeMap;

use super::super::problem::Problem;
use super::super::station::{FaultNow, State};
use super::state::{Counted, Counters, ErrorStateName, LineStation};
use super::{Act, Acted, OnLine, Station, in_one_line, no_station};
use crate::can_bus::can::BitRate;
use crate::can_bus::canopen::node::storage::Eeprom;
use crate::can_bus::canopen::{Address, Index, NmtState, NodeId, dictionary as objects};
use crate::devices::{CanopenDevice, CanopenEvent, Vocabulary};
use crate::face::description::Supply;
use crate::face::{Description, Operation};
use crate::host::can::{Bus, Product, Seat, StoredNode};
use crate::host::fault::{BusKind, Listed, Rule};
use crate::host::list::{Group, Spec};
use crate::host::{Startup, StateDir};
use crate::panel::dictionary;
use crate::panel::objects::whole;
use crate::time::{BaudRate, Instant};

/// The control word of CiA 402.
const CONTROL_WORD: Index = Index(0x6040);
/// What a drive has that can be homed.
const HOMING_METHOD: Index = Index(0x6098);

/// Nodes of a bus at most, twins included.
const MOST_NODES: usize = 254;

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
    /// The rate of every node that is added; `None`: that of its EEPROM.
    pub rate: Option<BitRate>,
    /// What is chosen about every node that is added: its quirks.
    pub choose: &'a dyn Fn(&mut Spec),
}

impl NodeAccess<'_> {
    /// Every node with its number, in the order of the command line.
    pub(in crate::panel) fn devices(&self) -> impl Iterator<Item = (&'static Product, &dyn CanopenDevice)> {
        self.nodes.iter().filter_map(|Seated { seat, product }| {
            Some((*product, self.bus.participant::<StoredNode>(*seat)?.as_device()))
        })
    }

    fn device(&self, address: u8) -> Option<(&'static Product, &dyn CanopenDevice)> {
        self.devices().find(|(_, device)| device.node_id().number() == address)
    }

    fn place(&self, address: u8) -> Option<usize> {
        self.nodes.iter().position(|seated| {
            let there = self.bus.participant::<StoredNode>(seated.seat);
            there.is_some_and(|there| there.node_id().number() == address)
        })
    }

    /// Does something to the node with that number; of two to the first.
    fn with<R>(
        &mut self,
        address: u8,
        act: impl FnOnce(&'static Product, &mut dyn CanopenDevice, Instant) -> R,
    ) -> Option<R> {
        let Seated { seat, product } = *self.nodes.get(self.place(address)?)?;
        self.bus.with(self.now, seat, |stored: &mut StoredNode, now| {
            stored.act(now, |device, now| act(product, device, now))
        })
    }
}

impl OnLine for NodeAccess<'_> {
    fn now(&self) -> Instant {
        self.now
    }

    fn kind(&self) -> BusKind {
        BusKind::Can
    }

    fn addresses(&self) -> Vec<u8> {
        self.devices().map(|(_, device)| device.node_id().number()).collect()
    }

    fn station(&self, address: u8) -> Option<Station<'_>> {
        let (product, device) = self.device(address)?;
        let state = device.node().state();
        Some(Station {
            description: device.description(),
            device: product.name,
            product: product.sheet.product_name.into(),
            power: Some(device.supply()),
            presence: None,
            exchanging: state == Some(NmtState::Operational),
            bus_state: state.map(|state| format!("{state}")),
            owner: None,
        })
    }

    fn described(&self, address: u8) -> Option<&dyn Description> {
        self.device(address).map(|(_, device)| device.description())
    }

    fn complete(&self, address: u8, state: &mut State) {
        let Some((product, device)) = self.device(address) else { return };
        state.has.objects = true;
        state.has.power = true;
        if device.node().state().is_none() {
            return;
        }
        state.words.extend(dictionary::words(product.vocabulary, device));
        state.process.extend(dictionary::pdos(device));
        state.history.extend(dictionary::history(product.vocabulary, device));
        let register = whole(device, Address::new(0x1001, 0)).filter(|register| *register != 0);
        let silent = state.summary.fault.is_none() && state.summary.warning.is_none();
        if let Some(register) = register.filter(|_| silent) {
            let fault = format!("error register {register:02X}h");
            state.summary.fault = Some(FaultNow { fault, text: std::string::String::new() });
        }
    }

    fn act(&mut self, address: u8, act: &Act<'_>) -> Result<(), Problem> {
        let there = self.addresses();
        let done = self.with(address, |product, device, now| {
            let mut done = Ok(());
            let acted = Acted { now, device: product.name };
            device.act(now, &mut |description| done = act(description, &acted));
            done
        });
        done.unwrap_or_else(|| Err(no_station(address, &there)))
    }

    fn switch(&mut self, address: u8, on: bool) -> Result<Supply, Problem> {
        let there = self.addresses();
        let wanted = self.device(address).map(|(_, device)| device.number_at_start().number());
        if let Some(wanted) = wanted.filter(|wanted| on && *wanted != address && there.contains(wanted)) {
            return Err(Problem::conflict(format!(
                "the DIP switches say node number {wanted}, which another node has; set them to a free one"
            )));
        }
        let switched = self.with(address, |_, device, now| {
            match (on, device.is_on()) {
                (true, false) => device.power_on(now),
                (false, true) => device.power_off(now),
                (true, true) | (false, false) => {}
            }
            device.supply()
        });
        switched.ok_or_else(|| no_station(address, &there))
    }

    fn add(&mut self, mut spec: Spec) -> Result<u8, Problem> {
        if spec.device.group() != Group::Node {
            let name = spec.device.name();
            return Err(Problem::value(format!("{name} is on PROFIBUS, this line is a bus of CAN")));
        }
        let product = spec.product().map_err(|wrong| Problem::value(wrong.words))?;
        let node = spec.node();
        if !spec.choices.flag("twin") && self.device(node.number()).is_some() {
            return Err(Problem::conflict(format!(
                "the number {node} is taken; choose another, remove that node, or say \"twin\": true"
            )));
        }
        if self.nodes.len() >= MOST_NODES {
            return Err(Problem::conflict(format!("{MOST_NODES} nodes are on this bus; remove some")));
        }
        (self.choose)(&mut spec);
        let (now, choices) = (self.now, &spec.choices);
        let mut stored = match self.state {
            Some(state) => state
                .load_node(product, node, choices, now)
                .map_err(|error| Problem::conflict(in_one_line(&error)))?,
            None => StoredNode::new(product.make(node, choices, Eeprom::Internal, now), now),
        };
        let number = stored.node_id().number();
        if !spec.choices.flag("twin") && self.device(number).is_some() {
            return Err(Problem::conflict(format!(
                "its EEPROM has the node number {number}, which another node has; remove that one, or give it another number"
            )));
        }
        if let Some(rate) = self.rate {
            stored.set_rate(now, rate);
        }
        self.bus.add_faults_to(now, &mut stored);
        for signal in spec.signals().map_err(|wrong| Problem::value(wrong.words))? {
            stored.connect(now, signal);
        }
        let seat = self.bus.add(now, Box::new(stored));
        self.nodes.push(Seated { seat, product });
        self.bus.reseat_faults();
        Ok(number)
    }

    fn remove(&mut self, address: u8) -> Option<Box<dyn Any + Send>> {
        let Seated { seat, .. } = self.nodes.remove(self.place(address)?);
        self.bus.remove(self.now, seat);
        self.bus.reseat_faults();
        // Those that wait for this node go on waiting.
        for listed in self.bus.faults().iter() {
            if let Err(absent) = listed.rule.check(self.addresses()) {
                tracing::warn!("{absent}");
            }
        }
        Some(Box::new(()))
    }

    fn state(&self) -> Counted {
        let station = |seated: &Seated| {
            let address = self.bus.participant::<StoredNode>(seated.seat)?.node_id().number();
            Some(LineStation {
                address,
                device: seated.product.name,
                presence: None,
                owner_address: None,
                counters: BTreeMap::new(),
                reply_times: None,
                error_state: Some(ErrorStateName::of(self.bus.confinement(seated.seat)?.state())),
            })
        };
        Counted {
            rate_bits_per_second: self.bus.rate().bits_per_second(),
            counters: Counters::of_can(self.bus.counters()),
            stations: self.nodes.iter().filter_map(station).collect(),
        }
    }

    fn baud(&self) -> Option<BaudRate> {
        None
    }

    fn faults(&self) -> Result<Vec<Listed>, Problem> {
        Ok(self.bus.list_faults())
    }

    fn check_fault(&self, rule: &Rule) -> Result<(), Problem> {
        rule.check(self.addresses()).map_err(|error| Problem::value(format!("{error}")))
    }

    fn add_fault(&mut self, rule: Rule) -> Result<u32, Problem> {
        self.bus.add_fault(self.now, rule).map_err(Problem::conflict)
    }

    fn remove_fault(&mut self, number: u32) -> Option<Rule> {
        self.bus.remove_fault(self.now, number)
    }

    fn operation(&self, address: u8) -> Option<(Operation, Option<Startup>)> {
        let (_, device) = self.device(address)?;
        let known = device.application().objects();
        let operation = if objects::object(known, CONTROL_WORD).is_some() {
            let homes = objects::object(known, HOMING_METHOD).is_some();
            Operation::Cia402 { homes, turning: device.description().turning() }
        } else {
            Operation::Objects
        };
        Some((operation, None))
    }

    fn words(&self, address: u8) -> Option<&'static Vocabulary> {
        self.device(address).map(|(product, _)| product.vocabulary)
    }

    fn node(&self, address: u8) -> Option<&dyn CanopenDevice> {
        self.device(address).map(|(_, device)| device)
    }

    fn with_node(&mut self, address: u8, act: &mut dyn FnMut(&mut dyn CanopenDevice, Instant)) {
        self.with(address, |_, device, now| act(device, now));
    }
}

/// Which node is at which seat, for whoever tells events by seats.
pub(in crate::panel) fn numbers(access: &NodeAccess<'_>) -> impl Iterator<Item = (Seat, NodeId)> {
    access.nodes.iter().filter_map(|seated| {
        Some((seated.seat, access.bus.participant::<StoredNode>(seated.seat)?.node_id()))
    })
}
