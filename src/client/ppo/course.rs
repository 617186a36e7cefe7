//! The steps to each goal of a drive of PROFIDRIVE version 2, as words and bits.

use super::PpoGoal;
use crate::client::course::{Bits, Course, Step};
use crate::devices::ppo_drive::profile::{StwBit, ZswBit};

/// OFF1 with everything else released: a drive that follows is ready to switch on.
pub(super) const OFF1: u16 = 0x047E;
/// Operation with the ramp generator and the setpoint released.
pub(super) const RUN: u16 = 0x047F;

/// What a step commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Act {
    /// The control word.
    Word(u16),
    /// The setpoint of the goal, until the speed is near it.
    Setpoint,
}

type Row = Step<Act, ()>;

const READY_TO_SWITCH_ON: u16 = 1 << ZswBit::ReadyToSwitchOn.number();
const ENABLED: u16 = 1 << ZswBit::OperationEnabled.number();
const READY: u16 = 1 << ZswBit::Ready.number();
const FAULT: u16 = 1 << ZswBit::Fault.number();
const ACKNOWLEDGE: u16 = 1 << StwBit::Acknowledge.number();

const OUT: Bits = Bits::clear(ENABLED | READY);
const OFF: Row = Step::new(Act::Word(OFF1), &[OUT.and(Bits::set(READY_TO_SWITCH_ON))], ());
const ON: Row = Step::new(Act::Word(RUN), &[Bits::set(ENABLED)], ());
const SPEED: Row = Step::new(Act::Setpoint, &[], ()).keeping(Bits::set(ENABLED)).moving();
const OUT_OF_OPERATION: Row = Step::new(Act::Word(OFF1), &[OUT], ());
const NO_FAULT: Row = Step::new(Act::Word(OFF1 | ACKNOWLEDGE), &[Bits::clear(FAULT)], ());

impl PpoGoal {
    /// A drive in operation needs no OFF1 for another speed.
    pub(super) const fn course(self, in_operation: bool) -> Course<Act, ()> {
        Course::new(match (self, in_operation) {
            (Self::Enable, false) => &[OFF, ON],
            (Self::Enable, true) => &[ON],
            (Self::Run(_), false) => &[OFF, ON, SPEED],
            (Self::Run(_), true) => &[ON, SPEED],
            (Self::Disable, false | true) => &[OUT_OF_OPERATION],
            (Self::Acknowledge, false | true) => &[NO_FAULT],
        })
    }
}
