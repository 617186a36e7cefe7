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
use crate::time::{BaudRate, Instant, nanos};

/// The least time between a request and its reply before Set_Prm says otherwise, in T_bit.
pub(crate) const DEFAULT_MIN_TSDR: u8 = 11;

/// The most octets of user data in one telegram: 246 less two SAPs.
pub(crate) const MAX_USER_DATA: usize = MAX_PDU_LEN - 2;

/// One passive station on the bus.
#[derive(Clone, Debug)]
pub struct Station {
    policy: Policy,
    address: Address,
    /// The address given up by the last telegram for us: a retry of that one is still answered.
    former: Option<Address>,
    baud: BaudRate,
    min_tsdr: u8,
    max_tsdr: Option<u16>,
    /// What they are at `baud`.
    window: Window,
    /// The last counted request, kept with its reply until another telegram for us arrives.
    last: Option<Cycle>,
    last_data: [u8; MAX_PDU_LEN],
    reply: [u8; MAX_TELEGRAM_LEN],
    reply_len: u8,
    /// The reply to what is not counted, apart, so that it does not overwrite a stored one.
    short_reply: [u8; SHORT_LEN],
    /// The end of the request and the reply that waits for its time.
    pending: Option<(Instant, Waiting)>,
}

/// When a reply may be sent, from the end of its request on. Worked out when it changes: each bit time is a division.
#[derive(Clone, Copy, Debug)]
struct Window {
    /// In ns, as [`Instant`] counts: a [`Duration`] is two numbers that each reply would put together.
    earliest: u64,
    /// In ns. A master may set a min T_SDR behind max T_SDR: the time allowed is then as long and begins with it, or
    /// nobody could ever talk to the station again, not even to set another.
    latest: Option<u64>,
}

impl Window {
    const fn of(baud: BaudRate, min_tsdr: u8, max_tsdr: Option<u16>) -> Self {
        let min = min_tsdr as u32;
        let latest = match max_tsdr {
            Some(max) if min < max as u32 => Some(nanos(baud.bit_times(max as u32))),
            Some(max) => Some(nanos(baud.bit_times(min + max as u32))),
            None => None,
        };
        Self { earliest: nanos(baud.bit_times(min)), latest }
    }
}

/// Octets of a telegram without data.
const SHORT_LEN: usize = 6;

/// Which reply is to be sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Waiting {
    /// `reply`.
    Counted,
    /// `short_reply`.
    Short,
}

/// How a passive station behaves where the sources are silent (`dp-v0.md` 16 points 6 and 11).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Policy {
    /// Whether an FDL status request between a request and its retry drops the stored reply, so that the retry is
    /// carried out as new.
    pub status_drops_reply: bool,
    /// The octets that answer a request for identification, 1..=244: four lengths and the four texts vendor,
    /// controller, hardware release and software release. `None`: RS.
    pub ident: Option<&'static [u8]>,
    /// What a request for LSAP status gets.
    pub lsap_status: NotOffered,
    /// What Send Data with Acknowledge (SDA) gets.
    pub sda: NotOffered,
}

impl Policy {
    /// What `dp-v0.md` proposes.
    pub(crate) const PROPOSED: Self = Self {
        status_drops_reply: true,
        ident: None,
        lsap_status: NotOffered::NotActivated,
        sda: NotOffered::NotActivated,
    };
}

/// The answer to a service that the station does not offer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum NotOffered {
    /// RS.
    NotActivated,
    /// None.
    Silence,
}

/// What identifies a counted request (`dp-v0.md` 2.3), its data apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Cycle {
    fcb: bool,
    service: Service,
    da: Address,
    sa: Address,
    dsap: Option<Sap>,
    ssap: Option<Sap>,
    data_len: usize,
}

impl Cycle {
    /// `None` if the request is not counted.
    const fn of(telegram: &DataTelegram<'_>, service: Service, frame_count: FrameCount) -> Option<Self> {
        let Some(fcb) = Self::frame_count_bit(frame_count) else { return None };
        Some(Self {
            fcb,
            service,
            da: telegram.da,
            sa: telegram.sa,
            dsap: telegram.dsap,
            ssap: telegram.ssap,
            data_len: telegram.data.len(),
        })
    }

    /// The frame count bit of a request that is counted.
    const fn frame_count_bit(frame_count: FrameCount) -> Option<bool> {
        match frame_count {
            FrameCount::Unused => None,
            FrameCount::Even => Some(false),
            FrameCount::First | FrameCount::Odd => Some(true),
        }
    }
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
    /// DH: data with high priority, 0..=244 octets; without octets in SD1.
    DataHigh(&'a [u8]),
    /// NR: no reply data ready.
    NoReplyData,
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
        Self::under(Policy::PROPOSED, address, baud, max_tsdr)
    }

