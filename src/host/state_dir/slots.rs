//! Which files have an owner, which images wait, and the writer.
//!
//! One slot per file that has an owner or an image that is not safe: nothing else is remembered.
//!
//! | newest image | becomes | when |
//! | --- | --- | --- |
//! | waits | is being written | the writer takes it |
//! | is being written | safe, forgotten | it is on the disk |
//! | is being written | failed | the file is surely as before: the owner is told |
//! | is being written | waits again | what the file holds is not known, or nobody owns it: later |
//! | any | waits | the owner hands over a newer one |
//! | failed | waits again | its owner goes |

use crate::map::Map;
use core::time::Duration;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use super::disk::Disk;
use super::{EXTENSION, Newest, StateDirError, TEMPORARY};

/// How long closing waits for a disk that does not answer.
const PATIENCE: Duration = Duration::from_secs(5);

/// After this time the writer tries again by itself.
const RETRY: Duration = Duration::from_secs(1);

/// What the owners of the files and the writer have in common.
#[derive(Debug)]
pub(super) struct Slots {
    directory: PathBuf,
    disk: Box<dyn Disk>,
    state: Mutex<State>,
    changed: Condvar,
}

/// Numbers the images of all files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Ticket(u64);

#[derive(Debug, Default)]
struct State {
    slots: Map<String, Slot>,
    last_ticket: Ticket,
    /// The file written last: the next in turn is the one behind it.
    last_name: String,
    /// The writer ends once nothing waits.
    closing: bool,
    /// The writer has ended.
    ended: bool,
}

/// One file, and what is to be done with it.
#[derive(Debug, Default)]
struct Slot {
    owned: bool,
    /// The newest image, until it is safe.
    newest: Option<Image>,
    /// The newest image that became safe, and one after it that failed: what the owner was not told yet.
    stored: Option<Ticket>,
    failed: Option<Ticket>,
    /// An image that was not acknowledged may be in the file or not.
    in_doubt: bool,
    /// The last write failed, which was said.
    failing: bool,
    /// That it is stored again is said when the owner asks what became of it: it has told of the failure then.
    again: bool,
}

#[derive(Debug)]
struct Image {
    ticket: Ticket,
    octets: Arc<[u8]>,
    stage: Stage,
}

/// How far an image is on its way to safety.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// The writer shall take it.
    Waits,
    /// The writer shall try once more then.
    WaitsUntil(Instant),
    BeingWritten,
    /// Its owner was told, and hands over another one.
    Failed,
}

/// Why an image is not safe.
#[derive(Debug)]
enum WriteError {
    /// The file is as before.
    AsBefore(io::Error),
    /// The file may hold the image, now or after a power failure.
    InDoubt(io::Error),
}

/// What the writer does next.
enum Next {
    Write(String, Ticket, Arc<[u8]>),
    /// Nothing, until something changes or this time.
    Wait(Option<Instant>),
}

impl Slots {
    pub(super) fn new(directory: &Path, disk: Box<dyn Disk>) -> Self {
        let (state, changed) = (Mutex::default(), Condvar::new());
        Self { directory: directory.to_owned(), disk, state, changed }
    }

    pub(super) fn path(&self, name: &str) -> PathBuf {
        self.directory.join(name)
    }

    /// Removes what a killed process left half written, and makes safe which files there are: what is read from now on
    /// is still there after a power failure.
    pub(super) fn tidy(&self) -> io::Result<()> {
        for name in self.disk.names()? {
            if name.starts_with('.') && name.ends_with(TEMPORARY) {
                self.disk.remove(&name)?;
            }
        }
        self.disk.sync_names()
    }

    /// Takes a file for one owner, and says what its newest image is.
    pub(super) fn own(&self, name: &str, longest: usize) -> Result<Option<Newest>, StateDirError> {
        let path = || self.path(name);
        let mut state = self.lock();
        let slot = state.slots.or_default(name.to_owned());
        if slot.owned {
            return Err(StateDirError::Owned { path: path() });
        }
        slot.owned = true;
        // Of the owner before, who waits for it no more.
        (slot.stored, slot.failed) = (None, None);
        if let Some(newest) = &slot.newest {
            return Ok(Some(Newest { octets: newest.octets.to_vec(), safe: false }));
        }
        drop(state);
        // Nobody else has the name, so nobody writes the file.
        let read = self.disk.read(name, longest.saturating_add(1));
        let read = read.map_err(|source| StateDirError::File { path: path(), source });
        if read.is_err() {
            self.disown(name);
        }
        Ok(read?.map(|octets| Newest { octets, safe: true }))
    }

    /// The owner of a file has gone. What it handed over last is written all the same.
    pub(super) fn disown(&self, name: &str) {
        let mut state = self.lock();
        if let Some(slot) = state.slots.get_mut(name) {
            slot.owned = false;
            if core::mem::take(&mut slot.again) {
                self.say_stored_again(name);
            }
            match &mut slot.newest {
                None => drop(state.slots.remove(name)),
                Some(Image { stage: stage @ Stage::Failed, .. }) => *stage = Stage::Waits,
                Some(_) => {}
            }
        }
        drop(state);
        self.changed.notify_all();
    }

