//! A slave in profirust's words, first of all an AG03 or AG03/1.

use profirust::dp::{Peripheral, PeripheralOptions};

use crate::devices::ag03::profibus::{CONFIGURATIONS, DESCRIPTION, IDENT_NUMBER};
use crate::profibus::ppo::PpoType;
use crate::time::BaudRate;

/// Octets of outputs and of inputs that [`CONFIGURATIONS`] stand for: seven words.
const DATA_LEN: usize = 14;

/// What a master must know of a slave to exchange data with it: what its GSD says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slave {
    /// The ident number.
    pub ident: u16,
    /// The identifiers of Chk_Cfg.
    pub configuration: &'static [u8],
    /// The user parameters of Set_Prm, DPV1_Status included.
    pub user_prm: &'static [u8],
    /// Octets from the master.
    pub outputs: usize,
    /// Octets to the master.
    pub inputs: usize,
    /// It knows Sync.
    pub sync_mode: bool,
    /// It knows Freeze.
    pub freeze_mode: bool,
}

impl Slave {
    /// An AG03 or AG03/1, as [`peripheral()`].
    pub(crate) const AG03: Self = Self {
        ident: IDENT_NUMBER,
        configuration: PpoType::SevenWords.configuration(),
        user_prm: &[],
        outputs: DATA_LEN,
        inputs: DATA_LEN,
        sync_mode: DESCRIPTION.sync_mode,
        freeze_mode: DESCRIPTION.freeze_mode,
    };

    /// A drive with this ident number, in this PPO with its customary configuration and without user parameters.
    pub const fn ppo(ident: u16, kind: PpoType) -> Self {
        let (configuration, len) = (kind.configuration(), kind.len());
        Self {
            ident,
            configuration,
            outputs: len,
            inputs: len,
            sync_mode: false,
            freeze_mode: false,
            ..Self::AG03
        }
    }

    pub(super) fn peripheral(&self, address: u8, baud: BaudRate) -> Peripheral<'static> {
        let options = PeripheralOptions {
            ident_number: self.ident,
            sync_mode: self.sync_mode,
            freeze_mode: self.freeze_mode,
            user_parameters: Some(self.user_prm),
            config: Some(self.configuration),
            ..options(baud)
        };
        Peripheral::new(address, options, vec![0; self.inputs], vec![0; self.outputs])
    }
}

/// What the master sends in Set_Prm and Chk_Cfg, as the GSD has it: the ident number, no user parameters, the first
/// configuration of [`CONFIGURATIONS`] (F3 F2), no group, no fail-safe.
///
/// Sync and Freeze are asked for as the GSD allows it. The watchdog is not of a slave but of the whole bus:
/// [`profirust::fdl::ParametersBuilder::watchdog_timeout`].
pub fn options(baud: BaudRate) -> PeripheralOptions<'static> {
    PeripheralOptions {
        ident_number: DESCRIPTION.ident,
        sync_mode: DESCRIPTION.sync_mode,
        freeze_mode: DESCRIPTION.freeze_mode,
        groups: 0,
        max_tsdr: baud.max_tsdr_bits(),
        fail_safe: false,
        // `None` would mean: not known yet, wait.
        user_parameters: Some(&[]),
        config: CONFIGURATIONS.first().copied(),
    }
}

/// The drive at `address` on a line at `baud`: 14 octets of outputs, all zero, and 14 octets of inputs.
///
/// [`crate::profibus::ppo`] draws and builds both.
pub fn peripheral(address: u8, baud: BaudRate) -> Peripheral<'static> {
    Peripheral::new(address, options(baud), vec![0; DATA_LEN], vec![0; DATA_LEN])
}
