//! What a servo drive of CiA 402 tells of itself in words, whoever made it.

use core::fmt;

use crate::can_bus::cia402::{Command, Controlword, State};
use crate::face::{DeviceEvent, EventKind};
use crate::untold::Untold;

/// News that wait to be taken; the oldest make room. Without `std` nobody takes them.
const MAX_NEWS: usize = if cfg!(feature = "std") { 16 } else { 1 };

/// So many process data with bit 4 and another target are no master that is about to take bit 4 back.
const PATIENCE: u8 = 3;

/// What happened in a drive. `F`: its faults and warnings, in words.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum News<F> {
    /// The state machine moved.
    State { from: State, to: State },
    /// A control word asks for a state that it does not lead to from here.
    NoEffect { word: Controlword, state: State, supplied: bool },
    /// Another target came while bit 4 stayed 1.
    NotTaken { word: Controlword, target: i64 },
    /// 6098h is no method that the drive has.
    HomingRefused { method: i64 },
    /// A fault or a warning began.
    Raised { what: F, is_fault: bool },
    /// Faults were reset, or warnings have gone.
    Cleared,
}

impl<F> News<F> {
    /// Whether a control word that came after `before` asks for more than it got. `was` is the state before it.
    pub(crate) fn of_command(
        (word, before): (Controlword, Controlword),
        (was, state): (State, State),
        supplied: bool,
    ) -> Option<Self> {
        if word != before && exchanged(word) {
            return Some(Self::NoEffect { word, state, supplied });
        }
        // Neither of them enables anything; with bits that do, something else was meant.
        let lets_go = |state| {
            matches!(state, State::SwitchOnDisabled | State::ReadyToSwitchOn | State::SwitchedOn)
                && word.0 & 0b1001 != 0
        };
        let wanted = match word.command(before) {
            Command::DisableVoltage | Command::QuickStop if lets_go(state) => 3,
            Command::Shutdown => 1,
            Command::SwitchOn => 2,
            Command::EnableOperation => 3,
            Command::DisableVoltage | Command::QuickStop | Command::FaultReset => 0,
        };
        let reached = match state {
            State::NotReadyToSwitchOn
            | State::SwitchOnDisabled
            | State::QuickStopActive
            | State::FaultReactionActive
            | State::Fault => 0,
            State::ReadyToSwitchOn => 1,
            State::SwitchedOn => 2,
            State::OperationEnabled => 3,
        };
        let is_new = word != before && was == state;
        (is_new && reached < wanted).then_some(Self::NoEffect { word, state, supplied })
    }
}

impl<F: fmt::Display + fmt::Debug + Send + Sync + 'static> DeviceEvent for News<F> {
    fn kind(&self) -> EventKind {
        match self {
            Self::State { .. } | Self::Raised { is_fault: false, .. } | Self::Cleared => EventKind::Drive,
            Self::NoEffect { .. } | Self::HomingRefused { .. } => EventKind::CommandRefused,
            Self::NotTaken { .. } => EventKind::Hint,
            Self::Raised { is_fault: true, .. } => EventKind::Fault,
        }
    }
}

impl<F: fmt::Display> fmt::Display for News<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::State { from, to } => write!(f, "drive state '{from}' -> '{to}'"),
            Self::NoEffect { word, .. } if exchanged(*word) => write!(
                f,
                "the octets of 6040h = {:04X}h seem to be exchanged: {:04X}h was meant; send the low octet first",
                word.0,
                word.0.swap_bytes()
            ),
            Self::NoEffect { word, state: State::SwitchedOn, supplied: false } => write!(
                f,
                "6040h = {:04X}h has no effect in '{}': the main circuit is not supplied; switch its supply on",
                word.0,
                State::SwitchedOn
            ),
            Self::NoEffect { word, state, .. } => {
                write!(f, "6040h = {:04X}h has no effect in '{state}': ", word.0)?;
                match word.0 & 0b110 {
                    0b110 => Ok(()),
                    0b010 => f.write_str("its bit 2 is 0 (quick stop), "),
                    _ => f.write_str("its bit 1 is 0 (disable voltage), "),
                }?;
                f.write_str(state.to_enable())
            }
            Self::NotTaken { word, target } => {
                let without = word.0 & !Controlword::NEW_SET_POINT.0;
                write!(
                    f,
                    "hint: the target 607Ah = {target} is not taken: bit 4 of 6040h is 1 already, only its change from 0 to 1 \
                     takes one; next: send 6040h = {without:04X}h, then {:04X}h",
                    word.0
                )
            }
            Self::HomingRefused { method } => write!(
                f,
                "homing refused: 6098h = {method} is no method of this drive; set another one, then bit 4 of 6040h from 0 to 1"
            ),
            Self::Raised { what, is_fault } => {
                write!(f, "{}: {what}", if *is_fault { "fault" } else { "warning" })
            }
            Self::Cleared => f.write_str("no fault and no warning is left"),
        }
    }
}

