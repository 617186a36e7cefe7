//! What a node is made of.

use super::quirks::Quirks;
use crate::can_bus::canopen::policy::{
    ErrorControlRule, EventRule, LoadRule, OutOfRange, StateCheck, Storing,
};
use crate::can_bus::canopen::policy::{SyncProducer, TypeZero, WrongLength};
use crate::can_bus::canopen::{Abort, NodeId, Policy};
use crate::devices::ag03::drive;
use crate::devices::ag03::param;
use crate::devices::ag03::param::{Gear, Model};
use crate::devices::ag03::unit;
use crate::devices::ag03::unit::{ApplicationCycle, DipSwitches, Eeprom, dip};

/// What a node is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config {
    /// The DIP switches: node number, factory reset, bus terminator.
    pub switches: DipSwitches,
    /// Which switches ask for a factory reset; an assumption (CN-01).
    pub reset_patterns: dip::ResetPatterns,
    /// Where the EEPROM is kept.
    pub eeprom: Eeprom,
    /// Which internal gear.
    pub gear: Gear,
    /// How often the drive runs.
    pub application_cycle: ApplicationCycle,
    /// Which parameter rules hold where the manuals contradict themselves.
    pub param: param::Quirks,
    /// How the drive behaves where the manuals leave it open, and the numbers of its plant.
    pub drive: drive::Config,
    /// How the node behaves where CiA 301 leaves a choice.
    pub policy: Policy,
    /// How the device behaves where its manual leaves a choice.
    pub quirks: Quirks,
}

/// The deviations of the AG03/1 from CiA 301 (`canopen-ag03.md` 4 to 7).
const POLICY: Policy = Policy {
    segmented: false,
    unknown_command: Abort::UNSUPPORTED_ACCESS,
    wrong_length: WrongLength::One(Abort::UNSUPPORTED_ACCESS),
    out_of_range: OutOfRange::One(Abort::RANGE),
    state_check: StateCheck::Last,
    wrong_state: Abort::DEVICE_STATE,
    wrong_signature: Abort::RANGE,
    communication_groups: &[1],
    storing: Storing::OnWrite,
    load: LoadRule::Erase,
    change_while_valid: None,
    sync_producer: SyncProducer::Dropped,
    type_0: TypeZero::EverySync,
    type_254: EventRule::CIA_301,
    type_255: EventRule::TIMER,
    rpdo_limits: false,
    rpdo_short_emcy: false,
    life_guarding_error: ErrorControlRule { emcy: false, behaviour: false },
    error_behaviour: None,
    ..Policy::CIA_301
};

impl Config {
    /// An AG03/1 with gear 48:1 at this node number, with an application cycle of 1 ms, whose EEPROM lives as long as the
    /// node.
    pub fn new(switches: impl Into<DipSwitches>) -> Self {
        Self {
            switches: switches.into(),
            reset_patterns: dip::ResetPatterns::ASSUMED,
            eeprom: Eeprom::Internal,
            gear: Gear::Ratio48,
            application_cycle: ApplicationCycle::DEFAULT,
            param: param::Quirks {
                calibrate_by_value: true,
                d_pos_without_job: true,
                ..param::Quirks::default()
            },
            drive: drive::Config::default(),
            policy: POLICY,
            quirks: Quirks::default(),
        }
    }

    /// The unit behind the bus.
    pub(super) const fn unit(&self) -> unit::Config {
        let Self { gear, switches, reset_patterns, eeprom, param, drive, .. } = *self;
        unit::Config { model: Model::Ag03_1, gear, switches, reset_patterns, eeprom, param, drive }
    }
}

impl DipSwitches {
    /// The node number of SW1 to SW7: 0 is taken as 1.
    pub(crate) fn node_id(self) -> NodeId {
        NodeId::new(self.number()).unwrap_or(NodeId::MIN)
    }
}

impl From<NodeId> for DipSwitches {
    /// SW1 to SW7 at this number, the others OFF.
    fn from(node: NodeId) -> Self {
        Self::from_bits(node.number().into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_switches_are_the_node_number_and_0_is_1() {
        for (bits, node) in [(0, 1), (1, 1), (5, 5), (127, 127), (0x385, 5)] {
            assert_eq!(DipSwitches::from_bits(bits).node_id().number(), node, "{bits}");
        }
    }
}
