//! Everything that touches an operating system: links, clocks, and the loop that runs drives on a line.
//!
//! ```text
//! master ──octets──▶ Link ──▶ run ──▶ Bus ──telegrams──▶ Device, dp::Station, … (any Participant)
//!        ◀─────────       ◀──     ◀──     ◀────────────
//! ```
//!
//! - [`Link`] moves octets. [`link::memory`] stays inside the process, [`link::pty`] is a pseudo-terminal that a
//!   master opens like a serial port, [`link::serial`] is an RS-485 port,
//!   [`link::tcp`] a port to which several programs connect. [`link::fault`] corrupts telegrams on any of them, and
//!   [`link::tap`] shows what passes. A master opens [`link::terminal`], [`link::tcp::Connection`], or a serial port.
//! - [`Clock`] tells the time: [`SystemClock`] runs, [`ManualClock`] stands until a test moves it.
//! - [`Bus`] puts many stations on one line, with the calling contract of one [`crate::devices::ag03::profibus::Device`].
//! - [`can`] is the same for CAN: a bus in memory, adapters over pseudo-terminal and TCP, and its own run loop.
//! - [`capture`] writes what passes to pcapng files and reads them (feature `capture`).
//! - [`StateDir`] keeps the images of units in files, each an `ImageFile`; what is [`Stored`] has such a
//!   file.
//! - [`run()`] connects the three until [`Stop`] is requested.
//!
//! A drive on an in-memory line, run by hand:
//!
//! ```
//! use profidrive::host::link::memory::Wire;
//! use profidrive::host::{Link, Received};
//!
//! let wire = Wire::new();
//! let (mut master, mut drive) = (wire.end(), wire.end());
//! master.send(&[0x10, 0x05, 0x02, 0x49, 0x50, 0x16])?;
//!
//! let mut buf = [0; 16];
//! assert_eq!(drive.receive(&mut buf)?, Received::Octets(6));
//! assert_eq!(master.receive(&mut buf)?, Received::Nothing, "nobody hears himself");
//! # Ok::<(), std::io::Error>(())
//! ```

use core::net::SocketAddr;
use core::time::Duration;
use std::io;
use std::path::PathBuf;

use thiserror::Error;

use crate::profibus::fdl::Address;
use crate::time::{BaudRate, Instant};

mod ag03;
mod bus;
mod by_hand;
pub mod can;
#[cfg(feature = "capture")]
pub mod capture;
mod clock;
mod device_file;
mod drive_image;
pub mod fault;
mod gsd_description;
mod gsd_station;
mod hexadecimal;
mod hosted_drive;
#[cfg(feature = "panel")]
pub(crate) mod inner_master;
pub mod link;
pub mod list;
mod lock;
mod participant;
mod ppo_drive;
mod profidrive4;
mod ranges;
pub(crate) mod reach;
mod refusals;
mod repeats;
mod reported;
mod run;
mod startup;
mod state_dir;
mod station_file;
mod stop;
mod stored;
#[cfg(all(test, feature = "parameters"))]
pub(crate) mod tests;
mod value_board;

pub(crate) use bus::StationErrors;
pub use bus::{Addresses, Bus, BusEvent, Evidence, LISTEN_TIME, LineHint, Presence, SlotTime};
pub use by_hand::ByHand;
pub use clock::{ManualClock, SystemClock};
#[cfg(feature = "eds")]
pub(crate) use device_file::eds_of_file;
pub(crate) use device_file::gsd_of_file;
pub(crate) use gsd_station::TimedAlarm;
pub use gsd_station::{GsdStation, OutputsAre, StationRecord, StationRecords};
pub(crate) use hexadecimal::octets_of_hex;
pub use hosted_drive::{Hosted, HostedDrive};
pub use participant::{Appearance, Participant, StationKind};
pub use ppo_drive::{HostedPpoDrive, PpoJudge};
pub use profidrive4::HostedProfidrive;
pub use reach::Reach;
pub use refusals::Refusals;
pub use run::run;
pub use startup::Startup;
pub use state_dir::{Disk, Images, StateDir, StateDirError};
pub use stop::Stop;
pub use stored::Stored;
pub use value_board::ValueBoard;

