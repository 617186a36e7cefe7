//! What a device tells of itself to whoever shows it: values with units, words with named bits, process data,
//! parameters, its history. Everything is told one after the other, so that nothing is allocated.

use core::fmt;

use super::{Acyclic, AnyDeviceEvent, Surroundings};
use crate::time::Instant;

/// Whether a device is supplied.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "panel", derive(serde::Serialize), serde(rename_all = "snake_case"))]
#[cfg_attr(all(test, feature = "panel"), derive(utoipa::ToSchema))]
pub enum Supply {
    /// It is not.
    Off,
    /// It is.
    On,
    /// Switched on for a factory reset: only the LEDs work.
    FactoryReset,
}

/// What a value is now.
#[derive(Clone, Copy)]
pub enum Amount<'a> {
    /// Nobody knows.
    Unknown,
    /// A number in the unit that is told with it.
    Number(f64),
    /// No or yes.
    Flag(bool),
    /// A word.
    Text(&'a dyn fmt::Display),
}

impl Amount<'_> {
    /// The number; none if it is no number.
    pub const fn number(&self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(*number),
            Self::Unknown | Self::Flag(_) | Self::Text(_) => None,
        }
    }
}

impl From<Option<f64>> for Amount<'_> {
    fn from(number: Option<f64>) -> Self {
        number.map_or(Self::Unknown, Self::Number)
    }
}

/// What a value is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "panel", derive(serde::Serialize), serde(rename_all = "snake_case"))]
#[cfg_attr(all(test, feature = "panel"), derive(utoipa::ToSchema))]
pub enum Group {
    /// Where the shaft is, and what moves it.
    Motion,
    /// What the device measures.
    Measured,
    /// The slave or node before it.
    Slave,
    /// How often something happened.
    Counter,
}

/// Whether a value is worth a curve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Curve {
    /// It is not.
    #[default]
    None,
    /// It has one of its own.
    Own,
    /// It is the setpoint of the value with this key.
    SetpointOf(&'static str),
}

/// A value of a device.
#[derive(Clone, Copy)]
pub struct Value<'a> {
    /// A name that stays, for programs.
    pub key: &'static str,
    /// What people call it.
    pub name: &'static str,
    /// The unit; empty: none.
    pub unit: &'static str,
    /// What it is about.
    pub group: Group,
    /// What it is now.
    pub amount: Amount<'a>,
    /// Whether it is worth a curve.
    pub curve: Curve,
    /// Digits behind the point that mean something; `None`: as many as there are.
    pub digits: Option<u8>,
    /// Whether a list of devices shows it.
    pub headline: bool,
}

impl<'a> Value<'a> {
    /// A value that is worth no curve and no place in a list.
    pub const fn new(key: &'static str, name: &'static str, group: Group, amount: Amount<'a>) -> Self {
        Self { key, name, unit: "", group, amount, curve: Curve::None, digits: None, headline: false }
    }

    /// With its unit.
    #[must_use]
    pub const fn unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }

    /// With a curve.
    #[must_use]
    pub const fn curve(self, curve: Curve) -> Self {
        Self { curve, ..self }
    }

    /// With so many digits behind the point.
    #[must_use]
    pub(crate) const fn digits(self, digits: u8) -> Self {
        Self { digits: Some(digits), ..self }
    }

    /// With a place in a list of devices.
    #[must_use]
    pub const fn headline(self) -> Self {
        Self { headline: true, ..self }
    }
}

/// A word of bits.
#[derive(Clone, Copy)]
pub struct Word<'a> {
    /// A name that stays, for programs: `stw`, `6040`.
    pub key: &'a dyn fmt::Display,
    /// What people call it.
    pub name: &'a dyn fmt::Display,
    /// Its bits.
    pub value: u16,
    /// What each bit, from 0 to 15, means now.
    pub bit: &'a dyn Fn(u8) -> Bit,
}

