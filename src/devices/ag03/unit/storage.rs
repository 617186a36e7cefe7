//! The EEPROM of a unit whose images the host keeps (manual chapter 6; `ag03.md` 3.1, column EE).
//!
//! ```text
//! acknowledged write ─▶ value acts ─▶ poll_image ─▶ host writes ─▶ handle_stored ─▶ Outcome::Safe: acknowledge
//!                                                             └─ failed: value goes back ─▶ Outcome::Undone: refuse
//! ```
//!
//! No clock and no file here: the unit offers its newest image, the host says what became of it. Only the newest
//! counts; an image holds everything, so one that is safe makes all before it safe.

use thiserror::Error;

use super::{BusSettings, Event, Image, ImageOctets, Unit};
use crate::devices::ag03::drive::{Drive, FaultBuffer, Memory, Settings};
use crate::devices::ag03::param::{DefaultSet, Parameter, Store, Write};

/// Where the EEPROM of a unit is kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Eeprom {
    /// In the unit, for as long as it lives. Writes are acknowledged at once, and no image is offered.
    #[default]
    Internal,
    /// By the host: it takes every image from [`Unit::poll_image`] and reports with [`Unit::handle_stored`]. A write is
    /// acknowledged only after that.
    Host,
}

/// How safe what the EEPROM holds is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum EepromState {
    /// [`Eeprom::Internal`]: kept for as long as the unit lives.
    Internal,
    /// The newest image is not written yet.
    Writing,
    /// The host keeps the newest image.
    Safe,
    /// The host could not keep the newest image; it is offered again with the next change.
    Failed,
}

/// Numbers the images of one unit: a later image has a larger number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Generation(u64);

impl From<u64> for Generation {
    fn from(number: u64) -> Self {
        Self(number)
    }
}

impl From<Generation> for u64 {
    fn from(generation: Generation) -> Self {
        generation.0
    }
}

/// An image the host shall keep instead of all before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StoreRequest {
    /// To be reported with it.
    pub generation: Generation,
    /// The image, for [`Unit::restore`].
    pub octets: ImageOctets,
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
    /// They have been undone: refuse them.
    Undone,
}

impl Unit {
    /// What the unit would keep if it were switched off now.
    pub fn image(&self) -> ImageOctets {
        self.image_with(self.drive.memory())
    }

    /// How safe what the unit keeps is.
    pub fn eeprom_state(&self) -> EepromState {
        match self.storage.as_ref().map(|storage| storage.progress) {
            None => EepromState::Internal,
            Some(Progress::Offered | Progress::Taken) => EepromState::Writing,
            Some(Progress::Safe) => EepromState::Safe,
            Some(Progress::Failed) => EepromState::Failed,
        }
    }

    /// The image to keep, if something in it has changed since the one taken before and [`Eeprom::Host`] is configured.
    ///
    /// The shaft position is in it as of the last standstill.
    #[must_use = "it is not offered again"]
    pub fn poll_image(&mut self) -> Option<StoreRequest> {
        let storage = self.storage.as_mut().filter(|storage| storage.progress == Progress::Offered)?;
        storage.progress = Progress::Taken;
        let (generation, memory) = (storage.generation, storage.memory.clone());
        Some(StoreRequest { generation, octets: self.image_with(memory) })
    }

    /// The host says what became of an image. Only reports on the newest image taken are needed: older ones may be left
    /// out.
    ///
    /// When the newest image could not be kept, what the waiting writes changed since the last safe one goes back to what
    /// it was. Everything else (faults, position, what was written without waiting) stays, and is in the image that is
    /// offered with the next change or write.
    pub fn handle_stored(&mut self, generation: Generation, outcome: Result<(), NotStored>) -> Outcome {
        let Some(storage) = &mut self.storage else {
            return Outcome::None;
        };
        let newest = storage.generation == generation;
        match outcome {
            Ok(()) => {
                if newest {
                    storage.progress = Progress::Safe;
                    self.events.push(Event::Stored);
                }
                match storage.waiting.take_if(|waiting| waiting.generation <= generation) {
                    Some(_) => Outcome::Safe,
                    None => Outcome::None,
                }
            }
            // A newer one is on its way and decides.
            Err(NotStored) if !newest => Outcome::None,
            Err(NotStored) => {
                storage.progress = Progress::Failed;
                let undone = storage.waiting.is_some();
                self.events.push(Event::NotStored { undone });
                let Some(Waiting { undo, .. }) = storage.waiting.take() else {
                    return Outcome::None;
                };
                // The file may hold what was refused.
                if !undo.is_nothing() {
                    storage.offer();
                }
                self.undo(&undo);
                Outcome::Undone
            }
        }
    }

