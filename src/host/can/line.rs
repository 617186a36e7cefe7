//! A bus in real time: stations, the adapters of masters, and the loop that runs both.

use core::fmt;
use core::time::Duration;

use super::adapters::Adapters;
use super::bus::{ChangeOver, Event};
use super::interface::{self, Interface};
use super::{Bus, CanEndpoint, CanParticipant, LinkSpec, Seat};
use crate::can_bus::can::BitRate;
use crate::can_bus::can::slcan::{BusTiming, Channel, Refusal};
use crate::host::{Clock, Error, Reach, Stop, SystemClock};
use crate::time::Instant;

/// Something that happened on a [`Line`].
#[derive(Clone, Debug, PartialEq)]
pub enum News<E> {
    /// On the bus.
    Bus(Event<E>),
    /// At the adapter of a master.
    Adapter {
        /// Which: the terminal, or the address of the master.
        name: String,
        /// What.
        news: AdapterNews,
    },
}

/// Something that happened at an adapter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum AdapterNews {
    /// The master set a rate.
    Rate {
        /// As it says it.
        timing: BusTiming,
        /// The rate of the bus now.
        bus: BitRate,
        /// Whether that is because of it.
        outcome: ChangeOver,
    },
    /// The master opened or closed the adapter.
    Channel(Channel),
    /// A line of the master was refused with BEL.
    Refused(Refusal),
}

impl fmt::Display for AdapterNews {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Rate { timing, bus, outcome: ChangeOver::Kept } => write!(
                f,
                "rate set to {timing}, which no node has; the bus in memory keeps {bus}, on a real bus the nodes would be silent"
            ),
            Self::Rate { timing, outcome: ChangeOver::Taken, .. } => {
                write!(f, "rate set to {timing}, which the bus has now")
            }
            Self::Rate { timing, outcome: ChangeOver::Same, .. } => {
                write!(f, "rate set to {timing}, that of the bus")
            }
            Self::Channel(Channel::Closed) => f.write_str("closed"),
            Self::Channel(Channel::Open) => f.write_str("open"),
            Self::Channel(Channel::ListenOnly) => f.write_str("open to listen only"),
            Self::Refused(refusal) => write!(f, "line refused: {refusal}"),
        }
    }
}

/// A bus in real time.
///
/// ```no_run
/// use profidrive::can_bus::can::BitRate;
/// use profidrive::host::can::Line;
/// use profidrive::host::{Reach, Stop};
///
/// let mut line: Line<()> = Line::open(&"slcan-pty:/tmp/can0".parse()?, BitRate::K1000, Reach::ThisMachine)?;
/// // line.add(Box::new(node));
/// println!("ready link={}", line.name());
/// line.run(&Stop::new()?, &mut |news| println!("{news:?}"))?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Line<E> {
    bus: Bus<E>,
    masters: Masters,
    clock: SystemClock,
    /// The port of a master of this process: what it has heard it takes before the loop sleeps.
    own: Option<Seat>,
}

/// How masters reach the bus.
enum Masters {
    /// Each at an adapter of this process.
    Adapters(Adapters),
    /// All behind one interface.
    Outside(Interface),
}

/// Whether [`Line::turn`] may sleep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stay {
    /// Until something is to be done.
    Sleep,
    /// Not at all.
    Awake,
}

