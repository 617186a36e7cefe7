//! Where the manuals leave the drive open: what else it might do.

use super::states::DirectionChange;

/// Alternatives to the proposals of `ag03.md` 15; each is off by default. `docs/quirks.md` has the reasons.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Quirks {
    /// C-05: a paused job counts as active positioning: not ready-to-travel (ZSW.15 = 0, SSW.14 = 1).
    pub paused_is_active: bool,
    /// C-06: turn-on disabled is left only by a change of STW.0 from 1 to 0, not by its being 0.
    pub off1_needs_edge: bool,
    /// C-07: ZSW.12 takes the level of STW.6 when a job is accepted, instead of toggling.
    pub acknowledge_mirrors_start: bool,
    /// C-09: ready to turn on (ZSW.0, ZSW.1) is 0 in fault and turn-on disabled.
    pub not_ready_in_fault: bool,
    /// C-11: in velocity mode ready-to-travel comes with STW.6 = 0 at once, not when the shaft stands.
    pub ready_while_running_down: bool,
    /// C-12: the speed of inching 2 is rounded up, not to the nearest whole rpm.
    pub inching_rounds_up: bool,
    /// C-13: the torque deactivation discards the job instead of keeping it.
    pub torque_discards_job: bool,
    /// C-18: PNU 945 lists the oldest fault first.
    pub oldest_fault_first: bool,
    /// C-23: OFF1 brakes with maximum deceleration and then releases the motor, instead of releasing at once.
    pub off1_brakes: bool,
    /// C-24: OFF1, OFF2 and disable together (STW = 0) brake with maximum deceleration and then release.
    pub all_zero_brakes: bool,
    /// C-32: only a change of STW.6 from 0 to 1 starts a travel job.
    pub start_needs_rising_edge: bool,
    /// C-35: target reached (ZSW.10) follows the position window during a job too.
    pub target_reached_live: bool,
    /// C-40: what STW.15 does while inching 2 goes on.
    pub inch_2_direction_change: DirectionChange,
    /// C-41: inpos modes 1 and 2 act as soon as the position is in the window, not when the shaft stands there.
    pub inpos_acts_in_window: bool,
    /// C-42: inching and the keys stand at a limit, instead of braking from there.
    pub inching_stops_at_limit: bool,
    /// C-36: STW.0 = 0 must be seen once in Data_Exchange before operation can be enabled.
    pub off1_must_be_seen: bool,
}
