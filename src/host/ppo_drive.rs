//! A drive of the profile on a bus.

use core::fmt;

use super::startup::usual_configuration;
use super::state_dir::Images;
use super::station_file::{Kept, KeptImage};
use super::{Appearance, Participant, Refusals, Startup, StateDir, StateDirError, StationKind, Stored};
use crate::devices::StationEvent;
use crate::devices::ppo_drive::profibus::{PpoDrive, PpoOnly, ppo_of};
use crate::face::{Description, Operation};
use crate::gsd::Station;
use crate::image::Generation;
use crate::image::storage::Outcome;
use crate::profibus::dp;
use crate::profibus::dp::{Application, Fixed, Refusal};
use crate::profibus::fdl::MAX_TELEGRAM_LEN;
use crate::profibus::fdl::{Address, Rates, Telegram};
use crate::profibus::ppo::PpoType;
use crate::time::{BaudRate, Instant};

/// The PPO that a master chooses, those with a parameter channel first.
const PARAMETERS_FIRST: [PpoType; 5] =
    [PpoType::Ppo1, PpoType::Ppo2, PpoType::Ppo5, PpoType::Ppo3, PpoType::Ppo4];

/// Who judges what the master of such a drive says, beside that a configuration must be a PPO.
#[derive(Clone, Debug)]
pub enum PpoJudge {
    /// The configurations of the profile.
    Profile(Fixed<'static>),
    /// The device file of a drive.
    Gsd(Box<Station>),
}

impl Application for PpoJudge {
    fn judge_prm(&self, user_prm: &[u8]) -> Result<(), Refusal> {
        match self {
            Self::Profile(fixed) => fixed.judge_prm(user_prm),
            Self::Gsd(station) => station.judge_prm(user_prm),
        }
    }

    fn judge_cfg(&self, configuration: &[u8], user_prm: &[u8]) -> Result<(), Refusal> {
        match self {
            Self::Profile(fixed) => fixed.judge_cfg(configuration, user_prm),
            Self::Gsd(station) => station.judge_cfg(configuration, user_prm),
        }
    }

    fn configuration<'a>(&'a self, accepted: Option<&'a [u8]>) -> &'a [u8] {
        match self {
            Self::Profile(fixed) => fixed.configuration(accepted),
            Self::Gsd(station) => station.configuration(accepted),
        }
    }

    fn words(&self, number: u16, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Profile(fixed) => fixed.words(number, f),
            Self::Gsd(station) => station.words(number, f),
        }
    }
}

/// A drive of the profile that says why it refuses what its device file does not admit.
#[derive(Debug)]
pub struct HostedPpoDrive {
    drive: PpoDrive<PpoOnly<PpoJudge>>,
    refusals: Refusals,
    image: Option<KeptImage>,
    /// Set_Slave_Add has changed the address.
    address_set: bool,
}

impl HostedPpoDrive {
    /// A drive whose words of refusals go into `refusals`.
    pub const fn new(drive: PpoDrive<PpoOnly<PpoJudge>>, refusals: Refusals) -> Self {
        Self { drive, refusals, image: None, address_set: false }
    }

    /// The same drive with what it kept before it was switched off; from now on its file in `state` keeps its address and
    /// the values that are written to its parameters. A job that writes has its reply when the value is on the disk.
    ///
    /// # Errors
    /// [`StateDirError::Owned`], [`StateDirError::File`], [`StateDirError::Refused`]; the file is as before.
    pub(crate) fn kept_in(mut self, state: &StateDir, now: Instant) -> Result<Stored<Self>, StateDirError> {
        let ident = self.drive.slave().description().ident;
        let (file, image, kept) = KeptImage::open(state, "ppo", ident, self.drive.address())?;
        self.drive.keep_parameters();
        if let Some(Kept { address, rem_slave_data, values, .. }) = kept {
            self.drive.recall((address, &rem_slave_data), values);
        }
        self.image = Some(image);
        Ok(Stored::in_file(self, file, now))
    }
}

impl Images for HostedPpoDrive {
    type Generation = Generation;

    fn poll_image(&mut self) -> Option<(Generation, Vec<u8>)> {
        let image = self.image.as_mut()?;
        let written = self.drive.take_changed();
        if written || core::mem::take(&mut self.address_set) {
            image.keep(&kept(&self.drive), written);
        }
        image.poll()
    }

    fn handle_stored(&mut self, _: Instant, generation: Generation, stored: bool) {
        let Some(image) = &mut self.image else { return };
        match image.report(generation, stored) {
            Outcome::None => {}
            Outcome::Safe => self.drive.handle_stored(true),
            Outcome::Undone => {
                self.drive.handle_stored(false);
                // The file may hold what was refused.
                image.keep(&kept(&self.drive), false);
            }
        }
    }
}

/// What the drive keeps.
fn kept(drive: &PpoDrive<PpoOnly<PpoJudge>>) -> Kept {
    Kept {
        address: drive.stored_address(),
        rem_slave_data: drive.slave().rem_slave_data().to_vec(),
        values: drive.written().collect(),
        records: Vec::new(),
    }
}

impl Participant for HostedPpoDrive {
    fn address(&self) -> Address {
        self.drive.address()
    }

    fn set_baud(&mut self, baud: BaudRate) {
        self.drive.set_baud(baud);
    }

    fn rates(&self) -> Rates {
        self.drive.slave().description().rates
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

    fn startup(&self) -> Option<Startup> {
        let (ident, judge) = (self.drive.slave().description().ident, self.drive.slave().application());
        let is = |octets: &[u8], kind| ppo_of(octets) == Some(kind) && judge.judge_cfg(octets, &[]).is_ok();
        PARAMETERS_FIRST.into_iter().find_map(|kind| {
            let startup = match &judge.inner {
                PpoJudge::Profile(_) => Startup::of_ppo(ident, kind, Operation::Speed),
                PpoJudge::Gsd(station) => {
                    let configuration = usual_configuration(station, |octets| is(octets, kind))
                        .unwrap_or_else(|| kind.configuration().to_vec());
                    let of_file = Startup::of_station(station, ident, configuration);
                    Startup { ppo: Some(kind), operation: Operation::Speed, ..of_file }
                }
            };
            is(&startup.configuration, kind).then_some(startup)
        })
    }

    fn appearance(&self) -> Appearance<'_> {
        let model = match &self.drive.slave().application().inner {
            PpoJudge::Profile(_) => "profile",
            PpoJudge::Gsd(station) => &station.gsd().model,
        };
        let ppo = self.drive.ppo().filter(|kind| *kind != PpoType::SevenWords);
        Appearance {
            kind: StationKind::PpoDrive,
            device: "ppo-drive",
            model: model.into(),
            product: ppo.map_or("PROFIDRIVE version 2".into(), |ppo| ppo.to_string().into()),
            drive: Some(self.drive.drive().status().state.into()),
            ..Appearance::of_slave(self.drive.slave())
        }
    }
}
