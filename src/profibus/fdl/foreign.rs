//! Octets of other protocols on RS-485, by their check: whoever listens at the wrong line is told what he hears.

use core::fmt;

use super::{Address, DataTelegram, Sap};

/// A protocol that is not PROFIBUS.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Foreign {
    /// Modbus RTU: address, function, data, CRC.
    ModbusRtu {
        /// The station that is asked or answers.
        station: u8,
        /// The function.
        function: u8,
    },
    /// Modbus ASCII: colon, hexadecimal digits, LRC.
    ModbusAscii,
    /// USS: STX, LGE, ADR, data, BCC.
    Uss {
        /// The drive.
        station: u8,
    },
    /// Characters that somebody can read.
    Text,
    /// Telegrams of PROFIBUS whose services are not those of DP.
    NotDp {
        /// Who asks.
        master: Address,
        /// A service access point that it asks.
        sap: Sap,
    },
}

/// Octets of text that are no chance.
const SHORTEST_TEXT: usize = 5;

/// The same in the middle of others.
const LONG_TEXT: usize = 24;

/// The source service access point of masters of class 2. The points from there on are those of DP.
const MSAC2: u8 = 50;

impl Foreign {
    /// What the octets begin with; `None`: nothing that is known.
    pub(crate) fn of(octets: &[u8]) -> Option<Self> {
        modbus_rtu(octets).or_else(|| uss(octets)).or_else(|| text(octets))
    }

    /// What is heard where no telegrams are, wherever its frames begin in the octets: two of them at least, so that it is no
    /// chance.
    pub(crate) fn in_noise(octets: &[u8]) -> Option<Self> {
        let (mut first, mut rest) = (None, octets);
        while !rest.is_empty() {
            let (found, len) = match framed(rest) {
                Some((found, len)) => (Some(found), len),
                None => (None, 1),
            };
            match (first, found) {
                (None, found) => first = found,
                (Some(_), Some(_)) => return first,
                (Some(_), None) => {}
            }
            rest = rest.get(len..).unwrap_or_default();
        }
        let is_text = |octet: &&u8| matches!(octet, b' '..=b'~' | b'\r' | b'\n' | b'\t');
        let readable = octets.iter().filter(is_text).count();
        (octets.len() >= LONG_TEXT && readable * 20 >= octets.len() * 19).then_some(Self::Text)
    }

    /// Of a request at a service access point that neither DP nor DP-V1 has.
    pub(crate) fn of_request(request: &DataTelegram<'_>) -> Option<Self> {
        let sap = request.dsap.filter(|sap| !(MSAC2..=63).contains(&sap.number()))?;
        let is_of_dpv1 = request.ssap.is_some_and(|ssap| ssap.number() == MSAC2);
        (!is_of_dpv1).then_some(Self::NotDp { master: request.sa, sap })
    }

    /// What to connect instead.
    pub(crate) const fn cure(&self) -> &'static str {
        match self {
            Self::ModbusRtu { .. } | Self::ModbusAscii | Self::Uss { .. } | Self::Text => {
                "connect the master of PROFIBUS DP"
            }
            Self::NotDp { .. } => "connect the interface of the PLC that is set to DP master",
        }
    }

    /// What the octets are as a whole, and no words of a PPO.
    pub(crate) fn is_all(octets: &[u8]) -> bool {
        modbus_rtu(octets).is_some() && is_frame(octets)
    }
}

/// ```text
/// 0 station 0..247   1 function   2.. data   last two: CRC, low octet first
/// ```
fn modbus_rtu(octets: &[u8]) -> Option<Foreign> {
    let &[station @ 0..=247, function, ..] = octets else { return None };
    // Functions that are in use; bit 7 is an exception.
    if !matches!(function & 0x7F, 1..=8 | 11 | 12 | 15..=17 | 20..=24 | 43) {
        return None;
    }
    let ends = 4..=octets.len().min(256);
    let found = ends.into_iter().any(|end| octets.get(..end).is_some_and(is_frame));
    found.then_some(Foreign::ModbusRtu { station, function })
}

/// A frame that the octets begin with, and its length: one whose length its first octets say.
fn framed(octets: &[u8]) -> Option<(Foreign, usize)> {
    if let Some(uss) = uss(octets) {
        return Some((uss, usize::from(*octets.get(1)?) + 2));
    }
    let &[station @ 1..=247, function, third, ..] = octets else { return None };
    let counted = octets.get(6).map_or(0, |count| usize::from(*count) + 9);
    let lengths = match function {
        1..=4 => [8, usize::from(third) + 5],
        5 | 6 => [8, 8],
        15 | 16 => [8, counted],
        0x81..=0x86 | 0x8F | 0x90 => [5, 5],
        _ => return None,
    };
    let len = lengths.into_iter().find(|len| octets.get(..*len).is_some_and(is_frame))?;
    Some((Foreign::ModbusRtu { station, function }, len))
}

/// Whether the CRC behind the octets is theirs: with it the CRC is 0.
fn is_frame(octets: &[u8]) -> bool {
    octets.iter().fold(0xFFFF, |crc, octet| crc16(crc ^ u16::from(*octet))) == 0
}

