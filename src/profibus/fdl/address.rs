//! Station addresses and service access points.

use core::fmt;

use thiserror::Error;

/// A station address, 0..=127; 127 means every station.
///
/// 126 is the delivery default of stations that wait for Set_Slave_Add (`dp-v0.md` 2.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Address(u8);

impl Address {
    /// Every station on the bus: broadcast and multicast. Nobody replies to it.
    pub const BROADCAST: Self = Self(127);

    /// The address of one station, 0..=126.
    ///
    /// # Errors
    /// [`AddressError`] for 127 and more.
    pub const fn station(number: u8) -> Result<Self, AddressError> {
        if number < Self::BROADCAST.0 { Ok(Self(number)) } else { Err(AddressError { got: number }) }
    }

    /// The addresses of two stations, 0..=126 each, as the octets of a token hold them; `None` if one of them is none.
    ///
    /// Both at once: an octet that is none has bit 7 set, or has it when 1 is added. Only 255 carries into the other one,
    /// and is none itself. The octets are not taken apart before: compilers then read and write them as one number.
    #[inline(always)]
    pub(super) const fn stations(octets: [u8; 2]) -> Option<[Self; 2]> {
        const ONE_EACH: u16 = 0x0101;
        let more = u16::from_le_bytes(octets).wrapping_add(ONE_EACH);
        let both = more.wrapping_sub(ONE_EACH);
        if (more | both) & 0x8080 != 0 {
            return None;
        }
        let [one, other] = both.to_le_bytes();
        Some([Self(one), Self(other)])
    }

    /// The address in the low seven bits of a DA or SA octet; bit 7 is not part of it.
    pub const fn from_octet(octet: u8) -> Self {
        Self(octet & 0x7F)
    }

    /// The number, 0..=127.
    pub const fn number(self) -> u8 {
        self.0
    }

    /// Whether this is [`Address::BROADCAST`].
    pub(crate) const fn is_broadcast(self) -> bool {
        self.0 == Self::BROADCAST.0
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// A number that cannot be the address of one station.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("station address {got} is outside 0..126")]
pub struct AddressError {
    /// The number found.
    pub got: u8,
}

/// A service access point, 0..=63.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[doc(alias = "LSAP")]
pub struct Sap(u8);

impl Sap {
    /// The SAP `number`, or `None` above 63.
    pub const fn new(number: u8) -> Option<Self> {
        if number < 64 { Some(Self(number)) } else { None }
    }

    /// The number, 0..=63.
    pub const fn number(self) -> u8 {
        self.0
    }
}

impl fmt::Display for Sap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_station_has_an_address_below_127() {
        assert_eq!(Address::station(126).map(Address::number), Ok(126));
        assert_eq!(Address::station(127), Err(AddressError { got: 127 }));
        assert_eq!(Address::from_octet(0xFF), Address::BROADCAST);
        assert_eq!(Address::from_octet(0x85).number(), 5);
    }

    #[test]
    fn two_octets_are_judged_as_each_alone() {
        for octets in (0..=u16::MAX).map(u16::to_be_bytes) {
            let [one, other] = octets.map(Address::station);
            assert_eq!(Address::stations(octets), one.ok().zip(other.ok()).map(<[_; 2]>::from), "{octets:?}");
        }
    }

    #[test]
    fn a_sap_has_six_bits() {
        assert_eq!(Sap::new(63).map(Sap::number), Some(63));
        assert_eq!(Sap::new(64), None);
    }
}
