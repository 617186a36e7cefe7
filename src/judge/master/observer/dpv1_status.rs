//! Rows V about Set_Prm: the three octets of DPV1_Status and the blocks behind them (`dp-v1.md` 5).

use super::Observer;
use super::cycle::Cycle;
use crate::gsd;
use crate::judge::master::rows::Row;
use crate::judge::master::setup::Slave;
use crate::profibus::dp::dpv1_status::{self, Status1, Status2, Status3};

/// The bits of DPV1_Status that are reserved. Those of Alarm_Mode are none of its flags.
const RESERVED: [u8; dpv1_status::LEN] = [Status1::RESERVED, Status2::RESERVED, Status3::RESERVED & !0x07];

/// The bits of DPV1_Status_2 that enable alarms.
const ALARMS: u8 = !Status2::RESERVED & !Status2::CheckCfgMode.mask();

impl Observer {
    /// The user parameters of a Set_Prm.
    pub(super) fn judge_dpv1_status(&mut self, cycle: &Cycle, slave: &Slave, user: &[u8]) {
        if !slave.has_dpv1_status() {
            return;
        }
        let Some((status, blocks)) = user.split_first_chunk::<{ dpv1_status::LEN }>() else { return };
        let described = slave.gsd.as_deref().cloned();
        let described = described.and_then(|file| gsd::Station::new(file, gsd::Policy::PROPOSED).ok());
        let supported = described.and_then(|station| station.description().dpv1_status);
        let supported = supported.unwrap_or([u8::MAX; dpv1_status::LEN]);
        let wrong = (1..).zip(status).zip(supported.iter().zip(RESERVED)).find_map(
            |((number, octet), (supported, reserved))| {
                let bits = octet & (reserved | !supported);
                (bits != 0).then(|| {
                    let what =
                        if bits & reserved != 0 { "reserved" } else { "not offered in the device file" };
                    format!("DPV1_Status_{number} is 0x{octet:02X}: the bits 0x{bits:02X} are {what}")
                })
            },
        );
        self.verdict_of(cycle, Row::V14, wrong);
        if let Some(file) = &slave.gsd {
            let missing = file
                .acyclic
                .missing(*status)
                .map(|(_, bit)| format!("{bit} is 0 in DPV1_Status; the device file requires it"));
            self.verdict_of(cycle, Row::V15, missing);
            let [_, enables, _] = *status;
            let needless = enables & ALARMS & !file.acyclic.alarms;
            let reason = (needless != 0).then(|| {
                format!("DPV1_Status_2 is 0x{enables:02X}: alarms 0x{needless:02X} are not offered in the device file")
            });
            self.verdict_of(cycle, Row::V16, reason);
        }
        let [.., structure] = *status;
        if Status3::PrmStructure.is_set(structure) {
            let wrong = dpv1_status::first_wrong_block(blocks);
            let reason = wrong.map(|at| {
                format!(
                    "the block at octet {at} behind DPV1_Status has a length that does not end with Set_Prm"
                )
            });
            self.verdict_of(cycle, Row::V17, reason);
        }
    }
}
