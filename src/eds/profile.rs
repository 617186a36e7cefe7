//! What kind of device a file describes.

use core::fmt;

use super::Eds;

/// A kind of device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Profile {
    /// CiA 401: inputs and outputs.
    InputsOutputs,
    /// CiA 402: a drive.
    Drive,
    /// CiA 406: an encoder.
    Encoder,
    /// Another profile, the low half of 1000h.
    Other(u16),
    /// 1000h has 0, or no default, and no object of a profile that is known.
    None,
}

impl Profile {
    /// By the default of 1000h; without one by the objects that every device of a profile has.
    pub(super) fn of(eds: &Eds) -> Self {
        let has = |indexes: &[u16]| indexes.iter().all(|index| eds.objects.contains_key(index));
        match eds.number(0x1000, 0).map(|number| number & 0xFFFF) {
            Some(401) => Self::InputsOutputs,
            Some(402) => Self::Drive,
            Some(406) => Self::Encoder,
            Some(number @ 1..=0xFFFF) => Self::Other(u16::try_from(number).unwrap_or_default()),
            Some(_) => Self::None,
            None if has(&[0x6040, 0x6041]) => Self::Drive,
            // 6000h is one number there, and an array in CiA 401.
            None if has(&[0x6000, 0x6004]) && eds.entry(0x6000, 1).is_none() => Self::Encoder,
            None if has(&[0x6000]) || has(&[0x6200]) => Self::InputsOutputs,
            None => Self::None,
        }
    }

    /// The low half of 1000h.
    pub const fn number(self) -> u16 {
        match self {
            Self::InputsOutputs => 401,
            Self::Drive => 402,
            Self::Encoder => 406,
            Self::Other(number) => number,
            Self::None => 0,
        }
    }
}

impl fmt::Display for Profile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::InputsOutputs => f.write_str("CiA 401, inputs and outputs"),
            Self::Drive => f.write_str("CiA 402, drive"),
            Self::Encoder => f.write_str("CiA 406, encoder"),
            Self::Other(number) => write!(f, "CiA {number}"),
            Self::None => f.write_str("no profile"),
        }
    }
}
