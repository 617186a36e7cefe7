//! The settings as the object dictionary has them: a value of the drive can have several names there, the second half of
//! the parameter mapping rule of the guide.

use super::Level;
use crate::face::{DataType, ObjectEntry};

/// A name of a setting: part of its row.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Name {
    /// Its place, type and text.
    pub(crate) object: ObjectEntry,
    /// How its value is made of the setting.
    pub(crate) form: Form,
    /// What may be written, if that is not what the setting takes.
    pub(crate) within: Option<&'static [(i64, i64)]>,
    /// What each of its digits may be, if that is less.
    pub(crate) digits: Option<Digits>,
    /// Whether it can be mapped into PDOs.
    pub(crate) mappable: bool,
    /// The level of CANopen that has it, both if `None`.
    level: Option<Level>,
}

/// How the value of an object is made of a setting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Form {
    /// It is the setting.
    Whole,
    /// It is a tenth of the setting: rpm of 0.1 rpm.
    Tenth,
    /// 605Bh: 0 and -1 for the digit Y = 1 and 0 of P1-32.
    Shutdown,
    /// P3-01: only digit Z can be written (CN-201).
    Rates,
    /// 60C1h:1 in half CANopen.
    LowWord,
    /// 60C1h:2 in half CANopen.
    HighWord,
}

/// What the digits of a value may be.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Digits {
    /// The lowest and the highest value of each digit, as they are written: U, Z, Y, X.
    ranges: [(u8, u8); 4],
    /// The same as the end of "1 was written, but".
    pub(crate) must: &'static str,
}

impl Digits {
    /// Whether the digits of a value are in their ranges.
    pub(crate) fn take(&self, value: i64) -> bool {
        let [low, high, ..] = value.to_le_bytes();
        let digits = [high >> 4, high & 0xF, low >> 4, low & 0xF];
        self.ranges.iter().zip(digits).all(|(&(least, most), digit)| (least..=most).contains(&digit))
    }
}

/// A name of both levels that is the whole setting and can be mapped.
pub(super) const fn object(index: u16, sub: u8, data: DataType, name: &'static str) -> Name {
    let object = ObjectEntry { at: (index, sub), data, name };
    Name { object, form: Form::Whole, within: None, digits: None, mappable: true, level: None }
}

impl Name {
    pub(super) const fn form(self, form: Form) -> Self {
        Self { form, ..self }
    }

    pub(super) const fn within(self, ranges: &'static [(i64, i64)]) -> Self {
        Self { within: Some(ranges), ..self }
    }

    pub(super) const fn digits(self, ranges: [(u8, u8); 4], must: &'static str) -> Self {
        Self { digits: Some(Digits { ranges, must }), ..self }
    }

    pub(super) const fn unmapped(self) -> Self {
        Self { mappable: false, ..self }
    }

    pub(super) const fn only(self, level: Level) -> Self {
        Self { level: Some(level), ..self }
    }

    /// Whether a level has it.
    pub(crate) const fn is_of(&self, level: Level) -> bool {
        matches!(
            (self.level, level),
            (None, _) | (Some(Level::Half), Level::Half) | (Some(Level::Full), Level::Full)
        )
    }
}

impl Form {
    /// The value of the object where the setting is `value`.
    pub(crate) const fn of_setting(self, value: i64) -> i64 {
        let [first, second, third, fourth, ..] = value.to_le_bytes();
        match self {
            Self::Whole | Self::Rates => value,
            Self::Tenth => value / 10,
            Self::Shutdown => (value >> 4 & 0xF != 0) as i64 - 1,
            Self::LowWord => u16::from_le_bytes([first, second]) as i64,
            Self::HighWord => u16::from_le_bytes([third, fourth]) as i64,
        }
    }

    /// The setting that was `before`, after `value` was written to the object.
    pub(crate) fn to_setting(self, before: i64, value: i64) -> i64 {
        match self {
            Self::Whole => value,
            Self::Tenth => value * 10,
            Self::Shutdown => before & !0xF0 | i64::from(value == 0) << 4,
            Self::Rates => before & !0xF00 | value & 0xF00,
            Self::LowWord => before & !0xFFFF | value,
            Self::HighWord => {
                let [low, high, ..] = before.to_le_bytes();
                let [third, fourth, ..] = value.to_le_bytes();
                i32::from_le_bytes([low, high, third, fourth]).into()
            }
        }
    }

    /// The limits of the object where these are the limits of the setting.
    pub(crate) const fn limits(self, (low, high): (i64, i64)) -> (i64, i64) {
        match self {
            Self::Whole | Self::Rates => (low, high),
            Self::Tenth => (low / 10, high / 10),
            Self::Shutdown => (-1, 0),
            Self::LowWord | Self::HighWord => (0, 0xFFFF),
        }
    }
}
