//! The EEPROM of a device whose images the host keeps (manual chapter 6; `ag03.md` 3.1, column EE).
//!
//! ```text
//! PKW write ─▶ value acts ─▶ poll_image ─▶ host writes ─▶ handle_stored ─▶ reply to the master
//!                                                    └─ failed: value goes back, reply is error 18
//! ```
//!
//! No clock and no file here: the device offers its newest image, the host says what became of it. Only the newest
//! counts; an image holds everything, so one that is safe makes all before it safe.

use thiserror::Error;

use super::{Device, Event, Parts};
use crate::drive::{Drive, FaultBuffer, Memory, Settings};
use crate::param::{DefaultSet, IMAGE_LEN, Image};
use crate::time::Instant;

/// Where the EEPROM of a device is kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Eeprom {
    /// In the device, for as long as it lives. Writes are acknowledged at once, and no image is offered.
    #[default]
    Internal,
    /// By the host: it takes every image from [`Device::poll_image`] and reports with [`Device::handle_stored`]. A
    /// write is acknowledged only after that.
    Host,
}

/// How safe what the EEPROM holds is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum EepromState {
    /// [`Eeprom::Internal`]: kept for as long as the device lives.
    Internal,
    /// The newest image is not written yet.
    Writing,
    /// The host keeps the newest image.
    Safe,
    /// The host could not keep the newest image; it is offered again with the next change.
    Failed,
}

/// Numbers the images of one device: a later image has a larger number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Generation(u64);

/// An image the host shall keep instead of all before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StoreRequest {
    /// To be reported with it.
    pub generation: Generation,
    /// The image, for [`Device::restore`].
    pub octets: [u8; IMAGE_LEN],
}

/// The host could not keep an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("the EEPROM image could not be stored")]
pub struct NotStored;

impl Device {
    /// What the drive would keep if it were switched off now.
    pub fn image(&self) -> [u8; IMAGE_LEN] {
        Image { shaft: self.part.drive.shaft(), ..self.part.image() }.encode()
    }

    /// How safe what the drive keeps is.
    pub fn eeprom_state(&self) -> EepromState {
        match self.part.storage.as_ref().map(|storage| storage.progress) {
            None => EepromState::Internal,
            Some(Progress::Offered | Progress::Taken) => EepromState::Writing,
            Some(Progress::Safe) => EepromState::Safe,
            Some(Progress::Failed) => EepromState::Failed,
        }
    }

    /// The image to keep, if it differs from the one taken before and [`Eeprom::Host`] is configured. Changes with
    /// every `handle_*`; poll it when those of the contract are drained.
    ///
    /// The shaft position is in it as of the last standstill.
    #[must_use = "it is not offered again"]
    pub fn poll_image(&mut self) -> Option<StoreRequest> {
        self.part.storage.as_mut()?.take()
    }

    /// The host says what became of an image. Only reports on the newest image taken are needed: older ones may be left
    /// out.
    ///
    /// When the newest image could not be kept, what PKW jobs wrote since the last safe one goes back to what it was:
    /// the waiting job is answered with error 18 and has changed nothing. Everything else (faults, position) stays,
    /// and is in the image that is offered with the next change or write.
    pub fn handle_stored(&mut self, now: Instant, generation: Generation, outcome: Result<(), NotStored>) {
        self.part.advance(now);
        match outcome {
            Ok(()) => self.part.stored(generation),
            Err(NotStored) => self.part.not_stored(generation),
        }
        self.part.wake(now);
    }
}

/// What is to be kept and what is safe.
#[derive(Clone, Debug)]
pub(super) struct Storage {
    /// The newest image, its number, and how far it is.
    newest: Image,
    generation: Generation,
    progress: Progress,
    unsafe_writes: Option<UnsafeWrites>,
}

/// How far an image is on its way to safety.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Progress {
    /// The host may take it.
    Offered,
    /// The host has taken it.
    Taken,
    /// The host keeps it.
    Safe,
    /// The host could not keep it. It is not offered again by itself: the host is not flooded.
    Failed,
}

/// PKW jobs have written what is not safe yet.
#[derive(Clone, Debug)]
struct UnsafeWrites {
    /// The image that makes them safe.
    generation: Generation,
    /// What was before them.
    before: Image,
}

impl Storage {
    /// `fresh` if the host does not have `image` yet.
    pub(super) fn new(eeprom: Eeprom, image: Image, fresh: bool) -> Option<Self> {
        let progress = if fresh { Progress::Offered } else { Progress::Safe };
        match eeprom {
            Eeprom::Internal => None,
            Eeprom::Host => {
                Some(Self { newest: image, generation: Generation(0), progress, unsafe_writes: None })
            }
        }
    }

