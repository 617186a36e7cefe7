//! Switching the drive off and on (manual chapters 2.4 and 2.6; `ag03.md` 8 row 1, 11).

use core::time::Duration;

use super::{Device, Event, Parts};
use crate::drive::{Inputs, Settings};
use crate::param::DefaultSet;
use crate::time::Instant;

/// What the supply of the control and the DIP switches make of the drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Power {
    /// Without control supply: silent on the bus, the motor released.
    Off,
    /// In normal operation.
    On,
    /// Switched on with the DIP switches of a factory reset: the parameters are reset, status LED and bus LED blink
    /// alternately, and nothing else works before it is switched off (manual chapter 2.4).
    FactoryReset(DefaultSet),
}

impl Device {
    /// Takes the control supply away: what travels runs out unbraked, the bus hears nothing more, and all is lost
    /// but EEPROM and shaft position. Counts as a `handle_*` call; does nothing to a drive that is off.
    pub fn power_off(&mut self, now: Instant) {
        self.set_inputs(now, self.inputs().with_control_supply(false));
    }

    /// Gives the control supply back (row 1): the EEPROM is loaded and the DIP switches are read, PNU 1035 is 100 and
    /// the setpoint 0, the motor is released and the slave waits for parameters. Counts as a `handle_*` call; does
    /// nothing to a drive that is on.
    pub fn power_on(&mut self, now: Instant) {
        self.set_inputs(now, self.inputs().with_control_supply(true));
    }

    /// Sets the DIP switches. They are read when the drive is switched on next (manual chapter 7.8).
    pub fn set_switches(&mut self, switches: super::DipSwitches) {
        self.part.config.switches = switches;
    }
}

impl Parts {
    /// Takes over the world around the drive. Says whether the drive was switched on or off by that.
    pub(super) fn set_inputs(&mut self, now: Instant, inputs: Inputs) -> bool {
        self.inputs = inputs;
        self.drive.set_inputs(inputs);
        let switched = match (self.power, self.drive.is_supplied()) {
            (Power::Off, true) => {
                self.switch_on();
                true
            }
            (Power::On | Power::FactoryReset(_), false) => {
                self.switch_off();
                true
            }
            (Power::Off, false) | (Power::On | Power::FactoryReset(_), true) => {
                self.supply_drive();
                false
            }
        };
        self.wake(now);
        switched
    }

    /// Whether telegrams are heard and answered.
    pub(super) const fn is_on_the_bus(&self) -> bool {
        match self.power {
            Power::On => true,
            Power::Off | Power::FactoryReset(_) => false,
        }
    }

    /// Reads the DIP switches, as the drive does when it is switched on, and does what they ask for.
    pub(super) fn read_switches(&mut self) {
        let switches = self.config.switches;
        self.address = switches.address();
        self.power = match self.config.reset_patterns.requested(switches) {
            None => Power::On,
            Some(set) => {
                self.store.load_defaults(set);
                self.settings = Settings::read(&self.store);
                if let Some(storage) = &mut self.storage {
                    storage.reset(set);
                }
                self.events.push(Event::FactoryReset(set));
                Power::FactoryReset(set)
            }
        };
        self.supply_drive();
    }

    fn switch_off(&mut self) {
        self.power = Power::Off;
        self.events.push(Event::SwitchedOff);
        self.supply_drive();
        self.restart();
    }

    fn switch_on(&mut self) {
        self.events.push(Event::SwitchedOn(self.config.switches));
        self.store.power_on();
        self.settings = Settings::read(&self.store);
        self.read_switches();
        self.restart();
    }

    /// What the drive itself gets: during a factory reset it is as dead as without supply.
    fn supply_drive(&mut self) {
        let inputs = if self.is_on_the_bus() { self.inputs } else { self.inputs.with_control_supply(false) };
        self.drive.set_inputs(inputs);
    }

    /// A new station on the bus that has heard nothing yet. A cycle without length lets the drive notice at once.
    fn restart(&mut self) {
        self.station = self.config.station();
        self.outputs_seen = self.station.slave().outputs_passed();
        self.interrupted = false;
        self.run_cycle(Duration::ZERO);
    }
}
