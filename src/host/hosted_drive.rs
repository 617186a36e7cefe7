//! A drive of the profile on a bus: its words of refusals, and what it keeps.

use core::fmt;

use super::state_dir::Images;
use super::station_file::{Kept, KeptImage};
use super::{Appearance, Participant, Refusals, Startup, StateDir, StateDirError, Stored};
use crate::devices::{BusDrive, StationEvent};
use crate::face::Description;
use crate::image::Generation;
use crate::image::storage::Outcome;
use crate::profibus::dp;
use crate::profibus::fdl::{Address, MAX_TELEGRAM_LEN, Rates, Telegram};
use crate::time::{BaudRate, Instant};

/// What a host knows of a drive beside what every one has.
pub trait HostedDrive: BusDrive + fmt::Debug + Send + Sized + 'static {
    /// How its image is called.
    const KEPT_AS: &'static str;

    /// How a master takes it over; `None`: nobody can say.
    fn startup(&self) -> Option<Startup>;

    /// What it is and how it is.
    fn appearance(&self) -> Appearance<'_>;
}

/// A drive that says why it refuses what its device file does not admit.
#[derive(Debug)]
pub struct Hosted<D> {
    drive: D,
    refusals: Refusals,
    image: Option<KeptImage>,
    /// Set_Slave_Add has changed the address.
    address_set: bool,
}

impl<D: HostedDrive> Hosted<D> {
    /// A drive whose words of refusals go into `refusals`.
    pub const fn new(drive: D, refusals: Refusals) -> Self {
        Self { drive, refusals, image: None, address_set: false }
    }

    /// The same drive, whose address and parameters are kept in a file in `state` if there is one: with what it kept before
    /// it was switched off.
    ///
    /// # Errors
    /// [`StateDirError::Owned`], [`StateDirError::File`], [`StateDirError::Refused`]; the file is as before.
    pub(crate) fn kept_in(
        mut self,
        state: Option<&StateDir>,
        now: Instant,
    ) -> Result<Box<dyn Participant>, StateDirError> {
        let Some(state) = state else { return Ok(Box::new(self)) };
        let ident = self.drive.station().slave().description().ident;
        let (file, image, kept) = KeptImage::open(state, D::KEPT_AS, ident, self.drive.address())?;
        self.drive.keep_parameters();
        if let Some(Kept { address, rem_slave_data, values, .. }) = kept {
            self.drive.recall((address, &rem_slave_data), values);
        }
        self.image = Some(image);
        Ok(Box::new(Stored::in_file(self, file, now)))
    }
}

/// What a drive keeps.
fn kept(drive: &impl BusDrive) -> Kept {
    Kept {
        address: drive.station().stored_address(),
        rem_slave_data: drive.station().slave().rem_slave_data().to_vec(),
        values: drive.to_keep(),
        records: Vec::new(),
    }
}

impl<D: HostedDrive> Images for Hosted<D> {
    type Generation = Generation;

    fn poll_image(&mut self) -> Option<(Generation, Vec<u8>)> {
        let image = self.image.as_mut()?;
        let changed = self.drive.take_changed();
        if changed || core::mem::take(&mut self.address_set) {
            image.keep(&kept(&self.drive), changed);
        }
        image.poll()
    }

    fn handle_stored(&mut self, now: Instant, generation: Generation, stored: bool) {
        let Some(image) = &mut self.image else { return };
        match image.report(generation, stored) {
            Outcome::None => {}
            Outcome::Safe => self.drive.handle_stored(now, true),
            Outcome::Undone => {
                self.drive.handle_stored(now, false);
                // The file may hold what was not stored.
                image.keep(&kept(&self.drive), false);
            }
        }
    }
}

impl<D: HostedDrive> Participant for Hosted<D> {
    fn address(&self) -> Address {
        self.drive.address()
    }

    fn set_baud(&mut self, baud: BaudRate) {
        self.drive.set_baud(baud);
    }

    fn rates(&self) -> Rates {
        self.drive.station().slave().description().rates
    }

    fn handle_telegram(&mut self, now: Instant, telegram: &Telegram<'_>, news: &mut dyn FnMut(StationEvent)) {
        let mut refused = None;
        let Self { drive, address_set, .. } = self;
        drive.handle_telegram(now, telegram, &mut |event| {
            if let StationEvent::Dp(event) = &event {
                *address_set |= matches!(event, dp::Event::AddressSet { .. });
                refused = event.refused_number().map(|_| *event).or(refused);
            }
            news(event);
        });
        if let Some(event) = refused {
            self.refusals.learn(self.drive.address(), &event, self.drive.station().slave().application());
        }
    }

    fn handle_timeout(&mut self, now: Instant, news: &mut dyn FnMut(StationEvent)) {
        self.drive.handle_timeout(now, news);
    }

    fn poll_transmit(
        &mut self,
        now: Instant,
        buf: &mut [u8; MAX_TELEGRAM_LEN],
        news: &mut dyn FnMut(StationEvent),
    ) -> Option<usize> {
        self.drive.poll_transmit(now, buf, news)
    }

    fn poll_timeout(&self) -> Option<Instant> {
        self.drive.poll_timeout()
    }

    fn description(&self) -> Option<&dyn Description> {
        Some(&self.drive)
    }

    fn description_mut(&mut self) -> Option<&mut dyn Description> {
        Some(&mut self.drive)
    }

    fn watchdog_on(&self) -> bool {
        self.drive.station().slave().watchdog_on()
    }

    fn startup(&self) -> Option<Startup> {
        self.drive.startup()
    }

    fn appearance(&self) -> Appearance<'_> {
        self.drive.appearance()
    }
}
