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

use std::string::{String, ToString};
use std::vec::Vec;

use thiserror::Error;

/// Reads lines of hexadecimal text.
///
/// Taken are octets (`68 05`), words and longer runs of digits, high octet first (`6805`), with or without `0x`, `$`,
/// `\x` or an `h` behind; separated by spaces, commas, colons, hyphens, or not at all; in the braces, brackets or
/// quotes of C, Rust and Python, string escapes included; behind a label (`TX:`); in dumps with offset and characters
/// beside them (`xxd`, `hexdump -C`, `od -tx1`, `tcpdump -X`, Wireshark). Comments begin with `#`, `//`, `/*` or `;`.
/// There is no decimal: `10` is 10h.
#[derive(Clone, Debug, Default)]
pub struct HexText {
    /// Octets of the dump so far, which its next offset must equal.
    dumped: usize,
}

/// Why a line cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
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
    let ends: &[&str] = if quoted { &[] } else { &["#", "//", "/*", ";"] };
    let end = ends.iter().filter_map(|mark| line.find(mark)).min().unwrap_or(line.len());
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

/// The octets of numbers. Words without digits at the front that cannot be numbers are a label.
fn numbers(text: &str) -> Result<Vec<u8>, TextError> {
    let mut octets = Vec::new();
    let mut label = true;
    let text = text.replace("\\x", " ");
    let mut tokens = text.split(SEPARATORS).filter(|token| !token.is_empty()).peekable();
    while let Some(token) = tokens.next() {
        let (prefixed, digits) = digits(token);
        if digits.is_empty() || !digits.bytes().all(|digit| digit.is_ascii_hexdigit()) {
            let word = !token.bytes().any(|char| char.is_ascii_digit());
            if label && word && tokens.peek().is_some() {
                continue;
            }
            return Err(TextError::NotHex { found: shortened(token) });
        }
        label = false;
        match digits.len() {
            // 0x5 is clear, 5 between other octets is not.
            1 if prefixed => octets.extend(u8::from_str_radix(digits, 16)),
            len if len % 2 == 1 => return Err(TextError::OddDigits { found: shortened(token) }),
            _ => {
                let pairs = digits.as_bytes().chunks(2).filter_map(|pair| core::str::from_utf8(pair).ok());
                octets.extend(pairs.filter_map(|pair| u8::from_str_radix(pair, 16).ok()));
            }
        }
    }
    Ok(octets)
}

const SEPARATORS: [char; 16] =
    [' ', '\t', ',', ':', '-', '_', '"', '\'', '{', '}', '[', ']', '(', ')', '<', '>'];

/// The digits of a number without what marks it as hexadecimal, and whether a mark was before them.
fn digits(token: &str) -> (bool, &str) {
    let stripped = ["0x", "0X", "$"].iter().find_map(|prefix| token.strip_prefix(prefix));
    let digits = stripped.unwrap_or(token);
    let digits = digits.strip_suffix(['h', 'H']).unwrap_or(digits);
    // The suffixes of C and Rust: 0x68u, 0x68u8.
    let digits = match stripped {
        Some(_) => digits.split(['u', 'U']).next().unwrap_or(digits),
        None => digits,
    };
    (stripped.is_some(), digits)
}

