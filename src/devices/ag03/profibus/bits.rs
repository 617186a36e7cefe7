//! Every bit of STW, ZSW, SSW and the general status register, once: number, name, and what 1 and 0 mean.
//!
//! Names and meanings are those of manual tables 1 and 11 to 14; where the English manual lost a word in translation,
//! those of the German one (`docs/reference/ag03.md` 4 to 6, C-04, C-22). All others take them from here: the words a
//! drive composes ([`words`](super::words)), the client, the explanations, the panel, the command, and the tables of the
//! Wireshark dissector (`docs/wireshark/profibus.lua`, compared by a test).
//!
//! ```
//! use profidrive::devices::ag03::profibus::bits::{StwBit, Word, ZswBit, bits};
//! use profidrive::devices::ag03::drive::Mode;
//! use profidrive::devices::ag03::param::Model;
//! use profidrive::profibus::ppo::Zsw;
//!
//! assert_eq!(StwBit::Start.number(), 6);
//! assert!(ZswBit::ReadyToTravel.is_set(Zsw::from_raw(0xAB37)));
//!
//! // Bit by bit, for a table of a program's own.
//! let start = bits(Word::Stw, Mode::Positioning, Some(Model::Ag03))[6];
//! assert_eq!((start.key, start.name), ("start", "activate travel job"));
//! ```

use crate::devices::ag03::drive::Mode;
use crate::devices::ag03::param::Model;
use crate::face::bits_of_word;

/// One of the words of bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Word {
    /// Control word STW, manual tables 11 and 13.
    Stw,
    /// Status word ZSW, manual tables 12 and 14.
    Zsw,
    /// System status word SSW, PNU 1020, manual table 1.
    Ssw,
    /// General status register, PNU 1031.
    GeneralStatus,
}

impl Word {
    /// All four.
    pub const ALL: [Self; 4] = [Self::Stw, Self::Zsw, Self::Ssw, Self::GeneralStatus];

    /// `STW`, `ZSW`, `SSW`, `GSR`.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Stw => "STW",
            Self::Zsw => "ZSW",
            Self::Ssw => "SSW",
            Self::GeneralStatus => "GSR",
        }
    }

    /// The bits that are 1 in every state and in both operating modes.
    pub(crate) fn always_1(self) -> u16 {
        self.mask_of(|bit| bit.role == Role::Fixed(true))
    }

    /// The bits that mean nothing in an operating mode: not used, or always 0.
    pub(crate) fn without_meaning(self, mode: Mode) -> u16 {
        let rows = (0..16_u8).zip(bits(self, mode, None));
        rows.filter(|(_, bit)| matches!(bit.role, Role::Unused | Role::Fixed(false)))
            .fold(0, |mask, (n, _)| mask | 1 << n)
    }

    fn mask_of(self, wanted: impl Fn(&Bit) -> bool) -> u16 {
        let rows = (0..16_u8).zip(self.rows());
        rows.filter(|(_, row)| wanted(&row.positioning) && wanted(&row.velocity))
            .fold(0, |mask, (n, _)| mask | 1 << n)
    }

    const fn rows(self) -> &'static [Row; 16] {
        match self {
            Self::Stw => &STW,
            Self::Zsw => &ZSW,
            Self::Ssw => &SSW,
            Self::GeneralStatus => &GENERAL_STATUS,
        }
    }
}

/// The bits of a word in an operating mode, bit 0 first. What releases the output stage (SSW.10, GSR.4) is the enable
/// input on an AG03 and a supply on an AG03/1; without a `model` the words are for either.
pub fn bits(word: Word, mode: Mode, model: Option<Model>) -> [&'static Bit; 16] {
    word.rows().each_ref().map(|row| row.of(mode, model))
}

/// One bit of a word, in one operating mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Bit {
    /// A short name for programs and command lines, `no-off2`. Empty for a bit that is not used.
    pub key: &'static str,
    /// What the manual calls it, in the column of the profile.
    pub name: &'static str,
    /// What 1 means.
    pub one: &'static str,
    /// What 0 means.
    pub zero: &'static str,
    /// What to know about it; empty where nothing is left to say.
    pub note: &'static str,
    /// How the bit carries its meaning.
    pub role: Role,
}

