//! A terminal that somebody else has opened the other side of, for a master: what `profidrive emulate` names when it is
//! ready (`/dev/pts/N`, or the symbolic link to it).
//!
//! The counterpart of [`pty`](super::pty), which makes such a terminal. It is set to raw mode and to the rate of the
//! line, which an emulator may follow; parity and stop bit mean nothing here. A real port wants
//! `link::serial::Serial` (feature `serial`).

use core::time::Duration;
use std::fs::{File, OpenOptions};
use std::io;
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;

use rustix::event::{PollFd, PollFlags};
use rustix::fs::OFlags;
use rustix::io::Errno;
use rustix::termios::{OptionalActions, QueueSelector};

use super::poll_readable;
use crate::host::lock::locked;
use crate::host::{Error, Link, Received, Stop};
use crate::time::BaudRate;

/// An open terminal.
#[derive(Debug)]
pub struct Terminal {
    file: File,
    lost: u64,
}

impl Terminal {
    /// Opens the terminal at `path` for this process alone, raw and at `rate`. What was waiting there is dropped.
    ///
    /// Another `Terminal` is kept out by a lock (`flock`) that ends with this one or its process, other programs by
    /// `TIOCEXCL`, which root may ignore.
    ///
    /// # Errors
    /// [`Error::TerminalOpen`], also if another program has it open. [`Error::LinkLeftBehind`].
    pub fn open(path: &Path, rate: BaudRate) -> Result<Self, Error> {
        #[cfg(target_os = "linux")]
        if super::symlink::Symlink::is_left_behind(path) {
            return Err(Error::LinkLeftBehind { path: path.to_path_buf() });
        }
        let failed = |source: io::Error| Error::TerminalOpen {
            path: path.to_path_buf(),
            advice: advice(&source),
            source,
        };
        let flags = OFlags::NOCTTY | OFlags::NONBLOCK;
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .custom_flags(flags.bits().cast_signed())
            .open(path)
            .map_err(failed)?;
        prepare(&file, rate).map_err(failed)?;
        Ok(Self { file, lost: 0 })
    }

    /// How many octets were sent that the terminal had no room for.
    pub fn lost(&self) -> u64 {
        self.lost
    }
}

fn prepare(file: &File, rate: BaudRate) -> io::Result<()> {
    // TIOCEXCL does not stop root. This lock ends with the process, however that ends.
    if !locked(file)? {
        return Err(Errno::BUSY.into());
    }
    let mut settings = rustix::termios::tcgetattr(file)?;
    rustix::termios::ioctl_tiocexcl(file)?;
    settings.make_raw();
    settings.set_speed(rate.bits_per_second())?;
    rustix::termios::tcsetattr(file, OptionalActions::Now, &settings)?;
    Ok(rustix::termios::tcflush(file, QueueSelector::IFlush)?)
}

/// What a person can do about a terminal that does not open.
fn advice(error: &io::Error) -> &'static str {
    match Errno::from_io_error(error) {
        Some(Errno::NOENT) => "check the name, that the adapter is plugged in or the emulator runs",
        Some(Errno::ACCESS | Errno::PERM) => "it belongs to another user",
        Some(Errno::BUSY) => "it is in use by another program; end that one first",
        Some(Errno::NOTTY | Errno::ISDIR | Errno::NXIO) => {
            "name the terminal that 'profidrive emulate' prints as link="
        }
        _ => "check that the emulator runs",
    }
}

impl Drop for Terminal {
    /// Whoever holds the other side lifts this as well, but later than the next one may open the terminal.
    fn drop(&mut self) {
        let _ = rustix::termios::ioctl_tiocnxcl(&self.file);
    }
}

impl Link for Terminal {
    fn receive(&mut self, buf: &mut [u8]) -> io::Result<Received> {
        loop {
            return match rustix::io::read(&self.file, &mut *buf) {
                Ok(0) => Err(io::Error::new(io::ErrorKind::NotConnected, "the other side is closed")),
                Ok(count) => Ok(Received::Octets(count)),
                Err(Errno::AGAIN) => Ok(Received::Nothing),
                Err(Errno::INTR) => continue,
                Err(Errno::IO) => {
                    Err(io::Error::new(io::ErrorKind::NotConnected, "the other side is closed"))
                }
                Err(error) => Err(error.into()),
            };
        }
    }

    /// See [`Link::send`]. What the terminal has no room for is lost, see [`Terminal::lost`].
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
        poll_readable(
            &mut [PollFd::new(&self.file, PollFlags::IN), PollFd::new(stop, PollFlags::IN)],
            timeout,
        )
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {

    use super::*;
    use crate::host::link::pty::Pty;

    #[test]
    fn octets_pass_in_both_directions_and_the_other_side_sees_the_rate() {
        let mut drives = Pty::open(None).unwrap();
        drives.follow_rate(true);
        let mut master = Terminal::open(drives.path(), BaudRate::K1500).unwrap();
        master.send(&[0x10, 0x0A, 0x03, 0x16]).unwrap();
        let mut buf = [0; 8];
        assert_eq!(drives.receive(&mut buf).unwrap(), Received::Rate(BaudRate::K1500));
        assert_eq!(drives.receive(&mut buf).unwrap(), Received::Octets(4));
        assert_eq!(buf[..4], [0x10, 0x0A, 0x03, 0x16]);
        drives.send(&[0xE5, 0x11, 0x04]).unwrap();
        master.wait(None, &Stop::new().unwrap()).unwrap();
        assert_eq!(master.receive(&mut buf).unwrap(), Received::Octets(3));
        assert_eq!(buf[..3], [0xE5, 0x11, 0x04], "no control character means anything");
        assert_eq!((master.receive(&mut buf).unwrap(), master.lost()), (Received::Nothing, 0));
    }

    #[test]
    fn a_closed_line_is_an_error() {
        let drives = Pty::open(None).unwrap();
        let mut master = Terminal::open(drives.path(), BaudRate::K500).unwrap();
        drop(drives);
        assert_eq!(master.receive(&mut [0; 8]).unwrap_err().kind(), io::ErrorKind::NotConnected);
    }

    #[test]
    fn a_terminal_is_for_one_program_at_a_time() {
        let drives = Pty::open(None).unwrap();
        let first = Terminal::open(drives.path(), BaudRate::K500).unwrap();
        let error = Terminal::open(drives.path(), BaudRate::K500).unwrap_err().to_string();
        assert!(error.contains("in use by another program"), "{error}");
        drop(first);
        Terminal::open(drives.path(), BaudRate::K500).unwrap();
    }

    #[test]
    fn what_is_no_terminal_is_refused_with_advice() {
        for (path, says) in [
            ("/dev/pts/no-such-terminal", "check the name"),
            ("/dev/null", "name the terminal that 'profidrive emulate' prints"),
            ("/tmp", "name the terminal"),
        ] {
            let error = Terminal::open(Path::new(path), BaudRate::K500).unwrap_err().to_string();
            assert!(error.contains(says), "{error}");
        }
    }
}
