//! Images of units in a directory: one file per unit, replaced whole or not at all.
//!
//! ```text
//! unit ──newest image──▶ slot of its file ──▶ writer thread ──▶ .NAME.tmp, fsync ──rename──▶ NAME, fsync of the directory
//!      ◀────outcome─────                  ◀──
//! ```
//!
//! A write takes as long as the disk takes, tens of milliseconds and more; a master waits less. So one thread writes
//! for all units of the directory, and the units go on answering. A slot holds one image, the newest: a slow disk
//! makes no queue.
//!
//! What a unit is does not matter here: it has [`Images`], and whoever adds it names its file.
//!
//! | file | holds |
//! | --- | --- |
//! | `disk.rs` | what is asked of a disk, and the directory that does it |
//! | `slots.rs` | which files have an owner, which images wait, the writer |
//! | `image_file.rs` | the file of one unit, as its owner uses it |

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::{self, JoinHandle};

use thiserror::Error;

mod disk;
mod image_file;
mod slots;
#[cfg(test)]
mod tests;

pub use disk::Disk;
use disk::{Folder, LockError};
pub(crate) use image_file::ImageFile;
pub use image_file::Images;
use slots::Slots;

/// How the name of every image ends.
const EXTENSION: &str = ".eeprom";
/// How the name of an image being written ends; it begins with a dot.
const TEMPORARY: &str = ".eeprom.tmp";

/// Why a directory or an image in it cannot be used. The cause, where there is one, is the error's source.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum StateDirError {
    /// The directory cannot be made, read or written.
    #[error("cannot keep EEPROM images in {} ({})", path.display(), advice(source))]
    Directory {
        /// Its path.
        path: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// The name of the lock belongs to something that cannot be locked.
    #[error(
        "cannot lock the directory: {} is {found}, expected a file that an emulator made; remove it or choose another \
         directory",
        path.display()
    )]
    Lock {
        /// The path of the lock.
        path: PathBuf,
        /// What was found there.
        found: &'static str,
    },
    /// Another process uses the directory.
    #[error("{} is used by another running emulator; end that one or choose another directory", path.display())]
    InUse {
        /// Its path.
        path: PathBuf,
    },
    /// A unit that is running keeps its image in this file.
    #[error(
        "the EEPROM image {} belongs to a unit that is running, which was added under this name; remove that one first",
        path.display()
    )]
    Owned {
        /// Its path.
        path: PathBuf,
    },
    /// The image of a unit cannot be read or written.
    #[error("cannot use the EEPROM image {} ({})", path.display(), advice(source))]
    File {
        /// Its path.
        path: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// The file is no image of this unit.
    #[error(
        "the EEPROM image {} is refused and left as it is: {cause}; to start with factory settings move it away, or \
         choose another directory",
        path.display()
    )]
    Refused {
        /// Its path.
        path: PathBuf,
        /// What is wrong with it.
        cause: Box<dyn core::error::Error + Send + Sync>,
    },
}

/// What a person can do about a disk that refuses.
#[expect(
    clippy::wildcard_enum_match_arm,
    reason = "operating systems have many more errors than there is advice"
)]
fn advice(error: &io::Error) -> &'static str {
    match error.kind() {
        io::ErrorKind::PermissionDenied => {
            "give this user the right to write there, or choose another directory"
        }
        io::ErrorKind::ReadOnlyFilesystem => "the disk is read-only; choose another directory",
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
            "the disk is full; make room, or choose another directory"
        }
        io::ErrorKind::NotADirectory | io::ErrorKind::AlreadyExists => {
            "it is not a directory; choose another one"
        }
        io::ErrorKind::NotFound => "there is no such place; choose a directory that can be made",
        _ => "move what is there away, or choose another directory",
    }
}

/// A directory with the images of units, used by this process alone.
///
/// Dropped, it waits until what was handed over is written, at most 5 s.
#[derive(Debug)]
pub struct StateDir {
    path: PathBuf,
    slots: Arc<Slots>,
    writer: Option<JoinHandle<()>>,
}

impl StateDir {
    /// Takes a directory into use; it is made if it is missing. What a killed process left half written is removed.
    ///
    /// # Errors
    /// [`StateDirError::Directory`], [`StateDirError::Lock`], [`StateDirError::InUse`].
    pub fn open(path: &Path) -> Result<Self, StateDirError> {
        let failed = |source| StateDirError::Directory { path: path.to_path_buf(), source };
        let folder = Folder::open(path).map_err(|error| match error {
            LockError::Failed(source) => failed(source),
            LockError::Locked => StateDirError::InUse { path: path.to_path_buf() },
            LockError::NoFile(path, found) => StateDirError::Lock { path, found },
        })?;
        let mut state = Self::on(path, Box::new(folder))?;
        let slots = Arc::clone(&state.slots);
        let writer = thread::Builder::new().name("eeprom".into()).spawn(move || slots.write_all());
        state.writer = Some(writer.map_err(failed)?);
        Ok(state)
    }

    /// Keeps images on a disk of the caller's, without a thread: they are written by [`StateDir::write_next`]. For tests
    /// of what happens when disks fail. `path` is what errors say.
    ///
    /// # Errors
    /// [`StateDirError::Directory`].
    pub fn on(path: &Path, disk: Box<dyn Disk>) -> Result<Self, StateDirError> {
        let slots = Slots::new(path, disk);
        slots.tidy().map_err(|source| StateDirError::Directory { path: path.to_path_buf(), source })?;
        Ok(Self { path: path.to_path_buf(), slots: Arc::new(slots), writer: None })
    }

    /// Writes the next image that waits, as the thread of [`StateDir::open`] does by itself. One that failed is tried
    /// again at once. `false`: none waits.
    pub fn write_next(&self) -> bool {
        self.slots.write_next()
    }

    /// Takes the file `NAME.eeprom` for one unit, until the [`ImageFile`] is dropped; with it comes the newest image it
    /// was given, at most one octet longer than `longest`. That may be one of an owner before that has not reached the
    /// disk yet. `None`: there is no file.
    ///
    /// # Errors
    /// [`StateDirError::Owned`], [`StateDirError::File`].
    pub(crate) fn file<G: Copy>(
        &self,
        name: &str,
        longest: usize,
    ) -> Result<(ImageFile<G>, Option<Newest>), StateDirError> {
        let name = format!("{name}{EXTENSION}");
        let newest = self.slots.own(&name, longest)?;
        Ok((ImageFile::new(Arc::clone(&self.slots), name), newest))
    }
}

/// The newest image of a unit that is taken into use.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Newest {
    /// The image.
    pub octets: Vec<u8>,
    /// It is on the disk. If not, the unit must hand it over again.
    pub safe: bool,
}

impl Drop for StateDir {
    fn drop(&mut self) {
        let names = self.slots.close(self.writer.is_some());
        // One that hangs in the disk is not waited for.
        if let Some(writer) = self.writer.take_if(|_| self.slots.has_ended()) {
            let _ = writer.join();
        }
        if !names.is_empty() {
            tracing::error!(
                "{}: the newest EEPROM images are not stored: {}",
                self.path.display(),
                names.join(", ")
            );
        }
    }
}