impl Bit {
    /// What the bit means with this value.
    pub(crate) const fn meaning(&self, set: bool) -> &'static str {
        if set { self.one } else { self.zero }
    }
}

/// How a bit carries its meaning.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Role {
    /// By being 0 or 1.
    Level,
    /// By changing.
    Edge,
    /// Not at all: it always has this value.
    Fixed(bool),
    /// Not at all: it is not evaluated, or 0.
    Unused,
}

/// The name of a bit that is not used.
pub(crate) const NOT_USED: &str = "not used";

/// A bit in both operating modes.
#[derive(Clone, Copy)]
struct Row {
    positioning: Bit,
    velocity: Bit,
    /// The bit of an AG03 and of an AG03/1 where they differ, in both operating modes.
    models: Option<[Bit; 2]>,
}

impl Row {
    fn of(&self, mode: Mode, model: Option<Model>) -> &Bit {
        match (&self.models, model) {
            (Some([ag03, _]), Some(Model::Ag03)) => ag03,
            (Some([_, ag03_1]), Some(Model::Ag03_1)) => ag03_1,
            (None, _) | (Some(_), None) => match mode {
                Mode::Positioning => &self.positioning,
                Mode::Velocity => &self.velocity,
            },
        }
    }

    /// A bit that speaks by its changes in positioning mode.
    const fn edge(self) -> Self {
        Self { positioning: Bit { role: Role::Edge, ..self.positioning }, ..self }
    }

    const fn velocity(self, velocity: Bit) -> Self {
        Self { velocity, ..self }
    }

    const fn models(self, ag03: Bit, ag03_1: Bit) -> Self {
        Self { models: Some([ag03, ag03_1]), ..self }
    }
}

const fn bit(
    key: &'static str,
    name: &'static str,
    one: &'static str,
    zero: &'static str,
    note: &'static str,
) -> Bit {
    Bit { key, name, one, zero, note, role: Role::Level }
}

const fn both(
    key: &'static str,
    name: &'static str,
    one: &'static str,
    zero: &'static str,
    note: &'static str,
) -> Row {
    let bit = bit(key, name, one, zero, note);
    Row { positioning: bit, velocity: bit, models: None }
}

const fn fixed(key: &'static str, name: &'static str, value: bool) -> Bit {
    let (one, zero) = if value { ("always 1", "0, which it never is") } else { ("1, must be 0", "always 0") };
    Bit { key, name, one, zero, note: "", role: Role::Fixed(value) }
}

const fn always(key: &'static str, name: &'static str, value: bool) -> Row {
    let bit = fixed(key, name, value);
    Row { positioning: bit, velocity: bit, models: None }
}

const UNUSED: Bit =
    Bit { key: "", name: NOT_USED, one: "no meaning", zero: "no meaning", note: "", role: Role::Unused };
const NONE: Row = Row { positioning: UNUSED, velocity: UNUSED, models: None };

