//! Who can connect to a port that is listened at.

use core::net::SocketAddr;
use std::io;
use std::net::{TcpListener, ToSocketAddrs};

/// Who can connect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// Programs on this machine.
    ThisMachine,
    /// Everybody whom the address reaches. There is no password and no encryption.
    Network,
}

/// Why a port is not listened at.
#[derive(Debug)]
pub(crate) enum ListenError {
    /// The operating system does not let us, or does not know the host.
    Failed(io::Error),
    /// Others than this machine could connect at this address, and were not invited.
    TooFar(SocketAddr),
}

/// What a person can do about a port that cannot be listened at.
#[expect(
    clippy::wildcard_enum_match_arm,
    reason = "operating systems have many more errors than there is advice"
)]
pub(crate) fn advice(error: &io::Error) -> &'static str {
    match error.kind() {
        io::ErrorKind::PermissionDenied => {
            "ports below 1024 need special rights; choose a port from 1024 to 65535"
        }
        io::ErrorKind::AddrInUse => {
            "another program listens there; end it, or choose another port; port 0 takes a free one"
        }
        io::ErrorKind::AddrNotAvailable => "this machine does not have that address; use 127.0.0.1",
        _ => "check the name of the host, or choose 127.0.0.1",
    }
}

/// What a person can do about a port of another program that does not take a connection.
#[expect(
    clippy::wildcard_enum_match_arm,
    reason = "operating systems have many more errors than there is advice"
)]
pub(crate) fn connect_advice(error: &io::Error) -> &'static str {
    match error.kind() {
        io::ErrorKind::ConnectionRefused | io::ErrorKind::ConnectionReset => {
            "check that the emulator runs there"
        }
        io::ErrorKind::TimedOut
        | io::ErrorKind::HostUnreachable
        | io::ErrorKind::NetworkUnreachable
        | io::ErrorKind::NetworkDown => "check the network and the address of the host",
        _ => "check the name of the host and the port",
    }
}

/// The address from which others than this machine could connect to `place`; `None`: none, or the host is not known.
pub(crate) fn open_to_others(place: &str) -> Option<SocketAddr> {
    place.to_socket_addrs().ok()?.find(|address| !address.ip().to_canonical().is_loopback())
}

/// Listens at `place`, `HOST:PORT`, without blocking; port 0 is a free one, and the address says which.
pub(crate) fn listen(place: &str, reach: Reach) -> Result<(TcpListener, SocketAddr), ListenError> {
    let addresses: Vec<SocketAddr> = place.to_socket_addrs().map_err(ListenError::Failed)?.collect();
    if reach == Reach::ThisMachine
        && let Some(address) = open_to_others(place)
    {
        return Err(ListenError::TooFar(address));
    }
    let listener = TcpListener::bind(&addresses[..]).map_err(ListenError::Failed)?;
    listener.set_nonblocking(true).map_err(ListenError::Failed)?;
    let address = listener.local_addr().map_err(ListenError::Failed)?;
    Ok((listener, address))
}
