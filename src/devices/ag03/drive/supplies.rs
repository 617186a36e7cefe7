//! What the supplies, the enable input and the battery are to a drive: worked out when the [`Inputs`] change, so that
//! a step need not.

use crate::devices::ag03::param::Model;

use super::faults::{Fault, FaultSet};
use super::inputs::Inputs;
use super::plant::{EMPTY_BATTERY, LOW_SUPPLY, Plant};
use super::scale::round;

/// The electrical side of the [`Inputs`] as the state machine and the measured values see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Supplies {
    /// The control has supply.
    pub(super) control: bool,
    /// AG03/1: the output stage is supplied. AG03: the enable input is active.
    pub(super) output_stage: bool,
    /// All supplies that `supply_ok` (ZSW.0) asks for.
    pub(super) ok: bool,
    /// The battery is low (SSW.12).
    pub(super) battery_low: bool,
    /// The lowest supply is there, but too low for a motor that turns (fault A).
    pub(super) low: bool,
    /// The causes of faults that are nothing but inputs (faults E, F and J).
    pub(super) causes: FaultSet,
    /// Supply the motor runs on, in 0.1 V (PNU 1040).
    pub(super) motor_decivolts: u16,
    /// Supply of the control, in 0.1 V (PNU 1041).
    pub(super) control_decivolts: u16,
    /// Battery in 0.01 V (PNU 1042).
    pub(super) battery_centivolts: u16,
}

impl Supplies {
    pub(super) fn of(model: Model, plant: &Plant, inputs: &Inputs) -> Self {
        let control = plant.supplies(inputs.control_supply);
        let output_stage = match model {
            Model::Ag03 => inputs.enable_input,
            Model::Ag03_1 => plant.supplies(inputs.output_supply),
        };
        let ok = match model {
            Model::Ag03 => control,
            Model::Ag03_1 => control && output_stage,
        };
        let lowest = inputs.lowest_supply(model);
        Self {
            control,
            output_stage,
            ok,
            // A supply that is missing is no fault (rows 1 and 3).
            low: lowest < LOW_SUPPLY && plant.supplies(lowest),
            causes: Fault::E.when(inputs.encoder_fault)
                | Fault::F.when(inputs.internal_fault)
                | Fault::J.when(inputs.battery < EMPTY_BATTERY),
            battery_low: plant.battery_low(inputs),
            motor_decivolts: word(inputs.motor_supply(model) * 10.0),
            control_decivolts: word(inputs.control_supply * 10.0),
            battery_centivolts: word(inputs.battery * 100.0),
        }
    }
}

/// A measured value as a parameter shows it, limited to what a word holds.
pub(super) fn word(value: f64) -> u16 {
    u16::try_from(round(value)).unwrap_or(u16::MAX)
}
