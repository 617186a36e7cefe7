//! A stable name for a terminal whose own name changes from run to run.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, Read, Seek, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt, symlink};
use std::path::{Path, PathBuf};
use std::{process, writeln};

use rustix::fs::OFlags;

use crate::host::lock::{is_locked, locked_past_looks};
use crate::host::{Error, PathOccupant};

/// Octets of the file of an owner that are read at most: two paths.
const MOST_TEXT: u64 = 2 * 4096 + 2;

/// A symbolic link to a terminal, removed on drop if it still leads there.
#[derive(Debug)]
pub(super) struct Symlink {
    path: PathBuf,
    terminal: PathBuf,
    /// Dropped behind the link.
    _owner: Owner,
}

/// What becomes of a symbolic link that is there already and leads to something else that exists. One that leads nowhere
/// (left behind by a process that was killed) is always replaced; what is no link never is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum OldLink {
    Keep,
    Replace,
}

impl Symlink {
    /// Makes `path` lead to `terminal`. A link left behind by an emulator that was killed is always replaced, that of a
    /// running one never.
    pub(super) fn create(path: &Path, terminal: &Path, old: OldLink) -> Result<Self, Error> {
        let failed = |source| Error::Symlink { path: path.to_path_buf(), source };
        let taken = || Error::PathTaken { path: path.to_path_buf(), found: PathOccupant::LinkInUse };
        let mut owner = Owner::become_of(path).map_err(failed)?.ok_or_else(taken)?;
        let old = if owner.owned(path) { OldLink::Replace } else { old };
        owner.write(path, terminal).map_err(failed)?;
        match symlink(terminal, path) {
            Ok(()) => {}
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                replace(path, terminal, old)?;
            }
            Err(source) => return Err(failed(source)),
        }
        Ok(Self { path: path.to_path_buf(), terminal: terminal.to_path_buf(), _owner: owner })
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Whether `path` is a link of an emulator that was killed: who has the terminal it leads to now is a stranger.
    pub(super) fn is_left_behind(path: &Path) -> bool {
        Owner::of(path)
            .is_some_and(|owner| owner.owned(path) && is_locked(&owner.file).is_ok_and(|locked| !locked))
    }
}

/// Says whose a link is: a hidden file beside it that names what the link leads to, locked while the emulator lives.
/// The numbers of terminals are used again, so the link alone does not tell.
#[derive(Debug)]
struct Owner {
    path: PathBuf,
    file: File,
    /// This process has locked it.
    ours: bool,
}

impl Owner {
    /// Locks the file, and makes it if it is missing; `None`: another emulator has it.
    fn become_of(link: &Path) -> io::Result<Option<Self>> {
        let path = hidden(link, "profidrive");
        loop {
            // Not through a link, and not waiting for the other end of a pipe.
            let flags = (OFlags::NOFOLLOW | OFlags::NONBLOCK).bits().cast_signed();
            let mut options = File::options();
            options.create(true).truncate(false).read(true).write(true).custom_flags(flags);
            let file = options.open(&path)?;
            if !locked_past_looks(&file)? {
                return Ok(None);
            }
            // The one before may have removed it between the two calls.
            let ours = fs::symlink_metadata(&path).is_ok_and(|found| {
                file.metadata().is_ok_and(|file| (file.dev(), file.ino()) == (found.dev(), found.ino()))
            });
            if ours {
                return Ok(Some(Self { path, file, ours }));
            }
        }
    }

    /// The file, to look at.
    fn of(link: &Path) -> Option<Self> {
        let path = hidden(link, "profidrive");
        let flags = (OFlags::NOFOLLOW | OFlags::NONBLOCK).bits().cast_signed();
        let file = File::options().read(true).custom_flags(flags).open(&path).ok()?;
        file.metadata().is_ok_and(|found| found.is_file()).then_some(Self { path, file, ours: false })
    }

    /// Whether `link` leads to where an owner said it does.
    fn owned(&self, link: &Path) -> bool {
        let mut text = String::new();
        let read = (&self.file).take(MOST_TEXT).read_to_string(&mut text);
        let leads_to = fs::read_link(link);
        read.is_ok() && leads_to.is_ok_and(|to| text.lines().any(|line| Path::new(line) == to))
    }

    /// Names the terminal, and still where the link leads that it replaces: a kill between the two changes nothing.
    fn write(&mut self, link: &Path, terminal: &Path) -> io::Result<()> {
        let before = fs::read_link(link).unwrap_or_default();
        self.file.set_len(0)?;
        self.file.rewind()?;
        writeln!(self.file, "{}", terminal.display())?;
        writeln!(self.file, "{}", before.display())
    }
}

impl Drop for Owner {
    fn drop(&mut self) {
        if self.ours
            && let Err(error) = fs::remove_file(&self.path)
        {
            tracing::warn!("cannot remove {}: {error}", self.path.display());
        }
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

    let temporary = hidden(path, &process::id().to_string());
    symlink(terminal, &temporary).map_err(failed)?;
    fs::rename(&temporary, path).map_err(|error| {
        let _ = fs::remove_file(&temporary);
        failed(error)
    })
}

/// A hidden name in the same directory.
fn hidden(path: &Path, end: &str) -> PathBuf {
    let mut name = OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(format!(".{end}"));
    path.with_file_name(name)
}