/// One bit of a word.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bit {
    /// A short name for programs; empty for a bit that is not used.
    pub key: &'static str,
    /// What the manual calls it.
    pub name: &'static str,
    /// What its level means.
    pub meaning: &'static str,
    /// What to know about it; may be empty.
    pub note: &'static str,
    /// Whether the bit means anything: not if it is fixed or not evaluated.
    pub used: bool,
    /// This level needs somebody.
    pub alarm: bool,
}

/// Octets that master and device exchange cyclically.
#[derive(Clone, Copy)]
pub struct Exchange<'a> {
    /// A name that stays, for programs: `outputs`, `rpdo1`.
    pub key: &'a dyn fmt::Display,
    /// What people call it.
    pub name: &'a dyn fmt::Display,
    /// The master sends it.
    pub from_master: bool,
    /// What is exchanged; empty if only the entries are known.
    pub octets: &'a [u8],
    /// The slot that they are in, and which bits are forced; `None`: they cannot be.
    pub forced: Option<(u16, &'a [u8])>,
    /// What they say, in words.
    pub details: Option<&'a dyn fmt::Display>,
    /// Tells each value that is in them.
    pub each_entry: &'a EachEntry<'a>,
}

/// Tells each value in octets that are exchanged.
pub type EachEntry<'a> = dyn Fn(&mut dyn FnMut(ExchangeEntry<'_>)) + 'a;

/// Says the value of an element, or of a parameter that is no array.
pub type SayElement<'a> = dyn Fn(Option<u8>, &mut dyn FnMut(&dyn fmt::Display)) + 'a;

/// A value in octets that are exchanged.
#[derive(Clone, Copy)]
pub struct ExchangeEntry<'a> {
    /// What people call it.
    pub name: &'a str,
    /// Where it is: an object, or octets.
    pub place: &'a dyn fmt::Display,
    /// What it is.
    pub amount: Amount<'a>,
    /// Its unit; empty: none.
    pub unit: &'static str,
}

/// Something that a device remembers: a fault, a warning.
#[derive(Clone, Copy)]
pub struct Past<'a> {
    /// Its code.
    pub code: &'a dyn fmt::Display,
    /// What it means.
    pub text: &'a dyn fmt::Display,
    /// What is known of when it was.
    pub when: Option<&'a dyn fmt::Display>,
}

/// Switches under the cover of a device.
#[derive(Clone, Copy)]
pub struct Switches<'a> {
    /// Which are on; bit 0 is the first.
    pub positions: u16,
    /// What each is for, the first first.
    pub names: &'static [&'static str],
    /// What they mean together.
    pub text: &'a dyn fmt::Display,
}

/// Whether a parameter can be read and written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "panel", derive(serde::Serialize), serde(rename_all = "snake_case"))]
#[cfg_attr(all(test, feature = "panel"), derive(utoipa::ToSchema))]
pub enum ParameterAccess {
    /// Read only.
    ReadOnly,
    /// Both.
    ReadWrite,
    /// A command.
    WriteOnly,
}

/// Which parameter, and which element of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ParameterPlace {
    /// Its number.
    pub number: u16,
    /// The element; `None`: it is no array.
    pub element: Option<u8>,
}

/// A parameter with its row of the table.
#[derive(Clone, Copy)]
pub struct Parameter<'a> {
    /// Its number.
    pub number: u16,
    /// The name in the manual or the table.
    pub name: &'a str,
    /// The unit of one step of the value.
    pub unit: &'a dyn fmt::Display,
    /// The first and the number of its elements, if it is an array.
    pub elements: Option<(u8, u8)>,
    /// The number of an element, or of the parameter; `None`: nobody can say.
    pub value: &'a dyn Fn(Option<u8>) -> Option<f64>,
    /// The same in words, with its unit.
    pub say: &'a SayElement<'a>,
    /// The values that stand for something.
    pub choices: &'a [(u16, &'static str)],
    /// Whether it can be read and written.
    pub access: ParameterAccess,
    /// The lowest value that can be written.
    pub low: Option<f64>,
    /// The highest.
    pub high: Option<f64>,
    /// The value of a new device.
    pub usual: Option<f64>,
    /// It is kept while the device is off.
    pub kept: bool,
    /// When it may be written; empty: always.
    pub writable_when: &'static str,
}

