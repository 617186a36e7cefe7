//! What a drive is: its model and gear, power, mode and EEPROM.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::super::inputs::PowerName;
use crate::devices::ag03::drive::Mode;
use crate::devices::ag03::param::{Gear, Model};
use crate::devices::ag03::profibus::{EepromState, Power};

/// A model as it is named in JSON and on the command line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub(in crate::panel) enum ModelName {
    #[serde(rename = "ag03")]
    Ag03,
    #[default]
    #[serde(rename = "ag03-1")]
    Ag03_1,
}

/// The operating mode, PNU 930.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub(in crate::panel) enum ModeName {
    Positioning,
    Velocity,
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

impl From<Model> for ModelName {
    fn from(model: Model) -> Self {
        match model {
            Model::Ag03 => Self::Ag03,
            Model::Ag03_1 => Self::Ag03_1,
        }
    }
}

impl From<ModelName> for Model {
    fn from(name: ModelName) -> Self {
        match name {
            ModelName::Ag03 => Self::Ag03,
            ModelName::Ag03_1 => Self::Ag03_1,
        }
    }
}

/// The gear of a ratio.
pub(in crate::panel) fn gear(ratio: u16) -> Option<Gear> {
    Gear::ALL.into_iter().find(|gear| gear.ratio() == ratio)
}

impl From<Power> for PowerName {
    fn from(power: Power) -> Self {
        match power {
            Power::Off => Self::Off,
            Power::On => Self::On,
            Power::FactoryReset(_) => Self::FactoryReset,
        }
    }
}

impl From<Mode> for ModeName {
    fn from(mode: Mode) -> Self {
        match mode {
            Mode::Positioning => Self::Positioning,
            Mode::Velocity => Self::Velocity,
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
