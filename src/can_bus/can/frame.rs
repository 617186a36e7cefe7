//! Frames of CAN 2.0 A and B (ISO 11898-1 classical frames).
//!
//! A frame has an identifier of 11 bits (base) or 29 bits (extended). It carries 0..=8 octets of data, or it is a
//! remote request, which carries a length and no data. A data length code of 9..=15 counts as 8.

use core::cmp::Ordering;
use core::fmt;

use thiserror::Error;

/// The most octets a frame carries.
pub(crate) const MAX_OCTETS: usize = 8;

/// The largest data length code that fits into its four bits.
const MAX_DLC: u8 = 15;

/// Bits of an extended identifier behind the eleven that it shares with a base identifier.
const EXTENSION_BITS: u32 = 18;

/// An identifier of 11 bits, 0..=7FFh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BaseId(u16);

impl BaseId {
    /// The highest identifier, which loses against every other base identifier.
    pub(crate) const MAX: Self = Self(0x7FF);

    /// The identifier `number`.
    ///
    /// # Errors
    /// [`IdError::Base`] above 7FFh.
    pub const fn new(number: u16) -> Result<Self, IdError> {
        if number <= Self::MAX.0 { Ok(Self(number)) } else { Err(IdError::Base { got: number as u32 }) }
    }

    /// The number, 0..=7FFh.
    pub(crate) const fn number(self) -> u16 {
        self.0
    }
}

/// An identifier of 29 bits, 0..=1FFFFFFFh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ExtendedId(u32);

impl ExtendedId {
    /// The highest identifier, which loses against every other.
    pub(crate) const MAX: Self = Self(0x1FFF_FFFF);

    /// The identifier `number`.
    ///
    /// # Errors
    /// [`IdError::Extended`] above 1FFFFFFFh.
    pub(crate) const fn new(number: u32) -> Result<Self, IdError> {
        if number <= Self::MAX.0 { Ok(Self(number)) } else { Err(IdError::Extended { got: number }) }
    }

    /// The number, 0..=1FFFFFFFh.
    pub(crate) const fn number(self) -> u32 {
        self.0
    }
}

/// The identifier of a frame. The lesser of two is the one that wins the bus: the lower number, and a base identifier
/// before an extended one with the same eleven leading bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Id {
    /// 11 bits.
    Base(BaseId),
    /// 29 bits.
    Extended(ExtendedId),
}

impl Id {
    /// The base identifier `number`.
    ///
    /// # Errors
    /// [`IdError::Base`] above 7FFh.
    pub const fn base(number: u16) -> Result<Self, IdError> {
        match BaseId::new(number) {
            Ok(id) => Ok(Self::Base(id)),
            Err(error) => Err(error),
        }
    }

    /// The extended identifier `number`.
    ///
    /// # Errors
    /// [`IdError::Extended`] above 1FFFFFFFh.
    pub const fn extended(number: u32) -> Result<Self, IdError> {
        match ExtendedId::new(number) {
            Ok(id) => Ok(Self::Extended(id)),
            Err(error) => Err(error),
        }
    }

    /// The number of either kind.
    pub const fn number(self) -> u32 {
        match self {
            Self::Base(id) => id.0 as u32,
            Self::Extended(id) => id.0,
        }
    }

    /// Whether this is an identifier of 29 bits.
    pub const fn is_extended(self) -> bool {
        match self {
            Self::Base(_) => false,
            Self::Extended(_) => true,
        }
    }
}

impl From<BaseId> for Id {
    fn from(id: BaseId) -> Self {
        Self::Base(id)
    }
}

impl From<ExtendedId> for Id {
    fn from(id: ExtendedId) -> Self {
        Self::Extended(id)
    }
}

impl Ord for Id {
    fn cmp(&self, other: &Self) -> Ordering {
        Priority::of(*self, false).cmp(&Priority::of(*other, false))
    }
}

impl PartialOrd for Id {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl fmt::Display for BaseId {
    /// Three hexadecimal digits.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:03X}", self.0)
    }
}

impl fmt::Display for ExtendedId {
    /// Eight hexadecimal digits.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:08X}", self.0)
    }
}

impl fmt::Display for Id {
    /// Three hexadecimal digits of a base identifier, eight of an extended one.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Base(id) => id.fmt(f),
            Self::Extended(id) => id.fmt(f),
        }
    }
}

