//! A pseudo-terminal that a master opens like a serial port.
//!
//! The kernel tells little about who is at the other end, so this file adds what a line needs:
//!
//! - **The slave side stays open here as well.** Without that, the terminal hangs up whenever no master has it open:
//!   `poll` then reports the hang-up at once, every time, and a loop either spins or looks only now and then. With it,
//!   an idle line sleeps until a master writes, and the octets in both queues can be thrown away.
//! - **`inotify` tells who comes and goes**: it wakes the sleeper when a master opens or closes the terminal, and
//!   tells in which order a master wrote and closed. Openings are counted; the kernel merges equal events, so the
//!   directory is watched as well and its events lie between those of the terminal. The price: a terminal opened or
//!   closed by anybody on the machine wakes this process for some microseconds.
//! - **When the last master has closed the terminal**, what it did not read is thrown away, its exclusive lock is lifted
//!   (`TIOCEXCL` outlives a master that was killed), the settings go back to raw unless the next one opens it at once,
//!   and [`Link::receive`] says [`Received::Reset`] once the octets it wrote are read. If the next one has opened the terminal by then, octets
//!   of the first that are still unread are thrown away as well.
//!
//! What follows from this: a master is never hung up on while this process lives, and two programs that have the
//! terminal open at the same time are one master. If a master writes and closes, and the next opens and writes, all
//! before this process runs once (some ten microseconds on an idle machine), nobody can tell their octets apart: they
//! lie in one queue. Then all of them come after the reset, and finding the first telegram of the second among them
//! is left to the framer.
//!
//! A pseudo-terminal has no rate, parity or timing, but it keeps the rate that the master sets: [`Pty::speed`].
//!
//! It does not keep the parity bit. Debian's C library then lets `tcsetattr` fail with EINVAL if that bit was all a
//! program wanted to change, so a pyserial program with `parity='E'` could open the terminal once and never again.
//! Therefore a flag without effect in raw mode, ECHONL, is set here and set again soon after a program has cleared
//! it, as all do on their way to raw mode: that is a change. Only a program that closes the terminal and opens it
//! with equal settings within some ten microseconds still gets EINVAL.

use core::mem::MaybeUninit;
use core::time::Duration;
use std::ffi::OsString;
use std::io;
use std::os::fd::OwnedFd;
use std::os::unix::ffi::OsStringExt;
use std::path::{Path, PathBuf};

use rustix::event::{PollFd, PollFlags};
use rustix::fs::{Mode, OFlags, inotify};
use rustix::io::Errno;
use rustix::pty::OpenptFlags;
use rustix::termios::{LocalModes, OptionalActions, QueueSelector, Termios};

use super::symlink::{OldLink, Symlink};
use super::{Look, Sleep};
use crate::host::{Error, Link, Received, Stop, UNTRUE_RESOLUTION};
use crate::time::BaudRate;

/// The speed of a terminal that no master has set: none of PROFIBUS.
const UNSET_SPEED: u32 = 115_200;

/// After a master has opened or closed the terminal, its settings are looked at so often, at this interval: there is
/// no event when a master sets them, usually within milliseconds after it has opened. And a master may close and open
/// at once; settings restored between its own and its reading them back would be an error to it.
const SETTLING_LOOKS: u32 = 16;
const SETTLING_INTERVAL: Duration = Duration::from_millis(2);

/// A master that has the terminal open for longer changes its settings seldom: they are looked at no more often than so.
const SETTINGS_INTERVAL: Duration = Duration::from_millis(50);

/// So many events are no more than what is read at once.
const FEW_EVENTS: u32 = 16;

/// A pseudo-terminal with the drives at its master side. The DP master opens the slave side.
#[derive(Debug)]
pub struct Pty {
    /// First, so that the name goes before the terminal it leads to.
    symlink: Option<Symlink>,
    /// The drives' side, without blocking.
    line: OwnedFd,
    /// The side of the DP master, kept open.
    held: OwnedFd,
    watch: OwnedFd,
    /// Whether the master has sent something.
    sent: Look,
    /// Whether somebody has opened, written or closed the terminal.
    stirred: Look,
    /// What `watch` calls the terminal.
    watched: i32,
    terminal: PathBuf,
    raw: Termios,
    /// How often the terminal is open, not counting `held`.
    openings: u32,
    /// The DP master wrote since the queue towards the drives was last seen empty.
    unread: bool,
    /// How often to look again at the settings.
    settling: u32,
    /// When they were looked at last.
    settings_seen: std::time::Instant,
    /// Somebody has opened the terminal since the settings were ours.
    set: bool,
    reset: Option<Reset>,
    follows_rate: bool,
    rate: Option<BaudRate>,
    /// One that the master has set, and nobody knows yet.
    new_rate: Option<BaudRate>,
    lost: u64,
    loss_reported: bool,
}

