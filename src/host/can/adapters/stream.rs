//! The connection of an adapter with its master: a pseudo-terminal, or a TCP connection.

use std::io::{self, ErrorKind, Read, Write};
use std::net::TcpStream;

use rustix::event::{PollFd, PollFlags};

use crate::host::link::pty::Pty;
use crate::host::link::{Look, Sleep};
use crate::host::{Link, Received};

/// Octets that the kernel keeps for a master at a TCP port: one that reads again after a pause gets no more old frames.
const KERNEL_BUFFER: usize = 64 * 1024;

pub(super) enum Stream {
    Pty(Box<Pty>),
    Tcp(TcpStream, Look),
}

/// What came from a master.
pub(super) enum Arrival {
    Octets(usize),
    Nothing,
    /// Octets after this one are of another master.
    Another,
    /// The master is gone for good.
    Gone,
}

impl Stream {
    pub(super) fn tcp(stream: TcpStream) -> io::Result<Self> {
        stream.set_nonblocking(true)?;
        stream.set_nodelay(true)?;
        rustix::net::sockopt::set_socket_send_buffer_size(&stream, KERNEL_BUFFER)?;
        Ok(Self::Tcp(stream, Look::new(super::IN_TURN)))
    }

    pub(super) fn read(&mut self, buf: &mut [u8]) -> io::Result<Arrival> {
        match self {
            Self::Pty(pty) => Ok(match pty.receive(buf)? {
                Received::Octets(count) | Received::BrokenOff(count) => Arrival::Octets(count),
                Received::Reset => Arrival::Another,
                Received::Rate(_) | Received::Nothing => Arrival::Nothing,
            }),
            Self::Tcp(_, look) if !look.asks() => Ok(Arrival::Nothing),
            Self::Tcp(stream, look) => Ok(match stream.read(buf) {
                Ok(0) => Arrival::Gone,
                Ok(count) => {
                    if count < buf.len() {
                        look.is_empty();
                    }
                    Arrival::Octets(count)
                }
                Err(error) if error.kind() == ErrorKind::WouldBlock => {
                    look.is_empty();
                    Arrival::Nothing
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => Arrival::Nothing,
                Err(_) => Arrival::Gone,
            }),
        }
    }

    /// How many octets were taken; `None`: nobody is there.
    pub(super) fn write(&mut self, octets: &[u8]) -> io::Result<Option<usize>> {
        match self {
            Self::Pty(pty) => pty.write(octets),
            Self::Tcp(stream, _) => Ok(match stream.write(octets) {
                Ok(count) => Some(count),
                Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => {
                    Some(0)
                }
                Err(_) => None,
            }),
        }
    }

    /// Throws away what the master has not read, as far as that is possible.
    pub(super) fn discard_output(&self) -> io::Result<()> {
        match self {
            Self::Pty(pty) => pty.discard_output(),
            Self::Tcp(..) => Ok(()),
        }
    }

    /// What to sleep on; with `full` until there is room again, with `reads` until something comes.
    pub(super) fn watch<'a>(&'a self, reads: bool, full: bool, sleep: &mut Sleep<'a>) {
        match self {
            Self::Pty(pty) => pty.watch(reads, full, sleep),
            Self::Tcp(stream, look) => {
                let mut flags = PollFlags::empty();
                flags.set(PollFlags::IN, reads);
                flags.set(PollFlags::OUT, full);
                if !flags.is_empty() {
                    sleep.or(PollFd::new(stream, flags), look);
                }
            }
        }
    }

    /// How long a sleep may last at most; `None`: for ever.
    pub(super) fn patience(&mut self) -> Option<core::time::Duration> {
        match self {
            Self::Pty(pty) => pty.patience(),
            Self::Tcp(..) => None,
        }
    }
}
