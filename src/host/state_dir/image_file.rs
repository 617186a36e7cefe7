//! The file of one unit, as its owner uses it.

use core::time::Duration;
use std::path::PathBuf;
use std::string::String;
use std::sync::Arc;
use std::vec::Vec;

use super::StateDirError;
use super::slots::{Slots, Ticket};
use crate::time::Instant;

/// How often it is looked whether an image is written, while one is. A write takes longer than that, and the master
/// waits for it.
const LOOK_AGAIN: Duration = Duration::from_millis(1);

/// Something whose state is one image, which a host keeps.
pub trait Images {
    /// Tells its images apart: what [`Images::handle_stored`] is told comes from [`Images::poll_image`].
    type Generation: Copy;

    /// The image to keep instead of all before it, if it differs from the one taken before.
    fn poll_image(&mut self) -> Option<(Self::Generation, Vec<u8>)>;

    /// What became of an image; of one replaced by a newer one perhaps nothing is said. `stored` is whether it is safe;
    /// if not, what is kept is surely one of the images before it.
    fn handle_stored(&mut self, now: Instant, generation: Self::Generation, stored: bool);
}

/// The file of one unit. No other unit gets it before this is dropped; what was handed over by then is still written,
/// and is what the next owner of the file begins with.
#[derive(Debug)]
pub struct ImageFile<G> {
    slots: Arc<Slots>,
    name: String,
    /// The newest image handed over, and the one before it that was being written then.
    newest: Option<(Ticket, G)>,
    before: Option<(Ticket, G)>,
    look_again: Option<Instant>,
}

impl<G: Copy> ImageFile<G> {
    pub(super) const fn new(slots: Arc<Slots>, name: String) -> Self {
        Self { slots, name, newest: None, before: None, look_again: None }
    }

    /// Writes the first image of a unit, and returns when it is safe. There must be no file yet.
    ///
    /// # Errors
    /// [`StateDirError::File`].
    pub fn store_first(&self, octets: &[u8]) -> Result<(), StateDirError> {
        self.slots.store_now(&self.name, octets)
    }

    /// Its path.
    pub fn path(&self) -> PathBuf {
        self.slots.path(&self.name)
    }

    /// Tells the unit what became of its images. Call it before anything is done to the unit.
    pub fn report_to(&mut self, now: Instant, unit: &mut impl Images<Generation = G>) {
        if self.newest.is_none() {
            return;
        }
        let Some((ticket, stored)) = self.slots.outcome(&self.name) else {
            return;
        };
        if let Some((_, generation)) = self.newest.take_if(|(newest, _)| *newest == ticket) {
            self.before = None;
            unit.handle_stored(now, generation, stored);
        } else if let Some((_, generation)) = self.before.take_if(|(before, _)| *before == ticket) {
            unit.handle_stored(now, generation, stored);
        }
    }

    /// Hands over the newest image of the unit. Call it when something was done to the unit. One that still waits is
    /// replaced: the newer one holds all it holds.
    pub fn take_from(&mut self, now: Instant, unit: &mut impl Images<Generation = G>) {
        if let Some((generation, octets)) = unit.poll_image() {
            let (ticket, replaced) = self.slots.store(&self.name, octets);
            if let Some(newest) = self.newest.replace((ticket, generation))
                && !replaced
            {
                self.before = Some(newest);
            }
        }
        self.look_again = self.newest.is_some().then(|| now.saturating_add(LOOK_AGAIN));
    }

    /// When to call [`ImageFile::report_to`] again.
    pub const fn poll_timeout(&self) -> Option<Instant> {
        self.look_again
    }
}

impl<G> Drop for ImageFile<G> {
    fn drop(&mut self) {
        self.slots.disown(&self.name);
    }
}
