//! A plain CANopen device: values in RAM, a copy of those that are kept, and everything that is wanted of it in a queue.

pub(crate) mod objects;
pub(crate) mod rig;

use std::collections::{BTreeMap, VecDeque};

use profidrive::can_bus::canopen::dictionary;
use profidrive::can_bus::canopen::dictionary::{Home, Object};
use profidrive::can_bus::canopen::{
    Abort, Address, Application, NodeId, Notice, Request, Reset, Source, Sub, Value, Written,
};
use profidrive::time::Instant;

pub(crate) use objects::OBJECTS;

/// The write to this object is answered when a key is pressed.
pub(crate) const HELD: Address = Address::new(0x200E, 0);

#[derive(Debug)]
pub(crate) struct Plain {
    pub(crate) objects: &'static [Object],
    pub(crate) node_id: NodeId,
    /// What is in effect.
    pub(crate) ram: BTreeMap<Address, Vec<u8>>,
    /// What comes back with a reset.
    pub(crate) kept: BTreeMap<Address, Vec<u8>>,
    /// Defaults come with the next reset.
    pub(crate) load_pending: bool,
    /// What is wanted of the node.
    pub(crate) requests: VecDeque<Request>,
    /// What the node said.
    pub(crate) notices: Vec<Notice>,
    /// What storing is answered with.
    pub(crate) store_fault: Option<Abort>,
}

impl Plain {
    pub(crate) fn new(node_id: u8) -> Self {
        let mut device = Self {
            objects: OBJECTS,
            node_id: NodeId::new(node_id).unwrap(),
            ram: BTreeMap::new(),
            kept: BTreeMap::new(),
            load_pending: false,
            requests: VecDeque::new(),
            notices: Vec::new(),
            store_fault: None,
        };
        device.kept = device.defaults();
        device.ram = device.kept.clone();
        device
    }

    pub(crate) fn set(&mut self, at: Address, value: Value<'_>) {
        value.with_octets(|octets| self.ram.insert(at, octets.to_vec()));
    }

    fn defaults(&self) -> BTreeMap<Address, Vec<u8>> {
        let mut values = BTreeMap::new();
        for object in self.objects {
            for entry in object.entries.iter().filter(|entry| entry.home == Home::Application) {
                let at = Address { index: object.index, sub: entry.sub };
                entry.default_value(self.node_id).with_octets(|octets| values.insert(at, octets.to_vec()));
            }
        }
        values
    }

    fn value<'a>(&self, values: &'a BTreeMap<Address, Vec<u8>>, at: Address) -> Result<Value<'a>, Abort> {
        let entry = dictionary::entry(self.objects, at)?;
        entry.data.decode(values.get(&at).ok_or(Abort::NO_DATA)?).ok_or(Abort::INTERNAL)
    }
}

impl Application for Plain {
    fn objects(&self) -> &'static [Object] {
        self.objects
    }

    fn node_id(&self) -> NodeId {
        self.node_id
    }

    fn read(&self, at: Address) -> Result<Value<'_>, Abort> {
        self.value(&self.ram, at)
    }

    fn write(
        &mut self,
        _now: Instant,
        at: Address,
        value: Value<'_>,
        source: Source,
    ) -> Result<Written, Abort> {
        self.set(at, value);
        if source == Source::Image {
            value.with_octets(|octets| self.kept.insert(at, octets.to_vec()));
        }
        Ok(if at == HELD && source == Source::Sdo { Written::Held } else { Written::Done })
    }

    fn notice(&mut self, _now: Instant, notice: Notice) {
        if let Notice::Reset(Reset::PowerOn | Reset::Node) = notice {
            if std::mem::take(&mut self.load_pending) {
                self.kept = self.defaults();
            }
            self.ram = self.kept.clone();
        }
        self.notices.push(notice);
    }

    fn poll_request(&mut self) -> Option<Request> {
        self.requests.pop_front()
    }

    fn store(&mut self, _now: Instant, group: Sub) -> Result<Written, Abort> {
        if let Some(fault) = self.store_fault {
            return Err(fault);
        }
        if group != Sub(2) {
            for object in self.objects {
                for entry in object.entries.iter().filter(|entry| entry.stored) {
                    let at = Address { index: object.index, sub: entry.sub };
                    if let Some(octets) = self.ram.get(&at) {
                        self.kept.insert(at, octets.clone());
                    }
                }
            }
        }
        Ok(Written::Done)
    }

    fn load_defaults(&mut self, _now: Instant, group: Sub) -> Result<Written, Abort> {
        self.load_pending |= group != Sub(2);
        Ok(Written::Done)
    }

    fn kept(&self, at: Address) -> Result<Value<'_>, Abort> {
        self.value(&self.kept, at)
    }
}
