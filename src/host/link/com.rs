//! A COM port of Windows whose arrivals can be slept on together with sockets.
//!
//! ```text
//! COM ──▶ thread ──socket pair──▶ read, poll
//!     ◀────────────────────────── write
//! ```

use core::sync::atomic::{AtomicBool, Ordering};
use std::io::{self, ErrorKind, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::sync::Arc;
use std::thread::{self, JoinHandle};

use rustix::event::{PollFd, PollFlags};
use serial2::os::windows::CommTimeouts;
use serial2::{CharSize, FlowControl, Parity, SerialPort, Settings, StopBits};

use super::socket_pair;
use crate::host::Error;
use crate::time::BaudRate;

/// How long the thread takes at most to notice that it shall end.
const LOOK_MS: u32 = 100;

/// Longer than the longest telegram takes at the lowest rate.
const WRITE_TIMEOUT_MS: u32 = 1000;

/// A read waits this long until all it has room for has arrived: with room for one octet, for that.
const WAIT: CommTimeouts = CommTimeouts {
    read_interval_timeout: 0,
    read_total_timeout_multiplier: 0,
    read_total_timeout_constant: LOOK_MS,
    write_total_timeout_multiplier: 0,
    write_total_timeout_constant: WRITE_TIMEOUT_MS,
};

/// A read takes what has arrived and does not wait.
const AT_ONCE: CommTimeouts =
    CommTimeouts { read_interval_timeout: u32::MAX, read_total_timeout_constant: 0, ..WAIT };

/// An open port, of this process alone: Windows lets nobody else open it.
#[derive(Debug)]
pub(super) struct Com {
    port: SerialPort,
    arrived: TcpStream,
    end: Arc<AtomicBool>,
    reader: Option<JoinHandle<()>>,
}

impl Com {
    /// Opens `device` with 8 data bits and one stop bit.
    pub(super) fn open(device: &str, rate: BaudRate, parity: Parity) -> Result<Self, Error> {
        let not_open =
            |source: io::Error| Error::SerialOpen { device: device.into(), advice: advice(&source), source };
        let mut port =
            SerialPort::open(Path::new(device), |settings: Settings| Ok(settings)).map_err(not_open)?;
        set(&mut port, rate, parity).map_err(|source| Error::SerialSettings {
            device: device.into(),
            rate,
            source,
        })?;
        Self::start(port).map_err(not_open)
    }

    fn start(port: SerialPort) -> io::Result<Self> {
        port.set_windows_timeouts(&WAIT)?;
        // What arrived under other settings is noise.
        port.discard_buffers()?;
        let (arrived, tell) = socket_pair()?;
        arrived.set_nonblocking(true)?;
        let end = Arc::new(AtomicBool::new(false));
        let (reads, ends) = (port.try_clone()?, Arc::clone(&end));
        let reader =
            thread::Builder::new().name("serial".into()).spawn(move || forward(&reads, tell, &ends))?;
        Ok(Self { port, arrived, end, reader: Some(reader) })
    }

    /// What has arrived, without waiting; 0: the device is gone.
    pub(super) fn read(&self, buf: &mut [u8]) -> io::Result<usize> {
        (&self.arrived).read(buf)
    }

    /// Waits until the driver has taken the octets.
    pub(super) fn write(&self, octets: &[u8]) -> io::Result<usize> {
        match self.port.write(octets) {
            Err(error) if error.kind() == ErrorKind::TimedOut => Ok(0),
            outcome => outcome,
        }
    }

    /// What to sleep on until something arrives.
    pub(super) fn watch(&self) -> PollFd<'_> {
        PollFd::new(&self.arrived, PollFlags::IN)
    }

    /// What arrived at the rate before is forgotten, but for what the thread has in hand.
    pub(super) fn set_rate(&mut self, rate: BaudRate) -> io::Result<()> {
        let parity = self.port.get_configuration()?.get_parity()?;
        set(&mut self.port, rate, parity)?;
        self.port.discard_input_buffer()?;
        let mut octets = [0; 512];
        while matches!(self.read(&mut octets), Ok(count) if count > 0) {}
        Ok(())
    }
}

impl Drop for Com {
    fn drop(&mut self) {
        self.end.store(true, Ordering::SeqCst);
        if let Some(reader) = self.reader.take() {
            let _ = reader.join();
        }
    }
}

fn set(port: &mut SerialPort, rate: BaudRate, parity: Parity) -> io::Result<()> {
    let mut settings = port.get_configuration()?;
    settings.set_raw();
    settings.set_baud_rate(rate.bits_per_second())?;
    settings.set_char_size(CharSize::Bits8);
    settings.set_stop_bits(StopBits::One);
    settings.set_parity(parity);
    settings.set_flow_control(FlowControl::None);
    port.set_configuration(&settings)
}

/// Hands on what arrives until the port is gone or nobody wants it. That the socket closes says so.
fn forward(port: &SerialPort, mut tell: TcpStream, end: &AtomicBool) {
    let mut octets = [0; 512];
    while !end.load(Ordering::SeqCst) {
        let Ok(count) = arrivals(port, &mut octets) else { return };
        if tell.write_all(octets.get(..count).unwrap_or_default()).is_err() {
            return;
        }
    }
}

/// Waits a while for an octet, and takes what has come with it.
///
/// Timeouts for this in one read exist too (`MAXDWORD` twice); Wine has no such read.
fn arrivals(port: &SerialPort, octets: &mut [u8; 512]) -> io::Result<usize> {
    let [first, rest @ ..] = octets;
    port.set_windows_timeouts(&WAIT)?;
    let waited = read(port, core::slice::from_mut(first))?;
    if waited == 0 {
        return Ok(0);
    }
    port.set_windows_timeouts(&AT_ONCE)?;
    Ok(waited + read(port, rest)?)
}

/// 0: nothing within the time.
fn read(port: &SerialPort, octets: &mut [u8]) -> io::Result<usize> {
    match port.read(octets) {
        Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) => Ok(0),
        outcome => outcome,
    }
}

/// What a person can do about a port that does not open.
#[expect(
    clippy::wildcard_enum_match_arm,
    reason = "operating systems have many more errors than there is advice"
)]
fn advice(error: &io::Error) -> &'static str {
    match error.kind() {
        ErrorKind::NotFound => {
            "check the name, such as COM3, in the Device Manager, and that the adapter is plugged in"
        }
        ErrorKind::PermissionDenied => "it is in use by another program; end that one first",
        _ => "check the adapter",
    }
}
