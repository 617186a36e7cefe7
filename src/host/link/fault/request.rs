//! Faults on the way from the master to the drives.

use core::time::Duration;

use super::observed::Occasion;
use super::{Active, HeldCfg, data_telegram, encoded};
use crate::host::fault::Kind;
use crate::profibus::dp::Service;
use crate::profibus::fdl;
use crate::profibus::fdl::{DataTelegram, FrameCount, FunctionCode, Sap};
use crate::time::Instant;

/// Set_Prm that releases the slave: Unlock_Req, watchdog factors of 1, min T_SDR unchanged, no groups. The slave does not
/// look at the ident number then.
const UNLOCK: [u8; 7] = [0x40, 1, 1, 0, 0, 0, 0];

/// Set_Prm that neither locks nor releases the slave and keeps min T_SDR: acknowledged, and without effect.
const NOTHING: [u8; 7] = [0; 7];

/// A service access point that no slave has.
const CLOSED_SAP: u8 = 1;

/// Octets 5 and 6 of Set_Prm.
const IDENT: core::ops::Range<usize> = 4..6;

/// What becomes of a request. The table of kinds ([`Row`](crate::host::fault::Row)) says it in words.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum RequestFault {
    Drop,
    NotReady(Duration),
    RefusePrm,
    RefuseCfg,
    LosePrm,
    Reject,
}

/// How a request to a station that is not ready passes.
enum Pass {
    /// As it is.
    Whole,
    /// This in its place.
    Instead(Vec<u8>),
    /// Behind this.
    Behind(Vec<u8>),
}

impl Active {
    /// What the drives hear instead of the request in `octets`.
    pub(super) fn corrupt_request(&mut self, octets: Vec<u8>, occasion: Occasion, now: Instant) -> Vec<u8> {
        let Kind::Request(fault) = self.rule.kind else { return octets };
        // A fault before this one may have dropped it, or put another telegram in front of it.
        let Some(request) = data_telegram(&octets) else {
            return octets;
        };
        if !self.concerns(occasion) {
            return octets;
        }
        let service = occasion.service;
        match fault {
            RequestFault::Drop => {
                if self.is_due() {
                    return Vec::new();
                }
            }
            RequestFault::RefusePrm => {
                if service == Some(Service::SetPrm) && self.is_due() {
                    let mut data = request.data.to_vec();
                    for octet in data.get_mut(IDENT).unwrap_or_default() {
                        *octet = !*octet;
                    }
                    return encoded(&DataTelegram { data: &data, ..request });
                }
            }
            RequestFault::RefuseCfg => {
                if service == Some(Service::ChkCfg) && self.is_due() {
                    let mut data = request.data.to_vec();
                    if let Some(octet) = data.first_mut() {
                        *octet ^= 0x01;
                    }
                    return encoded(&DataTelegram { data: &data, ..request });
                }
            }
            RequestFault::LosePrm => {
                if service == Some(Service::DataExchange) && self.is_due() {
                    let (dsap, ssap) = (Sap::new(61), Sap::new(62));
                    let unlock = DataTelegram {
                        format: DataTelegram::customary_format(dsap, ssap, &UNLOCK),
                        dsap,
                        ssap,
                        fc: FunctionCode::request(fdl::Service::SrdHigh, FrameCount::First),
                        data: &UNLOCK,
                        ..request
                    };
                    // The slave drops its reply to the first when the second comes.
                    return [encoded(&unlock), octets].concat();
                }
            }
            RequestFault::Reject => {
                let srd = fdl::Service::SrdHigh as u8 & 0x0E;
                if request.fc.octet() & 0x0E == srd && self.is_due() {
                    // A SAP where nothing listens.
                    let dsap = Sap::new(CLOSED_SAP);
                    let ssap = request.ssap.or(Sap::new(62));
                    let format = DataTelegram::customary_format(dsap, ssap, &[]);
                    return encoded(&DataTelegram { format, dsap, ssap, data: &[], ..request });
                }
            }
            RequestFault::NotReady(time) => {
                match self.keep_from_getting_ready(service, &request, now, time) {
                    Pass::Whole => {}
                    Pass::Instead(nothing) => return nothing,
                    Pass::Behind(chk_cfg) => return [chk_cfg, octets].concat(),
                }
            }
        }
        octets
    }

    /// The slave whose application takes its time: it stays in WAIT-CFG because its Chk_Cfg reaches it later. In the
    /// place of Chk_Cfg comes a Set_Prm that changes nothing, which is acknowledged as Chk_Cfg would be; when the time is
    /// over, Chk_Cfg comes in front of the next request, which ends the time of its reply.
    fn keep_from_getting_ready(
        &mut self,
        service: Option<Service>,
        request: &DataTelegram<'_>,
        now: Instant,
        time: Duration,
    ) -> Pass {
        let held =
            self.seen.stations.get_mut(&request.da.number()).and_then(|station| station.not_ready.take());
        let waits = held.as_ref().is_some_and(|held| now < held.until);
        // What another master asks meanwhile the slave refuses by itself.
        let foreign = held.as_ref().is_some_and(|held| held.master != request.sa);
        if service == Some(Service::ChkCfg) && !foreign && (waits || self.is_due()) {
            let until = match held {
                Some(held) if waits => held.until,
                Some(_) | None => now.saturating_add(time),
            };
            let first = FunctionCode::request(fdl::Service::SrdHigh, FrameCount::First);
            let chk_cfg = encoded(&DataTelegram { fc: first, ..*request });
            let nothing = DataTelegram {
                format: DataTelegram::customary_format(request.dsap, request.ssap, &NOTHING),
                dsap: Sap::new(61),
                data: &NOTHING,
                ..*request
            };
            let held = Some(HeldCfg { master: request.sa, until, octets: chk_cfg });
            self.seen.stations.or_default(request.da.number()).not_ready = held;
            return Pass::Instead(encoded(&nothing));
        }
        match held {
            // Void: the slave is parameterised anew.
            Some(_) if service == Some(Service::SetPrm) && !foreign => Pass::Whole,
            Some(held) if waits => {
                self.seen.stations.or_default(request.da.number()).not_ready = Some(held);
                Pass::Whole
            }
            Some(held) => Pass::Behind(held.octets),
            None => Pass::Whole,
        }
    }
}
