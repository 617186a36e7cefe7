//! An AG03 or AG03/1 in profirust's words.

use std::vec;

use profirust::dp::{Peripheral, PeripheralOptions};

use crate::device::{CONFIGURATIONS, DESCRIPTION};
use crate::time::BaudRate;

/// Octets of outputs and of inputs that [`CONFIGURATIONS`] stand for: seven words.
const DATA_LEN: usize = 14;

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
/// [`crate::ppo`] draws and builds both.
pub fn peripheral(address: u8, baud: BaudRate) -> Peripheral<'static> {
    Peripheral::new(address, options(baud), vec![0; DATA_LEN], vec![0; DATA_LEN])
}
