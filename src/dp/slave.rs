//! The slave: reactions to each service, owner and watchdog, and what the application says.
//!
//! The state machine itself is in [`state`](super::state), who may do what in [`dp`](super); the start-up services
//! and the buffers behind Data_Exchange have modules of their own.

mod start_up;

use core::time::Duration;

use super::buffer::Buffer;
use super::policy::{EmptyRead, NoEffect, WrongOutputLength};
use super::process_data::ProcessData;
use super::slave_diag::LEN as STANDARD_DIAG_LEN;
use super::watchdog::Watchdog;
use super::{
    Access, Caller, CfgFault, Description, Diagnosis, Event, ExtDiag, GlobalControl, IoLengths, Policy,
    Service, State, Stimulus,
};
use crate::fdl::{Address, Reply, Request, Sap};
use crate::time::Instant;

/// The SSAP of masters.
const MASTER_SAP: Option<Sap> = Sap::new(62);

/// One DP-V0 slave.
#[derive(Clone, Debug)]
pub struct Slave {
    description: Description,
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
    /// The accepted configuration.
    configuration: &'static [u8],
    /// What the application has yet to judge.
    pending: Option<Pending>,
    last_ticket: CfgTicket,
    process_data: ProcessData,
    /// The owner sends no outputs to a slave with Fail_Safe.
    safe_state: bool,
    ext_diag: ExtDiag,
    /// The owner has not read what was filed last: Data_Exchange is answered with DH.
    announced: bool,
    /// The octets of a reply that lie nowhere else.
    reply: Buffer,
}

/// A configuration that the application judges.
#[derive(Clone, Copy, Debug)]
struct Pending {
    ticket: CfgTicket,
    configuration: &'static [u8],
}

/// Which Chk_Cfg a judgement is about. A newer Set_Prm or Chk_Cfg makes it void.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CfgTicket(u32);

/// What a request led to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Handled<'a> {
    /// The reply.
    pub reply: Reply<'a>,
    /// News for the log.
    pub event: Option<Event>,
    /// A Data_Exchange of the owner was carried out.
    pub exchanged: bool,
}

impl Slave {
    /// A slave that has just been switched on.
    pub fn new(description: Description) -> Self {
        let configuration = description.configurations.first().copied().unwrap_or_default();
        Self {
            description,
            policy: Policy::PROPOSED,
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
            configuration,
            pending: None,
            last_ticket: CfgTicket(0),
            process_data: ProcessData::new(IoLengths::of(configuration).unwrap_or_default()),
            safe_state: false,
            ext_diag: ExtDiag::NONE,
            announced: false,
            reply: Buffer::EMPTY,
        }
    }

    /// The same slave with another policy.
    #[must_use]
    pub const fn with_policy(mut self, policy: Policy) -> Self {
        self.policy = policy;
        self
    }

    /// The same slave with what an earlier Set_Slave_Add left behind: the lock bit and Rem_Slave_Data.
    #[must_use]
    pub fn with_stored(mut self, no_add_chg: bool, rem_slave_data: &[u8]) -> Self {
        self.no_add_chg = no_add_chg;
        self.rem_slave_data.keep([rem_slave_data, &[]]);
        self
    }

    /// What it is.
    pub const fn description(&self) -> &Description {
        &self.description
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

    /// The accepted configuration, as Get_Cfg reports it.
    pub const fn configuration(&self) -> &'static [u8] {
        self.configuration
    }

    /// The configuration that waits for the application's judgement, and what to judge it by.
    pub fn pending_configuration(&self) -> Option<(CfgTicket, &'static [u8])> {
        self.pending.map(|pending| (pending.ticket, pending.configuration))
    }

