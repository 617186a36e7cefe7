//! The panel of a bus of CAN: the nodes on it, and what acts on them.
//!
//! It knows no device: what a node has, it says itself ([`Surroundings`](crate::face::Surroundings)), and its objects
//! are in its dictionary.
//!
//! | file | holds |
//! | --- | --- |
//! | `access` | what the thread of the bus lends |
//! | `routes` | every path, the OpenAPI description |
//! | `fleet` | nodes that come and go |
//! | `why` | what keeps a drive from moving |
//! | `objects` | the object dictionary |
//! | `state` | a node as JSON |
//! | `words` | words of bits, PDOs, the error history |
//! | `bus` | counters of the bus |
//! | `history` | the newest events, for who comes late |
//! | `news` | what happens, as events of the stream |
//! | `stream` | server-sent events |

mod access;
mod bus;
mod fleet;
mod history;
mod news;
mod objects;
mod routes;
mod state;
mod stream;
mod why;
mod words;

use core::net::SocketAddr;
use std::sync::Arc;

use super::queue;
use super::running::Running;
use super::{PanelError, at};
use crate::devices::CanopenEvent;
use crate::host::can::{BusHint, Event};
use crate::host::{Reach, Stop};
use crate::time::Instant;
use access::OfNodes;

pub use access::{NodeAccess, Seated};

/// A running panel of a bus of CAN. Dropped, it closes its port and every connection.
///
/// ```no_run
/// use profidrive::can_bus::can::BitRate;
/// use profidrive::can_bus::canopen::NodeId;
/// use profidrive::can_bus::canopen::storage::Eeprom;
/// use profidrive::host::can::{Line, News, Product, StoredNode};
/// use profidrive::host::list::Choices;
/// use profidrive::host::{Clock, Reach, Stop};
/// use profidrive::panel::{NodeAccess, NodePanel, Seated};
///
/// let stop = Stop::new()?;
/// let mut line = Line::open(&"slcan-tcp:127.0.0.1:0".parse()?, BitRate::K500, Reach::ThisMachine)?;
/// let clock = line.clock();
/// let product = Product::named("ap10").expect("it is in the list");
/// let device = product.make(NodeId::new(5)?, &Choices::default(), Eeprom::Internal, clock.now());
/// let seat = line.add(Box::new(StoredNode::new(device, clock.now())));
/// let mut nodes = vec![Seated { seat, product }];
///
/// let mut panel = NodePanel::start("127.0.0.1:8080", Reach::ThisMachine, stop.clone())?;
/// println!("http://{}/", panel.address());
/// loop {
///     // Ends whenever the panel wants something.
///     line.run(&stop, &mut |news| {
///         if let News::Bus(event) = &news {
///             panel.tell(clock.now(), event);
///         }
///     })?;
///     // In this order: what is asked from now on ends the next run.
///     stop.clear();
///     panel.serve(&mut NodeAccess {
///         now: clock.now(),
///         bus: line.bus_mut(),
///         nodes: &mut nodes,
///         state: None,
///         choose: &|_, _| {},
///     });
/// }
/// # #[allow(unreachable_code)]
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct NodePanel {
    /// Dropped first.
    running: Running,
    requests: queue::Requests<OfNodes>,
    feed: Arc<news::Feed>,
}

impl NodePanel {
    /// Listens at `place`, `HOST:PORT` (port 0: a free one). `wake` is what ends a run of the bus.
    ///
    /// # Errors
    /// [`PanelError`].
    pub fn start(place: &str, reach: Reach, wake: Stop) -> Result<Self, PanelError> {
        let (asking, requests) = queue::queue(wake);
        let feed = Arc::new(news::Feed::default());
        let app = routes::App { asking, feed: Arc::clone(&feed) };
        let running = Running::start(at(place, reach), routes::router(app), async {})
            .map_err(|error| PanelError::of(place, error))?;
        Ok(Self { running, requests, feed })
    }

    /// Where browsers and programs connect.
    pub const fn address(&self) -> SocketAddr {
        self.running.address()
    }

    /// Carries out what was asked since the last run of the bus. Changes what is due next on the bus, as a `handle_*`
    /// call of it does.
    pub fn serve(&mut self, bench: &mut NodeAccess<'_>) {
        self.requests.serve(bench);
        self.feed.know(bench);
    }

    /// Whether somebody reads frames, which a [`Bus`](crate::host::can::Bus) tells only if it is watched.
    pub fn wants_frames(&self) -> bool {
        self.feed.wants_frames()
    }

    /// Tells those who read the stream of something odd. Never waits.
    pub fn hint(&self, now: Instant, hint: BusHint) {
        self.feed.hint(now, hint);
    }

    /// Tells those who read the stream. Never waits.
    pub fn tell(&self, now: Instant, event: &Event<CanopenEvent>) {
        self.feed.tell(now, event);
    }
}
