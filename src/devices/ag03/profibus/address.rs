//! The station address that the DIP switches show (manual chapter 7.8).

use crate::devices::ag03::unit::DipSwitches;
use crate::profibus::fdl::Address;

impl DipSwitches {
    /// The station address of SW1 to SW7: 127 acts as 126 (manual chapter 7.8).
    pub(crate) const fn address(self) -> Address {
        match self.number() {
            127 => Address::from_octet(126),
            number => Address::from_octet(number),
        }
    }
}

impl From<Address> for DipSwitches {
    /// SW1 to SW7 at this address, the others OFF.
    fn from(address: Address) -> Self {
        Self::from_bits(address.number().into())
    }
}

#[cfg(test)]
mod tests {

    use super::*;

    #[test]
    fn the_address_table_of_manual_7_8() {
        for (switches, address) in [
            ("0000000 0 00", 0),
            ("1000000 0 00", 1),
            ("0100000 0 00", 2),
            ("1100000 0 00", 3),
            ("0011111 0 00", 124),
            ("1011111 0 00", 125),
            ("0111111 0 00", 126),
            ("1111111 0 00", 126),
        ] {
            let bits = switches
                .chars()
                .filter(|c| *c != ' ')
                .rev()
                .fold(0, |bits, c| bits << 1 | u16::from(c == '1'));
            let positions = DipSwitches::from_bits(bits);
            assert_eq!(positions.to_string(), switches);
            assert_eq!(positions.address().number(), address, "{switches}");
            assert_eq!(positions.with_reset(true).with_terminator(true).address().number(), address);
        }
        for number in 0..=126 {
            let address = Address::station(number).unwrap();
            assert_eq!(DipSwitches::from(address).address(), address);
        }
        assert_eq!(DipSwitches::from_bits(u16::MAX).to_string(), "1111111 1 11");
    }
}
