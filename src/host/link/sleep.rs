//! Sleeping on descriptors, and what the sleep saw there.

use core::cell::Cell;
use core::time::Duration;
use std::io;
use std::time::Instant;

use rustix::event::{PollFd, PollFlags};

use super::poll_readable;
use crate::host::Stop;

/// Longer than a turn of a loop that is not held up.
const BELIEVED: Duration = Duration::from_micros(200);

/// Whether asking a descriptor is worth a system call: what the last sleep saw there. It is believed as often as a loop
/// asks in a turn, and no longer than a turn takes; who asks more often or later, or does not sleep, asks the descriptor.
#[derive(Debug)]
pub(in crate::host) struct Look {
    /// How often a loop asks between two sleeps.
    in_turn: u8,
    /// How often what was seen is believed yet.
    believed: Cell<u8>,
    /// When it was seen.
    at: Cell<Option<Instant>>,
    /// Whether there is something.
    something: Cell<bool>,
}

impl Look {
    /// Nobody has looked. A loop asks so often between two sleeps.
    pub(in crate::host) const fn new(in_turn: u8) -> Self {
        Self { in_turn, believed: Cell::new(0), at: Cell::new(None), something: Cell::new(true) }
    }

    /// Whether to ask the descriptor.
    pub(in crate::host) fn asks(&self) -> bool {
        self.asks_at(Instant::now())
    }

    fn asks_at(&self, now: Instant) -> bool {
        let left = self.believed.get();
        self.believed.set(left.saturating_sub(1));
        let old = self.at.get().is_none_or(|at| now.saturating_duration_since(at) > BELIEVED);
        left == 0 || old || self.something.get()
    }

    /// Everything that was there is taken.
    pub(in crate::host) fn is_empty(&self) {
        self.something.set(false);
    }

    /// There is something, whatever the sleep saw.
    #[cfg(target_os = "linux")]
    pub(in crate::host) fn has_something(&self) {
        self.something.set(true);
    }

    fn saw(&self, something: bool) {
        self.believed.set(self.in_turn);
        self.at.set(Some(Instant::now()));
        self.something.set(something);
    }
}

/// What to sleep on.
pub(in crate::host) struct Sleep<'a> {
    fds: Vec<PollFd<'a>>,
    /// Behind the stop request, one for each descriptor.
    looks: Vec<&'a Look>,
}

impl<'a> Sleep<'a> {
    /// Until the end is requested, or what is added.
    pub(in crate::host) fn until(stop: &'a Stop) -> Self {
        Self { fds: Vec::from([PollFd::new(stop, PollFlags::IN)]), looks: Vec::new() }
    }

    /// Or until `fd` is as `fd` says; `look` gets to know.
    pub(in crate::host) fn or(&mut self, fd: PollFd<'a>, look: &'a Look) {
        self.fds.push(fd);
        self.looks.push(look);
    }

    /// Sleeps, for `timeout` at most.
    pub(in crate::host) fn sleep(mut self, timeout: Option<Duration>) -> io::Result<()> {
        poll_readable(&mut self.fds, timeout)?;
        for (fd, look) in self.fds.iter().skip(1).zip(self.looks) {
            look.saw(!fd.revents().is_empty());
        }
        Ok(())
    }
}

#[cfg(all(test, unix))]
mod tests {
    use std::io::Write;
    use std::os::unix::net::UnixStream;

    use super::*;

    #[test]
    fn what_a_sleep_saw_is_believed_for_one_turn() {
        let (mut near, far) = UnixStream::pair().unwrap();
        let (stop, look) = (Stop::new().unwrap(), Look::new(2));
        let nap = |timeout| {
            let mut sleep = Sleep::until(&stop);
            sleep.or(PollFd::new(&far, PollFlags::IN), &look);
            sleep.sleep(timeout).unwrap();
        };
        assert!(look.asks() && look.asks(), "nobody has looked");
        let asks = |after| look.asks_at(look.at.get().unwrap() + after);
        let (at_once, soon, late) = (Duration::ZERO, BELIEVED, BELIEVED * 2);
        nap(Some(Duration::ZERO));
        assert_eq!([asks(at_once), asks(soon), asks(at_once)], [false, false, true]);
        nap(Some(Duration::ZERO));
        assert!(asks(late), "a loop that was held up looks itself");
        near.write_all(b"X").unwrap();
        nap(None);
        assert!(look.asks());
        look.is_empty();
        assert_eq!([asks(at_once), asks(at_once)], [false, true], "that was all, and then nobody knows");
    }

    #[test]
    fn a_request_to_stop_ends_a_sleep() {
        let (_near, far) = UnixStream::pair().unwrap();
        let (stop, look) = (Stop::new().unwrap(), Look::new(2));
        stop.request();
        let mut sleep = Sleep::until(&stop);
        sleep.or(PollFd::new(&far, PollFlags::IN), &look);
        sleep.sleep(None).unwrap();
        assert!(!look.asks_at(look.at.get().unwrap()));
    }
}
