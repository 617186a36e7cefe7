//! A stable name for a terminal whose own name changes from run to run.

use std::ffi::OsString;
use std::fs;
use std::io;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::{format, process};

use crate::host::{Error, PathOccupant};

/// A symbolic link to a terminal, removed on drop if it still leads there.
#[derive(Debug)]
pub(super) struct Symlink {
    path: PathBuf,
    terminal: PathBuf,
}

/// What becomes of a symbolic link that is there already and leads to something else that exists. One that leads nowhere
/// (left behind by a process that was killed) is always replaced; what is no link never is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum OldLink {
    Keep,
    Replace,
}

impl Symlink {
    /// Makes `path` lead to `terminal`.
    pub(super) fn create(path: &Path, terminal: &Path, old: OldLink) -> Result<Self, Error> {
        match symlink(terminal, path) {
            Ok(()) => {}
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => replace(path, terminal, old)?,
            Err(source) => {
                return Err(Error::Symlink { path: path.to_path_buf(), source });
            }
        }
        Ok(Self { path: path.to_path_buf(), terminal: terminal.to_path_buf() })
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for Symlink {
    fn drop(&mut self) {
        if fs::read_link(&self.path).is_ok_and(|target| target == self.terminal)
            && let Err(error) = fs::remove_file(&self.path)
        {
            tracing::warn!("cannot remove the symbolic link {}: {error}", self.path.display());
        }
    }
}

/// Replaces the link at `path` in one step, so that a master never finds the name missing.
fn replace(path: &Path, terminal: &Path, old: OldLink) -> Result<(), Error> {
    let failed = |source| Error::Symlink { path: path.to_path_buf(), source };
    let taken = |found| Error::PathTaken { path: path.to_path_buf(), found };

    let kind = fs::symlink_metadata(path).map_err(failed)?.file_type();
    if kind.is_dir() {
        return Err(taken(PathOccupant::Directory));
    }
    if !kind.is_symlink() {
        return Err(taken(PathOccupant::File));
    }
    // Where it leads to cannot be told for sure (no permission, a loop): then it is not ours to replace.
    let dangling = path.try_exists().is_ok_and(|exists| !exists);
    let own = fs::read_link(path).is_ok_and(|target| target == terminal);
    if old == OldLink::Keep && !dangling && !own {
        return Err(taken(PathOccupant::LinkInUse));
    }

    let temporary = temporary_name(path);
    symlink(terminal, &temporary).map_err(failed)?;
    fs::rename(&temporary, path).map_err(|error| {
        let _ = fs::remove_file(&temporary);
        failed(error)
    })
}

/// A hidden name in the same directory that no other process uses.
fn temporary_name(path: &Path) -> PathBuf {
    let mut name = OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(format!(".{}", process::id()));
    path.with_file_name(name)
}
