//! A drive of PROFIdrive 3 and 4 on a bus.

use super::startup::usual_configuration;
use super::state_dir::Images;
use super::station_file::{Kept, KeptImage};
use super::{Appearance, Participant, Refusals, Startup, StateDir, StateDirError, StationKind, Stored};
use crate::devices::StationEvent;
use crate::devices::profidrive4::profibus::{ProfidriveDevice, Telegram, TelegramOnly};
use crate::face::{Description, Operation};
use crate::gsd::Station;
use crate::image::Generation;
use crate::image::storage::Outcome;
use crate::profibus::dp;
use crate::profibus::fdl::MAX_TELEGRAM_LEN;
use crate::profibus::fdl::{self, Address, Rates};
use crate::profibus::ppo::PpoType;
use crate::time::{BaudRate, Instant};

/// A drive, and the station of its device file.
type Drive = ProfidriveDevice<TelegramOnly<Station>>;

/// A drive that says why it refuses what its device file does not admit.
#[derive(Debug)]
pub struct HostedProfidrive {
    drive: Drive,
    refusals: Refusals,
    image: Option<KeptImage>,
    /// Set_Slave_Add has changed the address.
    address_set: bool,
}

impl HostedProfidrive {
    /// A drive whose words of refusals go into `refusals`.
    pub const fn new(drive: Drive, refusals: Refusals) -> Self {
        Self { drive, refusals, image: None, address_set: false }
    }

    /// The same drive with what it kept before it was switched off; from now on its file in `state` keeps its address and
    /// the parameters that are stored.
    ///
    /// # Errors
    /// [`StateDirError::Owned`], [`StateDirError::File`], [`StateDirError::Refused`]; the file is as before.
    pub(crate) fn kept_in(mut self, state: &StateDir, now: Instant) -> Result<Stored<Self>, StateDirError> {
        let ident = self.drive.slave().description().ident;
        let (file, image, kept) = KeptImage::open(state, "profidrive", ident, self.drive.address())?;
        self.drive.keep_parameters();
        if let Some(Kept { address, rem_slave_data, values, .. }) = kept {
            self.drive.recall((address, &rem_slave_data), values);
        }
        self.image = Some(image);
        Ok(Stored::in_file(self, file, now))
    }
}

impl Images for HostedProfidrive {
    type Generation = Generation;

    fn poll_image(&mut self) -> Option<(Generation, Vec<u8>)> {
        let image = self.image.as_mut()?;
        let stores = self.drive.take_changed();
        if stores || core::mem::take(&mut self.address_set) {
            image.keep(&kept(&self.drive), stores);
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

/// What the drive keeps.
fn kept(drive: &Drive) -> Kept {
    Kept {
        address: drive.stored_address(),
        rem_slave_data: drive.slave().rem_slave_data().to_vec(),
        values: drive.to_keep(),
        records: Vec::new(),
    }
}

impl Participant for HostedProfidrive {
    /// Telegram 1, which has the words of PPO 3, unless the drive is set to another one.
    fn startup(&self) -> Option<Startup> {
        let TelegramOnly { inner: station, only } = self.drive.slave().application();
        let wanted = only.or_else(|| Telegram::numbered(1));
        let is_it = |octets: &[u8]| Telegram::of_configuration(octets, wanted).is_some();
        let configuration = usual_configuration(station, is_it).or_else(|| {
            usual_configuration(station, |octets| Telegram::of_configuration(octets, *only).is_some())
        })?;
        let is_speed =
            Telegram::of_configuration(&configuration, None).is_some_and(|telegram| telegram.number == 1);
        let startup = Startup::of_station(station, self.drive.slave().description().ident, configuration);
        if !is_speed {
            return Some(startup);
        }
        Some(Startup { ppo: Some(PpoType::Ppo3), operation: Operation::Speed, ..startup })
    }

    fn address(&self) -> Address {
        self.drive.address()
    }

    fn set_baud(&mut self, baud: BaudRate) {
        self.drive.set_baud(baud);
    }

    fn rates(&self) -> Rates {
        self.drive.slave().description().rates
    }

    fn handle_telegram(
        &mut self,
        now: Instant,
        telegram: &fdl::Telegram<'_>,
        news: &mut dyn FnMut(StationEvent),
    ) {
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
            self.refusals.learn(self.drive.address(), &event, self.drive.slave().application());
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
        self.drive.slave().watchdog_on()
    }

    fn appearance(&self) -> Appearance<'_> {
        let telegram = self.drive.telegram();
        let product = telegram.map_or("PROFIdrive 4".into(), |telegram| {
            format!("PROFIdrive 4, telegram {}", telegram.number).into()
        });
        Appearance {
            kind: StationKind::Profidrive,
            device: "profidrive",
            model: self.drive.slave().application().inner.gsd().model.as_str().into(),
            product,
            drive: crate::face::Surroundings::drive_state(&self.drive),
            ..Appearance::of_slave(self.drive.slave())
        }
    }
}
