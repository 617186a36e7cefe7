//! What kind of slave it is: the facts its GSD states, as data.

use core::ops::RangeInclusive;
use core::time::Duration;

/// What kind of slave it is: the facts its GSD states (`dp-v0.md` 14).
///
/// ```
/// use profidrive::dp::Description;
///
/// // Four octets out, four in, and one user parameter of 0 to 3.
/// const DEVICE: Description = Description {
///     ident: 0x1234,
///     configurations: &[&[0x23, 0x13]],
///     user_prm_len: 1,
///     user_prm: &[0..=3],
///     ..Description::PLAIN
/// };
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Description {
    /// Ident_Number.
    pub ident: u16,
    /// The configurations Chk_Cfg accepts; Get_Cfg reports the first until another one was accepted. One with
    /// more than 244 octets in a direction ([`IoLengths::of`](super::IoLengths::of)) exchanges nothing.
    pub configurations: &'static [&'static [u8]],
    /// The fewest octets of user parameters in Set_Prm (GSD `User_Prm_Data_Len`).
    pub user_prm_len: u8,
    /// The most octets of user parameters, up to 237, where they may be more than the fewest (GSD
    /// `Max_User_Prm_Data_Len` less the fixed ones).
    pub max_user_prm_len: u8,
    /// What each octet of the user parameters may be, the first one first. Octets behind the end of the list may
    /// be anything.
    pub user_prm: &'static [RangeInclusive<u8>],
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
    /// Whether a master may give it another address (GSD `Set_Slave_Add_supp`).
    pub set_slave_add: bool,
    /// How often the application must say that it is alive during Data_Exchange, `None` = need not.
    pub user_watchdog: Option<Duration>,
}

impl Description {
    /// A slave with ident number 0, neither inputs nor outputs nor parameters, and no optional service.
    pub const PLAIN: Self = Self {
        ident: 0,
        configurations: &[],
        user_prm_len: 0,
        max_user_prm_len: 0,
        user_prm: &[],
        dpv1_status: None,
        max_diag_len: 6,
        sync_mode: false,
        freeze_mode: false,
        fail_safe: false,
        set_slave_add: false,
        user_watchdog: None,
    };
}

impl Default for Description {
    fn default() -> Self {
        Self::PLAIN
    }
}
