//! Extended diagnosis: the blocks behind the six octets of Slave_Diag.
//!
//! ```text
//! 00LLLLLL data..           device-related: LLLLLL = octets with this one, 2..=63
//! 01LLLLLL bits..           identifier-related: one bit a module, bit 0 of the first octet = module 0
//! 10MMMMMM DDCCCCCC TTTEEEEE  channel-related: module 0..=63, DD = 01 input 10 output 11 both,
//!                           channel 0..=63, TTT = 1..=6 how wide, EEEEE = 1..=31 what is wrong
//! 11RRRRRR                  revision number 0..=63
//! ```
//!
//! Source: `dp-v0.md` 6.2.

use thiserror::Error;

/// The most octets of extended diagnosis.
pub(crate) const MAX_LEN: usize = 238;

/// The most data octets of a device-related or identifier-related block.
pub(crate) const MAX_BLOCK_DATA: usize = 62;

const DEVICE: u8 = 0x00;
const IDENTIFIER: u8 = 0x40;
/// The bits of a header that say what kind of block it is; 0: device-related.
pub(crate) const FORMAT: u8 = 0xC0;

const CHANNEL: u8 = 0x80;
const REVISION: u8 = 0xC0;
const SIX_BITS: u8 = 0x3F;
const CHANNEL_LEN: usize = 3;

/// What the application reports in Slave_Diag, built block by block into a buffer of its own.
///
/// ```
/// use profidrive::profibus::dp::ext_diag::{Block, Channel, ChannelError, Direction, ExtDiag, Width};
///
/// let mut diagnosis = ExtDiag::fault();
/// diagnosis.push(Block::Modules(&[0b10]))?;
/// let channel = Channel {
///     module: 1,
///     direction: Direction::Output,
///     channel: 3,
///     width: Width::Bit,
///     error: ChannelError::SHORT_CIRCUIT,
/// };
/// diagnosis.push(Block::Channel(channel))?;
/// assert_eq!(diagnosis.octets(), [0x42, 0x02, 0x81, 0x83, 0x21]);
/// # Ok::<(), profidrive::profibus::dp::ext_diag::BlockError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ExtDiag {
    octets: [u8; MAX_LEN],
    len: usize,
    ext_diag: bool,
    stat_diag: bool,
    overflow: bool,
}

impl ExtDiag {
    /// Nothing to report. Filed after a fault it tells the master that the fault has gone. Blocks pushed to it are a
    /// mere message: Ext_Diag is not set.
    pub const NONE: Self =
        Self { octets: [0; MAX_LEN], len: 0, ext_diag: false, stat_diag: false, overflow: false };

    /// Blocks that show a fault: Ext_Diag is set.
    pub const fn fault() -> Self {
        Self { ext_diag: true, ..Self::NONE }
    }

    /// The same with Stat_Diag: the slave cannot deliver valid data, the master shall go on reading the diagnosis.
    #[must_use]
    pub const fn with_stat_diag(mut self) -> Self {
        self.stat_diag = true;
        self
    }

    /// Appends a block. One that does not fit any more is left out and sets Ext_Diag_Overflow.
    ///
    /// # Errors
    /// [`BlockError`] if no block on the wire can say this. Nothing is appended then.
    pub fn push(&mut self, block: Block<'_>) -> Result<(), BlockError> {
        match block {
            Block::Device(data) => self.push_sized(DEVICE, data)?,
            Block::Modules(bits) => self.push_sized(IDENTIFIER, bits)?,
            Block::Channel(channel) => self.append(&channel.octets()?, &[]),
            Block::Revision(number) => self.append(&[REVISION | six_bits("revision", number)?], &[]),
        }
        Ok(())
    }

    /// Appends blocks as they are on the wire. One that does not fit any more is left out and sets Ext_Diag_Overflow.
    ///
    /// # Errors
    /// [`BlockError::Cut`] if they are no whole blocks. Nothing is appended then.
    pub fn push_octets(&mut self, octets: &[u8]) -> Result<(), BlockError> {
        let mut all = *self;
        let mut rest = octets;
        while let Some(header) = rest.first() {
            let (block, behind) = match block_len(*header) {
                // A length counts its header, and a block has data.
                0 => (None, rest),
                1 if *header < REVISION => (None, rest),
                len => (rest.get(..len), rest.get(len..).unwrap_or_default()),
            };
            let at = octets.len() - rest.len();
            all.append(block.ok_or(BlockError::Cut { at, header: *header })?, &[]);
            rest = behind;
        }
        *self = all;
        Ok(())
    }

    /// The same behind a device-related block, which shows a fault or not.
    ///
    /// # Errors
    /// [`BlockError::Length`] of the block.
    pub(crate) fn behind(&self, block: &[u8], fault: bool) -> Result<Self, BlockError> {
        let mut all = Self { octets: [0; MAX_LEN], len: 0, ext_diag: self.ext_diag || fault, ..*self };
        all.push(Block::Device(block))?;
        all.push_octets(self.octets())?;
        Ok(all)
    }

