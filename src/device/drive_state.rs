//! The state of a drive in the few words that all devices share.

use strum::{IntoStaticStr, VariantArray};

use super::ag03_canopen::state as ag03;
#[cfg(feature = "std")]
use crate::ppo_drive;
use crate::{cia402, drive};

/// Where a drive is, whichever device and bus it has. What each device calls its own states is in its reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "snake_case")]
pub enum DriveState {
    /// No control supply.
    Off,
    /// A supply is missing, or the drive initialises itself.
    NotReady,
    /// OFF1, or shutdown, must be given once.
    Inhibited,
    /// Waits for ON, or for the enabling of operation. The motor does not follow the master.
    Ready,
    /// The motor follows the master, or brakes because it no longer does.
    Enabled,
    /// A fault is not acknowledged.
    Fault,
}

impl DriveState {
    /// Every state.
    pub const ALL: &'static [Self] = <Self as VariantArray>::VARIANTS;

    /// Its name for programs, as `not_ready`.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

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
        use crate::drive::{Motor, State};
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
