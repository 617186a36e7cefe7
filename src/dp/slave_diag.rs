//! Slave_Diag (SAP 60): the six octets of the standard diagnosis, ahead of the extended one.
//!
//! ```text
//! octet 1   b0 Station_Non_Existent*  b1 Station_Not_Ready  b2 Cfg_Fault  b3 Ext_Diag  b4 Not_Supported
//!           b5 Invalid_Slave_Response*  b6 Prm_Fault  b7 Master_Lock*
//! octet 2   b0 Prm_Req  b1 Stat_Diag  b2 always 1  b3 WD_On  b4 Freeze_Mode  b5 Sync_Mode  b6 0  b7 Deactivated*
//! octet 3   b7 Ext_Diag_Overflow  b6..b0 0
//! octet 4   Master_Add, 255 = none
//! octet 5,6 Ident_Number, high octet first
//! octet 7.. Ext_Diag_Data, 0..=238 octets, drawn in [`ext_diag`](super::ext_diag)
//! ```
//!
//! Bits marked * are set by masters only. Source: `dp-v0.md` 6.2.

use crate::fdl::Address;

/// Octets of the standard diagnosis.
pub const LEN: usize = 6;

/// Master_Add of a slave without owner.
const NO_MASTER: u8 = 255;

/// The diagnosis of a slave.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Diagnosis {
    /// Not ready for Data_Exchange.
    pub station_not_ready: bool,
    /// The last Chk_Cfg was refused.
    pub cfg_fault: bool,
    /// The extended diagnosis shows a fault.
    pub ext_diag: bool,
    /// The last Set_Prm asked for something the slave cannot do.
    pub not_supported: bool,
    /// The last Set_Prm was refused.
    pub prm_fault: bool,
    /// The slave must be parameterised.
    pub prm_req: bool,
    /// The slave cannot deliver valid data: the master shall go on reading the diagnosis.
    pub stat_diag: bool,
    /// The watchdog is on.
    pub wd_on: bool,
    /// Freeze is active.
    pub freeze_mode: bool,
    /// Sync is active.
    pub sync_mode: bool,
    /// There is more extended diagnosis than fits.
    pub ext_diag_overflow: bool,
    /// The owner.
    pub master: Option<Address>,
    /// The slave's ident number.
    pub ident: u16,
}

impl Diagnosis {
    /// The diagnosis in the octets of an answer, for masters; `None` with fewer than [`LEN`]. The bits that only masters
    /// set are not looked at.
    pub fn parse(octets: &[u8]) -> Option<Self> {
        let [first, second, third, master, ident @ ..] = *octets.first_chunk::<LEN>()?;
        let bit = |octet: u8, bit: u8| octet & 1 << bit != 0;
        Some(Self {
            station_not_ready: bit(first, 1),
            cfg_fault: bit(first, 2),
            ext_diag: bit(first, 3),
            not_supported: bit(first, 4),
            prm_fault: bit(first, 6),
            prm_req: bit(second, 0),
            stat_diag: bit(second, 1),
            wd_on: bit(second, 3),
            freeze_mode: bit(second, 4),
            sync_mode: bit(second, 5),
            ext_diag_overflow: bit(third, 7),
            master: Address::station(master).ok(),
            ident: u16::from_be_bytes(ident),
        })
    }

    /// The octets on the wire.
    pub fn octets(self) -> [u8; LEN] {
        let bit = |set: bool, bit: u8| u8::from(set) << bit;
        let [ident_high, ident_low] = self.ident.to_be_bytes();
        [
            bit(self.station_not_ready, 1)
                | bit(self.cfg_fault, 2)
                | bit(self.ext_diag, 3)
                | bit(self.not_supported, 4)
                | bit(self.prm_fault, 6),
            bit(self.prm_req, 0)
                | bit(self.stat_diag, 1)
                | bit(true, 2)
                | bit(self.wd_on, 3)
                | bit(self.freeze_mode, 4)
                | bit(self.sync_mode, 5),
            bit(self.ext_diag_overflow, 7),
            self.master.map_or(NO_MASTER, Address::number),
            ident_high,
            ident_low,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn d_08_d_09_each_flag_has_its_bit_and_the_masters_bits_stay_zero() {
        let none = Diagnosis { ident: 0x0AC5, ..Diagnosis::default() };
        assert_eq!(none.octets(), [0x00, 0x04, 0, 255, 0x0A, 0xC5]);
        let all = Diagnosis {
            station_not_ready: true,
            cfg_fault: true,
            ext_diag: true,
            not_supported: true,
            prm_fault: true,
            prm_req: true,
            stat_diag: true,
            wd_on: true,
            freeze_mode: true,
            sync_mode: true,
            ext_diag_overflow: true,
            master: Address::station(2).ok(),
            ident: 0x1234,
        };
        assert_eq!(all.octets(), [0x5E, 0x3F, 0x80, 2, 0x12, 0x34]);
        for diagnosis in [none, all] {
            assert_eq!(Diagnosis::parse(&diagnosis.octets()), Some(diagnosis));
        }
        assert_eq!(Diagnosis::parse(&[0xA1, 0x84, 0x7F, 255, 0x0A, 0xC5]), Some(none), "the masters' bits");
        assert_eq!(Diagnosis::parse(&[0x00, 0x04, 0, 255, 0x0A]), None);
    }
}
