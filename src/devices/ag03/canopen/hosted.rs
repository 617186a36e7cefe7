//! The drive as hosts run it.

use super::part::RATES;
use super::{Ag03Node, Event};
use crate::can_bus::can::{ErrorState, Frame};
use crate::can_bus::canopen::node::storage::{Generation, ImageError, NotStored, StoreRequest};
use crate::can_bus::canopen::{Address, Application, Node, NodeId, Refusal};
use crate::devices::ag03::unit;
use crate::devices::ag03::unit::{Outcome, Power, Unit};
use crate::devices::{CanopenDevice, CanopenEvent, RecallError};
#[cfg(feature = "std")]
use crate::face::AnyDeviceEvent;
use crate::face::Description;
use crate::face::description::Supply;
use crate::time::Instant;

impl Ag03Node {
    /// The drive without supply, before it has said anything.
    #[must_use]
    pub fn unsupplied(mut self, now: Instant) -> Self {
        self.power_off(now);
        while self.poll_transmit(now).is_some() {}
        while self.poll_event().is_some() {}
        while self.poll_drive_event().is_some() {}
        self
    }

    /// The oldest event of the drive behind the node not taken yet; with `std`, [`CanopenDevice::poll_event`] has them, too.
    #[must_use]
    pub(crate) fn poll_drive_event(&mut self) -> Option<Event> {
        self.part.poll_event()
    }
}

impl CanopenDevice for Ag03Node {
    fn description(&self) -> &dyn Description {
        self
    }

    fn act(&mut self, _: Instant, act: &mut dyn FnMut(&mut dyn Description)) {
        act(self);
    }

    fn node(&self) -> &Node {
        &self.node
    }

    fn application(&self) -> &dyn Application {
        &self.part
    }

    fn parts(&mut self) -> (&mut Node, &mut dyn Application) {
        (&mut self.node, &mut self.part)
    }

    fn write_without_bus(&mut self, now: Instant, at: Address, octets: &[u8]) -> Result<(), Refusal> {
        self.advance(now);
        let outcome = self.node.write_without_bus(now, at, octets, &mut self.part);
        self.finish(now);
        outcome
    }

    fn node_id(&self) -> NodeId {
        self.part.node_id
    }

    fn supply(&self) -> Supply {
        match self.power() {
            Power::Off => Supply::Off,
            Power::On => Supply::On,
            Power::FactoryReset(_) => Supply::FactoryReset,
        }
    }

    fn number_at_start(&self) -> NodeId {
        let switches = self.part.unit.switches();
        let resets = self.config().reset_patterns.requested(switches).is_some();
        if resets { self.part.node_id } else { switches.node_id() }
    }

    fn rates(&self) -> &'static [u32] {
        &RATES
    }

    fn bits_per_second(&self) -> Option<u32> {
        Some(self.part.bits_per_second())
    }

    fn set_rate(&mut self, bits_per_second: u32) {
        self.part.set_rate(bits_per_second);
    }

    fn is_on(&self) -> bool {
        self.power() != Power::Off
    }

    fn power_on(&mut self, now: Instant) {
        self.supply(now, Unit::power_on);
    }

    fn power_off(&mut self, now: Instant) {
        self.supply(now, Unit::power_off);
    }

    fn handle_frame(&mut self, now: Instant, frame: &Frame) {
        self.advance(now);
        self.node.handle_frame(now, frame, &mut self.part);
        if self.cycles.is_manual() {
            self.run_cycle(now);
        }
        self.finish(now);
    }

    fn handle_timeout(&mut self, now: Instant) {
        self.advance(now);
        self.finish(now);
    }

    fn handle_error_state(&mut self, now: Instant, _: ErrorState, state: ErrorState) {
        self.advance(now);
        let was_off = self.part.set_error_state(state);
        if was_off {
            self.node.bus_is_back();
        }
        self.node.handle_change(now, &mut self.part);
        self.finish(now);
    }

    fn poll_transmit(&mut self, _: Instant) -> Option<Frame> {
        if self.part.is_bus_off() { None } else { self.node.poll_transmit() }
    }

    fn poll_event(&mut self) -> Option<CanopenEvent> {
        #[cfg(feature = "std")]
        if let Some(event) = self.poll_drive_event() {
            return Some(CanopenEvent::Device(AnyDeviceEvent::new(event)));
        }
        self.node.poll_event().map(CanopenEvent::Node)
    }

    fn poll_timeout(&self) -> Option<Instant> {
        Instant::first_of(self.node.poll_timeout(), self.cycles.next())
    }

    fn recall(&mut self, now: Instant, image: &[u8]) -> Result<(), RecallError> {
        let node_id = self.number_at_start();
        *self = Self::restore(*self.config(), image, now)?.unsupplied(now);
        self.part.node_id = node_id;
        Ok(())
    }

    fn offer_image(&mut self) {
        self.part.unit.offer_image();
    }

    fn poll_image<'a>(&mut self, into: &'a mut [u8]) -> Result<Option<StoreRequest<&'a [u8]>>, ImageError> {
        let got = into.len();
        if got < unit::MAX_IMAGE_LEN {
            return Err(ImageError::NoRoom { got });
        }
        let Some(StoreRequest { generation, octets }) = self.part.unit.poll_image() else { return Ok(None) };
        let image = into.get_mut(..octets.len()).ok_or(ImageError::NoRoom { got })?;
        image.copy_from_slice(&octets);
        Ok(Some(StoreRequest { generation, octets: image }))
    }

    fn handle_stored(&mut self, now: Instant, generation: Generation, outcome: Result<(), NotStored>) {
        self.advance(now);
        let outcome = match self.part.unit.handle_stored(generation, outcome) {
            Outcome::None => None,
            Outcome::Safe => Some(Ok(())),
            Outcome::Undone => Some(Err(NotStored)),
        };
        if let (Some(outcome), Some(generation)) = (outcome, self.awaited.take_if(|_| outcome.is_some())) {
            self.stored(now, generation, outcome);
        }
        self.finish(now);
    }
}

#[cfg(all(test, feature = "std"))]
mod tests {
    use super::super::Config;
    use super::*;

    #[test]
    fn switching_is_told_when_it_happens_and_a_drive_without_supply_has_nothing_to_tell() {
        let now = Instant::ZERO;
        let mut node = Ag03Node::new(Config::new(NodeId::MIN), now).unsupplied(now);
        assert_eq!(node.poll_event(), None);
        node.power_on(now);
        let on = node.poll_drive_event();
        assert!(matches!(on, Some(Event::Unit(unit::Event::SwitchedOn(_)))), "{on:?}");
        while node.poll_event().is_some() {}
        node.power_off(now);
        let off = AnyDeviceEvent::new(Event::Unit(unit::Event::SwitchedOff));
        assert_eq!(node.poll_event(), Some(CanopenEvent::Device(off)));
    }
}
