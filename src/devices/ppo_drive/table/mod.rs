//! The parameters that a user gives a drive.
//!
//! | file | holds |
//! | --- | --- |
//! | `fields` | a row from its named fields as text, each checked |
//! | `first` | another first value for one drive |
//! | `file` | the fields of TOML and of CSV files (feature `parameters`) |
//! | `profile` | the parameters of the profile that every drive has |
//!
//! ```
//! use profidrive::devices::ppo_drive::table::{Fields, Row, Table};
//!
//! let fields = [("pnu", "100"), ("name", "ramp-up"), ("type", "uint16"), ("tie", "ramp-up-time"), ("scale", "0.1")];
//! let row = Row::of(&Fields::new(1, fields))?;
//! let table = Table::new([row])?;
//! assert_eq!(table.row(100).map(|row| row.unit.as_str()), Some("s"));
//! # Ok::<(), profidrive::devices::ppo_drive::table::TableError>(())
//! ```

mod fields;
#[cfg(feature = "parameters")]
mod file;
mod first;
mod profile;

use crate::map::Map;
use core::fmt;

use strum::{IntoStaticStr, VariantArray};
use thiserror::Error;

pub use fields::{FIELDS, Fields};
pub use first::FirstValueError;

use super::{Drive, Quantity};

/// The highest number of a parameter: PKE has 11 bits for it, and some families have pages.
pub(crate) const MAX_PNU: u16 = 3999;

/// What the octets of a value are (`profidrive-v2.md` 6).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum Kind {
    /// 16 bits with sign.
    Int16,
    /// 32 bits with sign.
    Int32,
    /// 16 bits.
    Uint16,
    /// 32 bits.
    Uint32,
    /// 32 bits, IEEE 754.
    Float,
    /// 16 single bits.
    #[strum(serialize = "v2")]
    Bits16,
}

impl Kind {
    /// Every kind.
    pub(crate) const ALL: &'static [Self] = <Self as VariantArray>::VARIANTS;

    /// Its name in a file.
    pub(crate) fn name(self) -> &'static str {
        self.into()
    }

    /// Its number in the object dictionary, bits 7 to 0 of the identifier of a description.
    pub(crate) const fn number(self) -> u8 {
        match self {
            Self::Int16 => 3,
            Self::Int32 => 4,
            Self::Uint16 => 6,
            Self::Uint32 => 7,
            Self::Float => 8,
            Self::Bits16 => 35,
        }
    }

    /// Whether it is a double word.
    pub(crate) const fn is_double(self) -> bool {
        match self {
            Self::Int16 | Self::Uint16 | Self::Bits16 => false,
            Self::Int32 | Self::Uint32 | Self::Float => true,
        }
    }

    /// Its smallest and largest value.
    pub(crate) const fn range(self) -> (f64, f64) {
        match self {
            Self::Int16 => (i16::MIN as f64, i16::MAX as f64),
            Self::Int32 => (i32::MIN as f64, i32::MAX as f64),
            Self::Uint16 | Self::Bits16 => (0.0, u16::MAX as f64),
            Self::Uint32 => (0.0, u32::MAX as f64),
            Self::Float => (f32::MIN as f64, f32::MAX as f64),
        }
    }

    /// The value of these bits, of which a word uses the low half.
    pub(crate) fn value(self, bits: u32) -> f64 {
        let [_, _, high, low] = bits.to_be_bytes();
        let word = [high, low];
        match self {
            Self::Int16 => i16::from_be_bytes(word).into(),
            Self::Int32 => i32::from_be_bytes(bits.to_be_bytes()).into(),
            Self::Uint16 | Self::Bits16 => u16::from_be_bytes(word).into(),
            Self::Uint32 => bits.into(),
            Self::Float => f32::from_bits(bits).into(),
        }
    }

    /// The bits of a value, rounded and brought into the range.
    pub(crate) fn bits(self, value: f64) -> u32 {
        let (low, high) = self.range();
        let value = value.clamp(low, high);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "within the range, and NaN is 0"
        )]
        match self {
            Self::Int16 => u32::from((libm::round(value) as i16).cast_unsigned()),
            Self::Int32 => (libm::round(value) as i32).cast_unsigned(),
            Self::Uint16 | Self::Bits16 => u32::from(libm::round(value) as u16),
            Self::Uint32 => libm::round(value) as u32,
            Self::Float => (value as f32).to_bits(),
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// What the parameter channel knows and the drive does not.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "kebab-case")]
pub enum Channel {
    /// The control word (PNU 967).
    ControlWord,
    /// The status word (PNU 968).
    StatusWord,
    /// The station address (PNU 918).
    Address,
    /// The PPO type in use (PNU 929).
    PpoType,
    /// An array: of each word of process data from the third on, the parameter that it sets (PNU 915).
    PzdSetpoint,
    /// The same for the parameters that it shows (PNU 916).
    PzdActual,
    /// Stores all parameters, and is 0 again when that is done: at once, as each write is kept (PNU 971).
    Store,
    /// An array: the numbers of all parameters (PNU 980).
    #[strum(serialize = "parameter-list")]
    List,
}

impl Channel {
    /// Every one.
    pub(crate) const ALL: &'static [Self] = <Self as VariantArray>::VARIANTS;

    /// Its name in a file.
    pub(crate) fn name(self) -> &'static str {
        self.into()
    }

    /// How many elements it has; `None`: it is a single value.
    pub(crate) const fn elements(self) -> Option<u8> {
        match self {
            // The words of PPO 5 behind the first two.
            Self::PzdSetpoint | Self::PzdActual => Some(8),
            Self::List => Some(LISTED),
            Self::ControlWord | Self::StatusWord | Self::Address | Self::PpoType | Self::Store => None,
        }
    }

    /// Whether its value is kept by the table, so that it can be written.
    pub(crate) const fn is_settable(self) -> bool {
        match self {
            Self::PzdSetpoint | Self::PzdActual | Self::Store => true,
            Self::ControlWord | Self::StatusWord | Self::Address | Self::PpoType | Self::List => false,
        }
    }
}