    /// As [`Station::new`] with another policy from the start.
    #[inline]
    pub const fn under(policy: Policy, address: Address, baud: BaudRate, max_tsdr: Option<u16>) -> Self {
        Self {
            policy,
            address,
            former: None,
            baud,
            min_tsdr: DEFAULT_MIN_TSDR,
            max_tsdr,
            window: Window::of(baud, DEFAULT_MIN_TSDR, max_tsdr),
            last: None,
            last_data: [0; MAX_PDU_LEN],
            reply: [0; MAX_TELEGRAM_LEN],
            reply_len: 0,
            short_reply: [0; SHORT_LEN],
            pending: None,
        }
    }

    /// The same station with another policy.
    #[must_use]
    pub const fn with_policy(mut self, policy: Policy) -> Self {
        self.policy = policy;
        self
    }

    /// The station's address.
    pub const fn address(&self) -> Address {
        self.address
    }

    /// The station has another address from the request on that it has just answered. Until the next telegram for
    /// it, a retry of that request to the old address still gets the same reply.
    pub const fn set_address(&mut self, address: Address) {
        self.former = Some(self.address);
        self.address = address;
    }

    /// The line has another rate from now on, and where replies are dropped at all they are after this max T_SDR.
    pub const fn set_baud(&mut self, baud: BaudRate, max_tsdr: u16) {
        // The rate as before: what the constructor was given holds.
        if self.baud.bits_per_second() == baud.bits_per_second() {
            return;
        }
        self.baud = baud;
        if self.max_tsdr.is_some() {
            self.max_tsdr = Some(max_tsdr);
        }
        self.window = Window::of(self.baud, self.min_tsdr, self.max_tsdr);
    }

    /// Sets the least time between a request and its reply in T_bit. Less than 11 is taken as 11, the shortest
    /// the standard knows.
    pub(crate) const fn set_min_tsdr(&mut self, bits: u8) {
        let bits = if bits < DEFAULT_MIN_TSDR { DEFAULT_MIN_TSDR } else { bits };
        if self.min_tsdr != bits {
            self.min_tsdr = bits;
            self.window = Window::of(self.baud, self.min_tsdr, self.max_tsdr);
        }
    }

