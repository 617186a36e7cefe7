//! News for the host.

use core::fmt;

use super::objects::{MAX_TARGET, TARGET};
use super::state::State;
use super::why::CURES;
use crate::canopen;
use crate::device::CanopenEvent;
use crate::unit;

/// Something a user may want to read. `Display` is one line of plain English.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Event {
    /// The node: NMT, SDO, PDO, EMCY, error control.
    Node(canopen::Event),
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
    /// Events were lost because nobody took them in time.
    Lost {
        /// How many.
        events: u32,
    },
}

impl From<Event> for CanopenEvent {
    fn from(event: Event) -> Self {
        match event {
            Event::Node(event) => Self::Node(event),
            Event::Unit(unit::Event::SwitchedOn(switches)) => {
                Self::SwitchedOn { node: switches.node_id(), switches }
            }
            Event::Unit(unit::Event::CommandRefused(refusal)) => {
                Self::CommandRefused { refusal, cures: CURES }
            }
            Event::Unit(event) => Self::Unit(event),
            Event::State { from, to } => Self::State { from: from.name(), to: to.name() },
            Event::TargetRefused { got } => {
                Self::TargetRefused { object: TARGET, low: -MAX_TARGET, high: MAX_TARGET, got }
            }
            Event::Lost { events } => Self::Lost { events },
        }
    }
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        CanopenEvent::from(*self).fmt(f)
    }
}