impl<E: 'static> Line<E> {
    /// Opens the link and a bus without stations.
    ///
    /// # Errors
    /// [`Error::Pty`], [`Error::PathTaken`], [`Error::Symlink`] of a pseudo-terminal, [`Error::Tcp`], [`Error::TcpReach`] of
    /// a TCP port, [`Error::TerminalOpen`], [`Error::LinkLeftBehind`] of a terminal, [`Error::CanInterface`].
    pub fn open(spec: &LinkSpec, rate: BitRate, reach: Reach) -> Result<Self, Error> {
        if let Some(outside) = interface::of_link(spec, rate) {
            let (endpoint, name) = outside?;
            return Ok(Self::over(endpoint, name, rate));
        }
        let clock = SystemClock::new();
        let mut bus = Bus::new(rate);
        let adapters = match spec {
            LinkSpec::Pty(path) => Adapters::at_pty(path.as_ref(), &mut bus, clock.now())?,
            LinkSpec::Tcp(place) => Adapters::at_tcp(place, reach)?,
            LinkSpec::Terminal(_) | LinkSpec::Socket(_) => {
                return Err(Error::Link { source: std::io::ErrorKind::Unsupported.into() });
            }
        };
        Ok(Self { bus, masters: Masters::Adapters(adapters), clock, own: None })
    }

    /// A bus without stations that goes on behind `endpoint`: masters and other nodes are there. `rate` is what the bus
    /// outside has; it times the frames here.
    pub(crate) fn over(endpoint: Box<dyn CanEndpoint + Send>, name: String, rate: BitRate) -> Self {
        let clock = SystemClock::new();
        let mut bus = Bus::new(rate);
        let outside = Interface::new(endpoint, name, &mut bus, clock.now());
        Self { bus, masters: Masters::Outside(outside), clock, own: None }
    }

    /// What a master opens: the path of a terminal, or `slcan-tcp:HOST:PORT` with the port that was found; of a bus that
    /// goes on outside where it does.
    pub fn name(&self) -> &str {
        match &self.masters {
            Masters::Adapters(adapters) => adapters.name(),
            Masters::Outside(outside) => outside.name(),
        }
    }

    /// Puts a station on the bus now.
    pub fn add(&mut self, participant: Box<dyn CanParticipant<Event = E>>) -> Seat {
        self.bus.add(self.clock.now(), participant)
    }

    /// The bus, to provoke errors and to read counters.
    pub const fn bus(&self) -> &Bus<E> {
        &self.bus
    }

    /// The bus, to change it while the loop does not run. Its time is that of [`Line::clock`].
    pub const fn bus_mut(&mut self) -> &mut Bus<E> {
        &mut self.bus
    }

    /// Puts a port on the bus for a master of this process.
    pub(super) fn connect_own(&mut self) -> Seat {
        let seat = self.bus.connect(self.clock.now());
        self.own = Some(seat);
        seat
    }

    /// The time of the bus.
    pub const fn clock(&self) -> SystemClock {
        self.clock
    }

    /// Runs the bus until `stop` is requested. `on_news` gets what happens. It can be called again afterwards.
    ///
    /// The loop sleeps until a frame ends, a station has something to do or a master sends something, and uses no time
    /// otherwise.
    ///
    /// # Errors
    /// [`Error::Link`] when the terminal or the interface no longer works. A connection that breaks is no error.
    pub fn run(&mut self, stop: &Stop, on_news: &mut dyn FnMut(News<E>)) -> Result<(), Error> {
        while !stop.is_requested() {
            self.turn(Stay::Sleep, stop, on_news)?;
        }
        Ok(())
    }

    /// Runs until nobody on the bus has a frame to send, for `limit` at most: the boot-ups of a start are over then.
    ///
    /// # Errors
    /// As [`Line::run`].
    pub(crate) fn run_until_idle(
        &mut self,
        limit: Duration,
        stop: &Stop,
        on_news: &mut dyn FnMut(News<E>),
    ) -> Result<(), Error> {
        let end = self.clock.now().saturating_add(limit);
        loop {
            self.turn(Stay::Awake, stop, on_news)?;
            let now = self.clock.now();
            if self.bus.is_quiet() || stop.is_requested() || now >= end {
                return Ok(());
            }
            let next = self.bus.poll_timeout().map_or(end, |next| next.min(end));
            std::thread::sleep(next.saturating_since(now));
        }
    }

    /// One turn of the loop of [`Line::run`].
    ///
    /// # Errors
    /// As [`Line::run`].
    pub fn turn(&mut self, stay: Stay, stop: &Stop, on_news: &mut dyn FnMut(News<E>)) -> Result<(), Error> {
        self.turn_until(stay, None, stop, on_news)
    }

    /// The same, and sleeps no longer than until `latest`.
    pub(super) fn turn_until(
        &mut self,
        stay: Stay,
        latest: Option<Instant>,
        stop: &Stop,
        on_news: &mut dyn FnMut(News<E>),
    ) -> Result<(), Error> {
        let failed = |source| Error::Link { source };
        let now = self.clock.now();
        self.bus.handle_timeout(now);
        let more = match &mut self.masters {
            Masters::Adapters(adapters) => adapters.read(&mut self.bus, now, on_news).map_err(failed)?,
            Masters::Outside(outside) => {
                outside.read(&mut self.bus, now).map_err(failed)?;
                false
            }
        };
        self.bus.handle_timeout(self.clock.now());
        self.bus.look_ahead();
        // Before a master reads of it: what a master knows, the one who watches has seen.
        while let Some(event) = self.bus.poll_event() {
            on_news(News::Bus(event));
        }
        let now = self.clock.now();
        match &mut self.masters {
            Masters::Adapters(adapters) => adapters.write(&mut self.bus, now).map_err(failed)?,
            Masters::Outside(outside) => outside.write(&mut self.bus).map_err(failed)?,
        }
        let has_heard = self.own.is_some_and(|seat| self.bus.has_heard(seat));
        if more || stay == Stay::Awake || has_heard {
            return Ok(());
        }
        let now = self.clock.now();
        match &mut self.masters {
            Masters::Adapters(adapters) => adapters.wait(&self.bus, now, latest, stop).map_err(failed),
            Masters::Outside(outside) => outside.wait(&self.bus, now, latest, stop).map_err(failed),
        }
    }
}
