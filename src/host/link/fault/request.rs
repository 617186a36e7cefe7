//! Faults on the way from the master to the drives.

use std::vec::Vec;

use super::{Active, Kind, data_telegram, encoded};
use crate::dp::Service;
use crate::fdl::{self, DataTelegram, FrameCount, FunctionCode, Sap};
use crate::time::Instant;

/// Set_Prm that releases the slave: Unlock_Req, watchdog factors of 1, min T_SDR unchanged, no groups. The slave does not
/// look at the ident number then.
const UNLOCK: [u8; 7] = [0x40, 1, 1, 0, 0, 0, 0];

/// Octets 5 and 6 of Set_Prm.
const IDENT: core::ops::Range<usize> = 4..6;

impl Active {
    /// What the drives hear instead of the request in `octets`.
    pub(super) fn corrupt_request(&mut self, octets: Vec<u8>, now: Instant) -> Vec<u8> {
        // A fault before this one may have dropped it, or put another telegram in front of it.
        let Some(request) = data_telegram(&octets) else {
            return octets;
        };
        if !self.concerns(Some(request.da)) {
            return octets;
        }
        let service = match request.fc.function() {
            fdl::Function::Request(fdl::Service::SrdLow | fdl::Service::SrdHigh, _) => {
                Service::of(request.dsap, request.ssap)
            }
            fdl::Function::Request(..) | fdl::Function::Response(..) | fdl::Function::Reserved => None,
        };
        match self.fault.kind {
            Kind::DropRequest => {
                if self.is_due() {
                    return Vec::new();
                }
            }
            Kind::RefusePrm => {
                if service == Some(Service::SetPrm) && self.is_due() {
                    let mut data = request.data.to_vec();
                    for octet in data.get_mut(IDENT).unwrap_or_default() {
                        *octet = !*octet;
                    }
                    return encoded(&DataTelegram { data: &data, ..request });
                }
            }
            Kind::RefuseCfg => {
                if service == Some(Service::ChkCfg) && self.is_due() {
                    let mut data = request.data.to_vec();
                    if let Some(octet) = data.first_mut() {
                        *octet ^= 0x01;
                    }
                    return encoded(&DataTelegram { data: &data, ..request });
                }
            }
            Kind::LosePrm => {
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
            Kind::NotReady(time) => {
                let station = request.da.number();
                if service == Some(Service::ChkCfg) && self.is_due() {
                    let until = Some(now.saturating_add(time));
                    self.stations.entry(station).or_default().not_ready = until;
                }
                if service == Some(Service::DataExchange) && self.is_not_ready(station, now) {
                    // A service that a DP slave does not offer: it says RS to it, as to Data_Exchange before its time.
                    let fc = FunctionCode::request(fdl::Service::SdaHigh, FrameCount::Unused);
                    return encoded(&DataTelegram {
                        format: fdl::telegram::Format::Sd1,
                        fc,
                        data: &[],
                        ..request
                    });
                }
            }
            Kind::NoReply
            | Kind::Late(_)
            | Kind::Duplicate
            | Kind::Truncated
            | Kind::BitErrors(_)
            | Kind::WrongFcs
            | Kind::WrongLength
            | Kind::WrongSource
            | Kind::Noise(_)
            | Kind::DiagStorm
            | Kind::Pkw(_) => {}
        }
        octets
    }

    pub(super) fn is_not_ready(&self, station: u8, now: Instant) -> bool {
        let until = self.stations.get(&station).and_then(|station| station.not_ready);
        until.is_some_and(|until| now < until)
    }
}