/// A byte transport to one line: telegram octets in and out, without framing.
///
/// No call but [`Link::wait`] blocks. An error is the end of the link (the device is gone, say), not a lost telegram.
pub trait Link {
    /// What has arrived, without waiting. Call it until it says [`Received::Nothing`]. What comes right after a
    /// [`Link::wait`] may be said after the next one only.
    ///
    /// # Errors
    /// The link no longer works.
    fn receive(&mut self, buf: &mut [u8]) -> io::Result<Received>;

    /// Sends one whole telegram. What nobody listens to is lost, as on a wire: that is no error.
    ///
    /// # Errors
    /// The link no longer works.
    fn send(&mut self, telegram: &[u8]) -> io::Result<()>;

    /// Sleeps until something may have arrived, `timeout` has passed (`None`: never) or `stop` is requested.
    ///
    /// May return early for no reason; the caller looks again with [`Link::receive`].
    ///
    /// # Errors
    /// The link no longer works.
    fn wait(&mut self, timeout: Option<Duration>, stop: &Stop) -> io::Result<()>;

    /// Sets the line to another rate. A link that cannot, as a pseudo-terminal cannot, keeps this answer.
    ///
    /// # Errors
    /// [`io::ErrorKind::Unsupported`]: no rate can be set. [`io::ErrorKind::InvalidInput`]: not this one, the line is as
    /// before. Others: the link no longer works.
    fn set_rate(&mut self, rate: BaudRate) -> io::Result<()> {
        let _ = rate;
        Err(io::ErrorKind::Unsupported.into())
    }

    /// The finest time that this link can show to the other side: a telegram that is due sooner than that is sent at
    /// once, since a sleep costs more than the time it would keep. Zero: every time.
    fn resolution(&self) -> Duration {
        Duration::ZERO
    }
}

/// [`Link::resolution`] where octets take no time and the kernel delivers them: it wakes a sleeper up to 50 us late (timer
/// slack).
pub(crate) const UNTRUE_RESOLUTION: Duration = Duration::from_micros(50);

impl<L: Link + ?Sized> Link for Box<L> {
    fn receive(&mut self, buf: &mut [u8]) -> io::Result<Received> {
        (**self).receive(buf)
    }
    fn send(&mut self, telegram: &[u8]) -> io::Result<()> {
        (**self).send(telegram)
    }
    fn wait(&mut self, timeout: Option<Duration>, stop: &Stop) -> io::Result<()> {
        (**self).wait(timeout, stop)
    }
    fn set_rate(&mut self, rate: BaudRate) -> io::Result<()> {
        (**self).set_rate(rate)
    }
    fn resolution(&self) -> Duration {
        (**self).resolution()
    }
}

/// What [`Link::receive`] found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Received {
    /// So many octets, at least one, were written to the front of the buffer.
    Octets(usize),
    /// So many octets, at least one, were written to the front of the buffer, and broke off: octets after them come from
    /// another and continue nothing.
    BrokenOff(usize),
    /// The master at the other end has gone. Octets after this one come from another: forget half telegrams and
    /// replies not yet sent.
    Reset,
    /// The master has set the line to this rate. Octets after this one have it.
    Rate(BaudRate),
    /// Nothing more for now.
    Nothing,
}

/// Where time comes from.
pub trait Clock {
    /// The time now. Never earlier than at the call before.
    fn now(&self) -> Instant;
}

