//! What the control word and the status word of such a drive say against turning.

use super::{StwBit, ZswBit};
use crate::face::Reason;
use crate::profibus::ppo::{Stw, Zsw};

const NOT_BY_PLC: Reason<'static> =
    Reason::new("NotByPlc", &"the drive ignores the control word: set STW bit 10 (control by PLC)");
const FAULT: Reason<'static> =
    Reason::new("Fault", &"a fault: remove its cause and acknowledge it (STW bit 7 from 0 to 1)");
const OFF2: Reason<'static> =
    Reason::new("Off2", &"OFF2: set STW bit 1, and check the OFF2 input at the terminals of the drive");
const OFF3: Reason<'static> =
    Reason::new("Off3", &"OFF3: set STW bit 2, and check the OFF3 input at the terminals of the drive");
const INHIBITED: Reason<'static> =
    Reason::new("Inhibited", &"switching on is inhibited: give OFF1 once (STW bit 0 = 0, bits 1 and 2 = 1)");
const NOT_READY: Reason<'static> =
    Reason::new("NotReadyToSwitchOn", &"not ready for switching on: check the supplies of the drive");
const NOT_ON: Reason<'static> = Reason::new("NotOn", &"OFF1: set STW bit 0 (ON)");
const NOT_ENABLED: Reason<'static> = Reason::new("NotEnabled", &"operation is not enabled: set STW bit 3");
const NOT_IN_OPERATION: Reason<'static> = Reason::new(
    "NotInOperation",
    &"all bits are set, but the drive does not enable operation: check its enable inputs",
);
const RAMP_DISABLED: Reason<'static> =
    Reason::new("RampDisabled", &"the output of the ramp generator is 0: set STW bit 4");
const RAMP_FROZEN: Reason<'static> = Reason::new("RampFrozen", &"the ramp generator is held: set STW bit 5");
const SETPOINT_DISABLED: Reason<'static> =
    Reason::new("SetpointDisabled", &"the setpoint is not enabled: set STW bit 6");

/// What stands against turning, the first thing to do first. A drive against which nothing stands turns with its setpoint.
pub fn reasons(stw: Stw, zsw: Zsw) -> impl Iterator<Item = Reason<'static>> {
    let (stw_has, zsw_has) = (|bit: StwBit| bit.is_set(stw), |bit: ZswBit| bit.is_set(zsw));
    let (fault, inhibited) = (zsw_has(ZswBit::Fault), zsw_has(ZswBit::SwitchingOnInhibited));
    let ready = zsw_has(ZswBit::ReadyToSwitchOn);
    let commanded = stw_has(StwBit::On) && stw_has(StwBit::EnableOperation) && stw_has(StwBit::ByPlc);
    let off2 = !stw_has(StwBit::NoOff2) || !zsw_has(ZswBit::NoOff2);
    let off3 = !stw_has(StwBit::NoOff3) || !zsw_has(ZswBit::NoOff3);
    let startable = !fault && !inhibited && !off2 && !off3;
    let enabled = zsw_has(ZswBit::OperationEnabled);
    let all = [
        (!stw_has(StwBit::ByPlc), NOT_BY_PLC),
        (fault, FAULT),
        (off2, OFF2),
        (off3, OFF3),
        (inhibited, INHIBITED),
        (startable && !ready, NOT_READY),
        (!stw_has(StwBit::On) && !inhibited, NOT_ON),
        (!stw_has(StwBit::EnableOperation), NOT_ENABLED),
        (commanded && startable && ready && !enabled, NOT_IN_OPERATION),
        (!stw_has(StwBit::EnableRamp), RAMP_DISABLED),
        (!stw_has(StwBit::RunRamp), RAMP_FROZEN),
        (!stw_has(StwBit::EnableSetpoint), SETPOINT_DISABLED),
    ];
    all.into_iter().filter_map(|(stands, reason)| stands.then_some(reason))
}

/// Those of them that stand without a control word, too.
#[cfg(feature = "std")]
pub(in crate::devices::ppo_drive) fn reasons_of_drive(zsw: Zsw) -> impl Iterator<Item = Reason<'static>> {
    let all = [(ZswBit::Fault, FAULT), (ZswBit::SwitchingOnInhibited, INHIBITED)];
    all.into_iter().filter_map(move |(bit, reason)| bit.is_set(zsw).then_some(reason))
}

#[cfg(test)]
mod tests {

    use super::*;

    #[test]
    fn each_reason_is_found_by_its_bits() {
        for (stw, zsw, expected) in [
            (0x047F, 0x0337, &[][..]),
            (0x047F, 0x0240, &["Off2", "Off3", "Inhibited"]),
            (0x047F, 0x0270, &["Inhibited"]),
            (0x047F, 0x0238, &["Fault"]),
            (0x007F, 0x0231, &["NotByPlc"]),
            (0x047E, 0x0231, &["NotOn"]),
            (0x0477, 0x0233, &["NotEnabled"]),
            (0x047F, 0x0233, &["NotInOperation"]),
            (0x047F, 0x0230, &["NotReadyToSwitchOn"]),
            (0x046F, 0x0337, &["RampDisabled"]),
            (0x045F, 0x0337, &["RampFrozen"]),
            (0x043F, 0x0337, &["SetpointDisabled"]),
        ] {
            let found: Vec<_> =
                reasons(Stw::from_raw(stw), Zsw::from_raw(zsw)).map(|reason| reason.name).collect();
            assert_eq!(found, expected, "{stw:04X} {zsw:04X}");
        }
    }
}
