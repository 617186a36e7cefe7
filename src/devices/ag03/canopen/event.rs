//! News of a drive, with the bits and objects of CANopen.

use core::convert::Infallible;
use core::fmt;

use super::objects::MAX_TARGET;
use super::state::State;
use super::why::Refused;
use crate::can_bus::cia402::Controlword;
use crate::devices::ag03::unit;
use crate::devices::servo::news::News;
use crate::face::{DeviceEvent, EventKind};

/// What has happened in a drive on CANopen. `Display` is one line of plain English.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Event {
    /// The unit: refused commands, faults, power.
    Unit(unit::Event),
    /// The state of the drive changed.
    State {
        /// The state before.
        from: State,
        /// The state now.
        to: State,
    },
    /// A travel job was refused because 607Ah, which came in a PDO, is outside its range (CN-35).
    TargetRefused {
        /// The target.
        got: i32,
    },
    /// The control word asks for a state that it does not lead to from here.
    NoEffect {
        /// 6040h.
        word: u16,
        /// The state that stays.
        state: State,
    },
    /// Another target came while bit 4 of the control word stayed 1.
    TargetNotTaken {
        /// 6040h.
        word: u16,
        /// 607Ah.
        target: i32,
    },
    /// Events were lost because nobody took them in time.
    Lost {
        /// How many.
        events: u32,
    },
}

impl DeviceEvent for Event {
    fn kind(&self) -> EventKind {
        match self {
            Self::Unit(event) => event.kind(),
            Self::State { .. } => EventKind::Drive,
            Self::TargetRefused { .. } | Self::NoEffect { .. } => EventKind::CommandRefused,
            Self::TargetNotTaken { .. } => EventKind::Hint,
            Self::Lost { .. } => EventKind::Line,
        }
    }

    fn is_detail(&self) -> bool {
        if let Self::Unit(event) = self { event.is_detail() } else { false }
    }
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unit(unit::Event::SwitchedOn(switches)) => {
                let node = switches.node_id();
                write!(f, "switched on at node number {node} (SW1 to SW10: {switches})")
            }
            Self::Unit(unit::Event::CommandRefused(refusal)) => Refused(refusal).fmt(f),
            Self::Unit(event) => event.fmt(f),
            Self::State { from, to } => write!(f, "drive state {from} -> {to}"),
            Self::TargetRefused { got } => {
                write!(f, "travel refused: target 607Ah is {got}, expected -{MAX_TARGET} to {MAX_TARGET}")
            }
            Self::NoEffect { word, state } => {
                let word = Controlword(*word);
                News::<Infallible>::NoEffect { word, state: state.of_profile(), supplied: true }.fmt(f)
            }
            Self::TargetNotTaken { word, target } => {
                let (word, target) = (Controlword(*word), i64::from(*target));
                News::<Infallible>::NotTaken { word, target }.fmt(f)
            }
            Self::Lost { events } => write!(f, "{events} more events were lost"),
        }
    }
}