/// Whether a word has nothing in its low octet, and the command of one that enables in the high one: nobody means that.
const fn exchanged(word: Controlword) -> bool {
    word.0 & 0xFF == 0 && word.0.swap_bytes() & 0b110 == 0b110
}

/// News until they are taken.
pub(crate) type NewsUntold<F> = Untold<News<F>, MAX_NEWS>;

/// Which target position was taken last, and how often another one came while bit 4 stayed 1.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Targets {
    taken: Option<i64>,
    missed: u8,
}

impl Targets {
    /// Bit 4 took this target.
    pub(crate) const fn take(&mut self, target: i64) {
        *self = Self { taken: Some(target), missed: 0 };
    }

    /// A control word came while 607Ah is `target`: whether it keeps bit 4 beside another target. Told once until one is taken. `at_once`: the word came
    /// alone, by SDO, and not with every process data.
    pub(crate) fn kept<F>(&mut self, word: Controlword, target: i64, at_once: bool) -> Option<News<F>> {
        if !word.has(Controlword::NEW_SET_POINT)
            || self.taken.is_none_or(|taken| taken == target)
            || self.missed >= PATIENCE
        {
            return None;
        }
        self.missed = if at_once { PATIENCE } else { self.missed.saturating_add(1) };
        (self.missed == PATIENCE).then_some(News::NotTaken { word, target })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(before: u16, word: u16, was: State, now: State) -> Option<std::string::String> {
        let words = (Controlword(word), Controlword(before));
        News::<&str>::of_command(words, (was, now), true).map(|news| std::string::ToString::to_string(&news))
    }

    #[test]
    fn what_the_state_does_not_allow_is_told_with_the_way() {
        assert_eq!(
            said(0, 0x0F, State::SwitchOnDisabled, State::SwitchOnDisabled).unwrap(),
            "6040h = 000Fh has no effect in 'switch on disabled': send 6040h = 0006h, then 0007h, then 000Fh"
        );
        assert_eq!(
            said(0x0F, 0x06, State::Fault, State::Fault).unwrap(),
            "6040h = 0006h has no effect in 'fault': send 6040h = 0080h (bit 7 from 0 to 1)"
        );
        // The way of a correct master, and words that repeat.
        for (before, word, was, now) in [
            (0, 6, State::SwitchOnDisabled, State::ReadyToSwitchOn),
            (6, 7, State::ReadyToSwitchOn, State::SwitchedOn),
            (7, 0xF, State::SwitchedOn, State::OperationEnabled),
            (0xF, 0x1F, State::OperationEnabled, State::OperationEnabled),
            (0x1F, 7, State::OperationEnabled, State::OperationEnabled),
            (0xF, 0, State::OperationEnabled, State::SwitchOnDisabled),
            (0xF, 0xF, State::Fault, State::Fault),
            (0xF, 0x80, State::Fault, State::SwitchOnDisabled),
        ] {
            assert_eq!(said(before, word, was, now), None, "{word:04X}h in {was}");
        }
    }

    #[test]
    fn a_target_that_is_not_taken_is_told_once() {
        let mut targets = Targets::default();
        let word = Controlword(0x1F);
        assert_eq!(targets.kept::<&str>(word, 5, true), None, "none was taken yet");
        targets.take(5);
        assert_eq!(targets.kept::<&str>(word, 5, true), None);
        let news = targets.kept::<&str>(word, 6, true).unwrap();
        assert_eq!(
            std::string::ToString::to_string(&news),
            "hint: the target 607Ah = 6 is not taken: bit 4 of 6040h is 1 already, only its change from 0 to 1 takes one; next: \
             send 6040h = 000Fh, then 001Fh"
        );
        assert_eq!(targets.kept::<&str>(word, 7, true), None);
        targets.take(7);
        let told: std::vec::Vec<_> = (0..9).map(|_| targets.kept::<&str>(word, 8, false).is_some()).collect();
        assert_eq!(told, [false, false, true, false, false, false, false, false, false]);
    }
}
