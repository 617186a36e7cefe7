//! Decoding and encoding of single telegrams, without state and without copying.
//!
//! Decoding is strict: every octet that the format fixes is compared (`dp-v0.md` 2, F-03..F-05). It never panics,
//! whatever the octets. The frames are drawn in the [layer guide](super).
//!
//! Every octet of a bus passes here, so the frame is taken apart with slice patterns: `nom`, which reads the user
//! data one layer up, tripled the time of a short telegram.

use thiserror::Error;

use super::address::{Address, Sap};
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
/// Octets of an SD2 telegram before DA.
const SD2_HEAD_LEN: usize = 4;
/// Octets of an SD2 telegram around those that LE counts.
const SD2_OVERHEAD: usize = 6;
/// Bit 7 of DA and SA: an extension octet follows.
const EXTENSION: u8 = 0x80;

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
        /// How many octets to drop before looking again, at least 1 and never more than there are. A telegram
        /// whose start and end fit and whose checksum does not is dropped whole, so that nothing inside its
        /// data can pose as a telegram.
        skip: usize,
    },
}

/// Looks at the front of `input`.
///
/// A telegram is refused as early as its first wrong octet. Panics: never.
#[must_use]
#[inline]
pub fn decode(input: &[u8]) -> Decoded<'_> {
    match *input {
        [SD2, ..] => sd2(input),
        [SD1, ..] => fixed::<SD1_LEN>(input, Format::Sd1),
        [SC, ..] => Decoded::Telegram { telegram: Telegram::ShortAcknowledge, len: 1 },
        [SD3, ..] => fixed::<SD3_LEN>(input, Format::Sd3),
        [SD4, ref rest @ ..] => sd4(rest),
        [got, ..] => refuse(FrameError::StartDelimiter { got }),
        [] => Decoded::Incomplete,
    }
}

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
    pub fn encode<'b>(&self, buf: &'b mut [u8]) -> Result<&'b [u8], EncodeError> {
        let pdu_len = self.pdu_len();
        let wrong = |expected| EncodeError::PduLength { format: self.format, expected, got: pdu_len };
        let out = match self.format {
            Format::Sd1 => {
                if pdu_len != 0 {
                    return Err(wrong((0, 0)));
                }
                let out = room(buf, SD1_LEN)?;
                self.encode_counted(start(out, [SD1]));
                out
            }
            Format::Sd2 => {
                let le = match u8::try_from(pdu_len + HEADER_LEN) {
                    Ok(le) if (MIN_LE..=MAX_LE).contains(&le) => le,
                    Ok(_) | Err(_) => return Err(wrong((1, MAX_PDU_LEN))),
                };
                let out = room(buf, usize::from(le) + SD2_OVERHEAD)?;
                self.encode_counted(start(out, [SD2, le, le, SD2]));
                out
            }
            Format::Sd3 => {
                if pdu_len != SD3_PDU_LEN {
                    return Err(wrong((SD3_PDU_LEN, SD3_PDU_LEN)));
                }
                let out = room(buf, SD3_LEN)?;
                self.encode_counted(start(out, [SD3]));
                out
            }
        };
        Ok(out)
    }

    /// Writes everything from DA to ED to `out`, which is just as long. The checksum is taken of what is written,
    /// not of what was: reading octets back in eights right after writing them one by one stalls a processor.
    #[inline(always)]
    fn encode_counted(&self, out: &mut [u8]) {
        let Some((header, pdu)) = out.split_first_chunk_mut() else { return };
        let extension = |sap: Option<Sap>| if sap.is_some() { EXTENSION } else { 0 };
        let da = self.da.number() | extension(self.dsap);
        let sa = self.sa.number() | extension(self.ssap);
        let fc = self.fc.octet();
        *header = [da, sa, fc];
        let (saps, rest) = match (self.dsap, self.ssap, pdu) {
            (Some(dsap), Some(ssap), [first, second, rest @ ..]) => {
                (*first, *second) = (dsap.number(), ssap.number());
                (dsap.number().wrapping_add(ssap.number()), rest)
            }
            (Some(sap), None, [first, rest @ ..]) | (None, Some(sap), [first, rest @ ..]) => {
                *first = sap.number();
                (sap.number(), rest)
            }
            (_, _, rest) => (0, rest),
        };
        if let Some((data, end)) = rest.split_last_chunk_mut::<2>() {
            copy(data, self.data);
            let header = da.wrapping_add(sa).wrapping_add(fc).wrapping_add(saps);
            *end = [checksum(self.data, 0).wrapping_add(header), ED];
        }
    }

    fn pdu_len(&self) -> usize {
        usize::from(self.dsap.is_some()) + usize::from(self.ssap.is_some()) + self.data.len()
    }
}

