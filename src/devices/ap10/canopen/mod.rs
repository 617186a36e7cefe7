//! The position indicator SIKO AP10 on CANopen: frames, keys and a shaft in, frames and a display out.
//!
//! A [`CanopenDevice`](crate::devices::CanopenDevice): after every call with `now` drain what it polls.
//!
//! ```
//! use profidrive::devices::CanopenDevice;
//! use profidrive::devices::ap10::Turns;
//! use profidrive::can_bus::canopen::NodeId;
//! use profidrive::devices::ap10::canopen::{Ap10, Config};
//! use profidrive::time::Instant;
//!
//! let now = Instant::ZERO;
//! let mut device = Ap10::new(Config::new(NodeId::new(125)?));
//! device.power_on(now);
//! let boot_up = device.poll_transmit(now).expect("a node that is switched on says so");
//! assert_eq!(boot_up.to_string(), "77D#00");
//! device.turn_to(now, Turns::from_revolutions(0.5));
//! assert_eq!(device.display().rows[0].text(), "440");
//! assert_eq!(device.display().to_string(), "[     440] [     ---], LED left off, right off");
//! # Ok::<(), profidrive::can_bus::canopen::NodeIdError>(())
//! ```
//!
//! | file | holds |
//! | --- | --- |
//! | `hosted` | what a host asks of any device on CANopen |
//! | `story` | what `profidrive demo` plays |
//! | `surroundings` | what surrounds it and what is seen of it |
//! | `objects` | [`OBJECTS`]: the dictionary, and the parameter behind each entry |
//! | `unit` | what objects read and do, EMCY, storage, external heartbeat, Auto-ID |
//! | `quirks` | [`Quirks`]: doubts of the manual, the policy of the node |

mod description;
mod hosted;
mod objects;
mod quirks;
mod spin;
mod story;
mod surroundings;
mod unit;
mod vocabulary;

pub use objects::OBJECTS;
pub use quirks::{QUIRKS, Quirks, SdoCodes, SoftwareVersion};
pub use spin::MAX_RPM;
pub(crate) use story::STORY;
pub use vocabulary::VOCABULARY;

use crate::can_bus::canopen::eds::Sheet;
use crate::can_bus::canopen::node::storage::Eeprom;
use crate::can_bus::canopen::{Node, NodeId};
use crate::devices::ap10::{Backup, Display, Fault, Indicator, Key, Turns};
use crate::time::Instant;
use spin::Spin;
use unit::Unit;

/// Rates of the device in kbit/s.
pub(crate) const KILOBITS: &[u16] = &[125, 250, 500, 800, 1000];
/// The same in bit/s, by the number of 5F0Ah:3 from 1 on; 0 is that of the bus.
const RATES: &[u32] = &[125_000, 250_000, 500_000, 800_000, 1_000_000];

/// What a device is made of.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// What 5F0Ah:1 holds in the EEPROM at first.
    pub node: NodeId,
    /// Doubts of the manual.
    pub quirks: Quirks,
    /// Who keeps the EEPROM.
    pub memory: Eeprom,
}

impl Config {
    /// A device with that node number, the proposed readings and an EEPROM of its own.
    pub const fn new(node: NodeId) -> Self {
        Self { node, quirks: Quirks::DEFAULT, memory: Eeprom::Internal }
    }
}

/// A position indicator. Never panics, whatever frames and inputs it is given.
#[derive(Clone, Debug)]
pub struct Ap10 {
    node: Node,
    unit: Unit,
    power: Power,
    switched_on: Option<Instant>,
    spin: Option<Spin>,
}

/// The supply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Power {
    Off,
    /// The rate is searched for: listening.
    Listening,
    On,
}

impl Ap10 {
    /// A device without supply.
    pub fn new(config: Config) -> Self {
        Self {
            node: Node::new(config.quirks.policy()).with_memory(config.memory),
            unit: Unit::new(config.node, config.quirks),
            power: Power::Off,
            switched_on: None,
            spin: None,
        }
    }

    /// The device without its bus.
    pub const fn indicator(&self) -> &Indicator {
        &self.unit.indicator
    }

