//! The AG03/1 on CANopen: the same unit as on PROFIBUS behind a node of CiA 301 (`canopen-ag03.md`).
//!
//! | file | holds |
//! | --- | --- |
//! | `config` | [`Config`]: what a node is made of |
//! | [`objects`] | the object dictionary, and which entry is which parameter |
//! | [`words`] | every bit of 6040h and 6041h |
//! | [`state`] | the drive state machine |
//! | `part` | the unit as the node sees it: control word in, status word out |
//! | `access` | what reads and writes of objects do |
//! | [`errors`] | the EMCY code and the bits of the error register of each fault |
//! | `event` | [`Event`]: what has happened in the drive, with the bits and objects of CANopen |
//! | `story` | what `profidrive demo` plays |
//! | `surroundings` | inputs, faults, keys, LEDs |
//! | `why` | what keeps it from moving |
//! | `quirks` | [`QUIRKS`]: every named alternative |
//!
//! ```
//! use profidrive::can_bus::can::{Frame, Id};
//! use profidrive::devices::ag03::canopen::{Ag03Node, Config};
//! use profidrive::can_bus::canopen::NodeId;
//! use profidrive::devices::CanopenDevice;
//! use profidrive::time::Instant;
//!
//! let now = Instant::ZERO;
//! let mut node = Ag03Node::new(Config::new(NodeId::new(5)?), now);
//! assert_eq!(node.poll_transmit(now), Some(Frame::with(Id::base(0x705)?, [0])), "boot-up");
//!
//! // Which device is it?
//! node.handle_frame(now, &Frame::with(Id::base(0x605)?, [0x40, 0x00, 0x10, 0, 0, 0, 0, 0]));
//! let answer = Frame::with(Id::base(0x585)?, [0x43, 0x00, 0x10, 0, 0x92, 0x01, 0, 0]);
//! assert_eq!(node.poll_transmit(now), Some(answer));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod access;
mod config;
mod description;
pub mod errors;
mod event;
mod hosted;
pub mod objects;
mod part;
mod quirks;
pub mod state;
mod story;
mod surroundings;
mod vocabulary;
mod why;
pub mod words;

use core::time::Duration;

use super::profibus::Leds;
use crate::can_bus::canopen::node::storage::Eeprom;
use crate::can_bus::canopen::{NmtState, Node};
use crate::devices::ag03::drive::{Inputs, Status, StatusLed, leds};
use crate::devices::ag03::unit::{
    BusSettings, Cycles, DipSwitches, Generation, ImageError, ImageOctets, NotStored, Power, Switched, Unit,
};
use crate::time::Instant;

pub use config::Config;
pub use event::Event;
pub use quirks::{QUIRKS, Quirks};
pub(crate) use story::STORY;
pub use vocabulary::VOCABULARY;

use part::Part;
use state::State;

/// How long the bus LED is lit and dark in PRE-OPERATIONAL: 2.5 Hz.
const BLINK: Duration = Duration::from_millis(200);
/// How long the bus LED is dark in STOPPED: scan ratio 1:5 (CN-42).
const STOPPED_DARK: Duration = Duration::from_millis(1000);

/// An AG03/1 as a node on CANopen: a [`CanopenDevice`](crate::devices::CanopenDevice).
///
/// Never panics, whatever frames it is given.
#[derive(Clone, Debug)]
pub struct Ag03Node {
    config: Config,
    node: Node,
    part: Part,
    cycles: Cycles,
    /// The image of the node that the unit's image makes safe.
    awaited: Option<Generation>,
}

