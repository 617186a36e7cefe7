//! What a host asks of a device on CANopen, whichever device it is.

use core::any::Any;

use crate::can::{ErrorState, Frame};
use crate::canopen::storage::{Generation, ImageError, NotStored, StoreRequest};
use crate::canopen::{Event, NodeId};
use crate::time::Instant;

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
    fn poll_transmit(&mut self) -> Option<Frame>;

    /// The next event.
    fn poll_event(&mut self) -> Option<Event>;

    /// When [`handle_timeout`](Self::handle_timeout) is due.
    fn poll_timeout(&self) -> Option<Instant>;

    /// Takes over an image before the first power-on.
    ///
    /// # Errors
    /// [`ImageError`]; nothing is taken over then.
    fn recall(&mut self, now: Instant, image: &[u8]) -> Result<(), ImageError>;

    /// The image to keep ([`Node::poll_image`](crate::canopen::Node::poll_image)).
    ///
    /// # Errors
    /// [`ImageError::NoRoom`]; it stays on offer.
    fn poll_image<'a>(&mut self, into: &'a mut [u8]) -> Result<Option<StoreRequest<'a>>, ImageError>;

    /// What became of an image ([`Node::handle_stored`](crate::canopen::Node::handle_stored)).
    fn handle_stored(&mut self, now: Instant, generation: Generation, outcome: Result<(), NotStored>);
}
