//! The slave: reactions to each service, owner and watchdog, and what the application says.
//!
//! The state machine itself is in [`state`](super::state), who may do what in [`dp`](super); the start-up services
//! and the buffers behind Data_Exchange have modules of their own.

mod not_served;
mod start_up;

use core::time::Duration;

use not_served::Said;

use super::buffer::Buffer;
use super::policy::{DefaultAddress, EmptyRead, FeedsWatchdog, NoEffect, WrongOutputLength};
use super::process_data::ProcessData;
use super::slave_diag::LEN as STANDARD_DIAG_LEN;
use super::watchdog::Watchdog;
use super::{
    Access, Application, Caller, CfgFault, Description, Diagnosis, Event, ExtDiag, Fixed, GlobalControl,
    IoLengths, MASTER_SAP, Policy, Refusal, Service, State, Stimulus, StoredAddress,
};
use crate::profibus::fdl::{Address, Reply, Request};
use crate::time::Instant;

/// One DP-V0 slave and the application that judges for it.
#[derive(Clone, Debug)]
pub struct Slave<A = Fixed<'static>> {
    description: Description,
    application: A,
    policy: Policy,
    state: State,
    /// Master_Add.
    owner: Option<Address>,
    /// Waits for the owner.
    watchdog: Option<Watchdog>,
    /// Waits for the application while data are exchanged.
    user_watchdog: Option<Watchdog>,
    min_tsdr: Option<u8>,
    group_ident: u8,
    prm_fault: bool,
    cfg_fault: bool,
    not_supported: bool,
    /// No_Add_Chg of an earlier Set_Slave_Add.
    no_add_chg: bool,
    rem_slave_data: Buffer,
    /// The Set_Prm that was accepted last.
    accepted_prm: Buffer,
    /// The configuration that was accepted last.
    accepted_cfg: Option<Buffer>,
    /// What the application has yet to judge.
    pending: Option<Pending>,
    last_ticket: CfgTicket,
    process_data: ProcessData,
    /// The owner sends no outputs to a slave with Fail_Safe.
    safe_state: bool,
    ext_diag: ExtDiag,
    /// The owner has not read what was filed last: Data_Exchange is answered with DH.
    announced: bool,
    /// What was said already of what is not served.
    said: Said,
    /// What ended the last data exchange. Nobody asks a slave without `std`.
    #[cfg(feature = "std")]
    ended: Option<Event>,
    /// The octets of a reply that lie nowhere else.
    reply: Buffer,
}

/// A configuration that the application judges.
#[derive(Clone, Debug)]
struct Pending {
    ticket: CfgTicket,
    configuration: Buffer,
    lengths: IoLengths,
}

/// Which Chk_Cfg a judgement is about. A newer Set_Prm or Chk_Cfg makes it void.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CfgTicket(u32);

/// What a request led to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Handled<'a> {
    /// The reply.
    pub reply: Reply<'a>,
    /// News for the log.
    pub event: Option<Event>,
    /// A Data_Exchange of the owner was carried out.
    pub exchanged: bool,
    /// The request started the watchdog of the owner anew.
    pub fed: bool,
}

impl<A: Application> Slave<A> {
    /// A slave that has just been switched on.
    pub(crate) fn new(description: Description, application: A) -> Self {
        Self::under(Policy::PROPOSED, description, application)
    }

    /// As [`Slave::new`] with another policy from the start.
    // Not inlined: made where it will lie, instead of copied there by each caller that builds more around it.
    #[inline(never)]
    pub(crate) fn under(policy: Policy, description: Description, application: A) -> Self {
        let lengths = IoLengths::of(application.configuration(None)).unwrap_or_default();
        Self {
            description,
            application,
            policy,
            state: State::WaitPrm,
            owner: None,
            watchdog: None,
            user_watchdog: None,
            min_tsdr: None,
            group_ident: 0,
            prm_fault: false,
            cfg_fault: false,
            not_supported: false,
            no_add_chg: false,
            rem_slave_data: Buffer::EMPTY,
            accepted_prm: Buffer::EMPTY,
            accepted_cfg: None,
            pending: None,
            last_ticket: CfgTicket(0),
            process_data: ProcessData::new(lengths),
            safe_state: false,
            ext_diag: ExtDiag::NONE,
            announced: false,
            said: Said::default(),
            #[cfg(feature = "std")]
            ended: None,
            reply: Buffer::EMPTY,
        }
    }

    /// The same slave with another policy.
    #[must_use]
    pub(crate) const fn with_policy(mut self, policy: Policy) -> Self {
        self.policy = policy;
        self
    }

