//! A service access point that carries out one request at a time, and hands its response over when the master polls.
//!
//! ```text
//! Idle ──request──▶ Running ──done──▶ Ready ──poll──▶ Idle
//! ```
//!
//! Source: `dp-v1.md` 1.1.

use core::fmt;

use super::identification::{self, CALL_LEN, Call, Written};
use super::pdu::{PduError, RequestPdu, ResponsePdu};
use super::{
    AlarmHead, CALL_INDEX, ErrorCode, Event, Failure, Function, MAX_DATA, MAX_PDU, NotDone, Records,
};
use crate::profibus::fdl::{Address, Reply};
use crate::time::Instant;

/// On which way a master asks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Channel {
    /// SAP 51: the owner.
    Ms1,
    /// SAP 50: the owner, for alarms.
    Alarms,
    /// A connection.
    Ms2 {
        /// Its SAP.
        sap: u8,
    },
}

impl fmt::Display for Channel {
    /// Nothing for the owner, else ` (connection at SAP 48)`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Ms1 | Self::Alarms => Ok(()),
            Self::Ms2 { sap } => write!(f, " (connection at SAP {sap})"),
        }
    }
}

/// A job for the application.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Job {
    /// Who asks.
    pub master: Address,
    /// On which way. What is asked on one knows nothing of the others.
    pub channel: Channel,
    /// Which slot: 0 the station, 1.. its modules.
    pub slot: u8,
    /// Which record.
    pub index: u8,
    /// When it was asked.
    pub since: Instant,
    /// The time now.
    pub now: Instant,
}

/// One request and its response.
#[derive(Clone, Debug)]
pub(super) struct Server {
    /// The request, then the response.
    octets: [u8; MAX_PDU],
    len: usize,
    work: Work,
    /// The block of identification that was asked for and not fetched.
    call: Option<(u8, Call)>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Work {
    Idle,
    Running { since: Instant },
    Ready,
}

/// For whom a job is carried out, and with what.
pub(super) struct Context<'a, R> {
    pub(super) master: Address,
    pub(super) channel: Channel,
    /// The most octets of data.
    pub(super) max_data: u8,
    pub(super) now: Instant,
    pub(super) records: &'a mut R,
    /// The alarm that an acknowledgement means.
    pub(super) acknowledge: &'a mut dyn FnMut(AlarmHead) -> Option<AlarmHead>,
}

/// What became of a telegram at a server.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fdl {
    /// Taken, or nothing to say.
    Acknowledged,
    /// It carries out another one.
    NoResource,
    /// The response is in [`Server::response`].
    Response,
}

impl Server {
    pub(super) const IDLE: Self = Self { octets: [0; MAX_PDU], len: 0, work: Work::Idle, call: None };

    pub(super) const fn is_busy(&self) -> bool {
        !matches!(self.work, Work::Idle)
    }

    /// The octets handed over last.
    pub(super) fn response(&self) -> &[u8] {
        self.octets.get(..self.len).unwrap_or_default()
    }

    /// Forgets everything.
    pub(super) const fn reset(&mut self) {
        self.work = Work::Idle;
        self.call = None;
        self.len = 0;
    }

    /// Takes a request, or a poll if there are no octets.
    pub(super) fn take<R: Records>(
        &mut self,
        octets: &[u8],
        context: &mut Context<'_, R>,
    ) -> (Fdl, Option<Event>) {
        if !octets.is_empty() {
            if self.is_busy() || octets.len() > MAX_PDU {
                return (Fdl::NoResource, None);
            }
            for (place, octet) in self.octets.iter_mut().zip(octets) {
                *place = *octet;
            }
            self.len = octets.len();
            self.work = Work::Running { since: context.now };
            return (Fdl::Acknowledged, self.run(context));
        }
        let event = self.run(context);
        match self.work {
            Work::Ready => {
                self.work = Work::Idle;
                (Fdl::Response, event)
            }
            Work::Idle | Work::Running { .. } => (Fdl::Acknowledged, event),
        }
    }

