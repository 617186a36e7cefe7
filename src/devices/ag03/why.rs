//! What keeps a drive from moving on either bus: its supply.

use super::unit::Power;
use crate::devices::reasons;
use crate::face::Reason;

/// Tells what stands against any Data_Exchange or NMT command.
pub(super) fn of_power(power: Power, tell: &mut dyn FnMut(Reason<'_>)) {
    match power {
        Power::Off => tell(reasons::SWITCHED_OFF),
        Power::FactoryReset(_) => {
            let text = "the drive is in a factory reset: switch it off, put SW8 to OFF and switch it on";
            tell(Reason::new("FactoryReset", &text));
        }
        Power::On => {}
    }
}
