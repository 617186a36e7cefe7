//! One emulated drive as one object: octets and time in, octets and events out.
//!
//! It owns no clock, no port and no thread.
//!
//! **After every `handle_*` call, drain [`Device::poll_transmit`] and [`Device::poll_event`] to `None`, then wait
//! until octets arrive or [`Device::poll_timeout`] has come.** The crate guide shows the loop.
//!
//! A device is two machines, as the real one is. The *DP part* answers each telegram at once from buffers. The
//! *drive part* runs once per application cycle: it takes the newest outputs, runs the state machine, one fixed
//! step of the motion and the parameter channel, and offers new inputs. So a PKW reply never comes in the
//! exchange that brought its job. When nothing can change, the drive part sleeps and [`Device::poll_timeout`]
//! does not ask to be called for its sake; what happens is the same as if it had run.
//!
//! | file | holds |
//! | --- | --- |
//! | `address` | the station address that the DIP switches show |
//! | `config` | [`Config`]: what a device is made of |
//! | `description` | what it tells of itself |
//! | `bits` | every bit of STW, ZSW, SSW and the general status register: number, name, meaning |
//! | `words` | those words from and to what the drive knows |
//! | `flow_charts` | the control words that the manual prints |
//! | `event` | [`Event`]: what has happened in the drive, with the bits of PROFIBUS |
//! | `hint` | [`Hint`]: what is odd, said once |
//! | `job` | `JobText`: why a PKW job was not executed, and what to send instead |
//! | `named_words` | control and status word in names |
//! | `parameters` | the parameters of the unit as the parameter channel reaches them |
//! | `part` | the DP part and the drive part of [`Device`] |
//! | `quirks` | [`QUIRKS`]: every named alternative |
//! | `refusal` | [`Refusal`]: why a control word is not followed |
//! | `story` | what `profidrive demo` plays |
//! | `why` | everything that keeps the drive from moving now |

mod address;
pub mod bits;
mod config;
mod description;
mod event;
pub(crate) mod flow_charts;
pub(crate) mod hint;
mod job;
mod named_words;
pub mod parameters;
mod part;
mod quirks;
mod refusal;
mod story;
mod surroundings;
mod why;
pub mod words;

use core::time::Duration;

use crate::devices::StationEvent;
use crate::devices::ag03::drive::{Drive, FaultBuffer, Inputs, Status, StatusLed, leds};
use crate::devices::ag03::param::{ParamError, Pnu, Store, Subindex, Value};
use crate::devices::ag03::unit::{Outcome, Switched, Unit};
use crate::face::DriveState;
use crate::profibus::dp;
use crate::profibus::fdl::{Address, Framer, Telegram};
use crate::profibus::ppo::{PpoType, Stw, Zsw};
use crate::time::{BaudRate, Instant};

pub use crate::devices::ag03::param::Gear;
pub(crate) use crate::devices::ag03::unit::EepromState;
pub use crate::devices::ag03::unit::{
    ApplicationCycle, CycleTooShort, DEFAULT_APPLICATION_CYCLE, DipSwitches, Eeprom, Generation, IMAGE_LEN,
    ImageError, ImageOctets, MAX_IMAGE_LEN, NotStored, Power, StoreRequest, dip,
};
pub use crate::profibus::fdl::{MAX_TELEGRAM_LEN, Timing};
pub use config::Config;
pub use event::Event;
pub use hint::Hint;
pub(crate) use job::JobText;
pub use quirks::QUIRKS;
pub use refusal::Refusal;

pub(crate) use named_words::NAMED_WORDS;
use part::Parts;
pub(crate) use story::STORY;

/// The ident number of both drives: the GSD is named `SIKO0AC5.GSD`.
pub const IDENT_NUMBER: u16 = 0x0AC5;

/// The configurations both drives accept: four and three words consistent, or seven words consistent. Which one
/// the real drive uses is not public (`ag03.md` 16).
pub const CONFIGURATIONS: &[&[u8]] = &[PpoType::SevenWords.configuration(), &[0xF6]];

/// What both drives are to a DP master. Both manuals list all rates of PROFIBUS-DP without 45.45 kbit/s.
pub const DESCRIPTION: dp::Description = dp::Description {
    ident: IDENT_NUMBER,
    rates: dp::Rates::CUSTOMARY.without(BaudRate::K45_45),
    sync_mode: true,
    freeze_mode: true,
    ..dp::Description::PLAIN
};