    /// Carries on with the request, if one runs.
    fn run<R: Records>(&mut self, context: &mut Context<'_, R>) -> Option<Event> {
        let Work::Running { since } = self.work else { return None };
        let request = self.octets;
        let octets = request.get(..self.len).unwrap_or_default();
        match RequestPdu::parse(octets) {
            Ok(pdu) => self.carry_out(pdu, since, context),
            Err(error) => {
                let code = match error {
                    PduError::Function { .. } | PduError::Empty => ErrorCode::NOT_SUPPORTED,
                    PduError::Short { .. } | PduError::Length { .. } => ErrorCode::INVALID_RANGE,
                };
                let function = octets.first().copied().unwrap_or_default() & !Function::NEGATIVE;
                Some(self.refuse(function, None, Failure::of(code), context))
            }
        }
    }

    fn carry_out<R: Records>(
        &mut self,
        pdu: RequestPdu<'_>,
        since: Instant,
        context: &mut Context<'_, R>,
    ) -> Option<Event> {
        let Context { master, channel, now, .. } = *context;
        let job = |slot, index| Job { master, channel, slot, index, since, now };
        let on_alarms = channel == Channel::Alarms;
        match pdu {
            RequestPdu::Read { slot, index, len } if !on_alarms => self.read(&job(slot, index), len, context),
            RequestPdu::Write { slot, index, data } if !on_alarms => {
                self.write(&job(slot, index), data, context)
            }
            RequestPdu::DataTransport { slot, index, data } if matches!(channel, Channel::Ms2 { .. }) => {
                self.transport(&job(slot, index), data, context)
            }
            RequestPdu::AlarmAck(ack) if !matches!(channel, Channel::Ms2 { .. }) => {
                let Some(alarm) = (context.acknowledge)(ack) else {
                    let failure = Failure::of(ErrorCode::STATE_CONFLICT);
                    return Some(self.refuse(Function::AlarmAck.number(), None, failure, context));
                };
                self.answer(ResponsePdu::AlarmAck(ack));
                Some(Event::AlarmAcknowledged { master, alarm })
            }
            RequestPdu::Idle if matches!(channel, Channel::Ms2 { .. }) => {
                self.answer(ResponsePdu::Idle);
                None
            }
            RequestPdu::Read { .. }
            | RequestPdu::Write { .. }
            | RequestPdu::DataTransport { .. }
            | RequestPdu::AlarmAck(_)
            | RequestPdu::Initiate(_)
            | RequestPdu::Idle
            | RequestPdu::Abort(_) => {
                let function = self.octets.first().copied().unwrap_or_default();
                Some(self.refuse(function, None, Failure::of(ErrorCode::NOT_SUPPORTED), context))
            }
        }
    }

    fn read<R: Records>(&mut self, job: &Job, asked: u8, context: &mut Context<'_, R>) -> Option<Event> {
        let (slot, index, master) = (job.slot, job.index, job.master);
        let mut out = [0; MAX_DATA as usize];
        let result = match asked {
            0 => Err(NotDone::refused(ErrorCode::INVALID_RANGE)),
            1.. if index == CALL_INDEX => self.identify(job, &mut out, context.records),
            1.. => context.records.read(job, &mut out),
        };
        let len = match result {
            Ok(len) => len.min(asked.min(context.max_data).into()),
            Err(NotDone::Yet) => return None,
            Err(NotDone::Refused(failure)) => {
                return Some(self.refuse(Function::Read.number(), Some((slot, index)), failure, context));
            }
        };
        let data = out.get(..len).unwrap_or_default();
        self.answer(ResponsePdu::Read { slot, index, data });
        Some(match (index, data) {
            (CALL_INDEX, &[_, _, high, low, ..]) => {
                let block = identification::block(u16::from_be_bytes([high, low]));
                Event::Identified { master, slot, block, written: false }
            }
            _ => {
                let len = u8::try_from(len).unwrap_or(MAX_DATA);
                Event::Read { master, channel: job.channel, slot, index, len }
            }
        })
    }

    fn identify<R: Records>(
        &mut self,
        job: &Job,
        out: &mut [u8; MAX_DATA as usize],
        records: &mut R,
    ) -> Result<usize, NotDone> {
        let call = self.call.take().filter(|(slot, _)| *slot == job.slot);
        let (_, call) = call.ok_or(NotDone::refused(ErrorCode::STATE_CONFLICT))?;
        let octets = records.identification(job.slot, call.block).map_err(NotDone::Refused)?;
        for (place, octet) in out.iter_mut().zip(call.octets().iter().chain(&octets)) {
            *place = *octet;
        }
        Ok(CALL_LEN + identification::LEN)
    }

