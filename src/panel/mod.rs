//! See a bus and control what acts on its drives: HTTP control, a live stream, and a page for browsers.
//!
//! ```text
//! browser, script ──HTTP──▶ server ─▶ routes ─▶ handlers ──request──▶ queue ──▶ thread of the bus: BusAccess
//!                 ◀────────                         ◀───────answer─────────────
//!                 ◀──server-sent events── stream ◀──────ring──── news, telegrams
//! ```
//!
//! HTTP has a thread of its own. The thread of the bus lends its things as a [`BusAccess`] between two telegrams, does what
//! is asked, and copies what somebody wants to see; words and JSON are made of the copy elsewhere. News and telegrams go
//! into a ring that never waits. So no reply waits for HTTP.
//!
//! ```no_run
//! use profidrive::devices::ag03::profibus::{Config, Device};
//! use profidrive::profibus::fdl::Address;
//! use profidrive::host::{Bus, Clock, Reach, Stop, SystemClock, link::pty::Pty, run};
//! use profidrive::panel::{BusAccess, Panel};
//!
//! let (clock, stop) = (SystemClock::new(), Stop::new()?);
//! let mut link = Pty::open(None)?;
//! let mut bus = Bus::new();
//! let config = Config::new(Address::station(5)?);
//! bus.add(Device::new(config, clock.now()))?;
//!
//! let mut panel = Panel::start("127.0.0.1:8080", Reach::ThisMachine, stop.clone())?;
//! println!("http://{}/", panel.address());
//! loop {
//!     // Ends whenever the panel wants something.
//!     run(&mut link, &mut bus, &clock, &stop, &mut |event| panel.tell(clock.now(), &event))?;
//!     // In this order: what is asked from now on ends the next run.
//!     stop.clear();
//!     let now = clock.now();
//!     panel.serve(&mut BusAccess { now, bus: &mut bus, faults: None, config, state: None, listen: false });
//! }
//! # #[allow(unreachable_code)]
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | file | holds |
//! | --- | --- |
//! | `running` | the thread of HTTP |
//! | `server` | connections, their bounds, who is trusted |
//! | `routes` | every path, the OpenAPI description |
//! | `queue` | the queue to the thread of the bus |
//! | `bus_access` | what the thread of a bus of PROFIBUS lends |
//! | `drives`, `inputs`, `switches`, `parameters`, `why`, `bus` | the handlers, by what they are about |
//! | `stations` | the same for stations from GSDs |
//! | `ppo_drives` | the same for drives of PROFIDRIVE version 2 |
//! | `state`, `words` | a drive as JSON |
//! | `stream` | server-sent events |
//! | `history` | events, curves and telegrams of the last minutes |
//! | `nodes` | all of this for a bus of CAN: [`NodePanel`] |
//! | `problem` | refusals |
//! | `page` | the files of the page |

mod bus;
mod bus_access;
mod drives;
mod faults;
mod history;
mod inputs;
mod nodes;
mod page;
mod parameters;
mod ppo_drives;
pub(crate) mod problem;
pub(crate) mod queue;
mod routes;
pub(crate) mod running;
pub(crate) mod server;
mod state;
mod stations;
mod stream;
mod switches;
mod why;
mod words;

use core::net::SocketAddr;
use std::io;
use std::sync::Arc;

use thiserror::Error;

use crate::host::link::tap::{Batch, Watchers};
use crate::host::reach::{ListenError, advice};
use crate::host::{BusEvent, Reach, Stop};
use crate::time::Instant;

pub use bus_access::BusAccess;
pub use nodes::{NodeAccess, NodePanel, Seated};

use bus_access::OfBus;
use running::{Place, Running, StartError};
use server::Names;

/// A running panel of a bus of PROFIBUS. Dropped, it closes its port and every connection.
#[derive(Debug)]
pub struct Panel {
    /// Dropped first.
    running: Running,
    requests: queue::Requests<OfBus>,
    feed: stream::Feed,
    sent: stream::SentSettings,
}

/// Why a panel cannot be started.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PanelError {
    /// The port cannot be opened.
    #[error("cannot listen for the panel at {place} ({})", advice(source))]
    Listen {
        /// Host and port wanted.
        place: String,
        /// What the operating system says.
        source: io::Error,
    },
    /// Others than this machine could connect, and were not invited.
    #[error("{place} is {address}, where others than this machine can connect and control the drives")]
    TooFar {
        /// Host and port wanted.
        place: String,
        /// The address that is not of this machine alone.
        address: SocketAddr,
    },
    /// No thread can be started.
    #[error("cannot start the panel")]
    Thread {
        /// What the operating system says.
        source: io::Error,
    },
}

/// Where a panel listens.
const fn at(place: &str, reach: Reach) -> Place<'_> {
    Place { name: "panel", place, reach, names: Names::Numbers }
}

impl PanelError {
    fn of(place: &str, error: StartError) -> Self {
        let place = place.to_string();
        match error {
            StartError::Listen(ListenError::Failed(source)) => Self::Listen { place, source },
            StartError::Listen(ListenError::TooFar(address)) => Self::TooFar { place, address },
            StartError::Thread(source) => Self::Thread { source },
        }
    }
}

impl Panel {
    /// Listens at `place`, `HOST:PORT` (port 0: a free one). `wake` is what ends a run of the bus.
    ///
    /// # Errors
    /// [`PanelError`].
    pub fn start(place: &str, reach: Reach, wake: Stop) -> Result<Self, PanelError> {
        let (asking, requests) = queue::queue(wake);
        let (feed, hub) = stream::stream();
        let app = routes::App { asking: asking.clone(), hub: hub.clone() };
        let running = Running::start(at(place, reach), routes::router(app), hub.run(asking))
            .map_err(|error| PanelError::of(place, error))?;
        Ok(Self { running, requests, feed, sent: stream::SentSettings::default() })
    }

    /// Where browsers and programs connect.
    pub const fn address(&self) -> SocketAddr {
        self.running.address()
    }

    /// Carries out what was asked since the last run of the bus. Changes what is due next on the bus, as a `handle_*`
    /// call of it does.
    pub fn serve(&mut self, bench: &mut BusAccess<'_>) {
        self.requests.serve(bench);
        self.feed.settings(bench, &mut self.sent);
    }

    /// Tells those who read the stream. Never waits.
    pub fn tell(&self, now: Instant, event: &BusEvent) {
        self.tell_with(now, event, None);
    }

    /// The same, with words that stand behind what the event says itself ([`Refusals`](crate::host::Refusals)).
    pub fn tell_with(&self, now: Instant, event: &BusEvent, words: Option<Arc<str>>) {
        self.feed.tell(now, event, words);
    }

    /// Who watches telegrams now, for [`Tap::only_for`](crate::host::link::tap::Tap::only_for).
    pub fn watchers(&self) -> Watchers {
        self.feed.watchers().clone()
    }

    /// What shows telegrams to those who read the stream, for a [`Tap`](crate::host::link::tap::Tap). Never waits, and
    /// does nothing while nobody watches telegrams.
    pub fn observer(&self) -> impl Fn(&Batch) + Send + use<> {
        let feed = self.feed.clone();
        move |batch| feed.show(batch)
    }
}