    /// What can be seen at `now`: behind the supply comes the display test.
    fn seen(&self, now: Instant) -> Display {
        let since = self.switched_on.filter(|_| self.power != Power::Off);
        since.and_then(|since| Display::test(now.saturating_since(since))).unwrap_or_else(|| self.display())
    }

    /// What can be seen behind the display test. Without supply there is nothing to be seen.
    pub fn display(&self) -> Display {
        match self.power {
            Power::Off => Display::DARK,
            Power::Listening | Power::On => self.unit.indicator.display(),
        }
    }

    /// The shaft is turned to that angle, with supply or without, and stays there.
    pub fn turn_to(&mut self, now: Instant, shaft: Turns) {
        if self.spin.take().is_some() {
            self.end_fault(now, Fault::Speed);
        }
        if shaft != self.indicator().shaft() {
            self.node.offer_image();
        }
        self.place(now, shaft);
    }

    fn place(&mut self, now: Instant, shaft: Turns) {
        match self.power {
            Power::Off => self.unit.indicator.turn_without_supply(shaft),
            Power::Listening | Power::On => {
                self.unit.indicator.turn_to(shaft);
                self.change(now);
            }
        }
    }

    /// A key goes down. Without supply nothing happens.
    pub fn press(&mut self, now: Instant, key: Key) {
        match self.power {
            Power::Off | Power::Listening => {}
            Power::On => {
                self.timeouts(now);
                let kept = self.indicator().backup();
                self.unit.indicator.press(now, key);
                self.fault_changed(now, kept);
            }
        }
    }

    /// A key goes up.
    pub fn release(&mut self, now: Instant, key: Key) {
        self.timeouts(now);
        self.unit.indicator.release(key);
        self.change(now);
    }

    /// A fault begins.
    pub fn provoke(&mut self, now: Instant, fault: Fault) {
        let kept = self.indicator().backup();
        self.unit.indicator.begin(fault);
        self.fault_changed(now, kept);
    }

    /// The cause of a fault is gone.
    pub fn end_fault(&mut self, now: Instant, fault: Fault) {
        let kept = self.indicator().backup();
        self.unit.indicator.end(fault);
        self.fault_changed(now, kept);
    }

    /// Nothing is wrong: battery, speed and bus.
    pub fn make_nominal(&mut self, now: Instant) {
        self.spin(now, 0.0);
        for fault in Fault::ALL {
            self.end_fault(now, fault);
        }
        self.set_error_passive(now, false);
    }

    /// The CAN controller is error passive, or not any more.
    fn set_error_passive(&mut self, now: Instant, passive: bool) {
        self.unit.set_error_passive(passive);
        self.change(now);
    }

    /// The CAN controller was off the bus and is back.
    fn recover_from_bus_off(&mut self, now: Instant) {
        self.unit.bus_off_recovered();
        self.change(now);
    }

    fn fault_changed(&mut self, now: Instant, before: Backup) {
        if before != self.indicator().backup() {
            self.node.offer_image();
        }
        self.change(now);
    }

    fn timeouts(&mut self, now: Instant) {
        if self.power == Power::On && self.unit.poll_timeout().is_some_and(|due| due <= now) {
            self.unit.handle_timeout(now);
            self.change(now);
        }
    }

    fn change(&mut self, now: Instant) {
        self.unit.follow(now);
        self.node.handle_change(now, &mut self.unit);
    }
}

/// The EDS of the unconfigured device, for [`eds::write`](crate::can_bus::canopen::eds::write) with [`OBJECTS`].
pub const EDS: Sheet<'static> = Sheet {
    file_name: "ap10.eds",
    file_version: 1,
    file_revision: 0,
    description: "Position indicator AP10",
    time: "12:00PM",
    date: "11-22-2026",
    created_by: "profidrive",
    vendor_name: "SIKO GmbH",
    vendor_number: 0x195,
    product_name: "AP10",
    product_number: 0xFFFF_FFFF,
    revision_number: 0,
    order_code: "AP10",
    kilobits: KILOBITS,
    granularity: 0,
};
