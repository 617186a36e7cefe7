//! Why the drive does not do what it is asked: every condition that ZSW, SSW, parameters or the diagnosis show.

use core::fmt;
use core::time::Duration;

use strum::VariantArray;
use thiserror::Error;

use super::goal::Goal;
use crate::devices::ag03::drive::{Fault, Mode};
use crate::devices::ag03::param::Gear;
use crate::devices::ag03::profibus::bits::{GeneralStatusBit, SswBit, ZswBit};
use crate::profibus::dp::DiagBit;
use crate::profibus::ppo::Zsw;

/// What stands against a goal, and where it shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, VariantArray)]
#[non_exhaustive]
pub enum Obstacle {
    /// No input image came: there is no Data_Exchange.
    NoDataExchange,
    /// Diagnosis: the master finds no station at the address.
    NoStation,
    /// Diagnosis: Set_Prm was refused, perhaps for a wrong ident number.
    ParameterFault,
    /// Diagnosis: Chk_Cfg was refused.
    ConfigurationFault,
    /// Diagnosis: another master owns the drive.
    OtherMaster,
    /// Diagnosis: the drive must be parameterised, or is not ready.
    StationNotReady,
    /// PNU 930: the drive is in velocity mode.
    VelocityMode,
    /// PNU 930: the drive is in positioning mode.
    PositioningMode,
    /// ZSW.0 = 0: a supply is missing.
    NoSupply,
    /// ZSW.3: a fault is latched; its letter is read from PNU 945.
    Fault,
    /// ZSW.3 is still 1 after the acknowledge: the cause of the fault is still there.
    FaultCause,
    /// ZSW.6: turn-on disabled.
    TurnOnDisabled,
    /// ZSW.2 = 0: operation is not enabled.
    NotEnabled,
    /// SSW.10: AG03/1: no supply of the output stage. AG03: enable input not active.
    NoOutputStage,
    /// SSW.5: the position is above the upper limit.
    AboveUpperLimit,
    /// SSW.6: the position is below the lower limit.
    BelowLowerLimit,
    /// ZSW.14: a limit is exceeded; which one is not known.
    LimitExceeded,
    /// PNU 1016 and 1017: the target is not within the limits.
    TargetBeyondLimits,
    /// PNU 1014: the drive approaches in a loop whose turning point may be beyond a limit.
    LoopPoint,
    /// PNU 961: the velocity is more than the gear allows.
    BeyondGear,
    /// SSW.14: a positioning is active.
    PositioningActive,
    /// ZSW.13 = 0 or SSW.4: the shaft turns.
    ShaftTurns,
    /// PNU 1031.7: the torque deactivation has interrupted the job.
    TorqueTripped,
    /// ZSW.8 = 0: lag error, the load is too high.
    LagError,
    /// There is no travel job to interrupt or to continue.
    NoJob,
}

impl Obstacle {
    /// Every obstacle, in the order in which [`Obstacles`] prints them.
    pub const ALL: &'static [Self] = <Self as VariantArray>::VARIANTS;

    const fn text(self) -> &'static str {
        match self {
            Self::NoDataExchange => "there is no Data_Exchange with the drive",
            Self::NoStation => {
                "no station answers at its address: check its DIP switches, the cable and the rate of the line"
            }
            Self::ParameterFault => {
                "it refused Set_Prm (Slave_Diag octet 1 bit 6, Prm_Fault = 1): the ident number must be 0AC5"
            }
            Self::ConfigurationFault => {
                "it refused Chk_Cfg (Slave_Diag octet 1 bit 2, Cfg_Fault = 1): the configuration must be F3 F2 or F6"
            }
            Self::OtherMaster => {
                "another master owns it (Slave_Diag octet 1 bit 7, Master_Lock = 1): stop that master, or let it unlock the drive"
            }
            Self::StationNotReady => {
                "it is not ready for Data_Exchange (Slave_Diag octet 1 bit 1, Station_Not_Ready = 1)"
            }
            Self::VelocityMode => "the drive is in velocity mode: write 2 to PNU 930 first",
            Self::PositioningMode => "the drive is in positioning mode: write 1 to PNU 930 first",
            Self::NoSupply => "a supply voltage is missing (ZSW.0 = 0): switch it on",
            Self::Fault => {
                "a fault is latched (ZSW.3 = 1): remove its cause, then acknowledge it (STW.7 from 0 to 1)"
            }
            Self::FaultCause => {
                "the cause of the fault is still present (ZSW.3 = 1 after the acknowledgement): remove it, then acknowledge again"
            }
            Self::TurnOnDisabled => "turning on is disabled (ZSW.6 = 1): give OFF1 once (STW.0 = 0)",
            Self::NotEnabled => "operation is not enabled (ZSW.2 = 0)",
            Self::NoOutputStage => {
                "the supply of the output stage (AG03/1) or the enable input (AG03) is missing (SSW.10 = 1): switch it on"
            }
            Self::AboveUpperLimit => {
                "the position is above the upper limit: only inching in negative direction is possible (SSW.5 = 1), or change the limits (PNU 1016, 1017)"
            }
            Self::BelowLowerLimit => {
                "the position is below the lower limit: only inching in positive direction is possible (SSW.6 = 1), or change the limits (PNU 1016, 1017)"
            }
            Self::LimitExceeded => {
                "the position is beyond a limit (ZSW.14 = 1): inch back, or change the limits (PNU 1016, 1017)"
            }
            Self::TargetBeyondLimits => "the target is beyond a limit (PNU 1016, 1017)",
            Self::LoopPoint => {
                "the drive approaches in a loop (PNU 1014) whose turning point may be beyond a limit"
            }
            Self::BeyondGear => "the velocity is more than the gear allows (PNU 961)",
            Self::PositioningActive => {
                "a positioning is active (SSW.14 = 1): wait for its end, or stop it (STW.4 = 0)"
            }
            Self::ShaftTurns => "the shaft turns (ZSW.13 = 0 or SSW.4 = 1): wait until it stands",
            Self::TorqueTripped => {
                "the torque deactivation has tripped (PNU 1031.7 = 1): resume the job, or stop it"
            }
            Self::LagError => {
                "lag error, the load is too high for the commanded speed (ZSW.8 = 0): reduce load or speed (PNU 1004)"
            }
            Self::NoJob => "there is no travel job",
        }
    }
}

