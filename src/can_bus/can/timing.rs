//! How many bits a frame is on the wire.
//!
//! ```text
//!           |<----------- CRC over these ---------->|
//! base      SOF id:11 RTR IDE=0 r0 DLC:4 data:8n     CRC:15 | CRC delimiter, ACK:2, EOF:7 | intermission:3
//! extended  SOF id:11 SRR=1 IDE=1 id:18 RTR r1 r0 DLC:4 data:8n CRC:15 | as above
//!           |<--------- stuffed: after five equal bits one more, the other way round ---->|
//! ```
//!
//! 34 + 8n bits of a base frame and 54 + 8n of an extended one are stuffed; the last of the five can be a stuff bit.

use super::{Content, Frame, Id};

/// Bits between two frames (intermission).
pub(crate) const INTERMISSION: u32 = 3;

/// Bits of an error frame: the flag of the first who sees the error, that of the others, the delimiter.
pub(crate) const ERROR_FRAME: u32 = 6 + 6 + 8;

/// Bits that an error passive transmitter waits more than others before it sends again.
pub(crate) const SUSPEND: u32 = 8;

/// CRC delimiter, acknowledge slot and its delimiter, end of frame: never stuffed.
const TAIL: u32 = 1 + 2 + 7;

/// x^15 + x^14 + x^10 + x^8 + x^7 + x^4 + x^3 + 1 without its first term.
const CRC_POLYNOMIAL: u16 = 0x4599;

/// The bits of `frame` from the start of frame to the end of frame, stuff bits counted, intermission not.
#[must_use]
pub fn bits(frame: &Frame) -> u32 {
    let stream = Stream::of(frame);
    u32::from(stream.length) + stream.stuff_bits() + TAIL
}

/// As many bits as a frame of `octets` data octets (more than 8 count as 8) can be at most, intermission not counted.
#[must_use]
pub const fn longest(extended: bool, octets: u8) -> u32 {
    let octets = if octets < 8 { octets } else { 8 };
    let stuffed = if extended { 54 } else { 34 } + 8 * octets as u32;
    stuffed + (stuffed - 1) / 4 + TAIL
}

/// The bits of a frame that are stuffed, before they are: the first one highest of the `length` lowest. 118 at most.
#[derive(Clone, Copy)]
struct Stream {
    bits: u128,
    length: u8,
}

impl Stream {
    fn of(frame: &Frame) -> Self {
        let mut stream = Self { bits: 0, length: 0 };
        let remote = u32::from(frame.is_remote());
        match frame.id() {
            // SOF and identifier; RTR, IDE and r0.
            Id::Base(id) => {
                stream.push(u32::from(id.number()), 12);
                stream.push(remote << 2, 3);
            }
            // SOF and the leading bits; SRR and IDE; the other bits; RTR, r1 and r0.
            Id::Extended(id) => {
                stream.push(id.number() >> 18, 12);
                stream.push(0b11, 2);
                stream.push(id.number(), 18);
                stream.push(remote << 2, 3);
            }
        }
        stream.push(u32::from(frame.dlc()), 4);
        if let Content::Data(octets) = frame.content() {
            for octet in octets {
                stream.push(u32::from(*octet), 8);
            }
        }
        stream.push(u32::from(stream.crc()), 15);
        stream
    }

    /// Appends the `count` lowest bits of `value`.
    fn push(&mut self, value: u32, count: u8) {
        self.bits = self.bits << count | u128::from(value) & ((1 << count) - 1);
        self.length += count;
    }

    // Each frame of a bus comes here, in tests without optimisation: loops over a place, not iterators.

    fn bit(self, place: u8) -> u16 {
        u16::from(self.bits >> place & 1 == 1)
    }

    fn crc(self) -> u16 {
        let (mut crc, mut place) = (0, self.length);
        while place > 0 {
            place -= 1;
            let feedback = self.bit(place) ^ (crc >> 14);
            crc = (crc << 1 & 0x7FFF) ^ (feedback * CRC_POLYNOMIAL);
        }
        crc
    }