/// A reset that is still to be reported.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Reset {
    /// Before any octet.
    Now,
    /// When the octets that the master left in the queue are read.
    WhenRead,
}

impl Pty {
    /// Opens a terminal, raw from the start, and makes `path` a symbolic link to it.
    ///
    /// The link is created in one step, replaces only a dangling link, and is removed when the `Pty` is dropped.
    ///
    /// # Errors
    /// [`Error::Pty`], [`Error::PathTaken`] or [`Error::Symlink`]; then nothing is left behind.
    pub fn open(path: Option<&Path>) -> Result<Self, Error> {
        Self::open_at(path, OldLink::Keep)
    }

    /// As [`Pty::open`]; a symbolic link that is at `path` already is replaced wherever it leads to.
    ///
    /// # Errors
    /// As [`Pty::open`].
    pub(crate) fn open_replacing(path: Option<&Path>) -> Result<Self, Error> {
        Self::open_at(path, OldLink::Replace)
    }

    fn open_at(path: Option<&Path>, old: OldLink) -> Result<Self, Error> {
        let mut pty = Self::open_terminal().map_err(|source| Error::Pty { source })?;
        pty.symlink = path.map(|path| Symlink::create(path, &pty.terminal, old)).transpose()?;
        Ok(pty)
    }

    fn open_terminal() -> io::Result<Self> {
        let line = rustix::pty::openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)?;
        rustix::io::ioctl_fionbio(&line, true)?;
        rustix::pty::grantpt(&line)?;
        let terminal = rustix::pty::ptsname(&line, Vec::new())?;
        let terminal = PathBuf::from(OsString::from_vec(terminal.into_bytes()));
        // Watched before it can be opened: no opening is missed, and the first one seen is that of `held`.
        let watch = inotify::init(inotify::CreateFlags::CLOEXEC | inotify::CreateFlags::NONBLOCK)?;
        let comes_and_goes = inotify::WatchFlags::OPEN | inotify::WatchFlags::CLOSE;
        let watched = inotify::add_watch(&watch, &terminal, comes_and_goes | inotify::WatchFlags::MODIFY)?;
        // The kernel merges an event with an equal one right before it, and then two openings count as one. Events
        // of the directory, which come with each of the terminal's, keep those apart.
        if let Some(directory) = terminal.parent() {
            inotify::add_watch(&watch, directory, comes_and_goes)?;
        }
        rustix::pty::unlockpt(&line)?;
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
        let held = rustix::fs::open(&terminal, flags, Mode::empty())?;

        let mut raw = rustix::termios::tcgetattr(&held)?;
        raw.make_raw();
        raw.local_modes |= LocalModes::ECHONL;
        raw.set_speed(UNSET_SPEED)?;
        rustix::termios::tcsetattr(&held, OptionalActions::Now, &raw)?;

