//! Faults with their buffer (PNU 944, 945, 947, 952) and warnings (PNU 953 to 960).
//!
//! ```text
//! sub-index   1 .. 8    the faults that are not acknowledged, the first one first
//!             9 .. 16   those acknowledged last
//!            17 .. 24   those before, and so on to 64
//! ```

use core::fmt;

/// Why a drive is in fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// Data_Exchange ended while the drive was switched on.
    Communication,
    /// The torque was at its limit for too long.
    Overload,
    /// Raised on purpose, with this number.
    Raised(u16),
}

impl Fault {
    /// The number in the buffer. Numbers are a matter of each manufacturer; these two are of this crate.
    pub(crate) const fn number(self) -> u16 {
        match self {
            Self::Communication => 1,
            Self::Overload => 2,
            Self::Raised(number) => number,
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let number = self.number();
        match self {
            Self::Communication => write!(f, "{number}: the master is gone while the drive is switched on"),
            Self::Overload => write!(f, "{number}: overload, the torque was at its limit for too long"),
            Self::Raised(_) => write!(f, "{number}: raised on purpose"),
        }
    }
}

/// Faults of one occasion.
const SLOTS: usize = 8;
/// Occasions kept: the present one and seven before.
const OCCASIONS: usize = 8;

/// What a fault buffer notes of a fault; the default is none.
pub trait Noted: Copy + Default {
    /// The number of the fault, 0: none.
    fn number(&self) -> u16;
}

impl Noted for u16 {
    fn number(&self) -> u16 {
        *self
    }
}

/// The fault buffer: eight occasions of eight faults. Of each fault its number, or more.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FaultBuffer<F = u16> {
    occasions: [[F; SLOTS]; OCCASIONS],
    /// Changes of the buffer (PNU 944).
    messages: u16,
    /// Occasions (PNU 952).
    count: u16,
}

impl FaultBuffer {
    /// Elements of PNU 945 and 947.
    pub(crate) const LEN: u8 = 64;

    /// The number at a sub-index from 1 to 64; `None` outside.
    pub fn number(&self, subindex: u8) -> Option<u16> {
        self.noted(subindex.checked_sub(1)?)
    }
}

impl<F: Noted> FaultBuffer<F> {
    /// What is noted at a place from 0 to 63; `None` outside.
    pub(crate) fn noted(&self, place: u8) -> Option<F> {
        let at = usize::from(place);
        self.occasions.get(at / SLOTS)?.get(at % SLOTS).copied()
    }

    /// How often something came into the buffer or was acknowledged (PNU 944).
    pub(crate) const fn messages(&self) -> u16 {
        self.messages
    }

    /// How many occasions there were (PNU 952).
    pub(crate) const fn count(&self) -> u16 {
        self.count
    }

    /// Another fault of the present occasion. One that is there, or the ninth, is not noted again.
    pub(crate) fn note(&mut self, fault: F) {
        let [present, ..] = &mut self.occasions;
        if present.iter().any(|noted| noted.number() == fault.number()) {
            return;
        }
        if let Some(place) = present.iter().position(|slot| slot.number() == 0) {
            if place == 0 {
                self.count = self.count.saturating_add(1);
            }
            present.iter_mut().skip(place).take(1).for_each(|slot| *slot = fault);
            self.messages = self.messages.wrapping_add(1);
        }
    }

    /// The present occasion is over.
    pub(crate) fn acknowledge(&mut self) {
        self.occasions.rotate_right(1);
        let [present, ..] = &mut self.occasions;
        *present = Default::default();
        self.messages = self.messages.wrapping_add(1);
    }

    /// Forgets what was acknowledged (0 is written to PNU 952).
    pub(crate) fn clear(&mut self) {
        let [_, acknowledged @ ..] = &mut self.occasions;
        *acknowledged = Default::default();
        let [present, ..] = &self.occasions;
        self.count = u16::from(present.iter().any(|fault| fault.number() != 0));
        self.messages = self.messages.wrapping_add(1);
    }
}

/// The last eight warnings, the newest first; 0 is none.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Warnings {
    last: [u16; 8],
    /// The torque is at its limit.
    pub(super) overload: bool,
    /// Raised on purpose; 0: none.
    pub(super) raised: u16,
}

impl Warnings {
    /// The number of the warning that the torque is at its limit.
    pub(crate) const OVERLOAD: u16 = 2;

    /// Whether one stands now (ZSW bit 7).
    pub(crate) const fn is_present(&self) -> bool {
        self.overload || self.raised != 0
    }

    /// The number of the last (0) to the eighth-last (7) warning; `None` outside.
    pub(crate) fn number(&self, before: u8) -> Option<u16> {
        self.last.get(usize::from(before)).copied()
    }

    pub(super) fn note(&mut self, number: u16) {
        self.last.rotate_right(1);
        let [first, ..] = &mut self.last;
        *first = number;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_acknowledged_occasion_moves_eight_places() {
        let mut buffer = FaultBuffer::default();
        buffer.note(7);
        buffer.note(9);
        buffer.note(7);
        assert_eq!((buffer.number(1), buffer.number(2), buffer.number(3)), (Some(7), Some(9), Some(0)));
        assert_eq!((buffer.messages(), buffer.count()), (2, 1));
        buffer.acknowledge();
        assert_eq!((buffer.number(1), buffer.number(9), buffer.number(10)), (Some(0), Some(7), Some(9)));
        buffer.note(3);
        buffer.acknowledge();
        assert_eq!((buffer.number(9), buffer.number(17)), (Some(3), Some(7)));
        assert_eq!((buffer.number(0), buffer.number(64), buffer.number(65)), (None, Some(0), None));
        buffer.clear();
        assert_eq!((buffer.number(9), buffer.count()), (Some(0), 0));
        (1..=10).for_each(|number| buffer.note(number));
        assert_eq!((buffer.number(8), buffer.number(9)), (Some(8), Some(0)));
    }
}