/// What both drives judge in Set_Prm and Chk_Cfg: they have no user parameters.
pub(crate) const APPLICATION: dp::Fixed<'static> = dp::Fixed {
    configurations: CONFIGURATIONS,
    cfg_advice: "choose the module of the drive's GSD (SIKO0AC5.GSD) in the master's project",
    ..dp::Fixed::PLAIN
};

/// How many events of a drive wait to be taken. What comes beyond them is counted, and one event more says how many.
pub const MAX_EVENTS: usize = 24;

/// The LEDs of a drive (`ag03.md` 11).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Leds {
    /// The green status LED is lit.
    pub status: bool,
    /// What the status LED tells of the drive over time.
    pub pattern: StatusLed,
    /// The orange bus LED is lit: Data_Exchange.
    pub bus: bool,
}

/// One emulated drive: a [`Unit`] on PROFIBUS.
#[derive(Clone, Debug)]
pub struct Device {
    framer: Framer,
    part: Parts,
}

impl Device {
    /// A drive with factory settings, switched on at `now` with its shaft at 0.
    pub fn new(config: Config, now: Instant) -> Self {
        Self::with(config, Unit::new(config.unit()), now)
    }

    /// A drive as an image of its EEPROM says, switched on at `now`.
    ///
    /// # Errors
    /// [`ImageError`] if the octets are no whole image, or that of another model or gear.
    pub fn restore(config: Config, octets: &[u8], now: Instant) -> Result<Self, ImageError> {
        Unit::restore(config.unit(), octets).map(|unit| Self::with(config, unit, now))
    }

    fn with(config: Config, unit: Unit, now: Instant) -> Self {
        let mut device = Self { framer: config.framer(), part: Parts::new(config, unit, now) };
        device.part.start(now);
        device
    }

    /// As [`Device::restore`], from an image that the host does not keep yet: [`Device::poll_image`] offers it again.
    ///
    /// # Errors
    /// As [`Device::restore`].
    pub(crate) fn restore_unstored(config: Config, octets: &[u8], now: Instant) -> Result<Self, ImageError> {
        Unit::restore_unstored(config.unit(), octets).map(|unit| Self::with(config, unit, now))
    }

    /// What the device was made of, with the rate of the line and the DIP switches as they are now.
    pub const fn config(&self) -> &Config {
        &self.part.config
    }

    /// Its station address, as the DIP switches were when it was switched on. A factory reset does not change it.
    pub const fn address(&self) -> Address {
        self.part.shown.address
    }

    /// Whether it is switched on.
    pub const fn power(&self) -> Power {
        self.part.unit.power()
    }

    /// The world around the drive as last set, switched on or not.
    pub const fn inputs(&self) -> &Inputs {
        self.part.unit.inputs()
    }

    /// The unit behind the bus.
    pub(crate) const fn unit(&self) -> &Unit {
        &self.part.unit
    }

    /// The state of the DP slave machine; WAIT-PRM while switched off.
    pub const fn dp_state(&self) -> dp::State {
        self.part.station.slave().state()
    }

    /// The DP slave: owner, outputs, inputs, diagnosis.
    pub const fn slave(&self) -> &dp::Slave {
        self.part.station.slave()
    }

    /// The drive as the last application cycle left it.
    pub const fn status(&self) -> &Status {
        self.part.unit.status()
    }

    /// The state of the drive in the words that all devices share.
    pub(crate) fn drive_state(&self) -> DriveState {
        self.status().state.into()
    }

    /// The drive itself: its faults and their causes.
    pub const fn drive(&self) -> &Drive {
        self.part.unit.drive()
    }

    /// Reads a parameter without the bus, as a PKW job would.
    ///
    /// # Errors
    /// As [`Store::read`].
    pub(crate) fn read_parameter(&self, pnu: Pnu, element: Option<Subindex>) -> Result<Value, ParamError> {
        let Parts { unit, shown, .. } = &self.part;
        unit.read(pnu, element, |of_bus, element| shown.show(unit, of_bus, element))
    }

    /// What stands now against a start with the newest outputs (`ag03.md` 8 rows 20 to 22, 40); `None`: nothing.
    pub(crate) fn start_refusal(&self) -> Option<Refusal> {
        self.part.unit.start_refusal().map(|refusal| Refusal::new(refusal, &self.part.shown.words))
    }

    /// The control word that the drive has seen last; 0 outside Data_Exchange.
    pub(crate) const fn commanded(&self) -> Stw {
        self.part.shown.words.stw()
    }

    /// The status word as it is offered to the master.
    pub fn zsw(&self) -> Zsw {
        self.part.shown.words.zsw(self.status())
    }

