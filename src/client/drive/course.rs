//! Enabling and acknowledging of an AG03 as words and bits, by the flow charts.

use super::control_word::ControlWord;
use crate::client::course::{Bits, Course, Step};
use crate::devices::ag03::drive::Mode;
use crate::devices::ag03::profibus::bits::ZswBit;
use crate::devices::ag03::profibus::flow_charts::operation_enabled;
use crate::profibus::ppo::ZswPattern;

type Row = Step<ControlWord, ()>;

const NO_FAULT: Bits = Bits::clear(ZswBit::Fault.mask());
const NOT_INHIBITED: Bits = Bits::clear(ZswBit::TurnOnDisabled.mask());

/// Without bits it ends when a parameter was read: the drive has seen the word then.
const fn row(word: ControlWord, until: &'static [Bits]) -> Row {
    Step::new(word, until, ())
}

/// OFF1, from 1 to 0.
const RELEASE: &[Row] = &[row(ControlWord::Disabled, &[]), row(ControlWord::Off1, &[NOT_INHIBITED])];
const CLEAR: &[Row] = &[row(ControlWord::Disabled, &[]), row(ControlWord::Acknowledging, &[NO_FAULT])];

const POSITIONING: Bits = bits(operation_enabled(Mode::Positioning), Mode::Positioning);
const VELOCITY: Bits = bits(operation_enabled(Mode::Velocity), Mode::Velocity);
const ENABLE_POSITIONING: &[Row] = &[row(ControlWord::Enabled, &[POSITIONING])];
const ENABLE_VELOCITY: &[Row] = &[row(ControlWord::Enabled, &[VELOCITY])];

/// Up to operation enabled.
pub(super) const fn enabling(mode: Mode, inhibited: bool) -> Course<ControlWord, ()> {
    let enable = match mode {
        Mode::Positioning => ENABLE_POSITIONING,
        Mode::Velocity => ENABLE_VELOCITY,
    };
    if inhibited { Course::and_then(RELEASE, enable) } else { Course::new(enable) }
}

/// Until there is no fault, and turning on is not disabled.
pub(super) const fn acknowledging(fault: bool) -> Course<ControlWord, ()> {
    if fault { Course::and_then(CLEAR, RELEASE) } else { Course::new(RELEASE) }
}

/// The bits of a pattern, with any ZSW.14 in velocity mode: one table has 1 there, the charts have 0 (C-03).
pub(super) const fn bits(pattern: ZswPattern, mode: Mode) -> Bits {
    let mask = match mode {
        Mode::Positioning => pattern.mask,
        Mode::Velocity => pattern.mask & !ZswBit::LimitExceeded.mask(),
    };
    Bits { mask, value: pattern.value & mask }
}