/// The most parameters that the list shows.
const LISTED: u8 = 254;

/// What a parameter is tied to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Tie {
    /// Nothing: it keeps what is written to it.
    None,
    /// A quantity of the drive.
    Drive(Quantity),
    /// Something of the bus.
    Channel(Channel),
}

impl Tie {
    /// How many elements it has; `None`: a single value.
    pub(crate) const fn elements(self) -> Option<u8> {
        match self {
            Self::None => None,
            Self::Drive(quantity) => quantity.elements(),
            Self::Channel(channel) => channel.elements(),
        }
    }

    /// Whether what is written to it is kept while the drive is switched off.
    pub(crate) const fn is_kept(self) -> bool {
        match self {
            Self::None => true,
            Self::Drive(quantity) => quantity.is_kept(),
            Self::Channel(channel) => channel.is_settable() && !matches!(channel, Channel::Store),
        }
    }

    /// Whether it can be written.
    pub(crate) const fn is_settable(self) -> bool {
        match self {
            Self::None => true,
            Self::Drive(quantity) => quantity.is_settable(),
            Self::Channel(channel) => channel.is_settable(),
        }
    }
}

/// One parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Its number, 1 to `MAX_PNU`.
    pub pnu: u16,
    /// Its name.
    pub name: String,
    /// What its octets are.
    pub kind: Kind,
    /// Elements of an array, counted from 1; `None`: a single value.
    pub elements: Option<u8>,
    /// The smallest value, as it is on the bus.
    pub low: f64,
    /// The largest value.
    pub high: f64,
    /// The values at the beginning, one per element; `None`: 0, or what the drive has.
    pub default: Option<Vec<f64>>,
    /// The unit, for people.
    pub unit: String,
    /// What 1 on the bus is, in the unit of the quantity it is tied to.
    pub scale: f64,
    /// Whether a master can write it.
    pub writable: bool,
    /// What it is tied to.
    pub tie: Tie,
}

/// Bits of the identifier of a description, beside the number of the type in bits 7 to 0.
const ARRAY: u16 = 1 << 14;
const READ_ONLY: u16 = 1 << 9;
/// The factor is 1 and says nothing.
const NO_FACTOR: u16 = 1 << 8;

