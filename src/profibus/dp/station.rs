//! A slave on the bus: the passive station and the slave behind it, telegrams in, telegrams out.
//!
//! The station sorts out what is for us and what is a retry, the slave carries it out. Whoever drives a device
//! passes telegrams and time, offers inputs and takes outputs:
//!
//! ```
//! use profidrive::profibus::dp::{Description, Fixed, Station};
//! use profidrive::profibus::fdl::{Address, Framer, Resync};
//! use profidrive::time::{BaudRate, Instant};
//!
//! let description = Description { ident: 0x1234, ..Description::PLAIN };
//! let application = Fixed { configurations: &[&[0x23, 0x13]], ..Fixed::PLAIN };
//! let mut station = Station::new(Address::station(5)?, BaudRate::K500, None, description, application);
//! let mut framer = Framer::new(Resync::SCAN);
//! framer.handle_bytes(Instant::ZERO, &[0x10, 0x05, 0x02, 0x49, 0x50, 0x16], |at, result| {
//!     if let Ok(telegram) = result {
//!         station.handle_telegram(at, &telegram);
//!     }
//! });
//! let due = station.poll_timeout().expect("a reply is waiting");
//! let reply = station.poll_transmit(due).expect("it is not late");
//! assert_eq!(reply, Some(&[0x10, 0x02, 0x05, 0x00, 0x07, 0x16][..]));
//! # Ok::<(), profidrive::profibus::fdl::AddressError>(())
//! ```

use core::fmt;

use super::policy::FeedsWatchdog;
use super::{
    Application, CfgTicket, Description, Event, ExtDiag, Fixed, Policy, Refusal, Slave, StoredAddress,
};
use crate::profibus::fdl;
use crate::profibus::fdl::station::TooLate;
use crate::profibus::fdl::{Address, Reception, Reply, Request, Telegram};
use crate::time::{BaudRate, Instant};

/// A DP-V0 slave at its address, and the application that judges for it.
#[derive(Clone, Debug)]
pub struct Station<A = Fixed<'static>> {
    fdl: fdl::Station,
    slave: Slave<A>,
    /// The description has the rate of the line.
    knows_rate: bool,
    /// The last request fed the watchdog: so may its retry.
    fed: bool,
}

/// What a telegram led to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Outcome {
    /// News for the application and its user.
    pub event: Option<Event>,
    /// A Data_Exchange of the owner was carried out.
    pub exchanged: bool,
}

impl<A: Application> Station<A> {
    /// A slave that has just been switched on. `max_tsdr` as for [`fdl::Station::new`].
    pub fn new(
        address: Address,
        baud: BaudRate,
        max_tsdr: Option<u16>,
        description: Description,
        application: A,
    ) -> Self {
        Self::of(address, baud, max_tsdr, Slave::new(description, application))
    }

    /// As [`Station::new`] with another policy from the start, on less stack than [`Station::with_policy`] takes.
    pub(crate) fn under(
        policy: Policy,
        address: Address,
        baud: BaudRate,
        max_tsdr: Option<u16>,
        description: Description,
        application: A,
    ) -> Self {
        Self::of(address, baud, max_tsdr, Slave::under(policy, description, application))
    }

    /// A slave that has just been switched on and remembers an earlier Set_Slave_Add: its address and lock bit, and
    /// its Rem_Slave_Data of up to 240 octets.
    pub fn restored(
        stored: StoredAddress,
        rem_slave_data: &[u8],
        baud: BaudRate,
        max_tsdr: Option<u16>,
        description: Description,
        application: A,
    ) -> Self {
        let slave = Slave::new(description, application).with_stored(stored.no_add_chg, rem_slave_data);
        Self::of(stored.address, baud, max_tsdr, slave)
    }

    #[inline(always)]
    const fn of(address: Address, baud: BaudRate, max_tsdr: Option<u16>, slave: Slave<A>) -> Self {
        let knows_rate = slave.description().rates.contains(baud);
        let fdl = fdl::Station::under(slave.policy().fdl, address, baud, max_tsdr);
        Self { fdl, slave, knows_rate, fed: false }
    }