    /// Takes a telegram whose last octet ended at `now`.
    ///
    /// A request on the line ends the time of a reply that has not been sent: the master has given it up, and a
    /// late one would be credited to somebody else (`dp-v0.md` 2 rule 6).
    #[must_use = "a `DataWithReply` must be answered with `Station::reply`"]
    #[inline]
    pub fn handle_telegram<'a>(&mut self, now: Instant, telegram: &Telegram<'a>) -> Reception<'a> {
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
            return self.answer_at_former(now, telegram, service, frame_count);
        }
        self.former = None;
        match service {
            Service::SrdLow | Service::SrdHigh => self.answer_srd(now, telegram, service, frame_count),
            Service::SdnLow | Service::SdnHigh => {
                self.last = None;
                Reception::Data(request(telegram))
            }
            Service::FdlStatus => {
                if self.policy.status_drops_reply {
                    self.last = None;
                }
                if telegram.dsap.is_some() || telegram.ssap.is_some() || !telegram.data.is_empty() {
                    return Reception::Ignored;
                }
                self.answer(now, telegram.sa, ReplyStatus::Ok)
            }
            Service::SdaLow | Service::SdaHigh => self.decline(now, telegram.sa, self.policy.sda),
            Service::LsapStatus => self.decline(now, telegram.sa, self.policy.lsap_status),
            Service::Ident => {
                self.last = None;
                let reply = self.policy.ident.map_or(Reply::NotActivated, Reply::DataLow);
                self.reply(now, &request(telegram), reply);
                Reception::Answered { sa: telegram.sa }
            }
            Service::TimeEvent | Service::Msrd => {
                self.last = None;
                Reception::Ignored
            }
        }
    }

    /// Answers the request that [`Station::handle_telegram`] has just handed over at `now`. The reply is sent by
    /// [`Station::poll_transmit`] once min T_SDR has passed.
    ///
    /// Addresses and SAPs are mirrored. Data of more octets than [`Reply`] allows, or fewer, are answered with RR: the
    /// layer above has broken its promise, the master shall not hang.
    #[inline]
    pub fn reply(&mut self, now: Instant, request: &Request<'_>, reply: Reply<'_>) {
        let (status, data) = match reply {
            Reply::ShortAcknowledge => {
                let len = Telegram::ShortAcknowledge.encode(&mut self.reply).map_or(0, <[u8]>::len);
                return self.schedule(now, len);
            }
            Reply::DataLow(data) if (1..=MAX_USER_DATA).contains(&data.len()) => (ReplyStatus::DataLow, data),
            Reply::DataHigh(data) if data.len() <= MAX_USER_DATA => (ReplyStatus::DataHigh, data),
            Reply::DataLow(_) | Reply::DataHigh(_) | Reply::NoResource => {
                (ReplyStatus::NoResource, [].as_slice())
            }
            Reply::NoReplyData => (ReplyStatus::NotReady, [].as_slice()),
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
        let len = telegram.encode(&mut self.reply).map_or(0, <[u8]>::len);
        self.schedule(now, len);
    }

    /// The reply to send at `now`, if its time has come.
    ///
    /// # Errors
    /// [`TooLate`] once if the reply was dropped because max T_SDR is over, or as much time behind a min T_SDR that
    /// the master has set beyond it.
    #[must_use = "the octets are not offered again"]
    #[inline]
    pub fn poll_transmit(&mut self, now: Instant) -> Result<Option<&[u8]>, TooLate> {
        let Some((end, waiting)) = self.pending.filter(|(end, _)| self.earliest(*end) <= now) else {
            return Ok(None);
        };
        let reply = match waiting {
            Waiting::Counted => self.reply.get(..self.reply_len.into()),
            Waiting::Short => Some(self.short_reply.as_slice()),
        };
        self.pending = None;
        let after = now.as_nanos().saturating_sub(end.as_nanos());
        match self.window.latest {
            Some(limit) if after > limit => {
                Err(TooLate { after: Duration::from_nanos(after), limit: Duration::from_nanos(limit) })
            }
            Some(_) | None => Ok(reply),
        }
    }

    /// When [`Station::poll_transmit`] has something to send. Changes with every telegram received or sent.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Instant> {
        self.pending.map(|(end, _)| self.earliest(end))
    }

    fn earliest(&self, end: Instant) -> Instant {
        Instant::from_nanos(end.as_nanos().saturating_add(self.window.earliest))
    }

    #[inline(always)]
    fn answer_srd<'a>(
        &mut self,
        now: Instant,
        telegram: &DataTelegram<'a>,
        service: Service,
        frame_count: FrameCount,
    ) -> Reception<'a> {
        let Some(fcb) = Cycle::frame_count_bit(frame_count) else {
            // Rule 6: not evaluated.
            self.last = None;
            return Reception::DataWithReply(request(telegram));
        };
        // A new request nearly always has the other bit: then nothing else is compared.
        let same_bit = self.last.is_some_and(|last| last.fcb == fcb);
        if same_bit && self.is_retry(telegram, service, frame_count) {
            self.pending = Some((now, Waiting::Counted));
            return Reception::Repeated { sa: telegram.sa };
        }
        // Rules 2 and 3: new, and stored.
        self.last = Cycle::of(telegram, service, frame_count);
        if let Some(room) = self.last_data.get_mut(..telegram.data.len()) {
            room.copy_from_slice(telegram.data);
        }
        Reception::DataWithReply(request(telegram))
    }

    /// A telegram that is not for our address: the retry of the one that took an address from us is (C-05).
    fn answer_at_former<'a>(
        &mut self,
        now: Instant,
        telegram: &DataTelegram<'a>,
        service: Service,
        frame_count: FrameCount,
    ) -> Reception<'a> {
        if self.former != Some(telegram.da) {
            return Reception::Ignored;
        }
        let retry = match service {
            Service::SrdLow | Service::SrdHigh => self.is_retry(telegram, service, frame_count),
            Service::TimeEvent
            | Service::SdaLow
            | Service::SdaHigh
            | Service::SdnLow
            | Service::SdnHigh
            | Service::Msrd
            | Service::FdlStatus
            | Service::Ident
            | Service::LsapStatus => false,
        };
        if !retry {
            self.former = None;
            return Reception::Ignored;
        }
        self.pending = Some((now, Waiting::Counted));
        Reception::Repeated { sa: telegram.sa }
    }

    /// Rule 1: a first cycle is never a retry. Rule 4: the stored FCB, the same initiator, directly after.
    #[inline(never)]
    fn is_retry(&self, telegram: &DataTelegram<'_>, service: Service, frame_count: FrameCount) -> bool {
        frame_count != FrameCount::First
            && self.last.is_some()
            && self.last == Cycle::of(telegram, service, frame_count)
            && self.last_data.get(..telegram.data.len()) == Some(telegram.data)
    }

    fn decline<'a>(&mut self, now: Instant, sa: Address, not_offered: NotOffered) -> Reception<'a> {
        self.last = None;
        match not_offered {
            NotOffered::NotActivated => self.answer(now, sa, ReplyStatus::NotActivated),
            NotOffered::Silence => Reception::Ignored,
        }
    }

    fn answer<'a>(&mut self, now: Instant, sa: Address, status: ReplyStatus) -> Reception<'a> {
        // Cannot fail: an SD1 telegram has six octets.
        let telegram = self.status_telegram(sa, status);
        self.pending = telegram.encode(&mut self.short_reply).is_ok().then_some((now, Waiting::Short));
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

    /// `reply` holds a telegram of so many octets; 0 cannot be: its data were measured before, and the buffer holds the
    /// longest telegram.
    #[inline]
    fn schedule(&mut self, now: Instant, len: usize) {
        self.reply_len = u8::try_from(len).unwrap_or(0);
        self.pending = (len > 0).then_some((now, Waiting::Counted));
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
