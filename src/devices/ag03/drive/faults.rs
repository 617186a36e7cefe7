//! Faults, their codes, and the fault buffer (manual chapter 5.2, `ag03.md` 10).

#![expect(clippy::use_self, reason = "in what the macro `bitflags` writes")]

use core::fmt;

use enumflags2::{BitFlags, bitflags};

use crate::devices::ag03::param::Model;

/// A fault of the manual's Table 2.
#[bitflags]
#[repr(u16)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Fault {
    /// Supply below 18 V and motor current above 200 mA.
    A,
    /// Shaft blocked: speed below 2 rpm and lag error (`ag03.md` C-10).
    B,
    /// Motor current above 2.4 A for more than 4 s.
    C,
    /// Output stage above 90 degC.
    D,
    /// SIN/COS monitoring of the encoder, AG03/1 only.
    E,
    /// Internal error.
    F,
    /// Intermediate circuit above 35 V.
    G,
    /// The bus makes too many errors while the drive travels. Raised by a bus (`Drive::set_bus_causes`).
    H,
    /// The bus is off. Raised by a bus.
    I,
    /// Battery below 2.2 V, AG03/1 only.
    J,
}

impl Fault {
    /// Every fault that the drive finds itself, in the order of the codes.
    pub const ALL: [Self; 8] = [Self::A, Self::B, Self::C, Self::D, Self::E, Self::F, Self::G, Self::J];

    /// The faults that only a bus raises: on an AG03/1 on CANopen.
    pub const OF_BUS: [Self; 2] = [Self::H, Self::I];

    /// The code in the fault buffer, PNU 945: the letter in ASCII (C-08).
    pub const fn code(self) -> u8 {
        match self {
            Self::A => b'A',
            Self::B => b'B',
            Self::C => b'C',
            Self::D => b'D',
            Self::E => b'E',
            Self::F => b'F',
            Self::G => b'G',
            Self::H => b'H',
            Self::I => b'I',
            Self::J => b'J',
        }
    }

    /// The fault of a code in the fault buffer.
    pub(crate) fn of_code(code: u8) -> Option<Self> {
        FaultSet::all().iter().find(|fault| fault.code() == code)
    }

    /// How often the status LED blinks for it.
    pub const fn blinks(self) -> u8 {
        self.code() - b'A' + 1
    }

    /// Whether `model` knows the fault.
    pub const fn exists_on(self, model: Model) -> bool {
        match (self, model) {
            (Self::E | Self::H | Self::I | Self::J, Model::Ag03) => false,
            (Self::E | Self::H | Self::I | Self::J, Model::Ag03_1)
            | (Self::A | Self::B | Self::C | Self::D | Self::F | Self::G, Model::Ag03 | Model::Ag03_1) => {
                true
            }
        }
    }

    /// The set of this fault if it is `present`, and none otherwise.
    pub(super) fn when(self, present: bool) -> FaultSet {
        if present { self.into() } else { FaultSet::empty() }
    }
}

impl Fault {
    /// What to do about its cause.
    pub(crate) const fn cure(self) -> &'static str {
        match self {
            Self::A => "check the supply voltage under load, it must be 18 V at least",
            Self::B => "free the shaft or reduce the load",
            Self::C => "reduce the load, the speed or the acceleration: more than 2.4 A flowed for 4 s",
            Self::D => "let the drive cool below 90 degC, reduce load or ambient temperature",
            Self::E => "switch it off and on; if it stays, the encoder of the drive is defective",
            Self::F => "switch it off and on; if it stays, the drive is defective",
            Self::G => "reduce the deceleration or the driving load: more than 35 V were fed back",
            Self::H => "check the wiring, the terminators and the bit rate of the bus",
            Self::I => "check the wiring and the bit rate of the bus",
            Self::J => "replace the battery of the encoder",
        }
    }
}

impl fmt::Display for Fault {
    /// Letter and cause: `A (supply voltage too low)`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::A => "A (supply voltage too low)",
            Self::B => "B (shaft blocked)",
            Self::C => "C (motor current too high)",
            Self::D => "D (output stage too hot)",
            Self::E => "E (SIN/COS monitoring)",
            Self::F => "F (internal error)",
            Self::G => "G (intermediate circuit voltage too high)",
            Self::H => "H (too many errors on the bus while travelling)",
            Self::I => "I (bus off)",
            Self::J => "J (battery empty)",
        })
    }
}

/// A set of faults, for example of the fault causes that are present; it goes through them in the order of their codes.
pub type FaultSet = BitFlags<Fault>;

/// The last ten faults and how many there were, PNU 945 and 952.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FaultBuffer {
    codes: [u8; 10],
    count: u16,
}

impl FaultBuffer {
    /// How many faults it keeps.
    pub(crate) const LEN: usize = 10;

    /// The codes, the oldest of those kept first, 0 = unused (the other reading of C-18).
    pub(crate) fn codes_oldest_first(&self) -> [u8; Self::LEN] {
        let mut codes = self.codes;
        let used = codes.iter().position(|&code| code == 0).unwrap_or(Self::LEN);
        if let Some(used) = codes.get_mut(..used) {
            used.reverse();
        }
        codes
    }

    /// A buffer as an EEPROM kept it: codes newest first, 0 = unused, and the counter.
    pub const fn kept(codes: [u8; Self::LEN], count: u16) -> Self {
        Self { codes, count }
    }

    /// The codes, newest first (C-18), 0 = unused.
    pub(crate) const fn codes(&self) -> [u8; Self::LEN] {
        self.codes
    }

    /// How many faults there were since the last clearing, at most 65535.
    pub(crate) const fn count(&self) -> u16 {
        self.count
    }

    /// Enters a fault; the oldest of ten is lost.
    pub(super) fn enter(&mut self, fault: Fault) {
        self.codes.rotate_right(1);
        if let Some(newest) = self.codes.first_mut() {
            *newest = fault.code();
        }
        self.count = self.count.saturating_add(1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_and_blinks_are_those_of_table_2() {
        let table: std::vec::Vec<_> = Fault::ALL.map(|fault| (fault.code(), fault.blinks())).into();
        assert_eq!(
            table,
            [(0x41, 1), (0x42, 2), (0x43, 3), (0x44, 4), (0x45, 5), (0x46, 6), (0x47, 7), (0x4a, 10)]
        );
    }

    #[test]
    fn the_ag03_knows_neither_e_nor_j() {
        for fault in Fault::ALL {
            assert!(fault.exists_on(Model::Ag03_1));
            assert_eq!(fault.exists_on(Model::Ag03), !matches!(fault, Fault::E | Fault::J));
        }
    }

    #[test]
    fn the_buffer_keeps_the_newest_ten_first_and_counts_all() {
        let mut buffer = FaultBuffer::default();
        buffer.enter(Fault::A);
        buffer.enter(Fault::J);
        assert_eq!(buffer.codes(), [0x4a, 0x41, 0, 0, 0, 0, 0, 0, 0, 0]);
        assert_eq!(buffer.codes_oldest_first(), [0x41, 0x4a, 0, 0, 0, 0, 0, 0, 0, 0]);
        for _ in 0..10 {
            buffer.enter(Fault::C);
        }
        assert_eq!((buffer.codes(), buffer.count()), ([0x43; 10], 12));
    }

    #[test]
    fn the_counter_stops_at_its_end() {
        let mut buffer = FaultBuffer { count: u16::MAX, ..FaultBuffer::default() };
        buffer.enter(Fault::B);
        assert_eq!(buffer.count(), u16::MAX);
    }
}
