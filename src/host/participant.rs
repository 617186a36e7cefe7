//! What a [`Bus`](super::Bus) carries: anything that is a passive station.

use core::any::Any;
use std::borrow::Cow;

use super::StoredDevice;
use crate::devices::StationEvent;
use crate::devices::ag03::profibus::{DESCRIPTION, Device, MAX_TELEGRAM_LEN, Power};
use crate::face::{DriveState, Surroundings, Why};
use crate::profibus::dp;
use crate::profibus::fdl::{Address, Rates, Telegram};
use crate::time::{BaudRate, Instant};

/// A passive station on a [`Bus`](super::Bus): telegrams and time in, telegrams, news and a deadline out.
///
/// [`Device`] is one, a drive with its application inside. [`dp::Station`] is another: a slave whose process image is
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
    fn receive(&mut self, now: Instant, telegram: &Telegram<'_>, news: &mut dyn FnMut(StationEvent));

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
        None
    }

    /// Whether its DP watchdog minds its master (WD_On of Slave_Diag).
    fn watchdog_on(&self) -> bool;

    /// What it is and how it is, for who watches the line.
    fn appearance(&self) -> Appearance<'_> {
        Appearance::default()
    }

    /// What acts on it from outside; `None`: nothing that a host could change.
    fn surroundings(&self) -> Option<&dyn Surroundings> {
        None
    }

    /// The same, to change it.
    fn surroundings_mut(&mut self) -> Option<&mut dyn Surroundings> {
        None
    }

    /// The address it would have after `act`, which it is not done to. Only a supply that comes moves a station.
    fn address_after(&self, _act: &dyn Fn(&mut dyn Surroundings)) -> Address {
        self.address()
    }
}

/// What a station is and how it is.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Appearance<'a> {
    /// What it is.
    pub kind: StationKind,
    /// Which of its kind, as `ag03-1`, or the model name of its GSD; empty: nobody says it.
    pub model: Cow<'a, str>,
    /// The state of its DP slave.
    pub slave: Option<dp::State>,
    /// The state of its drive.
    pub drive: Option<DriveState>,
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
    /// Somebody else's.
    #[default]
    Other,
}

/// The address of a drive after `act`: DIP switches are read when it is switched on.
fn address_after(device: &Device, act: &dyn Fn(&mut dyn Surroundings)) -> Address {
    if device.power() != Power::Off {
        return device.address();
    }
    let mut trial = device.clone();
    act(&mut trial);
    trial.address()
}

impl<'a> Appearance<'a> {
    fn of(device: &Device) -> Self {
        Self {
            kind: StationKind::Drive,
            model: device.config().model.to_string().into(),
            slave: Some(device.dp_state()),
            drive: Some(device.drive_state()),
        }
    }
}

impl Participant for Device {
    fn address(&self) -> Address {
        Self::address(self)
    }

    fn set_baud(&mut self, baud: BaudRate) {
        Self::set_baud(self, baud);
    }

    fn rates(&self) -> Rates {
        DESCRIPTION.rates
    }

    fn receive(&mut self, now: Instant, telegram: &Telegram<'_>, news: &mut dyn FnMut(StationEvent)) {
        self.handle_telegram(now, telegram);
        pass_on(self, news);
    }

    fn handle_timeout(&mut self, now: Instant, news: &mut dyn FnMut(StationEvent)) {
        Self::handle_timeout(self, now);
        pass_on(self, news);
    }

    fn poll_transmit(
        &mut self,
        now: Instant,
        buf: &mut [u8; MAX_TELEGRAM_LEN],
        news: &mut dyn FnMut(StationEvent),
    ) -> Option<usize> {
        let len = Self::poll_transmit(self, now, buf).map(<[u8]>::len);
        pass_on(self, news);
        len
    }

    fn poll_timeout(&self) -> Option<Instant> {
        Self::poll_timeout(self)
    }

    fn watchdog_on(&self) -> bool {
        Self::watchdog_on(self)
    }

    fn appearance(&self) -> Appearance<'_> {
        Appearance::of(self)
    }

    fn why(&self) -> Option<&dyn Why> {
        Some(self)
    }

    fn surroundings(&self) -> Option<&dyn Surroundings> {
        Some(self)
    }

    fn surroundings_mut(&mut self) -> Option<&mut dyn Surroundings> {
        Some(self)
    }

    fn address_after(&self, act: &dyn Fn(&mut dyn Surroundings)) -> Address {
        address_after(self, act)
    }
}

fn pass_on(device: &mut Device, news: &mut dyn FnMut(StationEvent)) {
    while let Some(event) = device.poll_event() {
        news(event);
    }
}

impl Participant for StoredDevice {
    fn address(&self) -> Address {
        self.device().address()
    }

    fn set_baud(&mut self, baud: BaudRate) {
        Self::set_baud(self, baud);
    }

    fn rates(&self) -> Rates {
        DESCRIPTION.rates
    }

    fn receive(&mut self, now: Instant, telegram: &Telegram<'_>, news: &mut dyn FnMut(StationEvent)) {
        self.handle_telegram(now, telegram);
        pass_on(self.device_mut(), news);
    }

    fn handle_timeout(&mut self, now: Instant, news: &mut dyn FnMut(StationEvent)) {
        Self::handle_timeout(self, now);
        pass_on(self.device_mut(), news);
    }

    fn poll_transmit(
        &mut self,
        now: Instant,
        buf: &mut [u8; MAX_TELEGRAM_LEN],
        news: &mut dyn FnMut(StationEvent),
    ) -> Option<usize> {
        Participant::poll_transmit(self.device_mut(), now, buf, news)
    }

    fn poll_timeout(&self) -> Option<Instant> {
        Self::poll_timeout(self)
    }

    fn watchdog_on(&self) -> bool {
        self.device().watchdog_on()
    }

    fn appearance(&self) -> Appearance<'_> {
        Appearance::of(self.device())
    }

    fn why(&self) -> Option<&dyn Why> {
        Some(self.device())
    }

    fn surroundings(&self) -> Option<&dyn Surroundings> {
        Some(self.device())
    }

    fn surroundings_mut(&mut self) -> Option<&mut dyn Surroundings> {
        Some(self.device_mut())
    }

    fn address_after(&self, act: &dyn Fn(&mut dyn Surroundings)) -> Address {
        address_after(self.device(), act)
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

    fn receive(&mut self, now: Instant, telegram: &Telegram<'_>, news: &mut dyn FnMut(StationEvent)) {
        if let Some(event) = Self::receive(self, now, telegram).event {
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
        match Self::poll_transmit(self, now) {
            Ok(octets) => {
                let octets = octets?;
                buf.get_mut(..octets.len())?.copy_from_slice(octets);
                Some(octets.len())
            }
            Err(too_late) => {
                news(StationEvent::ReplyTooLate(too_late));
                None
            }
        }
    }

    fn poll_timeout(&self) -> Option<Instant> {
        Self::poll_timeout(self)
    }

    fn watchdog_on(&self) -> bool {
        self.slave().watchdog_on()
    }

    fn appearance(&self) -> Appearance<'_> {
        Appearance { slave: Some(self.slave().state()), ..Appearance::default() }
    }
}
