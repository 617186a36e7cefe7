//! Files that one process uses at a time.

use std::fs::File;
use std::io;

/// Locks a file for this process until it is closed; `false`: another has locked it.
#[cfg(unix)]
pub(super) fn locked(file: &File) -> io::Result<bool> {
    use rustix::fs::{FlockOperation, flock};
    use rustix::io::Errno;

    match flock(file, FlockOperation::NonBlockingLockExclusive) {
        Ok(()) => Ok(true),
        Err(Errno::WOULDBLOCK) => Ok(false),
        Err(error) => Err(error.into()),
    }
}

#[cfg(not(unix))]
pub(super) fn locked(_: &File) -> io::Result<bool> {
    Ok(true)
}
