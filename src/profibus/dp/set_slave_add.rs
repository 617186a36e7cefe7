//! Set_Slave_Add (SAP 55): another station address for a slave that waits for parameters.
//!
//! ```text
//! octet 1   New_Slave_Add, 0..=125
//! octet 2,3 Ident_Number, high octet first
//! octet 4   No_Add_Chg: 0 = may be changed again, else not until the hardware is reset
//! octet 5.. Rem_Slave_Data, 0..=240 octets that the slave keeps
//! ```
//!
//! Source: `dp-v0.md` 6.4.

use thiserror::Error;

use crate::profibus::fdl::Address;

/// The most octets of Rem_Slave_Data.
pub(crate) const MAX_REM_SLAVE_DATA: usize = 240;

/// The highest address a slave can be given; 126 is for slaves that wait for one.
const HIGHEST_ADDRESS: u8 = 125;

/// What a slave with Set_Slave_Add keeps over a power cycle. The host stores it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StoredAddress {
    /// The station address.
    pub address: Address,
    /// No_Add_Chg: the address cannot be changed from the bus any more.
    pub no_add_chg: bool,
}

impl StoredAddress {
    /// As the slave is delivered, and after the hardware reset that is all that ends No_Add_Chg: address 126.
    pub const DELIVERED: Self = Self { address: Address::from_octet(126), no_add_chg: false };
}

/// A Set_Slave_Add request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SetSlaveAdd<'a> {
    /// What to store.
    pub stored: StoredAddress,
    /// Rem_Slave_Data.
    pub rem_slave_data: &'a [u8],
}

impl<'a> SetSlaveAdd<'a> {
    /// Reads the octets of a request to a slave with this ident number.
    ///
    /// # Errors
    /// The first fault found. [`AddressFault::Locked`] is the slave's to find.
    pub(crate) fn parse(octets: &'a [u8], ident: u16) -> Result<Self, AddressFault> {
        let length = AddressFault::Length { got: octets.len() };
        let Some((&[address, ident_high, ident_low, no_add_chg], rem_slave_data)) =
            octets.split_first_chunk()
        else {
            return Err(length);
        };
        if rem_slave_data.len() > MAX_REM_SLAVE_DATA {
            return Err(length);
        }
        let got = u16::from_be_bytes([ident_high, ident_low]);
        if got != ident {
            return Err(AddressFault::Ident { expected: ident, got });
        }
        let address = match Address::station(address) {
            Ok(station) if address <= HIGHEST_ADDRESS => station,
            Ok(_) | Err(_) => return Err(AddressFault::Address { got: address }),
        };
        Ok(Self { stored: StoredAddress { address, no_add_chg: no_add_chg != 0 }, rem_slave_data })
    }
}

/// Why Set_Slave_Add changed nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum AddressFault {
    /// Fewer than 4 or more than 244 octets.
    #[error("Set_Slave_Add has {got} octets, expected 4..244")]
    Length {
        /// Octets found.
        got: usize,
    },
    /// Octets 2 and 3 name another device.
    #[error("Set_Slave_Add octets 2-3: ident number 0x{got:04X}, expected 0x{expected:04X}")]
    Ident {
        /// The slave's ident number.
        expected: u16,
        /// The one found.
        got: u16,
    },
    /// Octet 1 is no address for a slave.
    #[error("Set_Slave_Add octet 1: address {got}, expected 0..125")]
    Address {
        /// The number found.
        got: u8,
    },
    /// An earlier request has ruled out changes.
    #[error(
        "the address was locked by No_Add_Chg of an earlier Set_Slave_Add; only a hardware reset unlocks it"
    )]
    Locked,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_octet_of_a_request_is_judged() {
        let rem_slave_data = [0xAA; 241];
        let with = |octets: &[u8]| SetSlaveAdd::parse(octets, 0x1234).map(|request| request.stored);
        for number in 0..=125 {
            let address = Address::station(number).unwrap();
            for (no_add_chg, octet) in [(false, 0x00), (true, 0xFF), (true, 0x01)] {
                assert_eq!(with(&[number, 0x12, 0x34, octet]), Ok(StoredAddress { address, no_add_chg }));
            }
        }
        for got in [126, 127, 128, 255] {
            assert_eq!(with(&[got, 0x12, 0x34, 0]), Err(AddressFault::Address { got }));
        }
        assert_eq!(with(&[7, 0x34, 0x12, 0]), Err(AddressFault::Ident { expected: 0x1234, got: 0x3412 }));
        assert_eq!(with(&[7, 0x12, 0x34]), Err(AddressFault::Length { got: 3 }));
        let most = [&[7, 0x12, 0x34, 0], &rem_slave_data[..240]].concat();
        assert_eq!(SetSlaveAdd::parse(&most, 0x1234).unwrap().rem_slave_data, &rem_slave_data[..240]);
        let more = [&[7, 0x12, 0x34, 0], &rem_slave_data[..]].concat();
        assert_eq!(with(&more), Err(AddressFault::Length { got: 245 }));
    }
}
