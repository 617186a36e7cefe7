//! The file of one unit, as its owner uses it.

use core::time::Duration;
use std::path::PathBuf;
use std::sync::Arc;

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

    /// Its host ends: what loses something without supply is switched off.
    fn switch_off(&mut self, _now: Instant) {}
}

/// The file of one unit. No other unit gets it before this is dropped; what was handed over by then is still written,
/// and is what the next owner of the file begins with.
#[derive(Debug)]
pub(crate) struct ImageFile<G> {
    slots: Arc<Slots>,
    name: String,
    /// Images handed over whose outcome is not known, the newest last. Those before it were being written when the next
    /// one came.
    handed_over: Vec<(Ticket, G)>,
    look_again: Option<Instant>,
}

impl<G: Copy> ImageFile<G> {
    pub(super) const fn new(slots: Arc<Slots>, name: String) -> Self {
        Self { slots, name, handed_over: Vec::new(), look_again: None }
    }

    /// Writes the first image of a unit, and returns when it is safe. There must be no file yet.
    ///
    /// # Errors
    /// [`StateDirError::File`].
    pub(crate) fn store_first(&self, octets: &[u8]) -> Result<(), StateDirError> {
        self.slots.store_now(&self.name, octets)
    }

    /// Its path.
    pub(crate) fn path(&self) -> PathBuf {
        self.slots.path(&self.name)
    }

    /// Tells the unit what became of its images. Call it before anything is done to the unit.
    pub(crate) fn report_to(&mut self, now: Instant, unit: &mut impl Images<Generation = G>) {
        while !self.handed_over.is_empty()
            && let Some((ticket, stored)) = self.slots.outcome(&self.name)
        {
            // One that is not here belongs to an owner before.
            let known = self.handed_over.iter().position(|(handed_over, _)| *handed_over == ticket);
            if let Some((_, generation)) = known.and_then(|place| self.handed_over.drain(..=place).last()) {
                unit.handle_stored(now, generation, stored);
            }
        }
    }

    /// Hands over the newest image of the unit. Call it when something was done to the unit. One that still waits is
    /// replaced: the newer one holds all it holds.
    pub(crate) fn take_from(&mut self, now: Instant, unit: &mut impl Images<Generation = G>) {
        if let Some((generation, octets)) = unit.poll_image() {
            let (ticket, replaced) = self.slots.store(&self.name, octets);
            if replaced {
                self.handed_over.pop();
            }
            self.handed_over.push((ticket, generation));
        }
        self.look_again = (!self.handed_over.is_empty()).then(|| now.saturating_add(LOOK_AGAIN));
    }

    /// When to call [`ImageFile::report_to`] again.
    pub(crate) const fn poll_timeout(&self) -> Option<Instant> {
        self.look_again
    }
}

impl<G> Drop for ImageFile<G> {
    fn drop(&mut self) {
        self.slots.disown(&self.name);
    }
}
