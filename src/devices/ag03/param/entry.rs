//! What the table says about a parameter.

use core::fmt;

use super::{Gear, Model, Parameter, Pnu, Quirks, Reading, Value, Width};

/// What is known about one parameter number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    /// The number on the bus.
    pub pnu: Pnu,
    /// The name in the English manual.
    pub name: &'static str,
    /// Width of the value, or of each element of an array.
    pub width: Width,
    /// Number of elements if the parameter is an array.
    pub elements: Option<u8>,
    /// The value is a number in two's complement.
    pub signed: bool,
    /// Unit or coding of the value.
    pub unit: Unit,
    /// The EEPROM keeps the value while the drive is off.
    pub persistent: bool,
    /// Which models have it.
    pub models: Models,
    /// Where the value comes from.
    pub kind: Kind,
}

impl Entry {
    /// Whether it can be read and written.
    pub(crate) const fn access(&self) -> Access {
        match self.kind {
            Kind::Setting(_) => Access::ReadWrite,
            Kind::Reading(_) => Access::ReadOnly,
            Kind::LoadParameterSet => Access::WriteOnly,
        }
    }

    /// The values a write to such a drive may have; `None` if the parameter is read-only.
    pub(crate) const fn range(&self, model: Model, gear: Gear, quirks: Quirks) -> Option<Range> {
        match self.kind {
            Kind::Setting(setting) => Some(setting.limits.range(model, gear, quirks)),
            Kind::Reading(_) => None,
            Kind::LoadParameterSet => Some(LOAD_COMMANDS),
        }
    }

    /// The value as a number: in two's complement if the parameter is signed.
    pub const fn number(&self, value: Value) -> i64 {
        match (value, self.signed) {
            (Value::Word(word), false) => word as i64,
            (Value::Word(word), true) => word.cast_signed() as i64,
            (Value::Double(double), false) => double as i64,
            (Value::Double(double), true) => double.cast_signed() as i64,
        }
    }

    pub(super) const fn only_ag03_1(self) -> Self {
        Self { models: Models::OnlyAg03_1, ..self }
    }

    pub(super) const fn array(self, elements: u8) -> Self {
        Self { elements: Some(elements), ..self }
    }

    pub(super) const fn signed(self, signed: bool) -> Self {
        Self { signed, ..self }
    }

    /// Only says something about a setting.
    pub(super) const fn writable(self, writable: WritableWhen) -> Self {
        match self.kind {
            Kind::Setting(setting) => Self { kind: Kind::Setting(Setting { writable, ..setting }), ..self },
            Kind::Reading(_) | Kind::LoadParameterSet => self,
        }
    }

    pub(super) const fn persistent(self, persistent: bool) -> Self {
        Self { persistent, ..self }
    }
}

/// The commands of PNU 970 (`ag03.md` 3.3).
pub(super) const LOAD_COMMANDS: Range = Range { low: 1, high: 5 };

/// Where the value of a parameter comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Stored in the drive, read and written.
    Setting(Setting),
    /// Measured or counted by the drive, or fixed in the factory; only read.
    Reading(Reading),
    /// PNU 970, a command: written, and 0 when read (`ag03.md` 3.3 and C-17).
    LoadParameterSet,
}

/// What is known about a stored parameter (manual chapter 6).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Setting {
    /// Its name in the program.
    pub parameter: Parameter,
    /// Its internal number, the first column of manual chapter 6.
    pub number: u8,
    /// The values allowed.
    pub limits: Limits,
    /// The value of a new drive.
    pub default: i32,
    /// Which command loads its default.
    pub group: Group,
    /// In which operating states it may be written.
    pub writable: WritableWhen,
}

/// Whether a parameter can be read and written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Access {
    /// Only read.
    ReadOnly,
    /// Read and written.
    ReadWrite,
    /// Written; a read finds 0.
    WriteOnly,
}

impl fmt::Display for Access {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::ReadOnly => "r",
            Self::ReadWrite => "r/w",
            Self::WriteOnly => "w",
        })
    }
}

/// Which models have a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Models {
    /// AG03 and AG03/1.
    Both,
    /// Only the AG03/1.
    OnlyAg03_1,
}

impl Models {
    /// Whether `model` is one of them.
    pub const fn contain(self, model: Model) -> bool {
        match (self, model) {
            (Self::Both, _) | (Self::OnlyAg03_1, Model::Ag03_1) => true,
            (Self::OnlyAg03_1, Model::Ag03) => false,
        }
    }
}

/// Which of the commands of PNU 970 loads the default of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Group {
    /// `*` in manual chapter 6.
    Controller,
    /// `**` in manual chapter 6.
    Standard,
}

/// A set of defaults, for PNU 970 and for the factory reset by DIP switches (manual chapter 2.4).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DefaultSet {
    /// Every stored parameter.
    All,
    /// The standard parameters, `**`.
    Standard,
    /// The controller parameters, `*`.
    Controller,
}

