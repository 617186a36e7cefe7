//! Decoding and encoding of single telegrams, without state and without copying.
//!
//! Decoding is strict: every octet that the format fixes is compared (`dp-v0.md` 2, F-03..F-05). It never panics,
//! whatever the octets. The frames are drawn in the [layer guide](super).
//!
//! Every octet of a bus passes here, so the frame is taken apart with slice patterns: `nom`, which reads the user
//! data one layer up, tripled the time of a short telegram. `docs/performance.md` has the numbers.

use thiserror::Error;

use super::address::{Address, Sap};
use super::fcs::{copy_summed, fcs_of};
use super::function_code::FunctionCode;

/// The longest telegram: SD2 with LE = 249.
pub const MAX_TELEGRAM_LEN: usize = 255;

/// The longest data unit of one telegram, extension octets included.
pub const MAX_PDU_LEN: usize = 246;

const SD1: u8 = 0x10;
const SD2: u8 = 0x68;
const SD3: u8 = 0xA2;
const SD4: u8 = 0xDC;
const SC: u8 = 0xE5;
const ED: u8 = 0x16;

/// LE counts DA, SA and FC too.
const HEADER_LEN: usize = 3;
const MIN_LE: u8 = 4;
const MAX_LE: u8 = 249;
const SD1_LEN: usize = 6;
const SD3_LEN: usize = 14;
const SD3_PDU_LEN: usize = 8;
const SD4_LEN: usize = 3;
/// Octets of an SD2 telegram up to the second start delimiter.
const SD2_HEAD_LEN: usize = 4;
/// Octets of an SD2 telegram around those that LE counts.
const SD2_OVERHEAD: usize = 6;
/// Bit 7 of DA and SA: an extension octet follows.
const EXTENSION: u8 = 0x80;
/// The highest address of one station.
const MAX_STATION: u8 = Address::BROADCAST.number() - 1;

/// What the front of a buffer is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decoded<'a> {
    /// A telegram may be there once more octets have come.
    Incomplete,
    /// A whole and correct telegram in the first `len` octets.
    Telegram {
        /// The telegram, borrowing its data from the buffer.
        telegram: Telegram<'a>,
        /// How many octets it takes, 1..=255.
        len: usize,
    },
    /// No telegram starts here.
    Invalid {
        /// Why not.
        error: FrameError,
        /// How many octets to drop before looking again, at least 1 and never more than there are. An SD2 or
        /// SD3 whose start and end fit and whose checksum or extension octets do not is dropped whole, so that
        /// nothing inside its data can pose as a telegram.
        skip: usize,
    },
}

/// Looks at the front of `input`.
///
/// A telegram is refused as early as its first wrong octet. Panics: never.
///
/// Not inlined: the result is then written where the caller wants it. Inlined, it is written field by field and copied
/// in blocks right behind, which stalls a processor when the caller moves it.
#[must_use]
#[inline(never)]
pub fn decode(input: &[u8]) -> Decoded<'_> {
    // The token first: then one comparison with the length is enough for it, before its octets are read.
    match input.first_chunk::<SD4_LEN>() {
        Some([SD4, addresses @ ..]) => {
            if let Some([da, sa]) = Address::stations(*addresses) {
                return Decoded::Telegram { telegram: Telegram::Token { da, sa }, len: SD4_LEN };
            }
        }
        Some(_) => {}
        None => unlikely(),
    }
    match *input {
        [SC, ..] => Decoded::Telegram { telegram: Telegram::ShortAcknowledge, len: 1 },
        [..] => with_function_code(input),
    }
}

/// Where this is called the compiler puts the code behind all other: a token is then decoded without a jump.
#[cold]
#[inline]
const fn unlikely() {}

/// One telegram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Telegram<'a> {
    /// SD1, SD2 or SD3: a request or a response.
    Data(DataTelegram<'a>),
    /// SD4: `sa` passes the token to `da`.
    Token {
        /// Who gets the token.
        da: Address,
        /// Who had it.
        sa: Address,
    },
    /// SC.
    ShortAcknowledge,
}

