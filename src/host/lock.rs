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

/// Locks a file for this process, though others may look at it with [`is_locked`] meanwhile.
#[cfg(target_os = "linux")]
pub(super) fn locked_past_looks(file: &File) -> io::Result<bool> {
    use rustix::fs::{FlockOperation, flock};

    if locked(file)? {
        return Ok(true);
    }
    // Who looks lets go at once: worth waiting for.
    if is_locked(file)? {
        return Ok(false);
    }
    flock(file, FlockOperation::LockExclusive)?;
    Ok(true)
}

/// Whether a process has a file [`locked`].
#[cfg(target_os = "linux")]
pub(super) fn is_locked(file: &File) -> io::Result<bool> {
    use rustix::fs::{FlockOperation, flock};
    use rustix::io::Errno;

    match flock(file, FlockOperation::NonBlockingLockShared) {
        Ok(()) => {
            flock(file, FlockOperation::Unlock)?;
            Ok(false)
        }
        Err(Errno::WOULDBLOCK) => Ok(true),
        Err(error) => Err(error.into()),
    }
}

/// Locks a file for this process until it is closed; `false`: another has locked it.
#[cfg(windows)]
pub(super) fn locked(file: &File) -> io::Result<bool> {
    use fs4::{FileExt, TryLockError};

    match FileExt::try_lock(file) {
        Ok(()) => Ok(true),
        Err(TryLockError::WouldBlock) => Ok(false),
        Err(TryLockError::Error(error)) => Err(error),
    }
}
