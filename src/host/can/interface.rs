//! A bus that goes on outside: the nodes here, masters and other nodes behind an interface of this machine.
//!
//! What a node sends is on the bus in memory first, with the time that takes, then behind the interface, and the other way
//! round. Who is bus off there, and who lost the arbitration, stays there.

use std::io;

use super::{Bus, CanEndpoint, LinkSpec, Seat, SlcanEndpoint};
use crate::can_bus::can::BitRate;
use crate::host::{Error, Stop};
use crate::time::Instant;

/// What a bus goes on behind.
pub(super) type AnyEndpoint = Box<dyn CanEndpoint + Send>;

/// The seat of everybody behind an endpoint.
pub(super) struct Interface {
    endpoint: AnyEndpoint,
    name: String,
    seat: Seat,
}

impl Interface {
    /// Everybody behind `endpoint`, called `name`.
    pub(super) fn new<E: 'static>(
        endpoint: AnyEndpoint,
        name: String,
        bus: &mut Bus<E>,
        now: Instant,
    ) -> Self {
        Self { endpoint, name, seat: bus.connect(now) }
    }

    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// Puts what came from outside on the bus, as far as it has room. What does not fit waits outside.
    pub(super) fn read<E: 'static>(&mut self, bus: &mut Bus<E>, now: Instant) -> io::Result<()> {
        while bus.has_room(self.seat) {
            match self.endpoint.receive()? {
                // There is room.
                Some(frame) => drop(bus.send(now, self.seat, frame)),
                None => break,
            }
        }
        Ok(())
    }

    /// Hands out what the bus has for those outside.
    pub(super) fn write<E: 'static>(&mut self, bus: &mut Bus<E>) -> io::Result<()> {
        while let Some(heard) = bus.poll_heard(self.seat) {
            self.endpoint.send(&heard.frame)?;
        }
        Ok(())
    }

    /// Sleeps until something comes from outside, or until a stop, what is due on the bus, or `latest`.
    pub(super) fn wait<E: 'static>(
        &mut self,
        bus: &Bus<E>,
        now: Instant,
        latest: Option<Instant>,
        stop: &Stop,
    ) -> io::Result<()> {
        let until = Instant::first_of(bus.poll_noticed(), latest);
        let timeout = until.map(|until| until.saturating_since(now));
        self.endpoint.wait(timeout, stop)
    }
}

/// Opens the CAN interface of Linux of that name: `can0`, `vcan0`. Its rate is set by `ip link`.
///
/// # Errors
/// [`Error::CanInterface`]: it is not there, is no CAN interface, or this build has no feature `socketcan`.
pub fn open_socketcan(name: &str) -> Result<Box<dyn CanEndpoint + Send>, Error> {
    socket(name).map_err(|source| Error::CanInterface { name: name.into(), source })
}

#[cfg(all(target_os = "linux", feature = "socketcan"))]
fn socket(name: &str) -> io::Result<AnyEndpoint> {
    Ok(Box::new(super::SocketCanEndpoint::open(name)?))
}

#[cfg(not(all(target_os = "linux", feature = "socketcan")))]
fn socket(_: &str) -> io::Result<AnyEndpoint> {
    let why = "this build has no feature socketcan; use slcan-tty:PATH";
    Err(io::Error::new(io::ErrorKind::Unsupported, why))
}

/// Opens the channel of the slcan adapter at the terminal or port of that path.
///
/// # Errors
/// Those of opening a terminal; [`Error::Link`] if the adapter has no number for `rate`.
pub fn open_slcan(path: &std::path::Path, rate: BitRate) -> Result<Box<dyn CanEndpoint + Send>, Error> {
    match SlcanEndpoint::open(terminal(path)?, rate) {
        Ok(endpoint) => Ok(Box::new(endpoint)),
        Err(source) => Err(Error::Link { source }),
    }
}

#[cfg(any(unix, feature = "serial"))]
fn terminal(path: &std::path::Path) -> Result<crate::host::link::terminal::Terminal, Error> {
    // The rate of the terminal means nothing to an emulator and little to a USB adapter.
    crate::host::link::terminal::Terminal::open(path, crate::time::BaudRate::K500)
}

#[cfg(not(any(unix, feature = "serial")))]
fn terminal(path: &std::path::Path) -> Result<crate::host::link::memory::End, Error> {
    let source = io::Error::new(io::ErrorKind::Unsupported, "this build has no feature serial");
    Err(Error::TerminalOpen { path: path.into(), advice: "use a TCP port", source })
}

/// The endpoint of a link that leads outside, and its name; `None`: the link has adapters here.
pub(super) fn of_link(spec: &LinkSpec, rate: BitRate) -> Option<Result<(AnyEndpoint, String), Error>> {
    match spec {
        LinkSpec::Pty(_) | LinkSpec::Tcp(_) => None,
        LinkSpec::Terminal(path) => {
            Some(open_slcan(path, rate).map(|endpoint| (endpoint, format!("slcan-tty:{}", path.display()))))
        }
        LinkSpec::Socket(name) => {
            Some(open_socketcan(name).map(|endpoint| (endpoint, format!("socketcan:{name}"))))
        }
    }
}
