//! A COM port without parity: an adapter that takes text, as one of slcan does.
//!
//! A line of PROFIBUS wants `link::serial::Serial`.

use core::time::Duration;
use std::io;
use std::path::Path;

use rustix::event::{PollFd, PollFlags};
use serial2::Parity;

use super::com::Com;
use super::poll_readable;
use crate::host::{Error, Link, Received, Stop};
use crate::time::BaudRate;

/// An open port.
#[derive(Debug)]
pub struct Terminal {
    com: Com,
    lost: u64,
}

impl Terminal {
    /// Opens the port at `path` (`COM3`, say) for this process alone, with 8 data bits and no parity. What was waiting
    /// there is dropped.
    ///
    /// # Errors
    /// [`Error::SerialOpen`], also if another program has it open. [`Error::SerialSettings`].
    pub fn open(path: &Path, rate: BaudRate) -> Result<Self, Error> {
        Com::open(&path.to_string_lossy(), rate, Parity::None).map(|com| Self { com, lost: 0 })
    }

    /// How many octets were sent that the port had no room for.
    pub fn lost(&self) -> u64 {
        self.lost
    }
}

impl Link for Terminal {
    fn receive(&mut self, buf: &mut [u8]) -> io::Result<Received> {
        match self.com.read(buf) {
            Ok(0) => Err(io::Error::new(io::ErrorKind::NotConnected, "the port is gone")),
            Ok(count) => Ok(Received::Octets(count)),
            Err(error) if matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted) => {
                Ok(Received::Nothing)
            }
            Err(error) => Err(error),
        }
    }

    /// See [`Link::send`]. What the port has no room for is lost, see [`Terminal::lost`].
    fn send(&mut self, telegram: &[u8]) -> io::Result<()> {
        let sent = self.com.write(telegram)?;
        self.lost = self.lost.saturating_add(telegram.len().saturating_sub(sent) as u64);
        Ok(())
    }

    fn wait(&mut self, timeout: Option<Duration>, stop: &Stop) -> io::Result<()> {
        poll_readable(&mut [self.com.watch(), PollFd::new(stop, PollFlags::IN)], timeout)
    }
}
