//! Telegrams and words in words: a tree of named fields, each with its octets, its value and what it means.
//!
//! ```text
//!            telegram ─▶ frame ─▶ service ─▶ set_prm, cfg, diag
//!  octets                            └─────▶ ppo ─▶ pkw ─▶ value
//!            bare PPO, PKW, PZD, word ───────┘  └─▶ words
//! ```
//!
//! | file | holds |
//! | --- | --- |
//! | `field` | [`Field`], [`Mark`]: what an explanation is made of |
//! | `context` | [`Context`]: what a stream teaches about what comes later |
//! | `frame` | FDL: delimiters, addresses, function code, SAPs, checksum; telegrams that are broken |
//! | `service` | what the services of DP carry; `set_prm`, `cfg`, `diag` the longer ones |
//! | `ppo` | the words of Data_Exchange, also without a telegram around them |
//! | `pkw` | jobs and replies of the parameter channel, and what is mistaken about them |
//! | [`words`] | every bit of STW, ZSW, SSW and the general status register by operating mode |
//! | [`value`] | values of parameters with their unit |
//! | `text` | [`HexText`]: octets written as text |
//! | `overheard` | another protocol on a line where nobody speaks DP |
//! | `decoder` | [`Decoder`]: streams cut into telegrams and words |
//! | [`canopen`] | frames of a CANopen network |
//!
//! An explanation is data: [`Explanation::line`] and `Display` write it as text, the feature `serde` serialises it.
//! Nothing here panics, whatever the octets, and every octet is in exactly one of the innermost fields (or, of a
//! word, every bit).
//!
//! ```
//! use profidrive::explain::{Context, Mark};
//!
//! let mut context = Context::default();
//! let asked = context.telegram(&[0x68, 0x05, 0x05, 0x68, 0x85, 0x82, 0x6D, 0x3C, 0x3E, 0xEE, 0x16]);
//! assert_eq!(asked.line(), "2 -> 5  Slave_Diag request");
//!
//! // A wrong checksum says so, and what the telegram would mean without it.
//! let broken = context.telegram(&[0x10, 0x05, 0x02, 0x49, 0x51, 0x16]);
//! assert_eq!(broken.mark(), Mark::Invalid);
//! assert_eq!(
//!     broken.line(),
//!     "2 -> 5  invalid at octet 4: frame check sequence is 0x51, expected 0x50; FDL status request",
//! );
//!
//! // The job of the manual's example (chapter 7.6.1) alone.
//! let job = context.bare(&[0x13, 0xFA, 0, 0, 0, 0, 0, 0], None);
//! assert_eq!(job.unwrap().line(), "PKW job: read PNU 1018 Calibration value");
//! ```

mod acyclic;
pub mod canopen;
mod cfg;
mod context;
mod decoder;
mod diag;
mod field;
mod frame;
mod known;
mod overheard;
mod parameters;
mod pkw;
mod ppo;
mod service;
mod set_prm;
mod text;
pub mod value;
pub mod words;

pub use context::Context;
pub(crate) use context::{MODES, Mode};
pub use decoder::{Decoder, Taking};
pub use field::{Bits, Field, Mark, hex};
pub use known::Known;
pub(crate) use overheard::Overheard;
#[cfg(feature = "emulator")]
pub(crate) use parameters::{description_text, values_text};
pub use text::{HexText, TextError};

use core::fmt;

use crate::can_bus::can::Id;

/// What some octets say.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Explanation {
    /// What the octets were taken as.
    pub kind: Kind,
    /// Identifier of a frame of CAN.
    #[cfg_attr(
        feature = "serde",
        serde(skip_serializing_if = "Option::is_none", serialize_with = "serialize_id")
    )]
    pub id: Option<Id>,
    /// Who says it, where that is known.
    pub sender: Option<Sender>,
    /// Station that sends, of a telegram with addresses; on CANopen the node whose frame it is.
    pub from: Option<u8>,
    /// Station that is meant; 127 means all. On CANopen the node, missing for all.
    pub to: Option<u8>,
    /// Name of the service, `Slave_Diag`; of a reply the service it answers.
    pub service: Option<&'static str>,
    /// All of it in one line, without the addresses.
    pub summary: String,
    /// The octets explained.
    #[cfg_attr(feature = "serde", serde(serialize_with = "serialize_hex"))]
    pub octets: Vec<u8>,
    /// The fields, in the order of the octets.
    pub fields: Vec<Field>,
}

impl Explanation {
    /// Of something that nobody sends and that is no service.
    pub(crate) fn of_nobody(kind: Kind, summary: String, octets: &[u8], fields: Vec<Field>) -> Self {
        let octets = octets.into();
        Self { kind, id: None, sender: None, from: None, to: None, service: None, summary, octets, fields }
    }
}

