//! What a drive is: its gear, power and EEPROM. Model and mode say themselves what they are called.

use std::prelude::v1::*;

use serde::Serialize;
use utoipa::ToSchema;

use crate::device::{EepromState, Power};
use crate::param::Gear;

/// Whether it has control supply.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub(in crate::panel) enum PowerState {
    Off,
    On,
    /// Switched on with the DIP switches of a factory reset: only the LEDs work.
    FactoryReset,
}

/// How safe what the EEPROM holds is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum EepromName {
    /// Without a state directory: kept as long as the process runs.
    InMemory,
    /// The newest values are being written.
    Writing,
    /// Everything is in the file.
    Stored,
    /// The file could not be written.
    Failed,
}

/// The gear of a ratio.
pub(in crate::panel) fn gear(ratio: u16) -> Option<Gear> {
    Gear::ALL.into_iter().find(|gear| gear.ratio() == ratio)
}

impl From<Power> for PowerState {
    fn from(power: Power) -> Self {
        match power {
            Power::Off => Self::Off,
            Power::On => Self::On,
            Power::FactoryReset(_) => Self::FactoryReset,
        }
    }
}

impl From<EepromState> for EepromName {
    fn from(state: EepromState) -> Self {
        match state {
            EepromState::Internal => Self::InMemory,
            EepromState::Writing => Self::Writing,
            EepromState::Safe => Self::Stored,
            EepromState::Failed => Self::Failed,
        }
    }
}
