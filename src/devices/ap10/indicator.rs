//! The indicator as one object.

use super::display::Arrow;
use super::faults::{Battery, Fault, Faults};
use super::keys::Pressed;
use super::leds::{Basic, Leds};
use super::menu::Menu;
use super::monitor::{Direction, Guide, Monitor};
use super::set_point::{SetPoint, Slot};
use super::settings::{Mode, Setting, Settings};
use super::shaft::{Encoder, Turns};
use super::words::{Control, ControlBit, Status, StatusBit};
use crate::time::Instant;
use crate::untold::Untold;

/// Events that wait for the bus; there is never more than one of each fault and key.
const MAX_EVENTS: usize = 16;

/// What the bus has to hear of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Event {
    /// A fault began.
    FaultBegan(Fault),
    /// Its cause is gone.
    FaultEnded(Fault),
    /// The zero point was set; the battery keeps it.
    Calibrated,
    /// A person chose a value in the menu.
    Chosen(Setting),
    /// A person gave this device the number of Auto-ID.
    AutoId(u8),
    /// A person wants factory settings.
    Restore(Restore),
}

/// Which parameters get their factory values (manual table 8).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Restore {
    /// Code 011100.
    All,
    /// Code 011102.
    AllButBus,
    /// Code 011105.
    Bus,
}

/// What the battery keeps beside zero point and calibration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Backup {
    /// The angle of the shaft.
    shaft: Turns,
    /// Faults present and errors unread, by their bits.
    faults: [u8; 2],
}

impl Backup {
    /// Its length in octets.
    pub(crate) const LEN: usize = 10;

    /// ```text
    /// octets 0..7  shaft in millionths of a turn, low octet first
    /// octet  8     faults present: bit 0 battery critical, 1 battery empty
    /// octet  9     errors unread: bit 1 battery empty, 2 speed
    /// ```
    pub(crate) const fn octets(self) -> [u8; Self::LEN] {
        let [a, b, c, d, e, f, g, h] = self.shaft.micros().to_le_bytes();
        let [present, unread] = self.faults;
        [a, b, c, d, e, f, g, h, present, unread]
    }

    /// What [`octets`](Self::octets) gave.
    pub(crate) const fn from_octets(octets: [u8; Self::LEN]) -> Self {
        let [a, b, c, d, e, f, g, h, present, unread] = octets;
        let micros = i64::from_le_bytes([a, b, c, d, e, f, g, h]);
        Self { shaft: Turns::from_micros(micros), faults: [present, unread] }
    }
}

/// Where the manual is silent or was lost, and both ways are thinkable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quirks {
    /// CN-105: the first octet of six characters is the rightmost, not the leftmost.
    pub ascii_reversed: bool,
    /// CN-108: what is shown for a value outside the display range, at most eight characters.
    pub overflow: &'static str,
}

impl Quirks {
    /// The proposed readings.
    pub const DEFAULT: Self = Self { ascii_reversed: false, overflow: "FULL" };
}

impl Default for Quirks {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// The position indicator without a bus. Never panics.
///
/// After every call that changes something drain `poll_event`.
#[derive(Clone, Debug)]
pub struct Indicator {
    pub(super) quirks: Quirks,
    pub(super) settings: Settings,
    pub(super) encoder: Encoder,
    pub(super) control: Control,
    set_points: [SetPoint; 2],
    /// Of the positions modes: the set point received last while it was valid.
    last: Slot,
    monitor: Monitor,
    pub(super) faults: Faults,
    pub(super) pressed: Pressed,
    pub(super) menu: Option<Menu>,
    /// The number Auto-ID waits with for a person.
    pub(super) auto_id: Option<u8>,
    events: Untold<Event, MAX_EVENTS>,
}

impl Indicator {
    /// An indicator with these parameters and its shaft at 0.
    pub(crate) fn new(settings: Settings, quirks: Quirks) -> Self {
        let mut encoder = Encoder::default();
        encoder.restart(&settings);
        Self {
            quirks,
            settings,
            encoder,
            control: Control(0),
            set_points: [SetPoint::default(); 2],
            last: Slot::One,
            monitor: Monitor::IDLE,
            faults: Faults::default(),
            pressed: Pressed::default(),
            menu: None,
            auto_id: None,
            events: Untold::new(),
        }
    }

    /// Begins anew with parameters of the EEPROM. What the battery keeps, faults and keys stay.
    pub(crate) fn restart(&mut self, settings: Settings) {
        self.settings = settings;
        self.encoder.restart(&settings);
        self.control = Control(0);
        self.set_points = [SetPoint::default(); 2];
        self.last = Slot::One;
        self.monitor = Monitor::IDLE;
        self.menu = None;
        self.auto_id = None;
        self.pressed.star_since = None;
    }

    /// The parameters.
    pub(crate) const fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Sets a parameter. Says whether it is in range; if not nothing changes.
    pub(crate) fn set(&mut self, setting: Setting, value: i32) -> bool {
        let accepted = self.settings.set(setting, value);
        self.watch();
        accepted
    }

