//! Where the manuals leave the drive open: what else it might do.

use super::states::DirectionChange;

/// Alternatives to the proposals of `ag03.md` 15; each is off by default. `docs/quirks.md` has the reasons.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Quirks {
    /// A paused job counts as active positioning: not ready-to-travel (ZSW.15 = 0, SSW.14 = 1) (C-05).
    pub paused_is_active: bool,
    /// Turn-on disabled is left only by a change of STW.0 from 1 to 0, not by its being 0 (C-06).
    pub off1_needs_edge: bool,
    /// ZSW.12 takes the level of STW.6 when a job is accepted, instead of toggling (C-07).
    pub acknowledge_mirrors_start: bool,
    /// Ready to turn on (ZSW.0, ZSW.1) is 0 in fault and turn-on disabled (C-09).
    pub not_ready_in_fault: bool,
    /// In velocity mode ready-to-travel comes with STW.6 = 0 at once, not when the shaft stands (C-11).
    pub ready_while_running_down: bool,
    /// The speed of inching 2 is rounded up, not to the nearest whole rpm (C-12).
    pub inching_rounds_up: bool,
    /// The torque deactivation discards the job instead of keeping it (C-13).
    pub torque_discards_job: bool,
    /// PNU 945 lists the oldest fault first (C-18).
    pub oldest_fault_first: bool,
    /// OFF1 brakes with maximum deceleration and then releases the motor, instead of releasing at once (C-23).
    pub off1_brakes: bool,
    /// OFF1, OFF2 and disable together (STW = 0) brake with maximum deceleration and then release (C-24).
    pub all_zero_brakes: bool,
    /// Only a change of STW.6 from 0 to 1 starts a travel job (C-32).
    pub start_needs_rising_edge: bool,
    /// Target reached (ZSW.10) follows the position window during a job too (C-35).
    pub target_reached_live: bool,
    /// What STW.15 does while inching 2 goes on (C-40).
    pub inch_2_direction_change: DirectionChange,
    /// Inpos modes 1 and 2 act as soon as the position is in the window, not when the shaft stands there (C-41).
    pub inpos_acts_in_window: bool,
    /// Inching and the keys stand at a limit, instead of braking from there (C-42).
    pub inching_stops_at_limit: bool,
    /// STW.0 = 0 must be seen once in Data_Exchange before operation can be enabled (C-36).
    pub off1_must_be_seen: bool,
}
