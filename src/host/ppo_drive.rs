//! A drive of the profile on a bus.

use core::fmt;

use super::hosted_drive::{Hosted, HostedDrive};
use super::startup::usual_configuration;
use super::{Appearance, Startup, StationKind};
use crate::devices::ppo_drive::profibus::{PpoDrive, PpoOnly, ppo_of};
use crate::face::Operation;
use crate::gsd::Station;
use crate::profibus::dp::{Application, Fixed, Refusal};
use crate::profibus::ppo::PpoType;

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

/// A drive of the profile that says why it refuses what its device file does not admit. It keeps the values that are written
/// to its parameters: a job that writes has its reply when the value is on the disk.
pub type HostedPpoDrive = Hosted<PpoDrive<PpoOnly<PpoJudge>>>;

impl HostedDrive for PpoDrive<PpoOnly<PpoJudge>> {
    const KEPT_AS: &'static str = "ppo";

    fn startup(&self) -> Option<Startup> {
        let (ident, judge) = (self.slave().description().ident, self.slave().application());
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
        let model = match &self.slave().application().inner {
            PpoJudge::Profile(_) => "profile",
            PpoJudge::Gsd(station) => &station.gsd().model,
        };
        let ppo = self.ppo().filter(|kind| *kind != PpoType::SevenWords);
        Appearance {
            kind: StationKind::PpoDrive,
            device: "ppo-drive",
            model: model.into(),
            product: ppo.map_or("PROFIDRIVE version 2".into(), |ppo| ppo.to_string().into()),
            drive: Some(self.drive().status().state.into()),
            ..Appearance::of_slave(self.slave())
        }
    }
}