/// Why no telegram starts here.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
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
}

/// Why a telegram cannot be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
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

/// SD2: each octet of the head is judged as soon as it is there.
#[inline]
fn sd2(input: &[u8]) -> Decoded<'_> {
    let le = match *input {
        [_, le, ler, SD2, ..] if le == ler && (MIN_LE..=MAX_LE).contains(&le) => usize::from(le),
        [_, le, ..] if !(MIN_LE..=MAX_LE).contains(&le) => return refuse(FrameError::Length { got: le }),
        [_, le, ler, ..] if ler != le => {
            return refuse(FrameError::RepeatedLength { expected: le, got: ler });
        }
        [_, _, _, got, ..] => return refuse(FrameError::SecondStartDelimiter { got }),
        [] | [_] | [_, _] | [_, _, _] => return Decoded::Incomplete,
    };
    let Some((frame, &[fcs, ed, ..])) = input.split_at_checked(SD2_HEAD_LEN + le) else {
        return Decoded::Incomplete;
    };
    if ed != ED {
        return refuse(FrameError::EndDelimiter { got: ed });
    }
    // Four octets of head and the end agree on its bounds, so that a damaged one can be dropped whole.
    let len = le + SD2_OVERHEAD;
    enclosed(frame, SD2_HEAD_LEN, fcs, Format::Sd2, len, len)
}

/// SD1 and SD3: the format says the length.
#[inline]
fn fixed<const LEN: usize>(input: &[u8], format: Format) -> Decoded<'_> {
    let Some((frame, &[fcs, ed])) = input.first_chunk::<LEN>().and_then(|frame| frame.split_last_chunk())
    else {
        return Decoded::Incomplete;
    };
    if ed != ED {
        return refuse(FrameError::EndDelimiter { got: ed });
    }
    enclosed(frame, 1, fcs, format, LEN, 1)
}

#[inline]
fn sd4(input: &[u8]) -> Decoded<'_> {
    let bad = |octet: u8| octet >= Address::BROADCAST.number();
    match *input {
        [got, ..] | [_, got, ..] if bad(got) => refuse(FrameError::TokenAddress { got }),
        [da, sa, ..] => Decoded::Telegram {
            telegram: Telegram::Token { da: Address::from_octet(da), sa: Address::from_octet(sa) },
            len: SD4_LEN,
        },
        [] | [_] => Decoded::Incomplete,
    }
}

/// The octets up to the last data octet of a telegram of `len` octets, `head` of which come before DA. Its parts
/// are written straight into the result, once: inlined, for the copies in between cost more than the checks.
#[inline(always)]
fn enclosed(frame: &[u8], head: usize, fcs: u8, format: Format, len: usize, skip: usize) -> Decoded<'_> {
    let expected = checksum(frame, head);
    if fcs != expected {
        return Decoded::Invalid { error: FrameError::Checksum { expected, got: fcs }, skip };
    }
    let Some(&[da, sa, fc, ref data @ ..]) = frame.get(head..) else {
        // Too short for its header, which LE and the formats rule out.
        return Decoded::Invalid { error: FrameError::ExtensionMissing, skip };
    };
    let (dsap, ssap, data) = match extensions(da, sa, data) {
        Ok(extensions) => extensions,
        Err(error) => return Decoded::Invalid { error, skip },
    };
    let (da, sa, fc) = (Address::from_octet(da), Address::from_octet(sa), FunctionCode::from_octet(fc));
    Decoded::Telegram { telegram: Telegram::Data(DataTelegram { format, da, sa, dsap, ssap, fc, data }), len }
}

