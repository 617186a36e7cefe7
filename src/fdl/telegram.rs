//! Decoding and encoding of single telegrams, without state and without copying.
//!
//! Decoding is strict: every octet that the format fixes is compared (`dp-v0.md` 2, F-03..F-05). It never panics,
//! whatever the octets. The frames are drawn in the [layer guide](super).

use nom::Parser;
use nom::bytes::streaming::take;
use nom::combinator::cond;
use nom::error::{ErrorKind, ParseError};
use nom::number::complete::be_u8;
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
pub fn decode(input: &[u8]) -> Decoded<'_> {
    match telegram(input) {
        Ok((rest, telegram)) => Decoded::Telegram { telegram, len: input.len() - rest.len() },
        Err(nom::Err::Incomplete(_)) => Decoded::Incomplete,
        Err(nom::Err::Error(error) | nom::Err::Failure(error)) => {
            Decoded::Invalid { error, skip: skip(input, error) }
        }
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
        let (out, counted) = match self.format {
            Format::Sd1 => {
                if pdu_len != 0 {
                    return Err(wrong((0, 0)));
                }
                let out = room(buf, SD1_LEN)?;
                start(out, SD1);
                (out, 1)
            }
            Format::Sd2 => {
                let le = match u8::try_from(pdu_len + HEADER_LEN) {
                    Ok(le) if (MIN_LE..=MAX_LE).contains(&le) => le,
                    Ok(_) | Err(_) => return Err(wrong((1, MAX_PDU_LEN))),
                };
                let out = room(buf, usize::from(le) + SD2_OVERHEAD)?;
                if let Some(head) = out.first_chunk_mut() {
                    *head = [SD2, le, le, SD2];
                }
                (out, 4)
            }
            Format::Sd3 => {
                if pdu_len != SD3_PDU_LEN {
                    return Err(wrong((SD3_PDU_LEN, SD3_PDU_LEN)));
                }
                let out = room(buf, SD3_LEN)?;
                start(out, SD3);
                (out, 1)
            }
        };
        self.encode_counted(out, counted);
        Ok(out)
    }

    /// Writes everything from DA to ED; `out` is as long as the telegram and DA stands at `start`.
    fn encode_counted(&self, out: &mut [u8], start: usize) {
        let body_len = HEADER_LEN + self.pdu_len();
        let Some((body, end)) = out.get_mut(start..).and_then(|out| out.split_at_mut_checked(body_len))
        else {
            return;
        };
        let extension = |sap: Option<Sap>| if sap.is_some() { EXTENSION } else { 0 };
        if let Some((header, pdu)) = body.split_first_chunk_mut() {
            *header = [
                self.da.number() | extension(self.dsap),
                self.sa.number() | extension(self.ssap),
                self.fc.octet(),
            ];
            let mut room = pdu.iter_mut();
            for (sap, octet) in [self.dsap, self.ssap].into_iter().flatten().zip(room.by_ref()) {
                *octet = sap.number();
            }
            room.into_slice().copy_from_slice(self.data);
        }
        let fcs = checksum(body);
        end.copy_from_slice(&[fcs, ED]);
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
    /// An octet came with wrong parity or without its stop bit. Only a line that sees bits can tell.
    #[error("an octet had a wrong parity or stop bit")]
    Parity,
}

impl ParseError<&[u8]> for FrameError {
    /// Within the octets that the frame encloses, only an announced extension octet can be missing.
    fn from_error_kind(_: &[u8], _: ErrorKind) -> Self {
        Self::ExtensionMissing
    }

