//! What a master sends: any telegram, right or wrong.

use crate::profibus::dp;
use crate::profibus::dpv1::{ALARM_SAP, EXT_PRM_SAP, MS1_SAP, RESOURCE_MANAGER_SAP};
use crate::profibus::fdl::telegram::Format;
use crate::profibus::fdl::{Address, DataTelegram, FrameCount, FunctionCode, MAX_TELEGRAM_LEN, Sap, Service};

/// The SAP of a master.
pub(super) const MASTER_SAP: u8 = 62;

/// A request that is right as a telegram.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Request {
    pub(super) da: u8,
    pub(super) sa: u8,
    pub(super) dsap: Option<u8>,
    pub(super) ssap: Option<u8>,
    pub(super) service: Service,
    pub(super) count: FrameCount,
    pub(super) data: Vec<u8>,
    /// SD3 where it has eight octets; otherwise the customary format.
    pub(super) as_sd3: bool,
}

impl Request {
    /// A service of DP, high priority.
    pub(super) fn of(da: u8, sa: u8, service: dp::Service, count: FrameCount, data: &[u8]) -> Self {
        let dsap = service.sap().map(Sap::number);
        let ssap = dsap.map(|_| MASTER_SAP);
        Self { da, sa, dsap, ssap, service: Service::SrdHigh, count, data: data.to_vec(), as_sd3: false }
    }

    /// An FDL status request.
    pub(super) const fn status(da: u8, sa: u8) -> Self {
        Self {
            da,
            sa,
            dsap: None,
            ssap: None,
            service: Service::FdlStatus,
            count: FrameCount::Unused,
            data: Vec::new(),
            as_sd3: false,
        }
    }

    /// Its octets.
    pub(super) fn octets(&self) -> Vec<u8> {
        let (dsap, ssap) = (self.dsap.and_then(Sap::new), self.ssap.and_then(Sap::new));
        let customary = DataTelegram::customary_format(dsap, ssap, &self.data);
        let telegram = DataTelegram {
            format: if self.as_sd3 { Format::Sd3 } else { customary },
            da: Address::from_octet(self.da),
            sa: Address::from_octet(self.sa),
            dsap,
            ssap,
            fc: FunctionCode::request(self.service, self.count),
            data: &self.data,
        };
        let mut buf = [0; MAX_TELEGRAM_LEN];
        telegram.encode(&mut buf).map(<[u8]>::to_vec).unwrap_or_default()
    }

    /// What it is called.
    pub(super) fn name(&self) -> &'static str {
        match self.service {
            Service::FdlStatus => "the FDL status request",
            Service::Ident => "the Ident request",
            Service::LsapStatus => "the LSAP status request",
            Service::SdaLow | Service::SdaHigh => "SDA",
            Service::TimeEvent | Service::SdnLow | Service::SdnHigh | Service::Msrd => "the request",
            Service::SrdLow | Service::SrdHigh => {
                let dsap = self.dsap.and_then(Sap::new);
                let ssap = self.ssap.and_then(Sap::new);
                let acyclic = || match self.dsap {
                    Some(EXT_PRM_SAP) => "Set_Ext_Prm",
                    Some(MS1_SAP) => "the telegram to SAP 51",
                    Some(ALARM_SAP) => "the telegram to SAP 50",
                    Some(RESOURCE_MANAGER_SAP) => "the telegram to SAP 49",
                    Some(..RESOURCE_MANAGER_SAP) => "the telegram to the SAP of a connection",
                    Some(_) | None => "the request to an unknown SAP",
                };
                dp::Service::of(dsap, ssap).map_or_else(acyclic, dp::Service::name)
            }
        }
    }
}

/// The same octets with another checksum and the same end.
pub(super) fn with_wrong_fcs(octets: &[u8]) -> Vec<u8> {
    changed(octets, 2, |fcs| fcs.wrapping_add(1))
}

/// The same octets with another end delimiter.
pub(super) fn with_wrong_end(octets: &[u8]) -> Vec<u8> {
    changed(octets, 1, |_| 0x17)
}

/// The octet that is `from_end` in front of the end, counted from 1, is another.
fn changed(octets: &[u8], from_end: usize, change: impl FnOnce(u8) -> u8) -> Vec<u8> {
    let mut octets = octets.to_vec();
    let place = octets.len().saturating_sub(from_end);
    if let Some(octet) = octets.get_mut(place) {
        *octet = change(*octet);
    }
    octets
}