impl Telegram<'_> {
    /// Writes the telegram to the front of `buf` and returns its octets.
    ///
    /// # Errors
    /// As [`DataTelegram::encode`]. `buf` is then unchanged.
    #[inline(always)]
    pub fn encode<'b>(&self, buf: &'b mut [u8]) -> Result<&'b [u8], EncodeError> {
        match self {
            Self::Data(data) => data.encode(buf),
            Self::Token { da, sa } => {
                let out = room(buf, SD4_LEN)?;
                out.copy_from_slice(&[SD4, da.number(), sa.number()]);
                Ok(out)
            }
            Self::ShortAcknowledge => {
                let out = room(buf, 1)?;
                out.copy_from_slice(&[SC]);
                Ok(out)
            }
        }
    }

    /// Appends the telegram to `buf`.
    ///
    /// # Errors
    /// As [`DataTelegram::encode`], a `buf` without room for it included. `buf` is then unchanged.
    #[cfg(feature = "alloc")]
    pub fn put(&self, buf: &mut impl bytes::BufMut) -> Result<(), EncodeError> {
        let mut octets = [0; MAX_TELEGRAM_LEN];
        let octets = self.encode(&mut octets)?;
        if buf.remaining_mut() < octets.len() {
            return Err(EncodeError::BufferTooSmall { needed: octets.len(), got: buf.remaining_mut() });
        }
        buf.put_slice(octets);
        Ok(())
    }
}

/// Which of the three formats with a function code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// No data.
    Sd1,
    /// 1..=246 data octets.
    Sd2,
    /// 8 data octets.
    Sd3,
}

impl Format {
    /// Least and most octets of the PDU.
    const fn pdu_lens(self) -> (usize, usize) {
        match self {
            Self::Sd1 => (0, 0),
            Self::Sd2 => (1, MAX_PDU_LEN),
            Self::Sd3 => (SD3_PDU_LEN, SD3_PDU_LEN),
        }
    }
}

/// A telegram with a function code: SD1, SD2 or SD3.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DataTelegram<'a> {
    /// How it is framed.
    pub format: Format,
    /// To whom.
    pub da: Address,
    /// From whom.
    pub sa: Address,
    /// Destination SAP, announced by bit 7 of DA.
    pub dsap: Option<Sap>,
    /// Source SAP, announced by bit 7 of SA.
    pub ssap: Option<Sap>,
    /// What it asks or answers.
    pub fc: FunctionCode,
    /// The user data behind the extension octets, 0..=246 octets.
    pub data: &'a [u8],
}

