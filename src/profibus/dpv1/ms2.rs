//! Connections of masters of class 2: the resource manager hands them out, each has a service access point of its own.
//!
//! ```text
//! Free ──Initiate at 49──▶ Offered ──RM fetched──▶ Answering ──response fetched──▶ Open ──Abort, silence──▶ Free
//! ```
//!
//! Source: `dp-v1.md` 4.

use core::time::Duration;

use super::connection::{Abort, AbortReason, AdditionalAddress, Instance, READ_WRITE, Subnet};
use super::connection::{Initiate, InitiateResponse, Terms};
use super::job::{Context, Fdl, Server};
use super::pdu::{RequestPdu, ResponsePdu};
use super::{Channel, Closed, Event, MAX_DATA, Ms2Offer, Records};
use crate::profibus::fdl::{Address, Reply, Request};
use crate::time::Instant;

/// The SAP of the first connection; the others lie below it.
const FIRST_SAP: u8 = 48;

/// The SAP of a master of class 2.
const MASTER_SAP: u8 = 50;

/// So many times Send_Timeout without a word a connection ends; the same for an answer that is not fetched (O-08).
const PATIENCE: u32 = 3;

/// The unit of Send_Timeout.
const UNIT: Duration = Duration::from_millis(10);

/// A connection, as it is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Link {
    /// Its SAP.
    pub sap: u8,
    /// Whose.
    pub master: Address,
    /// How often the master sends something at least.
    pub send_timeout: Duration,
    /// It carries out a request.
    pub busy: bool,
}

/// All connections and who asks for one.
#[derive(Clone, Debug)]
pub(super) struct ResourceManager<const N: usize> {
    connections: [Connection; N],
    /// RM, as it is handed over.
    reply: [u8; 4],
}

#[derive(Clone, Debug)]
struct Connection {
    phase: Phase,
    master: Address,
    send_timeout: Duration,
    /// When it ends unless something comes.
    ends: Instant,
    server: Server,
}

/// How far a connection is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    /// Nobody has it.
    Free,
    /// Its SAP is not fetched yet.
    Offered(Answer),
    /// Its answer to Initiate is not fetched yet.
    Answering(Answer),
    /// It works.
    Open,
}

/// The answer to Initiate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Answer {
    Accepted,
    Refused(AbortReason),
}

impl Connection {
    const FREE: Self = Self {
        phase: Phase::Free,
        master: Address::BROADCAST,
        send_timeout: Duration::ZERO,
        ends: Instant::ZERO,
        server: Server::IDLE,
    };

    fn free(&mut self) {
        self.phase = Phase::Free;
        self.server.reset();
    }

    /// Something came: the time begins anew.
    fn heard(&mut self, now: Instant) {
        self.ends = now.saturating_add(self.send_timeout.saturating_mul(PATIENCE));
    }
}

impl<const N: usize> ResourceManager<N> {
    pub(super) const NEW: Self = Self { connections: [const { Connection::FREE }; N], reply: [0; 4] };

    pub(super) fn links(&self) -> impl Iterator<Item = Link> {
        (0..=FIRST_SAP)
            .rev()
            .zip(&self.connections)
            .filter(|(_, connection)| connection.phase == Phase::Open)
            .map(|(sap, connection)| Link {
                sap,
                master: connection.master,
                send_timeout: connection.send_timeout,
                busy: connection.server.is_busy(),
            })
    }

    /// A telegram at SAP 49.
    pub(super) fn ask(
        &mut self,
        now: Instant,
        offer: &Ms2Offer,
        request: &Request<'_>,
    ) -> (Reply<'_>, Option<Event>) {
        let waiting = |connection: &Connection| matches!(connection.phase, Phase::Offered(_));
        let offered = self.connections.iter().position(waiting);
        let Self { connections, reply } = self;
        let least = UNIT.saturating_mul(offer.min_send_timeout.into());
        match offered.and_then(|place| Some((place, connections.get_mut(place)?))) {
            Some((place, connection)) if request.data.is_empty() && connection.master == request.sa => {
                let Phase::Offered(answer) = connection.phase else { return (Reply::ShortAcknowledge, None) };
                connection.phase = Phase::Answering(answer);
                connection.ends = now.saturating_add(least.saturating_mul(PATIENCE));
                let (sap, send_timeout) = (sap_of(place), offer.min_send_timeout);
                let pdu = ResponsePdu::ResourceManager { sap, send_timeout };
                let len = pdu.encode(reply).map_or(0, <[u8]>::len);
                (Reply::DataLow(reply.get(..len).unwrap_or_default()), None)
            }
            Some(_) | None if request.data.is_empty() => (Reply::ShortAcknowledge, None),
            // One at a time.
            Some(_) => (Reply::NoResource, None),
            None if request.data.len() > usize::from(offer.max_initiate) => (Reply::NoResource, None),
            None => {
                let most = usize::from(offer.connections).min(N);
                let master = request.sa;
                let is_free = |connection: &&mut Connection| connection.phase == Phase::Free;
                let Some(connection) = connections.iter_mut().take(most).find(is_free) else {
                    let event = Event::NoConnection { master, connections: most };
                    return (Reply::NotActivated, Some(event));
                };
                connection.master = master;
                connection.phase = Phase::Offered(connection.judge(offer, request.data));
                connection.ends = now.saturating_add(least.saturating_mul(PATIENCE));
                (Reply::ShortAcknowledge, None)
            }
        }
    }

