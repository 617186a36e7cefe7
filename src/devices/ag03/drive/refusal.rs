//! Why the drive does not do what it is asked: every unmet condition, with numbers.
//!
//! The real drive refuses silently. Here each refused request leaves one [`Refusal`], and the same list of conditions
//! decides whether the request is accepted at all. A bus adds which of its bits are meant.

#![expect(clippy::use_self, reason = "in what the macro `bitflags` writes")]

use core::fmt;

use enumflags2::{BitFlags, bitflags};
use strum::IntoStaticStr;

use crate::devices::ag03::param::{Lengths, Model};

use super::faults::Fault;
use super::settings::Limits;
use super::states::Direction;

/// A request that was refused, and the conditions it does not meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// What was asked.
    pub request: Request,
    /// Model of the drive: the AG03/1 lacks an output stage supply where the AG03 lacks its enable input.
    pub model: Model,
    /// What positions are counted in.
    pub lengths: Lengths,
    /// Actual position in user units.
    pub position: i32,
    /// Upper limit in user units.
    pub upper_limit: i32,
    /// Lower limit in user units.
    pub lower_limit: i32,
    /// Where a loop travel would turn round, user units. Equal to the setpoint without loop.
    pub loop_point: i32,
    /// The latched fault, or the one whose cause is still present.
    pub fault: Option<Fault>,
    reasons: BitFlags<Reason>,
}

/// What was asked of the drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request {
    /// To enable operation (rows 4, 5, 14).
    Enable,
    /// To acknowledge a fault (rows 10, 11).
    Acknowledge,
    /// To travel to a position in user units (rows 20-22, 25b).
    Travel {
        /// The setpoint.
        setpoint: i32,
    },
    /// To turn with a velocity in rpm (row 40).
    Velocity {
        /// The setpoint.
        setpoint: i32,
    },
    /// Inching 1 (rows 28, 35, 36).
    Inching1(Direction),
    /// Inching 2 (rows 31, 35, 36).
    Inching2(Direction),
}

/// What stands against a request.
#[bitflags]
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, IntoStaticStr)]
#[non_exhaustive]
pub enum Reason {
    /// The control has no supply. Always the only reason: the drive is not there to mind any other.
    SwitchedOff,
    /// A supply is missing, the drive is not ready to run.
    NoSupply,
    /// A fault is latched.
    FaultLatched,
    /// The cause of the fault is still present.
    FaultCause,
    /// Turning on is disabled after a fault until the bus arms it again.
    TurnOnDisabled,
    /// AG03/1: no supply of the output stage. AG03: enable input not active.
    NoOutputStage,
    /// The command does not want operation.
    NotAsked,
    /// Operation is not enabled.
    NotEnabled,
    /// Stop is given.
    Stop,
    /// Intermediate stop is given.
    IntermediateStop,
    /// The operating mode changed while start was given; it must be taken back once.
    StartHeld,
    /// A travel job is active.
    JobActive,
    /// A travel job is paused and can only be continued or stopped.
    JobPaused,
    /// Inching is active.
    InchingActive,
    /// The shaft still brakes or coasts.
    ShaftTurns,
    /// Inching 1 and 2 are asked for together.
    BothInching,
    /// The drive is in velocity mode.
    VelocityMode,
    /// The actual position is above the upper limit.
    AboveUpperLimit,
    /// The actual position is below the lower limit.
    BelowLowerLimit,
    /// The setpoint is above the upper limit.
    SetpointAboveUpperLimit,
    /// The setpoint is below the lower limit.
    SetpointBelowLowerLimit,
    /// The loop point is above the upper limit.
    LoopPointAboveUpperLimit,
    /// The loop point is below the lower limit.
    LoopPointBelowLowerLimit,
    /// The setpoint or the loop point is outside the range of the absolute encoder.
    BeyondEncoder,
}

