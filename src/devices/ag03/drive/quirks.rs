//! Where the manuals leave the drive open: what else it might do.

use super::states::DirectionChange;

/// Alternatives to the proposals of `ag03.md` 15; each is off by default. `docs/quirks.md` has the reasons.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Quirks {
    /// In velocity mode ready-to-travel comes with STW.6 = 0 at once, not when the shaft stands (C-11).
    pub ready_while_running_down: bool,
    /// The speed of inching 2 is rounded up, not to the nearest whole rpm (C-12).
    pub inching_rounds_up: bool,
    /// The torque deactivation discards the job instead of keeping it (C-13).
    pub torque_discards_job: bool,
    /// What STW.15 does while inching 2 goes on (C-40).
    pub inch_2_direction_change: DirectionChange,
    /// Inpos modes 1 and 2 act as soon as the position is in the window, not when the shaft stands there (C-41).
    pub inpos_acts_in_window: bool,
    /// Inching and the keys stand at a limit, instead of braking from there (C-42).
    pub inching_stops_at_limit: bool,
}
