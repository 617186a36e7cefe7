//! A device on CANopen that has no clock of its own: an application behind a node.

use super::{CanopenDevice, CanopenEvent, RecallError};
use crate::can_bus::can::Frame;
use crate::can_bus::canopen::storage::{Eeprom, Generation, ImageError, NotStored, StoreRequest};
use crate::can_bus::canopen::{Address, Application, Node, Policy, Refusal};
use crate::face::Description;
use crate::time::Instant;

/// A [`CanopenDevice`] of an application that changes only when the bus or its surroundings act on it: inputs and
/// outputs, a counter, a valve. What moves or measures by itself has its own deadlines and implements `CanopenDevice`.
#[derive(Clone, Debug)]
pub struct PlainNode<A> {
    node: Node,
    application: A,
}

impl<A> PlainNode<A> {
    /// The device, switched off.
    pub fn new(policy: Policy, memory: Eeprom, application: A) -> Self {
        Self { node: Node::new(policy).with_memory(memory), application }
    }
}

impl<A: Application + Description + Send> CanopenDevice for PlainNode<A> {
    fn description(&self) -> &dyn Description {
        &self.application
    }

    /// What changes is sent as the mappings say.
    fn act(&mut self, now: Instant, act: &mut dyn FnMut(&mut dyn Description)) {
        act(&mut self.application);
        self.node.handle_change(now, &mut self.application);
    }

    fn node(&self) -> &Node {
        &self.node
    }

    fn application(&self) -> &dyn Application {
        &self.application
    }

    fn write_without_bus(&mut self, now: Instant, at: Address, octets: &[u8]) -> Result<(), Refusal> {
        self.node.write_without_bus(now, at, octets, &mut self.application)
    }

    fn power_on(&mut self, now: Instant) {
        self.node.power_on(now, &mut self.application);
    }

    fn power_off(&mut self, _: Instant) {
        self.node.power_off();
    }

    fn handle_frame(&mut self, now: Instant, frame: &Frame) {
        self.node.handle_frame(now, frame, &mut self.application);
    }

    fn handle_timeout(&mut self, now: Instant) {
        self.node.handle_timeout(now, &mut self.application);
    }

    fn poll_transmit(&mut self, _: Instant) -> Option<Frame> {
        self.node.poll_transmit()
    }

    fn poll_event(&mut self) -> Option<CanopenEvent> {
        self.node.poll_event().map(CanopenEvent::Node)
    }

    fn poll_timeout(&self) -> Option<Instant> {
        self.node.poll_timeout()
    }

    fn recall(&mut self, now: Instant, image: &[u8]) -> Result<(), RecallError> {
        Ok(self.node.recall(now, image, &mut self.application)?)
    }

    fn poll_image<'a>(&mut self, into: &'a mut [u8]) -> Result<Option<StoreRequest<&'a [u8]>>, ImageError> {
        self.node.poll_image(&self.application, into)
    }

    fn handle_stored(&mut self, now: Instant, generation: Generation, outcome: Result<(), NotStored>) {
        self.node.handle_stored(now, generation, outcome, &mut self.application);
    }
}
