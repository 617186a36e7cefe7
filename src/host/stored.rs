//! What is on a bus of either kind, and the file its memory is kept in.

use std::path::PathBuf;

use super::state_dir::{ImageFile, Images};
use crate::time::Instant;

/// A unit whose image may be kept in a [`StateDir`](super::StateDir).
///
/// It hands images to the writer and its reports to the unit. Dropped, a unit with a file is switched off, and what it
/// keeps then is stored.
#[derive(Debug)]
pub struct Stored<U: Images> {
    unit: U,
    file: Option<ImageFile<U::Generation>>,
    now: Instant,
}

impl<U: Images> From<U> for Stored<U> {
    /// A unit whose memory lives as long as it.
    fn from(unit: U) -> Self {
        Self { unit, file: None, now: Instant::ZERO }
    }
}

impl<U: Images> Stored<U> {
    pub(super) fn in_file(unit: U, file: ImageFile<U::Generation>, now: Instant) -> Self {
        let mut this = Self { unit, file: Some(file), now };
        this.hand_over(now);
        this
    }

    /// The file of its memory.
    pub fn path(&self) -> Option<PathBuf> {
        Some(self.file.as_ref()?.path())
    }

    /// The unit itself.
    pub const fn unit(&self) -> &U {
        &self.unit
    }

    /// The unit itself. What it keeps is handed over with the next [`Stored::act`].
    pub const fn unit_mut(&mut self) -> &mut U {
        &mut self.unit
    }

    /// Does something to the unit, which learns before what became of its images; what it keeps then is handed over.
    pub fn act<R>(&mut self, now: Instant, act: impl FnOnce(&mut U) -> R) -> R {
        self.now = now;
        if let Some(file) = &mut self.file {
            file.report_to(now, &mut self.unit);
        }
        let result = act(&mut self.unit);
        self.hand_over(now);
        result
    }

    /// When something was done to it.
    pub(super) const fn now(&self) -> Instant {
        self.now
    }

    /// When to act on the unit that wants this, and again while an image is being written.
    pub(super) fn poll_timeout(&self, wanted: Option<Instant>) -> Option<Instant> {
        Instant::first_of(wanted, self.file.as_ref().and_then(ImageFile::poll_timeout))
    }

    fn hand_over(&mut self, now: Instant) {
        if let Some(file) = &mut self.file {
            file.take_from(now, &mut self.unit);
        }
    }
}

impl<U: Images> Drop for Stored<U> {
    fn drop(&mut self) {
        let now = self.now;
        if self.file.is_some() {
            self.act(now, |unit| unit.switch_off(now));
        }
    }
}
