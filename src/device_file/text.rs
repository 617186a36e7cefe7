//! Octets to text. Makers write ASCII, CP1252 and, rarely, UTF-8 (`gsd.md` 1.1, `eds.md` 1).

use std::borrow::Cow;

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
    /// The octets of a text that was read from such a file.
    pub(crate) fn encode(self, text: &str) -> Vec<u8> {
        match self {
            Self::Ascii | Self::Utf8 => text.as_bytes().to_vec(),
            Self::Cp1252 => text.chars().map(octet_of).collect(),
        }
    }

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

/// The file is UTF-16, with or without its mark.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Utf16;

/// The text of a file. It begins with an ASCII character, so that a second octet 0, or a first one, is UTF-16.
pub(crate) fn decode(octets: &[u8]) -> Result<(Cow<'_, str>, CodePage), Utf16> {
    if let Some(marked) = octets.strip_prefix(b"\xEF\xBB\xBF") {
        return Ok((String::from_utf8_lossy(marked), CodePage::Utf8));
    }
    if let [0xFF, 0xFE, ..] | [0xFE, 0xFF, ..] | [1..=0x7F, 0, ..] | [0, 1..=0x7F, ..] = octets {
        return Err(Utf16);
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

/// The inverse of [`cp1252`]; what has no character there is `?`.
fn octet_of(char: char) -> u8 {
    let special = (0x80..).zip(CP1252).find(|(_, special)| *special == char).map(|(octet, _)| octet);
    special
        .filter(|_| char != char::REPLACEMENT_CHARACTER)
        .unwrap_or_else(|| u8::try_from(char).unwrap_or(b'?'))
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
            assert_eq!(decode(octets), Err(Utf16));
        }
    }
}