    /// The same slave with what an earlier Set_Slave_Add left behind: the lock bit and Rem_Slave_Data.
    #[must_use]
    pub(crate) fn with_stored(mut self, no_add_chg: bool, rem_slave_data: &[u8]) -> Self {
        self.recall(no_add_chg, rem_slave_data);
        self
    }

    pub(super) fn recall(&mut self, no_add_chg: bool, rem_slave_data: &[u8]) {
        self.no_add_chg = no_add_chg;
        self.rem_slave_data.keep([rem_slave_data, &[]]);
    }

    /// What it is.
    pub const fn description(&self) -> &Description {
        &self.description
    }

    /// Who judges for it.
    pub const fn application(&self) -> &A {
        &self.application
    }

    /// Who judges for it, to be changed: a module was plugged, say. What was accepted stays so.
    pub(crate) const fn application_mut(&mut self) -> &mut A {
        &mut self.application
    }

    /// How it behaves where the sources are silent.
    pub const fn policy(&self) -> &Policy {
        &self.policy
    }

    /// The state of the slave machine.
    pub const fn state(&self) -> State {
        self.state
    }

    /// The master that owns the slave, Master_Add.
    pub const fn owner(&self) -> Option<Address> {
        self.owner
    }

    /// The min T_SDR in T_bit that Set_Prm asked for, `None` before it did.
    pub const fn min_tsdr(&self) -> Option<u8> {
        self.min_tsdr
    }

    /// The user parameters of the Set_Prm that was accepted last, DPV1_Status octets included.
    pub fn user_prm(&self) -> &[u8] {
        self.accepted_prm.octets().get(super::set_prm::FIXED_LEN..).unwrap_or_default()
    }

    /// The configuration that was accepted last; `None` before the first.
    pub fn accepted_configuration(&self) -> Option<&[u8]> {
        self.accepted_cfg.as_ref().map(Buffer::octets)
    }

    /// The real configuration, as Get_Cfg reports it.
    pub fn configuration(&self) -> &[u8] {
        self.application.configuration(self.accepted_configuration())
    }

    /// The configuration that waits for the application's judgement, and what to judge it by.
    pub fn pending_configuration(&self) -> Option<(CfgTicket, &[u8])> {
        self.pending.as_ref().map(|pending| (pending.ticket, pending.configuration.octets()))
    }

    /// Whether a Set_Slave_Add has ruled out further ones.
    pub(crate) const fn no_add_chg(&self) -> bool {
        self.no_add_chg
    }

    /// What the last Set_Slave_Add gave the slave to keep, 0..=240 octets.
    pub fn rem_slave_data(&self) -> &[u8] {
        self.rem_slave_data.octets()
    }

    /// The outputs for the application, as many octets as configured. All zero until the first Data_Exchange.
    pub fn outputs(&self) -> &[u8] {
        self.process_data.outputs()
    }

    /// The inputs that the next Data_Exchange carries.
    pub fn inputs(&self) -> &[u8] {
        self.process_data.inputs()
    }

    /// The watchdog time of the owner, and when the watchdog expires; `None` while none runs.
    pub fn watchdog(&self) -> Option<(Duration, Instant)> {
        self.watchdog.map(|watchdog| (watchdog.time, watchdog.expires()))
    }

    /// Counts every passing of outputs to the application, cleared ones included. Changes with every Data_Exchange
    /// unless Sync holds the outputs.
    pub const fn output_updates(&self) -> u32 {
        self.process_data.output_updates()
    }

    /// Whether the owner wants the safe state (`Description::fail_safe`). The outputs are cleared then.
    pub const fn safe_state(&self) -> bool {
        self.safe_state
    }

    /// Offers the inputs for the next Data_Exchange; octets behind the 244th are dropped.
    pub(crate) fn set_inputs(&mut self, inputs: &[u8]) {
        self.process_data.set_inputs(inputs);
    }

    /// Files the extended diagnosis, to stay until the next one is filed. Unless it is the same as before, each
    /// Data_Exchange is answered with high priority until the owner has read it, that of a fault that has gone
    /// too (`dp-v0.md` 6.2 rules 1, 2 and 4).
    pub fn file_diagnosis(&mut self, diagnosis: &ExtDiag) {
        let diagnosis = diagnosis.within(self.diag_limit());
        if self.ext_diag != diagnosis {
            self.ext_diag = diagnosis;
            self.announced = true;
        }
    }

