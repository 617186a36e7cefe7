//! A drive of PROFIdrive 3 and 4 on a bus.

use super::hosted_drive::{Hosted, HostedDrive};
use super::startup::usual_configuration;
use super::{Appearance, Startup, StationKind};
use crate::devices::profidrive4::profibus::{ProfidriveDevice, Telegram, TelegramOnly};
use crate::face::Operation;
use crate::gsd::Station;
use crate::profibus::ppo::PpoType;

/// A drive that says why it refuses what its device file does not admit. It keeps the parameters that are stored.
pub type HostedProfidrive = Hosted<ProfidriveDevice<TelegramOnly<Station>>>;

impl HostedDrive for ProfidriveDevice<TelegramOnly<Station>> {
    const KEPT_AS: &'static str = "profidrive";

    /// Telegram 1, which has the words of PPO 3, unless the drive is set to another one.
    fn startup(&self) -> Option<Startup> {
        let TelegramOnly { inner: station, only } = self.slave().application();
        let wanted = only.or_else(|| Telegram::numbered(1));
        let is_it = |octets: &[u8]| Telegram::of_configuration(octets, wanted).is_some();
        let configuration = usual_configuration(station, is_it).or_else(|| {
            usual_configuration(station, |octets| Telegram::of_configuration(octets, *only).is_some())
        })?;
        let is_speed =
            Telegram::of_configuration(&configuration, None).is_some_and(|telegram| telegram.number == 1);
        let startup = Startup::of_station(station, self.slave().description().ident, configuration);
        if !is_speed {
            return Some(startup);
        }
        Some(Startup { ppo: Some(PpoType::Ppo3), operation: Operation::Speed, ..startup })
    }

    fn appearance(&self) -> Appearance<'_> {
        let telegram = self.telegram();
        let product = telegram.map_or("PROFIdrive 4".into(), |telegram| {
            format!("PROFIdrive 4, telegram {}", telegram.number).into()
        });
        Appearance {
            kind: StationKind::Profidrive,
            device: "profidrive",
            model: self.slave().application().inner.gsd().model.as_str().into(),
            product,
            drive: crate::face::Surroundings::drive_state(self),
            ..Appearance::of_slave(self.slave())
        }
    }
}
