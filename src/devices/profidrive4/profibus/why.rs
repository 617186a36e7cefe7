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
        of_slave(state, &self.slave().diagnosis(), CFG_ADVICE, tell);
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
        reasons(stw, zsw_of_drive).filter(|reason| is_led || of_drive(reason)).for_each(&mut *tell);
        let command = self.drive().command();
        let operates = status.state == State::Operation && ZswBit::OperationEnabled.is_set(zsw);
        if operates && command.torque_reduction >= 1.0 {
            tell(NO_TORQUE);
        }
        let Setpoint::Speed(speed) = command.setpoint;
        if operates && speed == 0.0 {
            tell(SETPOINT_ZERO);
        }
    }
}