/// What octets were taken as.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Kind {
    /// A telegram of PROFIBUS with a service, or a short acknowledge.
    Telegram,
    /// A telegram that passes the token.
    Token,
    /// Fourteen octets without a telegram: the user data of one Data_Exchange.
    Ppo,
    /// Eight octets: the parameter channel.
    Pkw,
    /// Six octets: control word and setpoint, or status word and actual value.
    Pzd,
    /// Two octets: control word or status word.
    Word,
    /// A frame of CAN.
    Frame,
    /// An error frame of CAN.
    ErrorFrame,
    /// Octets that are none of these.
    Noise,
}

/// Which end of the line says something.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
pub enum Sender {
    /// The master: requests, outputs, jobs, control words.
    Master,
    /// The slave: responses, inputs, replies, status words.
    Slave,
}

impl Explanation {
    /// The highest mark of all fields.
    pub fn mark(&self) -> Mark {
        self.fields.iter().map(Field::worst).max().unwrap_or_default()
    }

    /// Every hint, in the order of the fields.
    pub(crate) fn hints(&self) -> Vec<&str> {
        let mut hints = Vec::new();
        self.walk(&mut |_, field| hints.extend(field.hints.iter().map(String::as_str)));
        hints
    }

    /// Visits every field from the outside in, with its depth.
    pub(crate) fn walk<'a>(&'a self, visit: &mut dyn FnMut(usize, &'a Field)) {
        for field in &self.fields {
            field.walk(visit);
        }
    }

    /// Addresses or identifier, and summary, in one line.
    pub fn line(&self) -> String {
        if let Some(id) = self.id {
            return format!("{id}  {}", self.summary);
        }
        match (self.from, self.to) {
            (Some(from), Some(127)) => format!("{from} -> all  {}", self.summary),
            (Some(from), Some(to)) => format!("{from} -> {to}  {}", self.summary),
            (None, _) | (_, None) => self.summary.clone(),
        }
    }
}

impl fmt::Display for Explanation {
    /// The line, then each field in a line of its own: octet or bits, name, value, meaning. Parts are indented, hints
    /// stand below what they are about. `!` marks trouble, `X` a mistake or what is invalid.
    ///
    /// ```text
    /// PKW job: read PNU 1018 Calibration value
    ///        0  PKW job   13 FA 00 00 00 00 00 00  read PNU 1018 Calibration value
    ///        0    PKE     13FA
    ///   b15-12      AK    0001                     1, read value
    /// ```
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.line())?;
        let mut rows = Vec::new();
        self.walk(&mut |depth, field| rows.push(Row::new(depth, field)));
        let widest = |width: fn(&Row<'_>) -> usize| rows.iter().map(width).max().unwrap_or(0);
        let name = widest(|row| row.name.chars().count());
        let value = widest(|row| row.value.len());
        rows.iter().try_for_each(|row| row.write(f, name, value))
    }
}

/// The most octets written beside the name of a field. More follow in lines of their own.
const MOST_BESIDE: usize = 8;
/// Octets in a line of their own.
const OCTETS_A_LINE: usize = 16;

/// A field on its way to a line of text.
struct Row<'a> {
    place: String,
    name: String,
    value: String,
    more: &'a str,
    field: &'a Field,
}

impl<'a> Row<'a> {
    fn new(depth: usize, field: &'a Field) -> Self {
        let long = field.bits.is_none() && field.len > MOST_BESIDE;
        let place = match field.bits {
            Some(Bits { high, low }) if high == low => format!("b{low}"),
            Some(Bits { high, low }) => format!("b{high}-{low}"),
            None => format!("{}", field.at),
        };
        let name = format!("{}{}", "  ".repeat(depth), field.name);
        let value = if long { format!("{} octets", field.len) } else { field.raw.clone() };
        // What parts show in octets of their own need not be shown twice.
        let more = if long && field.fields.is_empty() { field.raw.as_str() } else { "" };
        Self { place, name, value, more, field }
    }

    fn write(&self, f: &mut fmt::Formatter<'_>, name: usize, value: usize) -> fmt::Result {
        let Self { place, field, .. } = self;
        let mark = match field.mark {
            Mark::Plain => ' ',
            Mark::Trouble => '!',
            Mark::Mistake | Mark::Invalid => 'X',
        };
        let meaning = if field.meaning == field.name { "" } else { field.meaning.as_str() };
        let line = format!("{mark} {place:>6}  {:<name$}  {:<value$}  {meaning}", self.name, self.value);
        writeln!(f, "{}", line.trim_end())?;
        let indent = name + 12;
        let octets: Vec<&str> = self.more.split(' ').filter(|octet| !octet.is_empty()).collect();
        for octets in octets.chunks(OCTETS_A_LINE) {
            writeln!(f, "{:indent$}{}", "", octets.join(" "))?;
        }
        field.hints.iter().try_for_each(|hint| writeln!(f, "{:indent$}^ {hint}", ""))
    }
}

#[cfg(feature = "serde")]
fn serialize_id<S: serde::Serializer>(id: &Option<Id>, serializer: S) -> Result<S::Ok, S::Error> {
    match id {
        Some(id) => serializer.collect_str(id),
        None => serializer.serialize_none(),
    }
}

#[cfg(feature = "serde")]
fn serialize_hex<S: serde::Serializer>(octets: &[u8], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&hex(octets))
}
