//! Which inputs make which fault of this drive, with its gear and its constants.

use super::{EMPTY_BATTERY, HIGH_DC_LINK, HOT_STAGE, LOW_SUPPLY, LOW_SUPPLY_CURRENT, OVERCURRENT, Plant};
use crate::devices::ag03::drive::Drive;
use crate::devices::ag03::drive::faults::{Fault, FaultSet};
use crate::devices::ag03::drive::inputs::Inputs;

impl Drive {
    /// `inputs` with what makes `fault` on this drive: [`Inputs::provoking`], and a friction that suits its gear and its
    /// constants: for A one that takes more than 200 mA in steady travel, too (0.4 Nm with 48:1, 0.2 Nm with 24:1), for C
    /// one that takes too much (5 Nm, 2.5 Nm).
    #[must_use]
    pub fn provoking(&self, inputs: &Inputs, fault: Fault) -> Inputs {
        let inputs = inputs.provoking(fault);
        match fault {
            Fault::A => Inputs { friction_torque: inputs.friction_torque.max(self.plant.strain()), ..inputs },
            Fault::C => Inputs { friction_torque: self.plant.overload(), ..inputs },
            Fault::B | Fault::D | Fault::E | Fault::F | Fault::G | Fault::H | Fault::I | Fault::J => inputs,
        }
    }

    /// `inputs` without what [`provoking`](Self::provoking) changes for `fault`.
    pub(crate) fn relieved(&self, inputs: &Inputs, fault: Fault) -> Inputs {
        let usual = Inputs::default();
        let Inputs { control_supply, output_supply, friction_torque, battery, .. } = usual;
        match fault {
            Fault::A if inputs.friction_torque == self.plant.strain() => {
                Inputs { control_supply, output_supply, friction_torque, ..*inputs }
            }
            Fault::A => Inputs { control_supply, output_supply, ..*inputs },
            Fault::B => Inputs { blocked: false, ..*inputs },
            Fault::C => Inputs { friction_torque, ..*inputs },
            Fault::D => Inputs { stage_temperature: None, ..*inputs },
            Fault::E => Inputs { encoder_fault: false, ..*inputs },
            Fault::F => Inputs { internal_fault: false, ..*inputs },
            Fault::G => Inputs { dc_link: None, ..*inputs },
            Fault::J => Inputs { battery, ..*inputs },
            // Of the bus.
            Fault::H | Fault::I => *inputs,
        }
    }

    /// The faults that `inputs` make on this drive: D, E, F, G and J at once, A, B and C as soon as the shaft is commanded to turn
    /// (with a load: against it). B and C are here though nothing turns now and `Drive::causes` knows nothing of
    /// them: acknowledged, they come back with the next travel.
    pub fn provoked_by(&self, inputs: &Inputs) -> FaultSet {
        self.plant.provoked_by(inputs)
    }
}

impl Plant {
    /// A friction that the motor overcomes with too much current, Nm.
    fn overload(&self) -> f64 {
        self.friction_for(OVERCURRENT + (self.constants.peak_current - OVERCURRENT) / 3.0)
    }

    /// A friction that takes more current than a low supply allows, Nm; none if the motor alone does.
    fn strain(&self) -> f64 {
        self.friction_for(LOW_SUPPLY_CURRENT * 1.5).max(0.0)
    }

    /// The friction that takes a current in steady travel, Nm.
    fn friction_for(&self, current: f64) -> f64 {
        let torque = (current - self.constants.idle_current) * self.torque_per_ampere;
        // Of a number for people two digits are enough.
        libm::round(torque * 100.0) / 100.0
    }

    fn provoked_by(&self, inputs: &Inputs) -> FaultSet {
        let lowest = inputs.lowest_supply(self.model);
        let motor = inputs.motor_supply(self.model);
        let hindrance = inputs.friction_torque + inputs.load_torque.abs();
        let current = self.constants.idle_current + hindrance / self.torque_per_ampere;
        let stalls = self.supplies(motor) && current >= self.possible_current(motor, 0.0);
        let made = [
            (Fault::A, lowest < LOW_SUPPLY && self.supplies(lowest)),
            (Fault::B, inputs.blocked || stalls),
            (Fault::C, current > OVERCURRENT && !stalls),
            (Fault::D, inputs.stage_temperature.unwrap_or(inputs.ambient) > HOT_STAGE),
            (Fault::E, inputs.encoder_fault),
            (Fault::F, inputs.internal_fault),
            (Fault::G, inputs.dc_link.unwrap_or(motor) > HIGH_DC_LINK),
            (Fault::J, inputs.battery < EMPTY_BATTERY),
        ];
        let made = made.into_iter().filter(|(fault, made)| *made && fault.exists_on(self.model));
        made.map(|(fault, _)| fault).collect()
    }
}
