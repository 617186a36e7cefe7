//! Statusword, actual values and the text of the panel.

use core::fmt;

use super::Servo;
use super::homing::HomingState;
use super::interpolation::Interpolation;
use super::motion::Motion;
use super::plant::{Motor, rpm};
use super::settings::Setting;
use crate::can_bus::cia402::{Controlword, Mode, State, Statusword};

impl Servo {
    /// The statusword without bit 9, which is the bus's.
    pub(crate) fn statusword(&self) -> Statusword {
        let mut word = self.state.bits();
        word |= Statusword::VOLTAGE_ENABLED.when(self.inputs.main_circuit);
        word |= Statusword::WARNING.when(self.has_warning());
        word |= Statusword::TARGET_REACHED.when(self.target_reached());
        word |= Statusword::FOLLOWING_ERROR
            .when(self.following_error && self.mode == Some(Mode::ProfilePosition));
        if self.state != State::OperationEnabled {
            return word;
        }
        word | match self.motion {
            Motion::Hold | Motion::Torque => Statusword::NONE,
            Motion::Position(points) => Statusword::SET_POINT_ACKNOWLEDGE.when(points.acknowledges()),
            Motion::Velocity => {
                let zero = i64::from(self.velocity_actual()).abs() < self.settings.of(Setting::ZeroSpeed);
                Statusword::ZERO_SPEED.when(zero)
            }
            Motion::Homing(HomingState::Attained) => Statusword::HOMING_ATTAINED.when(self.is_on_demand()),
            Motion::Homing(HomingState::Failed) => Statusword::HOMING_ERROR,
            Motion::Homing(HomingState::Ready | HomingState::Running(_)) => Statusword::NONE,
            Motion::Interpolation(Interpolation::Waiting) => Statusword::NONE,
            Motion::Interpolation(Interpolation::Running(_)) => {
                Statusword::IP_ACTIVE | SYNC_OK.when(self.sync_in_time())
            }
        }
    }

    fn sync_in_time(&self) -> bool {
        match &self.motion {
            Motion::Interpolation(interpolation) => {
                interpolation.expected_at().is_some_and(|due| self.pace.now() <= due)
            }
            Motion::Hold | Motion::Position(_) | Motion::Velocity | Motion::Torque | Motion::Homing(_) => {
                false
            }
        }
    }

    fn target_reached(&self) -> bool {
        match self.state {
            State::OperationEnabled => {}
            State::QuickStopActive => return self.demand.velocity == 0.0,
            State::NotReadyToSwitchOn
            | State::SwitchOnDisabled
            | State::ReadyToSwitchOn
            | State::SwitchedOn
            | State::FaultReactionActive
            | State::Fault => return false,
        }
        if self.control.has(Controlword::HALT) && !matches!(self.motion, Motion::Interpolation(_)) {
            return self.demand.velocity == 0.0;
        }
        match self.motion {
            Motion::Hold | Motion::Interpolation(Interpolation::Waiting) => false,
            Motion::Position(points) => points.is_done() && self.window_is_full(),
            Motion::Velocity | Motion::Interpolation(Interpolation::Running(_)) => self.window_is_full(),
            Motion::Torque => self.torque_demand * 1000.0 == self.settings.of(Setting::TargetTorque) as f64,
            Motion::Homing(HomingState::Attained) => self.demand.velocity == 0.0 && self.is_on_demand(),
            Motion::Homing(HomingState::Failed) => self.demand.velocity == 0.0,
            Motion::Homing(HomingState::Ready | HomingState::Running(_)) => false,
        }
    }

    /// Whether position or velocity are in their window now.
    fn in_window_now(&self) -> bool {
        match self.motion {
            Motion::Velocity => {
                let target = self.settings.of(Setting::TargetVelocity);
                (target - i64::from(self.velocity_actual())).abs()
                    <= self.settings.of(Setting::VelocityWindow)
            }
            Motion::Position(points) => {
                let left = (points.target() - self.plant.position) / self.gear();
                left.abs() <= self.settings.of(Setting::PositionWindow) as f64
            }
            Motion::Interpolation(_) => self.is_on_demand(),
            Motion::Hold | Motion::Torque | Motion::Homing(_) => false,
        }
    }

    /// Whether the shaft is where it shall be now.
    fn is_on_demand(&self) -> bool {
        i64::from(self.following_error_puu()).abs() <= self.settings.of(Setting::PositionWindow)
    }

    fn window_time(&self) -> u32 {
        let setting = match self.motion {
            Motion::Velocity => Setting::VelocityWindowTime,
            Motion::Position(_)
            | Motion::Interpolation(_)
            | Motion::Hold
            | Motion::Torque
            | Motion::Homing(_) => Setting::PositionWindowTime,
        };
        u32::try_from(self.settings.of(setting)).unwrap_or(u32::MAX)
    }

