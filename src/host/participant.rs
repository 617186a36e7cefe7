//! What a [`Bus`](super::Bus) carries: anything that is a passive station.

use core::any::Any;
use core::time::Duration;
use std::borrow::Cow;
use std::path::PathBuf;

use super::state_dir::Images;
use super::{GsdStation, Startup, Stored};
use crate::devices::{PlainStation, SlaveDevice, StationEvent, write_reply};
use crate::face::{Description, DriveState, Why};
use crate::profibus::dp;
use crate::profibus::fdl::{Address, MAX_TELEGRAM_LEN, Rates, Telegram};
use crate::time::{BaudRate, Instant};

/// A passive station on a [`Bus`](super::Bus): telegrams and time in, telegrams, news and a deadline out.
///
/// [`Device`](crate::devices::ag03::profibus::Device) is one, a drive with its application inside. [`dp::Station`] is another: a slave whose process image is
/// read and written through [`Bus::with`](super::Bus::with). A slave with an application of its own wraps a
/// `dp::Station` and implements these calls.
///
/// The bus calls every station with the telegrams addressed to it, with broadcasts, and with those that end the time
/// of a reply it has not sent; with nothing else.
pub trait Participant: Any + Send {
    /// Its address now. It may change with any call (Set_Slave_Add); the bus follows.
    fn address(&self) -> Address;

    /// The line has another rate from now on.
    fn set_baud(&mut self, baud: BaudRate);

    /// The rates it knows: among those of all stations a [`Bus`](super::Bus) searches for that of its line.
    fn rates(&self) -> Rates {
        Rates::CUSTOMARY
    }

    /// Takes a telegram whose last octet ended at `now`, and says what came of it.
    fn handle_telegram(&mut self, now: Instant, telegram: &Telegram<'_>, news: &mut dyn FnMut(StationEvent));

    /// Time has passed. Spurious calls are harmless.
    fn handle_timeout(&mut self, now: Instant, news: &mut dyn FnMut(StationEvent));

    /// The telegram to send at `now`, written to `buf`, if its time has come: how many octets it has.
    fn poll_transmit(
        &mut self,
        now: Instant,
        buf: &mut [u8; MAX_TELEGRAM_LEN],
        news: &mut dyn FnMut(StationEvent),
    ) -> Option<usize>;

    /// When to call it again; `None` = a telegram comes first.
    fn poll_timeout(&self) -> Option<Instant>;

    /// What keeps its drive from moving now; `None`: it has no drive.
    fn why(&self) -> Option<&dyn Why> {
        self.description()?.why()
    }

    /// Whether its DP watchdog minds its master (WD_On of Slave_Diag).
    fn watchdog_on(&self) -> bool;

    /// What it is and how it is, for who watches the line.
    fn appearance(&self) -> Appearance<'_> {
        Appearance::default()
    }

    /// The station whose memory it stores; `None`: it stores none, and is the station itself.
    fn stored(&self) -> Option<&dyn Participant> {
        None
    }

    /// The same, to change it.
    fn stored_mut(&mut self) -> Option<&mut dyn Participant> {
        None
    }

    /// What acts on it from outside, and what it tells of itself; `None`: nothing.
    fn description(&self) -> Option<&dyn Description> {
        None
    }

    /// The same, to change it.
    fn description_mut(&mut self) -> Option<&mut dyn Description> {
        None
    }

    /// Its modules, if a file describes them.
    fn modules(&self) -> Option<&GsdStation> {
        None
    }

    /// The same, to change it.
    fn modules_mut(&mut self) -> Option<&mut GsdStation> {
        None
    }

    /// How a master takes it over and operates it; `None`: nobody can say.
    fn startup(&self) -> Option<Startup> {
        None
    }

    /// The file of its memory.
    fn path(&self) -> Option<PathBuf> {
        None
    }

    /// The address it would have after `act`, which it is not done to. Only a supply that comes moves a station.
    fn address_after(&self, _act: &dyn Fn(&mut dyn Description)) -> Address {
        self.address()
    }
}

/// What a station is and how it is.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Appearance<'a> {
    /// What it is.
    pub kind: StationKind,
    /// Its name in the list of devices, as `ag03-1`; empty: it is in none.
    pub device: &'static str,
    /// Which of its kind, as `ag03-1`, or the model name of its GSD; empty: nobody says it.
    pub model: Cow<'a, str>,
    /// What people call it; empty: as the model.
    pub product: Cow<'a, str>,
    /// The state of its DP slave.
    pub slave: Option<dp::State>,
    /// The master that owns the slave.
    pub owner: Option<Address>,
    /// The ident number of the slave.
    pub ident: Option<u16>,
    /// The watchdog time that Set_Prm asked for; `None`: no watchdog runs.
    pub watchdog: Option<Duration>,
    /// The state of its drive.
    pub drive: Option<DriveState>,
}

impl Appearance<'_> {
    /// What a slave says.
    pub(super) fn of_slave<A: dp::Application>(slave: &dp::Slave<A>) -> Self {
        Self {
            slave: Some(slave.state()),
            owner: slave.owner(),
            ident: Some(slave.description().ident),
            watchdog: slave.watchdog().map(|(time, _)| time),
            ..Self::default()
        }
    }
}

/// What a station is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StationKind {
    /// An AG03 or AG03/1.
    Drive,
    /// What a GSD describes.
    GsdStation,
    /// A drive of PROFIDRIVE version 2.
    PpoDrive,
    /// A drive of PROFIdrive version 3 and 4.
    Profidrive,
    /// Somebody else's.
    #[default]
    Other,
}

