//! EEPROM images in a directory: one file per drive, replaced whole or not at all.
//!
//! ```text
//! StoredDevice ──newest image──▶ slot ──▶ writer thread ──▶ .NAME.tmp, fsync ──rename──▶ NAME, fsync of the directory
//!              ◀────outcome─────      ◀──
//! ```
//!
//! A write takes as long as the disk takes, tens of milliseconds and more; a master waits less. So one thread writes
//! for all drives of the directory, and the drives go on answering. A slot holds one image, the newest: a slow disk
//! makes no queue.

use core::time::Duration;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::vec::Vec;
use std::{format, string::String};

use thiserror::Error;

use super::StoredDevice;
use super::lock::locked;
use crate::device::{Config, Device, Eeprom, Generation, ImageError, MAX_IMAGE_LEN, NotStored, StoreRequest};
use crate::time::Instant;

/// Held locked while a process uses the directory.
const LOCK: &str = ".lock";
/// How the name of every image ends.
const EXTENSION: &str = ".eeprom";
/// How the name of an image being written ends; it begins with a dot.
const TEMPORARY: &str = ".eeprom.tmp";

/// How long closing waits for a disk that does not answer.
const PATIENCE: Duration = Duration::from_secs(5);

/// Why a directory or an image in it cannot be used. The cause, where there is one, is the error's source.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum StateDirError {
    /// The directory cannot be made, read or written.
    #[error("cannot keep EEPROM images in {}", path.display())]
    Directory {
        /// Its path.
        path: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// Another process uses the directory.
    #[error("{} is used by another running emulator; end that one or choose another directory", path.display())]
    InUse {
        /// Its path.
        path: PathBuf,
    },
    /// The image of a drive cannot be read or written.
    #[error("cannot use the EEPROM image {}", path.display())]
    File {
        /// Its path.
        path: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// The file is no image of this drive.
    #[error(
        "the EEPROM image {} is refused and left as it is: {cause}; to start with factory settings move it away, or \
         choose another directory",
        path.display()
    )]
    Refused {
        /// Its path.
        path: PathBuf,
        /// What is wrong with it.
        cause: ImageError,
    },
}

/// A directory with the EEPROM images of drives, used by this process alone.
///
/// Dropped, it waits until what was handed over is written, at most 5 s.
#[derive(Debug)]
pub struct StateDir {
    path: PathBuf,
    shared: Arc<Shared>,
    _lock: File,
}

impl StateDir {
    /// Takes a directory into use; it is made if it is missing. What a killed process left half written is removed.
    ///
    /// # Errors
    /// [`StateDirError::Directory`], [`StateDirError::InUse`].
    pub fn open(path: &Path) -> Result<Self, StateDirError> {
        let failed = |source| StateDirError::Directory { path: path.to_path_buf(), source };
        fs::create_dir_all(path).map_err(failed)?;
        let lock = OpenOptions::new()
            .create(true)
            .truncate(false)
            .write(true)
            .open(path.join(LOCK))
            .map_err(failed)?;
        if !locked(&lock).map_err(failed)? {
            return Err(StateDirError::InUse { path: path.to_path_buf() });
        }
        remove_temporary_files(path).map_err(failed)?;
        let shared = Arc::new(Shared::default());
        let writer = Arc::clone(&shared);
        thread::Builder::new().name("eeprom".into()).spawn(move || writer.write_all()).map_err(failed)?;
        Ok(Self { path: path.to_path_buf(), shared, _lock: lock })
    }

    /// The drive of this model and address, as its image says; without an image a new one, whose image is written
    /// before this returns.
    ///
    /// # Errors
    /// [`StateDirError::File`], [`StateDirError::Refused`]; the file is as before.
    pub fn load(&self, config: Config, now: Instant) -> Result<StoredDevice, StateDirError> {
        let config = Config { eeprom: Eeprom::Host, ..config };
        let name = format!("{}-{:03}", config.model, config.switches.address().number());
        let path = self.path.join(format!("{name}{EXTENSION}"));
        let failed = |source| StateDirError::File { path: path.clone(), source };
        let device = match read(&path).map_err(failed)? {
            Some(octets) => {
                tracing::info!("EEPROM from {}", path.display());
                Device::restore(config, &octets, now)
                    .map_err(|cause| StateDirError::Refused { path: path.clone(), cause })?
            }
            None => {
                tracing::info!("a new EEPROM in {}", path.display());
                let mut device = Device::new(config, now);
                if let Some(StoreRequest { generation, octets }) = device.poll_image() {
                    replace(&path, &octets).map_err(failed)?;
                    device.handle_stored(now, generation, Ok(()));
                }
                device
            }
        };
        let slot = self.shared.add(path);
        Ok(StoredDevice::new(device, EepromFile { shared: Arc::clone(&self.shared), slot }, now))
    }
}

impl Drop for StateDir {
    fn drop(&mut self) {
        if !self.shared.close() {
            tracing::error!(
                "{} takes no EEPROM images since {PATIENCE:?}: the newest are not stored",
                self.path.display()
            );
        }
    }
}

/// The file of one drive.
#[derive(Debug)]
pub(super) struct EepromFile {
    shared: Arc<Shared>,
    slot: usize,
}

impl EepromFile {
    /// Hands an image over. One that waits is replaced: the newer one holds all it holds.
    pub(super) fn store(&self, request: StoreRequest) {
        if let Some(slot) = self.shared.lock().slots.get_mut(self.slot) {
            slot.waiting = Some(request);
        }
        self.shared.changed.notify_all();
    }

