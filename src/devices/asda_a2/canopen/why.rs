//! What keeps the drive behind a node from moving now, in words of CANopen.

use core::fmt;

use super::AsdaA2;
use crate::can_bus::cia402::{Controlword, Mode, State};
use crate::devices::asda_a2::{Level, Setting};
use crate::devices::reasons;
use crate::face::{Reason, Why};

impl Why for AsdaA2 {
    fn is_moving(&self) -> Option<bool> {
        Some(self.servo().velocity_demand() != 0)
    }

    fn each_reason(&self, tell: &mut dyn FnMut(Reason<'_>)) {
        let servo = self.servo();
        let Some(nmt) = self.node.state() else { return tell(reasons::SWITCHED_OFF) };
        reasons::of_node(nmt, self.node.sync_missing(), tell);
        let state = servo.state();
        let enabled = state == State::OperationEnabled;
        // An enabled drive goes on with a warning; at a limit switch in one direction only.
        for alarm in servo.alarms().iter().filter(|alarm| !enabled || alarm.text().contains("limit")) {
            tell(Reason::new("Alarm", &format_args!("alarm {alarm}: {}", alarm.text())));
        }
        let mut tell_if = |holds: bool, reason: Reason<'_>| {
            if holds {
                tell(reason);
            }
        };
        tell_if(!servo.inputs().main_circuit, Reason::new("MainCircuit", &"the main circuit has no supply"));
        tell_if(servo.mode().is_none(), reasons::NO_MODE);
        let cure = to_enable(state, servo.level());
        tell_if(!enabled, Reason::new("NotEnabled", &format_args!("drive state '{state}': {cure}")));
        tell_if(enabled && servo.controlword().has(Controlword::HALT), reasons::HALT);
        let stands =
            servo.mode() == Some(Mode::ProfilePosition) && servo.settings().of(Setting::ProfileVelocity) == 0;
        tell_if(enabled && stands, Reason::new("NoVelocity", &"the profile velocity is 0: write 6081h"));
        tell_if(servo.inputs().blocked, Reason::new("Blocked", &"the shaft is blocked"));
    }

    fn waits(&self) -> Option<&dyn fmt::Display> {
        Some(reasons::waits_for(self.servo().mode(), self.servo().controlword()))
    }
}

/// What to send until operation is enabled.
const fn to_enable(state: State, level: Level) -> &'static str {
    match (state, level) {
        (State::Fault | State::FaultReactionActive, Level::Half | Level::Full) => {
            "remove the cause of the alarm, then send 6040h = 0080h (bit 7 from 0 to 1)"
        }
        (State::QuickStopActive, Level::Half | Level::Full) => "send 6040h = 0000h, then 0006h",
        // One control word is enough.
        (
            State::NotReadyToSwitchOn | State::SwitchOnDisabled | State::ReadyToSwitchOn | State::SwitchedOn,
            Level::Half,
        ) => State::SwitchedOn.to_enable(),
        (
            State::NotReadyToSwitchOn | State::SwitchOnDisabled | State::ReadyToSwitchOn | State::SwitchedOn,
            Level::Full,
        )
        | (State::OperationEnabled, Level::Half | Level::Full) => state.to_enable(),
    }
}
