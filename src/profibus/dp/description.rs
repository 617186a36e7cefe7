//! What kind of slave it is: the facts its GSD states, as data.

use core::time::Duration;

use crate::profibus::fdl::Rates;

/// What kind of slave it is: the facts its GSD states (`dp-v0.md` 14).
///
/// ```
/// use profidrive::profibus::dp::Description;
///
/// // One user parameter, and Sync.
/// const DEVICE: Description =
///     Description { ident: 0x1234, user_prm_len: 1, sync_mode: true, ..Description::PLAIN };
/// ```
///
/// Which configurations and which values of the user parameters are right is judged by the
/// [`Application`](super::Application).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Description {
    /// Ident_Number.
    pub ident: u16,
    /// The rates at which it can be spoken to, each with its max T_SDR. At another one it hears nothing.
    pub rates: Rates,
    /// The fewest octets of user parameters in Set_Prm, DPV1_Status not counted (GSD `User_Prm_Data_Len`, less 3 for
    /// a slave with DPV1_Status).
    pub user_prm_len: u8,
    /// The most octets of user parameters, up to 237, where they may be more than the fewest (GSD
    /// `Max_User_Prm_Data_Len` less the fixed ones).
    pub max_user_prm_len: u8,
    /// For a slave with DPV1_Status_1 to 3 ahead of its user parameters (GSD `DPV1_Slave`): the bits it supports.
    pub dpv1_status: Option<[u8; 3]>,
    /// The longest Slave_Diag in octets, 6..=244 (GSD `Max_Diag_Data_Len`). Blocks that do not fit are left out
    /// and Ext_Diag_Overflow is set.
    pub max_diag_len: u8,
    /// Whether Sync is supported.
    pub sync_mode: bool,
    /// Whether Freeze is supported.
    pub freeze_mode: bool,
    /// Whether a Data_Exchange without outputs means the safe state (GSD `Fail_Safe`).
    pub fail_safe: bool,
    /// Whether a master may leave Fail_Safe of DPV1_Status_1 clear although the slave has it (GSD
    /// `Fail_Safe_required = 0`).
    pub fail_safe_optional: bool,
    /// Whether a master may give it another address (GSD `Set_Slave_Add_supp`).
    pub set_slave_add: bool,
    /// How often the application must say that it is alive during Data_Exchange, `None` = need not.
    pub user_watchdog: Option<Duration>,
}

impl Description {
    /// A slave with ident number 0, without user parameters and optional services, at every rate.
    pub const PLAIN: Self = Self {
        ident: 0,
        rates: Rates::CUSTOMARY,
        user_prm_len: 0,
        max_user_prm_len: 0,
        dpv1_status: None,
        max_diag_len: 6,
        sync_mode: false,
        freeze_mode: false,
        fail_safe: false,
        fail_safe_optional: false,
        set_slave_add: false,
        user_watchdog: None,
    };
}

impl Default for Description {
    fn default() -> Self {
        Self::PLAIN
    }
}
