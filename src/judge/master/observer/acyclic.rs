//! Rows V: what a master asks of a slave by the services of DP-V1 (`dp-v1.md` 1 to 4).

use super::Observer;
use super::cycle::Cycle;
use crate::explain::hex;
use crate::judge::master::findings::Weight;
use crate::judge::master::rows::Row;
use crate::profibus::dp::dpv1_status::Status1;
use crate::profibus::dp::set_prm::FIXED_LEN;
use crate::profibus::dpv1::{ALARM_SAP, MS1_SAP, RESOURCE_MANAGER_SAP, RequestPdu};

/// The SAP of a master of class 2.
const CLASS_2_SAP: u8 = 50;

impl Observer {
    /// A request that is no service of DP, at a SAP of DP-V1.
    pub(super) fn judge_acyclic(&mut self, cycle: &Cycle) {
        let Some(sap) = cycle.dsap().filter(|sap| *sap <= MS1_SAP) else { return };
        let data = cycle.data().to_vec();
        if sap >= ALARM_SAP && !data.is_empty() {
            let view = self.view(cycle.to);
            let status = view.prm_data.as_ref().and_then(|prm| prm.get(FIXED_LEN).copied());
            let enabled = status.is_some_and(|status| Status1::Enable.is_set(status));
            let reason = match (view.exchanging, enabled) {
                (true, true) => None,
                (false, _) => Some(format!("SAP {sap} is asked outside of data exchange")),
                (true, false) => {
                    Some(format!("SAP {sap} is asked, and DPV1_Enable in octet 8 of Set_Prm was 0"))
                }
            };
            self.verdict_of(cycle, Row::V01, reason);
        }
        // A poll has no data, and from another SAP it is no request of DP-V1, which is row F06.
        if data.is_empty() || sap < ALARM_SAP && cycle.ssap() != Some(CLASS_2_SAP) {
            return;
        }
        let pdu = RequestPdu::parse(&data);
        let fits = match pdu {
            Ok(RequestPdu::AlarmAck(head)) => sap >= ALARM_SAP && head.slot != u8::MAX,
            Ok(RequestPdu::Read { slot, len, .. }) => sap != ALARM_SAP && slot != u8::MAX && len != 0,
            Ok(RequestPdu::Write { slot, data, .. }) => {
                sap != ALARM_SAP && slot != u8::MAX && !data.is_empty()
            }
            Ok(RequestPdu::DataTransport { .. } | RequestPdu::Idle | RequestPdu::Abort(_)) => {
                sap < RESOURCE_MANAGER_SAP
            }
            Ok(RequestPdu::Initiate(_)) => sap == RESOURCE_MANAGER_SAP,
            Err(_) => false,
        };
        let reason = (!fits).then(|| match pdu {
            Ok(_) => format!("SAP {sap} is asked with {}: not a request of that SAP", hex(&data)),
            Err(error) => format!("SAP {sap} is asked with {}: {error}", hex(&data)),
        });
        self.verdict_of(cycle, Row::V02, reason);
    }

    fn verdict_of(&mut self, cycle: &Cycle, row: Row, broken: Option<String>) {
        match broken {
            None => self.held(row),
            Some(reason) => self.broken(row, Weight::Once, cycle.serial, Some(cycle.to), reason),
        }
    }
}