impl Ag03Node {
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
        let mut node = Node::new(config.policy).with_memory(Eeprom::Host);
        let settings = *unit.bus_settings();
        let mut part = Part::new(&config, unit);
        if !settings.is_empty() {
            // Of another bus, or of none that is known: the node begins with its defaults.
            let _foreign = node.recall(now, &settings, &mut part);
        }
        let cycles = Cycles::new(config.application_cycle, now);
        let mut this = Self { config, node, part, cycles, awaited: None };
        this.switched(now, Switched::On);
        this
    }

    /// What it was made of, with the DIP switches as they are now.
    pub const fn config(&self) -> &Config {
        &self.config
    }

    /// The bit rate in force, in bits per second: 2100h as it was at the last initialisation.
    pub fn bits_per_second(&self) -> u32 {
        self.part.bits_per_second()
    }

    /// The NMT state, `None` while it is switched off.
    pub const fn nmt_state(&self) -> Option<NmtState> {
        self.node.state()
    }

    /// The state of the drive.
    pub const fn state(&self) -> State {
        self.part.state
    }

    /// The status word 6041h.
    pub fn status_word(&self) -> u16 {
        self.part.status_word()
    }

    /// The unit behind the bus.
    pub(crate) const fn unit(&self) -> &Unit {
        &self.part.unit
    }

    /// The drive as the last step left it.
    pub const fn status(&self) -> &Status {
        self.part.unit.status()
    }

    /// Whether it is switched on.
    pub(crate) const fn power(&self) -> Power {
        self.part.unit.power()
    }

    /// The world around the drive as last set, switched on or not.
    pub const fn inputs(&self) -> &Inputs {
        self.part.unit.inputs()
    }

    /// What the drive would keep if it were switched off now.
    pub fn image(&self) -> ImageOctets {
        self.part.unit.image()
    }

    /// The LEDs at `now` (`canopen-ag03.md` 1); those of a factory reset alternate.
    pub fn leds(&self, now: Instant) -> Leds {
        let time = now.saturating_since(self.cycles.start());
        let lit = |on: Duration, off: Duration| time.as_nanos() % (on + off).as_nanos() < on.as_nanos();
        let status = self.status().led;
        match self.power() {
            Power::Off => Leds { status: false, pattern: StatusLed::Off, bus: false },
            Power::On => Leds {
                status: status.is_lit(time),
                pattern: status,
                bus: match self.nmt_state() {
                    None => false,
                    Some(NmtState::PreOperational) => lit(BLINK, BLINK),
                    Some(NmtState::Operational) => true,
                    Some(NmtState::Stopped) => lit(BLINK, STOPPED_DARK),
                },
            },
            Power::FactoryReset(_) => {
                let first = lit(leds::BLINK_ON, leds::BLINK_ON);
                Leds { status: first, pattern: StatusLed::Off, bus: !first }
            }
        }
    }

    /// Changes what acts on the drive from outside: see `Unit::set_inputs`. Counts as a `handle_*` call.
    pub fn set_inputs(&mut self, now: Instant, inputs: Inputs) {
        self.supply(now, |unit| unit.set_inputs(inputs));
    }

    /// Sets the DIP switches. They are read when the drive is switched on next.
    pub fn set_switches(&mut self, switches: DipSwitches) {
        self.config.switches = switches;
        self.part.unit.set_switches(switches);
    }

    fn supply(&mut self, now: Instant, change: impl FnOnce(&mut Unit) -> Switched) {
        self.advance(now);
        let switched = change(&mut self.part.unit);
        self.switched(now, switched);
    }

    fn switched(&mut self, now: Instant, switched: Switched) {
        match switched {
            Switched::No => self.part.evaluate(),
            Switched::Off => {
                self.node.power_off();
                self.part.switched_off();
                self.awaited = None;
            }
            Switched::On => {
                self.part.switched_on();
                if self.part.unit.is_working() {
                    self.node.power_on(now, &mut self.part);
                }
            }
        }
        self.node.handle_change(now, &mut self.part);
        self.finish(now);
    }

    /// Lets everything happen that is due until `now`, in the order of time.
    fn advance(&mut self, now: Instant) {
        self.cycles.forfeit(now);
        loop {
            let timeout = self.node.poll_timeout().filter(|due| *due <= now);
            let cycle = self.cycles.next().filter(|due| *due <= now);
            match (cycle, timeout) {
                (Some(cycle), Some(timeout)) if timeout < cycle => self.time(timeout),
                (Some(cycle), Some(_) | None) => {
                    self.run_cycle(cycle);
                    self.cycles.ran(cycle, self.part.unit.is_at_rest());
                }
                (None, Some(timeout)) => self.time(timeout),
                (None, None) => return,
            }
        }
    }

    fn time(&mut self, due: Instant) {
        self.node.handle_timeout(due, &mut self.part);
        self.finish(due);
    }

    fn run_cycle(&mut self, due: Instant) {
        self.part.run(self.cycles.step());
        self.node.handle_change(due, &mut self.part);
    }

    /// What follows from anything that happened: the unit keeps what the node keeps, and runs if something changed.
    fn finish(&mut self, now: Instant) {
        let mut octets = [0; BusSettings::MAX_LEN];
        if let Ok(Some(request)) = self.node.poll_image(&self.part, &mut octets) {
            let generation = request.generation;
            let waits =
                BusSettings::new(request.octets).is_ok_and(|kept| self.part.unit.keep_bus_settings(kept));
            if waits {
                self.awaited = Some(generation);
            } else {
                self.stored(now, generation, Ok(()));
            }
        }
        if self.part.take_changed() {
            self.cycles.wake(now);
        }
    }

    fn stored(&mut self, now: Instant, generation: Generation, outcome: Result<(), NotStored>) {
        if outcome.is_ok() {
            self.part.rate_is_safe();
        }
        self.node.handle_stored(now, generation, outcome, &mut self.part);
        self.node.handle_change(now, &mut self.part);
        self.part.evaluate();
    }
}
