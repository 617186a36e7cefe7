//! What a master must know of a station to take it over and to operate it.

use crate::face::Operation;
use crate::gsd::Station;
use crate::profibus::dp::chk_cfg::IoLengths;
use crate::profibus::dp::{self, Application as _};
use crate::profibus::ppo::PpoType;

/// What a master sends in Set_Prm and Chk_Cfg so that a slave accepts it, and how it operates the device then.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Startup {
    /// The ident number.
    pub(crate) ident: u16,
    /// The identifiers of Chk_Cfg.
    pub(crate) configuration: Vec<u8>,
    /// The user parameters of Set_Prm, DPV1_Status included.
    pub(crate) user_prm: Vec<u8>,
    /// The PPO that the configuration is, if it is one.
    pub(crate) ppo: Option<PpoType>,
    /// How the device is operated.
    pub(crate) operation: Operation,
}

impl Startup {
    /// What a master sends in Set_Prm (ident number, user parameters with DPV1_Status) and in Chk_Cfg, for a device whose octets
    /// have no meaning of their own.
    #[must_use]
    pub(crate) const fn new(ident: u16, configuration: Vec<u8>, user_prm: Vec<u8>) -> Self {
        Self { ident, configuration, user_prm, ppo: None, operation: Operation::Octets }
    }

    /// A slave that exchanges the words of a PPO by the customary configuration.
    pub(super) fn of_ppo(ident: u16, ppo: PpoType, operation: Operation) -> Self {
        let configuration = ppo.configuration().to_vec();
        Self { ident, configuration, user_prm: Vec::new(), ppo: Some(ppo), operation }
    }

    /// A station that a file describes, in this configuration with the default user parameters.
    pub(super) fn of_station(station: &Station, ident: u16, configuration: Vec<u8>) -> Self {
        let plugged = station.modules(&configuration, None).unwrap_or_default();
        let modules: Vec<usize> = plugged.iter().filter_map(|modules| modules.first().copied()).collect();
        let user_prm = station.gsd().default_user_prm(&modules);
        Self::new(ident, configuration, user_prm)
    }

    /// A slave that a file describes: in the configuration that its last master chose, else in one that the file allows.
    pub(super) fn of_slave(slave: &dp::Slave<Station>) -> Option<Self> {
        let station = slave.application();
        let accepted = slave.accepted_configuration().map(<[u8]>::to_vec);
        let fits = |octets: &[u8]| station.judge_cfg(octets, &[]).is_ok();
        // Where the master chooses the modules, one with inputs and one with outputs.
        let chosen = station.gsd().is_modular() && station.in_slot(0).is_none();
        let both = || {
            Some(inputs_and_outputs(station)).filter(|octets| chosen && !octets.is_empty() && fits(octets))
        };
        let configuration = accepted.or_else(both).or_else(|| usual_configuration(station, fits))?;
        Some(Self::of_station(station, slave.description().ident, configuration))
    }

    /// Octets from the master and to it.
    pub(crate) fn lengths(&self) -> IoLengths {
        IoLengths::of(&self.configuration).unwrap_or_default()
    }
}

/// Where the master chooses: the first module with inputs, and the first with outputs.
fn inputs_and_outputs(station: &Station) -> Vec<u8> {
    let modules = || station.gsd().modules.iter().map(|module| module.identifiers.as_slice());
    let lengths = |octets: &&[u8]| IoLengths::of(octets).unwrap_or_default();
    let reads = modules().find(|octets| lengths(octets).inputs > 0);
    let writes = modules().find(|octets| lengths(octets).outputs > 0);
    match (reads, writes) {
        (Some(reads), Some(writes)) if reads != writes => [reads, writes].concat(),
        (one, other) => one.or(other).unwrap_or_default().to_vec(),
    }
}

/// The configuration that the file of a station fixes; where the master chooses, the first module that is accepted.
pub(super) fn usual_configuration(station: &Station, fits: impl Fn(&[u8]) -> bool) -> Option<Vec<u8>> {
    let fixed = station.configuration(None);
    let modules = station.gsd().modules.iter().map(|module| module.identifiers.as_slice());
    core::iter::once(fixed)
        .chain(modules)
        .find(|octets| !octets.is_empty() && fits(octets))
        .map(<[u8]>::to_vec)
}
