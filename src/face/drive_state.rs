//! The state of a drive in the few words that all devices share.

use strum::{IntoStaticStr, VariantArray};

/// Where a drive is, whichever device and bus it has. What each device calls its own states is in its reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "snake_case")]
pub enum DriveState {
    /// No control supply.
    Off,
    /// A supply is missing, or the drive initialises itself.
    NotReady,
    /// OFF1, or shutdown, must be given once.
    Inhibited,
    /// Waits for ON, or for the enabling of operation. The motor does not follow the master.
    Ready,
    /// The motor follows the master, or brakes because it no longer does.
    Enabled,
    /// A fault is not acknowledged.
    Fault,
}

impl DriveState {
    /// Every state.
    pub(crate) const ALL: &'static [Self] = <Self as VariantArray>::VARIANTS;

    /// Its name for programs, as `not_ready`.
    pub(crate) fn name(self) -> &'static str {
        self.into()
    }
}