impl StationKind {
    /// Its name for programs.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Drive => "drive",
            Self::GsdStation => "gsd_station",
            Self::PpoDrive => "ppo_drive",
            Self::Profidrive => "profidrive",
            Self::Other => "other",
        }
    }
}

/// What is stored is the station itself, to whoever asks for one.
impl<P: Participant + Images<Generation: Send>> Participant for Stored<P> {
    fn address(&self) -> Address {
        self.unit().address()
    }

    fn set_baud(&mut self, baud: BaudRate) {
        self.unit_mut().set_baud(baud);
    }

    fn rates(&self) -> Rates {
        self.unit().rates()
    }

    fn handle_telegram(&mut self, now: Instant, telegram: &Telegram<'_>, news: &mut dyn FnMut(StationEvent)) {
        self.act(now, |station| station.handle_telegram(now, telegram, news));
    }

    fn handle_timeout(&mut self, now: Instant, news: &mut dyn FnMut(StationEvent)) {
        self.act(now, |station| station.handle_timeout(now, news));
    }

    fn poll_transmit(
        &mut self,
        now: Instant,
        buf: &mut [u8; MAX_TELEGRAM_LEN],
        news: &mut dyn FnMut(StationEvent),
    ) -> Option<usize> {
        self.unit_mut().poll_transmit(now, buf, news)
    }

    fn poll_timeout(&self) -> Option<Instant> {
        Self::poll_timeout(self, self.unit().poll_timeout())
    }

    fn watchdog_on(&self) -> bool {
        self.unit().watchdog_on()
    }

    fn stored(&self) -> Option<&dyn Participant> {
        Some(self.unit())
    }

    fn stored_mut(&mut self) -> Option<&mut dyn Participant> {
        Some(self.unit_mut())
    }

    fn startup(&self) -> Option<Startup> {
        self.unit().startup()
    }

    fn path(&self) -> Option<PathBuf> {
        Self::path(self)
    }

    fn appearance(&self) -> Appearance<'_> {
        self.unit().appearance()
    }

    fn description(&self) -> Option<&dyn Description> {
        self.unit().description()
    }

    fn description_mut(&mut self) -> Option<&mut dyn Description> {
        self.unit_mut().description_mut()
    }

    fn modules(&self) -> Option<&GsdStation> {
        self.unit().modules()
    }

    fn modules_mut(&mut self) -> Option<&mut GsdStation> {
        self.unit_mut().modules_mut()
    }

    fn address_after(&self, act: &dyn Fn(&mut dyn Description)) -> Address {
        self.unit().address_after(act)
    }
}

impl<A: dp::Application + Send + 'static> Participant for dp::Station<A> {
    fn address(&self) -> Address {
        Self::address(self)
    }

    fn set_baud(&mut self, baud: BaudRate) {
        Self::set_baud(self, baud);
    }

    fn rates(&self) -> Rates {
        self.slave().description().rates
    }

    fn handle_telegram(&mut self, now: Instant, telegram: &Telegram<'_>, news: &mut dyn FnMut(StationEvent)) {
        if let Some(event) = Self::handle_telegram(self, now, telegram).event {
            news(StationEvent::Dp(event));
        }
    }

    fn handle_timeout(&mut self, now: Instant, news: &mut dyn FnMut(StationEvent)) {
        if let Some(event) = Self::handle_timeout(self, now) {
            news(StationEvent::Dp(event));
        }
    }

    fn poll_transmit(
        &mut self,
        now: Instant,
        buf: &mut [u8; MAX_TELEGRAM_LEN],
        news: &mut dyn FnMut(StationEvent),
    ) -> Option<usize> {
        write_reply(Self::poll_transmit(self, now), buf, news)
    }

    fn poll_timeout(&self) -> Option<Instant> {
        Self::poll_timeout(self)
    }

    fn watchdog_on(&self) -> bool {
        self.slave().watchdog_on()
    }

    fn appearance(&self) -> Appearance<'_> {
        Appearance::of_slave(self.slave())
    }
}

impl<D: SlaveDevice> Participant for PlainStation<D> {
    fn address(&self) -> Address {
        self.station.address()
    }

    fn set_baud(&mut self, baud: BaudRate) {
        self.station.set_baud(baud);
    }

    fn rates(&self) -> Rates {
        Participant::rates(&self.station)
    }

    fn handle_telegram(&mut self, now: Instant, telegram: &Telegram<'_>, news: &mut dyn FnMut(StationEvent)) {
        Participant::handle_telegram(&mut self.station, now, telegram, news);
        self.exchange(now);
    }

    fn handle_timeout(&mut self, now: Instant, news: &mut dyn FnMut(StationEvent)) {
        Participant::handle_timeout(&mut self.station, now, news);
        self.exchange(now);
    }

    fn poll_transmit(
        &mut self,
        now: Instant,
        buf: &mut [u8; MAX_TELEGRAM_LEN],
        news: &mut dyn FnMut(StationEvent),
    ) -> Option<usize> {
        Participant::poll_transmit(&mut self.station, now, buf, news)
    }

    fn poll_timeout(&self) -> Option<Instant> {
        Instant::first_of(self.station.poll_timeout(), self.device.due())
    }

    fn watchdog_on(&self) -> bool {
        self.station.slave().watchdog_on()
    }

    fn appearance(&self) -> Appearance<'_> {
        let (device, product) = self.device.product();
        let drive = self.device.drive_state();
        Appearance { device, product: product.into(), drive, ..Appearance::of_slave(self.station.slave()) }
    }

    fn description(&self) -> Option<&dyn Description> {
        Some(&self.device)
    }

    fn description_mut(&mut self) -> Option<&mut dyn Description> {
        Some(&mut self.device)
    }
}
