//! The links: in memory, pseudo-terminal, serial port, TCP; and for any of them faults on purpose and a tap.

#[cfg(feature = "emulator")]
pub(crate) mod beside;
#[cfg(all(windows, feature = "serial"))]
mod com;
pub mod fault;
pub mod memory;
mod pieces;
#[cfg_attr(not(target_os = "linux"), path = "no_pty.rs")]
pub mod pty;
#[cfg(feature = "serial")]
pub mod serial;
mod sleep;
#[cfg(target_os = "linux")]
mod symlink;
pub mod tap;
pub mod tcp;
#[cfg_attr(windows, path = "terminal_windows.rs")]
#[cfg(any(unix, feature = "serial"))]
pub mod terminal;

pub(in crate::host) use sleep::{Look, Sleep};

/// Sleeps until one of the descriptors is readable or `timeout` has passed. A signal ends the sleep early.
///
/// On Windows they are sockets.
pub(in crate::host) fn poll_readable(
    fds: &mut [rustix::event::PollFd<'_>],
    timeout: Option<core::time::Duration>,
) -> std::io::Result<()> {
    use rustix::event::{Timespec, poll};

    // A timeout beyond what the kernel counts (292 billion years) is no timeout.
    let timeout = timeout.and_then(|timeout| Timespec::try_from(timeout).ok());
    match poll(fds, timeout.as_ref()) {
        Ok(_) | Err(rustix::io::Errno::INTR) => Ok(()),
        Err(error) => Err(error.into()),
    }
}

/// Two sockets of which each reads what the other writes, as `UnixStream::pair` makes them. Only this process has them.
#[cfg(windows)]
pub(in crate::host) fn socket_pair() -> std::io::Result<(std::net::TcpStream, std::net::TcpStream)> {
    use std::net::{Ipv4Addr, TcpListener, TcpStream};

    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
    let ours = TcpStream::connect(listener.local_addr()?)?;
    loop {
        let (theirs, peer) = listener.accept()?;
        // Another program of this machine may have been quicker.
        if peer == ours.local_addr()? {
            ours.set_nodelay(true)?;
            theirs.set_nodelay(true)?;
            return Ok((ours, theirs));
        }
    }
}
