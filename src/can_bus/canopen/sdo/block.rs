//! Block transfers: what a client asks, and their checksum (CiA 301).

use super::FRAME_LEN;
use crate::can_bus::canopen::address::Address;

/// Octets of a segment.
pub(crate) const SEGMENT_LEN: usize = 7;

/// The most segments of a block.
pub(crate) const MOST_SEGMENTS: u8 = 127;

/// Bit 7 of the number of a segment: no other follows.
pub(crate) const LAST: u8 = 0x80;

/// A request of a client; segments of a download are none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BlockRequest {
    /// Write.
    Download {
        at: Address,
        /// It sends a checksum at the end.
        crc: bool,
        /// Octets in all, if said.
        len: Option<u32>,
    },
    /// All segments are sent; so many octets of the last one do not count.
    DownloadEnd { unused: u8, crc: u16 },
    /// Read, in blocks of so many segments; values of at most `threshold` octets rather in an ordinary upload.
    Upload { at: Address, crc: bool, size: u8, threshold: u8 },
    /// Send the first block.
    UploadStart,
    /// So many segments of the block came in their order; the next block has this size.
    UploadTaken { count: u8, size: u8 },
    /// Everything came.
    UploadEnd,
    /// No command of a client.
    Unknown,
}

impl BlockRequest {
    pub(crate) const fn decode([command, a, b, c, d, e, f, g]: [u8; FRAME_LEN]) -> Self {
        let at = Address::new(u16::from_le_bytes([a, b]), c);
        let crc = command & 0x04 != 0;
        match (command >> 5, command & 0x03) {
            (6, bits @ (0 | 2)) => {
                let len = if bits == 2 { Some(u32::from_le_bytes([d, e, f, g])) } else { None };
                Self::Download { at, crc, len }
            }
            (6, 1 | 3) => Self::DownloadEnd { unused: command >> 2 & 7, crc: u16::from_le_bytes([a, b]) },
            (5, 0) => Self::Upload { at, crc, size: d, threshold: e },
            (5, 1) => Self::UploadEnd,
            (5, 2) => Self::UploadTaken { count: a, size: b },
            (5, 3) => Self::UploadStart,
            (0.., 0..) => Self::Unknown,
        }
    }
}

/// The checksum of octets behind others with the checksum `before`: x^16 + x^12 + x^5 + 1, beginning with 0.
pub(crate) fn crc_16(before: u16, octets: &[u8]) -> u16 {
    octets.iter().fold(before, |crc, octet| {
        (0..8).fold(crc ^ u16::from(*octet) << 8, |crc, _| {
            let divided = if crc & 0x8000 == 0 { 0 } else { 0x1021 };
            crc << 1 ^ divided
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checksum_is_that_of_the_standard() {
        assert_eq!(crc_16(0, b"123456789"), 0x31C3);
        assert_eq!(crc_16(crc_16(0, b"1234"), b"56789"), 0x31C3);
    }
}
