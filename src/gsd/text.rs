//! Octets to text. Makers write ASCII, CP1252 and, rarely, UTF-8 (`gsd.md` 1.1).

use std::borrow::Cow;

use super::MAX_FILE_LEN;
use super::hint::ReadError;

/// How the octets of a file were read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CodePage {
    /// Nothing above 7Fh.
    Ascii,
    /// UTF-8, with or without its mark.
    Utf8,
    /// Windows 1252, Western European.
    Cp1252,
}

impl CodePage {
    /// Its usual name.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Ascii => "ASCII",
            Self::Utf8 => "UTF-8",
            Self::Cp1252 => "CP1252",
        }
    }
}

/// The octets 80h to 9Fh of CP1252; the other ones are those of ISO 8859-1.
const CP1252: [char; 32] = [
    '\u{20AC}', '\u{FFFD}', '\u{201A}', '\u{0192}', '\u{201E}', '\u{2026}', '\u{2020}', '\u{2021}',
    '\u{02C6}', '\u{2030}', '\u{0160}', '\u{2039}', '\u{0152}', '\u{FFFD}', '\u{017D}', '\u{FFFD}',
    '\u{FFFD}', '\u{2018}', '\u{2019}', '\u{201C}', '\u{201D}', '\u{2022}', '\u{2013}', '\u{2014}',
    '\u{02DC}', '\u{2122}', '\u{0161}', '\u{203A}', '\u{0153}', '\u{FFFD}', '\u{017E}', '\u{0178}',
];

/// The text of a file.
pub(super) fn decode(octets: &[u8]) -> Result<(Cow<'_, str>, CodePage), ReadError> {
    if octets.len() > MAX_FILE_LEN {
        return Err(ReadError::TooLong { got: octets.len() });
    }
    if let Some(marked) = octets.strip_prefix(b"\xEF\xBB\xBF") {
        return Ok((String::from_utf8_lossy(marked), CodePage::Utf8));
    }
    // With or without the mark of UTF-16: a # that is two octets.
    if [&b"\xFF\xFE"[..], b"\xFE\xFF", b"#\0", b"\0#"].iter().any(|start| octets.starts_with(start)) {
        return Err(ReadError::Utf16);
    }
    match core::str::from_utf8(octets) {
        Ok(text) if text.is_ascii() => Ok((Cow::Borrowed(text), CodePage::Ascii)),
        Ok(text) => Ok((Cow::Borrowed(text), CodePage::Utf8)),
        Err(_) => Ok((Cow::Owned(octets.iter().map(|octet| cp1252(*octet)).collect()), CodePage::Cp1252)),
    }
}

fn cp1252(octet: u8) -> char {
    let special = octet.checked_sub(0x80).and_then(|place| CP1252.get(usize::from(place)));
    special.copied().unwrap_or(char::from(octet))
}

/// A string of the file without the blanks and signs that no display shows.
pub(super) fn trimmed(text: &str) -> String {
    text.trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_page_is_recognised() {
        for (octets, text, page) in [
            (&b"plain"[..], "plain", CodePage::Ascii),
            (b"\xEF\xBB\xBFf\xC3\xBCr", "f\u{fc}r", CodePage::Utf8),
            (b"f\xC3\xBCr", "f\u{fc}r", CodePage::Utf8),
            (b"f\xFCr \x80 \x81 \xB5", "f\u{fc}r \u{20AC} \u{FFFD} \u{b5}", CodePage::Cp1252),
            (b"", "", CodePage::Ascii),
        ] {
            assert_eq!(decode(octets), Ok((Cow::Borrowed(text), page)));
        }
        for octets in [&b"\xFF\xFE#\0"[..], b"\xFE\xFF\0#", b"#\0P\0", b"\0#\0P"] {
            assert_eq!(decode(octets), Err(ReadError::Utf16));
        }
    }

    #[test]
    fn no_file_is_longer_than_the_limit() {
        let long = std::vec![b' '; MAX_FILE_LEN + 1];
        assert_eq!(decode(&long), Err(ReadError::TooLong { got: MAX_FILE_LEN + 1 }));
        assert!(decode(&long[1..]).is_ok());
    }
}
