//! What keeps the drive of a file from moving now, in words of CANopen.

use core::fmt;

use super::drive::{Axis, Driven};
use super::names::OfAxis;
use crate::can_bus::cia402::{Controlword, Mode, State};
use crate::devices::reasons;
use crate::face::{Reason, Why};

const MAIN_CIRCUIT: Reason<'static> = Reason::new("MainCircuit", &"the main circuit has no supply");
const EMERGENCY_STOP: Reason<'static> = Reason::new("EmergencyStop", &"the emergency stop is not released");
const BLOCKED: Reason<'static> = Reason::new("Blocked", &"the shaft is blocked");
const LIMITED: Reason<'static> = Reason::new(
    "InternalLimit",
    &"a limit of position (607Dh, limit switch) or torque (6072h) is reached (bit 11 of 6041h)",
);
const RAMP: Reason<'static> =
    Reason::new("RampDisabled", &"vl follows 6042h with bits 4 to 6 of 6040h: send 6040h = 007Fh");
const INTERPOLATION: Reason<'static> =
    Reason::new("IpDisabled", &"ip follows 60C1h with bit 4 of 6040h: send 6040h = 001Fh");

impl Why for Driven {
    /// Whether all axes move.
    fn is_moving(&self) -> Option<bool> {
        Some(self.axes.iter().all(|axis| axis.drive.is_moving()))
    }

    fn each_reason(&self, tell: &mut dyn FnMut(Reason<'_>)) {
        let Some(nmt) = self.nmt else { return tell(reasons::SWITCHED_OFF) };
        reasons::of_node(nmt, self.awaits, tell);
        for axis in &self.axes {
            axis.each_reason(&mut |Reason { name, text }| {
                tell(Reason::new(name, &OfAxis(axis.number(), text)));
            });
        }
    }

    /// Of the first axis.
    fn waits(&self) -> Option<&dyn fmt::Display> {
        let drive = &self.axes.first()?.drive;
        Some(reasons::waits_for(drive.mode(), drive.controlword()))
    }
}

impl Axis {
    fn each_reason(&self, tell: &mut dyn FnMut(Reason<'_>)) {
        let drive = &self.drive;
        if let Some(fault) = drive.fault() {
            tell(Reason::new("Fault", &format_args!("fault {:04X}h: {}", fault.0, fault.text())));
        }
        let (state, mode, word) = (drive.state(), drive.mode(), drive.controlword());
        let enabled = state == State::OperationEnabled;
        let bits = |mask: u16| word.has(Controlword(mask));
        let mut tell_if = |holds: bool, reason: Reason<'_>| {
            if holds {
                tell(reason);
            }
        };
        tell_if(!drive.inputs().emergency_stop_released, EMERGENCY_STOP);
        tell_if(!drive.inputs().main_circuit, MAIN_CIRCUIT);
        tell_if(mode.is_none(), reasons::NO_MODE);
        let cure = state.to_enable();
        tell_if(!enabled, Reason::new("NotEnabled", &format_args!("drive state '{state}': {cure}")));
        tell_if(enabled && word.has(Controlword::HALT), reasons::HALT);
        tell_if(enabled && mode == Some(Mode::Velocity) && !bits(0x70), RAMP);
        tell_if(enabled && mode == Some(Mode::InterpolatedPosition) && !bits(0x10), INTERPOLATION);
        tell_if(enabled && drive.is_limited(), LIMITED);
        tell_if(drive.inputs().blocked, BLOCKED);
    }
}
