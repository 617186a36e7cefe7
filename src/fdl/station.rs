//! The passive station: which telegrams are for us, which are retries, and when the reply may be sent.
//!
//! A request that is a retry by the frame count bit is answered with the stored reply and never reaches the
//! layer above (`dp-v0.md` 2.3). A retry has the stored frame count, comes from the same initiator, follows
//! directly, **and** repeats the stored telegram octet for octet: some masters keep toggling the bit over lost
//! replies and would otherwise be answered with the reply to another request.

use core::time::Duration;

use super::address::{Address, Sap};
use super::function_code::{FrameCount, Function, FunctionCode, ReplyStatus, Service};
use super::telegram::{DataTelegram, Format, MAX_PDU_LEN, MAX_TELEGRAM_LEN, Telegram};
use crate::time::{BaudRate, Instant};

/// The least time between a request and its reply before Set_Prm says otherwise, in T_bit.
pub const DEFAULT_MIN_TSDR: u8 = 11;

/// The most octets of user data in one telegram: 246 less two SAPs.
pub const MAX_USER_DATA: usize = MAX_PDU_LEN - 2;

/// One passive station on the bus.
#[derive(Clone, Debug)]
pub struct Station {
    address: Address,
    baud: BaudRate,
    min_tsdr: u8,
    max_tsdr: Option<u16>,
    /// The last counted request and its reply, kept until another telegram for us arrives.
    last: Option<Cycle>,
    last_data: [u8; MAX_PDU_LEN],
    reply: [u8; MAX_TELEGRAM_LEN],
    reply_len: u8,
    /// The end of the request that `reply` answers, while that reply has not been sent.
    pending: Option<Instant>,
}

/// What identifies a counted request (`dp-v0.md` 2.3), its data apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Cycle {
    fcb: bool,
    service: Service,
    sa: Address,
    dsap: Option<Sap>,
    ssap: Option<Sap>,
    data_len: usize,
}

/// What became of a telegram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reception<'a> {
    /// Not for us, or nothing a slave reacts to.
    Ignored,
    /// Answered here: FDL status, or a service that no DP slave offers.
    Answered {
        /// Who asked.
        sa: Address,
    },
    /// A retry: the previous reply goes out again.
    Repeated {
        /// Who asked again.
        sa: Address,
    },
    /// Data without acknowledge (SDN): to be executed, never answered.
    Data(Request<'a>),
    /// Data that want a reply (SRD): [`Station::reply`] must follow.
    DataWithReply(Request<'a>),
}

/// A request for the layer above.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Request<'a> {
    /// To whom: our address or all.
    pub da: Address,
    /// From whom.
    pub sa: Address,
    /// The service access point addressed; `None` is the default one.
    pub dsap: Option<Sap>,
    /// The service access point of the sender.
    pub ssap: Option<Sap>,
    /// The user data, 0..=246 octets.
    pub data: &'a [u8],
}

/// A reply to an SRD request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reply<'a> {
    /// SC: done, nothing to say.
    ShortAcknowledge,
    /// DL: data with low priority, 1..=244 octets.
    DataLow(&'a [u8]),
    /// RR: no resource for the data.
    NoResource,
    /// RS: service or SAP not activated.
    NotActivated,
}

/// A reply whose time was over before it could be sent, by how much.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooLate {
    /// Time since the end of the request.
    pub after: Duration,
    /// The latest time allowed, max T_SDR.
    pub limit: Duration,
}

impl Station {
    /// A station at `address` on a line at `baud`, just switched on.
    ///
    /// `max_tsdr` is the time in T_bit after which a reply is dropped instead of sent. `None` for links without
    /// true timing, where the master's patience is all there is.
    pub const fn new(address: Address, baud: BaudRate, max_tsdr: Option<u16>) -> Self {
        Self {
            address,
            baud,
            min_tsdr: DEFAULT_MIN_TSDR,
            max_tsdr,
            last: None,
            last_data: [0; MAX_PDU_LEN],
            reply: [0; MAX_TELEGRAM_LEN],
            reply_len: 0,
            pending: None,
        }
    }

    /// The station's address.
    pub const fn address(&self) -> Address {
        self.address
    }

