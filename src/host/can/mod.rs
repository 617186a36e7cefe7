//! CAN on this machine: a bus in memory, and adapters through which masters of others reach it.
//!
//! ```text
//! master ──slcan──▶ adapter ──frames──▶ Bus ──frames──▶ any CanParticipant
//!        ◀───────── (pty, TCP) ◀──────      ◀──────
//! ```
//!
//! | file | holds |
//! | --- | --- |
//! | [`bus`] | arbitration, bit times, errors, in virtual time |
//! | [`participant`](CanParticipant) | what a station must be able to do |
//! | [`fault`] | frames lost, late, doubled, damaged on purpose |
//! | [`hint`](BusHint) | what is odd, said once |
//! | [`line`](Line) | the bus in real time with the adapters of its masters |
//! | `line_end` | the same as one of its masters has it |
//! | [`node`](StoredNode) | a CANopen device as a participant, and its EEPROM |
//! | `node_counters` | what a node has heard and sent, what went wrong |
//! | `node_faults` | the faults of a bus with nodes: [`Bus::add_fault`] |
//! | [`product`](Product) | a device that can be a node |
//! | [`link_spec`](LinkSpec) | where masters find the bus |
//! | [`endpoint`](CanEndpoint) | the bus from a master's end |
//! | `adapters` | pseudo-terminal and TCP port |
//! | `interface` | a bus that goes on behind an adapter or an interface of Linux |
//! | `tap` | shows what passes at an endpoint |
//! | `socket` | CAN interfaces of Linux (feature `socketcan`) |
//!
//! A node that answers, in virtual time:
//!
//! ```
//! use profidrive::can_bus::can::{BitRate, Frame, Id};
//! use profidrive::host::can::Bus;
//! use profidrive::time::Instant;
//!
//! let mut bus: Bus<()> = Bus::new(BitRate::K1000);
//! let (one, other) = (bus.connect(Instant::ZERO), bus.connect(Instant::ZERO));
//! let frame = Frame::with(Id::base(0x080)?, []);
//! bus.send(Instant::ZERO, one, frame)?;
//!
//! let end = bus.poll_timeout().expect("the frame ends");
//! assert_eq!(end, Instant::from_micros(48), "44 bits and 4 stuff bits");
//! bus.handle_timeout(end);
//! assert_eq!(bus.poll_heard(other).map(|heard| heard.frame), Some(frame));
//! assert_eq!(bus.poll_heard(one), None, "nobody hears himself");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod adapters;
pub mod bus;
mod endpoint;
pub mod fault;
mod hint;
mod interface;
mod line;
mod line_end;
mod link_spec;
mod node;
mod node_counters;
mod node_faults;
mod node_signals;
mod participant;
mod product;
#[cfg(all(target_os = "linux", feature = "socketcan"))]
mod socket;
mod tap;

pub use bus::{Bus, Event, Seat};
pub use endpoint::{CanEndpoint, SlcanEndpoint};
pub use hint::{BusHint, NodeRequest, NodeWatch, Numbers};
pub use interface::{open_slcan, open_socketcan};
pub(crate) use line::AdapterNews;
pub use line::{Line, News, Stay};
pub(crate) use line_end::LineEnd;
pub use link_spec::{LinkSpec, LinkSpecError};
pub use node::StoredNode;
pub(crate) use node_counters::NodeCounters;
pub(crate) use node_signals::number;
pub use node_signals::{NodeOrigin, NodeSignal};
pub use participant::CanParticipant;
pub use product::Product;
#[cfg(all(target_os = "linux", feature = "socketcan"))]
pub use socket::SocketCanEndpoint;
pub(crate) use tap::CanTap;
