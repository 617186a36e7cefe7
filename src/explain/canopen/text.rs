//! Frames written as text.
//!
//! ```text
//! (1436509052.249713) can0 605#4041600000000000   candump -L, cansend; R or R8 behind # is a remote request
//! can0  605   [8]  40 41 60 00 00 00 00 00         candump
//! t60584041600000000000                            slcan, also with a time stamp of four digits behind
//! 605#40 41 60 00                                  as logs of this program write it
//! ```

use thiserror::Error;

use crate::can_bus::can::slcan::parse_frame;
use crate::can_bus::can::{Frame, FrameError, Id, IdError};

/// Why a line that is written like a frame is none.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum FrameTextError {
    /// CAN FD.
    #[error("a frame of CAN FD (##) is no frame of CANopen")]
    Fd,
    /// An error frame, which has no data of its own.
    #[error("an error frame of the driver: no frame of the bus")]
    ErrorFrame,
    /// The identifier.
    #[error(transparent)]
    Id(#[from] IdError),
    /// More than eight octets.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// Data that are no octets.
    #[error("'{found}' is no row of octets with two digits each")]
    Data {
        /// What was found.
        found: String,
    },
    /// Fewer or more octets than the length says.
    #[error("the length says {expected} octets, there are {got}")]
    Length {
        /// What the length says.
        expected: usize,
        /// What there is.
        got: usize,
    },
    /// A line of slcan that is almost a frame.
    #[error("as a line of slcan: {reason}")]
    Slcan {
        /// What is wrong.
        reason: String,
    },
}

/// The frame that a line is, `None` if it is not written like one.
///
/// # Errors
/// [`FrameTextError`]. Never panics.
pub fn frame_in(line: &str) -> Option<Result<Frame, FrameTextError>> {
    let line = line.trim();
    let parts: Vec<&str> = line.split_ascii_whitespace().collect();
    if let [one] = parts[..]
        && let Some(frame) = slcan(one)
    {
        return Some(frame);
    }
    let hash = parts.iter().position(|part| part.split_once('#').is_some_and(|(id, _)| is_id(id)));
    if let Some(place) = hash {
        let (id, data) = parts.get(place)?.split_once('#')?;
        let rest = parts.get(place + 1..).unwrap_or_default();
        // candump -x says the direction behind the frame.
        let rest = rest.strip_suffix(&["R"]).or(rest.strip_suffix(&["T"])).unwrap_or(rest);
        return Some(compact(id, data, rest));
    }
    columns(&parts)
}

/// Three digits of 11 bits, eight of 29.
fn is_id(text: &str) -> bool {
    matches!(text.len(), 3 | 8) && text.bytes().all(|digit| digit.is_ascii_hexdigit())
}

fn id(text: &str) -> Result<Id, FrameTextError> {
    let number = u32::from_str_radix(text, 16).unwrap_or(u32::MAX);
    if text.len() == 3 {
        return Ok(Id::base(u16::try_from(number).unwrap_or(u16::MAX))?);
    }
    // candump writes error frames with bit 29 set.
    if number & 0x2000_0000 != 0 {
        return Err(FrameTextError::ErrorFrame);
    }
    Ok(Id::extended(number)?)
}

fn compact(name: &str, data: &str, rest: &[&str]) -> Result<Frame, FrameTextError> {
    if data.starts_with('#') {
        return Err(FrameTextError::Fd);
    }
    let id = id(name)?;
    if let Some(length) = data.strip_prefix(['R', 'r'])
        && rest.is_empty()
    {
        let dlc = if length.is_empty() { Some(0) } else { length.parse().ok() };
        let dlc = dlc.ok_or_else(|| FrameTextError::Data { found: data.into() })?;
        return Ok(Frame::remote(id, dlc)?);
    }
    let octets =
        core::iter::once(data).chain(rest.iter().copied()).map(octets).collect::<Result<Vec<_>, _>>()?;
    Ok(Frame::data(id, &octets.concat())?)
}

fn octets(text: &str) -> Result<Vec<u8>, FrameTextError> {
    let wrong = || FrameTextError::Data { found: text.chars().take(40).collect() };
    // cansend allows points between octets.
    let digits: Vec<u8> = text.bytes().filter(|octet| *octet != b'.').collect();
    if !digits.len().is_multiple_of(2) {
        return Err(wrong());
    }
    digits
        .chunks(2)
        .map(|pair| {
            let pair =
                core::str::from_utf8(pair).ok().filter(|pair| pair.bytes().all(|d| d.is_ascii_hexdigit()));
            pair.and_then(|pair| u8::from_str_radix(pair, 16).ok()).ok_or_else(wrong)
        })
        .collect()
}