    /// The blocks on the wire, 0..=238 octets.
    pub fn octets(&self) -> &[u8] {
        self.octets.get(..self.len).unwrap_or_default()
    }

    /// Ext_Diag: the blocks show a fault.
    pub(crate) const fn ext_diag(&self) -> bool {
        self.ext_diag
    }

    /// Stat_Diag: the slave cannot deliver valid data.
    pub(crate) const fn stat_diag(&self) -> bool {
        self.stat_diag
    }

    /// Ext_Diag_Overflow: a block was left out.
    pub(crate) const fn overflow(&self) -> bool {
        self.overflow
    }

    /// The same with the first blocks that fit in `limit` octets; if some are left out, Ext_Diag_Overflow is set.
    #[must_use]
    pub(crate) fn within(mut self, limit: usize) -> Self {
        let mut kept = 0;
        while let Some(header) = self.octets().get(kept) {
            let behind = kept + block_len(*header);
            if behind > limit {
                self.overflow = true;
                break;
            }
            kept = behind;
        }
        // What is left out must not tell two of these apart.
        for octet in self.octets.iter_mut().skip(kept) {
            *octet = 0;
        }
        self.len = kept;
        self
    }

    fn push_sized(&mut self, kind: u8, data: &[u8]) -> Result<(), BlockError> {
        match u8::try_from(data.len() + 1) {
            Ok(len @ 2..=SIX_BITS) => self.append(&[kind | len], data),
            Ok(_) | Err(_) => return Err(BlockError::Length { got: data.len() }),
        }
        Ok(())
    }

    /// Appends all of it or, if there is no room, nothing.
    fn append(&mut self, head: &[u8], data: &[u8]) {
        let len = self.len + head.len() + data.len();
        let Some(room) = self.octets.get_mut(self.len..len) else {
            self.overflow = true;
            return;
        };
        for (place, octet) in room.iter_mut().zip(head.iter().chain(data)) {
            *place = *octet;
        }
        self.len = len;
    }
}

/// The blocks of Slave_Diag behind its first six octets, each with its header. What is no block ends them.
pub fn blocks(octets: &[u8]) -> impl Iterator<Item = &[u8]> {
    let mut rest = octets;
    core::iter::from_fn(move || {
        let len = Some(block_len(*rest.first()?)).filter(|len| *len != 0)?;
        let (block, behind) = rest.split_at_checked(len)?;
        rest = behind;
        Some(block)
    })
}

/// Octets of the block with this header.
fn block_len(header: u8) -> usize {
    match header {
        // `push_sized` lets no length below 2 in.
        ..CHANNEL => usize::from(header & SIX_BITS),
        CHANNEL..REVISION => CHANNEL_LEN,
        REVISION.. => 1,
    }
}

/// One block of extended diagnosis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Block<'a> {
    /// Device-related: 1..=62 octets whose meaning the GSD gives (`Unit_Diag_Bit`).
    Device(&'a [u8]),
    /// Identifier-related: one bit a module, 1..=62 octets, bit 0 of the first is module 0.
    Modules(&'a [u8]),
    /// Channel-related.
    Channel(Channel),
    /// The revision of the device, 0..=63.
    Revision(u8),
}

/// What is wrong with one channel of a module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Channel {
    /// The module (configuration identifier), 0..=63.
    pub module: u8,
    /// Whether it is an input or an output.
    pub direction: Direction,
    /// The channel of the module, 0..=63.
    pub channel: u8,
    /// How wide the channel is.
    pub width: Width,
    /// What is wrong.
    pub error: ChannelError,
}

impl Channel {
    fn octets(self) -> Result<[u8; CHANNEL_LEN], BlockError> {
        Ok([
            CHANNEL | six_bits("module", self.module)?,
            (self.direction as u8) << 6 | six_bits("channel", self.channel)?,
            (self.width as u8) << 5 | self.error.0,
        ])
    }
}

/// Which way a channel goes, seen from the master.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "panel", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[cfg_attr(all(test, feature = "panel"), derive(utoipa::ToSchema))]
#[repr(u8)]
pub enum Direction {
    /// Slave to master.
    Input = 1,
    /// Master to slave.
    Output = 2,
    /// Both.
    Both = 3,
}

/// How wide a channel is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "panel", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[cfg_attr(all(test, feature = "panel"), derive(utoipa::ToSchema))]
#[repr(u8)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Width {
    Bit = 1,
    TwoBits = 2,
    FourBits = 3,
    Octet = 4,
    Word = 5,
    TwoWords = 6,
}

/// What is wrong with a channel, 1..=31.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChannelError(u8);

