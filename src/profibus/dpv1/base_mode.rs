//! Parameters of a drive by record 47, base mode: a request is written, its response is read.
//!
//! ```text
//! request    reference  01 read, 02 change  axis  n   n x (attribute, elements, PNU(2), sub-index(2))
//!            behind them, for a change, n x values
//! response   reference  01, 02; 81, 82 if a parameter failed  axis  n   n x values
//!            to a change that went well nothing follows
//! values     format, number, octets, 00 behind an odd number of octets
//! ```
//!
//! Source: `dp-v1.md` 9.1.

use super::pdu::put;

/// Octets before the parameters.
pub(crate) const HEAD_LEN: usize = 4;

/// Octets of the address of a parameter.
pub(crate) const ADDRESS_LEN: usize = 6;

/// The most parameters of a request.
pub(crate) const MAX_PARAMETERS: u8 = 39;

/// What is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Service {
    /// Read values, descriptions, texts.
    Read,
    /// Change values.
    Change,
    /// A number that is none.
    Unknown(u8),
}

impl Service {
    /// Set in the response if a parameter failed.
    const FAILED: u8 = 0x80;

    const fn numbered(number: u8) -> Self {
        match number {
            1 => Self::Read,
            2 => Self::Change,
            number => Self::Unknown(number),
        }
    }

    const fn number(self) -> u8 {
        match self {
            Self::Read => 1,
            Self::Change => 2,
            Self::Unknown(number) => number,
        }
    }
}

/// The first four octets of a request or a response.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Head {
    /// Request_Reference, mirrored.
    pub reference: u8,
    /// What is asked.
    pub service: Service,
    /// A parameter failed; of a response only.
    pub failed: bool,
    /// Of several axes which.
    pub axis: u8,
    /// No_of_Parameters.
    pub parameters: u8,
}

impl Head {
    /// Reads the head of a request and what is behind it.
    pub(crate) const fn of_request(octets: &[u8]) -> Option<(Self, &[u8])> {
        let [reference, id, axis, parameters, rest @ ..] = octets else { return None };
        let service = Service::numbered(*id);
        Some((
            Self { reference: *reference, service, failed: false, axis: *axis, parameters: *parameters },
            rest,
        ))
    }

    /// Reads the head of a response and what is behind it.
    pub const fn of_response(octets: &[u8]) -> Option<(Self, &[u8])> {
        let [reference, id, axis, parameters, rest @ ..] = octets else { return None };
        let service = Service::numbered(*id & !Service::FAILED);
        let failed = *id & Service::FAILED != 0;
        Some((Self { reference: *reference, service, failed, axis: *axis, parameters: *parameters }, rest))
    }

    /// Its octets.
    pub const fn octets(self) -> [u8; HEAD_LEN] {
        let failed = if self.failed { Service::FAILED } else { 0 };
        [self.reference, self.service.number() | failed, self.axis, self.parameters]
    }
}

/// Which part of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Attribute {
    /// Its value.
    Value,
    /// Its description.
    Description,
    /// Its text.
    Text,
    /// A number that is none.
    Unknown(u8),
}

impl Attribute {
    const fn numbered(number: u8) -> Self {
        match number {
            0x10 => Self::Value,
            0x20 => Self::Description,
            0x30 => Self::Text,
            number => Self::Unknown(number),
        }
    }

    const fn number(self) -> u8 {
        match self {
            Self::Value => 0x10,
            Self::Description => 0x20,
            Self::Text => 0x30,
            Self::Unknown(number) => number,
        }
    }
}

/// The address of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ParameterAddress {
    /// Which part of it.
    pub attribute: Attribute,
    /// How many elements, 0: a simple parameter.
    pub elements: u8,
    /// The number of the parameter.
    pub pnu: u16,
    /// The first element.
    pub subindex: u16,
}

impl ParameterAddress {
    /// The first address of these octets, and what is behind it.
    pub const fn split(octets: &[u8]) -> Option<(Self, &[u8])> {
        let [attribute, elements, p1, p0, s1, s0, rest @ ..] = octets else { return None };
        let address = Self {
            attribute: Attribute::numbered(*attribute),
            elements: *elements,
            pnu: u16::from_be_bytes([*p1, *p0]),
            subindex: u16::from_be_bytes([*s1, *s0]),
        };
        Some((address, rest))
    }

    /// Its octets.
    pub const fn octets(self) -> [u8; ADDRESS_LEN] {
        let ([p1, p0], [s1, s0]) = (self.pnu.to_be_bytes(), self.subindex.to_be_bytes());
        [self.attribute.number(), self.elements, p1, p0, s1, s0]
    }
}

/// The format of values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Format(pub u8);

macro_rules! formats {
    ($($name:ident = $number:literal: $size:literal, $words:literal;)*) => {
        impl Format {
            $(
                #[doc = concat!($words, ".")]
                pub const $name: Self = Self($number);
            )*

            /// Every format that is known.
            pub const ALL: &[Self] = &[$(Self::$name),*];

            /// The octets of one value; `None` if the format is unknown.
            pub const fn size(self) -> Option<usize> {
                match self.0 {
                    $($number => Some($size),)*
                    _ => None,
                }
            }

            /// What it is.
            pub const fn words(self) -> &'static str {
                match self.0 {
                    $($number => $words,)*
                    _ => "an unknown format",
                }
            }
        }
    };
}

