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
    /// Opens the switch of the control supply: what travels runs out unbraked, the bus hears nothing more, and all is
    /// lost but EEPROM and shaft position. The supply that is set ([`Inputs::control_supply`]) stays as it is. Counts
    /// as a `handle_*` call; does nothing to a drive that is switched off.
    pub fn power_off(&mut self, now: Instant) {
        self.supply(now, *self.inputs(), false);
    }

    /// Closes the switch of the control supply (row 1): the EEPROM is loaded and the DIP switches are read, PNU 1035 is
    /// 100 and the setpoint 0, the motor is released and the slave waits for parameters. The drive gets the supply that
    /// is set, or 24 V where that is none. Counts as a `handle_*` call; does nothing to a drive that is on.
    pub fn power_on(&mut self, now: Instant) {
        self.supply(now, *self.inputs(), true);
        if self.power() == Power::Off {
            self.supply(now, self.inputs().with_control_supply(true), true);
        }
    }

    /// Changes what acts on the drive from outside: supplies, keys, causes of faults. Counts as a `handle_*` call.
    ///
    /// A control supply of 0 switches the drive off, as [`Device::power_off`] does, and one that comes back switches it
    /// on; while [`Device::power_off`] holds, the supply is only set.
    pub fn set_inputs(&mut self, now: Instant, inputs: Inputs) {
        self.supply(now, inputs, self.part.switch_closed);
    }

    fn supply(&mut self, now: Instant, inputs: Inputs, switch_closed: bool) {
        self.part.advance(now);
        if self.part.supply(now, inputs, switch_closed) {
            self.framer = self.part.config.framer();
        }
    }

    /// Sets the DIP switches. They are read when the drive is switched on next (manual chapter 7.8).
    pub fn set_switches(&mut self, switches: super::DipSwitches) {
        self.part.config.switches = switches;
    }
}

impl Parts {
    /// Takes over the world around the drive. Says whether the drive was switched on or off by that.
    fn supply(&mut self, now: Instant, inputs: Inputs, switch_closed: bool) -> bool {
        (self.inputs, self.switch_closed) = (inputs, switch_closed);
        self.drive.set_inputs(if switch_closed { inputs } else { inputs.with_control_supply(false) });
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
        self.power = match self.config.reset_patterns.requested(switches) {
            None => {
                self.address = switches.address();
                Power::On
            }
            // SW1 to SW7 say which parameters, not which address (`ag03.md` 11).
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
        self.outputs_seen = self.station.slave().output_updates();
        self.interrupted = false;
        self.run_cycle(Duration::ZERO);
    }
}
