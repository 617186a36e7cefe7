//! The states of every device's machine in the words that all devices share.

use super::ag03::canopen::state as ag03;
use super::ag03::drive;
#[cfg(feature = "std")]
use super::ppo_drive;
use crate::can_bus::cia402;
use crate::face::DriveState;

impl From<drive::State> for DriveState {
    fn from(state: drive::State) -> Self {
        use drive::State;
        match state {
            State::Off => Self::Off,
            State::NotReady => Self::NotReady,
            State::TurnOnDisabled => Self::Inhibited,
            State::ReadyToRun(_) => Self::Ready,
            State::OperationEnabled(_)
            | State::Disabling
            | State::TravelActive
            | State::Pausing { .. }
            | State::Paused { .. }
            | State::Stopping
            | State::Inching(_)
            | State::VelocityTravelling
            | State::KeyInching(_)
            | State::KeyInchingEnding => Self::Enabled,
            State::Fault => Self::Fault,
        }
    }
}

#[cfg(feature = "std")]
impl From<ppo_drive::State> for DriveState {
    fn from(state: ppo_drive::State) -> Self {
        use ppo_drive::State;
        match state {
            State::SwitchingOnInhibited => Self::Inhibited,
            State::ReadyToSwitchOn | State::Ready => Self::Ready,
            State::Operation | State::SwitchingOff(_) => Self::Enabled,
            State::Fault => Self::Fault,
        }
    }
}

impl From<cia402::State> for DriveState {
    fn from(state: cia402::State) -> Self {
        use cia402::State;
        match state {
            State::NotReadyToSwitchOn => Self::NotReady,
            State::SwitchOnDisabled => Self::Inhibited,
            State::ReadyToSwitchOn | State::SwitchedOn => Self::Ready,
            State::OperationEnabled | State::QuickStopActive => Self::Enabled,
            State::FaultReactionActive | State::Fault => Self::Fault,
        }
    }
}

impl From<ag03::State> for DriveState {
    fn from(state: ag03::State) -> Self {
        use ag03::State;
        match state {
            State::SwitchOnDisabled => Self::Inhibited,
            State::ReadyToSwitchOn | State::SwitchedOn => Self::Ready,
            State::OperationEnabled | State::QuickStopActive => Self::Enabled,
            State::Fault => Self::Fault,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_of_every_machine_have_one_of_the_common_names() {
        use crate::devices::ag03::drive::{Motor, State};
        for (state, name) in [
            (State::Off, "off"),
            (State::NotReady, "not_ready"),
            (State::TurnOnDisabled, "inhibited"),
            (State::ReadyToRun(Motor::Released), "ready"),
            (State::OperationEnabled(Motor::InControl), "enabled"),
            (State::TravelActive, "enabled"),
            (State::Disabling, "enabled"),
            (State::Fault, "fault"),
        ] {
            assert_eq!(DriveState::from(state).name(), name, "{state:?}");
        }
        assert_eq!(DriveState::from(cia402::State::SwitchedOn).name(), "ready");
        assert_eq!(DriveState::from(ag03::State::QuickStopActive).name(), "enabled");
        let names: heapless::Vec<_, 8> = DriveState::ALL.iter().map(|state| state.name()).collect();
        assert!(names.iter().enumerate().all(|(at, name)| !names[..at].contains(name)), "{names:?}");
    }
}
