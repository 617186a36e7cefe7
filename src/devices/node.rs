//! What a host asks of a device on CANopen, whichever device it is.

use core::fmt;

use thiserror::Error;

use crate::can_bus::can::{ErrorState, Frame};
use crate::can_bus::canopen;
use crate::can_bus::canopen::node::storage;
use crate::can_bus::canopen::node::storage::{Generation, NotStored, StoreRequest};
use crate::can_bus::canopen::{Address, Application, NoEffect, Node, NodeId, Refusal};
use crate::devices::ag03::unit;
use crate::face::description::Supply;
use crate::face::{Again, AnyDeviceEvent, Description, DeviceEvent, EventKind};
use crate::time::Instant;

/// News of a device on CANopen. `Display` is one line of plain English.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum CanopenEvent {
    /// Of its node: NMT, SDO, PDO, EMCY, error control.
    Node(canopen::Event),
    /// Of its node, again and again.
    Repeated {
        /// What.
        event: canopen::Event,
        /// How often.
        again: Again,
    },
    /// Of the device behind the node, which names its own objects and bits in what it refuses.
    Device(AnyDeviceEvent),
    /// Of the device, again and again.
    DeviceRepeated {
        /// What.
        event: AnyDeviceEvent,
        /// How often.
        again: Again,
    },
}

impl CanopenEvent {
    /// What it is about, for filters.
    pub fn kind(&self) -> EventKind {
        match self {
            Self::Node(event) | Self::Repeated { event, .. } => of_node(event),
            Self::Device(event) | Self::DeviceRepeated { event, .. } => event.kind(),
        }
    }

    /// Whether a log leaves it out unless asked for more: a master may cause as many as it likes.
    pub(crate) fn is_detail(&self) -> bool {
        match self {
            Self::Node(event) => matches!(event, canopen::Event::Written(_)),
            Self::Device(event) => event.is_detail(),
            Self::Repeated { .. } | Self::DeviceRepeated { .. } => false,
        }
    }
}

const fn of_node(event: &canopen::Event) -> EventKind {
    match event {
        canopen::Event::BootUp { .. }
        | canopen::Event::State { .. }
        | canopen::Event::NmtIgnored { .. }
        | canopen::Event::LssRefused(_)
        | canopen::Event::NoEffect(NoEffect::NmtLength { .. }) => EventKind::Nmt,
        canopen::Event::SdoRefused(_)
        | canopen::Event::NoEffect(NoEffect::SdoStopped | NoEffect::SdoLength { .. })
        | canopen::Event::SdoAbortedByClient { .. }
        | canopen::Event::SegmentsMissed { .. }
        | canopen::Event::Written(_) => EventKind::Sdo,
        canopen::Event::RpdoLength { .. }
        | canopen::Event::RpdoRefused { .. }
        | canopen::Event::NoEffect(
            NoEffect::RpdoState { .. }
            | NoEffect::RpdoEmpty { .. }
            | NoEffect::RpdoLate { .. }
            | NoEffect::RpdoOff { .. }
            | NoEffect::TpdoRequest { .. }
            | NoEffect::TpdoOff { .. }
            | NoEffect::RpdoLong { .. }
            | NoEffect::RpdoWithoutNode { .. }
            | NoEffect::SdoOverwritten { .. }
            | NoEffect::SameIdentifier { .. }
            | NoEffect::SyncMissing { .. },
        ) => EventKind::Pdo,
        canopen::Event::Emergency { .. } => EventKind::Emcy,
        canopen::Event::LifeGuardingExpired { .. }
        | canopen::Event::NoEffect(NoEffect::Guarding { .. })
        | canopen::Event::LifeGuardingBack
        | canopen::Event::HeartbeatLost { .. }
        | canopen::Event::HeartbeatBack(_) => EventKind::ErrorControl,
        canopen::Event::FramesLost { .. } => EventKind::Line,
    }
}

impl fmt::Display for CanopenEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Node(event) => event.fmt(f),
            Self::Repeated { event, again } => write!(f, "{again}: {event}"),
            Self::Device(event) => event.fmt(f),
            Self::DeviceRepeated { event, again } => write!(f, "{again}: {event}"),
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
pub trait CanopenDevice: Send {
    /// What it tells of itself, and what surrounds it.
    fn description(&self) -> &dyn Description;

