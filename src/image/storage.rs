//! How the newest image of a device gets to its host, and the writes that wait for it.
//!
//! ```text
//! acknowledged write ─▶ value acts ─▶ take ─▶ host writes ─▶ report ─▶ Outcome::Safe: acknowledge
//!                                                     └─ failed: value goes back ─▶ Outcome::Undone: refuse
//! ```
//!
//! No clock and no file here. Only the newest image counts: it holds everything, so one that is safe makes all before it
//! safe.

use thiserror::Error;

/// Where a device keeps what survives power-off.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Eeprom {
    /// In itself, for as long as it lives. Writes are acknowledged at once, and no image is offered.
    #[default]
    Internal,
    /// By the host: it takes every image and reports what became of it. A write that stores something is acknowledged
    /// only after that.
    Host,
}

/// Numbers the images of one device: a later image has a larger number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Generation(u64);

/// An image the host shall keep instead of all before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StoreRequest<O> {
    /// To be reported with it.
    pub generation: Generation,
    /// The image.
    pub octets: O,
}

/// The host could not keep an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("the EEPROM image could not be stored")]
pub struct NotStored;

/// What a report of the host means for the writes that wait for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[must_use]
pub enum Outcome {
    /// None waits, or they wait on.
    None,
    /// They are safe: acknowledge them.
    Safe,
    /// They are to be undone: refuse them.
    Undone,
}

/// How far the newest image is on its way to safety.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stage {
    /// The host keeps it, or there is nothing to keep.
    Safe,
    /// The host may take it.
    Offered,
    /// The host has taken it.
    Taken,
    /// The host could not keep it. It is not offered again by itself: the host is not flooded.
    Failed,
}

/// The newest image, and the one that an acknowledgement waits for.
#[derive(Clone, Debug)]
pub(crate) struct Newest {
    generation: Generation,
    stage: Stage,
    awaited: Option<Generation>,
}

impl Newest {
    /// Nothing to keep that the host does not have.
    pub(crate) const SAFE: Self = Self { generation: Generation(0), stage: Stage::Safe, awaited: None };

    pub(crate) const fn generation(&self) -> Generation {
        self.generation
    }

    pub(crate) const fn stage(&self) -> Stage {
        self.stage
    }

    /// There is a new one to be kept, be it the same as before.
    pub(crate) const fn offer(&mut self) {
        self.generation = Generation(self.generation.0.saturating_add(1));
        self.stage = Stage::Offered;
    }

    /// The host asks for it; `None`: it has it.
    pub(crate) fn take(&mut self) -> Option<Generation> {
        let offered = self.stage == Stage::Offered;
        offered.then(|| {
            self.stage = Stage::Taken;
            self.generation
        })
    }

    /// An acknowledgement waits for the newest image.
    pub(crate) const fn wait(&mut self) {
        self.awaited = Some(self.generation);
    }

    /// Nobody waits any more.
    pub(crate) const fn forget(&mut self) {
        self.awaited = None;
    }

    pub(crate) const fn is_awaited(&self) -> bool {
        self.awaited.is_some()
    }

    /// An acknowledgement waits until what is kept is safe. Says whether it has to.
    pub(crate) const fn wait_until_safe(&mut self) -> bool {
        match self.stage {
            Stage::Safe => return false,
            Stage::Failed => self.offer(),
            Stage::Offered | Stage::Taken => {}
        }
        self.wait();
        true
    }

    /// The host says what became of an image. One that failed while a newer one is on its way decides nothing.
    pub(crate) fn report(&mut self, generation: Generation, outcome: Result<(), NotStored>) -> Outcome {
        let newest = generation == self.generation;
        let awaited = match outcome {
            Ok(()) => {
                if newest {
                    self.stage = Stage::Safe;
                }
                self.awaited.take_if(|awaited| *awaited <= generation).map(|_| Outcome::Safe)
            }
            Err(NotStored) if newest => {
                self.stage = Stage::Failed;
                self.awaited.take().map(|_| Outcome::Undone)
            }
            Err(NotStored) => None,
        };
        awaited.unwrap_or(Outcome::None)
    }
}
