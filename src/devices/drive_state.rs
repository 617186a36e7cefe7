//! The states of CiA 402 in the words that all devices share. A device with a machine of its own says so in its folder.

use crate::can_bus::cia402;
use crate::face::DriveState;

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_of_the_profile_have_one_of_the_common_names() {
        assert_eq!(DriveState::from(cia402::State::SwitchedOn).name(), "ready");
        let names: heapless::Vec<_, 8> = DriveState::ALL.iter().map(|state| state.name()).collect();
        assert!(names.iter().enumerate().all(|(at, name)| !names[..at].contains(name)), "{names:?}");
    }
}
