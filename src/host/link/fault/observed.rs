//! What telegrams show of the stations: who was asked for which service, how often, and in which state a station is.

use crate::map::Map;

use super::{data_telegram, is_request};
use crate::profibus::dp::{Diagnosis, Service, SetPrm, State};
use crate::profibus::fdl;
use crate::profibus::fdl::{Address, DataTelegram, FrameCount, Function, ReplyStatus};

/// What a request, or the reply to it, is about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Occasion {
    /// `None`: a reply that nobody asked for.
    pub(super) station: Option<Address>,
    /// Who asked it last.
    pub(super) master: Option<Address>,
    /// `None`: no service of a DP slave.
    pub(super) service: Option<Service>,
    /// Before the request.
    pub(super) state: State,
    /// How often the request was repeated; 0: it is new.
    pub(super) retry: u32,
}

/// Every station that was asked.
#[derive(Debug, Default)]
pub(super) struct Observed {
    stations: Map<u8, Seen>,
    /// To whom the last request was addressed: SC does not say from whom it is.
    asked: Option<Address>,
    /// From whom that request was.
    master: Option<Address>,
}

/// One station.
#[derive(Debug, Default)]
struct Seen {
    state: State,
    /// The newest request to it.
    request: Vec<u8>,
    service: Option<Service>,
    retry: u32,
    answered: bool,
    /// Set_Prm in `request` locks the station.
    locks: bool,
}

impl Observed {
    /// Takes a telegram of a master. `None`: it is no request.
    pub(super) fn request(&mut self, octets: &[u8]) -> Option<Occasion> {
        let request = data_telegram(octets).filter(is_request)?;
        self.asked = Some(request.da);
        self.master = Some(request.sa);
        let seen = self.stations.or_default(request.da.number());
        // With FCV the frame count tells; a first request is repeated only if nobody answered.
        let counted =
            matches!(request.fc.function(), Function::Request(_, FrameCount::Even | FrameCount::Odd));
        let again = seen.request == octets && (counted || !seen.answered);
        seen.retry = if again { seen.retry.saturating_add(1) } else { 0 };
        seen.request.clear();
        seen.request.extend_from_slice(octets);
        seen.answered = false;
        seen.service = service(&request);
        seen.locks = SetPrm::parse(request.data).is_ok_and(SetPrm::lock_req);
        Some(self.occasion(Some(request.da)))
    }

    /// Takes what a station sends, as it is before any fault.
    pub(super) fn reply(&mut self, octets: &[u8]) -> Occasion {
        let telegram = data_telegram(octets);
        let station = telegram.map(|telegram| telegram.sa).or(self.asked);
        let occasion = self.occasion(station);
        if let Some(seen) = station.and_then(|station| self.stations.get_mut(&station.number())) {
            seen.answered = true;
            seen.state = seen.state_after(telegram);
        }
        occasion
    }

    fn occasion(&self, station: Option<Address>) -> Occasion {
        match station.and_then(|station| self.stations.get(&station.number())) {
            Some(Seen { state, service, retry, .. }) => {
                let master = self.master;
                Occasion { station, master, service: *service, state: *state, retry: *retry }
            }
            None => Occasion { station, ..Occasion::default() },
        }
    }
}

impl Seen {
    /// The state after this reply to `request`; `None`: SC.
    fn state_after(&self, reply: Option<DataTelegram<'_>>) -> State {
        let status = match reply.map(|reply| reply.fc.function()) {
            Some(Function::Response(_, status)) => Some(status),
            Some(Function::Request(..) | Function::Reserved) => return self.state,
            None => None,
        };
        match (self.service, status) {
            (Some(Service::SetPrm), None) if self.locks => State::WaitCfg,
            (Some(Service::SetPrm), None) => State::WaitPrm,
            (Some(Service::ChkCfg), None) => State::DataExch,
            (Some(Service::DataExchange), Some(ReplyStatus::NotActivated)) => State::WaitPrm,
            (Some(Service::DataExchange), None | Some(ReplyStatus::DataLow | ReplyStatus::DataHigh)) => {
                State::DataExch
            }
            (Some(Service::SlaveDiag), Some(ReplyStatus::DataLow | ReplyStatus::DataHigh)) => {
                // Set_Prm and Chk_Cfg are acknowledged before they are judged.
                let diagnosis = reply.and_then(|reply| Diagnosis::parse(reply.data));
                if diagnosis.is_some_and(|diagnosis| diagnosis.prm_req) { State::WaitPrm } else { self.state }
            }
            (Some(_) | None, Some(_) | None) => self.state,
        }
    }
}

/// The service that a request asks for.
fn service(request: &DataTelegram<'_>) -> Option<Service> {
    let named = Service::of(request.dsap, request.ssap);
    match request.fc.function() {
        Function::Request(fdl::Service::SrdLow | fdl::Service::SrdHigh, _) => named,
        Function::Request(fdl::Service::SdnLow | fdl::Service::SdnHigh, _) => {
            named.filter(|service| *service == Service::GlobalControl)
        }
        Function::Request(..) | Function::Response(..) | Function::Reserved => None,
    }
}