    fn write<R: Records>(&mut self, job: &Job, data: &[u8], context: &mut Context<'_, R>) -> Option<Event> {
        let (slot, index, master) = (job.slot, job.index, job.master);
        let len = u8::try_from(data.len()).unwrap_or(MAX_DATA);
        let result = match data.len() {
            _ if len > context.max_data => Err(NotDone::refused(ErrorCode::WRITE_LENGTH)),
            0 => Err(NotDone::refused(ErrorCode::INVALID_RANGE)),
            _ if index == CALL_INDEX => self.call(job, data, context.records),
            _ => context.records.write(job, data).map(|()| None),
        };
        match result {
            Ok(written) => {
                self.answer(ResponsePdu::Write { slot, index, len });
                match written {
                    Some(block) => Some(Event::Identified { master, slot, block, written: true }),
                    // It is told when the block is read.
                    None if index == CALL_INDEX => None,
                    None => Some(Event::Written { master, channel: job.channel, slot, index, len }),
                }
            }
            Err(NotDone::Yet) => None,
            Err(NotDone::Refused(failure)) => {
                Some(self.refuse(Function::Write.number(), Some((slot, index)), failure, context))
            }
        }
    }

    /// Takes what is written to record 255: the block that was written, `None` if one is asked for.
    fn call<R: Records>(&mut self, job: &Job, data: &[u8], records: &mut R) -> Result<Option<u16>, NotDone> {
        let slot = job.slot;
        match Call::parse(data) {
            Written::Ask(call) => {
                // What is not there is refused at once.
                records.identification(slot, call.block).map_err(NotDone::Refused)?;
                self.call = Some((slot, call));
                Ok(None)
            }
            Written::Write(Call { block: 0 }, _) => Err(NotDone::refused(ErrorCode::ACCESS_DENIED)),
            Written::Write(Call { block }, octets) => {
                records.keep_identification(job, block, octets)?;
                Ok(Some(block))
            }
            Written::OtherFunction => Err(NotDone::refused(ErrorCode::NOT_SUPPORTED)),
            Written::NoBlock => Err(NotDone::refused(ErrorCode::INVALID_INDEX)),
            Written::Length => Err(NotDone::refused(ErrorCode::WRITE_LENGTH)),
        }
    }

    fn transport<R: Records>(
        &mut self,
        job: &Job,
        data: &[u8],
        context: &mut Context<'_, R>,
    ) -> Option<Event> {
        let (slot, index) = (job.slot, job.index);
        let mut out = [0; MAX_DATA as usize];
        match context.records.transport(job, data, &mut out) {
            Ok(len) => {
                let data = out.get(..len.min(context.max_data.into())).unwrap_or_default();
                self.answer(ResponsePdu::DataTransport { slot, index, data });
                None
            }
            Err(NotDone::Yet) => None,
            Err(NotDone::Refused(failure)) => {
                let function = Function::DataTransport.number();
                Some(self.refuse(function, Some((slot, index)), failure, context))
            }
        }
    }

    fn refuse<R>(
        &mut self,
        function: u8,
        place: Option<(u8, u8)>,
        failure: Failure,
        context: &Context<'_, R>,
    ) -> Event {
        self.answer(ResponsePdu::Negative { function, failure });
        Event::Refused { master: context.master, channel: context.channel, function, place, failure }
    }

    /// The response waits for the next poll.
    pub(super) fn answer(&mut self, response: ResponsePdu<'_>) {
        self.len = response.encode(&mut self.octets).map_or(0, <[u8]>::len);
        self.work = Work::Ready;
    }
}

impl Server {
    /// What is in [`Server::response`] was handed over.
    pub(super) const fn fetched(&mut self) {
        self.work = Work::Idle;
    }

    /// The reply of layer 2.
    pub(super) fn reply(&self, fdl: Fdl) -> Reply<'_> {
        match fdl {
            Fdl::Acknowledged => Reply::ShortAcknowledge,
            Fdl::NoResource => Reply::NoResource,
            Fdl::Response => Reply::DataLow(self.response()),
        }
    }
}