fn shortened(token: &str) -> String {
    const MOST: usize = 24;
    if token.chars().count() <= MOST {
        return token.to_string();
    }
    token.chars().take(MOST).chain("...".chars()).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use std::format;

    use super::*;

    /// A diagnosis and its short acknowledge: longer than a line of most dumps.
    const OCTETS: [u8; 18] = [
        0x68, 0x0B, 0x0B, 0x68, 0x82, 0x85, 0x08, 0x3E, 0x3C, 0x02, 0x05, 0x00, 0xFF, 0x0A, 0xC5, 0x5E, 0x16,
        0xE5,
    ];

    fn read(lines: &str) -> Result<Vec<u8>, TextError> {
        let mut text = HexText::default();
        let mut octets = Vec::new();
        for line in lines.lines() {
            octets.extend(text.octets(line)?);
        }
        Ok(octets)
    }

    #[test]
    fn the_dumps_of_common_tools_are_read_without_offset_and_characters() {
        for dump in [
            // xxd
            "00000000: 680b 0b68 8285 083e 3c02 0500 ff0a c55e  h..h...><......^\n00000010: 16e5                                     ..",
            // xxd -g1, whose characters may look like hexadecimal digits
            "00000000: 68 0b 0b 68 82 85 08 3e 3c 02 05 00 ff 0a c5 5e  ab cd ef........\n00000010: 16 e5                                            ab",
            // hexdump -C
            "00000000  68 0b 0b 68 82 85 08 3e  3c 02 05 00 ff 0a c5 5e  |h..h...><......^|\n00000010  16 e5                                             |..|\n00000012",
            // od -tx1
            "0000000 68 0b 0b 68 82 85 08 3e 3c 02 05 00 ff 0a c5 5e\n0000020 16 e5\n0000022",
            // od -Ax -tx1
            "000000 68 0b 0b 68 82 85 08 3e 3c 02 05 00 ff 0a c5 5e\n000010 16 e5\n000012",
            // Wireshark
            "0000   68 0b 0b 68 82 85 08 3e 3c 02 05 00 ff 0a c5 5e   h..h...><......^\n0010   16 e5                                             ..",
            "0000   68 0b 0b 68 82 85 08 3e  3c 02 05 00 ff 0a c5 5e   h..h...> <......^\n0010   16 e5",
            // tcpdump -X
            "\t0x0000:  680b 0b68 8285 083e 3c02 0500 ff0a c55e  h..h...><......^\n\t0x0010:  16e5                                     ..",
        ] {
            assert_eq!(read(dump).as_deref(), Ok(&OCTETS[..]), "{dump}");
        }
    }

    #[test]
    fn the_arrays_and_strings_of_programs_are_read() {
        for source in [
            "uint8_t reply[18] = {\n    0x68, 0x0B, 0x0B, 0x68, 0x82, 0x85, 0x08, 0x3E, 0x3C, // head\n    0x02, 0x05, 0x00, 0xFF, 0x0A, 0xC5, 0x5E, 0x16, /* end */\n    0xE5\n};",
            "let reply = [0x68u8, 0x0B, 0x0B, 0x68, 0x82, 0x85, 0x8, 0x3E, 0x3C, 0x02, 0x05, 0x00, 0xFF, 0x0A, 0xC5, 0x5E, 0x16, 0xE5];",
            r"b'h\x0b\x0bh\x82\x85\x08><\x02\x05\x00\xff\n\xc5^\x16\xe5'",
            r#""\x68\x0B\x0B\x68\x82\x85\x08\x3E\x3C\x02\x05\x00\xFF\x0A\xC5\x5E\x16\xE5""#,
            r"\x68\x0b\x0b\x68\x82\x85\x08\x3e\x3c\x02\x05\x00\xff\x0a\xc5\x5e\x16\xe5",
            "bytes.fromhex('680b0b688285083e3c020500ff0ac55e16e5')",
            "bytearray([0x68, 0x0b, 0x0b, 0x68, 0x82, 0x85, 0x08, 0x3e, 0x3c, 0x02, 0x05, 0x00, 0xff, 0x0a, 0xc5, 0x5e, 0x16, 0xe5])",
            "68h 0Bh 0Bh 68h 82h 85h 08h 3Eh 3Ch 02h 05h 00h 0FFh 0Ah 0C5h 5Eh 16h 0E5h",
            "# a comment\n; another\n\nRX -> 68:0b:0b:68:82:85:08:3e:3c:02:05:00:ff:0a:c5:5e:16 ; and more\nslave: E5",
            "$68 $0B $0B $68 $82 $85 $08 $3E $3C $02 $05 $00 $FF $0A $C5 $5E $16 $E5",
            "680B0B688285083E3C020500FF0AC55E16\nE5",
        ] {
            let octets = read(source);
            if source.contains("0FFh") {
                // Assemblers write a zero before a letter; such a number has an odd number of digits.
                assert_eq!(octets, Err(TextError::OddDigits { found: "0FFh".into() }));
            } else {
                assert_eq!(octets.as_deref(), Ok(&OCTETS[..]), "{source}");
            }
        }
    }

    #[test]
    fn words_of_the_manual_are_octets_high_first() {
        assert_eq!(read("13FA 0000 0000 0000"), Ok(Vec::from([0x13, 0xFA, 0, 0, 0, 0, 0, 0])));
        assert_eq!(read("0000 0000 0000 0000").map(|octets| octets.len()), Ok(8), "no dump");
        assert_eq!(read("\u{feff}13FA"), Ok(Vec::from([0x13, 0xFA])));
        assert_eq!(read("0x13FA 0x0000 0x0003 0xD090").map(|octets| octets.len()), Ok(8));
    }

    #[test]
    fn what_cannot_be_read_says_why() {
        for (line, error) in [
            ("68 0", "'0' has an odd number of digits; write each octet with two"),
            ("68 0G 05", "'0G' is no hexadecimal octet; comments begin with # or //"),
            ("1O 05 02", "'1O' is no hexadecimal octet; comments begin with # or //"),
            ("hello", "'hello' is no hexadecimal octet; comments begin with # or //"),
            ("hello world", "'world' is no hexadecimal octet; comments begin with # or //"),
            (
                "00000000: 00\n*",
                "'*' stands for lines that were left out; dump with hexdump -v, od -v or xxd",
            ),
            (
                "0000000 0b68 680b",
                "this is a dump of 16-bit words, which may have their octets swapped; dump with hexdump -C or od -tx1",
            ),
            ("68 \u{fffd}", "'\u{fffd}' is no hexadecimal octet; comments begin with # or //"),
        ] {
            assert_eq!(read(line).unwrap_err().to_string(), error, "{line}");
        }
        let long = "x".repeat(1000);
        assert!(read(&long).unwrap_err().to_string().len() < 100);
    }

    proptest! {
        #[test]
        fn any_text_is_read_or_refused_and_never_gives_more_octets_than_characters(text: String) {
            let mut reader = HexText::default();
            for line in text.lines() {
                if let Ok(octets) = reader.octets(line) {
                    prop_assert!(octets.len() <= line.len());
                }
            }
        }

        #[test]
        fn octets_survive_every_way_of_writing_them(octets in proptest::collection::vec(any::<u8>(), 1..40)) {
            let join = |format: fn(&u8) -> String, between: &str| {
                octets.iter().map(format).collect::<Vec<_>>().join(between)
            };
            for text in [
                join(|octet| format!("{octet:02x}"), " "),
                join(|octet| format!("{octet:02X}"), "-"),
                join(|octet| format!("0x{octet:X}"), ", "),
                join(|octet| format!("\\x{octet:02x}"), ""),
                join(|octet| format!("{octet:02X}"), ""),
            ] {
                prop_assert_eq!(HexText::default().octets(&text), Ok(octets.clone()), "{}", text);
            }
        }
    }
}