/// Why an access to a parameter was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Denied {
    /// There is no such parameter or element.
    Unknown,
    /// Not in this state, or never.
    NotNow,
    /// This value cannot be.
    Value,
}

/// What a device tells of itself. What is not said otherwise, it does not have.
pub trait Description: Surroundings {
    /// Whether it is supplied; `None`: it is not switched here.
    fn supply(&self) -> Option<Supply> {
        None
    }

    /// Switches its supply on or off.
    fn switch_supply(&mut self, _now: Instant, _on: bool) {}

    /// The next of what it has to tell of itself, besides what its bus tells.
    fn poll_news(&mut self) -> Option<AnyDeviceEvent> {
        None
    }

    /// Its state in its own words.
    fn say_state(&self, _say: &mut dyn FnMut(&dyn fmt::Display)) {}

    /// The fault that it is in: its code and what it means.
    fn tell_fault(&self, _tell: &mut dyn FnMut(&dyn fmt::Display, &dyn fmt::Display)) {}

    /// What it warns of.
    fn say_warning(&self, _say: &mut dyn FnMut(&dyn fmt::Display)) {}

    /// Each value, the most important first.
    fn each_value(&self, _tell: &mut dyn FnMut(Value<'_>)) {}

    /// Each word of bits, those of the master first.
    fn each_word(&self, _tell: &mut dyn FnMut(Word<'_>)) {}

    /// Everything that is exchanged cyclically, that of the master first.
    fn each_exchange(&self, _tell: &mut dyn FnMut(Exchange<'_>)) {}

    /// Everything that it remembers, the newest first.
    fn each_past(&self, _tell: &mut dyn FnMut(Past<'_>)) {}

    /// Its switches.
    fn tell_switches(&self, _tell: &mut dyn FnMut(Switches<'_>)) {}

    /// Sets its switches; bit 0 is the first.
    fn set_switches(&mut self, _positions: u16) {}

    /// Each parameter.
    fn each_parameter(&self, _tell: &mut dyn FnMut(Parameter<'_>)) {}

    /// Each parameter that decides what its words mean: number and value, none if it has no such parameter.
    fn each_meaning(&self, _tell: &mut dyn FnMut(u16, Option<u16>)) {}

    /// Reads a parameter by the rules of the bus, but without the bus.
    ///
    /// # Errors
    /// [`Denied`], and `say` is called with why.
    fn check_parameter(
        &self,
        _place: ParameterPlace,
        say: &mut dyn FnMut(&dyn fmt::Display),
    ) -> Result<(), Denied> {
        say(&"it has no parameters");
        Err(Denied::Unknown)
    }

    /// Writes a parameter by the rules of the bus, but without the bus: no master sees it.
    ///
    /// # Errors
    /// [`Denied`], and `say` is called with why; nothing is changed then.
    fn write_parameter(
        &mut self,
        _now: Instant,
        _place: ParameterPlace,
        _value: f64,
        say: &mut dyn FnMut(&dyn fmt::Display),
    ) -> Result<(), Denied> {
        say(&"it has no parameters");
        Err(Denied::Unknown)
    }

    /// Its records and alarms; `None`: it has none.
    fn acyclic(&self) -> Option<&dyn Acyclic> {
        None
    }

    /// The same, to change them.
    fn acyclic_mut(&mut self) -> Option<&mut dyn Acyclic> {
        None
    }

    /// How safe what its memory holds is.
    fn memory(&self) -> Option<&'static str> {
        None
    }
}
