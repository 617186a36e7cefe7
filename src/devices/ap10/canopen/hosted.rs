//! The indicator as hosts run it.

use super::Ap10;
use crate::can_bus::can::{ErrorState, Frame};
use crate::can_bus::canopen::storage::{Generation, ImageError, NotStored, StoreRequest};
use crate::can_bus::canopen::{Address, Application, Node, Refusal};
use crate::devices::{CanopenDevice, CanopenEvent, RecallError};
use crate::time::Instant;

impl CanopenDevice for Ap10 {
    fn node(&self) -> &Node {
        Self::node(self)
    }

    fn application(&self) -> &dyn Application {
        &self.unit
    }

    fn write_without_bus(&mut self, now: Instant, at: Address, octets: &[u8]) -> Result<(), Refusal> {
        self.node.write_without_bus(now, at, octets, &mut self.unit)
    }

    fn is_on(&self) -> bool {
        self.power != super::Power::Off
    }

    fn power_on(&mut self, now: Instant) {
        Self::power_on(self, now);
    }

    fn power_off(&mut self, _: Instant) {
        Self::power_off(self);
    }

    fn handle_frame(&mut self, now: Instant, frame: &Frame) {
        Self::handle_frame(self, now, frame);
    }

    fn handle_timeout(&mut self, now: Instant) {
        Self::handle_timeout(self, now);
    }

    fn handle_error_state(&mut self, now: Instant, from: ErrorState, to: ErrorState) {
        match (from, to) {
            (ErrorState::BusOff, ErrorState::Active | ErrorState::Passive) => self.recover_from_bus_off(now),
            (ErrorState::Active | ErrorState::Passive | ErrorState::BusOff, _) => {}
        }
        self.set_error_passive(now, to == ErrorState::Passive);
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
        Ok(Self::recall(self, now, image)?)
    }

    fn poll_image<'a>(&mut self, into: &'a mut [u8]) -> Result<Option<StoreRequest<&'a [u8]>>, ImageError> {
        Self::poll_image(self, into)
    }

    fn handle_stored(&mut self, now: Instant, generation: Generation, outcome: Result<(), NotStored>) {
        Self::handle_stored(self, now, generation, outcome);
    }
}
