//! Error numbers of the parameter channel.

use core::fmt;

use strum::VariantArray;
use thiserror::Error;

use super::table::Width;
use crate::profibus::ppo::ReservedId;

/// Why the parameter channel does not execute a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum JobError {
    /// The job identification has no meaning.
    #[error("job {0} does not exist")]
    UnknownJob(ReservedId),
    /// The drive keeps no descriptions of its parameters.
    #[error("the drive holds no description of the parameter")]
    NoDescription,
    /// Descriptions cannot be written.
    #[error("the description of a parameter cannot be changed")]
    DescriptionReadOnly,
    /// The parameter is a command and has nothing to read.
    #[error("the parameter can only be written")]
    WriteOnly,
    /// The EEPROM does not take the value (decided here: error 18, no manual says what happens).
    #[error("the EEPROM did not store it, so nothing was changed")]
    NotStored,
    /// There is no such parameter.
    #[error("there is no parameter {got}")]
    UnknownParameter {
        /// The number asked for.
        got: u16,
    },
    /// The octet of IND that some families have for pages is not one of this drive.
    #[error("the low octet of IND is {got:02X}: this drive has no such page of parameters")]
    NoPage {
        /// The octet.
        got: u8,
    },
    /// The value names a parameter that is not there.
    #[error("the value names parameter {got}, which is not there; 0 names none")]
    NamesNone {
        /// The value.
        got: u16,
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
        got: u8,
    },
    /// The array, whose elements count from 1, has no such element.
    #[error("the array has {count} elements counted from 1, got sub-index {got}")]
    NoElement {
        /// Elements of the array.
        count: u8,
        /// The sub-index found.
        got: u8,
    },
    /// The value, which may be a fraction, is outside the parameter's range: `JobError::outside`.
    #[error("the value must be within {} to {}, got {}", f64::from_bits(*.low), f64::from_bits(*.high), f64::from_bits(*.got))]
    Outside {
        /// Smallest value allowed, the bits of an `f64`.
        low: u64,
        /// Largest value allowed.
        high: u64,
        /// The value found.
        got: u64,
    },
    /// The name in a description has 16 octets, more than a reply holds.
    #[error("the name has 16 octets and a reply holds four")]
    NameTooLong,
    /// The whole description has 46 octets, more than a reply holds.
    #[error("the whole description has 46 octets and a reply holds four: read its elements 1 to 10")]
    DescriptionTooLong,
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
    /// The value may only be set to 0.
    #[error("the value may only be set to 0")]
    OnlyZero,
    /// The master has no right to change parameters.
    #[error("parameters may not be changed now")]
    NoRight,
    /// Everything about the write is right, only not in the present operating state, and why.
    #[error("not possible now: {0}")]
    NotNow(&'static str),
}

impl JobError {
    /// A value outside a range, of any type of number.
    pub(crate) const fn outside(low: f64, high: f64, got: f64) -> Self {
        Self::Outside { low: low.to_bits(), high: high.to_bits(), got: got.to_bits() }
    }
}

/// The number in word 4 of a reply "job not executable" (manual table 10).
///
/// [`JobError`] leads to 0 to 7, 9, 11, 14 and 17 to 19; a master may meet the others in replies of other drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, VariantArray)]
pub enum ErrorNumber {
    /// 0
    IllegalParameterNumber,
    /// 1
    NotChangeable,
    /// 2
    LimitExceeded,
    /// 3
    FaultySubindex,
    /// 4
    NoArray,
    /// 5
    WrongDataType,
    /// 6
    OnlyResettable,
    /// 7
    DescriptionNotChangeable,
    /// 8
    PpoWriteInReportMissing,
    /// 9
    NoDescription,
    /// 10
    WrongAccessGroup,
    /// 11
    NoControlRights,
    /// 12
    WrongPassword,
    /// 13
    TextNotReadable,
    /// 14
    NameNotReadable,
    /// 15
    NoTextArray,
    /// 16
    PpoWriteMissing,
    /// 17
    OperatingState,
    /// 18
    Other,
    /// 19
    DatumNotReadable,
}

impl ErrorNumber {
    /// Every number, from 0 on.
    pub const ALL: &'static [Self] = <Self as VariantArray>::VARIANTS;

    /// The error numbered `number`, if the manual lists it.
    pub(crate) fn from_number(number: u16) -> Option<Self> {
        Self::ALL.get(usize::from(number)).copied()
    }

    /// The number on the bus.
    pub const fn number(self) -> u16 {
        self as u16
    }

    /// What it means, without the number.
    pub const fn text(self) -> &'static str {
        match self {
            Self::IllegalParameterNumber => "no such parameter number",
            Self::NotChangeable => "value cannot be changed",
            Self::LimitExceeded => "value outside the limits",
            Self::FaultySubindex => "wrong sub-index",
            Self::NoArray => "not an array",
            Self::WrongDataType => "wrong data type",
            Self::OnlyResettable => "value can only be reset",
            Self::DescriptionNotChangeable => "description cannot be changed",
            Self::PpoWriteInReportMissing => "PPO write required in the information report is missing",
            Self::NoDescription => "no description available",
            Self::WrongAccessGroup => "wrong access group",
            Self::NoControlRights => "no control rights",
            Self::WrongPassword => "wrong password",
            Self::TextNotReadable => "text cannot be read cyclically",
            Self::NameNotReadable => "name cannot be read cyclically",
            Self::NoTextArray => "no text array",
            Self::PpoWriteMissing => "PPO write is missing",
            Self::OperatingState => "not possible in this operating state",
            Self::Other => "other error",
            Self::DatumNotReadable => "datum cannot be read cyclically",
        }
    }
}

impl fmt::Display for ErrorNumber {
    /// `error 2, value outside the limits`
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "error {}, {}", self.number(), self.text())
    }
}

/// The one place that decides how an error is answered (`ag03.md` 2.3).
impl From<JobError> for ErrorNumber {
    fn from(error: JobError) -> Self {
        match error {
            JobError::UnknownJob(_) | JobError::WriteOnly | JobError::NotStored => Self::Other,
            JobError::NoDescription => Self::NoDescription,
            JobError::DescriptionReadOnly => Self::DescriptionNotChangeable,
            JobError::UnknownParameter { .. } | JobError::NoPage { .. } => Self::IllegalParameterNumber,
            JobError::ReadOnly => Self::NotChangeable,
            JobError::OutOfRange { .. } | JobError::Outside { .. } | JobError::NamesNone { .. } => {
                Self::LimitExceeded
            }
            JobError::NameTooLong => Self::NameNotReadable,
            JobError::DescriptionTooLong => Self::DatumNotReadable,
            JobError::SubindexOutOfRange { .. } | JobError::NoElement { .. } => Self::FaultySubindex,
            JobError::NotAnArray => Self::NoArray,
            JobError::IsArray { .. } | JobError::WrongWidth { .. } => Self::WrongDataType,
            JobError::OnlyZero => Self::OnlyResettable,
            JobError::NoRight => Self::NoControlRights,
            JobError::NotNow(_) => Self::OperatingState,
        }
    }
}

#[cfg(test)]
mod tests {

    use super::*;

    #[test]
    fn the_numbers_are_those_of_manual_table_10() {
        for (number, &error) in (0..).zip(ErrorNumber::ALL) {
            assert_eq!(error.number(), number);
            assert_eq!(ErrorNumber::from_number(number), Some(error));
        }
        assert_eq!(ErrorNumber::from_number(20), None);
        assert_eq!(ErrorNumber::OperatingState.to_string(), "error 17, not possible in this operating state");
    }
}
