//! Drives at a line that somebody else serves, for programs that do one thing after the other.

mod settings;
mod turn;

use core::cell::RefCell;
use core::fmt;
use core::panic::AssertUnwindSafe;
use core::time::Duration;
use std::io;
use std::panic::catch_unwind;

use profirust::dp::{DiagnosticFlags, DpEvents, DpMaster, PeripheralEvent, PeripheralHandle};
use profirust::fdl::{FdlActiveStation, FdlApplication};

use super::error::SessionError;
use super::inquiry::{Answer, Inquiry, Question};
use super::peripheral::Slave;
use super::phy::{LinkPhy, instant};
use crate::host::{Clock, Link, Stop};
use crate::profibus::dp::Diagnosis;
use crate::profibus::fdl::{Address, StationType};
use crate::profibus::ppo::PPO_LEN;
use crate::time::{BITS_PER_OCTET, Instant};
pub use settings::Settings;
use turn::Turn;

/// How long this master sleeps at most: profirust does not say when it wants to be called next.
const LOOK: Duration = Duration::from_micros(200);

/// Cycles before the token is passed. As the only master profirust then waits a slot time for an absent station.
const CYCLES_PER_TOKEN: usize = 32;

/// For what should come soon, beside what the bus itself takes.
const MARGIN: Duration = Duration::from_secs(3);

/// A drive that was to be taken over.
#[derive(Clone, Copy, Debug)]
struct Drive {
    handle: PeripheralHandle,
    address: Address,
    /// Whether it was.
    started: bool,
    /// When its next exchange may begin.
    next_exchange: Instant,
}

/// A master and, once [`Session::start`] has succeeded, the drives it exchanges data with: one, or several in turn.
///
/// Every call blocks until it is done or has failed, in bounded time. Between calls nothing is sent: who waits longer
/// than [`Settings::watchdog`] between two exchanges loses the drives, which release their motors then. While one drive is
/// served the others are too, with the outputs they were given last.
///
/// ```no_run
/// use profidrive::profibus::fdl::Address;
/// use profidrive::host::link::terminal::Terminal;
/// use profidrive::host::{Stop, SystemClock};
/// use profidrive::master::{Session, Settings};
/// use profidrive::profibus::ppo::{Inputs, Outputs, Pkw, Stw};
/// use profidrive::time::BaudRate;
///
/// let link = Terminal::open("/tmp/bus".as_ref(), BaudRate::K500)?;
/// let settings = Settings::untimed(Address::station(2)?, BaudRate::K500);
/// let mut session = Session::new(link, SystemClock::new(), Stop::new()?, settings)?;
/// session.start(Address::station(5)?)?;
/// let inputs = session.exchange(&Outputs::octets(Pkw::ZERO, Stw::default(), 0))?;
/// println!("position {}", Inputs::new(&inputs).hiw());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Session<L, C> {
    settings: Settings,
    fdl: FdlActiveStation,
    /// Behind a cell so that it can have several turns while it has the token.
    dp: RefCell<DpMaster<'static>>,
    inquiry: Inquiry,
    phy: LinkPhy<L>,
    clock: C,
    stop: Stop,
    /// Never requested: an exchange that has begun is finished.
    undisturbed: Stop,
    /// In the order in which they were started.
    drives: Vec<Drive>,
    /// The DP master lets its turns pass: it would take a released drive back.
    dp_pauses: bool,
    next_exchange: Instant,
    /// Why profirust has given up. What it left behind is not used again.
    failed: Option<String>,
}

impl<L, C> fmt::Debug for Session<L, C> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { settings, drives, .. } = self;
        f.debug_struct("Session").field("settings", settings).field("drives", drives).finish_non_exhaustive()
    }
}

impl<L: Link, C: Clock> Session<L, C> {
    /// A master on `link`. It says nothing before the first call. `stop` ends every wait but that of an exchange with
    /// [`SessionError::Stopped`].
    ///
    /// # Errors
    /// The process has no file descriptors left.
    pub fn new(link: L, clock: C, stop: Stop, settings: Settings) -> io::Result<Self> {
        let mut fdl = FdlActiveStation::new(settings.parameters());
        fdl.set_online();
        Ok(Self {
            settings,
            fdl,
            dp: RefCell::new(DpMaster::new(Vec::new())),
            inquiry: Inquiry::default(),
            phy: LinkPhy::new(link, settings.baud),
            clock,
            stop,
            undisturbed: Stop::new()?,
            drives: Vec::new(),
            dp_pauses: false,
            next_exchange: Instant::ZERO,
            failed: None,
        })
    }

