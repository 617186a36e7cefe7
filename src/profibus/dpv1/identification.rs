//! Identification and maintenance (I&M): what a device says of itself in record 255, 64 octets a block.
//!
//! ```text
//! call   08 00 IM(2)            written: ask for a block, which is read behind it; or with 64 octets: write it
//! I&M0   header(10) manufacturer(2) order(20) serial(16) hardware(2) software(4) counter(2) profile(2) type(2)
//!        version(2) supported(2)
//! I&M1   header(10) function(32) location(22)
//! I&M2   header(10) date(16) reserved(38)
//! I&M3   header(10) descriptor(54)
//! I&M4   header(10) signature(54)
//! ```
//!
//! Source: `dp-v1.md` 7.

use core::fmt::{self, Write as _};

/// Octets of a block.
pub const LEN: usize = 64;

/// Octets of the header of a call.
pub(super) const CALL_LEN: usize = 4;

/// The number of I&M0.
pub(super) const FIRST: u16 = 65000;

/// The function of a call, its first octet.
const CALL: u8 = 0x08;

const HEADER: usize = 10;

/// A call of a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Call {
    /// Which block: 0 for I&M0.
    pub(super) block: u16,
}

/// What the octets of a written record 255 are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Written<'a> {
    /// A block is asked for.
    Ask(Call),
    /// A block is written.
    Write(Call, &'a [u8; LEN]),
    /// Another function than a call.
    OtherFunction,
    /// A number that is none of I&M.
    NoBlock,
    /// Neither 4 octets nor 68.
    Length,
}

/// The block of a number of I&M, 0 for I&M0.
pub(super) const fn block(number: u16) -> u16 {
    number.saturating_sub(FIRST)
}

impl Call {
    pub(super) const fn octets(self) -> [u8; CALL_LEN] {
        let [high, low] = FIRST.wrapping_add(self.block).to_be_bytes();
        [CALL, 0, high, low]
    }

    pub(super) fn parse(octets: &[u8]) -> Written<'_> {
        let [function, _, high, low, ref rest @ ..] = *octets else { return Written::Length };
        if function != CALL {
            return Written::OtherFunction;
        }
        let Some(block @ 0..=199) = u16::from_be_bytes([high, low]).checked_sub(FIRST) else {
            return Written::NoBlock;
        };
        match <&[u8; LEN]>::try_from(rest) {
            Ok(data) => Written::Write(Self { block }, data),
            Err(_) if rest.is_empty() => Written::Ask(Self { block }),
            Err(_) => Written::Length,
        }
    }
}

/// I&M0: what the device is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Identification {
    /// Who made it: the number that the organisation of PROFIBUS gives.
    pub manufacturer_id: u16,
    /// The order number.
    pub order_id: Text<20>,
    /// The serial number.
    pub serial_number: Text<16>,
    /// The version of the hardware.
    pub hardware_revision: u16,
    /// The version of the software.
    pub software_revision: Revision,
    /// How often its parameters were changed.
    pub revision_counter: u16,
    /// The profile, F600h: none.
    pub profile_id: u16,
    /// What the profile says of it.
    pub profile_specific_type: u16,
    /// Which of I&M1 to I&M4 there are, bit n for I&Mn.
    pub supported: u16,
}

/// `V1.2.3`
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Revision {
    /// V, R, P, U or T.
    pub letter: u8,
    /// The three numbers.
    pub numbers: [u8; 3],
}

/// IM_VERSION 1.1.
const VERSION: u16 = 0x0101;

impl Identification {
    /// A device without profile and without a number of its maker.
    pub const PLAIN: Self = Self {
        manufacturer_id: 0,
        order_id: Text::EMPTY,
        serial_number: Text::EMPTY,
        hardware_revision: 0,
        software_revision: Revision { letter: b'V', numbers: [0; 3] },
        revision_counter: 0,
        profile_id: 0xF600,
        profile_specific_type: 0,
        supported: 0,
    };

    /// The 64 octets, with a header of blanks.
    pub fn octets(&self) -> [u8; LEN] {
        let mut octets = [b' '; LEN];
        let parts: [&[u8]; 11] = [
            &self.manufacturer_id.to_be_bytes(),
            &self.order_id.0,
            &self.serial_number.0,
            &self.hardware_revision.to_be_bytes(),
            &[self.software_revision.letter],
            &self.software_revision.numbers,
            &self.revision_counter.to_be_bytes(),
            &self.profile_id.to_be_bytes(),
            &self.profile_specific_type.to_be_bytes(),
            &VERSION.to_be_bytes(),
            &self.supported.to_be_bytes(),
        ];
        let octets_behind = octets.iter_mut().skip(HEADER);
        for (place, octet) in octets_behind.zip(parts.into_iter().flatten()) {
            *place = *octet;
        }
        octets
    }