impl DataTelegram<'_> {
    /// The customary format of this telegram: SD1 without data and SAPs, else SD2.
    ///
    /// A slave answers eight octets with SD2 as well, as real devices do (`dp-v0.md` 2 rule 4).
    pub const fn customary_format(dsap: Option<Sap>, ssap: Option<Sap>, data: &[u8]) -> Format {
        if dsap.is_none() && ssap.is_none() && data.is_empty() { Format::Sd1 } else { Format::Sd2 }
    }

    /// Writes the telegram to the front of `buf` and returns its octets.
    ///
    /// # Errors
    /// [`EncodeError`] if the data do not fit the format or the telegram does not fit `buf`, which is then
    /// unchanged. Panics: never.
    #[inline(always)]
    pub fn encode<'b>(&self, buf: &'b mut [u8]) -> Result<&'b [u8], EncodeError> {
        let pdu_len = self.pdu_len();
        match (self.format, u8::try_from(pdu_len + HEADER_LEN)) {
            (Format::Sd1, _) if pdu_len == 0 => {
                let out = room(buf, SD1_LEN)?;
                let (da, sa, fc) = (self.da.number(), self.sa.number(), self.fc.octet());
                out.copy_from_slice(&[SD1, da, sa, fc, da.wrapping_add(sa).wrapping_add(fc), ED]);
                Ok(out)
            }
            (Format::Sd2, Ok(le @ MIN_LE..=MAX_LE)) => {
                let out = room(buf, usize::from(le) + SD2_OVERHEAD)?;
                self.encode_counted(start(out, [SD2, le, le, SD2]));
                Ok(out)
            }
            (Format::Sd3, _) if pdu_len == SD3_PDU_LEN => {
                let out = room(buf, SD3_LEN)?;
                self.encode_counted(start(out, [SD3]));
                Ok(out)
            }
            (format @ (Format::Sd1 | Format::Sd2 | Format::Sd3), _) => {
                Err(EncodeError::PduLength { format, expected: format.pdu_lens(), got: pdu_len })
            }
        }
    }

    /// Writes everything from DA to ED to `out`, which is just as long. The checksum is taken of what is written,
    /// not of what was: reading octets back in blocks right after writing them one by one stalls a processor.
    #[inline(never)]
    fn encode_counted(&self, out: &mut [u8]) {
        let Some((header, pdu)) = out.split_first_chunk_mut() else { return };
        let extension = |sap: Option<Sap>| if sap.is_some() { EXTENSION } else { 0 };
        let da = self.da.number() | extension(self.dsap);
        let sa = self.sa.number() | extension(self.ssap);
        let fc = self.fc.octet();
        *header = [da, sa, fc];
        let mut fcs = da.wrapping_add(sa).wrapping_add(fc);
        let mut rest = pdu;
        for sap in [self.dsap, self.ssap].into_iter().flatten() {
            let Some((first, behind)) = rest.split_first_mut() else { return };
            *first = sap.number();
            fcs = fcs.wrapping_add(sap.number());
            rest = behind;
        }
        if let Some((data, end)) = rest.split_last_chunk_mut::<2>() {
            *end = [fcs.wrapping_add(copy_summed(data, self.data)), ED];
        }
    }

    #[inline]
    fn pdu_len(&self) -> usize {
        usize::from(self.dsap.is_some()) + usize::from(self.ssap.is_some()) + self.data.len()
    }
}

/// Why no telegram starts here.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum FrameError {
    /// The first octet starts no telegram.
    #[error("octet 0x{got:02X} starts no telegram, expected 10, 68, A2, DC or E5")]
    StartDelimiter {
        /// The octet found.
        got: u8,
    },
    /// LE is outside 4..=249.
    #[error("length octet LE is {got}, expected 4..249")]
    Length {
        /// The value found.
        got: u8,
    },
    /// LEr differs from LE.
    #[error("repeated length octet LEr is {got}, expected {expected} as in LE")]
    RepeatedLength {
        /// LE.
        expected: u8,
        /// LEr.
        got: u8,
    },
    /// The fourth octet of an SD2 telegram is not 68 again.
    #[error("second start delimiter is 0x{got:02X}, expected 0x68")]
    SecondStartDelimiter {
        /// The octet found.
        got: u8,
    },
    /// The last octet is not 16.
    #[error("end delimiter is 0x{got:02X}, expected 0x16")]
    EndDelimiter {
        /// The octet found.
        got: u8,
    },
    /// The frame check sequence is wrong.
    #[error("frame check sequence is 0x{got:02X}, expected 0x{expected:02X}")]
    Checksum {
        /// The sum of the octets from DA to the last data octet.
        expected: u8,
        /// The octet found.
        got: u8,
    },
    /// DA or SA announces an extension octet and the data are too short for it.
    #[error("an extension octet is announced by bit 7 of DA or SA and missing")]
    ExtensionMissing,
    /// An extension octet that is no plain SAP: bits 7 and 6 must be 0 in DP.
    #[error("extension octet 0x{got:02X} is no service access point, expected 0x00..0x3F")]
    Extension {
        /// The octet found.
        got: u8,
    },
    /// A token telegram with bit 7 or address 127 in DA or SA.
    #[error("token address octet is 0x{got:02X}, expected 0x00..0x7E")]
    TokenAddress {
        /// The octet found.
        got: u8,
    },
    /// The line fell silent within a telegram.
    #[error("telegram broken off after {octets} octets")]
    BrokenOff {
        /// How many octets had come.
        octets: u8,
    },
    /// An octet came with wrong parity or without its stop bit. Only a line that sees bits can tell.
    #[error("an octet had a wrong parity or stop bit")]
    Parity,
}

