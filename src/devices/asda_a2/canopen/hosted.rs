//! The servo as hosts run it.

use super::AsdaA2;
use super::application::RATES;
use crate::can_bus::can::{ErrorState, Frame};
use crate::can_bus::canopen::{Address, Application, Node, Refusal};
use crate::devices::asda_a2::Alarm;
use crate::devices::asda_a2::keypad::Keypad;
use crate::devices::{CanopenDevice, CanopenEvent};
#[cfg(feature = "std")]
use crate::face::AnyDeviceEvent;
use crate::face::Description;
use crate::time::Instant;

impl CanopenDevice for AsdaA2 {
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
        &self.drive
    }

    fn parts(&mut self) -> (&mut Node, &mut dyn Application) {
        (&mut self.node, &mut self.drive)
    }

    fn write_without_bus(&mut self, now: Instant, at: Address, octets: &[u8]) -> Result<(), Refusal> {
        self.drive.servo.advance(now);
        self.node.write_without_bus(now, at, octets, &mut self.drive)
    }

    fn rates(&self) -> &'static [u32] {
        &RATES
    }

    fn bits_per_second(&self) -> Option<u32> {
        self.drive.bits_per_second()
    }

    fn set_rate(&mut self, bits_per_second: u32) {
        self.drive.set_rate(bits_per_second);
    }

    fn power_on(&mut self, now: Instant) {
        self.drive.servo.advance(now);
        self.keypad = Keypad::default();
        self.node.power_on(now, &mut self.drive);
    }

    fn power_off(&mut self, now: Instant) {
        self.drive.servo.advance(now);
        self.drive.servo.power_off();
        self.node.power_off();
    }

    fn handle_frame(&mut self, now: Instant, frame: &Frame) {
        self.drive.servo.advance(now);
        if self.quirks.overrun_alarms {
            self.watch_overrun(now, frame);
        }
        if !self.node.hear(now, frame, &mut self.drive) {
            self.node.handle_change(now, &mut self.drive);
        }
    }

    fn handle_timeout(&mut self, now: Instant) {
        self.drive.servo.advance(now);
        self.node.handle_timeout(now, &mut self.drive);
    }

    fn handle_error_state(&mut self, now: Instant, _: ErrorState, state: ErrorState) {
        self.drive.servo.advance(now);
        match state {
            ErrorState::Active => self.drive.servo.end(Alarm::CanErrors),
            ErrorState::Passive => self.drive.servo.raise(Alarm::CanErrors),
            ErrorState::BusOff => self.drive.servo.raise(Alarm::BusOff),
        }
        self.node.handle_change(now, &mut self.drive);
    }

    fn poll_event(&mut self) -> Option<CanopenEvent> {
        if let Some(event) = self.node.poll_event() {
            return Some(CanopenEvent::Node(event));
        }
        #[cfg(feature = "std")]
        if let Some(news) = self.drive.servo.poll_news() {
            return Some(CanopenEvent::Device(AnyDeviceEvent::new(news)));
        }
        None
    }

    fn poll_timeout(&self) -> Option<Instant> {
        Instant::first_of(self.node.poll_timeout(), self.drive.servo.poll_timeout())
    }
}