    /// Hands over the newest image of a file. Says whether it replaces one that nobody had begun to write.
    pub(super) fn store(&self, name: &str, octets: Vec<u8>) -> (Ticket, bool) {
        let mut state = self.lock();
        let ticket = Ticket(state.last_ticket.0.wrapping_add(1));
        state.last_ticket = ticket;
        let mut replaced = false;
        if let Some(slot) = state.slots.get_mut(name) {
            let before = slot.newest.replace(Image { ticket, octets: octets.into(), stage: Stage::Waits });
            replaced =
                before.is_some_and(|before| matches!(before.stage, Stage::Waits | Stage::WaitsUntil(_)));
        }
        drop(state);
        self.changed.notify_all();
        (ticket, replaced)
    }

    /// What became of images of a file, each once, the oldest first.
    pub(super) fn outcome(&self, name: &str) -> Option<(Ticket, bool)> {
        let mut state = self.lock();
        let slot = state.slots.get_mut(name)?;
        let stored = slot.stored.take().map(|ticket| (ticket, true));
        if stored.is_some() && core::mem::take(&mut slot.again) {
            self.say_stored_again(name);
        }
        stored.or_else(|| slot.failed.take().map(|ticket| (ticket, false)))
    }

    /// Writes an image now and waits for it, for the first image of a unit.
    ///
    /// # Errors
    /// [`StateDirError::File`].
    pub(super) fn store_now(&self, name: &str, octets: &[u8]) -> Result<(), StateDirError> {
        self.replace(name, octets).map_err(|error| match error {
            WriteError::AsBefore(source) | WriteError::InDoubt(source) => {
                StateDirError::File { path: self.path(name), source }
            }
        })
    }

    /// The writer: images as they come, each file in its turn, until it is closed and nothing waits.
    pub(super) fn write_all(&self) {
        let mut state = self.lock();
        loop {
            match state.next(Instant::now()) {
                Next::Write(name, ticket, octets) => {
                    drop(state);
                    self.write(&name, ticket, &octets);
                    state = self.lock();
                }
                Next::Wait(_) if state.closing => break,
                Next::Wait(None) => {
                    state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
                }
                Next::Wait(Some(due)) => {
                    let time = due.saturating_duration_since(Instant::now());
                    let (woken, _) =
                        self.changed.wait_timeout(state, time).unwrap_or_else(PoisonError::into_inner);
                    state = woken;
                }
            }
        }
        state.ended = true;
        drop(state);
        self.changed.notify_all();
    }

    /// Writes the next image that waits, whenever it is due. `false`: none waits.
    pub(super) fn write_next(&self) -> bool {
        let next = self.lock().next(Instant::now() + RETRY);
        match next {
            Next::Write(name, ticket, octets) => {
                self.write(&name, ticket, &octets);
                true
            }
            Next::Wait(_) => false,
        }
    }

    /// How many files are remembered.
    #[cfg(test)]
    pub(super) fn len(&self) -> usize {
        self.lock().slots.len()
    }

    /// Lets the writer, if there is one, end once everything was tried once more. Says which images are not safe.
    pub(super) fn close(&self, has_writer: bool) -> Vec<String> {
        let mut state = self.lock();
        state.closing = true;
        for slot in state.slots.values_mut() {
            if let Some(Image { stage: stage @ (Stage::WaitsUntil(_) | Stage::Failed), .. }) =
                &mut slot.newest
            {
                *stage = Stage::Waits;
            }
        }
        self.changed.notify_all();
        let (state, _) = self
            .changed
            .wait_timeout_while(state, PATIENCE, |state| has_writer && !state.ended)
            .unwrap_or_else(PoisonError::into_inner);
        let unsafe_slots = state.slots.iter().filter(|(_, slot)| slot.newest.is_some());
        unsafe_slots.map(|(name, _)| name.clone()).collect()
    }

    /// Whether the writer has ended.
    pub(super) fn has_ended(&self) -> bool {
        self.lock().ended
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        // No call here panics halfway through a change: a poisoned lock guards whole data.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn say_stored_again(&self, name: &str) {
        tracing::info!("{} is stored again", self.path(name).display());
    }

    fn write(&self, name: &str, ticket: Ticket, octets: &[u8]) {
        let written = self.replace(name, octets);
        let mut state = self.lock();
        let closing = state.closing;
        let Some(slot) = state.slots.get_mut(name) else { return };
        slot.say(&self.path(name), &written);
        let newest = slot.newest.as_mut().filter(|newest| newest.ticket == ticket);
        match written {
            Ok(()) => {
                slot.in_doubt = false;
                (slot.stored, slot.failed) = (Some(ticket), None);
                if newest.is_some() {
                    slot.newest = None;
                }
            }
            Err(error) => {
                slot.in_doubt |= matches!(error, WriteError::InDoubt(_));
                // If there is a newer one, that decides.
                if let Some(newest) = newest {
                    newest.stage = if closing || (slot.owned && !slot.in_doubt) {
                        Stage::Failed
                    } else {
                        Stage::WaitsUntil(Instant::now() + RETRY)
                    };
                    if !slot.in_doubt {
                        slot.failed = Some(ticket);
                    }
                }
            }
        }
        if !slot.owned && slot.newest.is_none() {
            state.slots.remove(name);
        }
        drop(state);
        self.changed.notify_all();
    }