    /// The time.
    pub fn now(&self) -> Instant {
        self.clock.now()
    }

    /// What ends a wait.
    pub const fn stop(&self) -> &Stop {
        &self.stop
    }

    /// How this master takes part in the line.
    pub(crate) const fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Asks who is at each address, and tells one after the other: `None` if nobody answers.
    ///
    /// # Errors
    /// [`SessionError::Stopped`], [`SessionError::Link`], [`SessionError::NoToken`], [`SessionError::AddressTaken`].
    pub fn find(
        &mut self,
        addresses: impl IntoIterator<Item = Address>,
        mut found: impl FnMut(Address, Option<StationType>),
    ) -> Result<(), SessionError> {
        for address in addresses {
            self.inquiry.ask(address.number(), Question::Status);
        }
        self.inquire(|address, answer| {
            found(
                address,
                match answer {
                    Answer::Silence
                    | Answer::Urgent(_)
                    | Answer::ShortAcknowledge
                    | Answer::NothingToSay
                    | Answer::NotActivated
                    | Answer::NoResource => None,
                    Answer::Station(station, _) => Some(station),
                },
            );
        })
    }

    /// Sends data from one SAP to another, or without SAPs, and says what came back.
    pub(super) fn ask(
        &mut self,
        address: Address,
        saps: Option<(u8, u8)>,
        data: &[u8],
    ) -> Result<Answer, SessionError> {
        self.inquiry.ask(address.number(), Question::Data { saps, data: data.to_vec() });
        let mut outcome = Answer::Silence;
        self.inquire(|_, answer| outcome = answer)?;
        Ok(outcome)
    }

    /// Lets the token go round for this time.
    pub(super) fn pause(&mut self, time: Duration) -> Result<(), SessionError> {
        let begun = self.now();
        while let Some(left) = time.checked_sub(self.now().saturating_since(begun)) {
            self.poll()?;
            self.rest(left.min(LOOK), true)?;
            if left.is_zero() {
                break;
            }
        }
        Ok(())
    }

    /// Whether this session has taken the slave over.
    pub(super) fn exchanges_with(&self, address: Address) -> bool {
        self.drive(address).is_some()
    }

    /// Asks a slave for its diagnosis: the standard part, and all octets. That changes nothing, whoever its master is.
    ///
    /// # Errors
    /// As [`Session::find`], and [`SessionError::NoAnswer`], [`SessionError::Master`], [`SessionError::NoSlave`].
    pub fn diagnosis(&mut self, address: Address) -> Result<(Diagnosis, Vec<u8>), SessionError> {
        self.inquiry.ask(address.number(), Question::Diagnosis);
        let mut outcome = Err(SessionError::NoAnswer { address });
        self.inquire(|_, answer| {
            outcome = match answer {
                Answer::Silence => Err(SessionError::NoAnswer { address }),
                Answer::Station(StationType::Slave, octets) => {
                    let diagnosis = Diagnosis::parse(&octets).ok_or(SessionError::NoSlave { address });
                    diagnosis.map(|diagnosis| (diagnosis, octets))
                }
                Answer::Station(
                    StationType::MasterNotReady | StationType::MasterReady | StationType::MasterInRing,
                    _,
                ) => Err(SessionError::Master { address }),
                Answer::Urgent(_)
                | Answer::ShortAcknowledge
                | Answer::NothingToSay
                | Answer::NotActivated
                | Answer::NoResource => Err(SessionError::NoSlave { address }),
            };
        })?;
        outcome
    }

    /// Takes a drive over, one more if there are some: reads its diagnosis, then Set_Prm with watchdog, Chk_Cfg, and the first exchanges with
    /// outputs of zero. A drive that was taken over is left as it is; after an error it may be tried again.
    ///
    /// # Errors
    /// As [`Session::diagnosis`];
    /// [`SessionError::Ident`] and [`SessionError::Locked`] before anything is sent that changes the slave;
    /// [`SessionError::PrmRefused`], [`SessionError::CfgRefused`], [`SessionError::NotReady`].
    pub fn start(&mut self, address: Address) -> Result<(), SessionError> {
        self.start_slave(address, &Slave::AG03)
    }