    fn stuff_bits(self) -> u32 {
        // The first bit equals none before it.
        let (mut last, mut equal, mut stuffed, mut place) = (2, 0, 0, self.length);
        while place > 0 {
            place -= 1;
            let bit = self.bit(place);
            equal = if last == bit { equal + 1 } else { 1 };
            last = bit;
            if equal == 5 {
                stuffed += 1;
                last = 1 - bit;
                equal = 1;
            }
        }
        stuffed
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn base(number: u16) -> Id {
        Id::base(number).unwrap()
    }

    #[test]
    fn a_frame_of_zeros_is_stuffed_after_each_five() {
        // 34 bits 0, the CRC too: six groups of five, four left over.
        let frame = Frame::with(base(0), []);
        assert_eq!(Stream::of(&frame).crc(), 0);
        assert_eq!(bits(&frame), 44 + 6);
        // 118 bits: SOF and 11 bits 0, two bits 1 (SRR, IDE), 18 + 3 + 4 bits 0 and the CRC: by hand only the front.
        let frame = Frame::with(Id::extended(0).unwrap(), []);
        let stream = Stream::of(&frame);
        assert_eq!((stream.length, stream.bits >> 15), (54, 0b11 << 25));
    }

    #[test]
    fn crc_and_stuff_bits_as_worked_out_apart() {
        // By long division of the bits written as text, in another language.
        for (frame, crc, stuff) in [
            (Frame::with(base(0x605), [0x40, 0, 0x10, 0, 0, 0, 0, 0]), 0x3576, 13),
            (Frame::with(base(0x7FF), [0xFF; 8]), 0x4C89, 15),
            (Frame::with(base(0), [0; 8]), 0x145B, 16),
            (Frame::with(base(0x080), []), 0x1C05, 4),
            (Frame::remote(base(0x705), 1).unwrap(), 0x3435, 2),
            (Frame::with(Id::extended(0x1FFF_FFFF).unwrap(), [0xAA, 0x55]), 0x4CBC, 7),
            (Frame::with(Id::extended(0x0605_0000).unwrap(), [0; 8]), 0x1BF4, 18),
            (Frame::remote(Id::extended(1).unwrap(), 8).unwrap(), 0x63C1, 6),
        ] {
            let stream = Stream::of(&frame);
            assert_eq!((stream.bits & 0x7FFF, stream.stuff_bits()), (crc, stuff), "{frame}");
        }
    }

    #[test]
    fn the_longest_frames_take_111_to_135_microseconds_at_a_megabit() {
        assert_eq!(longest(false, 8) + INTERMISSION, 135);
        assert_eq!(44 + 64 + INTERMISSION, 111);
        assert_eq!(longest(true, 8) + INTERMISSION, 64 + 64 + 3 + 29);
        assert_eq!(longest(false, 15), longest(false, 8));
        // A pattern that is stuffed as often as possible up to its CRC: five bits 0, then four of each.
        let frame = Frame::with(base(0x07C), [0x1E; 8]);
        assert!(bits(&frame) <= longest(false, 8));
    }

    proptest! {
        #[test]
        fn a_frame_is_never_shorter_than_its_bits_nor_longer_than_the_longest(
            id in 0_u32..=0x1FFF_FFFF, extended: bool, remote: bool, dlc in 0_u8..=8, octets: [u8; 8]
        ) {
            let id = if extended { Id::extended(id) } else { Id::base(u16::try_from(id & 0x7FF).unwrap()) }.unwrap();
            let frame = if remote {
                Frame::remote(id, dlc)
            } else {
                Frame::data(id, &octets[..usize::from(dlc)])
            }.unwrap();
            let carried = if remote { 0 } else { dlc };
            let least = if extended { 64 } else { 44 } + 8 * u32::from(carried);
            prop_assert!((least..=longest(extended, carried)).contains(&bits(&frame)));
            // The remainder of all bits, the CRC included, is 0.
            prop_assert_eq!(Stream::of(&frame).crc(), 0);
        }
    }
}
