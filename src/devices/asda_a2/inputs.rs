//! What the drive feels of its surroundings: load, switches, supply.

use super::plant::INCREMENTS_PER_REVOLUTION;

/// The surroundings of the drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inputs {
    /// The shaft cannot turn.
    pub blocked: bool,
    /// Torque that the load has against forward motion, Nm; below zero it pulls forward.
    pub load_torque: f64,
    /// Torque of friction, Nm.
    pub friction_torque: f64,
    /// The main circuit is supplied.
    pub main_circuit: bool,
    /// The emergency stop is released.
    pub emergency_stop_released: bool,
    /// Where the switches of the axis are.
    pub switches: Switches,
    /// Switches that are closed wherever the shaft is.
    pub pressed: Closed,
}

impl Inputs {
    /// A motor without an axis.
    pub const NOMINAL: Self = Self {
        blocked: false,
        load_torque: 0.0,
        friction_torque: 0.01,
        main_circuit: true,
        emergency_stop_released: true,
        switches: Switches::WhileHoming,
        pressed: Closed { negative_limit: false, positive_limit: false, home: false },
    };
}

impl Inputs {
    /// With no load in the place of torques that are no number.
    pub(super) fn finite(self) -> Self {
        let finite = |torque: f64| if torque.is_finite() { torque.clamp(-1e6, 1e6) } else { 0.0 };
        Self { load_torque: finite(self.load_torque), friction_torque: finite(self.friction_torque), ..self }
    }
}

impl Default for Inputs {
    fn default() -> Self {
        Self::NOMINAL
    }
}

/// Where limit and home switches are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Switches {
    /// A motor without an axis can turn without end. For each homing there are switches near where it
    /// begins, and none otherwise: limit switches 1.05 revolutions away on both sides, a home switch from 0.1 to 0.2
    /// revolutions ahead (with the methods 3 to 6 and 19 to 22 on one whole side of a position 0.1 revolutions away).
    WhileHoming,
    /// An axis with switches; outside homing its limits cause AL014 and AL015.
    Fixed(Axis),
}

/// An axis with switches. Positions in increments of the shaft since the drive was made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    /// The negative limit switch is closed here and below.
    pub negative_limit: f64,
    /// The positive limit switch is closed here and above.
    pub positive_limit: f64,
    /// The home switch is closed between these, both included.
    pub home: (f64, f64),
}

/// What the switches say.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Closed {
    /// Bit 0 of 60FDh.
    pub negative_limit: bool,
    /// Bit 1 of 60FDh.
    pub positive_limit: bool,
    /// Bit 2 of 60FDh.
    pub home: bool,
}

impl Axis {
    /// An axis for a homing from `position`, as [`Switches::WhileHoming`] says.
    pub(super) fn around(position: f64, home: HomeSwitch) -> Self {
        let at = |revolutions: f64| position + revolutions * INCREMENTS_PER_REVOLUTION;
        let home = match home {
            HomeSwitch::Cam => (at(0.1), at(0.2)),
            HomeSwitch::PositiveSide => (at(0.1), f64::INFINITY),
            HomeSwitch::NegativeSide => (f64::NEG_INFINITY, at(-0.1)),
        };
        Self { negative_limit: at(-1.05), positive_limit: at(1.05), home }
    }

    /// What the switches say at `position`.
    pub(super) fn closed(&self, position: f64) -> Closed {
        Closed {
            negative_limit: position <= self.negative_limit,
            positive_limit: position >= self.positive_limit,
            home: position >= self.home.0 && position <= self.home.1,
        }
    }
}

/// What of the axis closes the home switch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum HomeSwitch {
    /// Some way in between.
    Cam,
    /// Everything above a position.
    PositiveSide,
    /// Everything below a position.
    NegativeSide,
}

impl Closed {
    /// What is closed here or there.
    #[must_use]
    pub(crate) const fn or(self, other: Self) -> Self {
        Self {
            negative_limit: self.negative_limit || other.negative_limit,
            positive_limit: self.positive_limit || other.positive_limit,
            home: self.home || other.home,
        }
    }

    /// 60FDh (CiA 402).
    pub(crate) const fn word(self) -> u32 {
        self.negative_limit as u32 | (self.positive_limit as u32) << 1 | (self.home as u32) << 2
    }
}
