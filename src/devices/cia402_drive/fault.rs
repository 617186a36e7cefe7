//! Faults with their error codes, 603Fh.

use core::fmt;

/// A fault: its error code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Fault(pub(crate) u16);

impl Fault {
    pub(super) const OVERLOAD: Self = Self(0x2350);
    pub(super) const NO_VOLTAGE: Self = Self(0x3220);
    /// Guarding or heartbeat; the node reports it itself.
    pub(crate) const CONNECTION: Self = Self(0x8130);
    pub(super) const FOLLOWING: Self = Self(0x8611);
    pub(super) const EXTERNAL: Self = Self(0x9000);

    const ROWS: &[(u16, &'static str)] = &[
        (0x2310, "continuous over-current"),
        (0x2320, "short circuit or earth leakage of the motor"),
        (Self::OVERLOAD.0, "overload of the motor"),
        (0x3210, "DC link over-voltage"),
        (Self::NO_VOLTAGE.0, "DC link under-voltage"),
        (0x4210, "the drive is too hot"),
        (0x4310, "the motor is too hot"),
        (0x5530, "the memory of the drive is faulty"),
        (0x7121, "the motor is blocked"),
        (0x7300, "the encoder is faulty"),
        (Self::CONNECTION.0, "guarding or heartbeat of the master is lost"),
        (Self::FOLLOWING.0, "the following error is beyond its window"),
        (0x8612, "a limit of the position is reached"),
        (Self::EXTERNAL.0, "emergency stop"),
    ];

    /// Each that can be provoked.
    pub(crate) fn all() -> impl Iterator<Item = Self> {
        Self::ROWS.iter().map(|(code, _)| Self(*code))
    }

    /// That of a name: four hexadecimal digits.
    pub(crate) fn named(name: &str) -> Option<Self> {
        let code = u16::from_str_radix(name, 16).ok().filter(|_| name.len() == 4)?;
        Self::all().find(|fault| fault.0 == code)
    }

    /// What it is.
    pub(crate) fn text(self) -> &'static str {
        let row = Self::ROWS.iter().find(|(code, _)| *code == self.0);
        row.map_or("a fault", |(_, text)| text)
    }

    /// Its bit of the error register, 1001h, by the class of its code.
    pub(crate) const fn register(self) -> u8 {
        match self.0 >> 12 {
            2 => 1 << 1,
            3 => 1 << 2,
            4 => 1 << 3,
            8 if self.0 >> 8 == 0x81 => 1 << 4,
            _ => 1 << 5,
        }
    }
}

impl fmt::Display for Fault {
    /// `8611h, the following error is beyond its window`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:04X}h, {}", self.0, self.text())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_is_named_by_its_code() {
        for fault in Fault::all() {
            assert_eq!(Fault::named(&std::format!("{:04X}", fault.0)), Some(fault));
            assert_ne!(fault.text(), "a fault");
        }
        for name in ["", "1234", "8611h", "+861", "08611"] {
            assert_eq!(Fault::named(name), None, "{name}");
        }
        assert_eq!(Fault(0x8130).register(), 0x10);
        assert_eq!(Fault(0x8611).register(), 0x20);
    }
}
