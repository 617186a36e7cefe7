//! An RS-485 serial port.
//!
//! The port is set to 8 data bits, even parity, one stop bit (`dp-v0.md` 1) and belongs to this process alone. Beyond
//! that:
//!
//! - **Direction**: where the kernel switches an RS-485 driver by itself (`TIOCSRS485`), it is told to. Elsewhere the
//!   adapter must do it.
//! - **Latency**: the latency timer of an FTDI adapter is set to 1 ms if this user may write it. Else a warning says how.
//! - **Echo**: some adapters hear what they send. The octets sent last are dropped if they are the next ones heard.
//! - **Unplugging** ends the link, or with [`Serial::reopen`] is logged, and the device is opened again when it is back.
//!
//! A character with a wrong parity or stop bit is dropped by the kernel, and the telegram around it fails its checks. `docs/links.md`
//! says what can be reached with which adapter.

use core::time::Duration;
use std::collections::VecDeque;
use std::fs::{self, File, OpenOptions};
use std::io;
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::string::String;

use rustix::event::{PollFd, PollFlags};
use rustix::fs::OFlags;
use rustix::io::Errno;
use rustix::termios::{InputModes, OptionalActions};
use serialport::{ClearBuffer, DataBits, FlowControl, Parity, SerialPort, StopBits, TTYPort};

use super::poll_readable;
use crate::host::{Clock, Error, Link, Received, Stop, SystemClock};
use crate::time::{BaudRate, Instant};

mod echo;

use echo::Echo;

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

/// The device, open.
#[derive(Debug)]
struct Port {
    /// The device once more, for `poll` and for reads and writes that never block: `serialport` offers neither
    /// without its raw descriptor.
    file: File,
    /// Holds the settings and the exclusive lock.
    port: TTYPort,
}

impl Serial {
    /// Opens `device` (`/dev/ttyUSB0`, say) at `rate` for this process alone.
    ///
    /// # Errors
    /// [`Error::SerialOpen`], [`Error::SerialSettings`].
    pub fn open(device: &str, rate: BaudRate) -> Result<Self, Error> {
        let port = Port::open(device, rate)?;
        port.switch_direction(device);
        shorten_latency(device);
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
                port.switch_direction(&self.device);
                shorten_latency(&self.device);
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
        match rustix::io::read(&port.file, &mut buf) {
            Ok(0) => {
                self.unplugged(io::Error::new(io::ErrorKind::NotConnected, "the serial device is gone"))?;
                Ok(false)
            }
            Ok(count) => {
                self.echo.hear(buf.get(..count).unwrap_or_default(), &mut self.heard);
                Ok(true)
            }
            Err(Errno::AGAIN) => Ok(false),
            Err(Errno::INTR) => Ok(true),
            Err(error) => self.unplugged(error.into()).map(|()| false),
        }
    }
}

impl Port {
    fn open(device: &str, rate: BaudRate) -> Result<Self, Error> {
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
            .map_err(|error| match error.kind() {
                // Root is not kept out by TIOCEXCL, but by the lock of `serialport`.
                serialport::ErrorKind::NoDevice => not_open(Errno::BUSY.into()),
                serialport::ErrorKind::InvalidInput
                | serialport::ErrorKind::Unknown
                | serialport::ErrorKind::Io(_) => refused(error),
            })?;
        // What arrived under other settings is noise.
        port.clear(ClearBuffer::All).map_err(refused)?;
        drop_bad_characters(&file).map_err(|error| refused(io::Error::from(error).into()))?;
        Ok(Self { file, port })
    }

    /// Lets the kernel switch the driver of an RS-485 port, where it can.
    #[cfg(target_os = "linux")]
    fn switch_direction(&self, device: &str) {
        use serial2::rs4xx::Rs485Config;
        use std::os::fd::OwnedFd;

        let set = self.file.try_clone().and_then(|file| {
            let port = serial2::SerialPort::from(OwnedFd::from(file));
            port.set_rs4xx_mode(Rs485Config::new())
        });
        match set {
            Ok(()) => tracing::info!("{device}: the kernel switches the direction (RS-485)"),
            Err(error) => tracing::debug!("{device}: the adapter must switch the direction itself: {error}"),
        }
    }

    #[cfg(not(target_os = "linux"))]
    fn switch_direction(&self, device: &str) {
        tracing::debug!("{device}: the adapter must switch the direction itself");
    }
}

/// Has the kernel drop characters with a wrong parity or stop bit, which it would else hand over as 00: a telegram
/// that lacks one is refused, a telegram in which 00 was damaged would not be.
fn drop_bad_characters(file: &File) -> rustix::io::Result<()> {
    let mut settings = rustix::termios::tcgetattr(file)?;
    settings.input_modes |= InputModes::INPCK | InputModes::IGNPAR;
    rustix::termios::tcsetattr(file, OptionalActions::Now, &settings)
}

/// Sets the latency timer of an FTDI adapter to 1 ms.
fn shorten_latency(device: &str) {
    let Some(timer) = latency_timer(device) else {
        return;
    };
    let Some(millis) = fs::read_to_string(&timer).ok().and_then(|text| text.trim().parse::<u32>().ok())
    else {
        return;
    };
    if millis <= 1 {
        return;
    }
    match fs::write(&timer, "1") {
        Ok(()) => tracing::info!("{device}: latency timer set from {millis} ms to 1 ms"),
        Err(error) => tracing::warn!(
            "{device} holds octets back for {millis} ms: no usual slot time lasts that long. As root: echo 1 > {} ({error})",
            timer.display()
        ),
    }
}

/// Where the kernel shows the latency timer of a device that has one.
fn latency_timer(device: &str) -> Option<PathBuf> {
    let device = fs::canonicalize(device).ok()?;
    let timer = Path::new("/sys/class/tty").join(device.file_name()?).join("device/latency_timer");
    timer.exists().then_some(timer)
}

/// What a person can do about a device that does not open.
fn advice(error: &io::Error) -> &'static str {
    match Errno::from_io_error(error) {
        Some(Errno::NOENT) => "check the name and that the adapter is plugged in",
        Some(Errno::ACCESS | Errno::PERM) => "add your user to the group that owns it, often dialout",
        Some(Errno::BUSY) => "it is in use by another program; end that one first",
        Some(Errno::NOTTY | Errno::ISDIR) => "name a serial device such as /dev/ttyUSB0",
        _ => "check the adapter",
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
            State::Open(port) => rustix::io::write(&port.file, telegram),
            State::Gone { .. } => Ok(0),
        };
        let sent = match written {
            Ok(sent) => sent,
            Err(Errno::AGAIN | Errno::INTR) => 0,
            Err(error) => {
                self.unplugged(error.into())?;
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
            State::Open(port) => {
                poll_readable(&mut [PollFd::new(&port.file, PollFlags::IN), stopped], timeout)
            }
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
        if let State::Open(Port { port, .. }) = &mut self.port {
            port.set_baud_rate(rate.bits_per_second())?;
            port.clear(ClearBuffer::Input)?;
        }
        Ok(())
    }
}