    /// What 64 octets say.
    pub fn parse(octets: &[u8; LEN]) -> Option<Self> {
        let mut at = HEADER;
        let mut word = |skip: usize| {
            let value =
                octets.get(at..).and_then(<[u8]>::first_chunk).map(|octets| u16::from_be_bytes(*octets));
            at += skip;
            value
        };
        let manufacturer_id = word(2 + 20 + 16)?;
        let hardware_revision = word(2 + 4)?;
        let revision_counter = word(2)?;
        let profile_id = word(2)?;
        let profile_specific_type = word(4)?;
        let supported = word(2)?;
        let software = *octets.get(50..).and_then(<[u8]>::first_chunk::<4>)?;
        let [letter, numbers @ ..] = software;
        Some(Self {
            manufacturer_id,
            order_id: Text(*octets.get(12..).and_then(<[u8]>::first_chunk)?),
            serial_number: Text(*octets.get(32..).and_then(<[u8]>::first_chunk)?),
            hardware_revision,
            software_revision: Revision { letter, numbers },
            revision_counter,
            profile_id,
            profile_specific_type,
            supported,
        })
    }
}

impl fmt::Display for Identification {
    /// `order 6ES7 000-0AA00, serial number S 1, manufacturer 42, hardware 1, software V1.2.3, profile F600h`
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Revision { letter, numbers: [major, minor, patch] } = self.software_revision;
        write!(
            f,
            "order {}, serial number {}, manufacturer {}, hardware {}, software {}{major}.{minor}.{patch}, profile {:04X}h",
            self.order_id,
            self.serial_number,
            self.manufacturer_id,
            self.hardware_revision,
            char::from(letter),
            self.profile_id
        )
    }
}

impl<const N: usize> fmt::Display for Text<N> {
    /// Without the blanks at its end, `?` for what is no letter; `-` if nothing is left.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let len = self
            .0
            .iter()
            .rposition(|octet| !matches!(octet, b' ' | 0))
            .map_or(0, |last| last.saturating_add(1));
        let text = self.0.get(..len).unwrap_or_default();
        if text.is_empty() {
            return f.write_str("-");
        }
        text.iter().try_for_each(|octet| match octet {
            0x20..=0x7E => f.write_char(char::from(*octet)),
            0..=0x1F | 0x7F.. => f.write_char('?'),
        })
    }
}

/// A text of fixed length, filled with blanks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Text<const N: usize>([u8; N]);

impl<const N: usize> Text<N> {
    /// No text.
    pub const EMPTY: Self = Self([b' '; N]);

    /// As much of a text as fits.
    pub fn of(text: &str) -> Self {
        let mut octets = [b' '; N];
        for (place, octet) in octets.iter_mut().zip(text.bytes()) {
            *place = octet;
        }
        Self(octets)
    }

    /// Its octets.
    pub const fn octets(&self) -> &[u8; N] {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn i_and_m_0_has_each_field_where_the_reference_says() {
        let identification = Identification {
            manufacturer_id: 42,
            order_id: Text::of("6ES7 000-0AA00"),
            serial_number: Text::of("S 1"),
            hardware_revision: 1,
            software_revision: Revision { letter: b'V', numbers: [1, 2, 3] },
            revision_counter: 7,
            profile_id: 0x3A00,
            profile_specific_type: 5,
            supported: 0b1110,
        };
        let octets = identification.octets();
        for (at, expected) in [
            (0, &b"          "[..]),
            (10, &[0, 42]),
            (12, b"6ES7 000-0AA00      "),
            (32, b"S 1             "),
            (48, &[0, 1]),
            (50, b"V\x01\x02\x03"),
            (54, &[0, 7]),
            (56, &[0x3A, 0]),
            (58, &[0, 5]),
            (60, &[1, 1]),
            (62, &[0, 0b1110]),
        ] {
            assert_eq!(&octets[at..at + expected.len()], expected, "octet {at}");
        }
        assert_eq!(Identification::parse(&octets), Some(identification));
        let words = "order 6ES7 000-0AA00, serial number S 1, manufacturer 42, hardware 1, software V1.2.3, profile 3A00h";
        assert_eq!(std::format!("{identification}"), words);
        assert_eq!(std::format!("{}", Text::<4>::EMPTY), "-");
    }

    #[test]
    fn a_call_asks_or_writes() {
        assert_eq!(Call::parse(&[8, 0, 0xFD, 0xE8]), Written::Ask(Call { block: 0 }));
        let mut octets = [0; 68];
        octets[..4].copy_from_slice(&Call { block: 4 }.octets());
        assert_eq!(octets[..4], [8, 0, 0xFD, 0xEC]);
        assert_eq!(Call::parse(&octets), Written::Write(Call { block: 4 }, &[0; 64]));
        assert_eq!(Call::parse(&octets[..67]), Written::Length);
        assert_eq!(Call::parse(&[8, 0, 0xFD]), Written::Length);
        assert_eq!(Call::parse(&[8, 0, 0, 0]), Written::NoBlock);
        assert_eq!(Call::parse(&[7, 0, 0xFD, 0xE8]), Written::OtherFunction);
    }

    proptest! {
        #[test]
        fn a_call_of_whatever_octets_is_read(octets in proptest::collection::vec(any::<u8>(), 0..70)) {
            if let Written::Ask(call) | Written::Write(call, _) = Call::parse(&octets) {
                prop_assert_eq!(&call.octets()[2..], &octets[2..4]);
            }
        }

        #[test]
        fn what_a_block_says_is_written_back(octets in proptest::collection::vec(any::<u8>(), 64..=64)) {
            let octets: [u8; LEN] = octets.try_into().unwrap();
            let parsed = Identification::parse(&octets).unwrap();
            prop_assert_eq!(Identification::parse(&parsed.octets()), Some(parsed));
        }
    }
}
