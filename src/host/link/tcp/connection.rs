//! The master's end of a TCP line.

use core::time::Duration;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};

use rustix::event::{PollFd, PollFlags};

use crate::host::link::poll_readable;
use crate::host::{Error, Link, Received, Stop};

/// How long one address of a host may take to answer.
const PATIENCE: Duration = Duration::from_secs(5);

/// A connection to a line that somebody else serves, as a [`Tcp`](super::Tcp) does: raw octets in both directions.
#[derive(Debug)]
pub struct Connection {
    stream: TcpStream,
    lost: u64,
}

impl Connection {
    /// Connects to `place`, `HOST:PORT`. The first address of the host that answers within 5 s is taken.
    ///
    /// # Errors
    /// [`Error::TcpConnect`].
    pub fn open(place: &str) -> Result<Self, Error> {
        let failed = |source| Error::TcpConnect { place: place.into(), source };
        let mut refused = ErrorKind::AddrNotAvailable.into();
        for address in place.to_socket_addrs().map_err(failed)? {
            match TcpStream::connect_timeout(&address, PATIENCE) {
                Ok(stream) => {
                    // A telegram is a packet of its own.
                    stream.set_nodelay(true).and_then(|()| stream.set_nonblocking(true)).map_err(failed)?;
                    return Ok(Self { stream, lost: 0 });
                }
                Err(error) => refused = error,
            }
        }
        Err(failed(refused))
    }

    /// How many octets were sent that the connection had no room for.
    pub fn lost(&self) -> u64 {
        self.lost
    }
}

impl Link for Connection {
    fn receive(&mut self, buf: &mut [u8]) -> io::Result<Received> {
        loop {
            return match self.stream.read(buf) {
                Ok(0) => Err(io::Error::new(ErrorKind::NotConnected, "the other side has closed it")),
                Ok(count) => Ok(Received::Octets(count)),
                Err(error) if error.kind() == ErrorKind::WouldBlock => Ok(Received::Nothing),
                Err(error) if error.kind() == ErrorKind::Interrupted => continue,
                Err(error) => Err(error),
            };
        }
    }

    /// See [`Link::send`]. What the other side does not take is lost, see [`Connection::lost`].
    fn send(&mut self, telegram: &[u8]) -> io::Result<()> {
        let sent = match self.stream.write(telegram) {
            Ok(sent) => sent,
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => 0,
            Err(error) => return Err(error),
        };
        self.lost = self.lost.saturating_add(telegram.len().saturating_sub(sent) as u64);
        Ok(())
    }

    fn wait(&mut self, timeout: Option<Duration>, stop: &Stop) -> io::Result<()> {
        let mut fds = [PollFd::new(&self.stream, PollFlags::IN), PollFd::new(stop, PollFlags::IN)];
        poll_readable(&mut fds, timeout)
    }
}

#[cfg(test)]
mod tests {

    use super::*;
    use crate::host::link::tcp::{Reach, Tcp};
    use crate::time::BaudRate;

    const ASK: [u8; 6] = [0x10, 0x05, 0x02, 0x49, 0x50, 0x16];

    #[test]
    fn octets_pass_in_both_directions_until_the_other_side_goes() {
        let stop = Stop::new().unwrap();
        let mut drives = Tcp::bind("127.0.0.1:0", BaudRate::K500, Reach::ThisMachine).unwrap();
        let mut master = Connection::open(&drives.address().to_string()).unwrap();
        master.send(&ASK).unwrap();
        let mut buf = [0; 16];
        let mut heard = Received::Nothing;
        while heard == Received::Nothing {
            drives.wait(None, &stop).unwrap();
            heard = drives.receive(&mut buf).unwrap();
        }
        assert_eq!((heard, &buf[..6]), (Received::Octets(6), &ASK[..]));
        drives.send(&[0xE5]).unwrap();
        master.wait(None, &stop).unwrap();
        assert_eq!(master.receive(&mut buf).unwrap(), Received::Octets(1));
        assert_eq!(master.receive(&mut buf).unwrap(), Received::Nothing);
        drop(drives);
        master.wait(None, &stop).unwrap();
        assert!(master.receive(&mut buf).is_err());
    }

    #[test]
    fn a_place_where_nobody_listens_is_named() {
        let free = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
        let error = Connection::open(&free).unwrap_err().to_string();
        assert_eq!(error, std::format!("cannot connect to tcp:{free} (check that the emulator runs there)"));
    }
}
