//! See lines of either bus and control what acts on their stations: HTTP control, a live stream, and a page for browsers.
//!
//! ```text
//! browser, script ──HTTP──▶ server ─▶ routes ─▶ handlers ──request──▶ queue ──▶ thread of the line: BusAccess, NodeAccess
//!                 ◀────────                         ◀───────answer─────────────
//!                 ◀──server-sent events── stream ◀──────ring──── news, telegrams
//! ```
//!
//! HTTP has a thread of its own. The thread of a line lends its things as a [`BusAccess`] or [`NodeAccess`] between two
//! telegrams, does what is asked, and copies what somebody wants to see; JSON is made of the copy elsewhere. News and telegrams go
//! into a ring that never waits. So no reply waits for HTTP.
//!
//! ```no_run
//! use profidrive::devices::ag03::profibus::{Config, Device};
//! use profidrive::profibus::fdl::Address;
//! use profidrive::host::fault::BusKind;
//! use profidrive::host::list::Ground;
//! use profidrive::host::{Bus, Clock, ValueBoard, Reach, Refusals, Stop, SystemClock, link::pty::Pty, run};
//! use profidrive::panel::{BusAccess, Lines, Panel};
//!
//! let (clock, stop) = (SystemClock::new(), Stop::new()?);
//! let mut link = Pty::open(None)?;
//! let mut bus = Bus::new();
//! bus.add(Device::new(Config::new(Address::station(5)?), clock.now()))?;
//!
//! let (place, line) = (("127.0.0.1:8080", Reach::ThisMachine), ("line", BusKind::Profibus));
//! let mut panel = Panel::start(place, line, stop.clone(), &Lines::default())?;
//! panel.set_link(&link.path().display().to_string());
//! println!("http://{}/", panel.address());
//! let (refusals, board) = (Refusals::default(), ValueBoard::default());
//! loop {
//!     // Ends whenever the panel wants something.
//!     run(&mut link, &mut bus, &clock, &stop, &mut |event| panel.tell(clock.now(), &event))?;
//!     // In this order: what is asked from now on ends the next run.
//!     stop.clear();
//!     let rate = bus.baud();
//!     let ground = Ground { now: clock.now(), rate, state: None, refusals: &refusals, board: &board };
//!     panel.serve(&mut BusAccess { bus: &mut bus, faults: None, ground, choose: &|_| {}, listen: false });
//! }
//! # #[allow(unreachable_code)]
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | file | holds |
//! | --- | --- |
//! | `running` | the thread of HTTP |
//! | `server` | connections, their bounds, who is trusted |
//! | `routes`, `description` | every path; the OpenAPI description of all of them, `openapi.json` |
//! | `queue` | the queue to the thread of a line |
//! | `line` | the lines of a process, and what the thread of each lends |
//! | `station` | a station as JSON: its summary, its state, why it does not move |
//! | `inputs`, `switches`, `parameters`, `objects`, `modules`, `acyclic` | the handlers, by what they are about |
//! | `master` | the master in this program, and what any master can ask |
//! | `dictionary` | what the object dictionary of a node tells |
//! | `stream` | server-sent events |
//! | `history` | events, curves and telegrams of the last minutes |
//! | `problem` | refusals |
//! | `page` | the files of the page |
//!
//! Nothing here knows a device: what a station has, it tells itself ([`Description`](crate::face::Description)).

mod acyclic;
#[cfg(test)]
mod description;
mod dictionary;
mod history;
mod inputs;
mod line;
mod master;
mod modules;
mod objects;
mod page;
mod parameters;
pub(crate) mod problem;
pub(crate) mod queue;
mod routes;
pub(crate) mod running;
pub(crate) mod server;
mod station;
mod stream;
mod switches;

use core::net::SocketAddr;
use std::io;
use std::path::Path;
use std::sync::Arc;

use thiserror::Error;

use crate::devices::CanopenEvent;
use crate::host::can::{BusHint, Event};
use crate::host::fault::BusKind;
#[cfg(feature = "emulator")]
use crate::host::inner_master::InnerMaster;
use crate::host::link::tap::{Batch, Watchers};
use crate::host::reach::{ListenError, advice};
use crate::host::{BusEvent, Reach, Stop};
use crate::time::Instant;

