//! A device on CANopen that has no clock of its own: an application behind a node.

use core::fmt;

use super::{CanopenDevice, CanopenEvent, RecallError};
use crate::can_bus::can::Frame;
use crate::can_bus::canopen::storage::{Eeprom, Generation, ImageError, NotStored, StoreRequest};
use crate::can_bus::canopen::{Address, Application, Node, Policy, Refusal};
use crate::face::surroundings::{Declined, Face, Input, Level, Provocable, Surroundings};
use crate::face::{Description, DriveState, Why};
use crate::time::Instant;

/// A [`CanopenDevice`] of an application that changes only when the bus or its surroundings act on it: inputs and
/// outputs, a counter, a valve. What moves or measures by itself has its own deadlines and implements `CanopenDevice`.
#[derive(Clone, Debug)]
pub struct PlainNode<A> {
    node: Node,
    application: A,
}

impl<A: Application + Surroundings> PlainNode<A> {
    /// The device, switched off.
    pub fn new(policy: Policy, memory: Eeprom, application: A) -> Self {
        Self { node: Node::new(policy).with_memory(memory), application }
    }

    /// Does something to what is behind the node; what changes is sent as the mappings say.
    fn act<R>(&mut self, now: Instant, act: impl FnOnce(&mut A) -> R) -> R {
        let result = act(&mut self.application);
        self.node.handle_change(now, &mut self.application);
        result
    }
}

impl<A: Application + Surroundings + Send + 'static> CanopenDevice for PlainNode<A> {
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

impl<A: Application + Surroundings + 'static> Description for PlainNode<A> {}

impl<A: Application + Surroundings> Surroundings for PlainNode<A> {
    fn each_fault(&self, tell: &mut dyn FnMut(Provocable<'_>)) {
        self.application.each_fault(tell);
    }

    fn provoke(&mut self, now: Instant, fault: &str) -> Result<(), Declined> {
        self.act(now, |application| application.provoke(now, fault))
    }

    fn take_back(&mut self, now: Instant, fault: &str) -> Result<(), Declined> {
        self.act(now, |application| application.take_back(now, fault))
    }

    fn each_input(&self, tell: &mut dyn FnMut(&Input, Level)) {
        self.application.each_input(tell);
    }

    fn set_input(&mut self, now: Instant, name: &str, level: Level) {
        self.act(now, |application| application.set_input(now, name, level));
    }

    fn nominal(&self, name: &str) -> Option<Level> {
        self.application.nominal(name)
    }

    fn make_nominal(&mut self, now: Instant) {
        self.act(now, |application| application.make_nominal(now));
    }

    fn each_lack(&self, name: &str, say: &mut dyn FnMut(&dyn fmt::Display)) {
        self.application.each_lack(name, say);
    }

    fn each_key(&self, tell: &mut dyn FnMut(&'static str, bool)) {
        self.application.each_key(tell);
    }

    fn press(&mut self, now: Instant, key: &str, down: bool) -> Result<(), Declined> {
        self.act(now, |application| application.press(now, key, down))
    }

    fn face(&self, now: Instant) -> Face {
        self.application.face(now)
    }

    fn words(&self) -> &'static [Address] {
        self.application.words()
    }

    fn mode(&self) -> i64 {
        self.application.mode()
    }

    fn is_drive(&self) -> bool {
        self.application.is_drive()
    }

    fn drive_state(&self) -> Option<DriveState> {
        self.application.drive_state()
    }

    fn why(&self) -> Option<&dyn Why> {
        self.application.why()
    }
}