    /// Whether a Set_Slave_Add has ruled out further ones.
    pub const fn no_add_chg(&self) -> bool {
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
    pub fn set_inputs(&mut self, inputs: &[u8]) {
        self.process_data.set_inputs(inputs);
    }

    /// Files the extended diagnosis, to stay until the next one is filed. Unless it is the same as before, each
    /// Data_Exchange is answered with high priority until the owner has read it, that of a fault that has gone
    /// too (`dp-v0.md` 6.2 rules 1, 2 and 4).
    pub fn file_diagnosis(&mut self, diagnosis: &ExtDiag) {
        let limit = usize::from(self.description.max_diag_len).saturating_sub(STANDARD_DIAG_LEN);
        let diagnosis = diagnosis.within(limit);
        if self.ext_diag != diagnosis {
            self.ext_diag = diagnosis;
            self.announced = true;
        }
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

    /// A telegram from `sa` that feeds the watchdog was heard at `now`: it starts anew if `sa` is the owner.
    pub fn heard(&mut self, now: Instant, sa: Address) {
        if let (true, Some(watchdog)) = (self.owner == Some(sa), &mut self.watchdog) {
            watchdog.heard = now;
        }
    }

    /// The application is alive at `now`: the user watchdog starts anew.
    pub const fn application_alive(&mut self, now: Instant) {
        if let Some(watchdog) = &mut self.user_watchdog {
            watchdog.heard = now;
        }
    }

    /// The application gives up: the slave leaves its master (`dp-v0.md` 7 row 25).
    pub fn abort(&mut self) -> Option<Event> {
        let master = self.owner?;
        self.leave_master(Stimulus::ApplicationLost);
        Some(Event::ApplicationAborted { master })
    }

    /// The application has judged the configuration of `ticket` at `now`. Without effect if that one is no longer
    /// waiting.
    pub fn judge_cfg(
        &mut self,
        now: Instant,
        ticket: CfgTicket,
        verdict: Result<(), CfgFault>,
    ) -> Option<Event> {
        let pending = self.pending.filter(|pending| pending.ticket == ticket)?;
        let master = self.owner?;
        match verdict {
            Ok(()) => self.accept_cfg(now, master, pending.configuration),
            Err(fault) => Some(self.refuse_cfg(master, fault)),
        }
    }

    /// Carries out a request for data with reply (SRD).
    pub fn handle_srd(&mut self, now: Instant, request: &Request<'_>) -> Handled<'_> {
        let Some(service) = self.service(request) else {
            return Handled::reply(Reply::NotActivated);
        };
        match service.access(self.state, self.caller(request.sa), &self.policy) {
            Access::Run => {}
            Access::NotActivated | Access::Ignored => return Handled::reply(Reply::NotActivated),
            Access::Acknowledged => return Handled::reply(Reply::ShortAcknowledge),
        }
        match service {
            Service::DataExchange => self.data_exchange(request),
            Service::SetPrm => self.set_prm(now, request),
            Service::ChkCfg => Handled::acknowledge(self.chk_cfg(now, request)),
            Service::SetSlaveAdd => self.set_slave_add(request),
            Service::SlaveDiag | Service::GetCfg | Service::RdInp | Service::RdOutp
                if !request.data.is_empty() =>
            {
                Handled::reply(Reply::NoResource)
            }
            Service::SlaveDiag => self.slave_diag(request.sa),
            Service::GetCfg => Handled::reply(data_or_sc(self.configuration)),
            Service::RdInp => Handled::reply(self.read(self.process_data.inputs())),
            Service::RdOutp => Handled::reply(self.read(self.process_data.outputs())),
            // Global_Control is an SDN service.
            Service::GlobalControl => Handled::reply(Reply::NotActivated),
        }
    }

    /// Carries out a request without reply (SDN).
    pub fn handle_sdn(&mut self, request: &Request<'_>) -> Option<Event> {
        if self.service(request) != Some(Service::GlobalControl) {
            return None;
        }
        let caller = self.caller(request.sa);
        if Service::GlobalControl.access(self.state, caller, &self.policy) != Access::Run {
            return None;
        }
        let command = GlobalControl::parse(request.data, self.policy.check_reserved_control_bits)?;
        if !command.addresses(self.group_ident) {
            return None;
        }
        self.process_data.control(command);
        command.clear_data.then_some(Event::OutputsCleared { master: request.sa })
    }

    /// Time has passed: a watchdog may expire. Harmless at any time.
    pub fn handle_timeout(&mut self, now: Instant) -> Option<Event> {
        let master = self.owner?;
        if let Some(after) = self.watchdog.and_then(|watchdog| watchdog.expired(now)) {
            self.leave_master(Stimulus::WatchdogExpired);
            return Some(Event::WatchdogExpired { master, after });
        }
        let after = self.user_watchdog?.expired(now)?;
        self.leave_master(Stimulus::ApplicationLost);
        Some(Event::ApplicationSilent { master, after })
    }

    /// When to call [`Slave::handle_timeout`]. Changes with every request handled or heard, and with every word of
    /// the application.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Instant> {
        let expires = |watchdog: &Option<Watchdog>| watchdog.as_ref().map(Watchdog::expires);
        Instant::first_of(expires(&self.watchdog), expires(&self.user_watchdog))
    }

    /// The service of a request that this slave offers.
    fn service(&self, request: &Request<'_>) -> Option<Service> {
        let service = Service::of(request.dsap, request.ssap)?;
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

    fn data_exchange(&mut self, request: &Request<'_>) -> Handled<'_> {
        let master = request.sa;
        let (expected, got) = (self.process_data.lengths().outputs, request.data.len());
        if usize::from(expected) == got {
            self.state = self.state.on(Stimulus::Outputs);
            self.safe_state = false;
            self.process_data.receive(request.data);
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
        let reply = match self.policy.wrong_output_length {
            WrongOutputLength::NotActivated => Reply::NotActivated,
            WrongOutputLength::NoResource => Reply::NoResource,
            WrongOutputLength::Inputs => self.with_priority(self.reply.octets()),
        };
        Handled { event: Some(Event::WrongOutputLength { master, expected, got }), ..Handled::reply(reply) }
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
        Self { reply, event: None, exchanged: false }
    }

    const fn acknowledge(event: Option<Event>) -> Self {
        Self { reply: Reply::ShortAcknowledge, event, exchanged: false }
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
