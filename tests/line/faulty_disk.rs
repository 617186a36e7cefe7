//! A disk in memory that fails on purpose, dies with its process, and forgets what was not synced.

use std::collections::BTreeMap;
use std::io;
use std::sync::{Arc, Mutex, MutexGuard};

use profidrive::host::Disk;

/// What a disk does not do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Failing {
    pub(crate) write: bool,
    pub(crate) sync: bool,
    pub(crate) rename: bool,
    pub(crate) sync_names: bool,
}

/// A handle; clones are the same disk.
#[derive(Clone, Debug, Default)]
pub(crate) struct FaultyDisk(Arc<Mutex<Medium>>);

type Names = BTreeMap<String, usize>;

#[derive(Debug, Default)]
struct Medium {
    /// What processes see.
    names: Names,
    /// Every state of the names since they were last synced: a power failure leaves any of them.
    unsynced: Vec<Names>,
    files: Vec<File>,
    failing: Failing,
    /// Calls until the process is killed.
    lives: Option<u32>,
    dead: bool,
}

#[derive(Debug)]
struct File {
    octets: Vec<u8>,
    synced: bool,
}

impl FaultyDisk {
    fn medium(&self) -> MutexGuard<'_, Medium> {
        self.0.lock().unwrap()
    }

    pub(crate) fn fail(&self, failing: Failing) {
        self.medium().failing = failing;
    }

    /// The process that uses the disk is killed in the middle of so many calls from now.
    pub(crate) fn kill_after(&self, calls: u32) {
        self.medium().lives = Some(calls);
    }

    /// The process is dead: nothing it calls has an effect.
    pub(crate) fn kill(&self) {
        self.medium().dead = true;
    }

    /// The power failed as well: of what was not synced, some is there and some is not.
    pub(crate) fn power_failure(&self, chance: usize) {
        let mut medium = self.medium();
        let states = medium.unsynced.len();
        if states > 0 {
            medium.names = medium.unsynced[chance % states].clone();
        }
        for file in medium.files.iter_mut().filter(|file| !file.synced) {
            file.octets.truncate(chance % (file.octets.len() + 1));
            file.synced = true;
        }
    }

    /// The next process finds it in order.
    pub(crate) fn revive(&self) {
        let mut medium = self.medium();
        (medium.dead, medium.lives, medium.failing) = (false, None, Failing::default());
        medium.unsynced.clear();
    }
}

impl Medium {
    /// What a call may do: all of it, half of it and fail, or nothing and fail.
    fn call(&mut self, fails: bool) -> Call {
        match &mut self.lives {
            _ if self.dead => return Call::None,
            Some(0) => {
                self.dead = true;
                return Call::Half;
            }
            Some(lives) => *lives -= 1,
            None => {}
        }
        if fails { Call::Half } else { Call::Whole }
    }

    fn rename(&mut self, change: impl FnOnce(&mut Names)) {
        if self.unsynced.is_empty() {
            self.unsynced.push(self.names.clone());
        }
        change(&mut self.names);
        self.unsynced.push(self.names.clone());
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Call {
    Whole,
    Half,
    None,
}

impl Call {
    fn outcome(self) -> io::Result<()> {
        if self == Self::Whole { Ok(()) } else { Err(io::Error::other("on purpose")) }
    }
}

impl Disk for FaultyDisk {
    fn read(&self, name: &str, most: usize) -> io::Result<Option<Vec<u8>>> {
        let mut medium = self.medium();
        medium.call(false).outcome()?;
        let file = medium.names.get(name).map(|&file| &medium.files[file]);
        Ok(file.map(|file| file.octets[..file.octets.len().min(most)].to_vec()))
    }

    fn write(&self, name: &str, octets: &[u8]) -> io::Result<()> {
        let mut medium = self.medium();
        let fails = medium.failing.write;
        let call = medium.call(fails);
        if call == Call::None {
            return call.outcome();
        }
        let len = if call == Call::Whole { octets.len() } else { octets.len() / 2 };
        medium.files.push(File { octets: octets[..len].to_vec(), synced: false });
        let file = medium.files.len() - 1;
        medium.rename(|names| _ = names.insert(name.to_owned(), file));
        call.outcome()
    }

    fn sync(&self, name: &str) -> io::Result<()> {
        let mut medium = self.medium();
        let fails = medium.failing.sync;
        let call = medium.call(fails);
        let file = medium.names.get(name).copied().ok_or(io::ErrorKind::NotFound)?;
        medium.files[file].synced |= call == Call::Whole;
        call.outcome()
    }

    fn rename(&self, from: &str, to: &str) -> io::Result<()> {
        let mut medium = self.medium();
        let fails = medium.failing.rename;
        let call = medium.call(fails);
        if call == Call::Whole {
            let file = medium.names.get(from).copied().ok_or(io::ErrorKind::NotFound)?;
            medium.rename(|names| {
                names.remove(from);
                names.insert(to.to_owned(), file);
            });
        }
        call.outcome()
    }

    fn sync_names(&self) -> io::Result<()> {
        let mut medium = self.medium();
        let fails = medium.failing.sync_names;
        let call = medium.call(fails);
        if call == Call::Whole {
            medium.unsynced.clear();
        }
        call.outcome()
    }

    fn remove(&self, name: &str) -> io::Result<()> {
        let mut medium = self.medium();
        let call = medium.call(false);
        if call == Call::Whole {
            medium.rename(|names| _ = names.remove(name));
        }
        call.outcome()
    }

    fn names(&self) -> io::Result<Vec<String>> {
        let mut medium = self.medium();
        medium.call(false).outcome()?;
        Ok(medium.names.keys().cloned().collect())
    }
}