impl ChannelError {
    /// Short circuit.
    pub const SHORT_CIRCUIT: Self = Self(1);
    /// Undervoltage.
    pub const UNDERVOLTAGE: Self = Self(2);
    /// Overvoltage.
    pub const OVERVOLTAGE: Self = Self(3);
    /// Overload.
    pub const OVERLOAD: Self = Self(4);
    /// Overtemperature.
    pub const OVERTEMPERATURE: Self = Self(5);
    /// Line break.
    pub const LINE_BREAK: Self = Self(6);
    /// Upper limit exceeded.
    pub const UPPER_LIMIT: Self = Self(7);
    /// Lower limit exceeded.
    pub const LOWER_LIMIT: Self = Self(8);
    /// An error without name.
    pub const ERROR: Self = Self(9);

    /// The error with this number: 1..=9 or, of the manufacturer, 16..=31. `None` for the others, which are reserved.
    pub(crate) const fn numbered(number: u8) -> Option<Self> {
        match number {
            1..=9 => Some(Self(number)),
            0 | 10.. => Self::manufacturer(number),
        }
    }

    /// Its number.
    pub(crate) const fn number(self) -> u8 {
        self.0
    }

    /// What the standard says of it; `None` for those of the manufacturer.
    pub(crate) const fn words(self) -> Option<&'static str> {
        Some(match self {
            Self::SHORT_CIRCUIT => "short circuit",
            Self::UNDERVOLTAGE => "undervoltage",
            Self::OVERVOLTAGE => "overvoltage",
            Self::OVERLOAD => "overload",
            Self::OVERTEMPERATURE => "overtemperature",
            Self::LINE_BREAK => "line break",
            Self::UPPER_LIMIT => "upper limit exceeded",
            Self::LOWER_LIMIT => "lower limit exceeded",
            Self::ERROR => "error",
            Self(_) => return None,
        })
    }

    /// An error of the manufacturer, 16..=31, or `None`.
    pub(crate) const fn manufacturer(number: u8) -> Option<Self> {
        match number {
            16..=31 => Some(Self(number)),
            ..=15 | 32.. => None,
        }
    }
}

/// Why something cannot be said in a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum BlockError {
    /// Too little or too much for one block.
    #[error("a diagnosis block has {got} data octets, expected 1..62")]
    Length {
        /// Data octets.
        got: usize,
    },
    /// A number that needs more than six bits.
    #[error("{what} number {got} in a diagnosis block, expected 0..63")]
    Number {
        /// Which number.
        what: &'static str,
        /// Its value.
        got: u8,
    },
    /// Octets that are no whole block.
    #[error("octet {at} of the diagnosis, 0x{header:02X}, begins no whole block")]
    Cut {
        /// Its header, from 0.
        at: usize,
        /// The header.
        header: u8,
    },
}

