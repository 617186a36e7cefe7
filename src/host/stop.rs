//! How a run loop is told to end.

use core::sync::atomic::{AtomicBool, Ordering};
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
/// descriptor and on this one, and no request can fall between a look and the sleep after it. A flag says the same to who
/// only looks, without a system call; it is set before the socket wakes anybody.
#[derive(Clone, Debug)]
pub struct Stop {
    inner: Arc<Inner>,
}

#[derive(Debug)]
struct Inner {
    requested: Arc<AtomicBool>,
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
        readable_when_requested.set_nonblocking(true)?;
        Ok(Self { inner: Arc::new(Inner { requested: Arc::default(), readable_when_requested, waker }) })
    }

    /// Requests the end. Asking twice changes nothing.
    pub fn request(&self) {
        self.inner.requested.store(true, Ordering::SeqCst);
        // A full socket means that the request was made long ago.
        let _ = (&self.inner.waker).write(&[1]);
    }

    /// Whether the end was requested.
    pub fn is_requested(&self) -> bool {
        self.inner.requested.load(Ordering::SeqCst)
    }

    /// Takes the request back, for a loop that goes on. A request that is made at the same time may go with it.
    pub fn clear(&self) {
        // First, so that no request leaves an octet without its flag: a loop would neither end nor sleep.
        self.inner.requested.store(false, Ordering::SeqCst);
        let mut octets = [0; 64];
        while matches!((&self.inner.readable_when_requested).read(&mut octets), Ok(count) if count > 0) {}
    }

    /// What makes a request: a flag to set, then a stream to write an octet to. For `signal_hook::flag::register` and
    /// `signal_hook::low_level::pipe::register`, in this order.
    ///
    /// # Errors
    /// The process has no file descriptors left.
    #[cfg(unix)]
    pub(crate) fn waker(&self) -> io::Result<(Arc<AtomicBool>, Socket)> {
        Ok((Arc::clone(&self.inner.requested), self.inner.waker.try_clone()?))
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
    fn what_a_signal_handler_does_is_a_request() {
        use rustix::event::{PollFd, PollFlags, poll};

        let stop = Stop::new().unwrap();
        let (flag, mut stream) = stop.waker().unwrap();
        for _ in 0..2 {
            flag.store(true, Ordering::SeqCst);
            stream.write_all(b"X").unwrap();
            assert!(stop.is_requested());
            assert_eq!(poll(&mut [PollFd::new(&stop, PollFlags::IN)], None), Ok(1), "it ends a sleep");
            stop.clear();
            assert!(!stop.is_requested());
        }
    }
}
