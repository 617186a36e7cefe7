//! Where the manuals leave the drive open: what else it might do.

use super::states::DirectionChange;

/// Alternatives to the proposals of `ag03.md` 15; each is off by default. `docs/quirks.md` has the reasons.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Quirks {
    /// C-11: in velocity mode ready-to-travel comes with STW.6 = 0 at once, not when the shaft stands.
    pub ready_while_running_down: bool,
    /// C-12: the speed of inching 2 is rounded up, not to the nearest whole rpm.
    pub inching_rounds_up: bool,
    /// C-13: the torque deactivation discards the job instead of keeping it.
    pub torque_discards_job: bool,
    /// C-40: what STW.15 does while inching 2 goes on.
    pub inch_2_direction_change: DirectionChange,
    /// C-41: inpos modes 1 and 2 act as soon as the position is in the window, not when the shaft stands there.
    pub inpos_acts_in_window: bool,
    /// C-42: inching and the keys stand at a limit, instead of braking from there.
    pub inching_stops_at_limit: bool,
}
