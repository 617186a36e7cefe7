//! What the drive feels of its surroundings: load, switches, supply.

use super::plant::INCREMENTS_PER_REVOLUTION;
use crate::face::surroundings::{Input, InputKind, Level};

/// The largest torque of a load, Nm.
const MOST_TORQUE: f64 = 1000.0;

const BLOCKED: Input = Input { name: "blocked", about: "the shaft cannot turn", kind: InputKind::Switch };
const LOAD: Input = Input {
    name: "load_torque_newton_metres",
    about: "load against forward motion",
    kind: InputKind::Number { low: -MOST_TORQUE, high: MOST_TORQUE, own: false },
};
const FRICTION: Input = Input {
    name: "friction_torque_newton_metres",
    about: "friction in both directions",
    kind: InputKind::Number { low: 0.0, high: MOST_TORQUE, own: false },
};
const MAIN_CIRCUIT: Input =
    Input { name: "main_circuit", about: "the main circuit is supplied", kind: InputKind::Switch };
const EMERGENCY_STOP: Input = Input {
    name: "emergency_stop_released",
    about: "the emergency stop is released",
    kind: InputKind::Switch,
};
const NEGATIVE_LIMIT: Input = Input {
    name: "negative_limit_switch",
    about: "the negative limit switch is pressed, wherever the shaft is",
    kind: InputKind::Switch,
};
const POSITIVE_LIMIT: Input = Input {
    name: "positive_limit_switch",
    about: "the positive limit switch is pressed, wherever the shaft is",
    kind: InputKind::Switch,
};
const HOME: Input = Input {
    name: "home_switch",
    about: "the home switch is pressed, wherever the shaft is",
    kind: InputKind::Switch,
};

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
    /// Tells each as an input of a device.
    pub(crate) fn each_level(&self, tell: &mut dyn FnMut(&Input, Level)) {
        let Self {
            blocked,
            load_torque,
            friction_torque,
            main_circuit,
            emergency_stop_released,
            pressed,
            switches: _,
        } = *self;
        tell(&BLOCKED, Level::Switch(blocked));
        tell(&LOAD, Level::Number(load_torque));
        tell(&FRICTION, Level::Number(friction_torque));
        tell(&MAIN_CIRCUIT, Level::Switch(main_circuit));
        tell(&EMERGENCY_STOP, Level::Switch(emergency_stop_released));
        tell(&NEGATIVE_LIMIT, Level::Switch(pressed.negative_limit));
        tell(&POSITIVE_LIMIT, Level::Switch(pressed.positive_limit));
        tell(&HOME, Level::Switch(pressed.home));
    }

    /// The level of that input.
    pub(crate) fn level(&self, name: &str) -> Option<Level> {
        let mut found = None;
        self.each_level(&mut |input, level| {
            if input.name == name {
                found = Some(level);
            }
        });
        found
    }

    /// Changes the input of that name; says whether there is one that takes such a level.
    pub(crate) fn change(&mut self, name: &str, level: Level) -> bool {
        match level {
            Level::Switch(on) if name == BLOCKED.name => self.blocked = on,
            Level::Switch(on) if name == MAIN_CIRCUIT.name => self.main_circuit = on,
            Level::Switch(on) if name == EMERGENCY_STOP.name => self.emergency_stop_released = on,
            Level::Switch(on) if name == NEGATIVE_LIMIT.name => self.pressed.negative_limit = on,
            Level::Switch(on) if name == POSITIVE_LIMIT.name => self.pressed.positive_limit = on,
            Level::Switch(on) if name == HOME.name => self.pressed.home = on,
            Level::Number(torque) if name == LOAD.name => {
                self.load_torque = torque.clamp(-MOST_TORQUE, MOST_TORQUE);
            }
            Level::Number(torque) if name == FRICTION.name => {
                self.friction_torque = torque.clamp(0.0, MOST_TORQUE);
            }
            Level::Switch(_) | Level::Number(_) | Level::Own => return false,
        }
        true
    }

    /// What the switches say with the shaft at `position`; those of a homing are on `homing_axis`.
    pub(crate) fn closed(&self, position: f64, homing_axis: Option<Axis>) -> Closed {
        let by_position = match (self.switches, homing_axis) {
            (Switches::Fixed(axis), _) | (Switches::WhileHoming, Some(axis)) => axis.closed(position),
            (Switches::WhileHoming, None) => Closed::default(),
        };
        by_position.or(self.pressed)
    }

    /// With no load in the place of torques that are no number.
    pub(crate) fn finite(self) -> Self {
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
    pub(crate) fn around(position: f64, home: HomeSwitch) -> Self {
        let at = |revolutions: f64| position + revolutions * INCREMENTS_PER_REVOLUTION;
        let home = match home {
            HomeSwitch::Cam => (at(0.1), at(0.2)),
            HomeSwitch::PositiveSide => (at(0.1), f64::INFINITY),
            HomeSwitch::NegativeSide => (f64::NEG_INFINITY, at(-0.1)),
        };
        Self { negative_limit: at(-1.05), positive_limit: at(1.05), home }
    }

    /// What the switches say at `position`.
    pub(crate) fn closed(&self, position: f64) -> Closed {
        Closed {
            negative_limit: position <= self.negative_limit,
            positive_limit: position >= self.positive_limit,
            home: position >= self.home.0 && position <= self.home.1,
        }
    }
}

/// What of the axis closes the home switch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum HomeSwitch {
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