    /// Replaces a file: whoever reads it, whatever happens meanwhile, finds all the octets before or all those after.
    /// They are on the disk when this returns without error.
    fn replace(&self, name: &str, octets: &[u8]) -> Result<(), WriteError> {
        // A hidden name, which only the process that holds the lock uses, and of it only who has the name.
        let temporary = format!(".{}{TEMPORARY}", name.strip_suffix(EXTENSION).unwrap_or(name));
        let renamed = self
            .disk
            .write(&temporary, octets)
            .and_then(|()| self.disk.sync(&temporary))
            .and_then(|()| self.disk.rename(&temporary, name));
        if let Err(error) = renamed {
            // What remains is removed at the next start at the latest.
            let _ = self.disk.remove(&temporary);
            return Err(WriteError::AsBefore(error));
        }
        self.disk.sync_names().map_err(WriteError::InDoubt)
    }
}

impl State {
    /// The next image to write at `now`, of a file behind the last one first.
    fn next(&mut self, now: Instant) -> Next {
        let due = |slot: &Slot| match slot.newest.as_ref()?.stage {
            Stage::Waits => Some(now),
            Stage::WaitsUntil(due) => Some(due),
            Stage::BeingWritten | Stage::Failed => None,
        };
        let is_due = |slot: &Slot| due(slot).is_some_and(|due| due <= now);
        let last = core::mem::take(&mut self.last_name);
        let mut behind = self.slots.iter().filter(|(name, _)| *name > last);
        let name = behind
            .find(|(_, slot)| is_due(slot))
            .or_else(|| self.slots.iter().find(|(_, slot)| is_due(slot)));
        let name = name.map(|(name, _)| name.clone());
        if let Some(name) = name
            && let Some(newest) = self.slots.get_mut(&name).and_then(|slot| slot.newest.as_mut())
        {
            newest.stage = Stage::BeingWritten;
            self.last_name.clone_from(&name);
            return Next::Write(name, newest.ticket, Arc::clone(&newest.octets));
        }
        self.last_name = last;
        Next::Wait(self.slots.values().filter_map(due).min())
    }
}

impl Slot {
    /// Says what became of an image to the user, when it changes.
    fn say(&mut self, path: &Path, written: &Result<(), WriteError>) {
        let path = path.display();
        match written {
            Ok(()) if self.failing && self.owned => self.again = true,
            Ok(()) if self.failing => tracing::info!("{path} is stored again"),
            Ok(()) => {}
            Err(WriteError::AsBefore(error) | WriteError::InDoubt(error)) if self.failing => {
                tracing::debug!("cannot store {path}: {error}");
            }
            Err(WriteError::AsBefore(error)) => tracing::error!(
                "cannot store {path}: {error}; the drive goes on, but refuses to write parameters until it can; {}",
                super::advice(error)
            ),
            Err(WriteError::InDoubt(error)) => tracing::error!(
                "cannot make {path} safe: {error}; the drive goes on, but does not answer writes of parameters until \
                 it can; {}",
                super::advice(error)
            ),
        }
        self.failing = written.is_err();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A disk that is full at first.
    #[derive(Debug)]
    struct FullAtFirst(Mutex<bool>);

    impl Disk for FullAtFirst {
        fn read(&self, _: &str, _: usize) -> io::Result<Option<Vec<u8>>> {
            Ok(None)
        }
        fn write(&self, _: &str, _: &[u8]) -> io::Result<()> {
            let full = core::mem::take(&mut *self.0.lock().unwrap());
            if full { Err(io::ErrorKind::StorageFull.into()) } else { Ok(()) }
        }
        fn sync(&self, _: &str) -> io::Result<()> {
            Ok(())
        }
        fn rename(&self, _: &str, _: &str) -> io::Result<()> {
            Ok(())
        }
        fn sync_names(&self) -> io::Result<()> {
            Ok(())
        }
        fn remove(&self, _: &str) -> io::Result<()> {
            Ok(())
        }
        fn names(&self) -> io::Result<Vec<String>> {
            Ok(Vec::new())
        }
    }

    #[test]
    fn that_it_is_stored_again_is_said_behind_the_failure_that_its_owner_tells() {
        let slots = Slots::new(Path::new("/state"), Box::new(FullAtFirst(Mutex::new(true))));
        slots.own("a", 9).unwrap();
        let waits = || slots.lock().slots.get("a").unwrap().again;
        let (failed, _) = slots.store("a", vec![1]);
        slots.write("a", failed, &[1]);
        assert_eq!((slots.outcome("a"), waits()), (Some((failed, false)), false));
        let (stored, _) = slots.store("a", vec![2]);
        slots.write("a", stored, &[2]);
        assert!(waits(), "not by the writer, whose lines may come before those of the owner");
        assert_eq!((slots.outcome("a"), waits()), (Some((stored, true)), false));
    }
}
