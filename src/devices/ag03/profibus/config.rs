//! What a device is made of.

use super::{APPLICATION, DESCRIPTION, parameters, words};
use crate::devices::ag03::drive;
use crate::devices::ag03::param;
use crate::devices::ag03::param::{Gear, Model};
use crate::devices::ag03::unit;
use crate::devices::ag03::unit::{ApplicationCycle, DipSwitches, Eeprom, dip};
use crate::profibus::dp;
use crate::profibus::fdl::{Framer, Timing};
use crate::profibus::pkw;
use crate::time::BaudRate;

/// What a device is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config {
    /// The DIP switches: station address, factory reset, bus terminator.
    pub switches: DipSwitches,
    /// Which switches ask for a factory reset; an assumption.
    pub reset_patterns: dip::ResetPatterns,
    /// Where the EEPROM is kept.
    pub eeprom: Eeprom,
    /// Which drive.
    pub model: Model,
    /// Which internal gear.
    pub gear: Gear,
    /// The rate of the line.
    pub baud: BaudRate,
    /// What can be known of the time of octets.
    pub timing: Timing,
    /// How often the drive part runs.
    pub application_cycle: ApplicationCycle,
    /// How the parameter channel behaves where the manuals leave it open.
    pub pkw: pkw::Config,
    /// How the drive answers jobs where the manuals leave it open.
    pub parameters: parameters::JobQuirks,
    /// How the slave behaves where the sources are silent. The drives judge no configuration: with
    /// `ApplicationReady::WhenJudged` they stay not ready.
    pub dp: dp::Policy,
    /// Which parameter ranges hold where the manuals contradict themselves.
    pub param: param::Quirks,
    /// How the drive behaves where the manuals leave it open, and the numbers of its plant.
    pub drive: drive::Config,
    /// What the bits of STW and ZSW are where the manuals contradict themselves.
    pub words: words::WordQuirks,
}

impl Config {
    /// An AG03/1 with gear 48:1 with these DIP switches or at this address, on a line without true timing, with an
    /// application cycle of 1 ms, whose EEPROM lives as long as the device.
    pub fn new(switches: impl Into<DipSwitches>) -> Self {
        Self {
            switches: switches.into(),
            reset_patterns: dip::ResetPatterns::ASSUMED,
            eeprom: Eeprom::Internal,
            model: Model::Ag03_1,
            gear: Gear::Ratio48,
            baud: BaudRate::K500,
            timing: Timing::Untrue,
            application_cycle: ApplicationCycle::DEFAULT,
            pkw: pkw::Config::default(),
            parameters: parameters::JobQuirks::default(),
            dp: dp::Policy::PROPOSED,
            param: param::Quirks::default(),
            drive: drive::Config::default(),
            words: words::WordQuirks::default(),
        }
    }
}

impl Config {
    /// A station at the address of the DIP switches that has just been switched on.
    #[inline(never)]
    pub(super) fn station(&self) -> dp::Station {
        let max_tsdr = match self.timing {
            Timing::True => Some(self.baud.max_tsdr_bits()),
            Timing::Untrue => None,
        };
        let address = self.switches.address();
        dp::Station::under(self.dp, address, self.baud, max_tsdr, DESCRIPTION, APPLICATION)
    }

    pub(super) fn framer(&self) -> Framer {
        Framer::new(self.timing.resync(self.baud))
    }

    /// The unit behind the bus.
    pub(super) const fn unit(&self) -> unit::Config {
        let Self { model, gear, switches, reset_patterns, eeprom, param, drive, .. } = *self;
        unit::Config { model, gear, switches, reset_patterns, eeprom, param, drive }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::devices::ag03::profibus::Device;
    use crate::profibus::fdl::Address;
    use crate::time::Instant;
    use core::time::Duration;

    #[test]
    fn a_late_device_comes_back_with_the_shortest_and_the_longest_cycle() {
        for time in [ApplicationCycle::SHORTEST, Duration::MAX] {
            let application_cycle = ApplicationCycle::every(time).unwrap();
            let address = Address::station(5).unwrap();
            let mut device = Device::new(Config { application_cycle, ..Config::new(address) }, Instant::ZERO);
            // Inputs that are set wake the drive part.
            let inputs = *device.inputs();
            device.set_inputs(Instant::from_millis(1), inputs);
            device.handle_timeout(Instant::from_nanos(u64::MAX / 2));
            assert!(device.poll_timeout().is_none_or(|due| due > Instant::from_millis(1)));
        }
    }
}