/// A number that is no identifier of its kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum IdError {
    /// More than 11 bits.
    #[error("base identifier {got:X}h is outside 0..7FFh")]
    Base {
        /// The number found.
        got: u32,
    },
    /// More than 29 bits.
    #[error("extended identifier {got:X}h is outside 0..1FFFFFFFh")]
    Extended {
        /// The number found.
        got: u32,
    },
}

/// The bits of the arbitration field as they are sent, the first one highest. Of frames that begin at the same
/// instant the one with the least value goes on, the others wait.
///
/// ```text
/// base      id10..id0  RTR  IDE=0                      data before remote
/// extended  id28..id18 SRR=1 IDE=1 id17..id0 RTR       behind both with the same eleven bits
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct Priority(u32);

impl Priority {
    const fn of(id: Id, remote: bool) -> Self {
        match id {
            Id::Base(id) => Self((id.0 as u32) << 21 | (remote as u32) << 20),
            Id::Extended(id) => {
                let (leading, rest) = (id.0 >> EXTENSION_BITS, id.0 & ((1 << EXTENSION_BITS) - 1));
                Self(leading << 21 | 0b11 << 19 | rest << 1 | remote as u32)
            }
        }
    }
}

/// A data frame or a remote request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Frame {
    id: Id,
    remote: bool,
    /// 0..=8.
    length: u8,
    /// Zero from `length` on, and in a remote request.
    octets: [u8; MAX_OCTETS],
}

/// What a frame carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content<'a> {
    /// 0..=8 octets.
    Data(&'a [u8]),
    /// A request for a data frame with this identifier.
    Remote {
        /// The length asked for, 0..=8.
        dlc: u8,
    },
}

impl Frame {
    /// A data frame with `octets`.
    ///
    /// # Errors
    /// [`FrameError::TooLong`] for more than eight octets.
    pub fn data(id: impl Into<Id>, octets: &[u8]) -> Result<Self, FrameError> {
        let mut data = [0; MAX_OCTETS];
        let (Some(front), Ok(length)) = (data.get_mut(..octets.len()), u8::try_from(octets.len())) else {
            return Err(FrameError::TooLong { got: octets.len() });
        };
        front.copy_from_slice(octets);
        Ok(Self { id: id.into(), remote: false, length, octets: data })
    }

    /// A data frame with `N` octets. More than eight do not compile.
    pub fn with<const N: usize>(id: impl Into<Id>, octets: [u8; N]) -> Self {
        const { assert!(N <= MAX_OCTETS, "a CAN frame carries at most eight octets") };
        let mut data = [0; MAX_OCTETS];
        for (to, octet) in data.iter_mut().zip(octets) {
            *to = octet;
        }
        #[expect(clippy::cast_possible_truncation, reason = "at most eight, as asserted")]
        Self { id: id.into(), remote: false, length: N as u8, octets: data }
    }

    /// A remote request with the data length code `dlc`; 9..=15 count as 8.
    ///
    /// # Errors
    /// [`FrameError::Dlc`] above 15.
    pub fn remote(id: impl Into<Id>, dlc: u8) -> Result<Self, FrameError> {
        if dlc > MAX_DLC {
            return Err(FrameError::Dlc { got: dlc });
        }
        Ok(Self { id: id.into(), remote: true, length: dlc.min(8), octets: [0; MAX_OCTETS] })
    }

    /// The identifier.
    pub const fn id(&self) -> Id {
        self.id
    }

    /// Whether this is a remote request.
    pub const fn is_remote(&self) -> bool {
        self.remote
    }

    /// The data length code, 0..=8: how many octets a data frame carries or a remote request asks for.
    pub const fn dlc(&self) -> u8 {
        self.length
    }

    /// The data, empty in a remote request.
    pub fn octets(&self) -> &[u8] {
        let count = if self.remote { 0 } else { usize::from(self.length) };
        self.octets.get(..count).unwrap_or_default()
    }

    /// The data, or the length asked for.
    pub fn content(&self) -> Content<'_> {
        if self.remote { Content::Remote { dlc: self.length } } else { Content::Data(self.octets()) }
    }

    /// What decides between this frame and others that begin at the same instant.
    pub(crate) const fn priority(&self) -> Priority {
        Priority::of(self.id, self.remote)
    }
}