        let mut pty = Self {
            symlink: None,
            line,
            held,
            watch,
            // For what has come, and whether that was all; who is there, before a reply as well.
            sent: Look::new(2),
            stirred: Look::new(3),
            watched,
            terminal,
            raw,
            openings: 0,
            unread: false,
            settling: 0,
            settings_seen: std::time::Instant::now(),
            set: false,
            reset: None,
            follows_rate: false,
            rate: None,
            new_rate: None,
            lost: 0,
            loss_reported: false,
        };
        pty.observe()?;
        pty.openings = pty.openings.saturating_sub(1);
        pty.set = pty.openings > 0;
        pty.settling = 0;
        Ok(pty)
    }

    /// Whether [`Link::receive`] says [`Received::Rate`] when the master sets a rate of PROFIBUS-DP. At first not.
    pub fn follow_rate(&mut self, follow: bool) {
        self.follows_rate = follow;
    }

    /// What a master opens: the symbolic link if there is one, else the terminal itself (`/dev/pts/N`).
    pub fn path(&self) -> &Path {
        self.symlink.as_ref().map_or(&self.terminal, Symlink::path)
    }

    /// The speed the master has set, in bit/s; `None` if it has set none.
    ///
    /// # Errors
    /// The terminal no longer works.
    pub fn speed(&self) -> io::Result<Option<u32>> {
        let speed = rustix::termios::tcgetattr(&self.held)?.output_speed();
        Ok(Some(speed).filter(|&speed| speed != UNSET_SPEED))
    }

    /// How many octets were sent that no master had room for.
    pub fn lost(&self) -> u64 {
        self.lost
    }

    /// Takes note of who has opened, written and closed the terminal since the last look, and of its settings.
    fn observe(&mut self) -> io::Result<()> {
        let wrote = self.stirred.asks() && self.read_events()?;
        if self.settling > 0 || wrote && self.settings_seen.elapsed() >= SETTINGS_INTERVAL {
            self.look_at_settings()?;
        }
        if self.openings == 0 && self.set && self.settling == 0 {
            rustix::termios::tcsetattr(&self.held, OptionalActions::Now, &self.raw)?;
            self.set = false;
        }
        Ok(())
    }

    /// Who has opened, written and closed the terminal. Whether anybody wrote.
    fn read_events(&mut self) -> io::Result<bool> {
        use inotify::ReadFlags;

        let mut wrote = false;
        // Whether the master changed, and whether the one before has left octets in the queue.
        let mut changed = false;
        let mut left_octets = self.reset == Some(Reset::WhenRead);
        let mut buf = [MaybeUninit::uninit(); 1024];
        let mut events = inotify::Reader::new(&self.watch, &mut buf);
        let mut taken = 0;
        // A few that leave room in the buffer were all there are.
        while taken == 0 || taken >= FEW_EVENTS || !events.is_buffer_empty() {
            taken += 1;
            let event = match events.next() {
                // An overflow of the queue belongs to no watch.
                Ok(event) if event.wd() == self.watched || event.wd() == -1 => event.events(),
                Ok(_) => continue,
                Err(Errno::AGAIN) => break,
                Err(Errno::INTR) => continue,
                Err(error) => return Err(error.into()),
            };
            if event.contains(ReadFlags::OPEN) {
                self.openings = self.openings.saturating_add(1);
                self.settling = SETTLING_LOOKS;
                self.set = true;
                changed |= left_octets;
            }
            if event.contains(ReadFlags::MODIFY) {
                self.unread = true;
                wrote = true;
            }
            let mut gone = false;
            if event.intersects(ReadFlags::CLOSE_WRITE | ReadFlags::CLOSE_NOWRITE) {
                self.openings = self.openings.saturating_sub(1);
                gone = self.openings == 0;
            }
            // Thousands came and went since the last look; whoever is there now is taken for one new master.
            if event.contains(ReadFlags::QUEUE_OVERFLOW) {
                self.openings = 1;
                gone = true;
            }
            if gone {
                changed = true;
                left_octets |= core::mem::take(&mut self.unread);
            }
        }
        if changed {
            self.change_master(left_octets)?;
        }
        self.stirred.is_empty();
        if wrote {
            // Before it went, perhaps: its octets come before the reset.
            self.sent.has_something();
        }
        Ok(wrote)
    }

    /// Takes note of the rate, and sets the flag without effect again if the master has cleared it.
    fn look_at_settings(&mut self) -> io::Result<()> {
        self.settings_seen = std::time::Instant::now();
        let mut settings = rustix::termios::tcgetattr(&self.held)?;
        let speed = settings.output_speed();
        if self.follows_rate
            && self.openings > 0
            && let Ok(rate) = BaudRate::from_bits_per_second(speed)
        {
            self.new_rate = Some(rate).filter(|_| self.rate != Some(rate));
        }
        if !settings.local_modes.contains(LocalModes::ECHONL) {
            settings.local_modes |= LocalModes::ECHONL;
            rustix::termios::tcsetattr(&self.held, OptionalActions::Now, &settings)?;
        }
        Ok(())
    }

    /// Puts the terminal in order after a master has gone, and perhaps the next has come.
    fn change_master(&mut self, left_octets: bool) -> io::Result<()> {
        // Nothing was sent since it went, so whatever is queued for a master is not for the next one.
        self.discard_output()?;
        rustix::termios::ioctl_tiocnxcl(&self.held)?;
        self.settling = SETTLING_LOOKS;
        self.loss_reported = false;
        self.reset = Some(if left_octets && self.openings == 0 { Reset::WhenRead } else { Reset::Now });
        // The next one is there and has not written: the queue holds octets of the first only.
        if left_octets && self.openings > 0 && !self.unread {
            let mut octets = [0; 512];
            while self.read(&mut octets)? > 0 {}
        }
        Ok(())
    }

    /// Throws away what the master has not read.
    pub(in crate::host) fn discard_output(&self) -> io::Result<()> {
        // First what the kernel has not handed over to the terminal yet, then what the terminal holds.
        rustix::termios::tcflush(&self.line, QueueSelector::OFlush)?;
        Ok(rustix::termios::tcflush(&self.held, QueueSelector::IFlush)?)
    }

    /// Writes as many octets as there is room for, and says how many. `None`: nobody is there, or somebody who has not
    /// asked for this.
    pub(in crate::host) fn write(&mut self, octets: &[u8]) -> io::Result<Option<usize>> {
        self.observe()?;
        if self.openings == 0 || self.reset.is_some() {
            return Ok(None);
        }
        match rustix::io::write(&self.line, octets) {
            Ok(written) => Ok(Some(written)),
            Err(Errno::AGAIN | Errno::INTR) => Ok(Some(0)),
            Err(error) => Err(error.into()),
        }
    }

    /// What to sleep on until the master comes or goes; with `reads` until it has sent something, with `full` until
    /// there is room again.
    pub(in crate::host) fn watch<'a>(&'a self, reads: bool, full: bool, sleep: &mut Sleep<'a>) {
        let mut flags = PollFlags::empty();
        flags.set(PollFlags::IN, reads);
        flags.set(PollFlags::OUT, full);
        sleep.or(PollFd::new(&self.line, flags), &self.sent);
        sleep.or(PollFd::new(&self.watch, PollFlags::IN), &self.stirred);
    }

    /// How long a sleep may last at most; `None`: for ever.
    pub(in crate::host) fn patience(&mut self) -> Option<Duration> {
        if self.reset.is_some() {
            return Some(Duration::ZERO);
        }
        let looked_for = (self.settling > 0).then_some(SETTLING_INTERVAL);
        self.settling = self.settling.saturating_sub(1);
        looked_for
    }

    /// Octets from the master, 0 if there are none.
    fn read(&mut self, buf: &mut [u8]) -> io::Result<usize> {
        loop {
            match rustix::io::read(&self.line, &mut *buf) {
                Ok(count) => {
                    if count < buf.len() {
                        self.sent.is_empty();
                        self.unread = false;
                    }
                    return Ok(count);
                }
                Err(Errno::AGAIN) => {
                    self.sent.is_empty();
                    self.unread = false;
                    return Ok(0);
                }
                Err(Errno::INTR) => {}
                Err(error) => return Err(error.into()),
            }
        }
    }
}