    /// The angle of the shaft.
    pub(crate) const fn shaft(&self) -> Turns {
        self.encoder.shaft()
    }

    /// The shaft is turned, with supply or without.
    pub(crate) fn turn_to(&mut self, shaft: Turns) {
        self.encoder.turn_to(shaft);
        self.watch();
    }

    /// The shaft is turned without supply: the battery counts, unless it is empty.
    pub(crate) fn turn_without_supply(&mut self, shaft: Turns) {
        match self.battery() {
            Battery::Good | Battery::Critical => self.encoder.turn_to(shaft),
            Battery::Empty => self.encoder.turn_uncounted(shaft),
        }
    }

    /// The position value 6004h.
    pub fn position(&self) -> i32 {
        let divisor = if self.settings.is_on(Setting::DivisorUse) { 1 } else { self.settings.divisor() };
        let position = self.encoder.position(&self.settings) / divisor;
        i32::try_from(position).unwrap_or(if position < 0 { i32::MIN } else { i32::MAX })
    }

    /// Sets the zero point: the position becomes preset and offset.
    pub(crate) fn calibrate(&mut self) {
        self.encoder.calibrate(&self.settings);
        self.tell(Event::Calibrated);
        self.watch();
    }

    /// Whether calibration took place.
    pub(crate) const fn is_calibrated(&self) -> bool {
        self.encoder.calibrated
    }

    /// The count of the encoder at calibration, in steps of the sensor (6509h).
    pub(crate) const fn zero(&self) -> i32 {
        self.encoder.zero
    }

    /// Takes over what the battery kept.
    pub(crate) const fn recall(&mut self, zero: i32, calibrated: bool) {
        self.encoder.zero = zero;
        self.encoder.calibrated = calibrated;
    }

    /// What the battery keeps beside zero point and calibration.
    pub(crate) fn backup(&self) -> Backup {
        Backup { shaft: self.encoder.shaft(), faults: self.faults.kept() }
    }

    /// Takes over what the battery kept beside zero point and calibration.
    pub(crate) fn restore(&mut self, backup: Backup) {
        self.encoder.turn_to(backup.shaft);
        self.faults.recall(backup.faults);
    }

    /// The low four octets of a set point as received.
    pub(crate) fn set_point_low(&self, slot: Slot) -> u32 {
        self.set_point(slot).low
    }

    /// The high two octets of a set point.
    pub(crate) fn set_point_high(&self, slot: Slot) -> u32 {
        self.set_point(slot).high
    }

    /// The low four octets of a set point came. They act with [`received`](Self::received).
    pub(crate) fn set_low(&mut self, slot: Slot, low: u32) {
        self.set_point_mut(slot).low = low;
    }

    /// The high two octets of a set point came.
    pub(crate) fn set_high(&mut self, slot: Slot, high: u32) {
        self.set_point_mut(slot).high = high;
    }

    /// The control word.
    pub(crate) const fn control(&self) -> Control {
        self.control
    }

    /// A control word came. There is one: the newest counts, whichever set point it came with (CN-132).
    pub(crate) const fn set_control(&mut self, control: Control) {
        self.control = control;
    }

    /// A set point and its control word are complete.
    pub(crate) fn received(&mut self, slot: Slot) {
        let control = self.control;
        for each in Slot::ALL {
            self.set_point_mut(each).follow(each, control, each == slot);
        }
        if self.set_point(slot).is_valid() {
            self.last = slot;
        }
        // The level counts (CN-133): inside the window the bit stays 0 until the window is entered anew.
        if control.has(ControlBit::AcknowledgeStatic) {
            self.monitor.reached = false;
        }
        self.watch();
    }

    /// Auto-ID: a number waits for a person at this device. `None` ends it.
    pub(crate) const fn offer_id(&mut self, number: Option<u8>) {
        self.auto_id = number;
    }

    /// A fault begins; if it was there nothing happens.
    pub(crate) fn begin(&mut self, fault: Fault) {
        if self.faults.begin(fault) {
            self.tell(Event::FaultBegan(fault));
        }
    }

    /// The cause of a fault is gone; if it was not there nothing happens.
    pub(crate) fn end(&mut self, fault: Fault) {
        if self.faults.end(fault) {
            self.tell(Event::FaultEnded(fault));
        }
    }

    /// Whether a fault is there.
    pub(crate) fn has(&self, fault: Fault) -> bool {
        self.faults.has(fault)
    }

    /// Whether any fault is there.
    pub(crate) fn has_fault(&self) -> bool {
        self.faults.any()
    }

    /// What is left of the battery.
    pub(crate) fn battery(&self) -> Battery {
        self.faults.battery()
    }

    /// Whether the position may be wrong until it is acknowledged.
    pub(crate) fn is_position_invalid(&self) -> bool {
        self.faults.is_position_invalid()
    }