    /// Files an extended diagnosis that is no news for the owner: what it has read leaves it.
    pub(crate) fn replace_diagnosis(&mut self, diagnosis: &ExtDiag) {
        self.ext_diag = diagnosis.within(self.diag_limit());
    }

    fn diag_limit(&self) -> usize {
        usize::from(self.description.max_diag_len).saturating_sub(STANDARD_DIAG_LEN)
    }

    /// The extended diagnosis as it was filed, cut to what the description allows.
    pub const fn ext_diag(&self) -> &ExtDiag {
        &self.ext_diag
    }

    /// Whether a DP watchdog minds the owner (WD_On of Slave_Diag).
    pub const fn watchdog_on(&self) -> bool {
        self.watchdog.is_some()
    }

    /// The first six octets of the diagnosis as Slave_Diag reports it now.
    pub fn diagnosis(&self) -> Diagnosis {
        Diagnosis {
            station_not_ready: self.state != State::DataExch,
            cfg_fault: self.cfg_fault,
            ext_diag: self.ext_diag.ext_diag(),
            not_supported: self.not_supported,
            prm_fault: self.prm_fault,
            prm_req: self.state == State::WaitPrm,
            stat_diag: self.ext_diag.stat_diag(),
            wd_on: self.watchdog_on(),
            freeze_mode: self.process_data.freeze_mode(),
            sync_mode: self.process_data.sync_mode(),
            ext_diag_overflow: self.ext_diag.overflow(),
            master: self.owner,
            ident: self.description.ident,
        }
    }

    /// A telegram from `sa` that feeds the watchdog was heard at `now`: it starts anew if `sa` is the owner. Requests
    /// that are handled here call it themselves.
    pub(crate) fn heard(&mut self, now: Instant, sa: Address) {
        if let (true, Some(watchdog)) = (self.owner == Some(sa), &mut self.watchdog) {
            watchdog.heard = now;
        }
    }

    /// The application is alive at `now`: the user watchdog starts anew.
    pub(crate) const fn application_alive(&mut self, now: Instant) {
        if let Some(watchdog) = &mut self.user_watchdog {
            watchdog.heard = now;
        }
    }

    /// The application gives up: the slave leaves its master (`dp-v0.md` 7 row 25).
    pub(crate) fn abort(&mut self) -> Option<Event> {
        let master = self.owner?;
        self.leave_master(Stimulus::ApplicationLost);
        Some(self.ends_with(Event::ApplicationAborted { master }))
    }

    /// The application has judged the configuration of `ticket` at `now`. Without effect if that one is no longer
    /// waiting.
    pub(crate) fn judge_cfg(
        &mut self,
        now: Instant,
        ticket: CfgTicket,
        verdict: Result<(), Refusal>,
    ) -> Option<Event> {
        let pending = self.pending.take_if(|pending| pending.ticket == ticket)?;
        let master = self.owner?;
        match verdict {
            Ok(()) => self.accept_cfg(now, master, pending.configuration, pending.lengths),
            Err(refusal) => Some(self.refuse_cfg(master, CfgFault::Refused(refusal))),
        }
    }

