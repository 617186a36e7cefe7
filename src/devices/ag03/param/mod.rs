//! The parameters of the drives, without any bus.
//!
//! | file | holds |
//! | --- | --- |
//! | `on_canopen` | the rows as the object dictionary has them |
//! | `model` | [`Model`], [`Gear`]: which drive |
//! | `entry` | [`Entry`]: what the table says about a parameter |
//! | `in_words` | `Entry::in_words`, [`Lengths`]: values with their units |
//! | `table` | [`TABLE`]: every parameter of both models as data, [`Parameter`] |
//! | `quirks` | [`Quirks`]: where the manuals contradict themselves |
//! | `store` | [`Store`]: the values of one drive, and who may change them when |
//!
//! A parameter is known by its number [`Pnu`] on the bus and, if it is a stored one, by its name
//! [`Parameter`] in the program. A refused access says why as [`ParamError`]; what a bus makes of it is the
//! bus's business.
//!
//! ```
//! use profidrive::devices::ag03::param::{Gear, Model, ParamError, Parameter, Pnu, Store, Value, WriteContext};
//!
//! let mut store = Store::new(Model::Ag03_1, Gear::Ratio48);
//! let v_pos = Pnu::new(1004)?;
//! store.write(v_pos, None, Value::Word(100), &WriteContext::default())?;
//! assert_eq!(store.value(Parameter::VPos), 100);
//! assert_eq!(store.read(v_pos, None, |_, _| 0), Ok(Value::Word(100)));
//!
//! // A 48:1 gear turns at most 100 rpm.
//! let refused = store.write(v_pos, None, Value::Word(101), &WriteContext::default());
//! assert_eq!(refused, Err(ParamError::OutOfRange { low: 1, high: 100, got: 101 }));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod entry;
mod in_words;
#[cfg(test)]
pub(crate) mod live;
mod model;
pub(crate) mod on_canopen;
mod quirks;
mod store;
mod table;

pub use entry::{Access, DefaultSet, Entry, Group, Kind, Limits, Models, Range, Setting, Unit, WritableWhen};
pub use in_words::{Lengths, Position};
pub use model::{Gear, GearError, Model, ModelError};
pub use quirks::Quirks;
pub use store::{Identity, Store};
pub use table::{CALIBRATE, Parameter, Reading, TABLE, entry, parameters};
pub(crate) use table::{CLEAR_FAULTS, LOAD_PARAMETER_SET, POSITIONING_MODE, VELOCITY_MODE};

use core::fmt;

use thiserror::Error;

/// The number of a parameter, 0 to 2047 (PROFIDRIVE has 11 bits for it).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Pnu(u16);

impl Pnu {
    /// The largest number.
    pub(crate) const MAX: Self = Self(2047);

    /// The parameter numbered `number`.
    ///
    /// # Errors
    /// [`PnuError`] if it does not fit in 11 bits.
    pub const fn new(number: u16) -> Result<Self, PnuError> {
        if number <= Self::MAX.0 { Ok(Self(number)) } else { Err(PnuError { got: number }) }
    }

    /// The parameter whose number is the low 11 bits of `word`.
    pub const fn from_low_bits(word: u16) -> Self {
        Self(word & Self::MAX.0)
    }

    /// The number.
    pub const fn number(self) -> u16 {
        self.0
    }
}

impl fmt::Display for Pnu {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&self.0, f)
    }
}

/// A number no parameter can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("a parameter number is at most {}, got {got}", Pnu::MAX)]
pub struct PnuError {
    /// The number found.
    pub got: u16,
}

/// Which element of an array, counted from 0 (manual chapter 7.6, PNU 945).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Subindex(pub u8);

impl fmt::Display for Subindex {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&self.0, f)
    }
}

/// How wide a value is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Width {
    /// 16 bits.
    Word,
    /// 32 bits.
    Double,
}

impl fmt::Display for Width {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Word => "word",
            Self::Double => "double word",
        })
    }
}

/// A value as a bus carries it: bits of a width. [`Entry::number`] knows its sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Value {
    /// 16 bits.
    Word(u16),
    /// 32 bits.
    Double(u32),
}

impl Value {
    /// `number` in two's complement, of which a word keeps the low 16 bits.
    pub const fn of(width: Width, number: i32) -> Self {
        match width {
            Width::Word => {
                let [_, _, high, low] = number.to_be_bytes();
                Self::Word(u16::from_be_bytes([high, low]))
            }
            Width::Double => Self::Double(number.cast_unsigned()),
        }
    }

    /// How wide it is.
    pub const fn width(self) -> Width {
        match self {
            Self::Word(_) => Width::Word,
            Self::Double(_) => Width::Double,
        }
    }

    /// The bits, zero-extended.
    pub const fn bits(self) -> u32 {
        match self {
            Self::Word(word) => word as u32,
            Self::Double(double) => double,
        }
    }
}