    /// [`Session::start`] with any slave.
    ///
    /// # Errors
    /// As [`Session::start`].
    pub(crate) fn start_slave(&mut self, address: Address, slave: &Slave) -> Result<(), SessionError> {
        if self.drive(address).is_some_and(|drive| drive.started) {
            return Ok(());
        }
        let (diagnosis, _) = self.diagnosis(address)?;
        let (got, expected) = (diagnosis.ident, slave.ident);
        if got != expected {
            return Err(SessionError::Ident { address, got, expected });
        }
        if let Some(owner) = diagnosis.master.filter(|owner| *owner != self.settings.master) {
            return Err(SessionError::Locked { address, owner });
        }
        // What was begun and failed goes on: profirust forgets no peripheral.
        let handle = match self.drive(address) {
            Some(drive) => drive.handle,
            None => {
                let peripheral = slave.peripheral(address.number(), self.settings.baud);
                let handle = self.dp.borrow_mut().add(peripheral);
                let next_exchange = self.now();
                self.drives.push(Drive { handle, address, started: false, next_exchange });
                handle
            }
        };
        self.dp.borrow_mut().enter_operate();
        let begun = self.now();
        let mut online = 0_u32;
        while !self.dp.borrow_mut().get_mut(handle).is_running() {
            let event = self.poll()?.peripheral.filter(|(of, _)| *of == handle).map(|(_, event)| event);
            match event {
                Some(PeripheralEvent::Online) => online += 1,
                Some(PeripheralEvent::ConfigError) => return Err(SessionError::CfgRefused { address }),
                Some(PeripheralEvent::ParameterError) => return Err(SessionError::PrmRefused { address }),
                Some(
                    PeripheralEvent::Configured
                    | PeripheralEvent::DataExchanged
                    | PeripheralEvent::Diagnostics
                    | PeripheralEvent::Offline,
                )
                | None => {}
            }
            // The first diagnosis is from before Set_Prm. profirust begins anew when a slave has refused it.
            let flags = self.dp.borrow_mut().get_mut(handle).last_diagnostics().map(|diag| diag.flags);
            if online > 1 && flags.is_some_and(|flags| flags.contains(DiagnosticFlags::PARAMETER_FAULT)) {
                return Err(SessionError::PrmRefused { address });
            }
            let waited = self.now().saturating_since(begun);
            if waited > self.patience() {
                return Err(SessionError::NotReady { address, waited });
            }
            self.rest(LOOK, true)?;
        }
        let now = self.now();
        if let Some(drive) = self.drive_mut(address) {
            (drive.started, drive.next_exchange) = (true, now);
        }
        Ok(())
    }

    fn drive(&self, address: Address) -> Option<Drive> {
        self.drives.iter().copied().find(|drive| drive.address == address)
    }

    fn drive_mut(&mut self, address: Address) -> Option<&mut Drive> {
        self.drives.iter_mut().find(|drive| drive.address == address)
    }

    /// [`Session::exchange_with`] the drive that was started first: the one of a session with one drive.
    ///
    /// # Errors
    /// As [`Session::exchange_with`].
    pub fn exchange(&mut self, outputs: &[u8; PPO_LEN]) -> Result<[u8; PPO_LEN], SessionError> {
        let first = self.drives.first().ok_or(SessionError::NotStarted)?.address;
        self.exchange_with(first, outputs)
    }

    /// One exchange with a drive: these outputs, and the inputs that come back. They were ready before the drive saw the
    /// outputs.
    ///
    /// Begins [`Settings::cycle`] after the one before with the same drive. A requested end does not keep it from being done: who wants to
    /// end looks at [`Session::stop`] between exchanges.
    ///
    /// # Errors
    /// Each loss; [`SessionError::NotStarted`] before [`Session::start`].
    pub fn exchange_with(
        &mut self,
        address: Address,
        outputs: &[u8; PPO_LEN],
    ) -> Result<[u8; PPO_LEN], SessionError> {
        let mut inputs = [0; PPO_LEN];
        self.exchange_octets(address, outputs, &mut inputs)?;
        Ok(inputs)
    }

