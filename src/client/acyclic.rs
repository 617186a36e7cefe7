//! The master's end of the services of DP-V1: records are read and written, alarms acknowledged, connections opened and kept.
//!
//! ```text
//! class 2   Closed ──Initiate──▶ Asked ──RM──▶ Offered ──answer──▶ Open ──request──▶ Requested ──response──▶ Open ──Abort──▶ Closed
//! class 1   Open ──request──▶ Requested ──response──▶ Open
//! ```
//!
//! Source: `dp-v1.md` 1.1, 3, 4.

use core::time::Duration;

use thiserror::Error;

use crate::profibus::dpv1::connection::{
    Abort, AbortReason, AdditionalAddress, Initiate, Instance, READ_WRITE, Subnet, Terms,
};
use crate::profibus::dpv1::{
    AlarmHead, Asked, Failure, Function, MAX_DATA, MAX_PDU, MS1_SAP, PduError, RESOURCE_MANAGER_SAP,
    RequestPdu, ResponsePdu, WithCure,
};
use crate::time::Instant;

/// The SAP of a master of class 2.
const CLASS_2_SAP: u8 = 50;

/// The highest SAP of a connection.
const LAST_CONNECTION: u8 = 48;

/// The unit of Send_Timeout.
const UNIT: Duration = Duration::from_millis(10);

/// Octets of Initiate with addresses of the station itself.
const INITIATE_LEN: usize = 20;

/// The master's end of the acyclic services of one slave. It knows no bus and no clock: it says what to send, and is told what
/// layer 2 brought.
///
/// Layer 2 repeats what is not answered, with its frame count bit: a response that was lost comes again, and no request runs
/// twice.
///
/// ```
/// use core::time::Duration;
/// use profidrive::client::{AcyclicAnswer, AcyclicClient, Heard};
/// use profidrive::time::Instant;
///
/// let mut client = AcyclicClient::class_1(Duration::from_secs(5));
/// let now = Instant::ZERO;
/// client.read(now, 1, 10, 240)?;
/// let sent = client.poll_transmit(now).expect("the request");
/// assert_eq!((sent.dsap, sent.ssap, sent.data), (51, 51, &[0x5E, 1, 10, 240][..]));
/// assert!(client.handle(now, Heard::Acknowledged).is_none());
/// assert!(client.poll_transmit(now).expect("a poll").data.is_empty());
/// let answer = client.handle(now, Heard::Data(&[0x5E, 1, 10, 2, 7, 8]));
/// assert_eq!(answer, Some(Ok(AcyclicAnswer::Read(&[7, 8]))));
/// # Ok::<(), profidrive::client::NotAsked>(())
/// ```
#[derive(Clone, Debug)]
pub struct AcyclicClient {
    class: Class,
    phase: Phase,
    /// The request, then the response.
    octets: [u8; MAX_PDU],
    len: usize,
    /// How long a job may take.
    patience: Duration,
    /// When the present one is given up.
    ends: Instant,
    /// When the connection needs a sign of life.
    idle: Instant,
    /// The most octets of data that the slave takes.
    max_len: u8,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Class {
    One,
    /// Send_Timeout, times 10 ms.
    Two {
        send_timeout: u16,
    },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Closed,
    /// Initiate is to be sent.
    Asking,
    /// RM is polled for.
    Asked,
    /// The answer to Initiate is polled for.
    Offered {
        sap: u8,
    },
    Open {
        sap: u8,
    },
    /// A request is to be sent.
    Requesting {
        sap: u8,
    },
    /// Its response is polled for.
    Requested {
        sap: u8,
    },
    /// Abort is to be sent.
    Ending {
        sap: u8,
    },
}

/// A telegram to the slave: SRD.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ToSend<'a> {
    /// The SAP of the slave.
    pub dsap: u8,
    /// The SAP of the master.
    pub ssap: u8,
    /// The data behind the two.
    pub data: &'a [u8],
}