impl Link for Pty {
    fn receive(&mut self, buf: &mut [u8]) -> io::Result<Received> {
        self.observe()?;
        if self.reset == Some(Reset::Now) {
            self.reset = None;
            return Ok(Received::Reset);
        }
        if let Some(rate) = self.new_rate.take() {
            self.rate = Some(rate);
            return Ok(Received::Rate(rate));
        }
        let count = if self.sent.asks() { self.read(buf)? } else { 0 };
        Ok(match count {
            0 if self.reset.take().is_some() => Received::Reset,
            0 => Received::Nothing,
            count => Received::Octets(count),
        })
    }

    /// See [`Link::send`]. What a master does not read is lost when the kernel's queue is full, see [`Pty::lost`].
    fn send(&mut self, telegram: &[u8]) -> io::Result<()> {
        let written = self.write(telegram)?;
        let lost = telegram.len().saturating_sub(written.unwrap_or(0));
        self.lost = self.lost.saturating_add(lost as u64);
        if lost > 0 && written.is_some() && !self.loss_reported {
            self.loss_reported = true;
            tracing::warn!("the master does not read {}: octets are lost", self.terminal.display());
        }
        Ok(())
    }

    fn wait(&mut self, timeout: Option<Duration>, stop: &Stop) -> io::Result<()> {
        let timeout = [timeout, self.patience()].into_iter().flatten().min();
        let mut sleep = Sleep::until(stop);
        self.watch(true, false, &mut sleep);
        sleep.sleep(timeout)
    }

    fn resolution(&self) -> Duration {
        UNTRUE_RESOLUTION
    }
}
