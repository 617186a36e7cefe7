//! How a run loop is told to end.

use std::io::{self, Read, Write};
use std::sync::Arc;

#[cfg(windows)]
use std::net::TcpStream as Socket;
#[cfg(unix)]
use std::os::fd::{AsFd, BorrowedFd};
#[cfg(unix)]
use std::os::unix::net::UnixStream as Socket;
#[cfg(windows)]
use std::os::windows::io::{AsSocket, BorrowedSocket};

/// Asks [`super::run()`] to end, from a signal handler, another thread or a test. Clones are the same request.
///
/// This is a socket pair: a request makes one end readable for good, so a link can sleep in `poll` on its own
/// descriptor and on this one, and no request can fall between a look and the sleep after it.
#[derive(Clone, Debug)]
pub struct Stop {
    inner: Arc<Inner>,
}

#[derive(Debug)]
struct Inner {
    readable_when_requested: Socket,
    waker: Socket,
}

impl Stop {
    /// Not yet requested.
    ///
    /// # Errors
    /// The process has no file descriptors left.
    pub fn new() -> io::Result<Self> {
        let (readable_when_requested, waker) = pair()?;
        waker.set_nonblocking(true)?;
        Ok(Self { inner: Arc::new(Inner { readable_when_requested, waker }) })
    }

    /// Requests the end. Asking twice changes nothing.
    pub fn request(&self) {
        // A full socket means that the request was made long ago.
        let _ = (&self.inner.waker).write(&[1]);
    }

    /// Whether the end was requested.
    pub fn is_requested(&self) -> bool {
        use rustix::event::{PollFd, PollFlags, Timespec, poll};

        let mut fds = [PollFd::new(&self.inner.readable_when_requested, PollFlags::IN)];
        let at_once = Timespec { tv_sec: 0, tv_nsec: 0 };
        matches!(poll(&mut fds, Some(&at_once)), Ok(ready) if ready > 0)
    }

    /// Takes the request back, for a loop that goes on. A request that is made at the same time may go with it.
    pub fn clear(&self) {
        let mut octets = [0; 64];
        while self.is_requested() {
            // The socket was readable just now and nobody else reads it: this does not block.
            if (&self.inner.readable_when_requested).read(&mut octets).is_err() {
                return;
            }
        }
    }

    /// A stream whose every written octet is a request, for `signal_hook::low_level::pipe::register`.
    ///
    /// # Errors
    /// The process has no file descriptors left.
    #[cfg(unix)]
    pub(crate) fn waker(&self) -> io::Result<Socket> {
        self.inner.waker.try_clone()
    }
}

#[cfg(unix)]
fn pair() -> io::Result<(Socket, Socket)> {
    Socket::pair()
}

#[cfg(windows)]
fn pair() -> io::Result<(Socket, Socket)> {
    super::link::socket_pair()
}

#[cfg(unix)]
impl AsFd for Stop {
    /// A descriptor that becomes readable with the request. Do not read from it.
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.inner.readable_when_requested.as_fd()
    }
}

#[cfg(windows)]
impl AsSocket for Stop {
    /// A socket that becomes readable with the request. Do not read from it.
    fn as_socket(&self) -> BorrowedSocket<'_> {
        self.inner.readable_when_requested.as_socket()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_stays_and_reaches_every_clone() {
        let stop = Stop::new().unwrap();
        let clone = stop.clone();
        assert!(!clone.is_requested());
        stop.request();
        stop.request();
        assert!(clone.is_requested());
        assert!(clone.is_requested(), "looking does not consume the request");
    }

    #[test]
    fn a_request_taken_back_is_gone_for_every_clone_and_can_be_made_again() {
        let stop = Stop::new().unwrap();
        let clone = stop.clone();
        stop.clear();
        for _ in 0..200 {
            stop.request();
        }
        clone.clear();
        assert!(!stop.is_requested());
        stop.request();
        assert!(clone.is_requested());
    }

    #[cfg(unix)]
    #[test]
    fn an_octet_from_a_signal_handler_is_a_request() {
        let stop = Stop::new().unwrap();
        stop.waker().unwrap().write_all(b"X").unwrap();
        assert!(stop.is_requested());
    }
}
