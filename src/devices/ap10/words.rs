//! The control word 5F0Ch and the status word 5F19h: every bit, once.

use core::fmt;

use crate::face::bits_of_word;

/// A word, and its bits with their texts.
macro_rules! word {
    ($(#[doc = $word_doc:literal])+ $word:ident, $(#[doc = $bit_doc:literal])+ $bit:ident { $($bits:tt)* }) => {
        bits_of_word! {
            $(#[doc = $bit_doc])+
            $bit { $($bits)* }
        }

        $(#[doc = $word_doc])+
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
        pub struct $word(pub u16);

        impl $word {
            /// Whether a bit is 1.
            pub const fn has(self, bit: $bit) -> bool {
                self.0 & bit.mask() != 0
            }

            /// With a bit as `on` says.
            #[must_use]
            pub const fn with(self, bit: $bit, on: bool) -> Self {
                Self(if on { self.0 | bit.mask() } else { self.0 & !bit.mask() })
            }
        }

        impl fmt::Display for $word {
            /// The word and the texts of its bits.
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "{:04X}h", self.0)?;
                for bit in $bit::ALL.iter().filter(|bit| self.has(**bit)) {
                    write!(f, ", {}", bit.name())?;
                }
                Ok(())
            }
        }
    };
}

word! {
    /// The control word as received.
    Control,
    /// A bit of the control word (manual table 15). Bits 0, 1 and 5 are reserved.
    ControlBit {
        SetPoint1Valid = 2: "set point 1 valid";
        ExtendedRange = 3: "extended display range";
        AcknowledgeStatic = 4: "acknowledge target window 1 static";
        AcknowledgeSetPoint2 = 6: "acknowledge set point 2";
        Ascii = 7: "set point is ASCII";
        Guarding = 8: "guarding bit";
        SetPoint2Valid = 9: "set point 2 valid";
        AcknowledgeSetPoint1 = 10: "acknowledge set point 1";
        Led1 = 11: "LED1 green left on";
        Led3 = 12: "LED3 green right on";
        Led4 = 13: "LED4 red right on";
        Led2 = 14: "LED2 red left on";
        LedBlinking = 15: "LEDs blink";
    }
}

word! {
    /// The status word.
    Status,
    /// A bit of the status word (manual table 16). Bits 3 and 5 have another meaning in alpha-numeric mode: set point
    /// 2 and set point 1 acknowledged. So has bit 9 in the read-out of set points: the set point is ASCII.
    StatusBit {
        Clockwise = 0: "turn clockwise";
        CounterClockwise = 1: "turn counter-clockwise";
        SetPoint1Valid = 2: "set point 1 valid";
        Window2 = 3: "in target window 2";
        Window1Static = 4: "target window 1 was reached";
        Window1 = 5: "in target window 1";
        AboveSetPoint = 6: "actual value above set point";
        BatteryEmpty = 7: "battery empty";
        Guarding = 8: "guarding bit";
        Incremental = 9: "incremental measurement";
        SetPoint2Valid = 10: "set point 2 valid";
        BatteryCritical = 11: "battery critical";
        SensorError = 12: "sensor error";
        StarKey = 13: "star key pressed";
        UpKey = 14: "up key pressed";
        LeftKey = 15: "left key pressed";
    }
}

impl StatusBit {
    /// Bit 3 in alpha-numeric mode.
    pub(crate) const ACKNOWLEDGED_2: Self = Self::Window2;
    /// Bit 5 in alpha-numeric mode.
    pub(crate) const ACKNOWLEDGED_1: Self = Self::Window1;
    /// Bit 9 when set points are read by remote request in alpha-numeric mode.
    pub(crate) const ASCII: Self = Self::Incremental;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_read_as_their_bits() {
        assert_eq!(Control(0x0084).to_string(), "0084h, set point 1 valid, set point is ASCII");
        let status = Status(0x0034);
        assert_eq!(
            status.to_string(),
            "0034h, set point 1 valid, target window 1 was reached, in target window 1"
        );
        assert_eq!(status.with(StatusBit::Window1, false), Status(0x0014));
        let all = StatusBit::ALL.iter().fold(Status(0), |word, bit| word.with(*bit, true));
        assert_eq!(all.0, 0xFFFF);
        let all = ControlBit::ALL.iter().fold(Control(0), |word, bit| word.with(*bit, true));
        assert_eq!(all.0, !0b0010_0011);
    }
}