/// What the client knows of the drive when it gives a goal up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Findings {
    /// The last status word; `None` without Data_Exchange.
    pub zsw: Option<Zsw>,
    /// PNU 1020, system status word.
    pub ssw: Option<u16>,
    /// PNU 1031, general status register.
    pub general_status: Option<u16>,
    /// PNU 930, operating mode.
    pub mode: Option<Mode>,
    /// PNU 945, first element: the code of the newest fault.
    pub fault_code: Option<u8>,
    /// PNU 1016 and 1017, in this order.
    pub limits: [Option<i32>; 2],
    /// PNU 1014, positioning type.
    pub pos_type: Option<u16>,
    /// PNU 961: the gear.
    pub gear: Option<Gear>,
    /// The first two octets of the last diagnosis.
    pub diagnosis: Option<[u8; 2]>,
    /// A travel job of this client is active or interrupted.
    pub job: bool,
}

/// Everything that stands against a goal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub struct Obstacles {
    /// What was asked.
    pub goal: Goal,
    /// How long the drive was given, if it did not refuse by something it shows.
    pub waited: Option<Duration>,
    /// What was found.
    pub findings: Findings,
}

impl Obstacles {
    /// What is known while the goal is under way.
    pub(super) const fn of(goal: Goal, findings: Findings) -> Self {
        Self { goal, waited: None, findings }
    }

    /// By SSW: no edge would start a job.
    pub(super) fn rule_out_travel(&self) -> bool {
        [Obstacle::NoOutputStage, Obstacle::AboveUpperLimit, Obstacle::BelowLowerLimit]
            .into_iter()
            .any(|obstacle| self.contains(obstacle))
    }

    /// Every obstacle, in the order of [`Obstacle::ALL`]. None: the drive shows no reason.
    pub fn iter(&self) -> impl Iterator<Item = Obstacle> {
        Obstacle::ALL.iter().copied().filter(|obstacle| self.contains(*obstacle))
    }

