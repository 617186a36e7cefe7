//! A device on CANopen that is an application behind a node.

use super::{CanopenDevice, CanopenEvent};
use crate::can_bus::can::Frame;
use crate::can_bus::canopen::node::storage::Eeprom;
use crate::can_bus::canopen::{Application, Node, Policy};
use crate::face::Description;
use crate::time::Instant;

/// A [`CanopenDevice`] of an application: inputs and outputs, a counter, a valve. What moves or measures by itself says when
/// it is due ([`Application::poll_timeout`]); a device that does more than its dictionary implements `CanopenDevice`.
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
        self.application.advance(now);
        act(&mut self.application);
        self.node.handle_change(now, &mut self.application);
    }

    fn node(&self) -> &Node {
        &self.node
    }

    fn application(&self) -> &dyn Application {
        &self.application
    }

    fn parts(&mut self) -> (&mut Node, &mut dyn Application) {
        (&mut self.node, &mut self.application)
    }

    fn power_on(&mut self, now: Instant) {
        self.application.advance(now);
        self.node.power_on(now, &mut self.application);
    }

    fn power_off(&mut self, _: Instant) {
        self.application.power_off();
        self.node.power_off();
    }

    fn handle_frame(&mut self, now: Instant, frame: &Frame) {
        self.application.advance(now);
        self.node.handle_frame(now, frame, &mut self.application);
    }

    fn handle_timeout(&mut self, now: Instant) {
        self.application.advance(now);
        self.node.handle_timeout(now, &mut self.application);
    }

    fn poll_event(&mut self) -> Option<CanopenEvent> {
        let of_node = self.node.poll_event().map(CanopenEvent::Node);
        of_node.or_else(|| self.application.poll_news().map(CanopenEvent::Device))
    }

    fn poll_timeout(&self) -> Option<Instant> {
        Instant::first_of(self.node.poll_timeout(), self.application.poll_timeout())
    }
}