    /// The rate of the line.
    pub const fn baud(&self) -> BaudRate {
        self.baud
    }

    /// The line has another rate from now on, and where replies are dropped at all they are after the customary max
    /// T_SDR of that rate.
    pub fn set_baud(&mut self, baud: BaudRate) {
        if self.baud != baud {
            self.baud = baud;
            self.max_tsdr = self.max_tsdr.map(|_| baud.max_tsdr_bits());
        }
    }

    /// Sets the least time between a request and its reply in T_bit. Less than 11 is taken as 11, the shortest
    /// the standard knows.
    pub const fn set_min_tsdr(&mut self, bits: u8) {
        self.min_tsdr = if bits < DEFAULT_MIN_TSDR { DEFAULT_MIN_TSDR } else { bits };
    }

    /// Takes a telegram whose last octet ended at `now`.
    ///
    /// A request on the line ends the time of a reply that has not been sent: the master has given it up, and a
    /// late one would be credited to somebody else (`dp-v0.md` 2 rule 6).
    #[must_use = "a `DataWithReply` must be answered with `Station::reply`"]
    pub fn receive<'a>(&mut self, now: Instant, telegram: &Telegram<'a>) -> Reception<'a> {
        let telegram = match telegram {
            Telegram::Data(telegram) => telegram,
            Telegram::Token { .. } => {
                self.pending = None;
                return Reception::Ignored;
            }
            Telegram::ShortAcknowledge => return Reception::Ignored,
        };
        let (service, frame_count) = match telegram.fc.function() {
            Function::Request(service, frame_count) => (service, frame_count),
            Function::Response(..) | Function::Reserved => return Reception::Ignored,
        };
        self.pending = None;
        if telegram.sa == self.address || telegram.sa.is_broadcast() {
            return Reception::Ignored;
        }
        if telegram.da.is_broadcast() {
            return match service {
                Service::SdnLow | Service::SdnHigh => Reception::Data(request(telegram)),
                Service::TimeEvent
                | Service::SdaLow
                | Service::SdaHigh
                | Service::Msrd
                | Service::FdlStatus
                | Service::SrdLow
                | Service::SrdHigh
                | Service::Ident
                | Service::LsapStatus => Reception::Ignored,
            };
        }
        if telegram.da != self.address {
            return Reception::Ignored;
        }
        match service {
            Service::SrdLow | Service::SrdHigh => self.receive_srd(now, telegram, service, frame_count),
            Service::SdnLow | Service::SdnHigh => {
                self.last = None;
                Reception::Data(request(telegram))
            }
            Service::FdlStatus => {
                self.last = None;
                if telegram.dsap.is_some() || telegram.ssap.is_some() || !telegram.data.is_empty() {
                    return Reception::Ignored;
                }
                self.answer(now, telegram.sa, ReplyStatus::Ok)
            }
            Service::SdaLow | Service::SdaHigh | Service::Ident | Service::LsapStatus => {
                self.last = None;
                self.answer(now, telegram.sa, ReplyStatus::NotActivated)
            }
            Service::TimeEvent | Service::Msrd => {
                self.last = None;
                Reception::Ignored
            }
        }
    }

    /// Answers the request that [`Station::receive`] has just handed over at `now`. The reply is sent by
    /// [`Station::poll_transmit`] once min T_SDR has passed.
    ///
    /// Addresses and SAPs are mirrored. Data of no octets or more than 244 are answered with RR: the layer above
    /// has broken its promise, the master shall not hang.
    pub fn reply(&mut self, now: Instant, request: &Request<'_>, reply: Reply<'_>) {
        let (status, data) = match reply {
            Reply::ShortAcknowledge => {
                self.schedule(now, &Telegram::ShortAcknowledge);
                return;
            }
            Reply::DataLow(data) if (1..=MAX_USER_DATA).contains(&data.len()) => (ReplyStatus::DataLow, data),
            Reply::DataLow(_) | Reply::NoResource => (ReplyStatus::NoResource, [].as_slice()),
            Reply::NotActivated => (ReplyStatus::NotActivated, [].as_slice()),
        };
        let telegram = if data.is_empty() {
            self.status_telegram(request.sa, status)
        } else {
            let (dsap, ssap) = (request.ssap, request.dsap);
            DataTelegram {
                format: DataTelegram::customary_format(dsap, ssap, data),
                da: request.sa,
                sa: self.address,
                dsap,
                ssap,
                fc: FunctionCode::response(status),
                data,
            }
        };
        self.schedule(now, &Telegram::Data(telegram));
    }

    /// The reply to send at `now`, if its time has come.
    ///
    /// # Errors
    /// [`TooLate`] once if the reply was dropped because max T_SDR is over.
    #[must_use = "the octets are not offered again"]
    pub fn poll_transmit(&mut self, now: Instant) -> Result<Option<&[u8]>, TooLate> {
        let Some(end) = self.pending.filter(|end| self.earliest(*end) <= now) else {
            return Ok(None);
        };
        self.pending = None;
        let after = now.saturating_since(end);
        match self.max_tsdr.map(|bits| self.baud.bit_times(bits.into())) {
            Some(limit) if after > limit => Err(TooLate { after, limit }),
            Some(_) | None => Ok(self.reply.get(..self.reply_len.into())),
        }
    }

    /// When [`Station::poll_transmit`] has something to send. Changes with every telegram received or sent.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Instant> {
        self.pending.map(|end| self.earliest(end))
    }

    fn earliest(&self, end: Instant) -> Instant {
        end.saturating_add(self.baud.bit_times(self.min_tsdr.into()))
    }

    fn receive_srd<'a>(
        &mut self,
        now: Instant,
        telegram: &DataTelegram<'a>,
        service: Service,
        frame_count: FrameCount,
    ) -> Reception<'a> {
        let fcb = match frame_count {
            // Rule 6: not evaluated.
            FrameCount::Unused => {
                self.last = None;
                return Reception::DataWithReply(request(telegram));
            }
            FrameCount::Even => false,
            FrameCount::First | FrameCount::Odd => true,
        };
        let cycle = Cycle {
            fcb,
            service,
            sa: telegram.sa,
            dsap: telegram.dsap,
            ssap: telegram.ssap,
            data_len: telegram.data.len(),
        };
        // Rule 1: a first cycle is never a retry. Rule 4: the stored FCB, the same initiator, directly after.
        if frame_count != FrameCount::First
            && self.last == Some(cycle)
            && self.last_data.get(..cycle.data_len) == Some(telegram.data)
        {
            self.pending = Some(now);
            return Reception::Repeated { sa: telegram.sa };
        }
        // Rules 2 and 3: new, and stored.
        self.last = Some(cycle);
        if let Some(room) = self.last_data.get_mut(..cycle.data_len) {
            room.copy_from_slice(telegram.data);
        }
        Reception::DataWithReply(request(telegram))
    }

    fn answer<'a>(&mut self, now: Instant, sa: Address, status: ReplyStatus) -> Reception<'a> {
        let telegram = self.status_telegram(sa, status);
        self.schedule(now, &Telegram::Data(telegram));
        Reception::Answered { sa }
    }

    /// SD1 with a status and nothing else.
    const fn status_telegram<'a>(&self, da: Address, status: ReplyStatus) -> DataTelegram<'a> {
        DataTelegram {
            format: Format::Sd1,
            da,
            sa: self.address,
            dsap: None,
            ssap: None,
            fc: FunctionCode::response(status),
            data: &[],
        }
    }

    fn schedule(&mut self, now: Instant, telegram: &Telegram<'_>) {
        // Cannot fail: the data were measured before, and the buffer holds the longest telegram.
        let len = telegram.encode(&mut self.reply).map_or(0, <[u8]>::len);
        self.reply_len = u8::try_from(len).unwrap_or(0);
        self.pending = (len > 0).then_some(now);
    }
}

const fn request<'a>(telegram: &DataTelegram<'a>) -> Request<'a> {
    Request {
        da: telegram.da,
        sa: telegram.sa,
        dsap: telegram.dsap,
        ssap: telegram.ssap,
        data: telegram.data,
    }
}

#[cfg(test)]
mod tests;
