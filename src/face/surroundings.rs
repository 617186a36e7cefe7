//! What surrounds a device and what a person sees of it, in the device's own words: faults that can be made,
//! inputs, keys, the supply, its display and LEDs.
//!
//! A host that shows or changes them knows no device: it asks which there are.

use core::fmt;
use core::time::Duration;

use heapless::{String, Vec};

use super::{DriveState, Turning, Why};
use crate::can_bus::canopen::Address;
use crate::time::Instant;

/// A quantity outside the device that acts on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Input {
    /// Its name with its unit, as `output_supply_volts`.
    pub name: &'static str,
    /// What it is.
    pub about: &'static str,
    /// What it may be.
    pub kind: InputKind,
}

/// What an input may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum InputKind {
    /// Off or on.
    Switch,
    /// A number within these bounds, both included.
    Number {
        /// The lowest.
        low: f64,
        /// The highest.
        high: f64,
        /// Whether it may be left to what follows from everything else ([`Level::Own`]).
        own: bool,
    },
}

/// What an input is now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Level {
    /// Off or on.
    Switch(bool),
    /// A number.
    Number(f64),
    /// What follows from everything else.
    Own,
}

/// A fault that can be made, as a host lists it.
#[derive(Clone, Copy)]
pub struct Provocable<'a> {
    /// Its name in commands, as `D`, `battery-empty` or `011`.
    pub name: &'a dyn fmt::Display,
    /// What it is.
    pub text: &'a dyn fmt::Display,
    /// Whether its cause is there now.
    pub present: bool,
    /// Whether the inputs as they are set make it, at once or as soon as the shaft is commanded to turn.
    pub provoked: bool,
}

/// Ends of the names of inputs, and the unit that each says.
const UNITS: [(&str, &str); 7] = [
    ("_volts", "V"),
    ("_celsius", "°C"),
    ("_newton_metres", "Nm"),
    ("_metres", "m"),
    ("_revolutions", "turns"),
    ("_rpm", "rpm"),
    ("_percent", "%"),
];

impl Input {
    /// Its unit, which the end of its name says; `None`: it has none.
    pub fn unit(&self) -> Option<&'static str> {
        let said = |(end, unit): &(&str, &'static str)| self.name.ends_with(end).then_some(*unit);
        UNITS.iter().find_map(said)
    }
}

/// What a person sees: a display, signs on it, LEDs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Face {
    /// The rows of the display from above; none if there is no display.
    pub rows: Vec<FaceRow, 2>,
    /// What is lit beside the rows, as `arrow clockwise`.
    pub signs: Vec<&'static str, 4>,
    /// The LEDs, dark or not.
    pub leds: Vec<FaceLed, 4>,
}

/// A row of a display.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FaceRow {
    /// What it shows.
    pub text: String<12>,
    /// The whole row blinks.
    pub flashing: bool,
}

/// An LED.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FaceLed {
    /// Which, with its colour: `left green`.
    pub name: &'static str,
    /// What it does.
    pub glow: Glow,
}

/// What an LED does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Glow {
    /// Dark.
    Off,
    /// Lit.
    On,
    /// Blinks without end.
    Blinking {
        /// How long it is lit.
        on: Duration,
        /// How long it is dark.
        off: Duration,
    },
    /// Blinks so many times, then pauses: the code of a fault.
    Code(u8),
    /// In turn with another one.
    Alternating,
}

impl fmt::Display for Glow {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Off => f.write_str("off"),
            Self::On => f.write_str("on"),
            Self::Blinking { on, off } if on < off => f.write_str("flashing"),
            Self::Blinking { .. } => f.write_str("blinking"),
            Self::Code(times) => write!(f, "blinking {times} times"),
            Self::Alternating => f.write_str("alternating"),
        }
    }
}

impl fmt::Display for Face {
    /// One line: `[AL011]`, `status LED on, bus LED off`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (number, row) in self.rows.iter().enumerate() {
            let gap = if number == 0 { "" } else { " " };
            let flashing = if row.flashing { " flashing" } else { "" };
            write!(f, "{gap}[{}]{flashing}", row.text)?;
        }
        let mut gap = if self.rows.is_empty() { "" } else { ", " };
        for sign in &self.signs {
            write!(f, "{gap}{sign}")?;
            gap = ", ";
        }
        for led in &self.leds {
            write!(f, "{gap}LED {} {}", led.name, led.glow)?;
            gap = ", ";
        }
        Ok(())
    }
}