pub use line::Lines;
pub use line::can::{NodeAccess, Seated};
pub use line::profibus::BusAccess;

use line::OfLine;
use running::{Place, Running, StartError};
use server::Names;

/// A running panel, with the line whose thread serves it. Dropped, it closes its port and every connection.
#[derive(Debug)]
pub struct Panel {
    /// Dropped first.
    running: Running,
    requests: queue::Requests<OfLine>,
    feed: stream::Feed,
    sent: stream::SentSettings,
    lines: Lines,
    name: Arc<str>,
}

impl Drop for Panel {
    fn drop(&mut self) {
        self.lines.remove(&self.name);
    }
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
    #[error("{place} is {address}, where others than this machine can connect and control the stations")]
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
    /// Listens at `place`, `HOST:PORT` (port 0: a free one), for a line of this name on this bus; `wake` is what ends a
    /// run of it. Every panel of the process shows all `lines`. `link` is what a master opens.
    ///
    /// # Errors
    /// [`PanelError`].
    pub fn start(
        (place, reach): (&str, Reach),
        (name, bus): (&str, BusKind),
        wake: Stop,
        lines: &Lines,
    ) -> Result<Self, PanelError> {
        let (asking, requests) = queue::queue(wake);
        let name: Arc<str> = name.into();
        let (feed, hub) = stream::stream(Arc::clone(&name), Arc::clone(lines.readers()));
        let (lines, beside) = (lines.clone(), hub.clone().run(asking.clone()));
        let running = Running::start(at(place, reach), routes::router(lines.clone()), beside)
            .map_err(|error| PanelError::of(place, error))?;
        lines.add((Arc::clone(&name), bus), asking, hub);
        Ok(Self { running, requests, feed, sent: stream::SentSettings::default(), lines, name })
    }

    /// What a master opens.
    pub fn set_link(&self, link: &str) {
        self.lines.set_link(&self.name, link);
    }

    /// The folder of device files and tables that may be named over HTTP.
    pub fn set_files(&self, folder: &Path) {
        self.lines.set_files(&self.name, folder);
    }

    /// The master in this program, which those who connect may use.
    #[cfg(feature = "emulator")]
    pub(crate) fn set_master(&self, master: InnerMaster) {
        self.lines.set_master(&self.name, master);
    }

    /// Where browsers and programs connect.
    pub const fn address(&self) -> SocketAddr {
        self.running.address()
    }

    /// Carries out what was asked since the last run of the bus. Changes what is due next on the bus, as a `handle_*`
    /// call of it does.
    pub fn serve(&mut self, lent: &mut BusAccess<'_>) {
        self.requests.serve(lent);
        self.feed.settings(lent, &mut self.sent);
    }

    /// The same for a bus of CAN.
    pub fn serve_can(&mut self, lent: &mut NodeAccess<'_>) {
        self.requests.serve(lent);
        self.feed.know(line::can::numbers(lent));
        self.feed.settings(lent, &mut self.sent);
    }

    /// Tells those who read the stream. Never waits.
    pub fn tell(&self, now: Instant, event: &BusEvent) {
        self.tell_with(now, event, None);
    }

    /// The same, with words that stand behind what the event says itself ([`Refusals`](crate::host::Refusals)).
    pub fn tell_with(&self, now: Instant, event: &BusEvent, words: Option<Arc<str>>) {
        self.feed.tell(now, event, words);
    }

    /// The same of a bus of CAN.
    pub fn tell_can(&self, now: Instant, event: &Event<CanopenEvent>) {
        self.feed.tell_can(now, event);
    }

    /// Tells those who read the stream of something odd on a bus of CAN. Never waits.
    pub fn hint(&self, now: Instant, hint: BusHint) {
        self.feed.hint(now, hint);
    }

    /// What tells those who read the stream of trouble in the program itself. Never waits.
    #[cfg(feature = "emulator")]
    pub(crate) fn warner(&self) -> impl Fn(Instant, String) + Send + use<> {
        let feed = self.feed.clone();
        move |now, text| feed.warn(now, text)
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
