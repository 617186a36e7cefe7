//! An RS-485 serial port.
//!
//! The port is set to 8 data bits, even parity, one stop bit (`dp-v0.md` 1) and belongs to this process alone. This
//! file adds nothing to what the operating system and the adapter do: an adapter that needs its direction switched,
//! that echoes what is sent, or that holds octets back for milliseconds is not compensated for.

use core::time::Duration;
use std::fs::{File, OpenOptions};
use std::io;
use std::os::unix::fs::OpenOptionsExt;

use rustix::event::{PollFd, PollFlags};
use rustix::fs::OFlags;
use rustix::io::Errno;
use serialport::{ClearBuffer, DataBits, FlowControl, Parity, SerialPort, StopBits, TTYPort};

use super::poll_readable;
use crate::host::{Error, Link, Received, Stop};
use crate::time::BaudRate;

/// An open serial port.
#[derive(Debug)]
pub struct Serial {
    /// The device once more, for `poll` and for reads and writes that never block: `serialport` offers neither
    /// without its raw descriptor.
    file: File,
    /// Holds the settings and the exclusive lock.
    port: TTYPort,
    lost: u64,
}

impl Serial {
    /// Opens `device` (`/dev/ttyUSB0`, say) at `rate` for this process alone.
    ///
    /// # Errors
    /// [`Error::SerialOpen`], [`Error::SerialSettings`].
    pub fn open(device: &str, rate: BaudRate) -> Result<Self, Error> {
        let not_open =
            |source: io::Error| Error::SerialOpen { device: device.into(), advice: advice(&source), source };
        let flags = OFlags::NOCTTY | OFlags::NONBLOCK;
        // Before `serialport` locks it: the lock keeps out every opening that comes later.
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .custom_flags(flags.bits().cast_signed())
            .open(device)
            .map_err(not_open)?;
        if !rustix::termios::isatty(&file) {
            return Err(not_open(Errno::NOTTY.into()));
        }
        let refused = |source: serialport::Error| Error::SerialSettings {
            device: device.into(),
            rate,
            source: source.into(),
        };
        let port = serialport::new(device, rate.bits_per_second())
            .data_bits(DataBits::Eight)
            .parity(Parity::Even)
            .stop_bits(StopBits::One)
            .flow_control(FlowControl::None)
            .open_native()
            .map_err(refused)?;
        // What arrived under other settings is noise.
        port.clear(ClearBuffer::All).map_err(refused)?;
        Ok(Self { file, port, lost: 0 })
    }

    /// How many octets were sent that the port had no room for.
    pub fn lost(&self) -> u64 {
        self.lost
    }
}

/// What a person can do about a device that does not open.
fn advice(error: &io::Error) -> &'static str {
    match Errno::from_io_error(error) {
        Some(Errno::NOENT) => "check the name and that the adapter is plugged in",
        Some(Errno::ACCESS | Errno::PERM) => "add your user to the group that owns it, often dialout",
        Some(Errno::BUSY) => "another program has it open; close that one",
        Some(Errno::NOTTY | Errno::ISDIR) => "name a serial device such as /dev/ttyUSB0",
        _ => "check the adapter",
    }
}

impl Link for Serial {
    fn receive(&mut self, buf: &mut [u8]) -> io::Result<Received> {
        loop {
            match rustix::io::read(&self.file, &mut *buf) {
                Ok(0) if buf.is_empty() => return Ok(Received::Nothing),
                Ok(0) => {
                    return Err(io::Error::new(io::ErrorKind::NotConnected, "the serial device is gone"));
                }
                Ok(count) => return Ok(Received::Octets(count)),
                Err(Errno::AGAIN) => return Ok(Received::Nothing),
                Err(Errno::INTR) => {}
                Err(error) => return Err(error.into()),
            }
        }
    }

    /// See [`Link::send`]. What the port has no room for is lost, see [`Serial::lost`].
    fn send(&mut self, telegram: &[u8]) -> io::Result<()> {
        let sent = match rustix::io::write(&self.file, telegram) {
            Ok(sent) => sent,
            Err(Errno::AGAIN | Errno::INTR) => 0,
            Err(error) => return Err(error.into()),
        };
        self.lost = self.lost.saturating_add(telegram.len().saturating_sub(sent) as u64);
        Ok(())
    }

    fn wait(&mut self, timeout: Option<Duration>, stop: &Stop) -> io::Result<()> {
        let mut fds = [PollFd::new(&self.file, PollFlags::IN), PollFd::new(stop, PollFlags::IN)];
        poll_readable(&mut fds, timeout)
    }

    /// What arrived at the rate before is noise and forgotten.
    fn set_rate(&mut self, rate: BaudRate) -> io::Result<()> {
        self.port.set_baud_rate(rate.bits_per_second())?;
        self.port.clear(ClearBuffer::Input)?;
        Ok(())
    }
}