    /// The system status word SSW, PNU 1020.
    pub fn system_status(&self) -> u16 {
        self.part.shown.words.system_status(self.status())
    }

    /// The fault codes in the order PNU 945 lists them (C-18), 0 = unused.
    pub(crate) fn fault_codes(&self) -> [u8; FaultBuffer::LEN] {
        self.part.shown.fault_codes(self.unit())
    }

    /// The LEDs at `now`; those of a factory reset alternate.
    pub fn leds(&self, now: Instant) -> Leds {
        let time = self.blink_time(now);
        match self.power() {
            Power::Off => Leds { status: false, pattern: StatusLed::Off, bus: false },
            Power::On => Leds {
                status: self.status().led.is_lit(time),
                pattern: self.status().led,
                bus: self.dp_state() == dp::State::DataExch,
            },
            // Alternately, manual chapter 2.4.
            Power::FactoryReset(_) => {
                let half = time.as_nanos() / leds::BLINK_ON.as_nanos() % 2;
                Leds { status: half == 0, pattern: StatusLed::Off, bus: half == 1 }
            }
        }
    }

    /// The time that blinks count from, for [`StatusLed::is_lit`]: since the device was made.
    pub(crate) fn blink_time(&self, now: Instant) -> Duration {
        now.saturating_since(self.part.cycles.start())
    }

    /// The stored parameters.
    pub const fn parameters(&self) -> &Store {
        self.part.unit.parameters()
    }

    /// Writes a parameter without the bus, by its rules: the drive cannot tell it from a PKW job, but no reply
    /// is sent, nothing waits for the EEPROM, and the master does not notice. Counts as a `handle_*` call.
    ///
    /// # Errors
    /// As [`Store::write`]; nothing is changed then.
    pub fn write_parameter(
        &mut self,
        now: Instant,
        pnu: Pnu,
        element: Option<Subindex>,
        value: Value,
    ) -> Result<(), ParamError> {
        self.part.advance(now);
        let write = self.parameters().meaning(pnu, element, value)?;
        let _written = self.part.unit.write(write)?;
        self.part.pass_events();
        self.part.cycles.wake(now);
        Ok(())
    }

    /// Opens the switch of the control supply: see [`Unit::power_off`]; the bus hears nothing more. Counts as a `handle_*`
    /// call; does nothing to a drive that is switched off.
    pub fn power_off(&mut self, now: Instant) {
        self.supply(now, Unit::power_off);
    }

    /// Closes the switch of the control supply (row 1): see [`Unit::power_on`]; the slave waits for parameters at the
    /// address of the DIP switches. Counts as a `handle_*` call; does nothing to a drive that is on.
    pub fn power_on(&mut self, now: Instant) {
        self.supply(now, Unit::power_on);
    }

    /// Changes what acts on the drive from outside: see `Unit::set_inputs`. Counts as a `handle_*` call.
    pub fn set_inputs(&mut self, now: Instant, inputs: Inputs) {
        self.supply(now, |unit| unit.set_inputs(inputs));
    }

    fn supply(&mut self, now: Instant, change: impl FnOnce(&mut Unit) -> Switched) {
        self.part.advance(now);
        match change(&mut self.part.unit) {
            Switched::No => {}
            Switched::Off | Switched::On => {
                self.framer = self.part.config.framer();
                self.part.restart();
            }
        }
        self.part.pass_events();
        self.part.cycles.wake(now);
    }

    /// Sets the DIP switches. They are read when the drive is switched on next (manual chapter 7.8).
    pub fn set_switches(&mut self, switches: DipSwitches) {
        self.part.config.switches = switches;
        self.part.unit.set_switches(switches);
        self.part.pass_events();
    }

    /// What the drive would keep if it were switched off now.
    pub fn image(&self) -> ImageOctets {
        self.part.unit.image()
    }

    /// How safe what the drive keeps is.
    pub(crate) fn eeprom_state(&self) -> EepromState {
        self.part.unit.eeprom_state()
    }

    /// The image to keep: see [`Unit::poll_image`]. Changes with every `handle_*`; poll it when those of the contract are
    /// drained.
    #[must_use = "it is not offered again"]
    pub fn poll_image(&mut self) -> Option<StoreRequest> {
        self.part.unit.poll_image()
    }

