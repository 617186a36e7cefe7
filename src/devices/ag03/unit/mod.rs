//! A powered unit of the AG03 family, without a bus: drive, parameters, EEPROM, supplies, power, DIP switches.
//!
//! A bus owns one [`Unit`]. In each application cycle it says what it wants ([`Command`]) and lets one [step](Unit::step)
//! pass; it reads and writes parameters by whatever keys it has; and it puts [`Status`] into its own words. Which bits,
//! numbers and addresses those are the unit does not know.
//!
//! | file | holds |
//! | --- | --- |
//! | `cycle` | `Cycles`: when the next application cycle runs |
//! | `dip` | [`DipSwitches`]: ten switches |
//! | `drive_state` | the states of the drive in the words that all devices share |
//! | `event` | [`Event`]: what has happened in the unit |
//! | `image` | [`Image`]: what survives power-off, as octets |
//! | `paced` | what can change in every cycle is told at most once a second |
//! | `parameters` | reading and writing parameters, and what a write did |
//! | `power` | [`Power`]: switching off and on, row 1 of `ag03.md` 8 |
//! | `storage` | [`Eeprom`]: images the host keeps, and the acknowledgement that waits for them |
//!
//! ```
//! use core::time::Duration;
//! use profidrive::devices::ag03::drive::{Command, Operation};
//! use profidrive::devices::ag03::param::{Gear, Model, Parameter, Write};
//! use profidrive::devices::ag03::unit::{Config, Unit};
//!
//! let mut unit = Unit::new(Config::new(Model::Ag03_1, Gear::Ratio48));
//! let _written = unit.write(Write::Set(Parameter::VPos, 100))?;
//! let run = Command { operation: Operation::Run, ..Command::default() };
//! unit.step(Duration::from_millis(1), &run);
//! assert!(unit.status().operation_enabled);
//! # Ok::<(), profidrive::devices::ag03::param::ParamError>(())
//! ```

mod cycle;
pub mod dip;
mod drive_state;
mod event;
mod image;
mod paced;
mod parameters;
mod power;
mod storage;

use core::time::Duration;

use crate::devices::ag03::drive;
use crate::devices::ag03::drive::{Command, Drive, Fault, FaultSet, Inputs, Refusal, Settings, Status};
use crate::devices::ag03::param;
use crate::devices::ag03::param::{Gear, Model, Store};

pub(crate) use cycle::Cycles;
pub use cycle::{ApplicationCycle, CycleTooShort, DEFAULT_APPLICATION_CYCLE};
pub use dip::DipSwitches;
pub(crate) use event::Queue;
pub use event::{Event, Writer};
pub use image::{BusSettings, BusSettingsError, IMAGE_LEN, Image, ImageError, ImageOctets, MAX_IMAGE_LEN};
pub(crate) use parameters::OfBus;
pub use parameters::Written;
pub use power::{Power, Switched};
pub(crate) use storage::EepromState;
pub use storage::{Eeprom, Generation, NotStored, Outcome, StoreRequest};

use paced::Paced;
use storage::Storage;

/// What a unit is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config {
    /// Which drive.
    pub model: Model,
    /// Which internal gear.
    pub gear: Gear,
    /// The DIP switches as they are when it is made.
    pub switches: DipSwitches,
    /// Which switches ask for a factory reset; an assumption.
    pub reset_patterns: dip::ResetPatterns,
    /// Where the EEPROM is kept.
    pub eeprom: Eeprom,
    /// Which parameter ranges hold where the manuals contradict themselves.
    pub param: param::Quirks,
    /// How the drive behaves where the manuals leave it open, and the numbers of its plant.
    pub drive: drive::Config,
}

impl Config {
    /// This drive with every switch OFF, whose EEPROM lives as long as the unit.
    pub fn new(model: Model, gear: Gear) -> Self {
        Self {
            model,
            gear,
            switches: DipSwitches::default(),
            reset_patterns: dip::ResetPatterns::ASSUMED,
            eeprom: Eeprom::Internal,
            param: param::Quirks::default(),
            drive: drive::Config::default(),
        }
    }
}

/// A drive with its parameters, EEPROM, supplies and switches.
#[derive(Clone, Debug)]
pub struct Unit {
    reset_patterns: dip::ResetPatterns,
    switches: DipSwitches,
    power: Power,
    /// The world around the drive as last set.
    inputs: Inputs,
    /// The control supply of the inputs reaches the drive.
    switch_closed: bool,
    store: Store,
    settings: Settings,
    drive: Drive,
    /// The drive as the last step or write left it.
    status: Status,
    /// Counts the times that more of it than position and velocity may have changed.
    changes: u32,
    /// A write acts on the drive in the next step.
    parameters_acted: bool,
    bus: BusSettings,
    storage: Option<Storage>,
    /// The cause of the latched fault was present behind the last step.
    fault_cause: bool,
    /// What of the drive's events was told.
    paced: Paced,
    events: Queue<Event, 16>,
}

impl Unit {
    /// A unit with factory settings that has just been switched on, its shaft at 0.
    pub fn new(config: Config) -> Self {
        Self::with(config, None)
    }

    /// A unit as an image of its EEPROM says, just switched on.
    ///
    /// # Errors
    /// [`ImageError`] if the octets are no whole image, or that of another model or gear.
    pub(crate) fn restore(config: Config, octets: &[u8]) -> Result<Self, ImageError> {
        Image::decode(octets, config.model, config.gear).map(|image| Self::with(config, Some(image)))
    }