/// What layer 2 brought to the telegram that was sent last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heard<'a> {
    /// SC.
    Acknowledged,
    /// DL or DH.
    Data(&'a [u8]),
    /// RS: nothing listens at the SAP, or not for this master.
    NotActivated,
    /// RR: the slave carries out another request.
    NoResource,
    /// Nothing, however often it was repeated.
    Silence,
}

/// What came of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AcyclicAnswer<'a> {
    /// The connection is open.
    Opened {
        /// The most octets of a record.
        max_len: u8,
    },
    /// What is in the record.
    Read(&'a [u8]),
    /// The record was written.
    Written,
    /// The slave has taken the acknowledgement of an alarm.
    Acknowledged,
    /// The connection is closed.
    Closed,
}

/// Why a job failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum AcyclicError {
    /// The slave refused the service.
    #[error("{}: {}", Asked(.function.number(), *.place), WithCure(*.failure))]
    Refused {
        /// Which service.
        function: Function,
        /// Of which record, by slot and index.
        place: Option<(u8, u8)>,
        /// Why.
        failure: Failure,
    },
    /// RS at SAP 49.
    #[error("the slave has no connections of DP-V1 (SAP 49), or none is free")]
    NoConnections,
    /// RS at SAP 51, or at that of the connection.
    #[error(
        "SAP {sap} is closed: the connection has ended, or for SAP 51 the slave is not in data exchange with this master and DP-V1 enabled"
    )]
    ChannelClosed {
        /// Which SAP.
        sap: u8,
    },
    /// The slave ended the connection.
    #[error("the slave ended the connection: {}", .0.words())]
    Aborted(AbortReason),
    /// Nobody answers.
    #[error("no answer from the slave")]
    Silence,
    /// No response in time.
    #[error("no response of the slave within {} ms", .0.as_millis())]
    TimeOut(Duration),
    /// The response is none.
    #[error("the response of the slave cannot be read: {0}")]
    Malformed(PduError),
    /// The response is one to something else.
    #[error("the slave answered with something else than was asked: function {got:02X}")]
    Other {
        /// Its first octet.
        got: u8,
    },
}

/// Why a job was not begun.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum NotAsked {
    /// There is no connection.
    #[error("there is no connection; open one first")]
    NotOpen,
    /// Another job is not over.
    #[error("another job is not over")]
    Busy,
    /// More data than the slave takes.
    #[error("{got} octets of data, expected 1 to {most}")]
    Length {
        /// Octets.
        got: usize,
        /// The most.
        most: u8,
    },
}

impl AcyclicClient {
    /// The owner of a slave, at SAP 51: while it exchanges data, with DP-V1 enabled in Set_Prm. A job is given up after `patience`.
    pub const fn class_1(patience: Duration) -> Self {
        Self::new(Class::One, Phase::Open { sap: MS1_SAP }, patience)
    }

    /// Any master, over a connection, which is opened first. `send_timeout`, times 10 ms, is how often it shows life at least.
    pub const fn class_2(send_timeout: u16, patience: Duration) -> Self {
        Self::new(Class::Two { send_timeout }, Phase::Closed, patience)
    }

    const fn new(class: Class, phase: Phase, patience: Duration) -> Self {
        Self {
            class,
            phase,
            octets: [0; MAX_PDU],
            len: 0,
            patience,
            ends: Instant::ZERO,
            idle: Instant::ZERO,
            max_len: MAX_DATA,
        }
    }

    /// Whether a job can begin.
    pub const fn is_open(&self) -> bool {
        matches!(self.phase, Phase::Open { .. })
    }

    /// Opens a connection. One that is open is left as it is.
    pub fn open(&mut self, now: Instant) {
        if self.phase == Phase::Closed {
            self.phase = Phase::Asking;
            self.ends = now.saturating_add(self.patience);
        }
    }

    /// Ends the connection; the owner's channel ends with the data exchange only.
    pub const fn close(&mut self) {
        self.phase = match (self.class, self.phase) {
            (Class::One, phase) => phase,
            (Class::Two { .. }, Phase::Closed | Phase::Asking | Phase::Asked) => Phase::Closed,
            (
                Class::Two { .. },
                Phase::Offered { sap }
                | Phase::Open { sap }
                | Phase::Requesting { sap }
                | Phase::Requested { sap }
                | Phase::Ending { sap },
            ) => Phase::Ending { sap },
        };
    }