formats! {
    BOOLEAN = 0x01: 1, "boolean";
    INTEGER8 = 0x02: 1, "integer of 8 bits";
    INTEGER16 = 0x03: 2, "integer of 16 bits";
    INTEGER32 = 0x04: 4, "integer of 32 bits";
    UNSIGNED8 = 0x05: 1, "unsigned of 8 bits";
    UNSIGNED16 = 0x06: 2, "unsigned of 16 bits";
    UNSIGNED32 = 0x07: 4, "unsigned of 32 bits";
    FLOAT = 0x08: 4, "floating point";
    VISIBLE_STRING = 0x09: 1, "text";
    OCTET_STRING = 0x0A: 1, "octets";
    TIME_OF_DAY = 0x0C: 6, "time of day";
    TIME_DIFFERENCE = 0x0D: 4, "time difference";
    N2 = 0x21: 2, "normalised of 16 bits";
    N4 = 0x22: 4, "normalised of 32 bits";
    V2 = 0x23: 2, "bits";
    L2 = 0x24: 2, "nibbles";
    ZERO = 0x40: 0, "no value";
    BYTE = 0x41: 1, "octet";
    WORD = 0x42: 2, "word";
    DOUBLE_WORD = 0x43: 4, "double word";
    ERROR = 0x44: 2, "error";
}

/// The values of one parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Values<'a> {
    /// Their format.
    pub format: Format,
    /// How many.
    pub count: u8,
    /// Their octets.
    pub octets: &'a [u8],
}

impl<'a> Values<'a> {
    /// The first values of these octets, and what is behind them. `None` if they are cut off or of an unknown format.
    pub fn split(octets: &'a [u8]) -> Option<(Self, &'a [u8])> {
        let [format, count, ref rest @ ..] = *octets else { return None };
        let format = Format(format);
        let len = format.size()?.checked_mul(count.into())?;
        let (octets, behind) = rest.split_at_checked(len)?;
        // Words are aligned; behind the last values the 00 may be missing.
        let behind = if len % 2 == 1 { behind.get(1..).unwrap_or_default() } else { behind };
        Some((Self { format, count, octets }, behind))
    }

    /// Writes them to `buf`; `None` if there are fewer or more octets than the format has, or no room.
    pub fn encode<'b>(&self, buf: &'b mut [u8]) -> Option<&'b [u8]> {
        if self.format.size()?.checked_mul(self.count.into())? != self.octets.len() {
            return None;
        }
        let pad: &[u8] = if self.octets.len() % 2 == 1 { &[0] } else { &[] };
        put(buf, &[&[self.format.0, self.count], self.octets, pad])
    }

    /// The error and what it is about, if these are no values.
    pub fn error(&self) -> Option<(ParameterError, u16)> {
        let word = |at: usize| {
            self.octets.get(at..).and_then(<[u8]>::first_chunk).map(|octets| u16::from_be_bytes(*octets))
        };
        (self.format == Format::ERROR).then(|| (ParameterError(word(0).unwrap_or(0)), word(2).unwrap_or(0)))
    }
}

/// Why a parameter was not read or changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ParameterError(pub u16);

impl ParameterError {
    /// What it says.
    pub const fn words(self) -> &'static str {
        match self.0 {
            0x00 => "no such parameter",
            0x01 => "not changeable",
            0x02 => "outside of its limits",
            0x03 => "no such sub-index",
            0x04 => "no array",
            0x05 => "wrong data type",
            0x06 => "may only be set to 0",
            0x07 => "its description cannot be changed",
            0x09 => "no description",
            0x0B => "no right to change it",
            0x0F => "no texts",
            0x10 => "may not be read",
            0x11 => "not in this state of the drive",
            0x14 => "a value that is not permitted",
            0x15 => "the response is too long",
            0x16 => "an address that is none",
            0x17 => "a format that is none",
            0x18 => "another number of values than of elements",
            0x19 => "no such axis",
            0x20 => "its text cannot be changed",
            0x21 => "no such service",
            0x23 => "too many requests at once",
            0x65.. => "an error of the manufacturer",
            _ => "a reserved error",
        }
    }

    /// What helps; empty: nothing that is always the same.
    pub const fn cure(self) -> &'static str {
        match self.0 {
            0x00 | 0x16 => "read the list of parameters, PNU 980, to see which there are",
            0x01 => "read its description: it may only be read",
            0x02 | 0x14 => "read its description: it has the limits",
            0x03 | 0x18 => "read its description: it has the number of elements",
            0x04 => "leave the sub-index out",
            0x05 | 0x17 => "write the format that it is read with",
            0x0B => "take the right to change parameters first, PNU 927",
            0x11 => "bring the drive to another state first, mostly to standstill",
            0x15 | 0x23 => "ask for less at once",
            0x19 => "choose another axis (DO-ID): PNU 978 lists them",
            _ => "",
        }
    }

    /// Whether its second word is a sub-index.
    pub(crate) const fn names_subindex(self) -> bool {
        matches!(self.0, 0x01..=0x03 | 0x06 | 0x07 | 0x14)
    }
}

