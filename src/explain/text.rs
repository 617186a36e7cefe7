//! Octets written as text: hexadecimal digits in any usual form, line by line.
//!
//! ```
//! use profidrive::explain::HexText;
//!
//! let mut text = HexText::default();
//! for line in [
//!     "68 05 05 68",
//!     "680505 68",
//!     "0x68, 0x05, 0x05, 0x68,   // SD2",
//!     r"\x68\x05\x05\x68",
//!     r"b'h\x05\x05h'",
//!     "const uint8_t request[] = { 0x68, 0x05, 0x05, 0x68 };",
//!     "68-05-05-68",
//!     "TX: 68 05 05 68",
//!     "00000000: 6805 0568                                h..h",
//! ] {
//!     assert_eq!(text.octets(line)?, [0x68, 0x05, 0x05, 0x68], "{line}");
//! }
//! # Ok::<(), profidrive::explain::TextError>(())
//! ```

mod number;
mod stamp;

use thiserror::Error;

use number::{is_number, numbers};

/// Reads lines of hexadecimal text.
///
/// Taken are octets (`68 05`), words and longer runs of digits, high octet first (`6805`), with or without `0x`, `$`,
/// `\x`, the `16#`, `B#16#`, `W#16#` or `DW#16#` of a PLC, or an `h` behind; separated by spaces, commas, colons,
/// hyphens, or not at all; in the braces, brackets or quotes of C, Rust and Python, string escapes included; behind a
/// time stamp or a label (`TX:`); in dumps with offset and characters beside them (`xxd`, `hexdump -C`, `od -tx1`,
/// `tcpdump -X`, Wireshark). Comments begin with `#`, `//`, `/*` or `;`. There is no decimal: `10` is 10h.
///
/// Where `%#x` or a PLC leaves zeros out and one number has more than two digits, all are words: `0x33F8 0x0 0x3 0xD090`.
#[derive(Clone, Debug, Default)]
pub struct HexText {
    /// Octets of the dump so far, which its next offset must equal.
    dumped: usize,
}

/// Why a line cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum TextError {
    /// Something that is no hexadecimal number.
    #[error("'{found}' is no hexadecimal octet; comments begin with # or //")]
    NotHex {
        /// What was found, shortened.
        found: String,
    },
    /// A number that is no whole octets.
    #[error("'{found}' has an odd number of digits; write each octet with two")]
    OddDigits {
        /// What was found, shortened.
        found: String,
    },
    /// A number among others that are written in another way, so that octets and words cannot be told apart.
    #[error(
        "'{found}' is not written like the numbers beside it: write each octet with two digits or each word with four, and a space before a comment"
    )]
    Mixed {
        /// What was found, shortened.
        found: String,
    },
    /// Digits or letters of another alphabet that look like hexadecimal ones.
    #[error("'{found}' has full-width characters; write the digits 0 to 9 and the letters A to F")]
    FullWidth {
        /// What was found, shortened.
        found: String,
    },
    /// A PLC's number that is longer than its type.
    #[error("'{found}' has more digits than its type holds")]
    TooLong {
        /// What was found, shortened.
        found: String,
    },
    /// A line of `hexdump` or `xxd` that stands for several.
    #[error("'*' stands for lines that were left out; dump with hexdump -v, od -v or xxd")]
    LeftOut,
    /// A dump in words of this machine's octet order.
    #[error(
        "this is a dump of 16-bit words, which may have their octets swapped; dump with hexdump -C or od -tx1"
    )]
    Words,
}

impl HexText {
    /// The octets of a line; none of an empty one or a comment.
    ///
    /// # Errors
    /// [`TextError`] with the first thing that cannot be read.
    pub fn octets(&mut self, line: &str) -> Result<Vec<u8>, TextError> {
        // Editors and shells of Windows begin a file with a mark of its octet order.
        let line = without_comment(line.trim_start_matches('\u{feff}')).trim();
        let line = stamp::behind(line);
        if line == "*" && self.dumped > 0 {
            return Err(TextError::LeftOut);
        }
        if let Some(octets) = literal(line) {
            return Ok(octets);
        }
        if let Some(dump) = self.dump(line)? {
            let octets = numbers(dump)?;
            self.dumped += octets.len();
            return Ok(octets);
        }
        self.dumped = 0;
        numbers(content(line))
    }