    /// Reads a record of at most `len` octets, 1..=240; the slave sends as many as there are.
    ///
    /// # Errors
    /// [`NotAsked`]
    pub fn read(&mut self, now: Instant, slot: u8, index: u8, len: u8) -> Result<(), NotAsked> {
        let len = len.min(self.max_len);
        self.ask(now, &RequestPdu::Read { slot, index, len }, len.into())
    }

    /// Writes a record.
    ///
    /// # Errors
    /// [`NotAsked`]
    pub fn write(&mut self, now: Instant, slot: u8, index: u8, data: &[u8]) -> Result<(), NotAsked> {
        self.ask(now, &RequestPdu::Write { slot, index, data }, data.len())
    }

    /// Acknowledges an alarm, which Slave_Diag has told; of the owner only.
    ///
    /// # Errors
    /// [`NotAsked`]
    pub fn acknowledge(&mut self, now: Instant, alarm: AlarmHead) -> Result<(), NotAsked> {
        self.ask(now, &RequestPdu::AlarmAck(alarm), 1)
    }

    fn ask(&mut self, now: Instant, pdu: &RequestPdu<'_>, data: usize) -> Result<(), NotAsked> {
        let sap = match self.phase {
            Phase::Open { sap } => sap,
            Phase::Closed | Phase::Ending { .. } => return Err(NotAsked::NotOpen),
            Phase::Asking
            | Phase::Asked
            | Phase::Offered { .. }
            | Phase::Requesting { .. }
            | Phase::Requested { .. } => return Err(NotAsked::Busy),
        };
        let most = self.max_len;
        let wrong = NotAsked::Length { got: data, most };
        if !(1..=usize::from(most)).contains(&data) {
            return Err(wrong);
        }
        self.len = pdu.encode(&mut self.octets).map(<[u8]>::len).ok_or(wrong)?;
        self.phase = Phase::Requesting { sap };
        self.ends = now.saturating_add(self.patience);
        Ok(())
    }