impl core::fmt::Display for Value {
    /// A word without sign, a double word with sign, as nearly all parameters of PROFIDRIVE are meant.
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Word(word) => core::fmt::Display::fmt(word, f),
            Self::Double(double) => core::fmt::Display::fmt(&double.cast_signed(), f),
        }
    }
}

/// What a drive is doing, as far as write permissions depend on it (`ag03.md` 3.4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WriteContext {
    /// The shaft or its profile is in motion (travel, inching, braking, coasting).
    pub moving: bool,
    /// A travel job is active or paused, inching is active, or a velocity setpoint is released.
    pub job_active: bool,
}

/// What a successful write asks the drive to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub enum Effect {
    /// Nothing: no stored value differs from before.
    None,
    /// Stored values changed: the drive reads them anew, the host saves them.
    SettingsChanged,
    /// PNU 970 = 4: clear fault buffer and fault counter.
    ClearFaults,
    /// PNU 970 = 5: set the position to the calibration value.
    Calibrate,
}

/// Elements of the fault buffer, PNU 945.
pub(crate) const FAULT_BUFFER_LEN: u8 = 10;

/// A write that means something to the drive, by whatever number and width it came.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Write {
    /// A stored parameter gets this value, in the units of the table.
    Set(Parameter, i32),
    /// Defaults are loaded (PNU 970 = 1 to 3).
    Load(DefaultSet),
    /// Fault buffer and fault counter are cleared (PNU 970 = 4).
    ClearFaults,
    /// The position becomes the calibration value (PNU 970 = 5).
    Calibrate,
}

impl Write {
    /// Whether the EEPROM keeps what it changes. The commands all change something it keeps.
    pub(crate) fn is_kept(self) -> bool {
        match self {
            Self::Set(parameter, _) => parameter.entry().persistent,
            Self::Load(_) | Self::ClearFaults | Self::Calibrate => true,
        }
    }
}

/// Why an access to a parameter was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ParamError {
    /// This model has no such parameter.
    #[error("there is no parameter {got}")]
    UnknownParameter {
        /// The number asked for.
        got: Pnu,
    },
    /// The parameter can only be read.
    #[error("the parameter is read-only")]
    ReadOnly,
    /// The value is outside the parameter's range.
    #[error("the value must be within {low} to {high}, got {got}")]
    OutOfRange {
        /// Smallest value allowed.
        low: i32,
        /// Largest value allowed.
        high: i32,
        /// The value found.
        got: i32,
    },
    /// The array has no such element.
    #[error("the array has {count} elements counted from 0, got sub-index {got}")]
    SubindexOutOfRange {
        /// Elements of the array.
        count: u8,
        /// The sub-index found.
        got: Subindex,
    },
    /// An element was asked of a parameter that is a single value.
    #[error("the parameter is no array")]
    NotAnArray,
    /// A single value was asked of a parameter that is an array.
    #[error("the parameter is an array of {count} elements and needs an array access")]
    IsArray {
        /// Elements of the array.
        count: u8,
    },
    /// The value is of the other width.
    #[error("the parameter is a {expected}, got a {got}")]
    WrongWidth {
        /// Width of the parameter.
        expected: Width,
        /// Width of the value found.
        got: Width,
    },
    /// Everything about the write is right, only not in the present operating state.
    #[error("not possible now: {0}")]
    NotNow(NotNow),
}

/// What the drive is doing that forbids a write (`ag03.md` 3.4).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Error)]
#[error("{}", self.words())]
#[non_exhaustive]
pub enum NotNow {
    /// The write is only allowed at standstill.
    Moving,
    /// The write is only allowed without a travel job.
    JobActive,
}

impl NotNow {
    /// In words.
    pub(crate) const fn words(self) -> &'static str {
        match self {
            Self::Moving => "the shaft is moving",
            Self::JobActive => "a travel job is active",
        }
    }
}

#[cfg(test)]
mod tests {

    use super::*;

    #[test]
    fn a_number_has_11_bits() {
        assert_eq!(Pnu::new(2047), Ok(Pnu::MAX));
        assert_eq!(Pnu::new(2048), Err(PnuError { got: 2048 }));
        assert_eq!(Pnu::from_low_bits(0xFFFF), Pnu::MAX);
        assert_eq!(PnuError { got: 2048 }.to_string(), "a parameter number is at most 2047, got 2048");
    }

    #[test]
    fn values_keep_their_bits() {
        assert_eq!(Value::of(Width::Word, -1), Value::Word(0xFFFF));
        assert_eq!(Value::of(Width::Double, -1_000_000), Value::Double(0xFFF0_BDC0));
        assert_eq!(Value::Word(0x8000).bits(), 0x8000);
    }
}
