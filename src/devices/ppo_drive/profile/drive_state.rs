//! The states of the machine in the words that all devices share.

use crate::devices::ppo_drive::State;
use crate::face::DriveState;

impl From<State> for DriveState {
    fn from(state: State) -> Self {
        match state {
            State::SwitchingOnInhibited => Self::Inhibited,
            State::ReadyToSwitchOn | State::Ready => Self::Ready,
            State::Operation | State::SwitchingOff(_) => Self::Enabled,
            State::Fault => Self::Fault,
        }
    }
}
