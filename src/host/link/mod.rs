//! The links: in memory, pseudo-terminal, serial port, TCP; and for any of them faults on purpose and a tap.

pub mod fault;
pub mod memory;
mod pieces;
#[cfg(target_os = "linux")]
pub mod pty;
#[cfg(all(unix, feature = "serial"))]
pub mod serial;
#[cfg(target_os = "linux")]
mod symlink;
pub mod tap;
#[cfg(unix)]
pub mod tcp;
#[cfg(unix)]
pub mod terminal;

/// Sleeps until one of the descriptors is readable or `timeout` has passed. A signal ends the sleep early.
#[cfg(unix)]
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