    /// Carries out a request for data with reply (SRD).
    #[inline]
    pub(crate) fn handle_srd(&mut self, now: Instant, request: &Request<'_>) -> Handled<'_> {
        let service = self.service(request);
        let access = match service {
            Some(service) => service.access(self.state, self.caller(request.sa), &self.policy),
            None => Access::NotActivated,
        };
        let fed = match self.policy.feeds_watchdog {
            FeedsWatchdog::AnyTelegram => true,
            FeedsWatchdog::DpService => access == Access::Run,
        };
        if fed {
            self.heard(now, request.sa);
        }
        let mut handled = match service {
            // What masters ask for all day long.
            Some(Service::DataExchange) if access == Access::Run => self.data_exchange(request),
            Some(service) if access == Access::Run => self.run(now, service, request),
            Some(_) | None => self.not_served(service, access, request),
        };
        handled.fed = fed;
        handled
    }

    fn run(&mut self, now: Instant, service: Service, request: &Request<'_>) -> Handled<'_> {
        match service {
            Service::DataExchange => self.data_exchange(request),
            Service::SetPrm => self.set_prm(now, request),
            Service::ChkCfg => Handled::acknowledge(self.chk_cfg(now, request)),
            Service::SetSlaveAdd => self.set_slave_add(request),
            Service::SlaveDiag | Service::GetCfg | Service::RdInp | Service::RdOutp
                if !request.data.is_empty() =>
            {
                self.with_data(service, request)
            }
            Service::SlaveDiag => self.slave_diag(request.sa),
            Service::GetCfg => Handled::read(request, service, data_or_sc(self.configuration())),
            Service::RdInp => Handled::read(request, service, self.read(self.process_data.inputs())),
            Service::RdOutp => Handled::read(request, service, self.read(self.process_data.outputs())),
            // Global_Control is an SDN service.
            Service::GlobalControl => self.without_reply(service, request),
        }
    }

    /// Carries out a request without reply (SDN).
    pub(crate) fn handle_sdn(&mut self, now: Instant, request: &Request<'_>) -> Option<Event> {
        let is_control = self.service(request) == Some(Service::GlobalControl);
        let caller = self.caller(request.sa);
        let runs =
            is_control && Service::GlobalControl.access(self.state, caller, &self.policy) == Access::Run;
        let command = GlobalControl::parse(request.data, self.policy.check_reserved_control_bits);
        let feeds = match (self.policy.feeds_watchdog, request.da.is_broadcast()) {
            // Broadcasts do not unless the policy says so: a master that has dropped the slave still sends them.
            (FeedsWatchdog::AnyTelegram | FeedsWatchdog::DpService, true) => {
                is_control && self.policy.broadcast_feeds_watchdog
            }
            (FeedsWatchdog::AnyTelegram, false) => true,
            (FeedsWatchdog::DpService, false) => runs && command.is_some(),
        };
        if feeds {
            self.heard(now, request.sa);
        }
        let command = command.filter(|_| runs)?;
        if !command.addresses(self.group_ident) {
            return None;
        }
        let modes = |data: &ProcessData| (data.sync_mode(), data.freeze_mode());
        let before = modes(&self.process_data);
        let clears = command.clear_data && self.process_data.outputs().iter().any(|octet| *octet != 0);
        self.process_data.control(command);
        let changed = clears || before != modes(&self.process_data);
        if let Some(bit) = self.process_data.closed(command)
            && !changed
        {
            return self.latch_closed(request.sa, bit);
        }
        (command.asks_anything()).then_some(Event::Controlled { master: request.sa, command, changed })
    }

    /// Time has passed: a watchdog may expire. Harmless at any time.
    pub(crate) fn handle_timeout(&mut self, now: Instant) -> Option<Event> {
        let master = self.owner?;
        if let Some(after) = self.watchdog.and_then(|watchdog| watchdog.expired(now)) {
            self.leave_master(Stimulus::WatchdogExpired);
            return Some(self.ends_with(Event::WatchdogExpired { master, after }));
        }
        let after = self.user_watchdog?.expired(now)?;
        self.leave_master(Stimulus::ApplicationLost);
        Some(self.ends_with(Event::ApplicationSilent { master, after }))
    }

    /// When to call [`Slave::handle_timeout`]. Changes with every request handled or heard, and with every word of
    /// the application.
    #[must_use]
    pub(crate) fn poll_timeout(&self) -> Option<Instant> {
        let expires = |watchdog: &Option<Watchdog>| watchdog.as_ref().map(Watchdog::expires);
        Instant::first_of(expires(&self.watchdog), expires(&self.user_watchdog))
    }

    /// The service of a request that this slave offers, at the address that is asked.
    #[inline]
    fn service(&self, request: &Request<'_>) -> Option<Service> {
        let service = Service::of(request.dsap, request.ssap)?;
        match self.policy.default_address {
            DefaultAddress::Addressing if request.da == StoredAddress::DELIVERED.address => match service {
                Service::SlaveDiag | Service::GetCfg | Service::SetSlaveAdd => {}
                Service::SetPrm
                | Service::ChkCfg
                | Service::DataExchange
                | Service::RdInp
                | Service::RdOutp
                | Service::GlobalControl => return None,
            },
            DefaultAddress::Addressing | DefaultAddress::Everything => {}
        }
        let closed = service == Service::SetSlaveAdd && !self.description.set_slave_add;
        let wrong_ssap = self.policy.check_ssap && request.dsap.is_some() && request.ssap != MASTER_SAP;
        (!closed && !wrong_ssap).then_some(service)
    }

    fn caller(&self, sa: Address) -> Caller {
        if self.owner == Some(sa) { Caller::Owner } else { Caller::Other }
    }

    /// Only the owner's reading counts, and none while Stat_Diag is set (`docs/reference/dp-v0.md` 6.2 rule 2).
    fn slave_diag(&mut self, sa: Address) -> Handled<'_> {
        if self.caller(sa) == Caller::Owner && !self.ext_diag.stat_diag() {
            self.announced = false;
        }
        self.reply.keep([&self.diagnosis().octets(), self.ext_diag.octets()]);
        Handled::reply(Reply::DataLow(self.reply.octets()))
    }

    #[inline]
    fn data_exchange(&mut self, request: &Request<'_>) -> Handled<'_> {
        let master = request.sa;
        let (expected, got) = (self.process_data.lengths().outputs, request.data.len());
        if usize::from(expected) == got {
            self.state = self.state.on(Stimulus::Outputs);
            self.safe_state = false;
            self.process_data.take_outputs(request.data);
            let reply = self.with_priority(self.process_data.inputs());
            return Handled { exchanged: true, ..Handled::reply(reply) };
        }
        if got == 0 && self.description.fail_safe {
            self.state = self.state.on(Stimulus::NoOutputs);
            self.process_data.clear();
            let event = (!self.safe_state).then_some(Event::SafeState { master });
            self.safe_state = true;
            let reply = self.with_priority(self.process_data.inputs());
            return Handled { event, exchanged: true, ..Handled::reply(reply) };
        }
        // Freeze ends with the master: the inputs as they were before.
        self.reply.keep([self.process_data.inputs(), &[]]);
        self.leave_master(Stimulus::WrongOutputLength);
        let event = self.ends_with(Event::WrongOutputLength { master, expected, got });
        let reply = match self.policy.wrong_output_length {
            WrongOutputLength::NotActivated => Reply::NotActivated,
            WrongOutputLength::NoResource => Reply::NoResource,
            WrongOutputLength::Inputs => self.with_priority(self.reply.octets()),
        };
        Handled { event: Some(event), ..Handled::reply(reply) }
    }

    /// The event, which says from now on why the slave waits for Set_Prm.
    #[cfg(feature = "std")]
    pub(super) const fn ends_with(&mut self, event: Event) -> Event {
        self.ended = Some(event);
        event
    }

    /// The event; nobody asks later.
    #[cfg(not(feature = "std"))]
    pub(super) const fn ends_with(&self, event: Event) -> Event {
        event
    }

    /// What ended the last data exchange, as it was told.
    #[cfg(feature = "std")]
    pub(crate) const fn ended(&self) -> Option<Event> {
        self.ended
    }

    /// Gives up the owner and everything that came with it (`dp-v0.md` 7, Leave-Master).
    fn leave_master(&mut self, why: Stimulus) {
        self.state = self.state.on(why);
        self.owner = None;
        self.watchdog = None;
        self.user_watchdog = None;
        self.pending = None;
        self.group_ident = 0;
        self.safe_state = false;
        self.process_data.close();
    }

    /// The reply to a Data_Exchange: with high priority while a diagnosis waits for the owner. Without inputs that
    /// needs SD1, because SC has no priority (`dp-v0.md` 6.6).
    const fn with_priority<'a>(&self, inputs: &'a [u8]) -> Reply<'a> {
        if self.announced { Reply::DataHigh(inputs) } else { data_or_sc(inputs) }
    }