    /// The same station with another policy.
    #[must_use]
    pub fn with_policy(self, policy: Policy) -> Self {
        Self { fdl: self.fdl.with_policy(policy.fdl), slave: self.slave.with_policy(policy), ..self }
    }

    /// Its address.
    pub const fn address(&self) -> Address {
        self.fdl.address()
    }

    /// What to store for [`Station::restored`], with [`Slave::rem_slave_data`]. Changes with [`Event::AddressSet`].
    pub const fn stored_address(&self) -> StoredAddress {
        StoredAddress { address: self.fdl.address(), no_add_chg: self.slave.no_add_chg() }
    }

    /// As [`Station::restored`], for a station that was made already and has not answered yet.
    pub(crate) fn recall(&mut self, stored: StoredAddress, rem_slave_data: &[u8]) {
        self.fdl.set_address(stored.address);
        self.slave.recall(stored.no_add_chg, rem_slave_data);
    }

    /// The slave: its state, owner, outputs and diagnosis.
    pub const fn slave(&self) -> &Slave<A> {
        &self.slave
    }

    /// Who judges for it, to be changed: a module was plugged, say. What was accepted stays so.
    pub const fn application_mut(&mut self) -> &mut A {
        self.slave.application_mut()
    }

    /// News of this station in one line, with the words of its application where it refused something.
    pub const fn explain<'a>(&'a self, event: &'a Event) -> Explained<'a, A> {
        Explained { event, application: self.slave.application() }
    }

    /// Offers the inputs for the next Data_Exchange; octets behind the 244th are dropped.
    pub fn set_inputs(&mut self, inputs: &[u8]) {
        self.slave.set_inputs(inputs);
    }

    /// Files the extended diagnosis, to stay until the next one is filed ([`Slave::file_diagnosis`]).
    pub fn file_diagnosis(&mut self, diagnosis: &ExtDiag) {
        self.slave.file_diagnosis(diagnosis);
    }

    /// Parameters beside those of Set_Prm are wrong: the slave waits for Set_Prm with Prm_Fault.
    pub(crate) fn reject_prm(&mut self) {
        self.slave.reject_prm();
    }

    /// Puts another extended diagnosis in place of the one that is filed, without telling the master.
    pub(crate) fn replace_diagnosis(&mut self, diagnosis: &ExtDiag) {
        self.slave.replace_diagnosis(diagnosis);
    }

    /// Judges the configuration of [`Event::CfgToJudge`] at `now`. Without effect if a newer Set_Prm or Chk_Cfg has
    /// come since. A refusal names the octet that the application does not like.
    pub fn judge_cfg(
        &mut self,
        now: Instant,
        ticket: CfgTicket,
        verdict: Result<(), Refusal>,
    ) -> Option<Event> {
        self.slave.judge_cfg(now, ticket, verdict)
    }

    /// The application is alive at `now`; needed with [`Description::user_watchdog`].
    pub const fn application_alive(&mut self, now: Instant) {
        self.slave.application_alive(now);
    }

    /// The application gives up: the slave leaves its master and waits for Set_Prm.
    pub fn abort(&mut self) -> Option<Event> {
        self.slave.abort()
    }

    /// The line has another rate from now on. Where replies are dropped at all, they are after the max T_SDR that the
    /// description has for that rate.
    pub fn set_baud(&mut self, baud: BaudRate) {
        let max_tsdr = self.slave.description().rates.max_tsdr(baud);
        self.knows_rate = max_tsdr.is_some();
        self.fdl.set_baud(baud, max_tsdr.unwrap_or(baud.max_tsdr_bits()));
    }

    /// Takes a telegram whose last octet ended at `now`. At a rate that its description does not have a station hears
    /// nothing.
    pub fn handle_telegram(&mut self, now: Instant, telegram: &Telegram<'_>) -> Outcome {
        self.handle_beside(now, telegram, &mut ())
    }

