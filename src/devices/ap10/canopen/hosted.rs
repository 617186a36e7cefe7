//! The indicator as hosts run it.

use super::{Ap10, Power, RATES};
use crate::can_bus::can::{ErrorState, Frame};
use crate::can_bus::canopen::{Application, Node};
use crate::devices::CanopenDevice;
use crate::devices::ap10::Setting;
use crate::face::Description;
use crate::time::Instant;

impl CanopenDevice for Ap10 {
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
        &self.unit
    }

    fn parts(&mut self) -> (&mut Node, &mut dyn Application) {
        (&mut self.node, &mut self.unit)
    }

    fn is_on(&self) -> bool {
        self.power != Power::Off
    }

    fn rates(&self) -> &'static [u32] {
        RATES
    }

    fn bits_per_second(&self) -> Option<u32> {
        self.unit.bits_per_second()
    }

    fn set_rate(&mut self, bits_per_second: u32) {
        self.unit.set_rate(bits_per_second);
    }

    fn power_on(&mut self, now: Instant) {
        if self.power != Power::Off {
            return;
        }
        self.turn_on(now);
        self.switched_on = Some(now);
        let automatic = self.unit.kept_setting(Setting::BaudRate) == 0;
        if self.unit.quirks.listens_first && automatic {
            self.power = Power::Listening;
        } else {
            self.power = Power::On;
            self.node.power_on(now, &mut self.unit);
        }
    }

    fn power_off(&mut self, _: Instant) {
        self.power = Power::Off;
        self.unit.power_off();
        self.node.power_off();
    }

    fn handle_frame(&mut self, now: Instant, frame: &Frame) {
        match self.power {
            // It only tells what it ignores.
            Power::Off => self.node.handle_frame(now, frame, &mut self.unit),
            // Any valid frame has the rate; it is not understood itself.
            Power::Listening => {
                self.power = Power::On;
                self.node.power_on(now, &mut self.unit);
            }
            Power::On => {
                self.timeouts(now);
                self.node.handle_frame(now, frame, &mut self.unit);
            }
        }
    }

    fn handle_timeout(&mut self, now: Instant) {
        if self.power == Power::On {
            if self.spin_due().is_some_and(|due| due <= now) {
                self.turn_on(now);
            }
            self.timeouts(now);
            self.node.handle_timeout(now, &mut self.unit);
        }
    }

    fn handle_error_state(&mut self, now: Instant, from: ErrorState, to: ErrorState) {
        match (from, to) {
            (ErrorState::BusOff, ErrorState::Active | ErrorState::Passive) => self.recover_from_bus_off(now),
            (ErrorState::Active | ErrorState::Passive | ErrorState::BusOff, _) => {}
        }
        self.set_error_passive(now, to == ErrorState::Passive);
    }

    fn poll_timeout(&self) -> Option<Instant> {
        match self.power {
            Power::Off | Power::Listening => None,
            Power::On => {
                let due = Instant::first_of(self.node.poll_timeout(), self.unit.poll_timeout());
                Instant::first_of(due, self.spin_due())
            }
        }
    }
}