    /// The host says what became of an image: see [`Unit::handle_stored`]. If it could not be kept, a waiting job is
    /// answered with error 18 and has changed nothing.
    pub fn handle_stored(&mut self, now: Instant, generation: Generation, outcome: Result<(), NotStored>) {
        self.part.advance(now);
        let outcome = self.part.unit.handle_stored(generation, outcome);
        self.part.pass_events();
        match outcome {
            Outcome::None => {}
            Outcome::Safe => _ = self.part.engine.stored(),
            Outcome::Undone => {
                if let Some(refusal) = self.part.engine.store_failed() {
                    self.part.events.push(StationEvent::Device(Event::JobRefused(refusal)));
                }
            }
        }
        self.part.cycles.wake(now);
    }

    /// The line has another rate from now on.
    pub(crate) fn set_baud(&mut self, baud: BaudRate) {
        self.part.config.baud = baud;
        self.part.station.set_baud(baud);
        self.framer = self.part.config.framer();
    }

    /// Takes octets, the last of which ended at `now`. They may be cut anywhere. Never panics, never blocks.
    ///
    /// Returns whether something has come of it: a telegram or a refusal ended, or an application cycle ran. While it is
    /// `false`, as for most octets that come one by one, there is nothing to drain and no deadline is earlier than before.
    pub fn handle_bytes(&mut self, now: Instant, octets: &[u8]) -> bool {
        let Self { framer, part } = self;
        part.news = false;
        part.advance(now);
        if part.unit.is_working() {
            // What a scan finds among octets whose rest did not come counts from now: for the drive part, time has passed.
            framer.handle_bytes(now, octets, |_, result| part.hear(now, result));
        }
        part.news
    }

    /// An octet that ended at `now` came damaged: wrong parity, no stop bit, or lost because nobody took it in time. The
    /// telegram around it is refused once (`dp-v0.md` 1). Returns as [`Device::handle_bytes`].
    pub fn handle_damaged(&mut self, now: Instant) -> bool {
        let Self { framer, part } = self;
        part.news = false;
        part.advance(now);
        if part.unit.is_working() {
            framer.handle_damaged(now, |_, result| part.hear(now, result));
        }
        part.news
    }

    /// Takes one telegram whose last octet ended at `now`, for hosts that frame the octets of many devices once.
    pub(crate) fn handle_telegram(&mut self, now: Instant, telegram: &Telegram<'_>) {
        self.part.advance(now);
        if self.part.unit.is_working() {
            self.part.hear(now, Ok(*telegram));
        }
    }

    /// Time has passed. Spurious calls are harmless.
    pub fn handle_timeout(&mut self, now: Instant) {
        let Self { framer, part } = self;
        part.advance(now);
        framer.handle_timeout(now, |_, result| part.hear(now, result));
    }

    /// The telegram to send at `now`, written to `buf`, if its time has come.
    #[must_use = "the octets are not offered again"]
    pub fn poll_transmit<'b>(
        &mut self,
        now: Instant,
        buf: &'b mut [u8; MAX_TELEGRAM_LEN],
    ) -> Option<&'b [u8]> {
        match self.part.station.poll_transmit(now) {
            Ok(octets) => {
                let octets = octets?;
                let out = buf.get_mut(..octets.len())?;
                out.copy_from_slice(octets);
                Some(out)
            }
            Err(too_late) => {
                self.part.events.push(StationEvent::ReplyTooLate(too_late));
                None
            }
        }
    }

    /// When to call [`Device::handle_timeout`] and [`Device::poll_transmit`] again; `None` = octets come first.
    /// Changes with every `handle_*`, and with every `poll_transmit` that returned octets.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Instant> {
        Instant::first_of(self.due(), self.framer.poll_timeout())
    }

    /// Time has passed, where a bus finds the telegrams: see [`Device::handle_timeout`].
    #[inline]
    pub(crate) fn pass_time(&mut self, now: Instant) {
        self.part.advance(now);
    }

    /// When to call [`Device::pass_time`] again.
    #[inline]
    pub(crate) fn due(&self) -> Option<Instant> {
        Instant::first_of(self.part.station.poll_timeout(), self.part.cycles.next())
    }

    /// Whether the DP watchdog minds the master (WD_On of Slave_Diag).
    pub(crate) fn watchdog_on(&self) -> bool {
        self.part.station.slave().watchdog_on()
    }

    /// Whether [`Device::poll_event`] has one.
    #[cfg(feature = "std")]
    #[inline]
    pub(crate) fn has_events(&self) -> bool {
        !self.part.events.is_empty()
    }

    /// The oldest event not taken yet. Changes with every `handle_*` and `poll_transmit`.
    #[must_use]
    #[inline]
    pub fn poll_event(&mut self) -> Option<StationEvent<Event>> {
        self.part.events.pop().map(|event| event.unwrap_or_else(|events| StationEvent::Lost { events }))
    }
}
