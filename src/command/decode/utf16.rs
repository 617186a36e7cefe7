//! Text of Windows in UTF-16, as PowerShell writes it with `>`.

use std::collections::VecDeque;
use std::io::{self, Read};

/// Which octet of a unit comes first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Order {
    LowFirst,
    HighFirst,
}

/// Gives UTF-16 as UTF-8. What is no text becomes U+FFFD.
pub(super) struct Utf16<R> {
    source: R,
    order: Order,
    /// Half a unit.
    odd: Option<u8>,
    /// The first unit of a character of two.
    high: Option<u16>,
    text: VecDeque<u8>,
}

impl Utf16<()> {
    /// The order of octets by the mark at the beginning, if the text behind it begins with a character of ASCII or ends.
    pub(super) fn order(head: &[u8]) -> Option<Order> {
        match *head {
            [0xFF, 0xFE] | [0xFF, 0xFE, _] | [0xFF, 0xFE, 1..=0x7F, 0, ..] => Some(Order::LowFirst),
            [0xFE, 0xFF] | [0xFE, 0xFF, _] | [0xFE, 0xFF, 0, 1..=0x7F, ..] => Some(Order::HighFirst),
            [..] => None,
        }
    }
}

impl<R: Read> Utf16<R> {
    pub(super) fn new(source: R, order: Order) -> Self {
        Self { source, order, odd: None, high: None, text: VecDeque::new() }
    }

    /// Takes octets of the source; none: it has ended.
    fn take(&mut self, octets: &[u8]) {
        for octet in octets {
            let Some(first) = self.odd.take() else {
                self.odd = Some(*octet);
                continue;
            };
            let unit = match self.order {
                Order::LowFirst => u16::from_le_bytes([first, *octet]),
                Order::HighFirst => u16::from_be_bytes([first, *octet]),
            };
            let before = self.high.take();
            if (0xD800..0xDC00).contains(&unit) {
                self.high = Some(unit);
                if before.is_some() {
                    // It has lost its second.
                    push(&mut self.text, REPLACEMENT);
                }
                continue;
            }
            for char in char::decode_utf16(before.into_iter().chain([unit])) {
                push(&mut self.text, char.unwrap_or(REPLACEMENT));
            }
        }
        if octets.is_empty() && (self.odd.take().is_some() | self.high.take().is_some()) {
            push(&mut self.text, REPLACEMENT);
        }
    }
}

const REPLACEMENT: char = char::REPLACEMENT_CHARACTER;

fn push(text: &mut VecDeque<u8>, char: char) {
    text.extend(char.encode_utf8(&mut [0; 4]).bytes());
}

impl<R: Read> Read for Utf16<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        while self.text.is_empty() {
            let mut octets = [0; 4096];
            let len = self.source.read(&mut octets)?;
            self.take(octets.get(..len).unwrap_or_default());
            if len == 0 {
                break;
            }
        }
        self.text.read(into)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gives one octet at a time.
    struct Slow<'a>(&'a [u8]);

    impl Read for Slow<'_> {
        fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
            let len = into.len().min(1);
            self.0.read(&mut into[..len])
        }
    }

    fn text(octets: &[u8]) -> String {
        let order = Utf16::order(octets).unwrap();
        let mut text = String::new();
        Utf16::new(Slow(octets), order).read_to_string(&mut text).unwrap();
        text
    }

    #[test]
    fn both_orders_are_read_whatever_the_pieces() {
        let units: Vec<u16> = "\u{feff}10 05 # caf\u{e9} \u{1f600}\r\n".encode_utf16().collect();
        let low: Vec<u8> = units.iter().flat_map(|unit| unit.to_le_bytes()).collect();
        let high: Vec<u8> = units.iter().flat_map(|unit| unit.to_be_bytes()).collect();
        assert_eq!(text(&low), "\u{feff}10 05 # caf\u{e9} \u{1f600}\r\n");
        assert_eq!(text(&high), text(&low));
        assert_eq!(text(&[0xFF, 0xFE, b'1', 0, b'0']), "\u{feff}1\u{fffd}", "half a unit");
        assert_eq!(text(&[0xFF, 0xFE, b'1', 0, 0, 0xD8, 0x3D, 0xD8, 0, 0xDE]), "\u{feff}1\u{fffd}\u{1f600}");
        assert_eq!(text(&[0xFF, 0xFE, b'1', 0, 0, 0xD8, b'2', 0]), "\u{feff}1\u{fffd}2");
        assert_eq!(
            text(&[0xFF, 0xFE, b'1', 0, 0, 0xD8, 0, 0xD8, b'2', 0]),
            "\u{feff}1\u{fffd}\u{fffd}2",
            "the same half twice"
        );
        assert_eq!(
            text(&[0xFF, 0xFE, b'1', 0, 0, 0xDC, 0, 0xDC, b'2', 0]),
            "\u{feff}1\u{fffd}\u{fffd}2",
            "two second halves"
        );
    }

    #[test]
    fn raw_octets_are_no_text() {
        for octets in [&[0xFF, 0xFE, 0x10, 0x05][..], &[0xFE, 0xFF, 0x00, 0x80], &[0x10, 0x05], &[]] {
            assert_eq!(Utf16::order(octets), None, "{octets:02X?}");
        }
    }
}
