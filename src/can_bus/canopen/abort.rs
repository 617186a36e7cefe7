//! Abort codes of SDO transfers (CiA 301; `canopen-link.md` 5).

use core::fmt;

/// Why a transfer ends without result. Every 32-bit number can come from a network; those of CiA 301 have a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Abort(u32);

/// Declares the named codes and their text once.
macro_rules! codes {
    ($($name:ident = $code:literal, $text:literal;)*) => {
        impl Abort {
            $(#[doc = concat!("`", stringify!($code), "`: ", $text, ".")] pub const $name: Self = Self($code);)*

            /// Every code with a name.
            pub const ALL: &'static [Self] = &[$(Self::$name),*];

            /// What the code means, `None` for a code without a name.
            pub const fn meaning(self) -> Option<&'static str> {
                match self {
                    $(Self::$name => Some($text),)*
                    Self(_) => None,
                }
            }
        }
    };
}

codes! {
    TOGGLE = 0x0503_0000, "toggle bit not alternated";
    TIMEOUT = 0x0504_0000, "SDO protocol timed out";
    COMMAND = 0x0504_0001, "command specifier not valid or unknown";
    BLOCK_SIZE = 0x0504_0002, "invalid block size";
    SEQUENCE = 0x0504_0003, "invalid sequence number";
    CRC = 0x0504_0004, "CRC error";
    MEMORY = 0x0504_0005, "out of memory";
    UNSUPPORTED_ACCESS = 0x0601_0000, "unsupported access to an object";
    WRITE_ONLY = 0x0601_0001, "attempt to read a write-only object";
    READ_ONLY = 0x0601_0002, "attempt to write a read-only object";
    NO_OBJECT = 0x0602_0000, "object does not exist in the object dictionary";
    NOT_MAPPABLE = 0x0604_0041, "object cannot be mapped to the PDO";
    PDO_LENGTH = 0x0604_0042, "the mapped objects would exceed the PDO length";
    PARAMETER = 0x0604_0043, "general parameter incompatibility";
    INTERNAL = 0x0604_0047, "general internal incompatibility in the device";
    HARDWARE = 0x0606_0000, "access failed due to a hardware error";
    LENGTH = 0x0607_0010, "data type or length of the parameter does not match";
    TOO_LONG = 0x0607_0012, "data type does not match, parameter too long";
    TOO_SHORT = 0x0607_0013, "data type does not match, parameter too short";
    NO_SUB = 0x0609_0011, "sub-index does not exist";
    RANGE = 0x0609_0030, "value range of the parameter exceeded";
    TOO_HIGH = 0x0609_0031, "value of the parameter written too high";
    TOO_LOW = 0x0609_0032, "value of the parameter written too low";
    MAX_BELOW_MIN = 0x0609_0036, "maximum value is less than minimum value";
    RESOURCE = 0x060A_0023, "resource not available";
    GENERAL = 0x0800_0000, "general error";
    TRANSFER = 0x0800_0020, "data cannot be transferred or stored to the application";
    LOCAL_CONTROL = 0x0800_0021, "data cannot be transferred or stored because of local control";
    DEVICE_STATE = 0x0800_0022, "data cannot be transferred or stored because of the present device state";
    NO_DICTIONARY = 0x0800_0023, "no object dictionary is present";
    NO_DATA = 0x0800_0024, "no data available";
}

impl Abort {
    /// A code by its number.
    pub(crate) const fn from_code(code: u32) -> Self {
        Self(code)
    }

    /// What the client should do, for codes of a request that it can correct.
    pub(crate) const fn cure(self) -> Option<&'static str> {
        match self {
            Self::UNSUPPORTED_ACCESS => Some("check command specifier and number of octets"),
            Self::NO_OBJECT | Self::NO_SUB => Some("the EDS of the device lists what there is"),
            Self::READ_ONLY => Some("it can only be read"),
            Self::WRITE_ONLY => Some("it can only be written"),
            Self::LENGTH | Self::TOO_LONG | Self::TOO_SHORT => Some("send as many octets as the EDS says"),
            Self::RANGE | Self::TOO_HIGH | Self::TOO_LOW => Some("send a value within the limits of the EDS"),
            Self::NOT_MAPPABLE => Some("map an entry whose PDOMapping is 1 in the EDS"),
            Self::PDO_LENGTH => Some("map at most eight octets"),
            Self::MAX_BELOW_MIN => Some("send the other limit first"),
            Self::DEVICE_STATE => {
                Some("send it in another state of the node or the drive, or switch the PDO off first")
            }
            Self(_) => None,
        }
    }

    /// The number as on the bus.
    pub const fn code(self) -> u32 {
        self.0
    }
}

impl fmt::Display for Abort {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.meaning() {
            Some(meaning) => write!(f, "{meaning} ({:08X}h)", self.0),
            None => write!(f, "abort code {:08X}h", self.0),
        }
    }
}

impl core::error::Error for Abort {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_distinct_and_said_with_their_number() {
        let mut sorted = std::vec::Vec::from(Abort::ALL);
        sorted.dedup();
        assert_eq!(sorted.len(), Abort::ALL.len());
        assert_eq!(Abort::NO_SUB.to_string(), "sub-index does not exist (06090011h)");
        assert_eq!(Abort::from_code(0x0800_00A2).to_string(), "abort code 080000A2h");
    }
}
