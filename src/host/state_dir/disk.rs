//! [`Disk`]: what the state directory asks of the operating system, so that tests can let it fail.

use core::fmt::Debug;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use crate::host::lock::locked;

/// Held locked while a process uses the directory.
const LOCK: &str = ".lock";

/// Files in one directory, for images ([`StateDir::on`](super::StateDir::on)). Names have no folder in them.
///
/// A call that fails may have done half of it, but for [`Disk::rename`]. Errors are the operating system's.
pub trait Disk: Debug + Send + Sync {
    /// The octets of a file, at most `most`; `None` if there is no file.
    fn read(&self, name: &str, most: usize) -> io::Result<Option<Vec<u8>>>;
    /// Makes a file of these octets, instead of any of this name. They may be lost until [`Disk::sync`].
    fn write(&self, name: &str, octets: &[u8]) -> io::Result<()>;
    /// Makes the octets of a file safe.
    fn sync(&self, name: &str) -> io::Result<()>;
    /// Gives a file another name, instead of any file that has it: all at once or not at all. Which file has the name
    /// may be lost until [`Disk::sync_names`].
    fn rename(&self, from: &str, to: &str) -> io::Result<()>;
    /// Makes the names of the files safe.
    fn sync_names(&self) -> io::Result<()>;
    /// Removes a file; does nothing if there is none.
    fn remove(&self, name: &str) -> io::Result<()>;
    /// The names of all files.
    fn names(&self) -> io::Result<Vec<String>>;
}

/// A directory that this process has locked.
#[derive(Debug)]
pub(super) struct Folder {
    path: PathBuf,
    _lock: File,
}

/// Why a directory cannot be locked.
#[derive(Debug)]
pub(super) enum LockError {
    /// The operating system refuses.
    Failed(io::Error),
    /// Another process has locked it.
    Locked,
    /// The name of the lock belongs to something else.
    NoFile(PathBuf, &'static str),
}

impl From<io::Error> for LockError {
    fn from(error: io::Error) -> Self {
        Self::Failed(error)
    }
}

impl Folder {
    /// Makes the directory if it is missing, and locks it.
    pub(super) fn open(path: &Path) -> Result<Self, LockError> {
        fs::create_dir_all(path)?;
        let name = path.join(LOCK);
        // Opening a pipe would wait for its other end, opening a dangling link makes a file elsewhere.
        match fs::symlink_metadata(&name) {
            Ok(found) if !found.is_file() => return Err(LockError::NoFile(name, kind(found.file_type()))),
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error.into()),
            Ok(_) | Err(_) => {}
        }
        let lock = OpenOptions::new().create(true).truncate(false).write(true).open(name)?;
        if !locked(&lock)? {
            return Err(LockError::Locked);
        }
        Ok(Self { path: path.to_path_buf(), _lock: lock })
    }
}

impl Disk for Folder {
    fn read(&self, name: &str, most: usize) -> io::Result<Option<Vec<u8>>> {
        let path = self.path.join(name);
        match fs::metadata(&path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(error),
            // Opening a pipe would wait for its other end.
            Ok(found) if !found.is_file() => return Err(io::Error::other("it is not a file")),
            Ok(_) => {}
        }
        let mut octets = Vec::new();
        File::open(path)?.take(most as u64).read_to_end(&mut octets)?;
        Ok(Some(octets))
    }

    fn write(&self, name: &str, octets: &[u8]) -> io::Result<()> {
        // Not written through a link that somebody put there.
        self.remove(name)?;
        let mut file = OpenOptions::new().write(true).create_new(true).open(self.path.join(name))?;
        file.write_all(octets)
    }

    fn sync(&self, name: &str) -> io::Result<()> {
        // An error of a write that nobody was told yet is told here.
        OpenOptions::new().write(true).open(self.path.join(name))?.sync_all()
    }

    fn rename(&self, from: &str, to: &str) -> io::Result<()> {
        fs::rename(self.path.join(from), self.path.join(to))
    }

    #[cfg(unix)]
    fn sync_names(&self) -> io::Result<()> {
        File::open(&self.path)?.sync_all()
    }

    #[cfg(not(unix))]
    fn sync_names(&self) -> io::Result<()> {
        Ok(())
    }

    fn remove(&self, name: &str) -> io::Result<()> {
        match fs::remove_file(self.path.join(name)) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
            Ok(()) | Err(_) => Ok(()),
        }
    }

    fn names(&self) -> io::Result<Vec<String>> {
        let mut names = Vec::new();
        for entry in fs::read_dir(&self.path)? {
            // None of ours is not Unicode.
            names.extend(entry?.file_name().into_string());
        }
        Ok(names)
    }
}

/// What is at a place where a file was expected.
fn kind(found: fs::FileType) -> &'static str {
    #[cfg(unix)]
    if std::os::unix::fs::FileTypeExt::is_fifo(&found) {
        return "a pipe";
    }
    match (found.is_dir(), found.is_symlink()) {
        (true, _) => "a directory",
        (false, true) => "a symbolic link",
        (false, false) => "a device or socket",
    }
}