impl Face {
    /// With a row more; what does not fit is cut off.
    #[must_use]
    pub fn row(mut self, text: &str, flashing: bool) -> Self {
        let mut row = FaceRow { text: String::new(), flashing };
        for character in text.chars() {
            let _ = row.text.push(character);
        }
        let _ = self.rows.push(row);
        self
    }

    /// With a sign more, if it is lit.
    #[must_use]
    pub(crate) fn sign(mut self, sign: &'static str, lit: bool) -> Self {
        if lit {
            let _ = self.signs.push(sign);
        }
        self
    }

    /// With an LED more.
    #[must_use]
    pub(crate) fn led(mut self, name: &'static str, glow: Glow) -> Self {
        let _ = self.leds.push(FaceLed { name, glow });
        self
    }
}

/// Why something is not done to a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Declined {
    /// It has nothing of that name.
    Unknown,
    /// It is switched off.
    SwitchedOff,
}

/// What surrounds a device. Names that it does not have change nothing. What is not said otherwise, it does not have.
///
/// Every call with `now` counts as a `handle_*` call of the device.
pub trait Surroundings {
    /// Each fault that can be made, in the order of the manual.
    fn each_fault(&self, _tell: &mut dyn FnMut(Provocable<'_>)) {}

    /// Makes a fault, or what it follows from.
    ///
    /// # Errors
    /// [`Declined`]; nothing is changed then.
    fn provoke(&mut self, _now: Instant, _fault: &str) -> Result<(), Declined> {
        Err(Declined::Unknown)
    }

    /// Takes the cause of a fault back.
    ///
    /// # Errors
    /// [`Declined`]; nothing is changed then.
    fn take_back(&mut self, _now: Instant, _fault: &str) -> Result<(), Declined> {
        Err(Declined::Unknown)
    }

    /// Each input with what it is now.
    fn each_input(&self, _tell: &mut dyn FnMut(&Input, Level)) {}

    /// Changes an input. A level of the wrong kind changes nothing; a number outside its bounds counts as the nearest.
    fn set_input(&mut self, _now: Instant, _name: &str, _level: Level) {}

    /// What an input is when everything is as it should be; `None`: nobody says it.
    fn nominal(&self, _name: &str) -> Option<Level> {
        None
    }

    /// What the device makes of an input whose level is [`Level::Own`]; `None`: nobody says it.
    fn calculated(&self, _name: &str) -> Option<f64> {
        None
    }

    /// Every input is as it should be, and what was provoked has no cause any more. The shaft stays where it is.
    fn make_nominal(&mut self, _now: Instant) {}

    /// Says why it has no input or fault of that name, if a device next to it has one.
    fn each_lack(&self, _name: &str, _say: &mut dyn FnMut(&dyn fmt::Display)) {}

    /// Each key, and whether it is held.
    fn each_key(&self, _tell: &mut dyn FnMut(&'static str, bool)) {}

    /// A key goes down or up.
    ///
    /// # Errors
    /// [`Declined`]; nothing is changed then.
    fn press(&mut self, _now: Instant, _key: &str, _down: bool) -> Result<(), Declined> {
        Err(Declined::Unknown)
    }

    /// What is seen at `now`.
    fn face(&self, _now: Instant) -> Face {
        Face::default()
    }

    /// On CANopen the entries that are words of bits: what the master commands, then what the device says.
    fn words(&self) -> &'static [Address] {
        &[]
    }

    /// The mode in force, as the device's [`Vocabulary`](crate::devices::Vocabulary) takes it.
    fn mode(&self) -> i64 {
        0
    }

    /// On CANopen how a master turns it with a velocity, and inches; `None`: it cannot be turned so.
    fn turning(&self) -> Option<Turning> {
        None
    }

    /// Whether it can move by itself.
    fn is_drive(&self) -> bool {
        false
    }

    /// The state of its drive in the words that all devices share; `None`: it has none, or does not say it.
    fn drive_state(&self) -> Option<DriveState> {
        None
    }

    /// What keeps it from moving; `None`: nothing in it moves by itself.
    fn why(&self) -> Option<&dyn Why> {
        None
    }
}