/// The description of a parameter: 46 octets in twelve elements (`profidrive-v2.md` 6).
pub(crate) mod description {
    /// Bits of the identifier: 14, 10 and 9; bits 7 to 0 are the format.
    pub(crate) const ARRAY: u16 = 0x4000;
    /// There are texts of the values.
    pub(crate) const HAS_TEXTS: u16 = 0x0400;
    /// The parameter can only be read.
    pub(crate) const CANNOT_BE_WRITTEN: u16 = 0x0200;

    /// Each unit with its variable index and conversion index; 0 and 0: none.
    pub(crate) const UNITS: [(&str, [u8; 2]); 9] = [
        ("s", [4, 0]),
        ("ms", [4, 0xFD]),
        ("kW", [9, 3]),
        ("rpm", [11, 67]),
        ("Nm", [16, 0]),
        ("°C", [17, 0]),
        ("V", [21, 0]),
        ("A", [22, 0]),
        ("%", [24, 0]),
    ];
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_request_and_its_response_are_those_of_the_reference() {
        let request = [0x01, 0x01, 0x00, 0x01, 0x10, 0x06, 0x03, 0xC4, 0x00, 0x00];
        let (head, rest) = Head::of_request(&request).unwrap();
        let (address, rest) = ParameterAddress::split(rest).unwrap();
        let expected = ParameterAddress { attribute: Attribute::Value, elements: 6, pnu: 964, subindex: 0 };
        assert_eq!((head.service, head.parameters, address, rest), (Service::Read, 1, expected, &[][..]));
        assert_eq!([&head.octets()[..], &address.octets()].concat(), request);
        let response = [1, 1, 0, 1, 6, 6, 0, 0x2A, 0, 1, 0, 0x64, 7, 0xEA, 0x0B, 0x16, 0, 1];
        let (head, rest) = Head::of_response(&response).unwrap();
        let (values, rest) = Values::split(rest).unwrap();
        assert_eq!((head.failed, values.format, values.count, rest), (false, Format::UNSIGNED16, 6, &[][..]));
        assert_eq!(&values.octets[..4], [0, 42, 0, 1]);
    }

    #[test]
    fn one_bad_parameter_of_two_says_its_error_and_the_other_its_value() {
        let response = [4, 0x81, 0, 2, 0x42, 1, 0, 1, 0x44, 1, 0, 0];
        let (head, rest) = Head::of_response(&response).unwrap();
        assert_eq!((head.failed, head.service, head.octets()), (true, Service::Read, [4, 0x81, 0, 2]));
        let (good, rest) = Values::split(rest).unwrap();
        let (bad, rest) = Values::split(rest).unwrap();
        assert_eq!((good.error(), bad.error(), rest), (None, Some((ParameterError(0), 0)), &[][..]));
        let with_info = Values { format: Format::ERROR, count: 2, octets: &[0, 3, 0, 9] };
        let (error, info) = with_info.error().unwrap();
        assert_eq!((error.words(), error.names_subindex(), info), ("no such sub-index", true, 9));
    }

    #[test]
    fn an_odd_number_of_octets_has_one_more_behind_it() {
        let values = Values { format: Format::BYTE, count: 3, octets: &[1, 2, 3] };
        let mut buf = [0xFF; 8];
        assert_eq!(values.encode(&mut buf), Some(&[0x41, 3, 1, 2, 3, 0][..]));
        assert_eq!(Values::split(&[0x41, 3, 1, 2, 3, 0, 9]), Some((values, &[9][..])));
        assert_eq!(Values::split(&[0x41, 3, 1, 2, 3]), Some((values, &[][..])), "nothing follows");
        for cut in [&[][..], &[0x41], &[0x41, 3, 1, 2], &[0x99, 1, 0, 0]] {
            assert_eq!(Values::split(cut), None, "{cut:02X?}");
        }
        assert_eq!(Values { count: 2, ..values }.encode(&mut buf), None);
    }

    proptest! {
        #[test]
        fn whatever_is_read_is_written_back(octets in proptest::collection::vec(any::<u8>(), 0..64)) {
            if let Some((head, rest)) = Head::of_request(&octets) {
                prop_assert_eq!([&head.octets()[..], rest].concat(), octets.clone());
            }
            if let Some((head, rest)) = Head::of_response(&octets) {
                prop_assert_eq!([&head.octets()[..], rest].concat(), octets.clone());
            }
            if let Some((address, rest)) = ParameterAddress::split(&octets) {
                prop_assert_eq!([&address.octets()[..], rest].concat(), octets.clone());
            }
            let mut formatted: Vec<u8> = octets;
            if let Some(format) = formatted.first_mut() {
                *format = Format::ALL[usize::from(*format) % Format::ALL.len()].0;
            }
            if let Some((values, _)) = Values::split(&formatted) {
                let mut buf = [0; 300];
                let again = values.encode(&mut buf).unwrap();
                prop_assert_eq!(Values::split(again), Some((values, &[][..])));
            }
        }
    }
}