const fn six_bits(what: &'static str, got: u8) -> Result<u8, BlockError> {
    if got <= SIX_BITS { Ok(got) } else { Err(BlockError::Number { what, got }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_split_until_one_is_cut_or_none() {
        let split = |octets: &[u8]| blocks(octets).map(<[u8]>::len).collect::<heapless::Vec<_, 8>>();
        assert_eq!(split(&[4, 2, 1, 1, 0x42, 7, 0x81, 2, 3, 0xC5]), [4, 2, 3, 1]);
        assert_eq!(split(&[4, 2, 1]), [0_usize; 0]);
        assert_eq!(split(&[0x42, 7, 0, 1]), [2]);
    }

    const CHANNEL_63: Channel = Channel {
        module: 63,
        direction: Direction::Both,
        channel: 63,
        width: Width::TwoWords,
        error: ChannelError::ERROR,
    };

    #[test]
    fn octets_are_taken_as_whole_blocks_only() {
        let mut diagnosis = ExtDiag::fault();
        let blocks = [0x03, 0xAA, 0xBB, 0x42, 0x01, 0x81, 0x43, 0xB0, 0xC5];
        diagnosis.push_octets(&blocks).unwrap();
        assert_eq!(diagnosis.octets(), blocks);
        for (octets, at) in [(&[0x00][..], 0), (&[0x41], 0), (&[0xC0, 0x03, 0xAA], 1), (&[0x81, 0x43], 0)] {
            let cut = Err(BlockError::Cut { at, header: octets[at] });
            assert_eq!(diagnosis.push_octets(octets), cut);
            assert_eq!(diagnosis.octets(), blocks);
        }
        let many = [0xC0; 300];
        diagnosis.push_octets(&many).unwrap();
        assert_eq!((diagnosis.octets().len(), diagnosis.overflow()), (MAX_LEN, true));
    }

    #[test]
    fn d_07_every_type_of_block_has_its_header() {
        let one = |block| {
            let mut diagnosis = ExtDiag::fault();
            diagnosis.push(block).unwrap();
            diagnosis.octets().to_vec()
        };
        assert_eq!(one(Block::Device(&[0xAA])), [0x02, 0xAA]);
        assert_eq!(one(Block::Device(&[0; 62]))[..1], [0x3F]);
        assert_eq!(one(Block::Modules(&[0x05, 0x80])), [0x43, 0x05, 0x80]);
        assert_eq!(one(Block::Modules(&[0; 62]))[..1], [0x7F]);
        assert_eq!(one(Block::Channel(CHANNEL_63)), [0xBF, 0xFF, 0xC9]);
        assert_eq!(one(Block::Revision(5)), [0xC5]);
        for (direction, octet) in
            [(Direction::Input, 0x41), (Direction::Output, 0x81), (Direction::Both, 0xC1)]
        {
            let channel = Channel { module: 0, direction, channel: 1, ..CHANNEL_63 };
            assert_eq!(one(Block::Channel(channel)), [0x80, octet, 0xC9]);
        }
        for (width, octet) in [
            (Width::Bit, 0x21),
            (Width::TwoBits, 0x41),
            (Width::FourBits, 0x61),
            (Width::Octet, 0x81),
            (Width::Word, 0xA1),
            (Width::TwoWords, 0xC1),
        ] {
            let channel = Channel { width, error: ChannelError::SHORT_CIRCUIT, ..CHANNEL_63 };
            assert_eq!(one(Block::Channel(channel))[2], octet);
        }
        let errors = [
            ChannelError::SHORT_CIRCUIT,
            ChannelError::UNDERVOLTAGE,
            ChannelError::OVERVOLTAGE,
            ChannelError::OVERLOAD,
            ChannelError::OVERTEMPERATURE,
            ChannelError::LINE_BREAK,
            ChannelError::UPPER_LIMIT,
            ChannelError::LOWER_LIMIT,
            ChannelError::ERROR,
        ];
        for (number, error) in (1..).zip(errors) {
            assert_eq!(one(Block::Channel(Channel { error, ..CHANNEL_63 }))[2], 0xC0 | number);
        }
        for number in 0..=255 {
            let expected = (16..32).contains(&number).then_some(ChannelError(number));
            assert_eq!(ChannelError::manufacturer(number), expected);
        }
    }

    #[test]
    fn what_no_block_can_say_is_refused_and_changes_nothing() {
        let mut diagnosis = ExtDiag::fault();
        diagnosis.push(Block::Revision(63)).unwrap();
        let before = diagnosis;
        for (block, error) in [
            (Block::Device(&[]), BlockError::Length { got: 0 }),
            (Block::Device(&[0; 63]), BlockError::Length { got: 63 }),
            (Block::Modules(&[0; 300]), BlockError::Length { got: 300 }),
            (Block::Revision(64), BlockError::Number { what: "revision", got: 64 }),
            (
                Block::Channel(Channel { module: 64, ..CHANNEL_63 }),
                BlockError::Number { what: "module", got: 64 },
            ),
            (
                Block::Channel(Channel { channel: 255, ..CHANNEL_63 }),
                BlockError::Number { what: "channel", got: 255 },
            ),
        ] {
            assert_eq!(diagnosis.push(block), Err(error));
        }
        assert_eq!(diagnosis, before);
    }

    #[test]
    fn d_07_238_octets_fit_and_a_block_too_many_is_left_out_whole() {
        let mut diagnosis = ExtDiag::fault();
        for _ in 0..3 {
            diagnosis.push(Block::Device(&[0x5A; 62])).unwrap();
        }
        diagnosis.push(Block::Device(&[0x5A; 48])).unwrap();
        assert_eq!((diagnosis.octets().len(), diagnosis.overflow()), (238, false));
        diagnosis.push(Block::Revision(1)).unwrap();
        assert_eq!((diagnosis.octets().len(), diagnosis.overflow()), (238, true));
    }

    #[test]
    fn d_07_a_smaller_limit_keeps_whole_blocks() {
        let mut whole = ExtDiag::NONE;
        whole.push(Block::Modules(&[1])).unwrap();
        whole.push(Block::Channel(CHANNEL_63)).unwrap();
        whole.push(Block::Revision(9)).unwrap();
        whole.push(Block::Device(&[7, 7])).unwrap();
        for (limit, kept) in [(0, 0), (1, 0), (2, 2), (4, 2), (5, 5), (6, 6), (8, 6), (9, 9), (238, 9)] {
            let cut = whole.within(limit);
            assert_eq!(cut.octets(), &whole.octets()[..kept], "{limit}");
            assert_eq!(cut.overflow(), kept < 9, "{limit}");
        }
        assert_eq!(whole.within(9), whole);
        assert!(!ExtDiag::NONE.within(0).overflow());
    }
}
