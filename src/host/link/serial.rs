//! An RS-485 serial port.
//!
//! The port is set to 8 data bits, even parity, one stop bit (`dp-v0.md` 1) and belongs to this process alone. Beyond
//! that:
//!
//! - **Direction**: where the kernel switches an RS-485 driver by itself (`TIOCSRS485`), it is told to. Elsewhere the
//!   adapter must do it.
//! - **Latency**: on Linux the latency timer of an FTDI adapter is set to 1 ms if this user may write it. Else a warning
//!   says how. On Windows it is set in the Device Manager.
//! - **Echo**: some adapters hear what they send. The octets sent last are dropped if they are the next ones heard.
//! - **Unplugging** ends the link, or with [`Serial::reopen`] is logged, and the device is opened again when it is back.
//!
//! A character with a wrong parity or stop bit is dropped by the kernel (on Windows it is handed over), and the telegram
//! around it fails its checks. `docs/links.md`
//! says what can be reached with which adapter.

use core::time::Duration;
use std::collections::VecDeque;
use std::io;

use rustix::event::{PollFd, PollFlags};

use super::poll_readable;
use crate::host::{Clock, Error, Link, Received, Stop, SystemClock};
use crate::time::{BaudRate, Instant};

mod echo;
#[cfg_attr(windows, path = "serial/windows.rs")]
#[cfg_attr(not(windows), path = "serial/unix.rs")]
mod port;

use echo::Echo;
use port::Port;

/// The first and the longest time between two attempts to open a device that was unplugged.
const FIRST_PAUSE: Duration = Duration::from_millis(100);
const LONGEST_PAUSE: Duration = Duration::from_secs(2);

/// An open serial port.
#[derive(Debug)]
pub struct Serial {
    device: String,
    rate: BaudRate,
    port: State,
    clock: SystemClock,
    reopens: bool,
    /// The device was lost, and nobody has been told.
    reset: bool,
    echo: Echo,
    /// Heard, and no echo.
    heard: VecDeque<u8>,
    lost: u64,
}

/// Whether the device is there.
#[derive(Debug)]
enum State {
    Open(Port),
    /// Unplugged; to be opened again at `next`, and so much later if that fails.
    Gone {
        next: Instant,
        pause: Duration,
    },
}

impl Serial {
    /// Opens `device` (`/dev/ttyUSB0` or `COM3`, say) at `rate` for this process alone.
    ///
    /// # Errors
    /// [`Error::SerialOpen`], [`Error::SerialSettings`].
    pub fn open(device: &str, rate: BaudRate) -> Result<Self, Error> {
        let port = Port::open(device, rate)?;
        port.prepare(device);
        Ok(Self {
            device: device.into(),
            rate,
            port: State::Open(port),
            clock: SystemClock::new(),
            reopens: false,
            reset: false,
            echo: Echo::default(),
            heard: VecDeque::new(),
            lost: 0,
        })
    }

    /// Whether a device that was unplugged is opened again when it is back, instead of ending the link. At first not.
    ///
    /// While it is gone nothing is heard, and what is sent is lost; [`Link::receive`] says [`Received::Reset`] once.
    pub fn reopen(&mut self, reopen: bool) {
        self.reopens = reopen;
    }

    /// How many octets were sent that the port had no room for, or while the device was gone.
    pub fn lost(&self) -> u64 {
        self.lost
    }

    /// Notes that the device is gone, or ends the link.
    fn unplugged(&mut self, error: io::Error) -> io::Result<()> {
        if !self.reopens {
            return Err(error);
        }
        tracing::warn!("{} is gone ({error}); it is opened again when it is back", self.device);
        self.port = State::Gone { next: self.clock.now().saturating_add(FIRST_PAUSE), pause: FIRST_PAUSE };
        self.reset = true;
        self.echo.forget();
        self.heard.clear();
        Ok(())
    }

    /// Opens a device that is gone, if it is time to try.
    fn try_again(&mut self) {
        let State::Gone { next, pause } = &mut self.port else {
            return;
        };
        let now = self.clock.now();
        if now < *next {
            return;
        }
        match Port::open(&self.device, self.rate) {
            Ok(port) => {
                tracing::info!("{} is back", self.device);
                port.prepare(&self.device);
                self.port = State::Open(port);
            }
            Err(error) => {
                tracing::debug!("{error}");
                *pause = pause.saturating_mul(2).min(LONGEST_PAUSE);
                *next = now.saturating_add(*pause);
            }
        }
    }

    /// Reads once, and keeps what is no echo. False if there was nothing.
    fn read(&mut self) -> io::Result<bool> {
        let State::Open(port) = &self.port else {
            return Ok(false);
        };
        let mut buf = [0; 512];
        match port.read(&mut buf) {
            Ok(0) => {
                self.unplugged(io::Error::new(io::ErrorKind::NotConnected, "the serial device is gone"))?;
                Ok(false)
            }
            Ok(count) => {
                self.echo.hear(buf.get(..count).unwrap_or_default(), &mut self.heard);
                Ok(true)
            }
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => Ok(false),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => Ok(true),
            Err(error) => self.unplugged(error).map(|()| false),
        }
    }
}

impl Link for Serial {
    fn receive(&mut self, buf: &mut [u8]) -> io::Result<Received> {
        self.try_again();
        while self.heard.is_empty() && self.read()? {}
        if core::mem::take(&mut self.reset) {
            return Ok(Received::Reset);
        }
        let count = buf.len().min(self.heard.len());
        for (to, octet) in buf.iter_mut().zip(self.heard.drain(..count)) {
            *to = octet;
        }
        Ok(if count == 0 { Received::Nothing } else { Received::Octets(count) })
    }

    /// See [`Link::send`]. What the port has no room for is lost, see [`Serial::lost`].
    fn send(&mut self, telegram: &[u8]) -> io::Result<()> {
        let written = match &self.port {
            State::Open(port) => port.write(telegram),
            State::Gone { .. } => Ok(0),
        };
        let sent = match written {
            Ok(sent) => sent,
            Err(error) if matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted) => 0,
            Err(error) => {
                self.unplugged(error)?;
                0
            }
        };
        self.echo.sent(telegram.get(..sent).unwrap_or_default());
        self.lost = self.lost.saturating_add(telegram.len().saturating_sub(sent) as u64);
        Ok(())
    }

    fn wait(&mut self, timeout: Option<Duration>, stop: &Stop) -> io::Result<()> {
        if self.reset || !self.heard.is_empty() {
            return Ok(());
        }
        let stopped = PollFd::new(stop, PollFlags::IN);
        match &self.port {
            State::Open(port) => poll_readable(&mut [port.watch(), stopped], timeout),
            State::Gone { next, .. } => {
                let pause = next.saturating_since(self.clock.now());
                poll_readable(&mut [stopped], timeout.into_iter().chain([pause]).min())
            }
        }
    }

    /// What arrived at the rate before is noise and forgotten.
    fn set_rate(&mut self, rate: BaudRate) -> io::Result<()> {
        self.rate = rate;
        self.echo.forget();
        self.heard.clear();
        // A device that is gone is opened again at this rate.
        match &mut self.port {
            State::Open(port) => port.set_rate(rate),
            State::Gone { .. } => Ok(()),
        }
    }
}
