//! The servo ASDA-A2 as a node of CANopen: frames and time in, frames, events and a deadline out.
//!
//! ```text
//!  frame ──▶ Node ──▶ Application ──▶ links: object ──▶ Setting ─┐
//!                                  └─▶ controlword ──────────────┴──▶ Servo
//!  frame ◀── Node ◀── Emergency, NMT ◀────────────────────────── Alarm ◀──┘
//! ```
//!
//! | file | holds |
//! | --- | --- |
//! | `objects` | the object dictionary of both levels |
//! | `links` | which setting of the drive an object is |
//! | `application` | reads, writes, what the bus does to the drive |
//! | `front` | the keys, behind which are the parameters |
//! | `hosted` | what a host asks of any device on CANopen |
//! | `story` | what `profidrive demo` plays |
//! | `surroundings` | what surrounds it and what is seen of it |
//! | `why` | what keeps it from moving |
//! | [`quirks`] | each doubt of the guide with its default |

mod application;
mod description;
mod front;
mod hosted;
mod links;
mod objects;
pub mod quirks;
mod story;
mod surroundings;
mod vocabulary;
mod why;

use core::time::Duration;

pub use crate::devices::asda_a2::{Config, Level};
pub use objects::SHEET;
pub use quirks::{QUIRKS, Quirks};
pub(crate) use story::STORY;
pub use vocabulary::VOCABULARY;

use crate::can_bus::can::{Frame, Id};
use crate::can_bus::canopen::node::storage::Eeprom;
use crate::can_bus::canopen::{Node, Object, cob_id};
use crate::can_bus::cia402::Statusword;
use crate::devices::asda_a2::keypad::Keypad;
use crate::devices::asda_a2::{Alarm, Inputs, Servo};
use crate::time::Instant;
use application::Drive;

/// Two frames of one service nearer than this are an overrun (AL111, AL112).
const OVERRUN: Duration = Duration::from_millis(1);

/// COB-IDs of RPDOs watched for AL112.
const MAX_WATCHED: usize = 8;

/// The drive on its bus.
///
/// A [`CanopenDevice`](crate::devices::CanopenDevice). Never panics, whatever frames it is given.
#[derive(Clone, Debug)]
pub struct AsdaA2 {
    node: Node,
    drive: Drive,
    keypad: Keypad,
    quirks: Quirks,
    /// When the identifiers were seen last.
    seen: heapless::Vec<(Id, Instant), MAX_WATCHED>,
}

impl AsdaA2 {
    /// A drive that is switched off.
    pub fn new(config: Config, quirks: Quirks, now: Instant) -> Self {
        let coasts = config.bus_error_coasts || quirks.bus_error_coasts;
        let config = Config { bus_error_coasts: coasts, ..config };
        Self {
            node: Node::new(quirks.policy()),
            drive: Drive::new(config, !quirks.other_parameters_absent, now),
            keypad: Keypad::default(),
            quirks,
            seen: heapless::Vec::new(),
        }
    }

    /// With what is stored kept there.
    #[must_use]
    pub(crate) fn with_memory(mut self, memory: Eeprom) -> Self {
        self.node = self.node.with_memory(memory);
        self
    }

    /// The object dictionary of a level.
    pub const fn objects(level: Level) -> &'static [Object] {
        objects::of(level, true)
    }

    /// The drive, to look at.
    pub const fn servo(&self) -> &Servo {
        &self.drive.servo
    }

    /// 6041h.
    pub fn statusword(&self) -> Statusword {
        self.drive.statusword()
    }

    /// What surrounds the drive.
    pub const fn inputs(&self) -> &Inputs {
        self.drive.servo.inputs()
    }

    /// Changes what surrounds the drive.
    pub fn set_inputs(&mut self, now: Instant, inputs: Inputs) {
        self.drive.servo.advance(now);
        self.drive.servo.set_inputs(inputs);
        self.node.handle_change(now, &mut self.drive);
    }

    /// Makes an alarm happen, whatever its cause is.
    pub fn provoke(&mut self, now: Instant, alarm: Alarm) {
        self.drive.servo.advance(now);
        self.drive.servo.raise(alarm);
        self.node.handle_change(now, &mut self.drive);
    }

    /// Takes an alarm back that was provoked; the drive stays off until the master resets it.
    pub(crate) fn take_back_alarm(&mut self, now: Instant, alarm: Alarm) {
        self.drive.servo.advance(now);
        self.drive.servo.take_back(alarm);
        self.node.handle_change(now, &mut self.drive);
    }

    /// AL111: two SDO requests within 1 ms; AL112: two RPDOs with one COB-ID within 1 ms.
    fn watch_overrun(&mut self, now: Instant, frame: &Frame) {
        let id = frame.id();
        let alarm = if id == cob_id::of_node(cob_id::SDO_CLIENT, self.node.node_id()) {
            Alarm::SdoOverrun
        } else if !frame.is_remote() && self.node.takes_rpdo(id) {
            Alarm::PdoOverrun
        } else {
            return;
        };
        if let Some(place) = self.seen.iter_mut().find(|(seen, _)| *seen == id) {
            let before = core::mem::replace(&mut place.1, now);
            if now.saturating_since(before) < OVERRUN {
                self.drive.servo.raise(alarm);
            }
        } else {
            let _ = self.seen.push((id, now));
        }
    }
}