    /// A factory reset is not undone with the writes before it.
    pub(super) fn reset(&mut self, set: DefaultSet) {
        if let Some(writes) = &mut self.unsafe_writes {
            writes.before.store.load_defaults(set);
        }
    }

    fn take(&mut self) -> Option<StoreRequest> {
        match self.progress {
            Progress::Offered => {
                self.progress = Progress::Taken;
                Some(StoreRequest { generation: self.generation, octets: self.newest.encode() })
            }
            Progress::Taken | Progress::Safe | Progress::Failed => None,
        }
    }

    /// Takes an image over as the newest if it differs from the one before.
    fn note(&mut self, image: Image) {
        if image != self.newest {
            self.newest = image;
            self.offer();
        }
    }

    /// The newest image is to be kept, be it the same as before.
    pub(super) fn offer(&mut self) {
        self.generation = Generation(self.generation.0.saturating_add(1));
        self.progress = Progress::Offered;
    }

    /// A write was executed that `newest` holds. Says whether it has to wait.
    fn expect_safe(&mut self, before: Image) -> bool {
        match self.progress {
            Progress::Safe => return false,
            Progress::Failed => self.offer(),
            Progress::Offered | Progress::Taken => {}
        }
        // Writes that an earlier image was to make safe are safe with this one.
        let before = self.unsafe_writes.take().map_or(before, |writes| writes.before);
        self.unsafe_writes = Some(UnsafeWrites { generation: self.generation, before });
        true
    }
}

/// Puts the drive where the image says.
pub(super) fn recall(drive: &mut Drive, image: &Image) {
    drive.set_memory(memory(image));
    drive.set_shaft(image.shaft);
}

fn memory(image: &Image) -> Memory {
    Memory { faults: FaultBuffer::kept(image.fault_buffer, image.fault_count), zero: image.zero }
}

impl Parts {
    /// What the EEPROM and the encoder hold now; a shaft that moves is shown where it stood last.
    pub(super) fn image(&self) -> Image {
        let Memory { faults, zero } = self.drive.memory();
        let stood = self.storage.as_ref().filter(|_| self.status.moving).map(|storage| storage.newest.shaft);
        let shaft = stood.unwrap_or_else(|| self.drive.shaft());
        let mut store = self.store.clone();
        // Without what is not kept, so that it makes no difference.
        store.power_on();
        Image { store, fault_buffer: faults.codes(), fault_count: faults.count(), zero, shaft }
    }

    /// Offers a new image if anything in it has changed.
    pub(super) fn note_changes(&mut self) {
        let image = self.storage.is_some().then(|| self.image());
        if let (Some(storage), Some(image)) = (&mut self.storage, image) {
            storage.note(image);
        }
    }

    /// Whether the write just executed has to wait for the EEPROM, be it because the value it found there is not safe
    /// yet. `before` is the image before it.
    pub(super) fn must_be_stored(&mut self, before: Image) -> bool {
        let image = self.image();
        self.storage.as_mut().is_some_and(|storage| {
            storage.note(image);
            storage.expect_safe(before)
        })
    }

    fn stored(&mut self, generation: Generation) {
        let Some(storage) = &mut self.storage else {
            return;
        };
        if storage.generation == generation {
            storage.progress = Progress::Safe;
        }
        if storage.unsafe_writes.take_if(|writes| writes.generation <= generation).is_some() {
            self.engine.stored();
        }
    }

    fn not_stored(&mut self, generation: Generation) {
        // A newer one is on its way and decides.
        let Some(storage) = self.storage.as_mut().filter(|storage| storage.generation == generation) else {
            return;
        };
        storage.progress = Progress::Failed;
        let Some(UnsafeWrites { before, .. }) = storage.unsafe_writes.take() else {
            return;
        };
        let Memory { faults, zero } = memory(&before);
        let entered_since = self.drive.faults().clone();
        // A job can only have cleared the buffer. What was entered in that short time is not thrown away.
        let faults = if entered_since == FaultBuffer::default() { faults } else { entered_since };
        self.drive.set_memory(Memory { faults, zero });
        self.store = before.store;
        self.settings = Settings::read(&self.store);
        if let Some(refusal) = self.engine.store_failed() {
            self.events.push(Event::JobRefused(refusal));
        }
        // The file may hold what was refused.
        self.note_changes();
    }
}
