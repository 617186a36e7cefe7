//! What takes part in a bus.

use core::any::Any;

use crate::can_bus::can::{ErrorState, Frame};
use crate::time::Instant;

/// A station on a [`Bus`](super::Bus): frames and time in, frames, news and a deadline out.
///
/// The contract is that of every machine here: **after each call but the polls, `poll_transmit`, `poll_event` and
/// `poll_timeout` may have another answer**, and the bus asks. It holds one frame of each station that waits for the bus,
/// and asks for the next when that one was sent: a station sends its frames in its own order.
pub trait CanParticipant: Any + Send {
    /// News for whoever runs the bus.
    type Event;

    /// Takes a frame of another station that ended at `now`. Its own frames a station never hears.
    fn handle_frame(&mut self, now: Instant, frame: &Frame);

    /// Time has passed. Spurious calls are harmless.
    fn handle_timeout(&mut self, now: Instant);

    /// Its error counters have taken it to another state. While it is bus off it hears nothing and is not asked for
    /// frames, and the frame that waited is given back before.
    fn set_error_state(&mut self, now: Instant, state: ErrorState);

    /// A frame that [`poll_transmit`](Self::poll_transmit) has given and that was not sent, as the station went bus off.
    fn take_back(&mut self, _frame: Frame) {}

    /// Its bit rate in bit/s; `None`: that of the bus, whichever it is. At another rate than the bus it hears nothing, and
    /// what it sends nobody hears.
    fn bits_per_second(&self) -> Option<u32> {
        None
    }

    /// The frame to send, if there is one at `now`.
    fn poll_transmit(&mut self, now: Instant) -> Option<Frame>;

    /// The oldest news not taken yet.
    fn poll_event(&mut self) -> Option<Self::Event>;

    /// When to call `handle_timeout` and `poll_transmit` again; `None` = a frame comes first.
    fn poll_timeout(&self) -> Option<Instant>;
}