    /// [`Session::exchange_with`] a slave with any number of octets. What is short is filled up with zeros, what is too long
    /// left out.
    ///
    /// # Errors
    /// As [`Session::exchange_with`].
    pub(crate) fn exchange_octets(
        &mut self,
        address: Address,
        outputs: &[u8],
        inputs: &mut [u8],
    ) -> Result<(), SessionError> {
        let Some(Drive { handle, started: true, next_exchange, .. }) = self.drive(address) else {
            return Err(SessionError::NotStarted);
        };
        fill(self.dp.borrow_mut().get_mut(handle).pi_q_mut(), outputs);
        loop {
            let left = next_exchange.saturating_since(self.now());
            if left.is_zero() {
                break;
            }
            self.rest(left, false)?;
        }
        let begun = self.now();
        let next = begun.saturating_add(self.settings.cycle);
        if let Some(drive) = self.drive_mut(address) {
            drive.next_exchange = next;
        }
        loop {
            let events = self.poll()?;
            let mut dp = self.dp.borrow_mut();
            let drive = dp.get_mut(handle);
            if !drive.is_running() {
                drop(dp);
                return Err(self.explain_loss(handle, address)?);
            }
            if events.peripheral == Some((handle, PeripheralEvent::DataExchanged)) {
                fill(inputs, drive.pi_i());
                return Ok(());
            }
            drop(dp);
            if self.now().saturating_since(begun) > self.patience() {
                return Err(SessionError::NoToken { master: self.settings.master });
            }
            self.rest(LOOK, false)?;
        }
    }

    /// Releases the drives: one exchange with outputs of zero, which takes the motor out of control, then Set_Prm with
    /// Unlock_Req. Without it a drive belongs to this master until its watchdog expires.
    ///
    /// # Errors
    /// The first, as of [`Session::exchange`] and [`Session::find`]; the other drives are released all the same, and the
    /// watchdog releases those that were not.
    pub fn release(mut self) -> Result<(), SessionError> {
        let drives = self.drives.clone();
        if drives.is_empty() {
            return Ok(());
        }
        let mut outcome = Ok(());
        for drive in drives.iter().filter(|drive| drive.started) {
            outcome = outcome.and(self.exchange_octets(drive.address, &[], &mut []));
        }
        self.dp_pauses = true;
        for drive in &drives {
            self.inquiry.ask(drive.address.number(), Question::Release);
        }
        outcome.and(self.inquire(|_, _| {}))
    }

    /// Why the drive has left Data_Exchange. profirust tries to take it back meanwhile, with outputs of zero.
    fn explain_loss(
        &mut self,
        handle: PeripheralHandle,
        address: Address,
    ) -> Result<SessionError, SessionError> {
        self.dp.borrow_mut().get_mut(handle).pi_q_mut().fill(0);
        let begun = self.now();
        let master = self.settings.master;
        loop {
            let found = {
                let mut dp = self.dp.borrow_mut();
                let drive = dp.get_mut(handle);
                let live = drive.is_live();
                drive.last_diagnostics().filter(|_| live).and_then(|diag| {
                    let owner = diag.master_address.map(Address::from_octet);
                    match owner.filter(|owner| *owner != master) {
                        Some(owner) => Some(SessionError::Taken { address, owner }),
                        None => diag
                            .flags
                            .contains(DiagnosticFlags::PARAMETER_REQUIRED)
                            .then_some(SessionError::Restarted { address }),
                    }
                })
            };
            if let Some(found) = found {
                return Ok(found);
            }
            if self.now().saturating_since(begun) > self.request_time().saturating_mul(2) {
                return Ok(SessionError::Silent { address });
            }
            self.poll()?;
            self.rest(LOOK, false)?;
        }
    }