    /// What the bus keeps in the EEPROM.
    pub const fn bus_settings(&self) -> &BusSettings {
        &self.bus
    }

    /// Keeps these octets for the bus. Says whether the bus has to wait for [`Outcome::Safe`] before it acknowledges.
    pub fn keep_bus_settings(&mut self, settings: BusSettings) -> bool {
        let before = core::mem::replace(&mut self.bus, settings);
        let Some(storage) = &mut self.storage else {
            return false;
        };
        if before != settings {
            storage.offer();
        }
        let bus = Some(before).filter(|before| *before != settings);
        storage.expect_safe(Undo { bus, ..Undo::NOTHING })
    }

    fn image_with(&self, memory: Memory) -> ImageOctets {
        Image { store: self.store.clone(), memory, bus: self.bus }.encode()
    }

    /// Offers a new image if faults, zero or the angle of a standing shaft have changed.
    pub(super) fn note_memory(&mut self) {
        if let Some(storage) = &mut self.storage {
            storage.note(&self.drive, self.status.moving);
        }
    }

    /// A write was executed; `before` is what it found. Says whether it has to wait for the EEPROM, be it because the
    /// value it found there is not safe yet. A write that does not wait overrides those that do.
    pub(super) fn note_write(&mut self, write: Write, before: &Store, memory: &Memory, waits: bool) -> bool {
        self.note_memory();
        let Some(storage) = &mut self.storage else {
            return false;
        };
        let changed = |parameter: &Parameter| self.store.value(*parameter) != before.value(*parameter);
        if Parameter::all()
            .filter(|parameter| parameter.entry().persistent)
            .any(|parameter| changed(&parameter))
        {
            storage.offer();
        }
        let undo = Undo::of(write, before, memory, changed);
        if waits && write.is_kept() {
            return storage.expect_safe(undo);
        }
        if let Some(waiting) = &mut storage.waiting {
            waiting.undo.forget(write);
        }
        false
    }

    /// Loads defaults at power-on. A factory reset is not undone with the writes before it.
    pub(super) fn reset(&mut self, set: DefaultSet) {
        self.store.load_defaults(set);
        self.settings = Settings::read(&self.store);
        if let Some(storage) = &mut self.storage {
            if let Some(waiting) = &mut storage.waiting {
                waiting.undo.forget_set(set);
            }
            storage.offer();
        }
    }

    fn undo(&mut self, undo: &Undo) {
        for (parameter, before) in Parameter::all().zip(undo.values) {
            if let Some(before) = before {
                self.store.put(parameter, before);
            }
        }
        self.settings = Settings::read(&self.store);
        if let Some(zero) = undo.zero {
            self.drive.set_zero(zero);
        }
        if let Some(faults) = &undo.faults {
            self.drive.restore_faults(faults.clone());
        }
        self.bus = undo.bus.unwrap_or(self.bus);
        self.refresh_status();
        self.parameters_acted = true;
        self.note_memory();
    }
}

/// What is to be kept and what is safe.
#[derive(Clone, Debug)]
pub(super) struct Storage {
    /// As in the newest image.
    memory: Memory,
    generation: Generation,
    progress: Progress,
    waiting: Option<Waiting>,
}

/// How far the newest image is on its way to safety.
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

/// Writes that are executed but not safe yet.
#[derive(Clone, Debug)]
struct Waiting {
    /// The image that makes them safe.
    generation: Generation,
    undo: Undo,
}