/// `can0  605   [8]  40 41 ..` and `can0  705   [1]  remote request`.
fn columns(parts: &[&str]) -> Option<Result<Frame, FrameTextError>> {
    let place = parts.iter().position(|part| part.starts_with('[') && part.ends_with(']'))?;
    let name = parts.get(place.checked_sub(1)?).copied().filter(|name| is_id(name))?;
    let length = parts.get(place)?.trim_matches(['[', ']']);
    let length: usize = length.parse().ok()?;
    let data = parts.get(place + 1..).unwrap_or_default();
    let frame = || {
        let id = id(name)?;
        if let ["remote", "request", ..] = data {
            return Ok(Frame::remote(id, u8::try_from(length).unwrap_or(u8::MAX))?);
        }
        // candump -a shows the characters behind the octets.
        let data = data.get(..data.iter().position(|part| part.starts_with('\'')).unwrap_or(data.len()));
        let octets =
            data.unwrap_or_default().iter().copied().map(octets).collect::<Result<Vec<_>, _>>()?.concat();
        if octets.len() != length {
            return Err(FrameTextError::Length { expected: length, got: octets.len() });
        }
        Ok(Frame::data(id, &octets)?)
    };
    Some(frame())
}

/// A line of slcan. A word that only begins with the same letter is none.
fn slcan(line: &str) -> Option<Result<Frame, FrameTextError>> {
    let digits = line.get(1..).filter(|digits| digits.bytes().all(|digit| digit.is_ascii_hexdigit()))?;
    if digits.len() < 4 {
        return None;
    }
    match parse_frame(line.as_bytes())? {
        Ok(frame) => Some(Ok(frame)),
        Err(reason) => {
            let without_stamp = line.get(..line.len() - 4).and_then(|line| parse_frame(line.as_bytes()));
            match without_stamp {
                Some(Ok(frame)) => Some(Ok(frame)),
                Some(Err(_)) | None => Some(Err(FrameTextError::Slcan { reason: reason.to_string() })),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(line: &str) -> String {
        match frame_in(line) {
            None => "none".into(),
            Some(Ok(frame)) => frame.to_string(),
            Some(Err(error)) => error.to_string(),
        }
    }

    #[test]
    fn each_way_of_writing_a_frame() {
        for (line, frame) in [
            ("(1436509052.249713) vcan0 044#2A366C2BBA", "044#2A 36 6C 2B BA"),
            ("605#4041600000000000", "605#40 41 60 00 00 00 00 00"),
            ("605#40 41 60 00", "605#40 41 60 00"),
            ("605#40.41", "605#40 41"),
            ("080#", "080#"),
            ("705#R1", "705#R1"),
            ("705#R", "705#R0"),
            ("12345678#01", "12345678#01"),
            ("(0.1) can0 605#40 T", "605#40"),
            ("  can0  605   [8]  40 41 60 00 00 00 00 00", "605#40 41 60 00 00 00 00 00"),
            ("can0  185   [2]  70 02   'p.'", "185#70 02"),
            ("can0  705   [1]  remote request", "705#R1"),
            ("can0  080   [0]", "080#"),
            ("t60584041600000000000", "605#40 41 60 00 00 00 00 00"),
            ("t605840416000000000001234", "605#40 41 60 00 00 00 00 00"),
            ("r7051\r", "705#R1"),
            ("T123456781AA", "12345678#AA"),
        ] {
            assert_eq!(read(line), frame, "{line}");
        }
    }

    #[test]
    fn octets_of_other_lines_are_no_frames_and_broken_frames_say_why() {
        for line in [
            "10 05 02 49 50 16",
            "16#6805",
            "W#16#6805",
            "68 05 # 605",
            "transfer",
            "t",
            "",
            "[8] 40",
            "13FA0000",
        ] {
            assert_eq!(read(line), "none", "{line}");
        }
        for (line, says) in [
            ("605##1AA", "CAN FD"),
            ("20000008#0000", "error frame"),
            ("FFF#00", "base identifier FFFh"),
            ("605#4", "'4' is no row of octets"),
            ("605#4G", "'4G' is no row of octets"),
            ("605#000000000000000000", "0..8 octets, not 9"),
            ("can0 605 [2] 40", "the length says 2 octets, there are 1"),
            ("t6059404160", "as a line of slcan: a frame carries 0..8 octets, not 9"),
        ] {
            assert!(read(line).contains(says), "{line}: {}", read(line));
        }
    }
}