/// A word as its used bits: `Bit = number: kind(key, name, ...)`.
macro_rules! words {
    (
        $(#[$doc:meta])*
        $bits:ident, $rows:ident {
            $($bit:ident = $n:literal: $kind:ident($key:literal, $name:literal $($args:tt)*) $(.$more:ident($($of:tt)*))*;)*
        }
    ) => {
        bits_of_word! {
            $(#[$doc])*
            $bits { $($bit = $n: $name;)* }
        }

        const $rows: [Row; 16] = {
            let mut rows = [NONE; 16];
            $(rows[$n] = $kind($key, $name $($args)*)$(.$more($($of)*))*;)*
            rows
        };
    };
}

words! {
    /// The bits of the control word STW (manual tables 11 and 13). Bits 10 to 14 are not evaluated.
    StwBit, STW {
        On = 0: both("on", "ON / OFF1", "ON", "OFF1", "0 cancels the job, releases the motor, and ends turn-on disabled");
        NoOff2 = 1: both("no-off2", "no OFF2", "no OFF2", "OFF2", "0 cancels the job and releases the motor");
        Off3 = 2: always("off3", "OFF3", false);
        EnableOperation = 3: both("enable-operation", "enable operation", "enable operation", "disable operation", "0 brakes with maximum deceleration; the motor stays in control");
        NoStop = 4: both("no-stop", "stop", "no stop", "stop", "0 brakes with maximum deceleration and discards the job").velocity(UNUSED);
        NoIntermediateStop = 5: both("no-intermediate-stop", "intermediate stop", "no intermediate stop", "intermediate stop", "0 brakes with the programmed ramp and keeps the job, 1 continues it").velocity(UNUSED);
        Start = 6: both("start", "activate travel job", "start bit 1", "start bit 0", "each change starts a job to the setpoint").edge()
            .velocity(bit("start", "enable target value", "setpoint released", "setpoint not released", "1 turns with the setpoint, 0 brakes with the programmed ramp"));
        Acknowledge = 7: both("acknowledge", "acknowledge", "acknowledge", "acknowledge bit 0", "0 to 1 acknowledges a fault; turn-on disabled follows");
        Inching1 = 8: both("inch1", "inching 1", "inching 1", "inching 1 off", "travels once by delta inch").velocity(UNUSED);
        Inching2 = 9: both("inch2", "inching 2", "inching 2", "inching 2 off", "travels while 1").velocity(UNUSED);
        Inching2Negative = 15: both("inch2-negative", "direction of inching 2", "negative direction", "positive direction", "").velocity(UNUSED);
    }
}

words! {
    /// The bits of the status word ZSW (manual tables 12 and 14).
    ZswBit, ZSW {
        ReadyToTurnOn = 0: both("ready-to-turn-on", "ready to turn on", "ready to turn on", "not ready to turn on", "supplies present");
        Ready = 1: both("ready", "ready", "ready", "not ready", "identical with bit 0");
        OperationEnabled = 2: both("operation-enabled", "operation enabled", "enabled", "operation disabled", "");
        Fault = 3: both("fault", "fault", "FAULT", "no fault", "");
        NoOff2 = 4: both("no-off2", "no OFF2", "no OFF2", "OFF2 given", "");
        NoOff3 = 5: always("no-off3", "no OFF3", true);
        TurnOnDisabled = 6: both("turn-on-disabled", "turn-on disabled", "turn-on disabled", "turn-on not disabled", "");
        Warning = 7: both("warning", "warning", "warning", "no warning", "");
        NoLagError = 8: both("no-lag-error", "no lag error", "no lag error", "lag error", "")
            .velocity(bit("in-window", "required and actual value within tolerance", "velocity in the window", "velocity outside the window", ""));
        ControlRequested = 9: always("control-requested", "control requested", true);
        TargetReached = 10: both("target-reached", "target position reached", "target reached", "target not reached", "")
            .velocity(fixed("n-reached", "f or n reached", true));
        ReferencePointSet = 11: always("reference-point-set", "reference point set", true)
            .velocity(fixed("device-specific-11", "device-specific", true));
        JobToggle = 12: both("job-toggle", "acknowledgement of target value", "job bit 1", "job bit 0", "each change shows that the drive has accepted a job").edge()
            .velocity(fixed("device-specific-12", "device-specific", true));
        Standstill = 13: both("standstill", "drive stands still", "stands still", "travels", "");
        LimitExceeded = 14: both("limit-exceeded", "limiting value exceeded", "beyond a limit", "within the limits", "")
            .velocity(fixed("device-specific-14", "device-specific", false));
        ReadyToTravel = 15: both("ready-to-travel", "ready to travel", "ready to travel", "not ready to travel", "");
    }
}

words! {
    /// The bits of the system status word SSW, PNU 1020 (manual table 1).
    SswBit, SSW {
        InPosition = 3: both("in-position", "in position", "position in the window", "position outside the window", "")
            .velocity(bit("in-position", "in position", "velocity in the window", "velocity outside the window", ""));
        Travels = 4: both("travels", "drive travels", "travels", "stands still", "standstill is below 2 rpm");
        AboveUpperLimit = 5: both("above-upper-limit", "upper limit", "above the upper limit", "not above the upper limit", "").velocity(UNUSED);
        BelowLowerLimit = 6: both("below-lower-limit", "lower limit", "below the lower limit", "not below the lower limit", "").velocity(UNUSED);
        MotorReleased = 7: both("motor-released", "driver state", "motor released", "motor in control", "");
        Fault = 8: both("fault", "fault", "FAULT", "no fault", "");
        LoopTravel = 9: both("loop-travel", "loop travel", "travels against the approach direction", "travels in the approach direction", "").velocity(UNUSED);
        NoOutputStage = 10: both("no-output-stage", "enable input or supply of the output stage", "output stage not enabled or not supplied", "output stage enabled and supplied", "AG03: enable input, AG03/1: supply").models(
            bit("no-output-stage", "enable input", "enable input not active", "enable input active", ""),
            bit("no-output-stage", "supply of the output stage", "output stage not supplied", "output stage supplied", ""),
        );
        NotReadyToTravel = 11: both("not-ready-to-travel", "ready to travel", "not ready to travel", "ready to travel", "1: not ready");
        BatteryLow = 12: both("battery-low", "battery voltage", "battery low", "battery in order", "replace it within half a year");
        CurrentOutOfRange = 13: both("current-out-of-range", "motor current", "motor current out of range", "motor current in range", "fault C after 4 s");
        PositioningActive = 14: both("positioning-active", "positioning", "positioning active", "no positioning active", "").velocity(UNUSED);
        LagError = 15: both("lag-error", "lag error", "lag error", "no lag error", "");
    }
}

words! {
    /// The bits of the general status register, PNU 1031.
    GeneralStatusBit, GENERAL_STATUS {
        OutputStage = 4: both("output-stage", "enable input or supply of the output stage", "output stage enabled and supplied", "output stage not enabled or not supplied", "AG03: enable input, AG03/1: supply").models(
            bit("output-stage", "enable input", "enable input active", "enable input not active", ""),
            bit("output-stage", "supply of the output stage", "output stage supplied", "output stage not supplied", ""),
        );
        TorqueDeactivation = 7: both("torque-deactivation", "torque deactivation", "torque deactivation has tripped", "torque deactivation has not tripped", "ends when the job is resumed");
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    const MODES: [Mode; 2] = [Mode::Positioning, Mode::Velocity];

    #[test]
    fn every_used_bit_has_a_key_of_its_own_and_words_for_both_values() {
        let models = [None, Some(Model::Ag03), Some(Model::Ag03_1)];
        let modes = MODES.into_iter().flat_map(|mode| models.map(|model| (mode, model)));
        for (word, (mode, model)) in
            Word::ALL.into_iter().flat_map(|word| modes.clone().map(move |of| (word, of)))
        {
            let used = bits(word, mode, model).into_iter().filter(|bit| bit.role != Role::Unused);
            let mut keys = BTreeSet::new();
            for bit in used {
                assert!(keys.insert(bit.key), "{word:?} {mode:?}: {} twice", bit.key);
                assert!(!bit.one.is_empty() && bit.one != bit.zero, "{word:?} {}", bit.key);
            }
        }
    }

    #[test]
    fn what_releases_the_output_stage_has_the_name_it_has_on_the_model() {
        for (model, missing, there) in [
            (Some(Model::Ag03), "enable input not active", "enable input active"),
            (Some(Model::Ag03_1), "output stage not supplied", "output stage supplied"),
            (None, "output stage not enabled or not supplied", "output stage enabled and supplied"),
        ] {
            for mode in MODES {
                let (ssw, gsr) =
                    (bits(Word::Ssw, mode, model)[10], bits(Word::GeneralStatus, mode, model)[4]);
                assert_eq!((ssw.meaning(true), ssw.meaning(false)), (missing, there));
                assert_eq!((gsr.meaning(false), gsr.meaning(true)), (missing, there));
                assert_eq!((ssw.key, gsr.key), ("no-output-stage", "output-stage"), "one key for programs");
            }
        }
    }

    #[test]
    fn the_masks_are_those_of_the_manual_s_tables() {
        assert_eq!(Word::Zsw.always_1(), 0x0A20);
        assert_eq!(Word::Stw.without_meaning(Mode::Positioning), 0x7C04);
        assert_eq!(Word::Stw.without_meaning(Mode::Velocity), 0xFF34);
        let ssw = SswBit::ALL.iter().fold(0, |word, bit| word | bit.mask());
        assert_eq!((ssw, GeneralStatusBit::OutputStage.mask()), (0xFFF8, 0x10));
        assert_eq!(ZswBit::Fault.when(true) | ZswBit::Warning.when(false), 8);
    }
}