    /// As [`Unit::restore`], from an image that the host does not keep yet: [`Unit::poll_image`] offers it again.
    ///
    /// # Errors
    /// As [`Unit::restore`].
    pub(crate) fn restore_unstored(config: Config, octets: &[u8]) -> Result<Self, ImageError> {
        let mut unit = Self::restore(config, octets)?;
        unit.offer_image();
        Ok(unit)
    }

    // Not inlined: see `dp::Slave::under`.
    #[inline(never)]
    fn with(config: Config, kept: Option<Image>) -> Self {
        let fresh = kept.is_none();
        let Image { mut store, memory, bus } =
            kept.unwrap_or_else(|| Image::of_new(config.model, config.gear));
        store.set_quirks(config.param);
        let settings = Settings::read(&store);
        let mut drive = Drive::with(config.model, config.gear, &settings, config.drive);
        let storage = Storage::new(config.eeprom, memory.clone(), fresh);
        drive.recall(memory);
        let mut unit = Self {
            reset_patterns: config.reset_patterns,
            switches: config.switches,
            power: Power::On,
            inputs: drive.inputs(),
            switch_closed: true,
            store,
            settings,
            status: drive.status(),
            changes: 0,
            drive,
            parameters_acted: false,
            bus,
            storage,
            fault_cause: false,
            paced: Paced::default(),
            events: Queue::default(),
        };
        unit.read_switches();
        unit
    }

    /// Lets `dt` pass under what the bus wants; without a master that is for example `Command::UNATTENDED`. Inputs and
    /// parameters act at the beginning.
    pub fn step(&mut self, dt: Duration, command: &Command) {
        self.drive.step(dt, command, &self.settings);
        self.note_step(dt, command);
    }

    /// As [`Unit::step`], under what the bus wanted in the step before; its edges are over.
    pub(crate) fn hold(&mut self, dt: Duration) {
        let command = self.drive.hold(dt, &self.settings);
        self.note_step(dt, &command);
    }

    /// Takes note of what a step under `command` has changed.
    #[inline]
    fn note_step(&mut self, dt: Duration, command: &Command) {
        self.parameters_acted = false;
        if !self.drive.has_only_moved(&mut self.status) {
            self.note_changes(command);
        }
        let velocity = self.drive.velocity_in_force(command);
        if velocity.is_some() || self.paced.waits() {
            let events = &mut self.events;
            self.paced.pass_time(dt, velocity, |event| events.push(Event::Drive(event)));
        }
    }

    /// As [`Unit::note_step`], where more than position and velocity may have changed: nothing is to be kept or told of a
    /// shaft that goes on turning.
    fn note_changes(&mut self, command: &Command) {
        let before = self.status;
        self.refresh_status();
        self.note_memory();
        if let Some(refusal) = self.drive.take_refusal() {
            self.events.push(Event::CommandRefused(refusal));
        }
        let new_fault = self.status.fault.filter(|fault| before.fault != Some(*fault));
        if let Some(fault) = new_fault {
            self.events.push(Event::Fault(fault));
        }
        let Self { drive, events, paced, status, .. } = self;
        drive.tell(&before, status, command, |event| {
            if let Some(event) = paced.pass(event) {
                events.push(Event::Drive(event));
            }
        });
        if let Some(fault) = self.status.fault {
            self.tell_cause(fault, new_fault.is_some());
        }
    }

    /// Says once that the cause of the latched fault has gone.
    fn tell_cause(&mut self, fault: Fault, new: bool) {
        let present = self.drive.causes().contains(fault);
        let was_present = core::mem::replace(&mut self.fault_cause, present) || new;
        if was_present && !present {
            self.events.push(Event::FaultCauseGone(fault));
        }
    }

    /// Says which causes of faults the bus sees now: see [`Drive::set_bus_causes`].
    pub(crate) fn set_bus_causes(&mut self, causes: FaultSet) {
        self.drive.set_bus_causes(causes);
    }

    /// Whether another step with the same command would change nothing.
    pub(crate) fn is_at_rest(&self) -> bool {
        self.drive.is_at_rest() && !self.parameters_acted && !self.paced.waits()
    }

    /// The drive as the last step or write left it.
    pub const fn status(&self) -> &Status {
        &self.status
    }

    /// Counts the times that more of [`Unit::status`] than position and velocity may have changed.
    pub(crate) const fn changes(&self) -> u32 {
        self.changes
    }

    /// The drive itself: its faults and their causes, what it measures.
    pub(crate) const fn drive(&self) -> &Drive {
        &self.drive
    }

    /// The stored parameters.
    pub(crate) const fn parameters(&self) -> &Store {
        &self.store
    }

    /// What stands now against a start under the last command (`ag03.md` 8 rows 20 to 22, 40); `None`: nothing.
    pub(crate) fn start_refusal(&self) -> Option<Refusal> {
        self.drive.start_refusal(&self.settings)
    }

    /// Composes the status anew.
    fn refresh_status(&mut self) {
        self.status = self.drive.status();
        self.changes = self.changes.wrapping_add(1);
    }

    /// The oldest event not taken yet.
    #[must_use]
    #[inline]
    pub(crate) fn poll_event(&mut self) -> Option<Event> {
        self.events.pop().map(|event| event.unwrap_or_else(|events| Event::Lost { events }))
    }
}

#[cfg(test)]
mod tests;
