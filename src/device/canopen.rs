//! What a host asks of a device on CANopen, whichever device it is.

use core::any::Any;
use core::fmt;

use thiserror::Error;

use crate::can::{ErrorState, Frame};
use crate::canopen::storage::{self, Generation, NotStored, StoreRequest};
use crate::canopen::{self, Index, NodeId};
use crate::drive;
use crate::time::Instant;
use crate::unit::{self, DipSwitches};

/// What to do about each reason of a refusal, as the end of a sentence.
pub type Cures = &'static [(drive::Reason, &'static str)];

/// What to do about this reason; empty where its own words say it.
pub(super) fn cure(cures: Cures, reason: drive::Reason) -> &'static str {
    cures.iter().find(|(of, _)| *of == reason).map_or("", |(_, cure)| cure)
}

/// News of a device on CANopen. `Display` is one line of plain English.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum CanopenEvent {
    /// Of its node: NMT, SDO, PDO, EMCY, error control.
    Node(canopen::Event),
    /// A command was refused by the drive of the unit.
    CommandRefused {
        /// What was asked, and what stands against it.
        refusal: drive::Refusal,
        /// What to do about each reason, with the bits and objects of the device.
        cures: Cures,
    },
    /// Of the unit behind the node: faults, travels, power.
    Unit(unit::Event),
    /// The unit was switched on, and its switches were read.
    SwitchedOn {
        /// The node number that they say.
        node: NodeId,
        /// The switches.
        switches: DipSwitches,
    },
    /// The state of the device changed.
    State {
        /// The state before, as its manual writes it.
        from: &'static str,
        /// The state now.
        to: &'static str,
    },
    /// A travel job was refused because its target, which came in a PDO, is outside the range.
    TargetRefused {
        /// The object of the target.
        object: Index,
        /// The smallest target.
        low: i32,
        /// The largest target.
        high: i32,
        /// The target.
        got: i32,
    },
    /// Events were lost because nobody took them in time.
    Lost {
        /// How many.
        events: u32,
    },
}

impl CanopenEvent {
    /// Whether a log leaves it out unless asked for more: a master may cause as many as it likes.
    pub const fn is_detail(&self) -> bool {
        match self {
            Self::Node(event) => matches!(event, canopen::Event::Written { .. }),
            Self::Unit(event) => event.is_detail(),
            Self::CommandRefused { .. }
            | Self::SwitchedOn { .. }
            | Self::State { .. }
            | Self::TargetRefused { .. }
            | Self::Lost { .. } => false,
        }
    }
}

impl fmt::Display for CanopenEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Node(event) => event.fmt(f),
            Self::CommandRefused { refusal, cures } => {
                write!(f, "{} refused", refusal.asked())?;
                for (place, reason) in refusal.reasons().enumerate() {
                    let gap = if place == 0 { ": " } else { "; " };
                    write!(f, "{gap}{}{}", refusal.text(reason), cure(cures, reason))?;
                }
                Ok(())
            }
            Self::Unit(event) => event.fmt(f),
            Self::SwitchedOn { node, switches } => {
                write!(f, "switched on at node number {node} (SW1 to SW10: {switches})")
            }
            Self::State { from, to } => write!(f, "drive state {from} -> {to}"),
            Self::TargetRefused { object, low, high, got } => {
                write!(f, "travel refused: target {object} is {got}, expected {low} to {high}")
            }
            Self::Lost { events } => write!(f, "{events} more events were lost"),
        }
    }
}

/// Why an image is not taken over.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum RecallError {
    /// It is no image of a node.
    #[error(transparent)]
    Node(#[from] storage::ImageError),
    /// It is no image of the drive behind the node.
    #[error(transparent)]
    Unit(#[from] unit::ImageError),
}

/// A device on CANopen: frames and time in, frames, events, images and a deadline out.
///
/// After every call but the polls, `poll_transmit`, `poll_event`, `poll_image` and `poll_timeout` may have another answer.
/// A host that knows which device it has reaches the rest of it by `dyn Any`.
pub trait CanopenDevice: Any + Send {
    /// The node number in force: after power-on that of the device's memory.
    fn node_id(&self) -> NodeId;

    /// Supply on.
    fn power_on(&mut self, now: Instant);

    /// Supply off: what was not saved is lost.
    fn power_off(&mut self, now: Instant);

    /// A frame was received.
    fn handle_frame(&mut self, now: Instant, frame: &Frame);

    /// The deadline has come, or any other instant.
    fn handle_timeout(&mut self, now: Instant);

    /// The error counters of its CAN controller have taken it from one state to another.
    fn handle_error_state(&mut self, now: Instant, from: ErrorState, to: ErrorState);

    /// The next frame to send.
    fn poll_transmit(&mut self, now: Instant) -> Option<Frame>;

    /// The next event.
    fn poll_event(&mut self) -> Option<CanopenEvent>;

    /// Says what keeps its drive from moving now, a sentence each, the most important first. Nothing: it moves, waits
    /// for a start, or has no drive.
    fn why(&self, _say: &mut dyn FnMut(&dyn fmt::Display)) {}

    /// When [`handle_timeout`](Self::handle_timeout) is due.
    fn poll_timeout(&self) -> Option<Instant>;

    /// Takes over an image before the first power-on.
    ///
    /// # Errors
    /// [`RecallError`]; nothing is taken over then.
    fn recall(&mut self, now: Instant, image: &[u8]) -> Result<(), RecallError>;

    /// The image to keep ([`Node::poll_image`](crate::canopen::Node::poll_image)).
    ///
    /// # Errors
    /// [`storage::ImageError::NoRoom`]; it stays on offer.
    fn poll_image<'a>(&mut self, into: &'a mut [u8])
    -> Result<Option<StoreRequest<'a>>, storage::ImageError>;

    /// What became of an image ([`Node::handle_stored`](crate::canopen::Node::handle_stored)).
    fn handle_stored(&mut self, now: Instant, generation: Generation, outcome: Result<(), NotStored>);
}
