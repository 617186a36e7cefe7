//! The servo as hosts run it.

use super::AsdaA2;
use crate::can_bus::can::{ErrorState, Frame};
use crate::can_bus::canopen::storage::{Generation, ImageError, NotStored, StoreRequest};
use crate::can_bus::canopen::{Address, Application, Node, Refusal};
use crate::devices::{CanopenDevice, CanopenEvent, RecallError};
use crate::time::Instant;

impl CanopenDevice for AsdaA2 {
    fn node(&self) -> &Node {
        Self::node(self)
    }

    fn application(&self) -> &dyn Application {
        &self.drive
    }

    fn write_without_bus(&mut self, now: Instant, at: Address, octets: &[u8]) -> Result<(), Refusal> {
        self.drive.servo.advance(now);
        self.node.write_without_bus(now, at, octets, &mut self.drive)
    }

    fn power_on(&mut self, now: Instant) {
        Self::power_on(self, now);
    }

    fn power_off(&mut self, now: Instant) {
        Self::power_off(self, now);
    }

    fn handle_frame(&mut self, now: Instant, frame: &Frame) {
        Self::handle_frame(self, now, frame);
    }

    fn handle_timeout(&mut self, now: Instant) {
        Self::handle_timeout(self, now);
    }

    fn handle_error_state(&mut self, now: Instant, _: ErrorState, to: ErrorState) {
        Self::set_error_state(self, now, to);
    }

    fn poll_transmit(&mut self, _: Instant) -> Option<Frame> {
        Self::poll_transmit(self)
    }

    fn poll_event(&mut self) -> Option<CanopenEvent> {
        Self::poll_event(self).map(CanopenEvent::Node)
    }

    fn poll_timeout(&self) -> Option<Instant> {
        Self::poll_timeout(self)
    }

    fn recall(&mut self, now: Instant, image: &[u8]) -> Result<(), RecallError> {
        Ok(self.node.recall(now, image, &mut self.drive)?)
    }

    fn poll_image<'a>(&mut self, into: &'a mut [u8]) -> Result<Option<StoreRequest<&'a [u8]>>, ImageError> {
        self.node.poll_image(&self.drive, into)
    }

    fn handle_stored(&mut self, now: Instant, generation: Generation, outcome: Result<(), NotStored>) {
        self.node.handle_stored(now, generation, outcome, &mut self.drive);
    }
}
