//! Requests that are not served here or now: what is said of them, once.

use super::{Handled, Slave};
use crate::profibus::dp::policy::DefaultAddress;
use crate::profibus::dp::{
    Access, Application, Event, MASTER_SAP, NotServed, Policy, PrmBit, Service, State, StoredAddress,
};
use crate::profibus::fdl::{Address, Reply, Request};

/// What was said in one state of the slave: a master that asks in each of its cycles is told of once.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Said {
    /// The state and the owner for which it was said.
    at: (State, Option<Address>),
    /// One bit for each [`Topic`].
    topics: u16,
}

/// What is said once: a service by its place in [`Service::ALL`], and what is none.
#[derive(Clone, Copy, Debug)]
enum Topic {
    Service(Service),
    /// Nothing listens there.
    NoService,
    /// A service that only reads came with data.
    Data,
    Sync,
    Freeze,
}

impl Topic {
    fn mask(self) -> u16 {
        let place = match self {
            Self::Service(service) => {
                Service::ALL.iter().position(|known| *known == service).unwrap_or_default()
            }
            Self::NoService => 12,
            Self::Data => 13,
            Self::Sync => 14,
            Self::Freeze => 15,
        };
        1 << place
    }
}

impl<A: Application> Slave<A> {
    /// The answer to a request that does not run: `service` is what it would have run, as far as the slave offers it.
    #[cold]
    #[inline(never)]
    pub(super) fn not_served(
        &mut self,
        service: Option<Service>,
        access: Access,
        request: &Request<'_>,
    ) -> Handled<'static> {
        let asked = service.or_else(|| Service::of(request.dsap, request.ssap));
        let event = self.first(asked.map_or(Topic::NoService, Topic::Service)).then(|| {
            let why = match (service, asked) {
                (Some(service), _) => self.refused(service),
                (None, Some(asked)) => self.not_offered(asked, request),
                (None, None) => NotServed::NoSuchSap { got: request.dsap },
            };
            Event::NotServed { master: request.sa, service: asked, why }
        });
        let acknowledged = service.is_some() && access == Access::Acknowledged;
        let reply = if acknowledged { Reply::ShortAcknowledge } else { Reply::NotActivated };
        Handled { event, ..Handled::reply(reply) }
    }

    /// The answer to a request with data for a service that takes none.
    #[cold]
    #[inline(never)]
    pub(super) fn with_data(&mut self, service: Service, request: &Request<'_>) -> Handled<'static> {
        let why = NotServed::WithData { got: request.data.len() };
        let event = Event::NotServed { master: request.sa, service: Some(service), why };
        let event = self.first(Topic::Data).then_some(event);
        Handled { event, ..Handled::reply(Reply::NoResource) }
    }

    /// The answer to a request with a reply for a service that has none.
    #[cold]
    #[inline(never)]
    pub(super) fn without_reply(&mut self, service: Service, request: &Request<'_>) -> Handled<'static> {
        let event = Event::NotServed { master: request.sa, service: Some(service), why: NotServed::NoReply };
        let event = self.first(Topic::Service(service)).then_some(event);
        Handled { event, ..Handled::reply(Reply::NotActivated) }
    }

    /// Sync or Freeze without the bit of Set_Prm that opens it.
    #[cold]
    pub(super) fn latch_closed(&mut self, master: Address, bit: PrmBit) -> Option<Event> {
        let topic = if bit == PrmBit::SyncReq { Topic::Sync } else { Topic::Freeze };
        let supported = match bit {
            PrmBit::SyncReq => self.description.sync_mode,
            PrmBit::FreezeReq => self.description.freeze_mode,
            PrmBit::LockReq | PrmBit::UnlockReq | PrmBit::WdOn => true,
        };
        self.first(topic).then_some(Event::LatchClosed { master, bit, supported })
    }

    /// Whether this is the first of its kind in this state; it counts as said then.
    fn first(&mut self, topic: Topic) -> bool {
        let at = (self.state, self.owner);
        if self.said.at != at {
            self.said = Said { at, topics: 0 };
        }
        let first = self.said.topics & topic.mask() == 0;
        self.said.topics |= topic.mask();
        first
    }

    /// Why a service that the slave offers does not run ([`Service::access`]).
    fn refused(&self, service: Service) -> NotServed {
        match (self.state, self.owner) {
            (State::WaitCfg | State::DataExch, Some(owner)) if service == Service::SetSlaveAdd => {
                NotServed::Owned { owner }
            }
            (State::WaitPrm, _) | (_, None) => NotServed::WaitsForPrm,
            (State::WaitCfg, _) if service != Service::ChkCfg => NotServed::WaitsForCfg,
            (State::WaitCfg | State::DataExch, Some(owner)) => NotServed::Locked { owner },
        }
    }

    /// Why a service of DP-V0 is none of this slave, or not at this address.
    fn not_offered(&self, service: Service, request: &Request<'_>) -> NotServed {
        let Policy { check_ssap, default_address, .. } = self.policy;
        if service == Service::SetSlaveAdd && !self.description.set_slave_add {
            NotServed::NotOffered
        } else if default_address == DefaultAddress::Addressing
            && request.da == StoredAddress::DELIVERED.address
        {
            NotServed::NoAddress
        } else if check_ssap && request.ssap != MASTER_SAP {
            NotServed::MasterSap { got: request.ssap }
        } else {
            NotServed::NotOffered
        }
    }
}