    /// Asks what is queued.
    fn inquire(&mut self, mut told: impl FnMut(Address, Answer)) -> Result<(), SessionError> {
        self.next_exchange = self.now();
        let mut in_ring = self.fdl.is_in_ring();
        let outcome = loop {
            if let Err(error) = self.poll() {
                break Err(error);
            }
            let mut heard = false;
            while let Some((address, answer)) = self.inquiry.take_answer() {
                heard = true;
                told(Address::from_octet(address), answer);
            }
            if heard {
                self.next_exchange = self.now();
            }
            if self.inquiry.is_done() {
                return Ok(());
            }
            let was_in_ring = core::mem::replace(&mut in_ring, self.fdl.is_in_ring());
            if in_ring && !was_in_ring {
                self.next_exchange = self.now();
            }
            let patience = if in_ring { self.patience() } else { self.patience_to_enter() };
            if self.now().saturating_since(self.next_exchange) > patience {
                break Err(SessionError::NoToken { master: self.settings.master });
            }
            if let Err(error) = self.rest(LOOK, true) {
                break Err(error);
            }
        };
        self.inquiry.clear();
        outcome
    }

    /// Lets profirust do what is due.
    fn poll(&mut self) -> Result<DpEvents, SessionError> {
        if let Some(reason) = &self.failed {
            return Err(SessionError::Library(reason.clone()));
        }
        let now = self.clock.now();
        let mut turns = [Turn { dp: &self.dp, passes: self.dp_pauses }; CYCLES_PER_TOKEN];
        let turns = turns.iter_mut().map(|turn| turn as &mut dyn FdlApplication);
        let mut layers: Vec<&mut dyn FdlApplication> =
            core::iter::once(&mut self.inquiry as &mut dyn FdlApplication).chain(turns).collect();
        let polled = contained(|| self.fdl.poll_multi(instant(now), &mut self.phy, &mut layers));
        if let Err(reason) = polled {
            self.failed = Some(reason.clone());
            return Err(SessionError::Library(reason));
        }
        if self.phy.is_lost() {
            let error = self.phy.take_error().unwrap_or_else(|| io::ErrorKind::NotConnected.into());
            return Err(SessionError::Link(error));
        }
        if self.fdl.connectivity_state().is_offline() {
            return Err(SessionError::AddressTaken { master: self.settings.master });
        }
        Ok(self.dp.borrow_mut().take_last_events())
    }

    /// Sleeps until octets arrive or the time is over.
    fn rest(&mut self, time: Duration, stoppable: bool) -> Result<(), SessionError> {
        let stop = if stoppable { &self.stop } else { &self.undisturbed };
        self.phy.link_mut().wait(Some(time), stop).map_err(SessionError::Link)?;
        if stoppable && self.stop.is_requested() {
            return Err(SessionError::Stopped);
        }
        Ok(())
    }

    /// How long a request with all its repetitions can take.
    fn request_time(&self) -> Duration {
        let parameters = self.fdl.parameters();
        let slot = Duration::from_micros(parameters.slot_time().total_micros());
        let telegram = self.settings.baud.bit_times(2 * 255 * BITS_PER_OCTET);
        slot.saturating_add(telegram).saturating_mul(u32::from(parameters.max_retry_limit) + 1)
    }

    /// How long the token can be away: a silent line is taken after a time that depends on the master's address, on
    /// another the other masters have their turns.
    fn patience(&self) -> Duration {
        let parameters = self.fdl.parameters();
        let claim = Duration::from_micros(parameters.token_lost_timeout().total_micros());
        let rotation = Duration::from_micros(parameters.token_rotation_time().total_micros());
        claim.saturating_add(rotation).saturating_add(self.request_time()).saturating_add(MARGIN)
    }

    /// How long it may take until the other masters let this one in. A master like this one asks one address with
    /// each of its tokens whether a master waits there, and lets in who was asked twice.
    fn patience_to_enter(&self) -> Duration {
        let slot = Duration::from_micros(self.fdl.parameters().slot_time().total_micros());
        let cycles = u32::try_from(CYCLES_PER_TOKEN).unwrap_or(u32::MAX);
        let token = slot.saturating_add(self.settings.cycle.saturating_mul(cycles));
        self.patience().saturating_add(token.saturating_mul(2 * 126))
    }
}

/// What a panic of another crate says, which must not end the program of a user.
fn contained<R>(act: impl FnOnce() -> R) -> Result<R, String> {
    // What is left behind is not looked at again.
    catch_unwind(AssertUnwindSafe(act)).map_err(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no reason").into()
    })
}

/// As many octets as there is room for, and zeros behind them.
fn fill(room: &mut [u8], octets: &[u8]) {
    let octets = octets.iter().copied().chain(core::iter::repeat(0));
    room.iter_mut().zip(octets).for_each(|(place, octet)| *place = octet);
}
