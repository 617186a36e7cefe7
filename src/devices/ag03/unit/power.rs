//! Switching the unit off and on (manual chapters 2.4 and 2.6; `ag03.md` 8 row 1, 11).

use core::time::Duration;

use super::paced::Paced;
use super::{DipSwitches, Event, Unit};
use crate::devices::ag03::drive::{Command, InputChange, Inputs, Settings};
use crate::devices::ag03::param::DefaultSet;

/// What the supply of the control and the DIP switches make of the unit.
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

/// Whether a change of the supply has switched the unit. If so a bus begins anew, too.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[must_use]
pub enum Switched {
    /// It is as it was.
    No,
    /// It has just been switched off.
    Off,
    /// It has just been switched on.
    On,
}

impl Unit {
    /// Whether it is switched on.
    pub(crate) const fn power(&self) -> Power {
        self.power
    }

    /// Whether it serves a bus: neither switched off nor in a factory reset.
    pub(crate) const fn is_working(&self) -> bool {
        match self.power {
            Power::On => true,
            Power::Off | Power::FactoryReset(_) => false,
        }
    }

    /// The world around the drive as last set, switched on or not.
    pub(crate) const fn inputs(&self) -> &Inputs {
        &self.inputs
    }

    /// Opens the switch of the control supply: what travels runs out unbraked, and all is lost but EEPROM and shaft
    /// position. The supply that is set ([`Inputs::control_supply`]) stays as it is.
    pub fn power_off(&mut self) -> Switched {
        self.supply(self.inputs, false)
    }

    /// Closes the switch of the control supply (row 1): the EEPROM is loaded and the DIP switches are read, PNU 1035 is
    /// 100 and the setpoint 0, the motor is released. The drive gets the supply that is set, or 24 V where that is none.
    pub fn power_on(&mut self) -> Switched {
        match self.supply(self.inputs, true) {
            Switched::No if self.power == Power::Off => {
                self.supply(self.inputs.with_control_supply(true), true)
            }
            switched @ (Switched::No | Switched::Off | Switched::On) => switched,
        }
    }

    /// Changes what acts on the drive from outside: supplies, keys, causes of faults.
    ///
    /// A control supply of 0 switches the unit off, as [`Unit::power_off`] does, and one that comes back switches it on;
    /// while [`Unit::power_off`] holds, the supply is only set.
    pub(crate) fn set_inputs(&mut self, inputs: Inputs) -> Switched {
        for change in InputChange::between(&self.inputs, &inputs.limited()) {
            self.events.push(Event::Input(change));
        }
        self.supply(inputs, self.switch_closed)
    }

    /// Begins anew as after power-on (row 1), but without reading the DIP switches: what the EEPROM does not keep is at its
    /// default, the motor is released, no fault is latched. Does nothing to a unit that is not working.
    pub(crate) fn restart(&mut self) {
        if self.is_working() {
            self.drive.set_inputs(self.inputs.with_control_supply(false));
            self.step(Duration::ZERO, &Command::UNATTENDED);
            self.store.power_on();
            self.settings = Settings::read(&self.store);
            self.supply_drive();
            self.step(Duration::ZERO, &Command::UNATTENDED);
        }
    }

    /// The DIP switches as they are now.
    pub(crate) const fn switches(&self) -> DipSwitches {
        self.switches
    }

    /// Sets the DIP switches. They are read when the unit is switched on next (manual chapter 7.8).
    pub(crate) fn set_switches(&mut self, switches: DipSwitches) {
        if core::mem::replace(&mut self.switches, switches) != switches {
            self.events.push(Event::SwitchesSet(switches));
        }
    }

    /// Takes over the world around the drive.
    fn supply(&mut self, inputs: Inputs, switch_closed: bool) -> Switched {
        (self.inputs, self.switch_closed) = (inputs, switch_closed);
        self.drive.set_inputs(if switch_closed { inputs } else { inputs.with_control_supply(false) });
        match (self.power, self.drive.is_supplied()) {
            (Power::Off, true) => {
                self.events.push(Event::SwitchedOn(self.switches));
                self.paced = Paced::default();
                self.store.power_on();
                self.settings = Settings::read(&self.store);
                self.read_switches();
                self.notice(Switched::On)
            }
            (Power::On | Power::FactoryReset(_), false) => {
                self.power = Power::Off;
                self.events.push(Event::SwitchedOff);
                self.supply_drive();
                self.notice(Switched::Off)
            }
            (Power::Off, false) | (Power::On | Power::FactoryReset(_), true) => {
                self.supply_drive();
                Switched::No
            }
        }
    }

    /// A step without length lets the drive notice at once.
    fn notice(&mut self, switched: Switched) -> Switched {
        self.step(Duration::ZERO, &Command::UNATTENDED);
        switched
    }

    /// Reads the DIP switches, as the unit does when it is switched on, and does what they ask for.
    pub(super) fn read_switches(&mut self) {
        self.power = match self.reset_patterns.requested(self.switches) {
            None => Power::On,
            Some(set) => {
                self.reset(set);
                self.events.push(Event::FactoryReset(set));
                Power::FactoryReset(set)
            }
        };
        self.supply_drive();
    }

    /// What the drive itself gets: during a factory reset it is as dead as without supply.
    fn supply_drive(&mut self) {
        let inputs = if self.is_working() { self.inputs } else { self.inputs.with_control_supply(false) };
        self.drive.set_inputs(inputs);
    }
}