/// Why a telegram cannot be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum EncodeError {
    /// The buffer is shorter than the telegram.
    #[error("the telegram needs {needed} octets, the buffer has {got}")]
    BufferTooSmall {
        /// Octets of the telegram.
        needed: usize,
        /// Octets of the buffer.
        got: usize,
    },
    /// The data with their extension octets do not fit the format.
    #[error("{format:?} carries {}..{} data octets, got {got}", expected.0, expected.1)]
    PduLength {
        /// The format asked for.
        format: Format,
        /// Least and most octets it carries.
        expected: (usize, usize),
        /// Octets to carry.
        got: usize,
    },
}

/// SD1, SD2 and SD3. Not inlined: a caller gains nothing but a copy of all this.
#[inline(never)]
fn with_function_code(input: &[u8]) -> Decoded<'_> {
    match *input {
        [SD2, ..] => sd2(input),
        [SD1, ..] => fixed::<SD1_LEN>(input, Format::Sd1, 1),
        [SD3, ..] => fixed::<SD3_LEN>(input, Format::Sd3, SD3_LEN),
        [..] => refused(input),
    }
}

/// SD2. All that a good telegram needs and nothing else: what is wrong with a bad one is found out apart.
#[inline(always)]
fn sd2(input: &[u8]) -> Decoded<'_> {
    let (le, behind) = match input {
        [_, le @ MIN_LE..=MAX_LE, ler, SD2, behind @ ..] if ler == le => (usize::from(*le), behind),
        [..] => return refused(input),
    };
    let Some((counted, &[fcs, ed, ..])) = behind.split_at_checked(le) else {
        return Decoded::Incomplete;
    };
    if ed != ED {
        return refused(input);
    }
    // Four octets of head and the end agree on its bounds, so that a damaged one can be dropped whole.
    let len = le + SD2_OVERHEAD;
    enclosed(counted, fcs, Format::Sd2, len, len)
}

/// SD1 and SD3: the format says the length. A damaged one is followed by the next look `skip` octets behind.
#[inline(always)]
fn fixed<const LEN: usize>(input: &[u8], format: Format, skip: usize) -> Decoded<'_> {
    match input.first_chunk::<LEN>().and_then(|telegram| telegram.split_last_chunk()) {
        Some(([_, counted @ ..], &[fcs, ED])) => enclosed(counted, fcs, format, LEN, skip),
        Some(_) | None => refused(input),
    }
}

/// The octets that the checksum `fcs` covers, of a telegram of `len` octets.
#[inline(always)]
fn enclosed(counted: &[u8], fcs: u8, format: Format, len: usize, skip: usize) -> Decoded<'_> {
    let expected = fcs_of(counted);
    if fcs != expected {
        return Decoded::Invalid { error: FrameError::Checksum { expected, got: fcs }, skip };
    }
    match *counted {
        [da @ ..EXTENSION, sa @ ..EXTENSION, fc, ref data @ ..] => {
            let (da, sa, fc) =
                (Address::from_octet(da), Address::from_octet(sa), FunctionCode::from_octet(fc));
            let telegram = DataTelegram { format, da, sa, dsap: None, ssap: None, fc, data };
            Decoded::Telegram { telegram: Telegram::Data(telegram), len }
        }
        [..] => extended(counted, format, len, skip),
    }
}

