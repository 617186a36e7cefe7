//! Control and status word in the names of the flow charts.

use super::bits::{Role, StwBit, Word, ZswBit, bits};
use super::flow_charts::{
    DISABLED, ENABLED, INCHING_1, INCHING_2_NEGATIVE, INCHING_2_POSITIVE, PAUSED, START, STOPPED, TRAVEL,
    VELOCITY,
};
use crate::devices::ag03::drive::Mode;
use crate::devices::named_word::{NamedWord, NamedWords};

/// Both words.
pub(crate) const NAMED_WORDS: NamedWords = NamedWords { stw: STW, zsw: ZSW };

fn keys(word: Word, mode: Mode) -> [Option<&'static str>; 16] {
    bits(word, mode, None).map(|bit| Some(bit.key).filter(|_| bit.role != Role::Unused))
}

/// Control words (`ag03.md` 4 and 7).
const STW: NamedWord = NamedWord {
    name: Word::Stw.name(),
    bits: |mode| keys(Word::Stw, mode),
    states: &[
        ("off", Some(0), Some(0)),
        ("enable", Some(ENABLED), Some(ENABLED)),
        ("prepare", Some(TRAVEL), None),
        ("start", Some(TRAVEL | START), None),
        ("run", None, Some(VELOCITY)),
        // These follow start: its bit 6 stays, for a change would be another job.
        ("pause", Some(PAUSED | START), None),
        ("resume", Some(TRAVEL | START), None),
        ("stop", Some(STOPPED | START), Some(ENABLED)),
        ("disable", Some(DISABLED), Some(DISABLED)),
        ("off1", Some(ENABLED & !StwBit::On.mask()), Some(ENABLED & !StwBit::On.mask())),
        ("off2", Some(ENABLED & !StwBit::NoOff2.mask()), Some(ENABLED & !StwBit::NoOff2.mask())),
        (
            "acknowledge",
            Some(ENABLED | StwBit::Acknowledge.mask()),
            Some(ENABLED | StwBit::Acknowledge.mask()),
        ),
        ("inch1", Some(INCHING_1), None),
        ("jog+", Some(INCHING_2_POSITIVE), None),
        ("jog-", Some(INCHING_2_NEGATIVE), None),
    ],
};

/// Status words (`ag03.md` 5), without OFF2, warning and limit.
const ZSW: NamedWord = NamedWord {
    name: Word::Zsw.name(),
    bits: |mode| keys(Word::Zsw, mode),
    states: &[
        ("ready-to-run", Some(STANDS), Some(STANDS_IN_VELOCITY_MODE)),
        ("ready-to-travel", Some(STANDS | READY), Some(STANDS_IN_VELOCITY_MODE | READY)),
        ("travelling", Some(TRAVELS), Some(TRAVELS_IN_VELOCITY_MODE)),
        ("arrived", Some(STANDS | READY | ZswBit::TargetReached.mask()), None),
        ("fault", Some(STANDS | FAULT), Some(STANDS_IN_VELOCITY_MODE | FAULT)),
        (
            "turn-on-disabled",
            Some(STANDS | TURN_ON_DISABLED),
            Some(STANDS_IN_VELOCITY_MODE | TURN_ON_DISABLED),
        ),
    ],
};

/// Ready to turn on, no OFF2, standing still.
const STANDS: u16 = NOT_ENABLED | ZswBit::NoLagError.mask() | ZswBit::Standstill.mask();
const STANDS_IN_VELOCITY_MODE: u16 = NOT_ENABLED | FIXED_IN_VELOCITY_MODE | ZswBit::Standstill.mask();
const TRAVELS: u16 = NOT_ENABLED | ZswBit::NoLagError.mask() | ENABLED_NOW;
const TRAVELS_IN_VELOCITY_MODE: u16 = NOT_ENABLED | FIXED_IN_VELOCITY_MODE | ENABLED_NOW;
const READY: u16 = ENABLED_NOW | ZswBit::ReadyToTravel.mask();
const FAULT: u16 = ZswBit::Fault.mask();
const TURN_ON_DISABLED: u16 = ZswBit::TurnOnDisabled.mask();

const ENABLED_NOW: u16 = ZswBit::OperationEnabled.mask();
const FIXED_IN_VELOCITY_MODE: u16 = ZswBit::TargetReached.mask() | ZswBit::JobToggle.mask();
/// Supplies present, no OFF2, and what is always 1.
const NOT_ENABLED: u16 = ZswBit::ReadyToTurnOn.mask()
    | ZswBit::Ready.mask()
    | ZswBit::NoOff2.mask()
    | ZswBit::NoOff3.mask()
    | ZswBit::ControlRequested.mask()
    | ZswBit::ReferencePointSet.mask();