    fn read<'a>(&self, data: &'a [u8]) -> Reply<'a> {
        match self.policy.empty_read {
            EmptyRead::NoReplyData if data.is_empty() => Reply::NoReplyData,
            EmptyRead::NoReplyData | EmptyRead::ShortAcknowledge => data_or_sc(data),
        }
    }
}

impl<'a> Handled<'a> {
    const fn reply(reply: Reply<'a>) -> Self {
        Self { reply, event: None, exchanged: false, fed: false }
    }

    /// What a master has read.
    const fn read(request: &Request<'_>, service: Service, reply: Reply<'a>) -> Self {
        let event = Some(Event::Read { master: request.sa, service });
        Self { reply, event, exchanged: false, fed: false }
    }

    const fn acknowledge(event: Option<Event>) -> Self {
        Self { reply: Reply::ShortAcknowledge, event, exchanged: false, fed: false }
    }
}

impl From<NoEffect> for Reply<'_> {
    fn from(no_effect: NoEffect) -> Self {
        match no_effect {
            NoEffect::Acknowledged => Self::ShortAcknowledge,
            NoEffect::NotActivated => Self::NotActivated,
        }
    }
}

/// A slave with nothing to say acknowledges.
const fn data_or_sc(data: &[u8]) -> Reply<'_> {
    if data.is_empty() { Reply::ShortAcknowledge } else { Reply::DataLow(data) }
}

#[cfg(test)]
mod tests;
