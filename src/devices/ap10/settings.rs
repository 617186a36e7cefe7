//! The parameters as data: default and range of each stand here once.

/// What may be written to a setting, and its value at the factory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rule {
    /// The value at the factory.
    pub default: i32,
    /// Ranges, ascending, ends included.
    pub ranges: &'static [(i64, i64)],
}

/// Declares the settings and their rules once.
macro_rules! settings {
    ($($(#[doc = $doc:literal])+ $name:ident = $default:literal, $ranges:expr;)*) => {
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
        }
    };
}

settings! {
    /// 2001h: added to the position, in display steps.
    ApplicationOffset = 0, [(-9999, 9999)];
    /// 2003h: the up key calibrates.
    CalibrationByKey = 1, [(0, 1)];
    /// 2004h: the left key switches incremental measurement.
    IncrementalByKey = 1, [(0, 1)];
    /// 2005h:1: the star key opens the menu. 0 is listed, but not supported (CN-115).
    ConfigurationByKey = 1, [(1, 1)];
    /// 2005h:2: how long the star key is held for it, in seconds.
    KeyEnableTime = 5, [(1, 60)];
    /// 2005h:3: for internal use.
    Internal = 0, [(0, 999_999)];
    /// 5F09h:1: the longest silence of the master in milliseconds, 0 = not supervised.
    ExternalHeartbeatTime = 0, [(0, 0), (10, 65_535)];
    /// 5F09h:2: what counts, 0 RPDO, 1 SYNC.
    ExternalHeartbeatSource = 0, [(0, 1)];
    /// 5F0Ah:1: the node number.
    NodeId = 125, [(1, 127)];
    /// 5F0Ah:2: the number received last for Auto-ID, 0 before (CN-135).
    AutoId = 0, [(0, 127)];
    /// 5F0Ah:3: 0 auto, 1 125, 2 250, 3 500, 4 800, 5 1000 kbit/s.
    BaudRate = 0, [(0, 5)];
    /// 5F0Bh: 1 blanks row 2.
    RowTwo = 0, [(0, 1)];
    /// 5F0Dh:2: 0 actual - set, 1 set - actual.
    DifferenceFormation = 0, [(0, 1)];
    /// 5F10h: target window 1 in display steps.
    Window1 = 5, [(0, 9999)];
    /// 5F11h: decimal places on the display.
    DecimalPlaces = 0, [(0, 4)];
    /// 5F12h:1: 1 turns the display by 180 degrees.
    Orientation = 0, [(0, 1)];
    /// 5F12h:2: LED1 green left by position, else by control word.
    Led1 = 1, [(0, 1)];
    /// 5F12h:3: LED2 red left.
    Led2 = 1, [(0, 1)];
    /// 5F12h:4: LED3 green right.
    Led3 = 1, [(0, 1)];
    /// 5F12h:5: LED4 red right.
    Led4 = 1, [(0, 1)];
    /// 5F12h:6: LEDs flash.
    LedFlashing = 0, [(0, 1)];
    /// 5F12h:7: white backlight.
    WhiteBacklight = 1, [(0, 1)];
    /// 5F12h:8: red backlight.
    RedBacklight = 1, [(0, 1)];
    /// 5F12h:9: the backlight flashes.
    BacklightFlashing = 0, [(0, 1)];
    /// 5F13h:1: 0 1, 1 10, 2 100, 3 1000.
    Divisor = 0, [(0, 3)];
    /// 5F13h:2: 0 on all values, 1 on the display only.
    DivisorUse = 0, [(0, 1)];
    /// 5F14h: loop length in display steps.
    LoopLength = 0, [(0, 9999)];
    /// 5F15h: 0 direct, 1 loop+, 2 loop-.
    Positioning = 0, [(0, 2)];
    /// 5F1Bh:2: operating mode, see [`Mode`].
    OperatingMode = 0, [(0, 3)];
    /// 5F1Ch:0: 0 star acknowledges both set points, 2 up and left one each.
    AcknowledgeKey = 0, [(0, 0), (2, 2)];
    /// 5F1Ch:1: 1 shows pending set points steadily.
    PendingSteady = 0, [(0, 1)];
    /// 5F1Fh: arrows 0 on, 1 inverted, 2 off.
    Arrows = 0, [(0, 2)];
    /// 5F21h:1: target window 2 in display steps.
    Window2 = 0, [(0, 9999)];
    /// 5F21h:2: target window 2 shows on the LEDs.
    Window2Visible = 0, [(0, 1)];
    /// 6000h: bit 0 sense of rotation, bit 2 always 1 (CN-121).
    OperatingParameters = 4, [(4, 5)];
    /// 6001h: display steps of one revolution.
    StepsPerRevolution = 880, [(1, 65_535)];
    /// 6003h: the calibration value.
    Preset = 0, [(-999_999, 999_999)];
}

impl Setting {
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