/// DSAP, SSAP and the data behind them.
type Extensions<'a> = (Option<Sap>, Option<Sap>, &'a [u8]);

/// The SAPs that bit 7 of DA and SA announce, DA's first, and the data behind them.
#[inline(always)]
fn extensions(da: u8, sa: u8, data: &[u8]) -> Result<Extensions<'_>, FrameError> {
    match (da & EXTENSION != 0, sa & EXTENSION != 0, data) {
        (false, false, data) => Ok((None, None, data)),
        (true, true, &[dsap, ssap, ref data @ ..]) => Ok((Some(sap(dsap)?), Some(sap(ssap)?), data)),
        (true, false, &[dsap, ref data @ ..]) => Ok((Some(sap(dsap)?), None, data)),
        (false, true, &[ssap, ref data @ ..]) => Ok((None, Some(sap(ssap)?), data)),
        (true, true, [] | [_]) | (true, false, []) | (false, true, []) => Err(FrameError::ExtensionMissing),
    }
}

/// An extension octet: b7 = another one follows, b6 = segment address, b5..b0 = SAP. DP uses plain SAPs only.
#[inline(always)]
fn sap(octet: u8) -> Result<Sap, FrameError> {
    Sap::new(octet).ok_or(FrameError::Extension { got: octet })
}

/// Refused, to be looked at again behind the first octet.
#[inline]
const fn refuse<'a>(error: FrameError) -> Decoded<'a> {
    Decoded::Invalid { error, skip: 1 }
}

/// FCS: the sum modulo 256 of the octets behind `head`, eight of them at a time.
///
/// With four octets of head, as SD2 has, the last eight always exist and the odd ones at the end are what is left
/// of them after a shift; shorter telegrams have a length known when this is compiled.
#[inline(always)]
fn checksum(octets: &[u8], head: usize) -> u8 {
    // Four lanes of 16 bits: 31 times twice 255 is the most a telegram adds to one.
    const LANES: u64 = 0x00FF_00FF_00FF_00FF;
    let lanes_of = |eight: u64| (eight & LANES) + (eight >> 8 & LANES);
    let (eights, odd) = octets.get(head..).unwrap_or_default().as_chunks::<8>();
    let mut lanes = eights.iter().fold(0, |lanes, eight| lanes + lanes_of(u64::from_le_bytes(*eight)));
    lanes += match octets.last_chunk::<8>() {
        Some(last) => lanes_of(u64::from_le_bytes(*last) >> (56 - 8 * odd.len()) >> 8),
        None => odd.iter().map(|octet| u64::from(*octet)).sum(),
    };
    // The product gathers the sum of all lanes in the highest one.
    let [.., sum, _] = lanes.wrapping_mul(0x0001_0001_0001_0001).to_le_bytes();
    sum
}

fn room(buf: &mut [u8], needed: usize) -> Result<&mut [u8], EncodeError> {
    let got = buf.len();
    buf.get_mut(..needed).ok_or(EncodeError::BufferTooSmall { needed, got })
}

/// Copies eight octets at a time, which for telegrams is quicker than to call for a copy of any length. The last
/// eight are copied even where they overlap those before.
#[inline(always)]
fn copy(to: &mut [u8], from: &[u8]) {
    let (eights, _) = from.as_chunks::<8>();
    for (to, from) in to.as_chunks_mut::<8>().0.iter_mut().zip(eights) {
        *to = *from;
    }
    match (to.last_chunk_mut::<8>(), from.last_chunk::<8>()) {
        (Some(to), Some(from)) => *to = *from,
        (_, _) => to.iter_mut().zip(from).for_each(|(to, from)| *to = *from),
    }
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