    /// Whether this stands against the goal.
    pub fn contains(&self, obstacle: Obstacle) -> bool {
        let Self { goal, findings, .. } = self;
        let zsw = |bit: ZswBit| findings.zsw.map(|zsw| bit.is_set(zsw));
        let ssw = |bit: SswBit| findings.ssw.is_some_and(|ssw| bit.is_set(ssw));
        let diagnosis = |bit: DiagBit| {
            findings.zsw.is_none() && findings.diagnosis.is_some_and(|octets| bit.is_set(&octets))
        };
        let moves = goal.moves();
        // Not a matter of limits and jobs: the drive could not travel anyway.
        let enabled = zsw(ZswBit::OperationEnabled) == Some(true);
        match obstacle {
            Obstacle::NoDataExchange => findings.zsw.is_none(),
            Obstacle::NoStation => diagnosis(DiagBit::StationNonExistent),
            Obstacle::ParameterFault => diagnosis(DiagBit::PrmFault),
            Obstacle::ConfigurationFault => diagnosis(DiagBit::CfgFault),
            Obstacle::OtherMaster => diagnosis(DiagBit::MasterLock),
            Obstacle::StationNotReady => diagnosis(DiagBit::StationNotReady) || diagnosis(DiagBit::PrmReq),
            Obstacle::VelocityMode => {
                findings.mode == Some(Mode::Velocity) && goal.mode() == Some(Mode::Positioning)
            }
            Obstacle::PositioningMode => {
                findings.mode == Some(Mode::Positioning) && goal.mode() == Some(Mode::Velocity)
            }
            // In fault and turn-on disabled it may say nothing about the supply (C-09).
            Obstacle::NoSupply => {
                zsw(ZswBit::ReadyToTurnOn) == Some(false)
                    && zsw(ZswBit::Fault) == Some(false)
                    && zsw(ZswBit::TurnOnDisabled) == Some(false)
            }
            Obstacle::Fault => zsw(ZswBit::Fault) == Some(true) && *goal != Goal::Acknowledge,
            Obstacle::FaultCause => zsw(ZswBit::Fault) == Some(true) && *goal == Goal::Acknowledge,
            Obstacle::TurnOnDisabled => zsw(ZswBit::TurnOnDisabled) == Some(true),
            Obstacle::NotEnabled => {
                (moves || *goal == Goal::Pause) && zsw(ZswBit::OperationEnabled) == Some(false)
            }
            Obstacle::NoOutputStage => (moves || *goal == Goal::Enable) && ssw(SswBit::NoOutputStage),
            Obstacle::AboveUpperLimit => moves && ssw(SswBit::AboveUpperLimit),
            Obstacle::BelowLowerLimit => moves && ssw(SswBit::BelowLowerLimit),
            Obstacle::LimitExceeded => {
                let positioning = findings.mode == Some(Mode::Positioning);
                let which = ssw(SswBit::AboveUpperLimit) || ssw(SswBit::BelowLowerLimit);
                moves && positioning && zsw(ZswBit::LimitExceeded) == Some(true) && !which
            }
            Obstacle::TargetBeyondLimits => self.target_beyond_limits(),
            Obstacle::LoopPoint => {
                enabled
                    && goal.target().is_some()
                    && findings.pos_type.is_some_and(|kind| kind != 0)
                    && !self.target_beyond_limits()
            }
            Obstacle::BeyondGear => goal
                .rpm()
                .zip(findings.gear)
                .is_some_and(|(rpm, gear)| rpm.unsigned_abs() > gear.max_rpm().into()),
            Obstacle::PositioningActive => moves && ssw(SswBit::PositioningActive),
            Obstacle::ShaftTurns => zsw(ZswBit::Standstill) == Some(false) || ssw(SswBit::Travels),
            Obstacle::TorqueTripped => findings
                .general_status
                .is_some_and(|register| GeneralStatusBit::TorqueDeactivation.is_set(register)),
            Obstacle::LagError => {
                findings.mode == Some(Mode::Positioning) && zsw(ZswBit::NoLagError) == Some(false)
            }
            Obstacle::NoJob => {
                let tripped = self.contains(Obstacle::TorqueTripped);
                matches!(goal, Goal::Pause | Goal::Resume) && !findings.job && !tripped
            }
        }
    }

    /// Equal limits are no limits (`ag03.md` 9).
    fn target_beyond_limits(&self) -> bool {
        let [limit_1, limit_2] = self.findings.limits;
        self.goal
            .target()
            .zip(limit_1)
            .zip(limit_2)
            .is_some_and(|((target, a), b)| a != b && !(a.min(b)..=a.max(b)).contains(&target))
    }

    /// One obstacle in words, with its numbers.
    pub(crate) const fn text(&self, obstacle: Obstacle) -> impl fmt::Display + use<> {
        Text { obstacles: *self, obstacle }
    }

    fn write(&self, f: &mut fmt::Formatter<'_>, obstacle: Obstacle) -> fmt::Result {
        f.write_str(obstacle.text())?;
        let Findings { fault_code, limits, gear, .. } = self.findings;
        let fault = fault_code.and_then(|code| Fault::ALL.into_iter().find(|fault| fault.code() == code));
        if let Some(fault) = fault
            && matches!(obstacle, Obstacle::Fault | Obstacle::FaultCause)
        {
            // C-18: perhaps not the newest one.
            write!(f, ": {fault}, says element 0 of PNU 945")?;
        }
        if let [Some(a), Some(b)] = limits
            && obstacle == Obstacle::TargetBeyondLimits
        {
            write!(f, ": the limits are {} and {}", a.min(b), a.max(b))?;
        }
        if let Some(gear) = gear
            && obstacle == Obstacle::BeyondGear
        {
            write!(f, ": at most {} rpm", gear.max_rpm())?;
        }
        Ok(())
    }
}

struct Text {
    obstacles: Obstacles,
    obstacle: Obstacle,
}

impl fmt::Display for Text {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.obstacles.write(f, self.obstacle)
    }
}

impl fmt::Display for Obstacles {
    /// One line: the goal, the time it was given if that ran out, then every obstacle.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.waited {
            None => write!(f, "{} is not possible", self.goal)?,
            Some(waited) => write!(f, "{} was not done within {waited:?}", self.goal)?,
        }
        for (index, obstacle) in self.iter().enumerate() {
            f.write_str(if index == 0 { ": " } else { "; " })?;
            self.write(f, obstacle)?;
        }
        if self.iter().next().is_none() {
            f.write_str(": the drive shows no reason")?;
        }
        Ok(())
    }
}