    /// The octets in a line of a dump, as text; `None` if it is none.
    fn dump<'a>(&mut self, line: &'a str) -> Result<Option<&'a str>, TextError> {
        let (offset, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let padded = rest.trim_start();
        let digits = offset.strip_suffix(':').unwrap_or(offset);
        let digits = digits.strip_prefix("0x").unwrap_or(digits);
        let is_hex = digits.bytes().all(|digit| digit.is_ascii_hexdigit());
        if !is_hex || !(4..=8).contains(&digits.len()) {
            return Ok(None);
        }
        if offset.ends_with(':') {
            self.begin_if_zero(digits);
            return Ok(Some(padded.split_once("  ").map_or(padded, |(octets, _)| octets)));
        }
        // Without a colon only the value of the offset tells it from data. `od` counts in octal.
        let radix = if digits.len() == 7 { [8, 16] } else { [16, 16] };
        let expected =
            |radix| usize::from_str_radix(digits, radix).is_ok_and(|at| at == self.dumped || at == 0);
        if !radix.into_iter().any(expected) {
            return Ok(None);
        }
        let first = padded.split_whitespace().next();
        match first.map(str::len) {
            // The last line of a dump is its length.
            None if self.dumped > 0 => Ok(Some("")),
            Some(2) => {
                self.begin_if_zero(digits);
                let octets = padded.split_once('|').map_or(padded, |(octets, _)| octets);
                Ok(Some(octets.split_once("   ").map_or(octets, |(octets, _)| octets)))
            }
            Some(4) if digits.len() == 7 => Err(TextError::Words),
            None | Some(_) => Ok(None),
        }
    }

    fn begin_if_zero(&mut self, digits: &str) {
        if digits.bytes().all(|digit| digit == b'0') {
            self.dumped = 0;
        }
    }
}

/// The line up to a comment. Quotes hide nothing: no octets are written with these characters.
fn without_comment(line: &str) -> &str {
    let quoted = line.contains(['"', '\'']) && line.contains("\\x");
    if quoted {
        return line;
    }
    let others = ["//", "/*", ";"].iter().filter_map(|mark| line.find(mark));
    let hashes = line.match_indices('#').map(|(at, _)| at).filter(|at| !number::is_in_number(line, *at));
    let end = others.chain(hashes).min().unwrap_or(line.len());
    line.get(..end).unwrap_or(line)
}

/// The octets of a string in quotes with escapes, as Python prints them: letters stand for themselves.
fn literal(line: &str) -> Option<Vec<u8>> {
    let start = line.find(['"', '\''])?;
    let (_, quoted) = line.split_at_checked(start)?;
    let quote = quoted.chars().next()?;
    let text = quoted.get(1..)?;
    let text = text.get(..text.rfind(quote)?)?;
    if !text.contains('\\') || !text.is_ascii() {
        return None;
    }
    let mut octets = Vec::new();
    let mut chars = text.bytes();
    while let Some(char) = chars.next() {
        if char != b'\\' {
            octets.push(char);
            continue;
        }
        octets.push(match chars.next()? {
            b'x' => {
                let digits = [chars.next()?, chars.next()?];
                u8::from_str_radix(core::str::from_utf8(&digits).ok()?, 16).ok()?
            }
            b'n' => b'\n',
            b'r' => b'\r',
            b't' => b'\t',
            b'0' => 0,
            other @ (b'\\' | b'"' | b'\'') => other,
            _ => return None,
        });
    }
    Some(octets)
}

/// What is between the brackets of an array or behind a label or an equals sign; else the whole line.
fn content(line: &str) -> &str {
    let line = line.rsplit_once('=').map_or(line, |(_, value)| value);
    // `(12.345678) 10 05`: brackets before the octets are a label.
    let behind = line.starts_with(['[', '(']).then(|| line.find([']', ')'])).flatten();
    let behind = behind.and_then(|at| line.get(at + 1..)).unwrap_or_default();
    if behind.split_whitespace().next().is_some_and(is_number) {
        return behind;
    }
    let inside = match line.rfind(['{', '[', '(']) {
        Some(open) => line.get(open + 1..).unwrap_or_default(),
        None => line,
    };
    let inside = inside.find(['}', ']', ')']).and_then(|close| inside.get(..close)).unwrap_or(inside).trim();
    match inside.split_once(':') {
        Some((label, rest)) if rest.starts_with(char::is_whitespace) && !is_octet(label) => rest.trim(),
        Some(_) | None => inside,
    }
}

/// Two digits before a colon are an octet, not a label.
fn is_octet(text: &str) -> bool {
    text.len() == 2 && text.bytes().all(|digit| digit.is_ascii_hexdigit())
}

#[cfg(test)]
mod tests;
