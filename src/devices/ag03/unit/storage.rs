//! The EEPROM of a unit whose images the host keeps (manual chapter 6; `ag03.md` 3.1, column EE).

use super::{BusSettings, Event, Image, ImageOctets, Unit};
use crate::devices::ag03::drive::{Drive, FaultBuffer, Memory, Settings};
use crate::devices::ag03::param::{DefaultSet, Parameter, Store, Write};
use crate::image::storage::{Newest, Stage};

pub use crate::image::storage::Outcome;
pub use crate::image::{Eeprom, Generation, NotStored};

/// An image the host shall keep, for `Unit::restore`.
pub type StoreRequest = crate::image::StoreRequest<ImageOctets>;

/// How safe what the EEPROM holds is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum EepromState {
    /// [`Eeprom::Internal`]: kept for as long as the unit lives.
    Internal,
    /// The newest image is not written yet.
    Writing,
    /// The host keeps the newest image.
    Safe,
    /// The host could not keep the newest image; it is offered again with the next change.
    Failed,
}

impl Unit {
    /// What the unit would keep if it were switched off now.
    pub(crate) fn image(&self) -> ImageOctets {
        self.image_with(self.drive.memory())
    }

    /// How safe what the unit keeps is.
    pub(crate) fn eeprom_state(&self) -> EepromState {
        match self.storage.as_ref().map(|storage| storage.newest.stage()) {
            None => EepromState::Internal,
            Some(Stage::Offered | Stage::Taken) => EepromState::Writing,
            Some(Stage::Safe) => EepromState::Safe,
            Some(Stage::Failed) => EepromState::Failed,
        }
    }

    /// The host does not keep yet what the unit holds: [`Unit::poll_image`] offers it.
    pub(crate) const fn offer_image(&mut self) {
        if let Some(storage) = &mut self.storage {
            storage.newest.offer();
        }
    }

    /// The image to keep, if something in it has changed since the one taken before and [`Eeprom::Host`] is configured.
    ///
    /// The shaft position is in it as of the last standstill.
    #[must_use = "it is not offered again"]
    pub fn poll_image(&mut self) -> Option<StoreRequest> {
        let storage = self.storage.as_mut()?;
        let generation = storage.newest.take()?;
        let memory = storage.memory.clone();
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
        let newest = storage.newest.generation() == generation;
        let waiting = storage.newest.report(generation, outcome);
        match waiting {
            Outcome::Safe => storage.undo = None,
            Outcome::None | Outcome::Undone => {}
        }
        match outcome {
            Ok(()) if newest => self.events.push(Event::Stored),
            Err(NotStored) if newest => {
                self.events.push(Event::NotStored { undone: waiting == Outcome::Undone });
                self.undo();
            }
            // A newer one is on its way and decides.
            Ok(()) | Err(NotStored) => {}
        }
        waiting
    }

    /// What the bus keeps in the EEPROM.
    pub(crate) const fn bus_settings(&self) -> &BusSettings {
        &self.bus
    }

    /// Keeps these octets for the bus. Says whether the bus has to wait for [`Outcome::Safe`] before it acknowledges.
    pub(crate) fn keep_bus_settings(&mut self, settings: BusSettings) -> bool {
        let before = core::mem::replace(&mut self.bus, settings);
        let Some(storage) = &mut self.storage else {
            return false;
        };
        if before != settings {
            storage.newest.offer();
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
            storage.newest.offer();
        }
        let undo = Undo::of(write, before, memory, changed);
        if waits && write.is_kept() {
            return storage.expect_safe(undo);
        }
        if let Some(undo) = &mut storage.undo {
            undo.forget(write);
        }
        false
    }

    /// Loads defaults at power-on. A factory reset is not undone with the writes before it.
    pub(super) fn reset(&mut self, set: DefaultSet) {
        self.store.load_defaults(set);
        self.settings = Settings::read(&self.store);
        if let Some(storage) = &mut self.storage {
            if let Some(undo) = &mut storage.undo {
                undo.forget_set(set);
            }
            storage.newest.offer();
        }
    }

    /// Takes back what the waiting writes have changed.
    fn undo(&mut self) {
        let Some(storage) = &mut self.storage else { return };
        let Some(undo) = storage.undo.take() else { return };
        // The file may hold what was refused.
        if !undo.is_nothing() {
            storage.newest.offer();
        }
        for (parameter, before) in Parameter::all().zip(undo.values) {
            if let Some(before) = before {
                self.store.put(parameter, before);
            }
        }
        self.settings = Settings::read(&self.store);
        if let Some(zero) = undo.zero {
            self.drive.set_zero(zero);
        }
        if let Some(faults) = undo.faults {
            self.drive.restore_faults(faults);
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
    pub(super) newest: Newest,
    /// What the writes found that are executed but not safe yet.
    undo: Option<Undo>,
}

impl Storage {
    /// `fresh` if the host does not have the image yet.
    pub(super) fn new(eeprom: Eeprom, memory: Memory, fresh: bool) -> Option<Self> {
        match eeprom {
            Eeprom::Internal => None,
            Eeprom::Host => {
                let mut newest = Newest::SAFE;
                if fresh {
                    newest.offer();
                }
                Some(Self { memory, newest, undo: None })
            }
        }
    }

    fn note(&mut self, drive: &Drive, moving: bool) {
        let mut memory = drive.memory();
        if moving {
            memory.shaft = self.memory.shaft;
        }
        if memory != self.memory {
            self.memory = memory;
            self.newest.offer();
        }
    }

    fn expect_safe(&mut self, undo: Undo) -> bool {
        if !self.newest.wait_until_safe() {
            return false;
        }
        // Writes that an earlier image was to make safe are safe with this one.
        self.undo = Some(match self.undo.take() {
            Some(before) => before.and_then(undo),
            None => undo,
        });
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