impl fmt::Display for Frame {
    /// `605#40 00 10 00 00 00 00 00` for data, `705#R1` for a remote request of length 1.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}#", self.id)?;
        match self.content() {
            Content::Remote { dlc } => write!(f, "R{dlc}"),
            Content::Data(octets) => {
                for (place, octet) in octets.iter().enumerate() {
                    let space = if place == 0 { "" } else { " " };
                    write!(f, "{space}{octet:02X}")?;
                }
                Ok(())
            }
        }
    }
}

/// Something that fits into no frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum FrameError {
    /// More than eight octets.
    #[error("a frame carries 0..8 octets, not {got}")]
    TooLong {
        /// How many there were.
        got: usize,
    },
    /// A data length code of more than four bits.
    #[error("a data length code is 0..15, not {got}")]
    Dlc {
        /// The code found.
        got: u8,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    fn base(number: u16) -> Id {
        Id::base(number).unwrap()
    }

    fn extended(number: u32) -> Id {
        Id::extended(number).unwrap()
    }

    #[test]
    fn identifiers_have_11_or_29_bits() {
        assert_eq!(BaseId::new(0x7FF), Ok(BaseId::MAX));
        assert_eq!(Id::base(0x800), Err(IdError::Base { got: 0x800 }));
        assert_eq!(ExtendedId::new(0x1FFF_FFFF), Ok(ExtendedId::MAX));
        assert_eq!(Id::extended(0x2000_0000), Err(IdError::Extended { got: 0x2000_0000 }));
        assert_eq!(base(5).number(), extended(5).number());
        assert_ne!(base(5), extended(5), "two identifiers with one number");
    }

    #[test]
    fn the_lower_identifier_wins_base_before_extended_and_data_before_remote() {
        let in_order = [
            Frame::with(base(0), []),
            Frame::with(base(0x080), [0xFF; 8]),
            Frame::remote(base(0x080), 0).unwrap(),
            Frame::with(extended(0x080 << 18), []),
            Frame::remote(extended(0x080 << 18), 8).unwrap(),
            Frame::with(extended(0x080 << 18 | 1), []),
            Frame::with(base(0x081), []),
            Frame::with(base(0x7FF), []),
            Frame::with(extended(0x1FFF_FFFF), []),
            Frame::remote(extended(0x1FFF_FFFF), 0).unwrap(),
        ];
        assert!(in_order.is_sorted_by(|one, next| one.priority() < next.priority()));
        let ids: Vec<_> = in_order.iter().map(Frame::id).collect();
        assert!(ids.is_sorted(), "identifiers alone are in the same order");
        assert_eq!(in_order[9].priority(), Priority(u32::MAX), "all bits recessive");
    }

    #[test]
    fn a_data_frame_carries_at_most_eight_octets() {
        for count in 0..=8 {
            let octets = [0xA5; 8];
            let frame = Frame::data(base(1), &octets[..count]).unwrap();
            assert_eq!(frame.content(), Content::Data(&octets[..count]));
            assert_eq!((usize::from(frame.dlc()), frame.is_remote()), (count, false));
        }
        assert_eq!(Frame::data(base(1), &[0; 9]), Err(FrameError::TooLong { got: 9 }));
        assert_eq!(Frame::data(base(1), &[0; 300]), Err(FrameError::TooLong { got: 300 }));
        assert_eq!(Frame::data(base(1), &[1, 2]), Ok(Frame::with(base(1), [1, 2])));
    }

    #[test]
    fn a_remote_request_carries_a_length_and_no_data_and_9_to_15_count_as_8() {
        for dlc in 0..=15 {
            let frame = Frame::remote(base(0x705), dlc).unwrap();
            assert_eq!(frame.content(), Content::Remote { dlc: dlc.min(8) });
            assert!(frame.octets().is_empty());
        }
        assert_eq!(Frame::remote(base(1), 16), Err(FrameError::Dlc { got: 16 }));
    }

    #[test]
    fn frames_in_words() {
        assert_eq!(Frame::with(base(0x605), [0x40, 0x00, 0x10]).to_string(), "605#40 00 10");
        assert_eq!(Frame::with(base(0x080), []).to_string(), "080#");
        assert_eq!(Frame::remote(base(0x705), 1).unwrap().to_string(), "705#R1");
        assert_eq!(Frame::with(extended(0x605), [1]).to_string(), "00000605#01");
    }
}