    /// What to send now; `None`: nothing before [`AcyclicClient::poll_timeout`].
    pub fn poll_transmit(&mut self, now: Instant) -> Option<ToSend<'_>> {
        let ssap = match self.class {
            Class::One => MS1_SAP,
            Class::Two { .. } => CLASS_2_SAP,
        };
        let dsap = match self.phase {
            Phase::Closed => return None,
            Phase::Asking => {
                let Class::Two { send_timeout } = self.class else { return None };
                let terms = Terms {
                    features: READ_WRITE,
                    profile_features: 0,
                    profile_ident: 0,
                    source: AdditionalAddress::STATION,
                    destination: AdditionalAddress::STATION,
                };
                let pdu = RequestPdu::Initiate(Initiate { send_timeout, terms });
                self.len = pdu.encode(&mut self.octets).map_or(0, <[u8]>::len);
                debug_assert_eq!(self.len, INITIATE_LEN, "room for all of it");
                RESOURCE_MANAGER_SAP
            }
            Phase::Asked => {
                self.len = 0;
                RESOURCE_MANAGER_SAP
            }
            Phase::Offered { sap } | Phase::Requested { sap } => {
                return Some(ToSend { dsap: sap, ssap, data: &[] });
            }
            Phase::Requesting { sap } => sap,
            Phase::Open { sap } => {
                if self.class == Class::One || now < self.idle {
                    return None;
                }
                self.len = RequestPdu::Idle.encode(&mut self.octets).map_or(0, <[u8]>::len);
                self.phase = Phase::Requesting { sap };
                self.ends = now.saturating_add(self.patience);
                sap
            }
            Phase::Ending { sap } => {
                let abort = Abort { subnet: Subnet::None, instance: Instance::User, reason: AbortReason(0) };
                self.len = RequestPdu::Abort(abort).encode(&mut self.octets).map_or(0, <[u8]>::len);
                sap
            }
        };
        Some(ToSend { dsap, ssap, data: self.octets.get(..self.len).unwrap_or_default() })
    }

    /// When there is something to send, with nothing asked.
    #[must_use]
    pub const fn poll_timeout(&self) -> Option<Instant> {
        match (self.class, self.phase) {
            (Class::Two { .. }, Phase::Open { .. }) => Some(self.idle),
            (Class::One, Phase::Open { .. }) | (_, Phase::Closed) => None,
            (
                _,
                Phase::Asking
                | Phase::Asked
                | Phase::Offered { .. }
                | Phase::Requesting { .. }
                | Phase::Requested { .. }
                | Phase::Ending { .. },
            ) => Some(Instant::ZERO),
        }
    }

    /// Takes what came to the telegram that was sent last. `Some`: the job is over.
    pub fn handle(
        &mut self,
        now: Instant,
        heard: Heard<'_>,
    ) -> Option<Result<AcyclicAnswer<'_>, AcyclicError>> {
        let phase = self.phase;
        match (phase, heard) {
            (Phase::Closed | Phase::Open { .. }, _) => None,
            // Whatever the slave says of it, this end has closed it.
            (Phase::Ending { .. }, _) => {
                self.phase = Phase::Closed;
                Some(Ok(AcyclicAnswer::Closed))
            }
            (_, Heard::Silence) => Some(Err(self.lost(AcyclicError::Silence))),
            (Phase::Asking | Phase::Asked, Heard::NotActivated) => {
                Some(Err(self.lost(AcyclicError::NoConnections)))
            }
            (
                Phase::Offered { sap } | Phase::Requesting { sap } | Phase::Requested { sap },
                Heard::NotActivated,
            ) => Some(Err(self.lost(AcyclicError::ChannelClosed { sap }))),
            (Phase::Asking, Heard::Acknowledged) => self.unless_over(now, Phase::Asked),
            (Phase::Requesting { sap }, Heard::Acknowledged) => {
                self.unless_over(now, Phase::Requested { sap })
            }
            (
                Phase::Asked
                | Phase::Offered { .. }
                | Phase::Requested { .. }
                | Phase::Asking
                | Phase::Requesting { .. },
                Heard::Acknowledged | Heard::NoResource,
            ) => self.unless_over(now, phase),
            (Phase::Asking | Phase::Asked, Heard::Data(data)) => match ResponsePdu::parse(data) {
                Ok(ResponsePdu::ResourceManager { sap, .. }) if sap <= LAST_CONNECTION => {
                    self.phase = Phase::Offered { sap };
                    None
                }
                Ok(ResponsePdu::Negative { function, failure }) => Some(Err(self.refused(function, failure))),
                Ok(_) => Some(Err(self.other(data))),
                Err(error) => Some(Err(self.malformed(error))),
            },
            (Phase::Offered { sap }, Heard::Data(data)) => match ResponsePdu::parse(data) {
                Ok(ResponsePdu::Initiate(response)) => {
                    self.max_len = response.max_len.clamp(1, MAX_DATA);
                    self.lives(now, sap);
                    Some(Ok(AcyclicAnswer::Opened { max_len: self.max_len }))
                }
                Ok(ResponsePdu::Abort(abort)) => {
                    self.phase = Phase::Closed;
                    Some(Err(AcyclicError::Aborted(abort.reason)))
                }
                Ok(ResponsePdu::Negative { function, failure }) => Some(Err(self.refused(function, failure))),
                Ok(_) => Some(Err(self.other(data))),
                Err(error) => Some(Err(self.malformed(error))),
            },
            (Phase::Requesting { sap } | Phase::Requested { sap }, Heard::Data(data)) => {
                self.respond(now, sap, data)
            }
        }
    }

    /// A response to the request in `octets`.
    fn respond(
        &mut self,
        now: Instant,
        sap: u8,
        data: &[u8],
    ) -> Option<Result<AcyclicAnswer<'_>, AcyclicError>> {
        let asked = self.octets;
        let asked = RequestPdu::parse(asked.get(..self.len).unwrap_or_default());
        let response = match ResponsePdu::parse(data) {
            Ok(response) => response,
            Err(error) => return Some(Err(self.malformed(error))),
        };
        let answer = match (asked, response) {
            (Ok(RequestPdu::Read { slot, index, len }), ResponsePdu::Read { slot: s, index: i, data })
                if (slot, index) == (s, i) && data.len() <= len.into() =>
            {
                for (place, octet) in self.octets.iter_mut().zip(data) {
                    *place = *octet;
                }
                self.len = data.len();
                self.lives(now, sap);
                let read = self.octets.get(..self.len).unwrap_or_default();
                return Some(Ok(AcyclicAnswer::Read(read)));
            }
            (Ok(RequestPdu::Write { slot, index, data }), ResponsePdu::Write { slot: s, index: i, len })
                if (slot, index, data.len()) == (s, i, len.into()) =>
            {
                AcyclicAnswer::Written
            }
            (Ok(RequestPdu::AlarmAck(alarm)), ResponsePdu::AlarmAck(other)) if alarm == other => {
                AcyclicAnswer::Acknowledged
            }
            (Ok(RequestPdu::Idle), ResponsePdu::Idle) => {
                self.lives(now, sap);
                return None;
            }
            (_, ResponsePdu::Abort(abort)) => {
                self.phase = Phase::Closed;
                return Some(Err(AcyclicError::Aborted(abort.reason)));
            }
            (Ok(_), ResponsePdu::Negative { function, failure })
                if self.octets.first() == Some(&function) =>
            {
                self.lives(now, sap);
                let function = Function::numbered(function).unwrap_or(Function::Read);
                let place = match asked {
                    Ok(RequestPdu::Read { slot, index, .. } | RequestPdu::Write { slot, index, .. }) => {
                        Some((slot, index))
                    }
                    Ok(_) | Err(_) => None,
                };
                return Some(Err(AcyclicError::Refused { function, place, failure }));
            }
            (_, _) => return Some(Err(self.other(data))),
        };
        self.lives(now, sap);
        Some(Ok(answer))
    }

    /// The connection is open and was used just now.
    fn lives(&mut self, now: Instant, sap: u8) {
        self.phase = Phase::Open { sap };
        self.idle = match self.class {
            Class::One => now,
            // Half the time: what is lost is repeated in the other half.
            Class::Two { send_timeout } => now.saturating_add(UNIT * u32::from(send_timeout) / 2),
        };
    }

    fn unless_over(&mut self, now: Instant, next: Phase) -> Option<Result<AcyclicAnswer<'_>, AcyclicError>> {
        self.phase = next;
        (now >= self.ends).then(|| Err(self.broken(AcyclicError::TimeOut(self.patience))))
    }

    fn refused(&mut self, function: u8, failure: Failure) -> AcyclicError {
        let function = Function::numbered(function).unwrap_or(Function::Initiate);
        self.lost(AcyclicError::Refused { function, place: None, failure })
    }

    fn other(&mut self, data: &[u8]) -> AcyclicError {
        self.broken(AcyclicError::Other { got: data.first().copied().unwrap_or_default() })
    }

    fn malformed(&mut self, error: PduError) -> AcyclicError {
        self.broken(AcyclicError::Malformed(error))
    }

    /// The channel is gone; that of the owner may be there again with the next job.
    const fn lost(&mut self, error: AcyclicError) -> AcyclicError {
        self.phase = match self.class {
            Class::One => Phase::Open { sap: MS1_SAP },
            Class::Two { .. } => Phase::Closed,
        };
        error
    }

    /// The other end is out of step: a connection is closed.
    const fn broken(&mut self, error: AcyclicError) -> AcyclicError {
        match self.class {
            Class::One => self.phase = Phase::Open { sap: MS1_SAP },
            Class::Two { .. } => self.close(),
        }
        error
    }
}