    /// The same with what answers beside the slave.
    #[inline(always)]
    pub(crate) fn handle_beside(
        &mut self,
        now: Instant,
        telegram: &Telegram<'_>,
        beside: &mut impl Beside<A>,
    ) -> Outcome {
        if !self.knows_rate {
            return Outcome::default();
        }
        // By reference: a request is not copied.
        match &self.fdl.handle_telegram(now, telegram) {
            Reception::Ignored => Outcome::default(),
            Reception::Answered { sa } => {
                match self.slave.policy().feeds_watchdog {
                    FeedsWatchdog::AnyTelegram => self.slave.heard(now, *sa),
                    FeedsWatchdog::DpService => {}
                }
                Outcome::default()
            }
            Reception::Repeated { sa } => {
                if self.slave.policy().retry_feeds_watchdog && self.fed {
                    self.slave.heard(now, *sa);
                }
                Outcome::default()
            }
            Reception::Data(request) => {
                Outcome { event: self.slave.handle_sdn(now, request), exchanged: false }
            }
            Reception::DataWithReply(request) => self.serve(now, request, beside),
        }
    }

    /// Time has passed: a watchdog may expire. Harmless at any time.
    pub fn handle_timeout(&mut self, now: Instant) -> Option<Event> {
        self.slave.handle_timeout(now)
    }

    /// The reply to send at `now`, if its time has come.
    ///
    /// # Errors
    /// [`TooLate`] once if the reply was dropped because max T_SDR is over.
    #[must_use = "the octets are not offered again"]
    pub fn poll_transmit(&mut self, now: Instant) -> Result<Option<&[u8]>, TooLate> {
        self.fdl.poll_transmit(now)
    }

    /// When a reply is to be sent or a watchdog expires. Changes with every telegram received or sent and with every
    /// word of the application.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Instant> {
        Instant::first_of(self.fdl.poll_timeout(), self.slave.poll_timeout())
    }

    /// When a watchdog expires, apart from replies to be sent.
    #[must_use]
    pub(crate) fn watchdog_timeout(&self) -> Option<Instant> {
        self.slave.poll_timeout()
    }

    #[inline(always)]
    fn serve(&mut self, now: Instant, request: &Request<'_>, beside: &mut impl Beside<A>) -> Outcome {
        if let Some(reply) = beside.serve(now, &self.slave, request) {
            self.fed = false;
            self.fdl.reply(now, request, reply);
            return Outcome::default();
        }
        let handled = self.slave.handle_srd(now, request);
        self.fed = handled.fed;
        self.fdl.reply(now, request, handled.reply);
        let (event, exchanged) = (handled.event, handled.exchanged);
        if let Some(bits) = self.slave.min_tsdr() {
            self.fdl.set_min_tsdr(bits);
        }
        // Most requests are no news, and an event is large to be handed on.
        let Some(event) = event else {
            return Outcome { event: None, exchanged };
        };
        // Behind the reply, which still belongs to the old address.
        if let Event::AddressSet { stored, .. } = event {
            self.fdl.set_address(stored.address);
        }
        Outcome { event: Some(event), exchanged }
    }
}

/// What answers at service access points that are none of DP-V0, and sees what a slave is asked.
pub(crate) trait Beside<A> {
    /// The reply to a request that is none of the slave's; `None`: it is the slave's.
    fn serve(&mut self, now: Instant, slave: &Slave<A>, request: &Request<'_>) -> Option<Reply<'_>>;
}

/// Nothing: a slave of DP-V0.
impl<A> Beside<A> for () {
    #[inline(always)]
    fn serve(&mut self, _: Instant, _: &Slave<A>, _: &Request<'_>) -> Option<Reply<'_>> {
        None
    }
}

/// News of a station with the words of its application ([`Station::explain`]).
#[derive(Clone, Copy, Debug)]
pub struct Explained<'a, A> {
    event: &'a Event,
    application: &'a A,
}

impl<A: Application> fmt::Display for Explained<'_, A> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.event.fmt(f)?;
        let Some(number) = self.event.refused_number() else { return Ok(()) };
        f.write_str(": ")?;
        self.application.words(number, f)
    }
}
