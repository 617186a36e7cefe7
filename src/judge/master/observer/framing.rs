//! Rows F: every telegram of the master as such.

use super::Observer;
use crate::judge::master::findings::Weight;
use crate::judge::master::rows::Row;
use crate::profibus::dp;
use crate::profibus::fdl::telegram::Format;
use crate::profibus::fdl::{Address, DataTelegram, FrameError, Function, Service, Telegram};

/// The SAP of a master for the services of DP.
const MASTER_SAP: u8 = 62;
/// The SAPs of DPV1.
const DPV1_SAPS: core::ops::RangeInclusive<u8> = 0..=51;
/// The most octets of user data.
const MOST_DATA: usize = 244;
/// The most octets without a pause.
const MOST_OCTETS: usize = 255;
/// The highest address of a master.
const HIGHEST_MASTER: u8 = 125;

impl Observer {
    /// Octets of the master that are no telegram.
    pub(super) fn not_framed(&mut self, serial: u64, octets: &[u8], error: Option<FrameError>) {
        self.noise = self.noise.saturating_add(1);
        self.noise_octets = self.noise_octets.saturating_add(octets.len());
        if self.noise_octets > MOST_OCTETS {
            let reason = format!("{} octets without a telegram among them", self.noise_octets);
            self.broken(Row::F11, Weight::Once, serial, None, reason);
        }
        let (row, why) = match error {
            Some(error @ FrameError::Checksum { .. }) => (Row::F02, format!("{error}")),
            Some(FrameError::Length { got: 3 }) => {
                (Row::F07, "SD2 with LE 3: a telegram without data is SD1".into())
            }
            Some(error @ FrameError::Length { got: 250.. }) => (Row::F08, format!("{error}")),
            Some(
                error @ (FrameError::Length { .. }
                | FrameError::RepeatedLength { .. }
                | FrameError::SecondStartDelimiter { .. }
                | FrameError::EndDelimiter { .. }
                | FrameError::BrokenOff { .. }),
            ) => (Row::F03, format!("{error}")),
            Some(error @ (FrameError::ExtensionMissing | FrameError::Extension { .. })) => {
                (Row::F06, format!("{error}"))
            }
            Some(error @ (FrameError::StartDelimiter { .. } | FrameError::Parity)) => {
                (Row::F01, format!("{error}"))
            }
            Some(error @ FrameError::TokenAddress { .. }) => (Row::F04, format!("{error}")),
            None => (Row::F01, "octets behind a telegram".into()),
        };
        self.broken(row, Weight::Once, serial, None, why);
    }

    /// A whole telegram of the master.
    pub(super) fn framed(&mut self, serial: u64, telegram: &Telegram<'_>) {
        for row in [Row::F01, Row::F02, Row::F03, Row::F11] {
            self.held(row);
        }
        match telegram {
            Telegram::ShortAcknowledge => {
                self.broken(Row::F01, Weight::Once, serial, None, "the master sends SC, which only answers");
            }
            Telegram::Token { sa, .. } => self.judge_source(serial, *sa),
            Telegram::Data(data) => match data.fc.function() {
                Function::Response(..) => self.judge_source(serial, data.sa),
                Function::Reserved => {
                    let reason = format!("function code 0x{:02X} is no request", data.fc.octet());
                    self.broken(Row::F05, Weight::Once, serial, None, reason);
                }
                Function::Request(kind, _) => self.judge_request(serial, kind, data),
            },
        }
    }

    /// One address in every telegram.
    fn judge_source(&mut self, serial: u64, sa: Address) {
        let reason = match self.master {
            Some(master) if master != sa && self.sight != super::Sight::Recorded => {
                format!("a telegram from {sa}; the master is {master}")
            }
            _ if sa.number() > HIGHEST_MASTER => format!("SA {sa} is outside 0 to {HIGHEST_MASTER}"),
            _ => return self.held(Row::F04),
        };
        self.broken(Row::F04, Weight::Once, serial, None, reason);
    }

