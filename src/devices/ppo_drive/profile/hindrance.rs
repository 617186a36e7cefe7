//! What the control word and the status word of such a drive say against turning.

use core::fmt;

use super::{StwBit, ZswBit};
use crate::profibus::ppo::{Stw, Zsw};

/// A reason why the drive does not turn, and what to do about it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ProfileHindrance {
    /// STW bit 10 = 0.
    NotByPlc,
    /// ZSW bit 3.
    Fault,
    /// STW bit 1 = 0, or ZSW bit 4 = 0.
    Off2,
    /// STW bit 2 = 0, or ZSW bit 5 = 0.
    Off3,
    /// ZSW bit 6.
    Inhibited,
    /// Not ready to switch on.
    NotReadyToSwitchOn,
    /// STW bit 0 = 0.
    NotOn,
    /// STW bit 3 = 0.
    NotEnabled,
    /// All is commanded, and operation is not enabled.
    NotInOperation,
    /// STW bit 4 = 0.
    RampDisabled,
    /// STW bit 5 = 0.
    RampFrozen,
    /// STW bit 6 = 0.
    SetpointDisabled,
}

impl fmt::Display for ProfileHindrance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotByPlc => "the drive ignores the control word: set STW bit 10 (control by PLC)",
            Self::Fault => "a fault: remove its cause and acknowledge it (STW bit 7 from 0 to 1)",
            Self::Off2 => "OFF2: set STW bit 1, and check the OFF2 input at the terminals of the drive",
            Self::Off3 => "OFF3: set STW bit 2, and check the OFF3 input at the terminals of the drive",
            Self::Inhibited => "switching on is inhibited: give OFF1 once (STW bit 0 = 0, bits 1 and 2 = 1)",
            Self::NotReadyToSwitchOn => "not ready for switching on: check the supplies of the drive",
            Self::NotOn => "OFF1: set STW bit 0 (ON)",
            Self::NotEnabled => "operation is not enabled: set STW bit 3",
            Self::NotInOperation => {
                "all bits are set, but the drive does not enable operation: check its enable inputs"
            }
            Self::RampDisabled => "the output of the ramp generator is 0: set STW bit 4",
            Self::RampFrozen => "the ramp generator is held: set STW bit 5",
            Self::SetpointDisabled => "the setpoint is not enabled: set STW bit 6",
        })
    }
}

/// What stands against turning, the first thing to do first. A drive against which nothing stands turns with its setpoint.
pub fn hindrances(stw: Stw, zsw: Zsw) -> impl Iterator<Item = ProfileHindrance> {
    let (stw_has, zsw_has) = (|bit: StwBit| bit.is_set(stw), |bit: ZswBit| bit.is_set(zsw));
    let stopped = zsw_has(ZswBit::Fault) || zsw_has(ZswBit::SwitchingOnInhibited);
    let commanded = stw_has(StwBit::On) && stw_has(StwBit::EnableOperation) && stw_has(StwBit::ByPlc);
    let off = !stw_has(StwBit::NoOff2)
        || !stw_has(StwBit::NoOff3)
        || !zsw_has(ZswBit::NoOff2)
        || !zsw_has(ZswBit::NoOff3);
    [
        (!stw_has(StwBit::ByPlc), ProfileHindrance::NotByPlc),
        (zsw_has(ZswBit::Fault), ProfileHindrance::Fault),
        (!stw_has(StwBit::NoOff2) || !zsw_has(ZswBit::NoOff2), ProfileHindrance::Off2),
        (!stw_has(StwBit::NoOff3) || !zsw_has(ZswBit::NoOff3), ProfileHindrance::Off3),
        (zsw_has(ZswBit::SwitchingOnInhibited), ProfileHindrance::Inhibited),
        (!stopped && !off && !zsw_has(ZswBit::ReadyToSwitchOn), ProfileHindrance::NotReadyToSwitchOn),
        (!stw_has(StwBit::On) && !zsw_has(ZswBit::SwitchingOnInhibited), ProfileHindrance::NotOn),
        (!stw_has(StwBit::EnableOperation), ProfileHindrance::NotEnabled),
        (
            commanded
                && !stopped
                && !off
                && zsw_has(ZswBit::ReadyToSwitchOn)
                && !zsw_has(ZswBit::OperationEnabled),
            ProfileHindrance::NotInOperation,
        ),
        (!stw_has(StwBit::EnableRamp), ProfileHindrance::RampDisabled),
        (!stw_has(StwBit::RunRamp), ProfileHindrance::RampFrozen),
        (!stw_has(StwBit::EnableSetpoint), ProfileHindrance::SetpointDisabled),
    ]
    .into_iter()
    .filter_map(|(stands, hindrance)| stands.then_some(hindrance))
}

#[cfg(test)]
mod tests {

    use super::*;

    #[test]
    fn each_hindrance_is_found_by_its_bits() {
        for (stw, zsw, expected) in [
            (0x047F, 0x0337, &[][..]),
            (0x047F, 0x0240, &[ProfileHindrance::Off2, ProfileHindrance::Off3, ProfileHindrance::Inhibited]),
            (0x047F, 0x0270, &[ProfileHindrance::Inhibited]),
            (0x047F, 0x0238, &[ProfileHindrance::Fault]),
            (0x007F, 0x0231, &[ProfileHindrance::NotByPlc]),
            (0x047E, 0x0231, &[ProfileHindrance::NotOn]),
            (0x0477, 0x0233, &[ProfileHindrance::NotEnabled]),
            (0x047F, 0x0233, &[ProfileHindrance::NotInOperation]),
            (0x047F, 0x0230, &[ProfileHindrance::NotReadyToSwitchOn]),
            (0x046F, 0x0337, &[ProfileHindrance::RampDisabled]),
            (0x045F, 0x0337, &[ProfileHindrance::RampFrozen]),
            (0x043F, 0x0337, &[ProfileHindrance::SetpointDisabled]),
        ] {
            let found: Vec<_> = hindrances(Stw::from_raw(stw), Zsw::from_raw(zsw)).collect();
            assert_eq!(found, expected, "{stw:04X} {zsw:04X}");
        }
    }
}