impl DefaultSet {
    /// Its name, as `standard`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::All => "all",
            Self::Standard => "standard",
            Self::Controller => "controller",
        }
    }

    /// Whether the set holds the parameters of a group.
    pub(crate) const fn contains(self, group: Group) -> bool {
        match (self, group) {
            (Self::All, _) | (Self::Standard, Group::Standard) | (Self::Controller, Group::Controller) => {
                true
            }
            (Self::Standard, Group::Controller) | (Self::Controller, Group::Standard) => false,
        }
    }
}

/// The operating states in which a parameter may be written (`ag03.md` 3.4).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum WritableWhen {
    /// In every state. What a running travel job has latched stays.
    Always,
    /// While nothing moves.
    Standstill,
    /// While no travel job is active.
    NoJob,
}

/// The smallest and the largest value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Range {
    /// Smallest value.
    pub low: i32,
    /// Largest value.
    pub high: i32,
}

impl Range {
    /// Whether `value` is one of the values, the ends included.
    pub const fn contains(self, value: i32) -> bool {
        self.low <= value && value <= self.high
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}..{}", self.low, self.high)
    }
}

/// The range of a stored parameter and what it depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Limits {
    /// The same for every drive.
    Fixed(Range),
    /// A percentage of the largest acceleration: 1 to 100 on an AG03/1, 0 to 100 on an AG03 (`ag03.md` C-02).
    Acceleration,
    /// The I gain: 0 to 500 (`ag03.md` C-01).
    IGain,
    /// A speed: 1 rpm up to what the gear allows, see `Gear::max_rpm`.
    Speed,
}

impl Limits {
    /// The range that holds for one drive.
    pub(crate) const fn range(self, model: Model, gear: Gear, quirks: Quirks) -> Range {
        match self {
            Self::Fixed(range) => range,
            Self::Acceleration => match model {
                Model::Ag03 if !quirks.acceleration_from_1 => Range { low: 0, high: 100 },
                Model::Ag03 | Model::Ag03_1 => Range { low: 1, high: 100 },
            },
            Self::IGain => match model {
                Model::Ag03_1 if quirks.i_gain_from_1 => Range { low: 1, high: 500 },
                Model::Ag03 | Model::Ag03_1 => Range { low: 0, high: 500 },
            },
            Self::Speed => Range { low: 1, high: gear.max_rpm() as i32 },
        }
    }
}

/// Unit or coding of a value. `Display` writes it behind a number; a coding writes nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Unit {
    /// A number without a unit.
    None,
    /// Percent.
    Percent,
    /// Percent of the largest acceleration, 4 rev/s^2 of the output shaft.
    PercentOfAcceleration,
    /// Revolutions of the output shaft per minute.
    Rpm,
    /// Increments (1600 per turn of the output shaft), or 0.01 mm if a spindle pitch is set.
    Position,
    /// As [`Unit::Position`], in velocity mode rpm.
    Window,
    /// Increments, 1600 per turn of the output shaft.
    Increments,
    /// 0.01 mm per turn of the spindle.
    SpindlePitch,
    /// 0.1 degrees Celsius.
    TenthDegrees,
    /// Milliamperes.
    Milliamperes,
    /// 0.1 V.
    TenthVolts,
    /// 0.01 V.
    HundredthVolts,
    /// Single bits.
    Bits,
    /// A character.
    Ascii,
    /// A version: the high octet before the point, the low octet after it, in hexadecimal.
    Version,
    /// A date in BCD: day, month and two octets of the year.
    Date,
    /// One of these numbers, each with its meaning.
    Choice(&'static [(u16, &'static str)]),
}

impl Unit {
    /// Its name; empty for what counts nothing.
    pub(crate) const fn name(&self) -> &'static str {
        match self {
            Self::None | Self::Bits | Self::Ascii | Self::Version | Self::Date | Self::Choice(_) => "",
            Self::Percent => "%",
            Self::PercentOfAcceleration => "% of 4 rev/s^2",
            Self::Rpm => "rpm",
            Self::Position => "inc or 0.01 mm",
            Self::Window => "inc, 0.01 mm or rpm",
            Self::Increments => "inc",
            Self::SpindlePitch => "0.01 mm",
            Self::TenthDegrees => "0.1 degC",
            Self::Milliamperes => "mA",
            Self::TenthVolts => "0.1 V",
            Self::HundredthVolts => "0.01 V",
        }
    }

    /// The units that people write behind a value; empty: none.
    pub(crate) const fn written(&self) -> &'static [&'static str] {
        match self {
            Self::Percent | Self::PercentOfAcceleration => &["%"],
            Self::Rpm => &["rpm"],
            Self::Position => &["inc", "mm"],
            Self::Window => &["inc", "mm", "rpm"],
            Self::Increments => &["inc"],
            Self::SpindlePitch => &["mm"],
            Self::Milliamperes => &["mA"],
            Self::None
            | Self::TenthDegrees
            | Self::TenthVolts
            | Self::HundredthVolts
            | Self::Bits
            | Self::Ascii
            | Self::Version
            | Self::Date
            | Self::Choice(_) => &[],
        }
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