    /// Does something to that. Counts as a `handle_*` call.
    fn act(&mut self, now: Instant, act: &mut dyn FnMut(&mut dyn Description));

    /// Its node on the bus, to look at.
    fn node(&self) -> &Node;

    /// Its objects as the node asks for them, for [`Node::read_with`].
    fn application(&self) -> &dyn Application;

    /// Both, as the functions of [`Node`] want them.
    fn parts(&mut self) -> (&mut Node, &mut dyn Application);

    /// Writes an entry as a client does, but without the bus: no client waits for it, and what it stores is stored later
    /// ([`Node::write_without_bus`]).
    ///
    /// # Errors
    /// What a client would be told; nothing is changed then.
    fn write_without_bus(&mut self, now: Instant, at: Address, octets: &[u8]) -> Result<(), Refusal> {
        let (node, application) = self.parts();
        node.write_without_bus(now, at, octets, application)
    }

    /// The node number in force: after power-on that of the device's memory.
    fn node_id(&self) -> NodeId {
        self.node().node_id()
    }

    /// Whether it is supplied.
    fn is_on(&self) -> bool {
        self.node().state().is_some()
    }

    /// Its supply, and whether it does nothing but a factory reset.
    fn supply(&self) -> Supply {
        if self.is_on() { Supply::On } else { Supply::Off }
    }

    /// The node number that it will have when it is switched on, if it has switches for that; else that in force.
    fn number_at_start(&self) -> NodeId {
        self.node_id()
    }

    /// The bit rates that it can have, in bit/s; none: those of its data sheet.
    fn rates(&self) -> &'static [u32] {
        &[]
    }

    /// The bit rate in force since its last start, in bit/s; `None`: that of its bus, whichever it is.
    fn bits_per_second(&self) -> Option<u32> {
        None
    }

    /// Gives it one of [`rates`](Self::rates), as if it had been stored before the last start.
    fn set_rate(&mut self, _bits_per_second: u32) {}

    /// Supply on.
    fn power_on(&mut self, now: Instant);

    /// Supply off: what was not saved is lost.
    fn power_off(&mut self, now: Instant);

    /// A frame was received.
    fn handle_frame(&mut self, now: Instant, frame: &Frame);

    /// The deadline has come, or any other instant.
    fn handle_timeout(&mut self, now: Instant);

    /// The error counters of its CAN controller have taken it from one state to another.
    fn handle_error_state(&mut self, _now: Instant, _from: ErrorState, _to: ErrorState) {}

    /// The next frame to send.
    fn poll_transmit(&mut self, _now: Instant) -> Option<Frame> {
        self.parts().0.poll_transmit()
    }

    /// The next event.
    fn poll_event(&mut self) -> Option<CanopenEvent> {
        self.parts().0.poll_event().map(CanopenEvent::Node)
    }

    /// When [`handle_timeout`](Self::handle_timeout) is due.
    fn poll_timeout(&self) -> Option<Instant> {
        self.node().poll_timeout()
    }

    /// Takes over an image before the first power-on.
    ///
    /// # Errors
    /// [`RecallError`]; nothing is taken over then.
    fn recall(&mut self, now: Instant, image: &[u8]) -> Result<(), RecallError> {
        let (node, application) = self.parts();
        Ok(node.recall(now, image, application)?)
    }

    /// The host does not keep yet what was recalled: it is offered as an image.
    fn offer_image(&mut self) {
        self.parts().0.offer_image();
    }

    /// The image to keep ([`Node::poll_image`](crate::can_bus::canopen::Node::poll_image)).
    ///
    /// # Errors
    /// [`storage::ImageError::NoRoom`]; it stays on offer.
    fn poll_image<'a>(
        &mut self,
        into: &'a mut [u8],
    ) -> Result<Option<StoreRequest<&'a [u8]>>, storage::ImageError> {
        let (node, application) = self.parts();
        node.poll_image(application, into)
    }

    /// What became of an image ([`Node::handle_stored`](crate::can_bus::canopen::Node::handle_stored)).
    fn handle_stored(&mut self, now: Instant, generation: Generation, outcome: Result<(), NotStored>) {
        let (node, application) = self.parts();
        node.handle_stored(now, generation, outcome, application);
    }
}