    fn append(_: &[u8], _: ErrorKind, other: Self) -> Self {
        other
    }
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

type Parsed<'a, T> = nom::IResult<&'a [u8], T, FrameError>;

fn telegram(input: &[u8]) -> Parsed<'_, Telegram<'_>> {
    match input {
        [SD2, rest @ ..] => sd2(rest),
        [SD1, ..] => fixed(input, SD1_LEN, Format::Sd1),
        [SD3, ..] => fixed(input, SD3_LEN, Format::Sd3),
        [SD4, rest @ ..] => sd4(rest),
        [SC, rest @ ..] => Ok((rest, Telegram::ShortAcknowledge)),
        [got, ..] => refuse(FrameError::StartDelimiter { got: *got }),
        [] => Err(nom::Err::Incomplete(nom::Needed::Unknown)),
    }
}

/// SD1 and SD3: the format says the length.
fn fixed(input: &[u8], len: usize, format: Format) -> Parsed<'_, Telegram<'_>> {
    let (rest, frame) = take(len)(input)?;
    enclosed(frame.get(1..).unwrap_or_default(), format).map(|telegram| (rest, telegram))
}

/// SD2 behind its first octet. Each octet of the head is judged as soon as it is there.
fn sd2(input: &[u8]) -> Parsed<'_, Telegram<'_>> {
    let (le, rest) = match *input {
        [le, ..] if !(MIN_LE..=MAX_LE).contains(&le) => return refuse(FrameError::Length { got: le }),
        [le, ler, ..] if ler != le => {
            return refuse(FrameError::RepeatedLength { expected: le, got: ler });
        }
        [_, _, sd, ..] if sd != SD2 => return refuse(FrameError::SecondStartDelimiter { got: sd }),
        [le, _, _, ref rest @ ..] => (le, rest),
        [] | [_] | [_, _] => return Err(nom::Err::Incomplete(nom::Needed::Unknown)),
    };
    let (rest, body) = take(usize::from(le) + 2)(rest)?;
    enclosed(body, Format::Sd2).map(|telegram| (rest, telegram))
}

fn sd4(input: &[u8]) -> Parsed<'_, Telegram<'_>> {
    let bad = |got: &u8| *got >= Address::BROADCAST.number();
    match input {
        [got, ..] | [_, got, ..] if bad(got) => refuse(FrameError::TokenAddress { got: *got }),
        [da, sa, rest @ ..] => {
            Ok((rest, Telegram::Token { da: Address::from_octet(*da), sa: Address::from_octet(*sa) }))
        }
        [] | [_] => Err(nom::Err::Incomplete(nom::Needed::Unknown)),
    }
}

/// The octets from DA to ED of a telegram whose bounds are known.
fn enclosed(octets: &[u8], format: Format) -> Result<Telegram<'_>, nom::Err<FrameError>> {
    let Some((body, &[fcs, ed])) = octets.split_last_chunk::<2>() else {
        return Err(nom::Err::Incomplete(nom::Needed::Unknown));
    };
    if ed != ED {
        return Err(nom::Err::Error(FrameError::EndDelimiter { got: ed }));
    }
    let expected = checksum(body);
    if fcs != expected {
        return Err(nom::Err::Error(FrameError::Checksum { expected, got: fcs }));
    }
    let (rest, (da, sa, fc)) = (be_u8, be_u8, be_u8).parse(body)?;
    let (rest, dsap) = cond(da & EXTENSION != 0, extension).parse(rest)?;
    let (data, ssap) = cond(sa & EXTENSION != 0, extension).parse(rest)?;
    Ok(Telegram::Data(DataTelegram {
        format,
        da: Address::from_octet(da),
        sa: Address::from_octet(sa),
        dsap,
        ssap,
        fc: FunctionCode::from_octet(fc),
        data,
    }))
}

/// An extension octet: b7 = another one follows, b6 = segment address, b5..b0 = SAP. DP uses plain SAPs only.
fn extension(input: &[u8]) -> Parsed<'_, Sap> {
    let (rest, octet) = be_u8(input)?;
    match Sap::new(octet) {
        Some(sap) => Ok((rest, sap)),
        None => refuse(FrameError::Extension { got: octet }),
    }
}

fn refuse<T>(error: FrameError) -> Result<T, nom::Err<FrameError>> {
    Err(nom::Err::Error(error))
}

/// How much of a refused telegram to drop: all of it only where four octets of head and the end agree on its
/// bounds, which is SD2 behind its ED.
fn skip(input: &[u8], error: FrameError) -> usize {
    match (input, error) {
        (
            [SD2, le, ..],
            FrameError::Checksum { .. } | FrameError::ExtensionMissing | FrameError::Extension { .. },
        ) => usize::from(*le) + SD2_OVERHEAD,
        (_, _) => 1,
    }
}

/// FCS: the sum modulo 256 of the octets from DA to the last data octet.
fn checksum(octets: &[u8]) -> u8 {
    octets.iter().fold(0, |sum: u8, octet| sum.wrapping_add(*octet))
}

fn room(buf: &mut [u8], needed: usize) -> Result<&mut [u8], EncodeError> {
    let got = buf.len();
    buf.get_mut(..needed).ok_or(EncodeError::BufferTooSmall { needed, got })
}

fn start(out: &mut [u8], delimiter: u8) {
    if let Some(first) = out.first_mut() {
        *first = delimiter;
    }
}

#[cfg(test)]
pub(crate) mod tests;