    fn window_is_full(&self) -> bool {
        self.in_window_now() && self.in_window >= self.window_time()
    }

    pub(super) fn window_is_settled(&self) -> bool {
        !self.is_on() || !self.in_window_now() || self.window_is_full()
    }

    pub(super) fn count_window(&mut self) {
        self.in_window = if self.in_window_now() { self.in_window.saturating_add(1) } else { 0 };
    }

    /// PUU of a position in increments, counted from home.
    pub(crate) fn puu(&self, increments: f64) -> i32 {
        whole((increments - self.origin) / self.gear())
    }

    /// 603Fh.
    pub(crate) const fn error_code(&self) -> u16 {
        self.error_code
    }

    /// 6061h.
    pub(crate) const fn mode(&self) -> Option<Mode> {
        self.mode
    }

    /// 6062h in PUU.
    pub(crate) fn position_demand(&self) -> i32 {
        self.puu(self.demand.position)
    }

    /// 60FCh in increments.
    pub(crate) fn position_demand_increments(&self) -> i32 {
        whole(self.demand.position - self.origin)
    }

    /// 6063h in increments.
    pub(crate) fn position_actual_increments(&self) -> i32 {
        whole(self.plant.position - self.origin)
    }

    /// 6064h in PUU.
    pub(crate) fn position_actual(&self) -> i32 {
        self.puu(self.plant.position)
    }

    /// 60F4h in PUU.
    pub(crate) fn following_error_puu(&self) -> i32 {
        whole((self.demand.position - self.plant.position) / self.gear())
    }

    /// 606Bh in 0.1 rpm.
    pub(crate) fn velocity_demand(&self) -> i32 {
        whole(self.demand.velocity / rpm(0.1))
    }

    /// 606Ch in 0.1 rpm.
    pub(crate) fn velocity_actual(&self) -> i32 {
        whole(self.plant.velocity / rpm(0.1))
    }

    /// 6074h in 0.1 % of the rated torque.
    pub(crate) fn torque_demand(&self) -> i16 {
        let torque = if self.motion == Motion::Torque { self.torque_demand } else { self.plant.torque };
        narrow(torque * 1000.0)
    }

    /// 6077h in 0.1 % of the rated torque, and 6078h in 0.1 % of the rated current.
    pub(crate) fn torque_actual(&self) -> i16 {
        narrow(self.plant.torque * 1000.0)
    }

    /// 6075h in mA.
    pub(crate) const fn rated_current(&self) -> u32 {
        Motor::RATED_CURRENT
    }

    /// 6076h in mNm.
    pub(crate) const fn rated_torque(&self) -> u32 {
        Motor::RATED_TORQUE
    }

    /// 60FDh.
    pub(crate) fn digital_inputs(&self) -> u32 {
        self.switches_closed().word()
    }

    /// What the panel shows: the newest alarm, else the position in PUU.
    pub fn panel(&self) -> Panel {
        match self.alarms.last() {
            Some(alarm) => Panel::Alarm(*alarm),
            None => Panel::Number(self.position_actual()),
        }
    }
}

/// Bit 14 in interpolated position mode: SYNCs come in time.
const SYNC_OK: Statusword = Statusword(1 << 14);

/// The five digits of the panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Panel {
    /// An alarm.
    Alarm(super::Alarm),
    /// A number, of which the panel has the low five digits. It shows the sign of one with five digits by its points.
    Number(i32),
}

impl fmt::Display for Panel {
    /// Always five characters; the points of a number below zero are not among them.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Alarm(alarm) => alarm.fmt(f),
            Self::Number(number @ -9999..=-1) => write!(f, "{number:5}"),
            Self::Number(number) if number.unsigned_abs() > 99_999 => {
                write!(f, "{:05}", number.unsigned_abs() % 100_000)
            }
            Self::Number(number) => write!(f, "{:5}", number.unsigned_abs()),
        }
    }
}

/// The nearest whole number; positions run round as the 32-bit counters of the drive do.
#[expect(clippy::cast_possible_truncation, reason = "wraps as the counter does")]
fn whole(value: f64) -> i32 {
    libm::round(value) as i64 as i32
}

#[expect(clippy::cast_possible_truncation, reason = "saturates")]
fn narrow(value: f64) -> i16 {
    libm::round(value) as i16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_panel_has_five_digits() {
        for (number, text) in [
            (0, "    0"),
            (-1, "   -1"),
            (-9999, "-9999"),
            (-10_000, "10000"),
            (99_999, "99999"),
            (1_234_567, "34567"),
            (-1_200_007, "00007"),
            (i32::MIN, "83648"),
        ] {
            assert_eq!(Panel::Number(number).to_string(), text);
        }
    }
}
