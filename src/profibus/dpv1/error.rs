//! Why a service of DP-V1 was not carried out: Error_Decode, Error_Code_1 (class and code) and Error_Code_2 of the
//! negative response.
//!
//! Source: `dp-v1.md` 2.

use core::fmt;

/// What a negative response says behind its function number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Failure {
    /// Whose codes the other two octets are.
    pub decode: ErrorDecode,
    /// Error_Code_1.
    pub code: ErrorCode,
    /// Error_Code_2: 0, or what the manufacturer means by it.
    pub detail: u8,
}

impl Failure {
    /// A failure of DP-V1 without detail.
    pub const fn of(code: ErrorCode) -> Self {
        Self { decode: ErrorDecode::DP_V1, code, detail: 0 }
    }

    /// The three octets.
    pub const fn octets(self) -> [u8; 3] {
        [self.decode.0, self.code.0, self.detail]
    }

    /// What three octets say.
    pub const fn from_octets([decode, code, detail]: [u8; 3]) -> Self {
        Self { decode: ErrorDecode(decode), code: ErrorCode(code), detail }
    }
}

/// A failure with what to do about it: `access, invalid index (80 B0 00): the slot has no record of this index`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WithCure(pub Failure);

impl fmt::Display for WithCure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(failure) = self;
        failure.fmt(f)?;
        match failure.decode {
            ErrorDecode::DP_V1 if !failure.code.cure().is_empty() => write!(f, ": {}", failure.code.cure()),
            _ => Ok(()),
        }
    }
}

impl fmt::Display for Failure {
    /// `access, invalid index (80 B0 00)`
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [decode, code, detail] = self.octets();
        match self.decode {
            ErrorDecode::DP_V1 => write!(f, "{}", self.code)?,
            other => f.write_str(other.name())?,
        }
        write!(f, " ({decode:02X} {code:02X} {detail:02X})")
    }
}

/// Error_Decode: which protocol the codes are of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ErrorDecode(pub u8);

impl ErrorDecode {
    /// DP-V1, the only one that slaves of DP-V1 send.
    pub const DP_V1: Self = Self(0x80);
    /// FMS.
    pub const FMS: Self = Self(0xFE);
    /// HART.
    pub const HART: Self = Self(0xFF);

    /// Its name.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::DP_V1 => "an error of DP-V1",
            Self::FMS => "an error of FMS",
            Self::HART => "an error of HART",
            Self(_) => "an error of an unknown protocol",
        }
    }
}

/// Error_Code_1: the class in the high half, the code in the low one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ErrorCode(pub u8);

macro_rules! codes {
    ($($name:ident = $octet:literal: $words:literal, $cure:literal;)*) => {
        impl ErrorCode {
            $(
                #[doc = concat!($words, ".")]
                pub const $name: Self = Self($octet);
            )*

            /// Every code that the standard names.
            pub const ALL: &[Self] = &[$(Self::$name),*];

            /// What went wrong; `None` for codes of the manufacturer and reserved ones.
            pub const fn words(self) -> Option<&'static str> {
                match self.0 {
                    $($octet => Some($words),)*
                    _ => None,
                }
            }

            /// What to do about it; empty where that depends on the device.
            pub const fn cure(self) -> &'static str {
                match self.0 {
                    $($octet => $cure,)*
                    _ => "",
                }
            }
        }
    };
}

codes! {
    READ_ERROR = 0xA0: "read error", "";
    WRITE_ERROR = 0xA1: "write error", "";
    MODULE_FAILURE = 0xA2: "module failure", "read the diagnosis of the slave";
    VERSION_CONFLICT = 0xA8: "version conflict", "";
    NOT_SUPPORTED = 0xA9: "feature not supported", "the device has no such service";
    INVALID_INDEX = 0xB0: "invalid index", "the slot has no record of this index";
    WRITE_LENGTH = 0xB1: "write length error", "write as many octets as the record has";
    INVALID_SLOT = 0xB2: "invalid slot", "the device has no such slot; slot 0 is the station itself";
    TYPE_CONFLICT = 0xB3: "type conflict", "";
    INVALID_AREA = 0xB4: "invalid area", "";
    STATE_CONFLICT = 0xB5: "state conflict", "ask again later, or write the request first";
    ACCESS_DENIED = 0xB6: "access denied", "the record can only be read, or only be written";
    INVALID_RANGE = 0xB7: "invalid range", "the length octet is wrong";
    INVALID_PARAMETER = 0xB8: "invalid parameter", "";
    INVALID_TYPE = 0xB9: "invalid type", "";
    READ_CONFLICT = 0xC0: "read constraint conflict", "";
    WRITE_CONFLICT = 0xC1: "write constraint conflict", "";
    BUSY = 0xC2: "resource busy", "ask again later";
    UNAVAILABLE = 0xC3: "resource unavailable", "end another connection first";
}

impl ErrorCode {
    /// The class, in a word.
    pub const fn class(self) -> &'static str {
        match self.0 >> 4 {
            0xA => "application",
            0xB => "access",
            0xC => "resource",
            0xD.. => "of the manufacturer",
            ..=9 => "reserved",
        }
    }

    /// Whether the standard leaves its meaning to the user of the device.
    pub(crate) const fn is_of_user(self) -> bool {
        matches!(self.0, 0xAA..=0xAF | 0xBA..=0xBF | 0xC8..=0xFF)
    }
}

impl fmt::Display for ErrorCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.words() {
            Some(words) => write!(f, "{}, {words}", self.class()),
            None if self.is_of_user() => write!(f, "{}, code {:02X} of the device", self.class(), self.0),
            None => write!(f, "reserved code {:02X}", self.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_is_said_in_class_and_code() {
        for (octets, words) in [
            ([0x80, 0xB0, 0x00], "access, invalid index (80 B0 00)"),
            ([0x80, 0xC2, 0x05], "resource, resource busy (80 C2 05)"),
            ([0x80, 0xBA, 0x00], "access, code BA of the device (80 BA 00)"),
            ([0x80, 0x12, 0x00], "reserved code 12 (80 12 00)"),
            ([0xFF, 0x12, 0x00], "an error of HART (FF 12 00)"),
        ] {
            let failure = Failure::from_octets(octets);
            assert_eq!((failure.to_string().as_str(), failure.octets()), (words, octets));
        }
    }

    #[test]
    fn no_code_that_the_standard_reserves_has_words() {
        for octet in 0..=255 {
            let code = ErrorCode(octet);
            let reserved = matches!(octet, 0..=0x9F | 0xA3..=0xA7 | 0xC4..=0xC7);
            assert!(!(reserved && (code.words().is_some() || code.is_of_user())), "{octet:02X}");
        }
        assert_eq!(ErrorCode::ALL.len(), 19);
    }
}
