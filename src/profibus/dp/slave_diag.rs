//! Slave_Diag (SAP 60): the six octets of the standard diagnosis, ahead of the extended one.
//!
//! ```text
//! octet 1..3  the bits of [`DiagBit`]; the others are 0
//! octet 4     Master_Add, 255 = none
//! octet 5,6   Ident_Number, high octet first
//! octet 7..   Ext_Diag_Data, 0..=238 octets, drawn in [`ext_diag`](super::ext_diag)
//! ```
//!
//! Source: EN 50170 part 8 at second hand (`docs/reference/dp-v0.md` 6.2).

use super::diag_bit::DiagBit;
use crate::profibus::fdl::Address;

/// Octets of the standard diagnosis.
pub(crate) const LEN: usize = 6;

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
    /// The diagnosis in the octets of an answer, for masters; `None` with fewer than `LEN`. The bits that only masters
    /// set are not looked at.
    pub fn parse(octets: &[u8]) -> Option<Self> {
        let [_, _, _, master, ident @ ..] = *octets.first_chunk::<LEN>()?;
        Some(Self {
            station_not_ready: DiagBit::StationNotReady.is_set(octets),
            cfg_fault: DiagBit::CfgFault.is_set(octets),
            ext_diag: DiagBit::ExtDiag.is_set(octets),
            not_supported: DiagBit::NotSupported.is_set(octets),
            prm_fault: DiagBit::PrmFault.is_set(octets),
            prm_req: DiagBit::PrmReq.is_set(octets),
            stat_diag: DiagBit::StatDiag.is_set(octets),
            wd_on: DiagBit::WdOn.is_set(octets),
            freeze_mode: DiagBit::FreezeMode.is_set(octets),
            sync_mode: DiagBit::SyncMode.is_set(octets),
            ext_diag_overflow: DiagBit::ExtDiagOverflow.is_set(octets),
            master: Address::station(master).ok(),
            ident: u16::from_be_bytes(ident),
        })
    }

    /// The octets on the wire.
    pub fn octets(self) -> [u8; LEN] {
        let bit = |set: bool, bit: DiagBit| u8::from(set) << bit.number();
        let [ident_high, ident_low] = self.ident.to_be_bytes();
        [
            bit(self.station_not_ready, DiagBit::StationNotReady)
                | bit(self.cfg_fault, DiagBit::CfgFault)
                | bit(self.ext_diag, DiagBit::ExtDiag)
                | bit(self.not_supported, DiagBit::NotSupported)
                | bit(self.prm_fault, DiagBit::PrmFault),
            bit(self.prm_req, DiagBit::PrmReq)
                | bit(self.stat_diag, DiagBit::StatDiag)
                | bit(true, DiagBit::Always1)
                | bit(self.wd_on, DiagBit::WdOn)
                | bit(self.freeze_mode, DiagBit::FreezeMode)
                | bit(self.sync_mode, DiagBit::SyncMode),
            bit(self.ext_diag_overflow, DiagBit::ExtDiagOverflow),
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
