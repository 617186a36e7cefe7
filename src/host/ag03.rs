//! An AG03 or AG03/1 on a bus.

use super::{Appearance, Participant, Startup, StationKind};
use crate::devices::StationEvent;
use crate::devices::ag03::param::Model;
use crate::devices::ag03::profibus::{Config, DESCRIPTION, Device, MAX_TELEGRAM_LEN, Power};
use crate::face::{Description, Operation};
use crate::profibus::fdl::{Address, Rates, Telegram};
use crate::profibus::ppo::PpoType;
use crate::time::{BaudRate, Instant};

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

    fn handle_telegram(&mut self, now: Instant, telegram: &Telegram<'_>, news: &mut dyn FnMut(StationEvent)) {
        self.handle_telegram(now, telegram);
        pass_on(self, news);
    }

    fn handle_timeout(&mut self, now: Instant, news: &mut dyn FnMut(StationEvent)) {
        // The bus has the framer.
        self.pass_time(now);
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
        self.due()
    }

    fn watchdog_on(&self) -> bool {
        Self::watchdog_on(self)
    }

    fn appearance(&self) -> Appearance<'_> {
        Appearance::of(self)
    }

    fn description(&self) -> Option<&dyn Description> {
        Some(self)
    }

    fn description_mut(&mut self) -> Option<&mut dyn Description> {
        Some(self)
    }

    fn startup(&self) -> Option<Startup> {
        Some(Startup::of_ppo(DESCRIPTION.ident, PpoType::SevenWords, Operation::Positioning))
    }

    fn address_after(&self, act: &dyn Fn(&mut dyn Description)) -> Address {
        address_after(self, act)
    }
}

/// Asked with each telegram and in each application cycle, nearly always in vain.
#[inline(always)]
fn pass_on(device: &mut Device, news: &mut dyn FnMut(StationEvent)) {
    if device.has_events() {
        pass_waiting(device, news);
    }
}

#[inline(never)]
fn pass_waiting(device: &mut Device, news: &mut dyn FnMut(StationEvent)) {
    while let Some(event) = device.poll_event() {
        news(event.of_any());
    }
}

/// The address of a drive after `act`: DIP switches are read when it is switched on.
fn address_after(device: &Device, act: &dyn Fn(&mut dyn Description)) -> Address {
    if device.power() != Power::Off {
        return device.address();
    }
    let mut trial = device.clone();
    act(&mut trial);
    trial.address()
}

impl Appearance<'_> {
    fn of(device: &Device) -> Self {
        let Config { model, gear, .. } = *device.config();
        Self {
            kind: StationKind::Drive,
            device: match model {
                Model::Ag03 => "ag03",
                Model::Ag03_1 => "ag03-1",
            },
            model: model.to_string().into(),
            product: format!("{}, gear {gear}:1", model.product_name()).into(),
            drive: Some(device.drive_state()),
            ..Self::of_slave(device.slave())
        }
    }
}
