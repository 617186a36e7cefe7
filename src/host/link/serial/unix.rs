//! A serial device of Unix.

use std::fs::{self, File, OpenOptions};
use std::io;
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

use rustix::event::{PollFd, PollFlags};
use rustix::fs::OFlags;
use rustix::io::Errno;
use rustix::termios::{InputModes, OptionalActions};
use serialport::{ClearBuffer, DataBits, FlowControl, Parity, SerialPort, StopBits, TTYPort};

use crate::host::Error;
use crate::time::BaudRate;

/// The device, open.
#[derive(Debug)]
pub(super) struct Port {
    /// The device once more, for `poll` and for reads and writes that never block: `serialport` offers neither
    /// without its raw descriptor.
    file: File,
    /// Holds the settings and the exclusive lock.
    port: TTYPort,
}

impl Port {
    pub(super) fn open(device: &str, rate: BaudRate) -> Result<Self, Error> {
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

    /// Does what makes a reply come in time, where the system can.
    pub(super) fn prepare(&self, device: &str) {
        self.switch_direction(device);
        shorten_latency(device);
    }

    /// What has arrived, without waiting; 0: the device is gone.
    pub(super) fn read(&self, buf: &mut [u8]) -> io::Result<usize> {
        Ok(rustix::io::read(&self.file, buf)?)
    }

    /// Takes as many octets as there is room for.
    pub(super) fn write(&self, octets: &[u8]) -> io::Result<usize> {
        Ok(rustix::io::write(&self.file, octets)?)
    }

    /// What to sleep on until something arrives.
    pub(super) fn watch(&self) -> PollFd<'_> {
        PollFd::new(&self.file, PollFlags::IN)
    }

    /// What arrived at the rate before is forgotten.
    pub(super) fn set_rate(&mut self, rate: BaudRate) -> io::Result<()> {
        self.port.set_baud_rate(rate.bits_per_second())?;
        Ok(self.port.clear(ClearBuffer::Input)?)
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
            "{device} holds octets back for {millis} ms: longer than the usual slot times. Set it to 1 ms, as root: echo 1 > {} ({error})",
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