/// Eight steps of the polynomial A001h.
fn crc16(crc: u16) -> u16 {
    (0..8).fold(crc, |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0xA001 } else { crc >> 1 })
}

/// ```text
/// 0 STX 02   1 LGE: octets behind it   2 ADR   3.. data   LGE+1 BCC: all octets before it by exclusive or
/// ```
fn uss(octets: &[u8]) -> Option<Foreign> {
    let &[0x02, length @ 3..=254, address, ..] = octets else { return None };
    let whole = octets.get(..usize::from(length) + 2)?;
    let sum = whole.iter().fold(0, |sum, octet| sum ^ octet);
    (sum == 0).then_some(Foreign::Uss { station: address & 0x1F })
}

fn text(octets: &[u8]) -> Option<Foreign> {
    let is_text = |octet: &u8| matches!(octet, b' '..=b'~' | b'\r' | b'\n' | b'\t');
    if octets.len() < SHORTEST_TEXT || !octets.iter().all(is_text) {
        return None;
    }
    let is_digit = |octet: &u8| matches!(octet, b'0'..=b'9' | b'A'..=b'F');
    Some(match octets {
        [b':', digits @ .., b'\r', b'\n'] if digits.iter().all(is_digit) => Foreign::ModbusAscii,
        [..] => Foreign::Text,
    })
}

impl fmt::Display for Foreign {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ModbusRtu { station, function } => write!(
                f,
                "this is Modbus RTU, not PROFIBUS: station {station}, function {function:02X}h, and the CRC is right"
            ),
            Self::ModbusAscii => f.write_str("this is Modbus ASCII, not PROFIBUS"),
            Self::Uss { station } => write!(
                f,
                "this is the USS protocol, not PROFIBUS: STX, drive {station}, and the block check is right; set the drive to \
                 PROFIBUS DP"
            ),
            Self::Text => f.write_str("this is text, not PROFIBUS"),
            Self::NotDp { master, sap } => write!(
                f,
                "master {master} speaks PROFIBUS, but not DP (it asks SAP {sap}): MPI, FMS or another protocol"
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn of(octets: &[u8]) -> Option<std::string::String> {
        Foreign::of(octets).map(|foreign| std::string::ToString::to_string(&foreign))
    }

    /// A request for ten registers, its answer begins like it.
    const MODBUS: [u8; 8] = [0x01, 0x03, 0, 0, 0, 0x0A, 0xC5, 0xCD];

    #[test]
    fn protocols_are_known_by_their_check() {
        let said = of(&MODBUS).unwrap();
        assert_eq!(said, "this is Modbus RTU, not PROFIBUS: station 1, function 03h, and the CRC is right");
        assert!(Foreign::is_all(&MODBUS));
        let two = [MODBUS, MODBUS].concat();
        assert_eq!(of(&two), Some(said));
        let uss = [0x02, 0x0E, 0x05, 0x13, 0xE9, 0, 0, 0, 0, 0, 0, 0x04, 0x7E, 0, 0, 0x89];
        let check = uss.iter().fold(0, |sum, octet| sum ^ octet);
        let uss: std::vec::Vec<u8> = uss.into_iter().take(15).chain([0x89 ^ check]).collect();
        assert!(of(&uss).unwrap().contains("USS protocol, not PROFIBUS: STX, drive 5"));
        assert_eq!(of(b":010300000001FB\r\n").unwrap(), "this is Modbus ASCII, not PROFIBUS");
        assert_eq!(of(b"Hello world\r\n").unwrap(), "this is text, not PROFIBUS");
    }

    #[test]
    fn every_single_bit_error_and_every_prefix_is_nothing_known() {
        for bit in 0..MODBUS.len() * 8 {
            let mut wrong = MODBUS;
            wrong[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(Foreign::of(&wrong), None, "{wrong:02X?}");
        }
        for len in 0..MODBUS.len() {
            assert_eq!(Foreign::of(&MODBUS[..len]), None);
        }
    }

    #[test]
    fn in_noise_two_frames_or_much_text_are_known() {
        let noise = |octets: &[u8]| {
            Foreign::in_noise(octets).map(|foreign| std::string::ToString::to_string(&foreign))
        };
        assert_eq!(noise(&MODBUS), None, "one may be chance");
        let two = [&[0x77][..], &MODBUS, &[0x00, 0x33], &MODBUS].concat();
        assert!(noise(&two).unwrap().contains("Modbus RTU, not PROFIBUS: station 1"));
        assert!(noise(b"\x80Temperature 21.5 C, humidity 40 %\r\n").unwrap().contains("text"));
        let mut state = 1_u64;
        let mut octet = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let [octet, ..] = state.to_be_bytes();
            octet
        };
        for _ in 0..500 {
            let octets: std::vec::Vec<u8> = (0..512).map(|_| octet()).collect();
            assert_eq!(Foreign::in_noise(&octets), None);
        }
    }

    proptest! {
        #[test]
        fn any_octets_are_looked_at(octets in proptest::collection::vec(any::<u8>(), 0..600)) {
            let _ = of(&octets);
        }
    }
}