    /// The differential value 5F0Dh:1, 0 without a valid set point.
    pub(crate) fn difference(&self) -> i32 {
        self.monitor.difference(&self.settings)
    }

    /// The status word.
    pub(crate) fn status(&self) -> Status {
        let [one, two] = &self.set_points;
        let status = Status(0)
            .with(StatusBit::SetPoint1Valid, one.is_valid())
            .with(StatusBit::SetPoint2Valid, two.is_valid())
            .with(StatusBit::BatteryEmpty, self.battery() == Battery::Empty)
            .with(StatusBit::BatteryCritical, self.battery() != Battery::Good)
            .with(StatusBit::Guarding, self.control.has(ControlBit::Guarding))
            .with(StatusBit::SensorError, self.has(Fault::Speed))
            .with(StatusBit::StarKey, self.pressed.star)
            .with(StatusBit::UpKey, self.pressed.up)
            .with(StatusBit::LeftKey, self.pressed.left);
        match self.settings.mode() {
            Mode::Alphanumeric => status
                .with(StatusBit::ACKNOWLEDGED_1, one.is_acknowledged())
                .with(StatusBit::ACKNOWLEDGED_2, two.is_acknowledged()),
            Mode::Absolute | Mode::Difference | Mode::Modulo => status
                .with(StatusBit::Clockwise, self.arrow() == Some(Arrow::Clockwise))
                .with(StatusBit::CounterClockwise, self.arrow() == Some(Arrow::CounterClockwise))
                .with(StatusBit::Window2, self.monitor.is_near(&self.settings))
                .with(StatusBit::Window1Static, self.monitor.reached)
                .with(StatusBit::Window1, self.monitor.is_inside())
                .with(StatusBit::AboveSetPoint, self.monitor.is_above())
                .with(StatusBit::Incremental, self.encoder.is_incremental()),
        }
    }

    /// The status word in the read-out of a set point by remote request.
    pub(crate) fn status_of(&self, slot: Slot) -> Status {
        match self.settings.mode() {
            Mode::Alphanumeric => self.status().with(StatusBit::ASCII, self.set_point(slot).is_ascii()),
            Mode::Absolute | Mode::Difference | Mode::Modulo => self.status(),
        }
    }

    /// What the LEDs show.
    pub(crate) fn leds(&self) -> Leds {
        let [one, two] = &self.set_points;
        let basic = match self.settings.mode() {
            Mode::Alphanumeric => {
                Basic::SetPoints([one, two].map(|set| set.is_valid().then_some(set.is_acknowledged())))
            }
            Mode::Absolute | Mode::Difference | Mode::Modulo => Basic::Position(self.guide()),
        };
        Leds::shining(basic, self.control, &self.settings)
    }

    /// Time passes.
    pub(crate) fn handle_timeout(&mut self, now: Instant) {
        if self.menu_due().is_some_and(|due| due <= now) {
            self.open_menu();
        }
    }

    /// When [`handle_timeout`](Self::handle_timeout) is to be called.
    pub(crate) fn poll_timeout(&self) -> Option<Instant> {
        self.menu_due()
    }

    /// The next event.
    pub(crate) fn poll_event(&mut self) -> Option<Event> {
        self.events.pop()
    }

    /// The set point that counts in the modes with a position: the valid one received last.
    pub(super) fn target(&self) -> Option<i32> {
        let other = match self.last {
            Slot::One => Slot::Two,
            Slot::Two => Slot::One,
        };
        self.set_point(self.last).number().or_else(|| self.set_point(other).number())
    }

    /// The way a person has to turn, if any.
    pub(super) fn way(&self) -> Option<Direction> {
        match (self.settings.mode(), self.guide()) {
            (Mode::Alphanumeric, _) => None,
            (Mode::Absolute | Mode::Difference | Mode::Modulo, Guide::Turn { to, .. }) => Some(to),
            (Mode::Absolute | Mode::Difference | Mode::Modulo, Guide::Idle | Guide::Reached) => None,
        }
    }

    fn guide(&self) -> Guide {
        self.monitor.guide(self.position(), &self.settings)
    }

    pub(super) const fn set_point(&self, slot: Slot) -> &SetPoint {
        let [one, two] = &self.set_points;
        match slot {
            Slot::One => one,
            Slot::Two => two,
        }
    }

    pub(super) const fn set_point_mut(&mut self, slot: Slot) -> &mut SetPoint {
        let [one, two] = &mut self.set_points;
        match slot {
            Slot::One => one,
            Slot::Two => two,
        }
    }

    /// Looks at the windows after a change.
    pub(super) fn watch(&mut self) {
        let target = match self.settings.mode() {
            Mode::Alphanumeric => None,
            Mode::Absolute | Mode::Difference | Mode::Modulo => self.target(),
        };
        self.monitor.update(self.position(), target, &self.settings);
    }

    pub(super) fn tell(&mut self, event: Event) {
        self.events.push(event);
    }
}
