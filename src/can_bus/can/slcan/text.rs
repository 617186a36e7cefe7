//! A frame as a line of text.
//!
//! ```text
//! t iii l dd..        data frame, base identifier        l = 0..8, exactly 2 l digits dd
//! T iiiiiiii l dd..   data frame, extended identifier
//! r iii l             remote request, base identifier
//! R iiiiiiii l        remote request, extended identifier
//!             mmmm    behind a received frame, if asked for: milliseconds, 0000..EA5F (0..59999)
//! ```

use thiserror::Error;

use super::CR;
use crate::can_bus::can::{ExtendedId, Frame, Id, MAX_OCTETS};
use crate::time::Instant;

/// Digits of a base and of an extended identifier.
const BASE_DIGITS: usize = 3;
const EXTENDED_DIGITS: usize = 8;

/// `T`, identifier, length, data, time stamp, CR.
const MAX_LINE: usize = 1 + EXTENDED_DIGITS + 1 + 2 * MAX_OCTETS + 4 + 1;

/// What is wrong with the line of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum LineError {
    /// Too few or too many characters.
    #[error("a line of this kind has {expected} characters, not {got}")]
    Length {
        /// How many there must be.
        expected: usize,
        /// How many there are.
        got: usize,
    },
    /// A character that is no hexadecimal digit.
    #[error("{got:02X}h in column {column} is no hexadecimal digit")]
    Digit {
        /// Where, from 0 on.
        column: usize,
        /// The octet found.
        got: u8,
    },
    /// An identifier of more than 11 or 29 bits.
    #[error("identifier {got:X}h has too many bits")]
    Id {
        /// The number found.
        got: u32,
    },
    /// A data length above 8.
    #[error("a frame carries 0..8 octets, not {got}")]
    DataLength {
        /// The length found.
        got: u8,
    },
}

/// The frame that `line` is, without its CR; `None` if it begins like no frame.
///
/// # Errors
/// [`LineError`]. Never panics.
pub fn parse_frame(line: &[u8]) -> Option<Result<Frame, LineError>> {
    let (digits, remote) = match line.first()? {
        b't' => (BASE_DIGITS, false),
        b'T' => (EXTENDED_DIGITS, false),
        b'r' => (BASE_DIGITS, true),
        b'R' => (EXTENDED_DIGITS, true),
        _ => return None,
    };
    Some(frame(line, digits, remote))
}

fn frame(line: &[u8], digits: usize, remote: bool) -> Result<Frame, LineError> {
    // Before the length is known, the line is at least as long as without data.
    let shortest = 1 + digits + 1;
    if line.len() < shortest {
        return Err(LineError::Length { expected: shortest, got: line.len() });
    }
    let number = hex(line, 1, digits)?;
    let length = octet(hex(line, 1 + digits, 1)?);
    let count = usize::from(length);
    if count > MAX_OCTETS {
        return Err(LineError::DataLength { got: length });
    }
    let expected = if remote { shortest } else { shortest + 2 * count };
    if line.len() != expected {
        return Err(LineError::Length { expected, got: line.len() });
    }
    let id = if digits == BASE_DIGITS { Id::base(word(number)) } else { Id::extended(number) };
    let id = id.map_err(|_| LineError::Id { got: number })?;
    let mut octets = [0; MAX_OCTETS];
    if !remote {
        for (place, to) in octets.iter_mut().take(count).enumerate() {
            *to = octet(hex(line, shortest + 2 * place, 2)?);
        }
    }
    let frame = if remote {
        Frame::remote(id, length)
    } else {
        Frame::data(id, octets.get(..count).unwrap_or_default())
    };
    // At most 8, as looked at above.
    frame.map_err(|_| LineError::DataLength { got: length })
}

/// The number that `count` digits from `column` on are; at most eight.
pub(super) fn hex(line: &[u8], column: usize, count: usize) -> Result<u32, LineError> {
    let digits = line.get(column..column + count);
    let digits = digits.ok_or(LineError::Length { expected: column + count, got: line.len() })?;
    let mut number = 0;
    for (place, &digit) in digits.iter().enumerate() {
        let value = char::from(digit).to_digit(16);
        let value = value.ok_or(LineError::Digit { column: column + place, got: digit })?;
        number = number << 4 | value;
    }
    Ok(number)
}

/// The lowest 16 and 8 bits, of which no more were read.
pub(super) const fn word(number: u32) -> u16 {
    let [high, low] = [octet(number >> 8), octet(number)];
    u16::from_be_bytes([high, low])
}

const fn octet(number: u32) -> u8 {
    let [.., low] = number.to_be_bytes();
    low
}

/// When a frame was received: milliseconds, 0..=59999, then from 0 again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimeStamp(u16);

impl TimeStamp {
    /// The stamp of `now`.
    pub(crate) const fn of(now: Instant) -> Self {
        Self(word((now.as_nanos() / 1_000_000 % 60_000) as u32))
    }

    /// Milliseconds.
    pub(crate) const fn millis(self) -> u16 {
        self.0
    }
}

/// The line of a frame, its CR included.
#[derive(Clone, Copy, Debug)]
pub struct FrameLine {
    text: [u8; MAX_LINE],
    length: usize,
}