    /// What became of the image written last, once.
    pub(super) fn outcome(&self) -> Option<(Generation, Result<(), NotStored>)> {
        self.shared.lock().slots.get_mut(self.slot)?.outcome.take()
    }
}

/// What the drives and the writer have in common.
#[derive(Debug, Default)]
struct Shared {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct State {
    slots: Vec<Slot>,
    closing: bool,
    closed: bool,
}

/// One file, and what is to be done with it.
#[derive(Debug)]
struct Slot {
    path: PathBuf,
    waiting: Option<StoreRequest>,
    outcome: Option<(Generation, Result<(), NotStored>)>,
    /// The last write failed, which was said.
    failing: bool,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        // No call here panics halfway through a change: a poisoned lock guards whole data.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn add(&self, path: PathBuf) -> usize {
        let mut state = self.lock();
        state.slots.push(Slot { path, waiting: None, outcome: None, failing: false });
        state.slots.len() - 1
    }

    /// Lets the writer end once nothing waits. Says whether it did in time.
    fn close(&self) -> bool {
        self.lock().closing = true;
        self.changed.notify_all();
        let (state, _) = self
            .changed
            .wait_timeout_while(self.lock(), PATIENCE, |state| !state.closed)
            .unwrap_or_else(PoisonError::into_inner);
        state.closed
    }

    /// The writer: images as they come, each drive in its turn, until it is closed.
    fn write_all(&self) {
        let mut last = 0;
        while let Some((index, path, request)) = self.next(last) {
            let outcome = replace(&path, &request.octets);
            if let Some(slot) = self.lock().slots.get_mut(index) {
                slot.report(request.generation, outcome);
            }
            last = index;
        }
        self.lock().closed = true;
        self.changed.notify_all();
    }

    /// Waits for the next image to write, of a drive behind `last` first; `None`: closed and nothing waits.
    fn next(&self, last: usize) -> Option<(usize, PathBuf, StoreRequest)> {
        let mut state = self.lock();
        loop {
            let count = state.slots.len();
            for index in (last + 1..count).chain(0..count.min(last + 1)) {
                if let Some(slot) = state.slots.get_mut(index)
                    && let Some(request) = slot.waiting.take()
                {
                    return Some((index, slot.path.clone(), request));
                }
            }
            if state.closing {
                return None;
            }
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

impl Slot {
    /// Says what became of an image: to the drive each time, to the user when it changes.
    fn report(&mut self, generation: Generation, outcome: io::Result<()>) {
        match &outcome {
            Ok(()) if self.failing => tracing::info!("{} is stored again", self.path.display()),
            Ok(()) => {}
            Err(error) if self.failing => tracing::debug!("cannot store {}: {error}", self.path.display()),
            Err(error) => tracing::error!(
                "cannot store {}: {error}; the drive goes on, but refuses to write parameters until it can",
                self.path.display()
            ),
        }
        self.failing = outcome.is_err();
        self.outcome = Some((generation, outcome.map_err(|_| NotStored)));
    }
}

/// The octets of a file, one more than an image at most; `None` if there is no file.
fn read(path: &Path) -> io::Result<Option<Vec<u8>>> {
    match fs::metadata(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(error),
        // Opening a pipe would wait for its other end.
        Ok(found) if !found.is_file() => return Err(io::Error::other("it is not a file")),
        Ok(_) => {}
    }
    let mut octets = Vec::new();
    File::open(path)?.take(MAX_IMAGE_LEN as u64 + 1).read_to_end(&mut octets)?;
    Ok(Some(octets))
}

/// Replaces a file: whoever reads it, whatever happens meanwhile, finds all the octets before or all those after. They
/// are on the disk when this returns without error.
fn replace(path: &Path, octets: &[u8]) -> io::Result<()> {
    let temporary = temporary_name(path);
    let written = write_new(&temporary, octets).and_then(|()| fs::rename(&temporary, path));
    if written.is_err() {
        // What remains is removed at the next start at the latest.
        let _ = fs::remove_file(&temporary);
        return written;
    }
    sync_directory(path)
}

fn write_new(path: &Path, octets: &[u8]) -> io::Result<()> {
    // Not written through a link that somebody put there.
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        Ok(()) | Err(_) => {}
    }
    let mut file = OpenOptions::new().write(true).create_new(true).open(path)?;
    file.write_all(octets)?;
    file.sync_all()
}

/// Makes the new name of a file in its directory safe.
#[cfg(unix)]
fn sync_directory(path: &Path) -> io::Result<()> {
    let directory = path.parent().filter(|parent| !parent.as_os_str().is_empty());
    File::open(directory.unwrap_or(Path::new(".")))?.sync_all()
}

#[cfg(not(unix))]
fn sync_directory(_: &Path) -> io::Result<()> {
    Ok(())
}

fn remove_temporary_files(directory: &Path) -> io::Result<()> {
    for entry in fs::read_dir(directory)? {
        let name = entry?.file_name();
        if name.to_str().is_some_and(|name| name.starts_with('.') && name.ends_with(TEMPORARY)) {
            fs::remove_file(directory.join(name))?;
        }
    }
    Ok(())
}

/// A hidden name in the same directory, which only the process that holds the lock uses.
fn temporary_name(path: &Path) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let name: String = format!(".{stem}{TEMPORARY}");
    path.with_file_name(name)
}
