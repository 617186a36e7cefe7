//! The states of the drive in the words that all devices share.

use crate::devices::ag03::drive;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::devices::ag03::drive::{Motor, State};

    #[test]
    fn each_state_has_one_of_the_common_names() {
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
    }
}
