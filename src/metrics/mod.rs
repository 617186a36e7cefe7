//! What was counted on lines, as OpenMetrics for Prometheus.
//!
//! ```text
//! Prometheus ──GET /metrics──▶ server of the panel ─▶ scrape ──request──▶ queue ──▶ thread of each line: copies its counters
//!            ◀──── text ─────── families ◀────────── Line ◀───────────────────────
//! ```
//!
//! The thread of a line only copies plain numbers, between two telegrams; text is made elsewhere, and one scrape follows the
//! other. So no reply waits for Prometheus. HTTP, its bounds and its thread are those of [`panel`](crate::panel).
//!
//! ```no_run
//! use profidrive::devices::ag03::profibus::{Config, Device};
//! use profidrive::profibus::fdl::Address;
//! use profidrive::host::{Bus, Clock, Reach, Stop, SystemClock, link::pty::Pty, run};
//! use profidrive::metrics::Metrics;
//!
//! let (clock, stop) = (SystemClock::new(), Stop::new()?);
//! let mut link = Pty::open(None)?;
//! let mut bus = Bus::new();
//! bus.add(Device::new(Config::new(Address::station(5)?), clock.now()))?;
//!
//! let metrics = Metrics::start("127.0.0.1:9187", Reach::ThisMachine)?;
//! let mut of_line = metrics.line(1, &link.path().display().to_string(), stop.clone());
//! loop {
//!     // Ends whenever somebody wants the numbers.
//!     run(&mut link, &mut bus, &clock, &stop, &mut |event| println!("{event}"))?;
//!     // In this order: what is asked from now on ends the next run.
//!     stop.clear();
//!     of_line.serve(&bus);
//! }
//! # #[allow(unreachable_code)]
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! `docs/metrics.md` lists the metrics.
//!
//! | file | holds |
//! | --- | --- |
//! | `families` | every metric: name, type, labels, meaning, and where its numbers come from |
//! | `series` | the text of a metric |
//! | `line` | the numbers of a line and of who is on it |
//! | `scrape` | who asks, and in which order |

mod families;
mod line;
mod scrape;
mod series;

use core::net::SocketAddr;
use std::io;

use thiserror::Error;

use crate::devices::CanopenEvent;
use crate::host::reach::{ListenError, advice};
use crate::host::{Bus, Reach, Stop, can};
use crate::panel::Seated;
use crate::panel::queue::{self, Requests};
use crate::panel::running::{Place, Running, StartError};
use crate::panel::server::Names;

use line::{OfBus, OfNodes};
use scrape::{Asked, Lines, Source};

/// The path of the metrics.
pub const PATH: &str = "/metrics";

/// A port where Prometheus reads what was counted. Dropped, it closes its port and every connection.
#[derive(Debug)]
pub struct Metrics {
    running: Running,
    lines: Lines,
}

/// A line of PROFIBUS among the metrics. Dropped, its metrics are gone.
#[derive(Debug)]
pub struct LineMetrics {
    requests: Requests<OfBus>,
}

/// A bus of CAN among the metrics. Dropped, its metrics are gone.
#[derive(Debug)]
pub struct NodeMetrics {
    requests: Requests<OfNodes>,
}

/// Why metrics cannot be served.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MetricsError {
    /// The port cannot be opened.
    #[error("cannot listen for Prometheus at {place} ({})", advice(source))]
    Listen {
        /// Host and port wanted.
        place: String,
        /// What the operating system says.
        source: io::Error,
    },
    /// Others than this machine could connect, and were not invited.
    #[error("{place} is {address}, where others than this machine can connect and read the metrics")]
    TooFar {
        /// Host and port wanted.
        place: String,
        /// The address that is not of this machine alone.
        address: SocketAddr,
    },
    /// No thread can be started.
    #[error("cannot start the thread for the metrics")]
    Thread {
        /// What the operating system says.
        source: io::Error,
    },
}

impl Metrics {
    /// Listens at `place`, `HOST:PORT` (port 0: a free one).
    ///
    /// # Errors
    /// [`MetricsError`].
    pub fn start(place: &str, reach: Reach) -> Result<Self, MetricsError> {
        let lines = Lines::default();
        let at = Place { name: "metrics", place, reach, names: Names::Any };
        let failed = |error| {
            let place = place.into();
            match error {
                StartError::Listen(ListenError::Failed(source)) => MetricsError::Listen { place, source },
                StartError::Listen(ListenError::TooFar(address)) => MetricsError::TooFar { place, address },
                StartError::Thread(source) => MetricsError::Thread { source },
            }
        };
        let running = Running::start(at, scrape::router(lines.clone()), async {}).map_err(failed)?;
        Ok(Self { running, lines })
    }

    /// Where Prometheus connects; the metrics are at [`PATH`].
    pub const fn address(&self) -> SocketAddr {
        self.running.address()
    }

    /// Puts a line among the metrics, under this number and with the link that a master opens. `wake` is what ends a run
    /// of its bus.
    pub fn line(&self, number: usize, link: &str, wake: Stop) -> LineMetrics {
        let (asking, requests) = queue::queue(wake);
        self.lines.add(Source { number, link: link.into(), asked: Asked::Bus(asking) });
        LineMetrics { requests }
    }

    /// The same for a bus of CAN.
    pub fn can_line(&self, number: usize, link: &str, wake: Stop) -> NodeMetrics {
        let (asking, requests) = queue::queue(wake);
        self.lines.add(Source { number, link: link.into(), asked: Asked::Nodes(asking) });
        NodeMetrics { requests }
    }
}

impl LineMetrics {
    /// Hands over the numbers, if they were asked for since the last run of the bus.
    pub fn serve(&mut self, mut bus: &Bus) {
        self.requests.serve(&mut bus);
    }
}

impl NodeMetrics {
    /// Hands over the numbers, if they were asked for since the last run of the bus. `nodes` are those on it.
    pub fn serve(&mut self, bus: &can::Bus<CanopenEvent>, nodes: &[Seated]) {
        self.requests.serve(&mut (bus, nodes));
    }
}