impl Row {
    /// The identifier of its description, element 1 (`profidrive-v2.md` 6).
    pub(crate) fn identifier(&self) -> u16 {
        let flags =
            [(self.elements.is_some(), ARRAY), (!self.writable, READ_ONLY), (self.scale == 1.0, NO_FACTOR)];
        let set = flags.into_iter().filter(|(set, _)| *set);
        set.fold(u16::from(self.kind.number()), |bits, (_, bit)| bits | bit)
    }

    /// The element of what it is tied to that an element of it shows, from 1: its own, but for the eight single
    /// parameters of the profile that show one warning each.
    pub(crate) fn shown_element(&self, own: Option<u8>) -> u8 {
        own.or_else(|| profile::single_element(self.pnu, self.tie)).unwrap_or(1)
    }
}

/// Why a table cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("line {line}: {what}")]
pub struct TableError {
    /// The line, from 1.
    pub line: usize,
    /// What is wrong, and what to do about it.
    pub what: String,
}

/// The parameters of a drive and the values of those that are tied to nothing.
#[derive(Clone, Debug)]
pub struct Table {
    rows: Map<u16, (Row, Vec<u32>)>,
}

impl Table {
    /// The parameters of the profile, and these. One with a number of the profile stands for it.
    ///
    /// # Errors
    /// [`TableError`] if two have the same number; its line is the place in `rows`.
    pub fn new(rows: impl IntoIterator<Item = Row>) -> Result<Self, TableError> {
        let mut own = Map::new();
        for (place, row) in rows.into_iter().enumerate() {
            let pnu = row.pnu;
            if own.insert(pnu, with_values(row)).is_some() {
                let what = std::format!("PNU {pnu} is in the table twice; take one of them out");
                return Err(TableError { line: place + 1, what });
            }
        }
        let mut rows: Map<_, _> =
            profile::rows().into_iter().map(|row| (row.pnu, with_values(row))).collect();
        rows.extend(own);
        Ok(Self { rows })
    }

    /// The parameters of the profile alone.
    pub fn profile() -> Self {
        Self { rows: profile::rows().into_iter().map(|row| (row.pnu, with_values(row))).collect() }
    }

    /// A parameter.
    pub fn row(&self, pnu: u16) -> Option<&Row> {
        self.rows.get(&pnu).map(|(row, _)| row)
    }

    /// All parameters in the order of their numbers.
    pub fn rows(&self) -> impl Iterator<Item = &Row> + Clone {
        self.rows.values().map(|(row, _)| row)
    }

    /// The first parameter with this tie.
    pub(crate) fn tied(&self, tie: Tie) -> Option<&Row> {
        self.rows().find(|row| row.tie == tie)
    }

    /// The bits kept of a parameter: of an array at `place`, counted from 0.
    pub(crate) fn kept(&self, pnu: u16, place: usize) -> Option<u32> {
        self.rows.get(&pnu)?.1.get(place).copied()
    }

    /// Keeps the bits of a parameter. `false`: there is no such place.
    pub(crate) fn keep(&mut self, pnu: u16, place: usize, bits: u32) -> bool {
        let kept = self.rows.get_mut(&pnu).and_then(|(_, values)| values.get_mut(place));
        kept.map(|kept| *kept = bits).is_some()
    }

    /// Sets what the defaults of tied parameters say.
    ///
    /// # Errors
    /// The first parameter whose default its quantity does not take.
    pub(crate) fn set_up(&self, drive: &mut Drive) -> Result<(), &Row> {
        for row in self.rows() {
            let (Tie::Drive(quantity), Some(default)) = (row.tie, &row.default) else { continue };
            if let (true, Some(value)) = (quantity.is_settable(), default.first()) {
                drive.set_quantity(quantity, value * row.scale).map_err(|_| row)?;
            }
        }
        Ok(())
    }
}

fn with_values(row: Row) -> (Row, Vec<u32>) {
    let count = usize::from(row.elements.unwrap_or(1));
    let default = row.default.as_deref().unwrap_or_default();
    let values = (0..count).map(|place| row.kind.bits(default.get(place).copied().unwrap_or(0.0))).collect();
    (row, values)
}