impl FrameLine {
    /// The line of `frame`; with `stamp` as an adapter sends it that was asked for time stamps.
    #[must_use]
    pub fn new(frame: &Frame, stamp: Option<TimeStamp>) -> Self {
        let mut line = Self { text: [0; MAX_LINE], length: 0 };
        match (frame.id(), frame.is_remote()) {
            (Id::Base(id), remote) => {
                line.push(if remote { b'r' } else { b't' });
                line.push_hex(u32::from(id.number()), BASE_DIGITS);
            }
            (Id::Extended(id), remote) => {
                line.push(if remote { b'R' } else { b'T' });
                line.push_hex(ExtendedId::number(id), EXTENDED_DIGITS);
            }
        }
        line.push_hex(u32::from(frame.dlc()), 1);
        for octet in frame.octets() {
            line.push_hex(u32::from(*octet), 2);
        }
        if let Some(stamp) = stamp {
            line.push_hex(u32::from(stamp.millis()), 4);
        }
        line.push(CR);
        line
    }

    /// The characters, the last one CR.
    pub fn as_octets(&self) -> &[u8] {
        self.text.get(..self.length).unwrap_or_default()
    }

    fn push(&mut self, character: u8) {
        // The longest line fits.
        if let Some(place) = self.text.get_mut(self.length) {
            *place = character;
            self.length += 1;
        }
    }

    fn push_hex(&mut self, number: u32, digits: usize) {
        const DIGITS: [u8; 16] = *b"0123456789ABCDEF";
        for place in (0..digits).rev() {
            let digit = (number >> (4 * place)) & 0xF;
            self.push(DIGITS.get(usize::from(octet(digit))).copied().unwrap_or_default());
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const GOLDEN: [(&[u8], &str); 7] = [
        (b"t60584000100000000000", "605#40 00 10 00 00 00 00 00"),
        (b"t0000", "000#"),
        (b"t7FF1A5", "7FF#A5"),
        (b"r7051", "705#R1"),
        (b"T0000060520105", "00000605#01 05"),
        (b"T1FFFFFFF0", "1FFFFFFF#"),
        (b"R000007058", "00000705#R8"),
    ];

    #[test]
    fn golden_lines() {
        for (line, frame) in GOLDEN {
            let parsed = parse_frame(line).unwrap().unwrap();
            assert_eq!(parsed.to_string(), frame);
            assert_eq!(FrameLine::new(&parsed, None).as_octets().split_last(), Some((&CR, line)));
        }
        let frame = Frame::with(Id::base(0x705).unwrap(), [0x7F]);
        let stamped = FrameLine::new(&frame, Some(TimeStamp::of(Instant::from_millis(119_999))));
        assert_eq!(stamped.as_octets(), b"t70517FEA5F\r", "59999 ms");
        let stamped = FrameLine::new(&frame, Some(TimeStamp::of(Instant::from_millis(60_010))));
        assert_eq!(stamped.as_octets(), b"t70517F000A\r");
    }

    #[test]
    fn no_part_of_a_line_is_another_frame() {
        for (line, _) in GOLDEN {
            for length in 1..line.len() {
                let part = parse_frame(&line[..length]).unwrap();
                assert!(matches!(part, Err(LineError::Length { .. })), "{part:?}");
            }
            let longer = [line, b"0"].concat();
            assert!(matches!(parse_frame(&longer), Some(Err(LineError::Length { .. }))));
        }
    }

    #[test]
    fn what_is_wrong_with_a_line_is_named() {
        for (line, error) in [
            (&b"t8000"[..], LineError::Id { got: 0x800 }),
            (b"T200000000", LineError::Id { got: 0x2000_0000 }),
            (b"t1239", LineError::DataLength { got: 9 }),
            (b"r123F", LineError::DataLength { got: 15 }),
            (b"t12G0", LineError::Digit { column: 3, got: b'G' }),
            (b"t1231 0", LineError::Digit { column: 5, got: b' ' }),
            (b"t12320", LineError::Length { expected: 9, got: 6 }),
            (b"r12311", LineError::Length { expected: 5, got: 6 }),
            (b"t1230\n", LineError::Length { expected: 5, got: 6 }),
            (b"t\xFF\xFF\xFF0", LineError::Digit { column: 1, got: 0xFF }),
        ] {
            assert_eq!(parse_frame(line), Some(Err(error)));
        }
        for line in [&b""[..], b"x1230", b"\r", b"z"] {
            assert_eq!(parse_frame(line), None);
        }
    }

    proptest! {
        #[test]
        fn a_line_read_back_is_the_frame(
            id in 0_u32..=0x1FFF_FFFF, extended: bool, remote: bool, dlc in 0_u8..=8, octets: [u8; 8], lower: bool
        ) {
            let id = if extended { Id::extended(id) } else { Id::base(word(id & 0x7FF)) }.unwrap();
            let frame = if remote {
                Frame::remote(id, dlc)
            } else {
                Frame::data(id, &octets[..usize::from(dlc)])
            }.unwrap();
            let line = FrameLine::new(&frame, None);
            let mut text = line.as_octets().split_last().unwrap().1.to_vec();
            if lower {
                text[1..].make_ascii_lowercase();
            }
            prop_assert_eq!(parse_frame(&text), Some(Ok(frame)));
        }
    }
}