impl Storage {
    /// `fresh` if the host does not have the image yet.
    pub(super) fn new(eeprom: Eeprom, memory: Memory, fresh: bool) -> Option<Self> {
        let progress = if fresh { Progress::Offered } else { Progress::Safe };
        match eeprom {
            Eeprom::Internal => None,
            Eeprom::Host => Some(Self { memory, generation: Generation(0), progress, waiting: None }),
        }
    }

    fn note(&mut self, drive: &Drive, moving: bool) {
        let mut memory = drive.memory();
        if moving {
            memory.shaft = self.memory.shaft;
        }
        if memory != self.memory {
            self.memory = memory;
            self.offer();
        }
    }

    /// The newest image is to be kept, be it the same as before.
    pub(super) fn offer(&mut self) {
        self.generation = Generation(self.generation.0.saturating_add(1));
        self.progress = Progress::Offered;
    }

    fn expect_safe(&mut self, undo: Undo) -> bool {
        match self.progress {
            Progress::Safe => return false,
            Progress::Failed => self.offer(),
            Progress::Offered | Progress::Taken => {}
        }
        // Writes that an earlier image was to make safe are safe with this one.
        let undo = match self.waiting.take() {
            Some(waiting) => waiting.undo.and_then(undo),
            None => undo,
        };
        self.waiting = Some(Waiting { generation: self.generation, undo });
        true
    }
}

/// What the waiting writes found, of everything that they changed.
#[derive(Clone, Debug)]
struct Undo {
    /// In the order of [`Parameter::all`].
    values: [Option<i32>; Parameter::COUNT],
    zero: Option<f64>,
    faults: Option<FaultBuffer>,
    bus: Option<BusSettings>,
}

impl Undo {
    const NOTHING: Self = Self { values: [None; Parameter::COUNT], zero: None, faults: None, bus: None };

    fn of(write: Write, before: &Store, memory: &Memory, changed: impl Fn(&Parameter) -> bool) -> Self {
        let mut undo = Self::NOTHING;
        for (parameter, value) in Parameter::all().zip(&mut undo.values) {
            *value = Some(before.value(parameter)).filter(|_| changed(&parameter));
        }
        match write {
            // Writing the calibration value may calibrate, too.
            Write::Set(Parameter::CalibrationValue, _) | Write::Calibrate => undo.zero = Some(memory.zero),
            Write::ClearFaults => undo.faults = Some(memory.faults.clone()),
            Write::Set(..) | Write::Load(_) => {}
        }
        undo
    }

    fn is_nothing(&self) -> bool {
        let Self { values, zero, faults, bus } = self;
        values.iter().all(Option::is_none) && zero.is_none() && faults.is_none() && bus.is_none()
    }

    /// `self`, then `later`: of what both changed the earlier value counts.
    fn and_then(self, later: Self) -> Self {
        let mut undo = self;
        for (value, later) in undo.values.iter_mut().zip(later.values) {
            *value = value.or(later);
        }
        undo.zero = undo.zero.or(later.zero);
        undo.faults = undo.faults.or(later.faults);
        undo.bus = undo.bus.or(later.bus);
        undo
    }

    /// What was written since without waiting stays, also where it is what a waiting write has written.
    fn forget(&mut self, write: Write) {
        match write {
            Write::Set(written, _) => {
                let of_it =
                    Parameter::all().zip(&mut self.values).find(|(parameter, _)| *parameter == written);
                if let Some((_, value)) = of_it {
                    *value = None;
                }
                if written == Parameter::CalibrationValue {
                    self.zero = None;
                }
            }
            Write::Load(set) => self.forget_set(set),
            Write::Calibrate => self.zero = None,
            Write::ClearFaults => self.faults = None,
        }
    }

    fn forget_set(&mut self, set: DefaultSet) {
        for (parameter, value) in Parameter::all().zip(&mut self.values) {
            *value = value.filter(|_| !set.contains(parameter.setting().group));
        }
    }
}
