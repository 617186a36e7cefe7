//! The slave: reactions to each service, the buffers behind Data_Exchange, owner and watchdog.
//!
//! The state machine itself is in [`state`](super::state), who may do what in [`dp`](super).

use core::time::Duration;

use super::chk_cfg::MAX_IO_LEN;
use super::global_control::{GlobalControl, Latch};
use super::{
    Access, Caller, CfgFault, Diagnosis, Event, IoLengths, PrmFault, Service, SetPrm, State, Stimulus,
};
use crate::fdl::{Address, Reply, Request};
use crate::time::Instant;

/// What kind of slave it is: the facts its GSD states. The default has neither inputs nor outputs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Description {
    /// Ident_Number.
    pub ident: u16,
    /// The configurations Chk_Cfg accepts; Get_Cfg reports the first until another one was accepted.
    pub configurations: &'static [&'static [u8]],
    /// Octets of user parameters in Set_Prm.
    pub user_prm_len: u8,
    /// Whether Sync is supported.
    pub sync_mode: bool,
    /// Whether Freeze is supported.
    pub freeze_mode: bool,
}

/// One DP-V0 slave.
#[derive(Clone, Debug)]
pub struct Slave {
    description: Description,
    state: State,
    /// Master_Add.
    owner: Option<Address>,
    watchdog: Option<Watchdog>,
    min_tsdr: Option<u8>,
    group_ident: u8,
    prm_fault: bool,
    cfg_fault: bool,
    not_supported: bool,
    /// The accepted configuration and its lengths.
    configuration: &'static [u8],
    lengths: IoLengths,
    sync: Mode,
    freeze: Mode,
    /// What the application sees.
    outputs: Octets,
    /// What Data_Exchange brought while Sync holds the outputs.
    waiting_outputs: Octets,
    /// What the application offers.
    inputs: Octets,
    /// What Freeze holds.
    frozen_inputs: Octets,
    /// Counts what is passed to the application.
    outputs_passed: u32,
    diagnosis: [u8; super::slave_diag::LEN],
}

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
            state: State::WaitPrm,
            owner: None,
            watchdog: None,
            min_tsdr: None,
            group_ident: 0,
            prm_fault: false,
            cfg_fault: false,
            not_supported: false,
            configuration,
            lengths: IoLengths::of(configuration).unwrap_or_default(),
            sync: Mode::Closed,
            freeze: Mode::Closed,
            outputs: Octets::EMPTY,
            waiting_outputs: Octets::EMPTY,
            inputs: Octets::EMPTY,
            frozen_inputs: Octets::EMPTY,
            outputs_passed: 0,
            diagnosis: [0; super::slave_diag::LEN],
        }
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

    /// The outputs for the application, as many octets as configured. All zero until the first Data_Exchange.
    pub fn outputs(&self) -> &[u8] {
        self.outputs.first(self.lengths.outputs)
    }

    /// Counts every passing of outputs to the application, cleared ones included. Changes with every Data_Exchange
    /// unless Sync holds the outputs.
    pub const fn outputs_passed(&self) -> u32 {
        self.outputs_passed
    }

    /// Offers the inputs for the next Data_Exchange; octets behind the 244th are dropped.
    pub fn set_inputs(&mut self, inputs: &[u8]) {
        self.inputs.copy(inputs);
    }

    /// The diagnosis as Slave_Diag reports it now.
    pub fn diagnosis(&self) -> Diagnosis {
        Diagnosis {
            station_not_ready: self.state != State::DataExch,
            cfg_fault: self.cfg_fault,
            not_supported: self.not_supported,
            prm_fault: self.prm_fault,
            prm_req: self.state == State::WaitPrm,
            wd_on: self.watchdog.is_some(),
            freeze_mode: self.freeze == Mode::Active,
            sync_mode: self.sync == Mode::Active,
            master: self.owner,
            ident: self.description.ident,
        }
    }

    /// A telegram from `sa` to this station was heard at `now`, a retry included: the watchdog starts anew if it
    /// came from the owner. Broadcasts do not count: a master that has dropped the slave still sends them.
    pub fn heard(&mut self, now: Instant, sa: Address) {
        if let (true, Some(watchdog)) = (self.owner == Some(sa), &mut self.watchdog) {
            watchdog.heard = now;
        }
    }

    /// Carries out a request for data with reply (SRD).
    pub fn handle_srd(&mut self, now: Instant, request: &Request<'_>) -> Handled<'_> {
        let Some(service) = Service::of(request.dsap, request.ssap) else {
            return Handled::reply(Reply::NotActivated);
        };
        match service.access(self.state, self.caller(request.sa)) {
            Access::Run => {}
            Access::NotActivated | Access::Ignored => return Handled::reply(Reply::NotActivated),
        }
        match service {
            Service::DataExchange => self.data_exchange(request),
            Service::SetPrm => Handled::acknowledge(self.set_prm(now, request)),
            Service::ChkCfg => Handled::acknowledge(self.chk_cfg(request)),
            Service::SlaveDiag | Service::GetCfg | Service::RdInp | Service::RdOutp
                if !request.data.is_empty() =>
            {
                Handled::reply(Reply::NoResource)
            }
            Service::SlaveDiag => {
                self.diagnosis = self.diagnosis().octets();
                Handled::reply(Reply::DataLow(&self.diagnosis))
            }
            Service::GetCfg => Handled::reply(data_or_sc(self.configuration)),
            Service::RdInp => Handled::reply(data_or_sc(self.offered_inputs())),
            Service::RdOutp => Handled::reply(data_or_sc(self.outputs())),
            // Global_Control is an SDN service; Set_Slave_Add never runs.
            Service::GlobalControl | Service::SetSlaveAdd => Handled::reply(Reply::NotActivated),
        }
    }

    /// Carries out a request without reply (SDN).
    pub fn handle_sdn(&mut self, request: &Request<'_>) -> Option<Event> {
        let service = Service::of(request.dsap, request.ssap);
        if service != Some(Service::GlobalControl)
            || Service::GlobalControl.access(self.state, self.caller(request.sa)) != Access::Run
        {
            return None;
        }
        let command = GlobalControl::parse(request.data)?;
        if !command.addresses(self.group_ident) {
            return None;
        }
        self.global_control(command);
        command.clear_data.then_some(Event::OutputsCleared { master: request.sa })
    }

    /// Time has passed: the watchdog may expire. Harmless at any time.
    pub fn handle_timeout(&mut self, now: Instant) -> Option<Event> {
        let watchdog = self.watchdog.filter(|watchdog| watchdog.expires() <= now)?;
        let master = self.owner?;
        self.leave_master(Stimulus::WatchdogExpired);
        Some(Event::WatchdogExpired { master, after: watchdog.time })
    }

    /// When to call [`Slave::handle_timeout`]. Changes with every request handled or heard.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Instant> {
        self.watchdog.map(Watchdog::expires)
    }

    fn caller(&self, sa: Address) -> Caller {
        if self.owner == Some(sa) { Caller::Owner } else { Caller::Other }
    }

    /// `dp-v0.md` 5.2; the numbers are its steps.
    fn set_prm(&mut self, now: Instant, request: &Request<'_>) -> Option<Event> {
        let master = request.sa;
        // 2: locked by another master.
        if let Some(owner) = self.owner.filter(|owner| *owner != master) {
            self.state = self.state.on(Stimulus::ForeignPrm);
            return Some(Event::PrmForeign { master, owner });
        }
        let prm = match SetPrm::parse(request.data) {
            Ok(prm) => prm,
            // 1
            Err(fault) => return Some(self.refuse_prm(master, fault)),
        };
        // 4
        if prm.unlock_req() {
            let released = self.owner.is_some();
            self.leave_master(Stimulus::Unlocked);
            return released.then_some(Event::Released { master });
        }
        // 3: carried out even when the ident number is another one.
        if !prm.lock_req() {
            self.min_tsdr = prm.min_tsdr().or(self.min_tsdr);
            self.state = self.state.on(Stimulus::MinTsdrOnly);
            return None;
        }
        // 5, 6, 8, 9
        if let Err(fault) = prm.check(self.description.ident, self.description.user_prm_len.into()) {
            return Some(self.refuse_prm(master, fault));
        }
        // 10
        self.leave_master(Stimulus::PrmAccepted);
        self.owner = Some(master);
        self.watchdog = prm.watchdog().map(|time| Watchdog { time, heard: now });
        self.min_tsdr = prm.min_tsdr().or(self.min_tsdr);
        self.group_ident = prm.group_ident();
        self.prm_fault = false;
        // 7: the fault is shown, the start-up goes on.
        self.not_supported = prm.sync_req() && !self.description.sync_mode
            || prm.freeze_req() && !self.description.freeze_mode;
        self.sync = Mode::enabled(prm.sync_req() && self.description.sync_mode);
        self.freeze = Mode::enabled(prm.freeze_req() && self.description.freeze_mode);
        Some(Event::Parameterised { master, watchdog: prm.watchdog() })
    }

    fn refuse_prm(&mut self, master: Address, fault: PrmFault) -> Event {
        self.prm_fault = true;
        self.leave_master(Stimulus::PrmRejected);
        Event::PrmRejected { master, fault }
    }

    fn chk_cfg(&mut self, request: &Request<'_>) -> Option<Event> {
        let master = request.sa;
        if let Err(fault) = CfgFault::compare(request.data, self.description.configurations) {
            self.cfg_fault = true;
            self.leave_master(Stimulus::CfgRejected);
            return Some(Event::CfgRejected { master, fault });
        }
        self.cfg_fault = false;
        let accepted = self.description.configurations.iter().find(|accepted| **accepted == request.data);
        if let Some(accepted) = accepted {
            self.configuration = accepted;
            self.lengths = IoLengths::of(accepted).unwrap_or_default();
        }
        let entered = self.state != State::DataExch;
        self.state = self.state.on(Stimulus::CfgAccepted);
        entered.then_some(Event::DataExchange { master })
    }

    fn data_exchange(&mut self, request: &Request<'_>) -> Handled<'_> {
        let (expected, got) = (self.lengths.outputs, request.data.len());
        if usize::from(expected) != got {
            self.leave_master(Stimulus::WrongOutputLength);
            let event = Some(Event::WrongOutputLength { master: request.sa, expected, got });
            return Handled { event, ..Handled::reply(Reply::NotActivated) };
        }
        self.state = self.state.on(Stimulus::Outputs);
        if self.sync == Mode::Active {
            self.waiting_outputs.copy(request.data);
        } else {
            self.outputs.copy(request.data);
            self.pass_outputs();
        }
        Handled { exchanged: true, ..Handled::reply(data_or_sc(self.offered_inputs())) }
    }

    /// `dp-v0.md` 6.3. A mode that Set_Prm did not enable stays closed (S-10).
    fn global_control(&mut self, command: GlobalControl) {
        if command.clear_data {
            self.outputs = Octets::EMPTY;
            self.waiting_outputs = Octets::EMPTY;
            self.pass_outputs();
        }
        match (self.sync, command.sync) {
            (Mode::Closed, _) | (_, Latch::Keep) | (Mode::Enabled, Latch::Release) => {}
            (Mode::Enabled, Latch::Set) => {
                // The outputs received last are out already; from now on they wait.
                self.waiting_outputs = self.outputs;
                self.sync = Mode::Active;
            }
            (Mode::Active, Latch::Set) => self.pass_waiting_outputs(),
            (Mode::Active, Latch::Release) => {
                self.pass_waiting_outputs();
                self.sync = Mode::Enabled;
            }
        }
        match (self.freeze, command.freeze) {
            (Mode::Closed, _) | (_, Latch::Keep) => {}
            (Mode::Enabled | Mode::Active, Latch::Set) => {
                self.frozen_inputs = self.inputs;
                self.freeze = Mode::Active;
            }
            (Mode::Enabled | Mode::Active, Latch::Release) => self.freeze = Mode::Enabled,
        }
    }

    /// Gives up the owner and everything that came with it (`dp-v0.md` 7, Leave-Master).
    fn leave_master(&mut self, why: Stimulus) {
        self.state = self.state.on(why);
        self.owner = None;
        self.watchdog = None;
        self.group_ident = 0;
        self.sync = Mode::Closed;
        self.freeze = Mode::Closed;
        self.outputs = Octets::EMPTY;
        self.waiting_outputs = Octets::EMPTY;
        self.pass_outputs();
    }

    fn pass_waiting_outputs(&mut self) {
        self.outputs = self.waiting_outputs;
        self.pass_outputs();
    }

    const fn pass_outputs(&mut self) {
        self.outputs_passed = self.outputs_passed.wrapping_add(1);
    }

    fn offered_inputs(&self) -> &[u8] {
        let inputs = if self.freeze == Mode::Active { &self.frozen_inputs } else { &self.inputs };
        inputs.first(self.lengths.inputs)
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

/// A slave with nothing to say acknowledges.
const fn data_or_sc(data: &[u8]) -> Reply<'_> {
    if data.is_empty() { Reply::ShortAcknowledge } else { Reply::DataLow(data) }
}

/// The monitoring of the owner.
#[derive(Clone, Copy, Debug)]
struct Watchdog {
    time: Duration,
    heard: Instant,
}

impl Watchdog {
    const fn expires(self) -> Instant {
        self.heard.saturating_add(self.time)
    }
}

/// Sync or Freeze.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    /// Set_Prm did not ask for it.
    Closed,
    /// May be commanded.
    Enabled,
    /// Commanded.
    Active,
}

impl Mode {
    const fn enabled(enabled: bool) -> Self {
        if enabled { Self::Enabled } else { Self::Closed }
    }
}

/// The octets of one direction; those never written are zero.
#[derive(Clone, Copy, Debug)]
struct Octets([u8; MAX_IO_LEN]);

impl Octets {
    const EMPTY: Self = Self([0; MAX_IO_LEN]);

    fn first(&self, len: u8) -> &[u8] {
        self.0.get(..len.into()).unwrap_or_default()
    }

    fn copy(&mut self, octets: &[u8]) {
        for (place, octet) in self.0.iter_mut().zip(octets) {
            *place = *octet;
        }
    }
}

#[cfg(test)]
mod tests;