    /// A telegram at the SAP of a connection; `None` if the sender has no such connection.
    pub(super) fn serve<R: Records>(
        &mut self,
        now: Instant,
        offer: &Ms2Offer,
        request: &Request<'_>,
        records: &mut R,
    ) -> Option<(Reply<'_>, Option<Event>)> {
        let sap = request.dsap?.number();
        let place = usize::from(FIRST_SAP.checked_sub(sap)?);
        let connection = self.connections.get_mut(place)?;
        let is_master_sap = request.ssap.is_some_and(|ssap| ssap.number() == MASTER_SAP);
        if connection.master != request.sa || !is_master_sap {
            return None;
        }
        let master = request.sa;
        let is_handed_out = matches!(connection.phase, Phase::Answering(_) | Phase::Open);
        if let (true, Ok(RequestPdu::Abort(Abort { reason, .. }))) =
            (is_handed_out, RequestPdu::parse(request.data))
        {
            connection.free();
            let event = Event::Ended { master, sap, why: Closed::Aborted(reason) };
            return Some((Reply::ShortAcknowledge, Some(event)));
        }
        match connection.phase {
            Phase::Free | Phase::Offered(_) => None,
            Phase::Answering(_) if !request.data.is_empty() => Some((Reply::NoResource, None)),
            Phase::Answering(Answer::Accepted) => {
                connection.phase = Phase::Open;
                connection.heard(now);
                let event = Event::Opened { master, sap };
                Some((connection.fetched(), Some(event)))
            }
            Phase::Answering(Answer::Refused(reason)) => {
                connection.phase = Phase::Free;
                let event = Event::Ended { master, sap, why: Closed::Refused(reason) };
                Some((connection.fetched(), Some(event)))
            }
            Phase::Open => {
                // A poll alone keeps no connection.
                if !request.data.is_empty() || connection.server.is_busy() {
                    connection.heard(now);
                }
                let mut context = Context {
                    master,
                    channel: Channel::Ms2 { sap },
                    max_data: offer.max_data,
                    now,
                    records,
                    acknowledge: &mut |_| None,
                };
                let (fdl, event) = connection.server.take(request.data, &mut context);
                Some((connection.server.reply(fdl), event))
            }
        }
    }

    /// A connection that nobody wanted any more ends.
    pub(super) fn handle_timeout(&mut self, now: Instant) -> Option<Event> {
        let over = |connection: &Connection| connection.phase != Phase::Free && connection.ends <= now;
        let place = self.connections.iter().position(over)?;
        let connection = self.connections.get_mut(place)?;
        let why = if connection.phase == Phase::Open { Closed::Silent } else { Closed::NotFetched };
        connection.free();
        Some(Event::Ended { master: connection.master, sap: sap_of(place), why })
    }

    /// When the next one ends.
    pub(super) fn poll_timeout(&self) -> Option<Instant> {
        let held = self.connections.iter().filter(|connection| connection.phase != Phase::Free);
        held.map(|connection| connection.ends).min()
    }
}

fn sap_of(place: usize) -> u8 {
    FIRST_SAP.saturating_sub(u8::try_from(place).unwrap_or(FIRST_SAP))
}

impl Connection {
    /// Judges Initiate: the answer waits in the server.
    fn judge(&mut self, offer: &Ms2Offer, octets: &[u8]) -> Answer {
        self.server.reset();
        self.send_timeout = UNIT.saturating_mul(offer.min_send_timeout.into());
        let refused = match RequestPdu::parse(octets) {
            Ok(RequestPdu::Initiate(initiate)) => match admit(offer, &initiate) {
                Ok(response) => {
                    self.send_timeout = UNIT.saturating_mul(initiate.send_timeout.into());
                    self.server.answer(ResponsePdu::Initiate(response));
                    return Answer::Accepted;
                }
                Err(reason) => reason,
            },
            Ok(_) | Err(_) => AbortReason::INVALID_REQUEST,
        };
        let abort = Abort { subnet: Subnet::Local, instance: Instance::Msac2, reason: refused };
        self.server.answer(ResponsePdu::Abort(abort));
        Answer::Refused(refused)
    }

    /// The answer to Initiate, handed over.
    fn fetched(&mut self) -> Reply<'_> {
        self.server.fetched();
        self.server.reply(Fdl::Response)
    }
}

/// The answer to a request for a connection.
fn admit<'a>(offer: &Ms2Offer, initiate: &Initiate<'a>) -> Result<InitiateResponse<'a>, AbortReason> {
    let Initiate { send_timeout, terms: Terms { features, source, destination, .. } } = *initiate;
    if features & READ_WRITE == 0 {
        return Err(AbortReason::INVALID_REQUEST);
    }
    // The station itself has no other address, and API 0 only.
    if destination != AdditionalAddress::STATION || source.kind != AdditionalAddress::STATION.kind {
        return Err(AbortReason::ADDRESS);
    }
    if send_timeout < offer.min_send_timeout {
        return Err(AbortReason::SEND_TIMEOUT);
    }
    Ok(InitiateResponse {
        max_len: offer.max_data.min(MAX_DATA),
        terms: Terms {
            features: READ_WRITE,
            profile_features: 0,
            profile_ident: 0,
            source: destination,
            destination: source,
        },
    })
}