/// Why drives cannot be put on a line, or the line failed. The cause, where there is one, is the error's source.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Error {
    /// Two stations of one bus want one address, or it is that of all.
    #[error("two drives have address {address}; give each drive its own")]
    AddressTaken {
        /// The address of both.
        address: Address,
    },
    /// The operating system gives no pseudo-terminal.
    #[error("cannot open a pseudo-terminal")]
    Pty {
        /// What it says.
        source: io::Error,
    },
    /// The name wanted for the terminal belongs to something else.
    #[error("{} is {found}, which is not replaced; {} or choose another path", path.display(), found.cure())]
    PathTaken {
        /// The name wanted.
        path: PathBuf,
        /// What was found there.
        found: PathOccupant,
    },
    /// The symbolic link to the terminal cannot be made.
    #[error("cannot create the symbolic link {} (choose a path in a directory that this user can write)", path.display())]
    Symlink {
        /// The name wanted.
        path: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// The symbolic link leads to a terminal that an emulator had. It was killed, and whoever has the terminal now is a
    /// stranger.
    #[error(
        "{} was left by an emulator that has ended; start it again with 'profidrive emulate --link pty:{}'",
        path.display(), path.display()
    )]
    LinkLeftBehind {
        /// The link.
        path: PathBuf,
    },
    /// The serial device cannot be opened.
    #[error("cannot open serial device {device} ({advice})")]
    SerialOpen {
        /// Its path.
        device: String,
        /// What to do.
        advice: &'static str,
        /// What the operating system says.
        source: io::Error,
    },
    /// The serial device is open but refuses 8 data bits, even parity, one stop bit at this rate.
    #[error("serial device {device} does not take {rate}, 8 data bits, even parity, 1 stop bit")]
    SerialSettings {
        /// Its path.
        device: String,
        /// The rate wanted.
        rate: BaudRate,
        /// What the operating system says.
        source: io::Error,
    },
    /// The terminal of another process cannot be opened.
    #[error("cannot open terminal {} ({advice})", path.display())]
    TerminalOpen {
        /// Its path.
        path: PathBuf,
        /// What to do.
        advice: &'static str,
        /// What the operating system says.
        source: io::Error,
    },
    /// Nobody answers at the TCP port of another process.
    #[error("cannot connect to tcp:{place} ({})", reach::connect_advice(source))]
    TcpConnect {
        /// Host and port wanted.
        place: String,
        /// What the operating system says.
        source: io::Error,
    },
    /// The TCP port cannot be opened.
    #[error("cannot listen at tcp:{place} ({})", reach::advice(source))]
    Tcp {
        /// Host and port wanted.
        place: String,
        /// What the operating system says.
        source: io::Error,
    },
    /// Others than this machine could connect to the TCP port, and were not invited.
    #[error("tcp:{place} is {address}, where others than this machine can connect and command the drives")]
    TcpReach {
        /// Host and port wanted.
        place: String,
        /// The address that is not of this machine alone.
        address: SocketAddr,
    },
    /// The CAN interface cannot be opened.
    #[error("cannot open the CAN interface {name} ('ip link show {name}' says whether it is there and up)")]
    CanInterface {
        /// Its name.
        name: String,
        /// What the operating system says.
        source: io::Error,
    },
    /// The link failed while drives were running on it.
    #[error("the link failed")]
    Link {
        /// What the operating system says.
        source: io::Error,
    },
}

/// What occupies a path that was wanted for a symbolic link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PathOccupant {
    /// A symbolic link to something that exists, for example the terminal of another running emulator.
    LinkInUse,
    /// A directory.
    Directory,
    /// A file or device.
    File,
}

impl PathOccupant {
    /// What helps, as the middle of a sentence.
    const fn cure(self) -> &'static str {
        match self {
            Self::LinkInUse => "end the program that has it, remove it,",
            Self::Directory | Self::File => "remove it",
        }
    }
}

impl core::fmt::Display for PathOccupant {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::LinkInUse => "a symbolic link that is in use, perhaps that of another emulator",
            Self::Directory => "a directory",
            Self::File => "a file",
        })
    }
}