impl Reason {
    /// Its name for programs, as `NoSupply`.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

impl Refusal {
    /// A request of which no condition is checked yet.
    pub(super) const fn new(request: Request, model: Model) -> Self {
        Self {
            request,
            model,
            lengths: Lengths::Increments,
            position: 0,
            upper_limit: 0,
            lower_limit: 0,
            loop_point: 0,
            fault: None,
            reasons: BitFlags::EMPTY,
        }
    }

    /// Adds `reason` if it `applies` and the drive is switched on.
    pub(super) fn note(&mut self, reason: Reason, applies: bool) {
        if applies && !self.contains(Reason::SwitchedOff) {
            self.reasons |= reason;
        }
    }

    /// Rows 34, 35: beyond a limit the way in `direction` leads on outward.
    pub(super) fn note_outward(&mut self, direction: Direction, limits: Limits) {
        match direction {
            Direction::Positive => self.note(Reason::AboveUpperLimit, limits.is_above(self.position)),
            Direction::Negative => self.note(Reason::BelowLowerLimit, limits.is_below(self.position)),
        }
    }

    /// Whether nothing stands against the request.
    pub(super) fn is_empty(&self) -> bool {
        self.reasons.is_empty()
    }

    /// Whether `reason` is one of the reasons.
    pub(crate) fn contains(&self, reason: Reason) -> bool {
        self.reasons.contains(reason)
    }

    /// Every reason, in the order in which it is printed.
    pub(crate) fn reasons(&self) -> impl Iterator<Item = Reason> + use<> {
        self.reasons.iter()
    }

    /// What was asked in words, with its unit.
    pub(crate) const fn asked(&self) -> impl fmt::Display + use<> {
        Asked { request: self.request, lengths: self.lengths }
    }

    /// One of the reasons in words, with its numbers.
    pub(crate) const fn text(&self, reason: Reason) -> impl fmt::Display + use<> {
        ReasonText { refusal: *self, reason }
    }

    /// What a setpoint far outside the limits would be with its octets the other way round, if that is within them.
    fn write_exchanged(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Request::Travel { setpoint } = self.request else { return Ok(()) };
        let meant = setpoint.swap_bytes();
        let is_far = setpoint.unsigned_abs() >> 24 != 0 && setpoint & 0xFFFF == 0;
        match is_far && (self.lower_limit..=self.upper_limit).contains(&meant) {
            true => write!(
                f,
                ", its octets seem to be exchanged, {} was meant: send the high octet first",
                self.lengths.position(meant.into())
            ),
            false => Ok(()),
        }
    }