/// As [`enclosed`], with the SAPs that bit 7 of DA and SA announce, DA's first, before the data.
#[inline(always)]
fn extended(counted: &[u8], format: Format, len: usize, skip: usize) -> Decoded<'_> {
    let invalid = |error| Decoded::Invalid { error, skip };
    let (da, sa, fc, dsap, ssap, data) = match *counted {
        [da @ EXTENSION..=u8::MAX, sa @ EXTENSION..=u8::MAX, fc, dsap, ssap, ref data @ ..] => {
            (da, sa, fc, Some(dsap), Some(ssap), data)
        }
        [da @ EXTENSION..=u8::MAX, sa @ ..EXTENSION, fc, dsap, ref data @ ..] => {
            (da, sa, fc, Some(dsap), None, data)
        }
        [da @ ..EXTENSION, sa @ EXTENSION..=u8::MAX, fc, ssap, ref data @ ..] => {
            (da, sa, fc, None, Some(ssap), data)
        }
        [..] => return invalid(FrameError::ExtensionMissing),
    };
    // An extension octet: b7 = another one follows, b6 = segment address, b5..b0 = SAP. DP uses plain SAPs only.
    let is_no_sap = |octet: &u8| Sap::new(*octet).is_none();
    if let Some(got) = dsap.filter(is_no_sap).or(ssap.filter(is_no_sap)) {
        return invalid(FrameError::Extension { got });
    }
    let (da, sa, fc) = (Address::from_octet(da), Address::from_octet(sa), FunctionCode::from_octet(fc));
    let (dsap, ssap) = (dsap.and_then(Sap::new), ssap.and_then(Sap::new));
    Decoded::Telegram { telegram: Telegram::Data(DataTelegram { format, da, sa, dsap, ssap, fc, data }), len }
}

/// What is wrong or missing at the front of octets in which no whole telegram was found: the first octet that is
/// wrong, as soon as it is there.
#[cold]
#[inline(never)]
fn refused(input: &[u8]) -> Decoded<'_> {
    let error = match *input {
        [SD2, le, ..] if !(MIN_LE..=MAX_LE).contains(&le) => FrameError::Length { got: le },
        [SD2, le, ler, ..] if ler != le => FrameError::RepeatedLength { expected: le, got: ler },
        [SD2, _, _, got, ..] if got != SD2 => FrameError::SecondStartDelimiter { got },
        [SD4, got, ..] | [SD4, _, got, ..] if got > MAX_STATION => FrameError::TokenAddress { got },
        [SD1, _, _, _, _, got, ..] => FrameError::EndDelimiter { got },
        [SD3, _, _, _, _, _, _, _, _, _, _, _, _, got, ..] => FrameError::EndDelimiter { got },
        [SD2, le, ..] => match input.get(usize::from(le) + SD2_OVERHEAD - 1) {
            Some(got) => FrameError::EndDelimiter { got: *got },
            None => return Decoded::Incomplete,
        },
        [SD1 | SD2 | SD3 | SD4 | SC, ..] | [] => return Decoded::Incomplete,
        [got, ..] => FrameError::StartDelimiter { got },
    };
    Decoded::Invalid { error, skip: 1 }
}

/// How many octets belong to what the front of `octets` begins, as far as its start says so; 1 where no start
/// delimiter is.
pub(super) fn extent(octets: &[u8]) -> usize {
    match *octets {
        [SD1, ..] => SD1_LEN,
        [SD2, le @ MIN_LE..=MAX_LE, ler, SD2, ..] if ler == le => usize::from(le) + SD2_OVERHEAD,
        [SD2, ..] => SD2_HEAD_LEN,
        [SD3, ..] => SD3_LEN,
        [SD4, ..] => SD4_LEN,
        [..] => 1,
    }
}

#[inline]
fn room(buf: &mut [u8], needed: usize) -> Result<&mut [u8], EncodeError> {
    let got = buf.len();
    buf.get_mut(..needed).ok_or(EncodeError::BufferTooSmall { needed, got })
}

/// Writes what comes before DA and returns the rest.
#[inline(always)]
fn start<const N: usize>(out: &mut [u8], head: [u8; N]) -> &mut [u8] {
    match out.split_first_chunk_mut() {
        Some((start, rest)) => {
            *start = head;
            rest
        }
        None => &mut [],
    }
}

#[cfg(test)]
pub(crate) mod tests;
