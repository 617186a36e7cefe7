//! The parameters as data: default and range of each stand here once.

use crate::face::{DataType, ObjectEntry};

/// What may be written to a setting, and its value at the factory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rule {
    /// The value at the factory.
    pub default: i32,
    /// Ranges, ascending, ends included.
    pub ranges: &'static [(i64, i64)],
}

/// Declares each setting once: default, ranges, place in the object dictionary, type and name there.
macro_rules! settings {
    ($($(#[doc = $doc:literal])+ $name:ident = $default:literal, $ranges:expr, $at:expr, $data:ident, $object:literal;)*) => {
        /// A parameter.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Setting {
            $($(#[doc = $doc])+ $name,)*
        }

        impl Setting {
            /// Every setting.
            pub const ALL: &'static [Self] = &[$(Self::$name),*];

            /// Its default and its range.
            pub const fn rule(self) -> Rule {
                match self {
                    $(Self::$name => Rule { default: $default, ranges: &$ranges },)*
                }
            }

            /// Its entry in the object dictionary.
            pub(crate) const fn object(self) -> ObjectEntry {
                match self {
                    $(Self::$name => ObjectEntry { at: $at, data: DataType::$data, name: $object },)*
                }
            }
        }
    };
}

#[rustfmt::skip]
settings! {
    /// Added to the position, in display steps.
    ApplicationOffset = 0, [(-9999, 9999)], (0x2001, 0), I16, "Application offset";
    /// The up key calibrates.
    CalibrationByKey = 1, [(0, 1)], (0x2003, 0), U8, "Calibration by key";
    /// The left key switches incremental measurement.
    IncrementalByKey = 1, [(0, 1)], (0x2004, 0), U8, "Incremental measurement by key";
    /// The star key opens the menu. 0 is listed, but not supported (CN-115).
    ConfigurationByKey = 1, [(1, 1)], (0x2005, 1), U8, "Configuration by key";
    /// How long the star key is held for it, in seconds.
    KeyEnableTime = 5, [(1, 60)], (0x2005, 2), U8, "Key enable time s";
    /// For internal use.
    Internal = 0, [(0, 999_999)], (0x2005, 3), U32, "Internal";
    /// The longest silence of the master in milliseconds, 0 = not supervised.
    ExternalHeartbeatTime = 0, [(0, 0), (10, 65_535)], (0x5F09, 1), U16, "External heartbeat time ms";
    /// What counts, 0 RPDO, 1 SYNC.
    ExternalHeartbeatSource = 0, [(0, 1)], (0x5F09, 2), U8, "External heartbeat source";
    /// The node number.
    NodeId = 125, [(1, 127)], (0x5F0A, 1), U8, "Node-ID";
    /// The number received last for Auto-ID, 0 before (CN-135).
    AutoId = 0, [(0, 127)], (0x5F0A, 2), U8, "Auto-ID";
    /// 0 auto, 1 125, 2 250, 3 500, 4 800, 5 1000 kbit/s.
    BaudRate = 0, [(0, 5)], (0x5F0A, 3), U8, "Baud rate";
    /// 1 blanks row 2.
    RowTwo = 0, [(0, 1)], (0x5F0B, 0), U8, "Row 2 display";
    /// 0 actual - set, 1 set - actual.
    DifferenceFormation = 0, [(0, 1)], (0x5F0D, 2), U8, "Difference formation";
    /// Target window 1 in display steps.
    Window1 = 5, [(0, 9999)], (0x5F10, 0), U16, "Target window 1";
    /// Decimal places on the display.
    DecimalPlaces = 0, [(0, 4)], (0x5F11, 0), U8, "Decimal places";
    /// 1 turns the display by 180 degrees.
    Orientation = 0, [(0, 1)], (0x5F12, 1), U8, "Display orientation";
    /// LED1 green left by position, else by control word.
    Led1 = 1, [(0, 1)], (0x5F12, 2), U8, "LED1 green left";
    /// LED2 red left.
    Led2 = 1, [(0, 1)], (0x5F12, 3), U8, "LED2 red left";
    /// LED3 green right.
    Led3 = 1, [(0, 1)], (0x5F12, 4), U8, "LED3 green right";
    /// LED4 red right.
    Led4 = 1, [(0, 1)], (0x5F12, 5), U8, "LED4 red right";
    /// LEDs flash.
    LedFlashing = 0, [(0, 1)], (0x5F12, 6), U8, "LED flashing";
    /// White backlight.
    WhiteBacklight = 1, [(0, 1)], (0x5F12, 7), U8, "White backlight";
    /// Red backlight.
    RedBacklight = 1, [(0, 1)], (0x5F12, 8), U8, "Red backlight";
    /// The backlight flashes.
    BacklightFlashing = 0, [(0, 1)], (0x5F12, 9), U8, "Backlight flashing";
    /// 0 1, 1 10, 2 100, 3 1000.
    Divisor = 0, [(0, 3)], (0x5F13, 1), U8, "Display divisor";
    /// 0 on all values, 1 on the display only.
    DivisorUse = 0, [(0, 1)], (0x5F13, 2), U8, "Divisor application";
    /// Loop length in display steps.
    LoopLength = 0, [(0, 9999)], (0x5F14, 0), U16, "Loop length";
    /// 0 direct, 1 loop+, 2 loop-.
    Positioning = 0, [(0, 2)], (0x5F15, 0), U8, "Positioning type";
    /// Operating mode, see [`Mode`].
    OperatingMode = 0, [(0, 3)], (0x5F1B, 2), U8, "Operating mode";
    /// 0 star acknowledges both set points, 2 up and left one each.
    AcknowledgeKey = 0, [(0, 0), (2, 2)], (0x5F1C, 0), U8, "Acknowledge key";
    /// 1 shows pending set points steadily.
    PendingSteady = 0, [(0, 1)], (0x5F1C, 1), U8, "Flashing of pending set points";
    /// Arrows 0 on, 1 inverted, 2 off.
    Arrows = 0, [(0, 2)], (0x5F1F, 0), U8, "Direction indicators";
    /// Target window 2 in display steps.
    Window2 = 0, [(0, 9999)], (0x5F21, 1), U16, "Target window 2";
    /// Target window 2 shows on the LEDs.
    Window2Visible = 0, [(0, 1)], (0x5F21, 2), U8, "Window 2 visualisation";
    /// Bit 0 sense of rotation, bit 2 always 1 (CN-121).
    OperatingParameters = 4, [(4, 5)], (0x6000, 0), U16, "Operating parameters";
    /// Display steps of one revolution.
    StepsPerRevolution = 880, [(1, 65_535)], (0x6001, 0), U32, "Measuring steps per revolution";
    /// The calibration value.
    Preset = 0, [(-999_999, 999_999)], (0x6003, 0), I32, "Preset (calibration) value";
}

impl Setting {
    /// The setting at an index and sub-index, if it is one.
    pub(crate) fn at(pair: (u16, u8)) -> Option<Self> {
        Self::ALL.iter().copied().find(|setting| setting.object().at == pair)
    }

    /// Whether the value may be written.
    pub(crate) fn accepts(self, value: i32) -> bool {
        self.rule().ranges.iter().any(|&(low, high)| (low..=high).contains(&i64::from(value)))
    }

    const fn place(self) -> usize {
        self as usize
    }
}

/// What the display shows (5F1Bh:2).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Mode {
    /// 0: actual and set point.
    Absolute,
    /// 1: actual and differential value.
    Difference,
    /// 2: the actual value modulo 360 and the set point.
    Modulo,
    /// 3: both set points as numbers or characters.
    Alphanumeric,
}

/// The values of all settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    values: [i32; Setting::ALL.len()],
}

impl Default for Settings {
    fn default() -> Self {
        let mut settings = Self { values: [0; Setting::ALL.len()] };
        for setting in Setting::ALL {
            settings.set(*setting, setting.rule().default);
        }
        settings
    }
}

impl Settings {
    /// The value of a setting.
    pub(crate) fn value(&self, setting: Setting) -> i32 {
        self.values.get(setting.place()).copied().unwrap_or_default()
    }

    /// Whether a setting of 0 and 1 is 1.
    pub(crate) fn is_on(&self, setting: Setting) -> bool {
        self.value(setting) == 1
    }

    /// Sets a value. Says whether it is in range; if not nothing changes.
    pub(crate) fn set(&mut self, setting: Setting, value: i32) -> bool {
        let accepted = setting.accepts(value);
        if let Some(place) = self.values.get_mut(setting.place()).filter(|_| accepted) {
            *place = value;
        }
        accepted
    }

    /// The operating mode.
    pub(crate) fn mode(&self) -> Mode {
        match self.value(Setting::OperatingMode) {
            ..=0 => Mode::Absolute,
            1 => Mode::Difference,
            2 => Mode::Modulo,
            3.. => Mode::Alphanumeric,
        }
    }

    /// The display divisor, 1 to 1000.
    pub(crate) fn divisor(&self) -> i64 {
        match self.value(Setting::Divisor) {
            ..=0 => 1,
            1 => 10,
            2 => 100,
            3.. => 1000,
        }
    }

    /// Whether the value rises when the shaft turns clockwise, seen on the display (sense I).
    pub(crate) fn rises_clockwise(&self) -> bool {
        self.value(Setting::OperatingParameters) & 1 == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_default_is_in_range_and_its_neighbours_outside_are_refused() {
        let mut settings = Settings::default();
        for setting in Setting::ALL {
            let rule = setting.rule();
            assert!(setting.accepts(rule.default), "{setting:?}");
            assert_eq!(settings.value(*setting), rule.default);
            let (low, high) = (rule.ranges.first().unwrap().0, rule.ranges.last().unwrap().1);
            for outside in [low - 1, high + 1] {
                assert!(!settings.set(*setting, i32::try_from(outside).unwrap()), "{setting:?}");
            }
            assert_eq!(settings, Settings::default());
        }
        assert!(!Setting::ExternalHeartbeatTime.accepts(9) && Setting::ExternalHeartbeatTime.accepts(10));
        assert!(!Setting::AcknowledgeKey.accepts(1));
    }
}