    fn write(&self, f: &mut fmt::Formatter<'_>, reason: Reason) -> fmt::Result {
        let place = |number: i32| self.lengths.position(number.into());
        let [position, upper_limit, lower_limit, loop_point] =
            [self.position, self.upper_limit, self.lower_limit, self.loop_point].map(place);
        match reason {
            Reason::FaultLatched => match self.fault {
                Some(fault) => write!(f, "fault {fault} is not acknowledged"),
                None => f.write_str("a fault is not acknowledged"),
            },
            Reason::FaultCause => match self.fault {
                Some(fault) => write!(f, "the cause of fault {fault} is still present"),
                None => f.write_str("the cause of the fault is still present"),
            },
            Reason::TurnOnDisabled => f.write_str("turning on is disabled after a fault"),
            Reason::SwitchedOff => f.write_str("the drive is switched off"),
            Reason::NoSupply => f.write_str("a supply voltage is missing"),
            Reason::NoOutputStage => f.write_str(match self.model {
                Model::Ag03 => "the enable input is not active",
                Model::Ag03_1 => "the supply voltage of the output stage is missing",
            }),
            Reason::NotAsked => f.write_str("operation is not asked for"),
            Reason::NotEnabled => f.write_str("operation is not enabled"),
            Reason::Stop => f.write_str("stop is given"),
            Reason::IntermediateStop => f.write_str("intermediate stop is given"),
            Reason::StartHeld => f.write_str("the operating mode has changed: set the start bit to 0 once"),
            Reason::JobActive => f.write_str("a travel job is active"),
            Reason::JobPaused => f.write_str("a paused travel job must be continued or stopped first"),
            Reason::InchingActive => f.write_str("inching is active"),
            Reason::ShaftTurns => f.write_str("the shaft still turns"),
            Reason::BothInching => f.write_str("inching 1 and inching 2 are asked for together"),
            Reason::VelocityMode => f.write_str("inching needs the positioning mode"),
            Reason::AboveUpperLimit => write!(
                f,
                "actual position {position} is above the upper limit ({upper_limit}): \
                 only inching in negative direction is possible"
            ),
            Reason::BelowLowerLimit => write!(
                f,
                "actual position {position} is below the lower limit ({lower_limit}): \
                 only inching in positive direction is possible"
            ),
            Reason::SetpointAboveUpperLimit => {
                write!(f, "setpoint is above the upper limit ({upper_limit})")?;
                self.write_exchanged(f)
            }
            Reason::SetpointBelowLowerLimit => {
                write!(f, "setpoint is below the lower limit ({lower_limit})")?;
                self.write_exchanged(f)
            }
            Reason::LoopPointAboveUpperLimit => {
                write!(f, "loop point {loop_point} is above the upper limit ({upper_limit})")
            }
            Reason::LoopPointBelowLowerLimit => {
                write!(f, "loop point {loop_point} is below the lower limit ({lower_limit})")
            }
            Reason::BeyondEncoder => f.write_str("the travel would leave the range of the absolute encoder"),
        }
    }
}

/// A reason with the numbers of its refusal.
struct ReasonText {
    refusal: Refusal,
    reason: Reason,
}

impl fmt::Display for ReasonText {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.refusal.write(f, self.reason)
    }
}

impl fmt::Display for Refusal {
    /// One line: the request, then every unmet condition.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} refused", self.asked())?;
        for (index, reason) in self.reasons().enumerate() {
            f.write_str(if index == 0 { ": " } else { "; " })?;
            self.write(f, reason)?;
        }
        Ok(())
    }
}

/// What was asked, with its unit.
struct Asked {
    request: Request,
    lengths: Lengths,
}

impl fmt::Display for Asked {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.request {
            Request::Enable => f.write_str("enabling operation"),
            Request::Acknowledge => f.write_str("acknowledging"),
            Request::Travel { setpoint } => write!(f, "travel to {}", self.lengths.position(setpoint.into())),
            Request::Velocity { setpoint } => write!(f, "velocity {setpoint} rpm"),
            Request::Inching1(direction) => write!(f, "inching 1 in {direction} direction"),
            Request::Inching2(direction) => write!(f, "inching 2 in {direction} direction"),
        }
    }
}

#[cfg(test)]
mod tests {

    use super::*;

    #[test]
    fn a_refusal_reads_as_one_line_with_every_condition() {
        let mut refusal = Refusal::new(Request::Travel { setpoint: 1_200_000 }, Model::Ag03_1);
        refusal.upper_limit = 1_000_000;
        refusal.note(Reason::SetpointAboveUpperLimit, true);
        refusal.note(Reason::Stop, false);
        assert_eq!(
            refusal.to_string(),
            "travel to 1200000 inc refused: setpoint is above the upper limit (1000000 inc)"
        );
        refusal.note(Reason::NoOutputStage, true);
        assert_eq!(
            refusal.to_string(),
            "travel to 1200000 inc refused: the supply voltage of the output stage is missing; \
             setpoint is above the upper limit (1000000 inc)"
        );
    }

    #[test]
    fn every_reason_has_its_own_bit_and_text() {
        let mut texts = std::collections::BTreeSet::new();
        for reason in BitFlags::<Reason>::ALL {
            let mut refusal = Refusal::new(Request::Inching1(Direction::Positive), Model::Ag03);
            refusal.note(reason, true);
            assert!(refusal.reasons().eq([reason]));
            assert!(texts.insert(refusal.to_string()));
        }
    }
}
