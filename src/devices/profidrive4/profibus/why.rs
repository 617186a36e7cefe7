//! What keeps the drive from turning now, the first thing to do first.

use super::ProfidriveDevice;
use super::application::TelegramOnly;
use crate::devices::ppo_drive::State;
use crate::devices::ppo_drive::profile::{ZswBit, reasons};
use crate::devices::profidrive4::Setpoint;
use crate::devices::reasons::of_slave;
use crate::face::{Reason, Why};
use crate::profibus::dp;
use crate::profibus::dp::Application;
use crate::profibus::ppo::{Stw, Zsw};

/// What is to be done about a refused Chk_Cfg.
const CFG_ADVICE: &str = "choose the module of a telegram that the drive has";

const MAIN_CIRCUIT: Reason<'static> =
    Reason::new("MainCircuit", &"the main circuit is not supplied: switch it on (input main_circuit)");
const EMERGENCY_STOP: Reason<'static> = Reason::new(
    "EmergencyStop",
    &"the emergency stop is not released: release it (input emergency_stop_released)",
);
const BLOCKED: Reason<'static> = Reason::new("Blocked", &"the shaft is blocked (input blocked)");
const SETPOINT_ZERO: Reason<'static> =
    Reason::new("SetpointZero", &"the setpoint of the speed is 0: send another");
const NO_TORQUE: Reason<'static> =
    Reason::new("NoTorque", &"the torque is reduced to 0 (MOMRED of 4000h): reduce it less");

const REJECTED: Reason<'static> = Reason::new("TaskRejected", &"tasks are rejected: set STW1 bit 4");
const STOPPED: Reason<'static> = Reason::new("IntermediateStop", &"intermediate stop: set STW1 bit 5");
const NO_VELOCITY: Reason<'static> =
    Reason::new("OverrideZero", &"OVERRIDE is 0: send another, 4000h is all of the velocity");
const NOT_REFERENCED: Reason<'static> = Reason::new(
    "NotReferenced",
    &"the position has no reference, absolute targets and blocks are refused: reference the axis (STW1 bit 11) or set the \
      reference",
);
const NO_TASK: Reason<'static> = Reason::new(
    "NoTask",
    &"the axis has no task: begin one (STW1 bit 6 from 0 to 1), jog (bits 8, 9) or reference it (bit 11)",
);

impl<A: Application> Why for ProfidriveDevice<TelegramOnly<A>> {
    fn verb(&self) -> &'static str {
        "turn"
    }

    fn is_moving(&self) -> Option<bool> {
        Some(!self.drive().status().stands)
    }

    fn each_reason(&self, tell: &mut dyn FnMut(Reason<'_>)) {
        let status = self.drive().status();
        if !status.stands {
            return;
        }
        let state = self.slave().state();
        of_slave(self.slave(), CFG_ADVICE, tell);
        let inputs = self.drive().inputs();
        let zsw = self.zsw1();
        for (stands, reason) in [
            (!inputs.main_circuit, MAIN_CIRCUIT),
            (!inputs.emergency_stop_released, EMERGENCY_STOP),
            (inputs.blocked, BLOCKED),
        ] {
            if stands {
                tell(reason);
            }
        }
        // Outside Data_Exchange the control word counts as 0 and says nothing.
        let is_led = state == dp::State::DataExch;
        let of_drive = |reason: &Reason<'_>| matches!(reason.name, "Fault" | "Inhibited");
        let (stw, zsw_of_drive) = (Stw::from_raw(self.stw1()), Zsw::from_raw(zsw));
        let positions = self.telegram().is_some_and(|telegram| telegram.positions());
        // Bits 4 to 6 are others there.
        let of_speed =
            |reason: &Reason<'_>| matches!(reason.name, "RampDisabled" | "RampFrozen" | "SetpointDisabled");
        let told = reasons(stw, zsw_of_drive).filter(|reason| is_led || of_drive(reason));
        told.filter(|reason| !(positions && of_speed(reason))).for_each(&mut *tell);
        let command = self.drive().command();
        let operates = status.state == State::Operation && ZswBit::OperationEnabled.is_set(zsw);
        if operates && command.torque_reduction >= 1.0 {
            tell(NO_TORQUE);
        }
        match command.setpoint {
            Setpoint::Speed(speed) if operates && speed == 0.0 => tell(SETPOINT_ZERO),
            Setpoint::Position(task) if operates => {
                let axis = self.drive().axis();
                for (stands, reason) in [
                    (!command.control.enable_ramp, REJECTED),
                    (!command.control.run_ramp, STOPPED),
                    (task.velocity_part == 0.0, NO_VELOCITY),
                    (!axis.referenced, NOT_REFERENCED),
                    (axis.by.is_none() && !axis.homing, NO_TASK),
                ] {
                    if stands {
                        tell(reason);
                    }
                }
            }
            Setpoint::Speed(_) | Setpoint::Position(_) => {}
        }
    }
}
