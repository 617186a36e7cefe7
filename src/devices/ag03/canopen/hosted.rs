//! The drive as hosts run it.

use super::Ag03Node;
use crate::can_bus::can::{ErrorState, Frame};
use crate::can_bus::canopen::storage::{Generation, ImageError, NotStored, StoreRequest};
use crate::can_bus::canopen::{Address, Application, Node, NodeId, Refusal};
use crate::devices::ag03::unit;
use crate::devices::{CanopenDevice, CanopenEvent, RecallError};
use crate::time::Instant;

impl Ag03Node {
    /// The drive without supply, before it has said anything.
    #[must_use]
    pub fn unsupplied(mut self, now: Instant) -> Self {
        self.power_off(now);
        while self.poll_transmit(now).is_some() {}
        while self.poll_event().is_some() {}
        self
    }
}

impl CanopenDevice for Ag03Node {
    fn node(&self) -> &Node {
        Self::node(self)
    }

    fn application(&self) -> &dyn Application {
        &self.part
    }

    fn write_without_bus(&mut self, now: Instant, at: Address, octets: &[u8]) -> Result<(), Refusal> {
        Self::write_without_bus(self, now, at, octets)
    }

    fn node_id(&self) -> NodeId {
        Self::node_id(self)
    }

    fn is_on(&self) -> bool {
        self.power() != crate::devices::ag03::unit::Power::Off
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

    fn poll_transmit(&mut self, now: Instant) -> Option<Frame> {
        Self::poll_transmit(self, now)
    }

    fn poll_event(&mut self) -> Option<CanopenEvent> {
        Self::poll_event(self)
    }

    fn poll_timeout(&self) -> Option<Instant> {
        Self::poll_timeout(self)
    }

    fn recall(&mut self, now: Instant, image: &[u8]) -> Result<(), RecallError> {
        *self = Self::restore(*self.config(), image, now)?.unsupplied(now);
        Ok(())
    }

    fn poll_image<'a>(&mut self, into: &'a mut [u8]) -> Result<Option<StoreRequest<&'a [u8]>>, ImageError> {
        let got = into.len();
        if got < unit::MAX_IMAGE_LEN {
            return Err(ImageError::NoRoom { got });
        }
        let Some(StoreRequest { generation, octets }) = Self::poll_image(self) else { return Ok(None) };
        let image = into.get_mut(..octets.len()).ok_or(ImageError::NoRoom { got })?;
        image.copy_from_slice(&octets);
        Ok(Some(StoreRequest { generation, octets: image }))
    }

    fn handle_stored(&mut self, now: Instant, generation: Generation, outcome: Result<(), NotStored>) {
        Self::handle_stored(self, now, generation, outcome);
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Config, Event};
    use super::*;

    #[test]
    fn switching_is_told_when_it_happens_and_a_drive_without_supply_has_nothing_to_tell() {
        let now = Instant::ZERO;
        let mut node = Ag03Node::new(Config::new(NodeId::MIN), now).unsupplied(now);
        assert_eq!(Ag03Node::poll_event(&mut node), None);
        Ag03Node::power_on(&mut node, now);
        let on = Ag03Node::poll_event(&mut node);
        assert!(matches!(on, Some(CanopenEvent::Ag03(Event::Unit(unit::Event::SwitchedOn(_))))), "{on:?}");
        while Ag03Node::poll_event(&mut node).is_some() {}
        Ag03Node::power_off(&mut node, now);
        assert_eq!(
            Ag03Node::poll_event(&mut node),
            Some(CanopenEvent::Ag03(Event::Unit(unit::Event::SwitchedOff)))
        );
    }
}