    fn judge_request(&mut self, serial: u64, kind: Service, data: &DataTelegram<'_>) {
        self.judge_source(serial, data.sa);
        let broken = |observer: &mut Self, row, reason: &str| {
            observer.broken(row, Weight::Once, serial, None, reason);
        };
        if data.da == data.sa {
            broken(self, Row::F04, "a request of the master to itself");
        } else if data.da.is_broadcast() && kind.wants_reply() {
            broken(self, Row::F04, "a request that wants a reply to address 127, all stations");
        }
        let service = dp::Service::of(data.dsap, data.ssap);
        let control = service == Some(dp::Service::GlobalControl);
        let fits = match kind {
            Service::SrdLow | Service::SrdHigh => !control,
            Service::SdnLow | Service::SdnHigh => control || self.is_stranger(data.da),
            Service::FdlStatus | Service::Ident | Service::LsapStatus => true,
            Service::TimeEvent | Service::SdaLow | Service::SdaHigh | Service::Msrd => false,
        };
        if fits {
            self.held(Row::F05);
        } else {
            let reason = format!(
                "function code 0x{:02X} for {}",
                data.fc.octet(),
                service.map_or("no service of DP", dp::Service::name)
            );
            self.broken(Row::F05, Weight::Once, serial, None, reason);
        }
        self.judge_saps(serial, kind, service, data);
        if data.dsap.is_none() && data.ssap.is_none() && data.data.is_empty() {
            match data.format {
                Format::Sd1 => self.held(Row::F07),
                Format::Sd2 | Format::Sd3 => broken(self, Row::F07, "no data and no SD1"),
            }
        }
        if data.data.len() > MOST_DATA {
            broken(self, Row::F08, "more than 244 octets of user data");
        } else {
            self.held(Row::F08);
        }
    }

    /// Nothing is known of what others than configured slaves are sent.
    fn is_stranger(&self, station: Address) -> bool {
        !station.is_broadcast() && self.setup.slave(station).is_none()
    }

    fn judge_saps(
        &mut self,
        serial: u64,
        kind: Service,
        service: Option<dp::Service>,
        data: &DataTelegram<'_>,
    ) {
        match kind {
            Service::SrdLow | Service::SrdHigh | Service::SdnLow | Service::SdnHigh => {}
            Service::TimeEvent
            | Service::SdaLow
            | Service::SdaHigh
            | Service::Msrd
            | Service::FdlStatus
            | Service::Ident
            | Service::LsapStatus => return,
        }
        let (dsap, ssap) = (data.dsap.map(|sap| sap.number()), data.ssap.map(|sap| sap.number()));
        match (service, dsap, ssap) {
            (Some(dp::Service::DataExchange), ..) => self.held(Row::F06),
            (Some(service), _, Some(MASTER_SAP)) if !wants_nothing(service) || data.data.is_empty() => {
                self.held(Row::F06);
            }
            (Some(service), _, Some(MASTER_SAP)) => {
                let octets = data.data.len();
                let reason = format!("{} with {octets} octets of data; expected none", service.name());
                self.broken(Row::F06, Weight::Once, serial, Some(data.da), reason);
            }
            // DPV1 has SAPs of its own, and of others than configured slaves nothing is known.
            (None, Some(dsap), Some(ssap))
                if ssap != MASTER_SAP && DPV1_SAPS.contains(&dsap) || self.setup.slave(data.da).is_none() => {
            }
            (Some(_) | None, _, _) => {
                let name = |sap: Option<u8>| sap.map_or("none".into(), |sap| format!("{sap}"));
                let reason = format!(
                    "SAPs {} to {}; expected 62 to that of the service, or none for Data_Exchange",
                    name(ssap),
                    name(dsap)
                );
                self.broken(Row::F06, Weight::Once, serial, Some(data.da), reason);
            }
        }
    }
}

/// Whether the request of a service carries no data.
const fn wants_nothing(service: dp::Service) -> bool {
    match service {
        dp::Service::SlaveDiag | dp::Service::GetCfg | dp::Service::RdInp | dp::Service::RdOutp => true,
        dp::Service::SetSlaveAdd
        | dp::Service::GlobalControl
        | dp::Service::SetPrm
        | dp::Service::ChkCfg
        | dp::Service::DataExchange => false,
    }
}
