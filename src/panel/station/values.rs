//! Values, words, process data and the history of a station as JSON.

use serde::{Serialize, Serializer};

use crate::explain;
use crate::face::description::{self, Amount, Curve, Exchange, ExchangeEntry, Group, Value};

/// A value of a device.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(in crate::panel) struct ValueState {
    /// A name that stays, for programs.
    key: &'static str,
    name: String,
    /// `null`: it has none.
    unit: Option<&'static str>,
    /// A number in that unit, a word, or `null`.
    value: AmountState,
    group: Group,
    /// It is worth a curve.
    #[serde(skip_serializing_if = "is_false")]
    curve: bool,
    /// Whose curve it is drawn with, dashed.
    #[serde(skip_serializing_if = "Option::is_none")]
    setpoint_of: Option<&'static str>,
    /// Digits behind the point that mean something.
    #[serde(skip_serializing_if = "Option::is_none")]
    digits: Option<u8>,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde calls it")]
const fn is_false(flag: &bool) -> bool {
    !*flag
}

/// A number, a flag, a word, or nothing.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::panel) enum AmountState {
    Unknown,
    Whole(i64),
    Number(f64),
    Flag(bool),
    Text(String),
}

impl Serialize for AmountState {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Unknown => serializer.serialize_none(),
            Self::Whole(number) => serializer.serialize_i64(*number),
            Self::Number(number) => serializer.serialize_f64(*number),
            Self::Flag(flag) => serializer.serialize_bool(*flag),
            Self::Text(text) => serializer.serialize_str(text),
        }
    }
}

/// A word of bits.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(in crate::panel) struct WordState {
    /// A name that stays, for programs: `stw`, `6041`.
    pub(in crate::panel) key: String,
    pub(in crate::panel) name: String,
    #[cfg_attr(test, schema(minimum = 0, maximum = 65535))]
    pub(in crate::panel) value: u16,
    /// Bit 0 first.
    pub(in crate::panel) bits: Vec<BitState>,
}

/// One bit with what it means now.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(in crate::panel) struct BitState {
    pub(in crate::panel) bit: u8,
    pub(in crate::panel) set: bool,
    /// A short name for programs; may be empty.
    pub(in crate::panel) key: &'static str,
    /// What the manual calls it; empty for a bit that means nothing.
    pub(in crate::panel) name: &'static str,
    /// What its level means; may be empty.
    pub(in crate::panel) meaning: &'static str,
    /// What to know about it; may be empty.
    pub(in crate::panel) note: &'static str,
    /// Whether the bit means anything.
    pub(in crate::panel) used: bool,
    /// This level needs somebody.
    pub(in crate::panel) alarm: bool,
}

/// Octets that master and device exchange.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(in crate::panel) struct Process {
    /// A name that stays, for programs: `outputs`, `TPDO1`, `slot1 inputs`.
    pub(in crate::panel) key: String,
    pub(in crate::panel) name: String,
    pub(in crate::panel) from_master: bool,
    /// The slot that they are in.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::panel) slot: Option<u16>,
    /// Octets apart; empty if only the entries are known.
    pub(in crate::panel) octets_hex: String,
    /// The bits that are forced, octets apart.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::panel) forced_hex: Option<String>,
    /// What they say, in words.
    pub(in crate::panel) details: Option<String>,
    pub(in crate::panel) entries: Vec<Entry>,
}

/// A value in octets that are exchanged.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(in crate::panel) struct Entry {
    name: String,
    /// An object, or octets.
    place: String,
    value: AmountState,
    unit: Option<&'static str>,
}

/// Something that a device remembers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(in crate::panel) struct Past {
    pub(in crate::panel) code: String,
    pub(in crate::panel) text: String,
    /// What is known of when it was.
    pub(in crate::panel) when: Option<String>,
}

impl AmountState {
    /// A whole number is written as one, unless digits behind the point mean something.
    pub(in crate::panel) fn of(amount: Amount<'_>, digits: Option<u8>) -> Self {
        match amount {
            Amount::Unknown => Self::Unknown,
            Amount::Number(number) => Self::of_number(number, digits),
            Amount::Flag(flag) => Self::Flag(flag),
            Amount::Text(text) => Self::Text(text.to_string()),
        }
    }

    #[expect(clippy::cast_possible_truncation, reason = "it is checked that it is whole and fits")]
    pub(in crate::panel) fn of_number(number: f64, digits: Option<u8>) -> Self {
        let is_whole = number.fract() == 0.0 && number.abs() < 9e15;
        match digits {
            Some(1..) => Self::Number(number),
            _ if !number.is_finite() => Self::Unknown,
            Some(0) | None if is_whole => Self::Whole(number as i64),
            Some(0) | None => Self::Number(number),
        }
    }
}

fn unit_of(unit: &'static str) -> Option<&'static str> {
    Some(unit).filter(|unit| !unit.is_empty())
}

impl ValueState {
    pub(in crate::panel) fn of(value: &Value<'_>) -> Self {
        let Value { key, name, unit, group, amount, curve, digits, headline: _ } = *value;
        Self {
            key,
            name: name.into(),
            unit: unit_of(unit),
            value: AmountState::of(amount, digits),
            group,
            curve: curve == Curve::Own,
            setpoint_of: match curve {
                Curve::SetpointOf(key) => Some(key),
                Curve::None | Curve::Own => None,
            },
            digits,
        }
    }

    /// How often something happened, by its key.
    pub(in crate::panel) fn counter(key: &'static str, count: u64) -> Self {
        Self {
            key,
            name: key.replace('_', " "),
            unit: None,
            value: AmountState::Whole(i64::try_from(count).unwrap_or(i64::MAX)),
            group: Group::Counter,
            curve: false,
            setpoint_of: None,
            digits: None,
        }
    }

    pub(in crate::panel) const fn has_curve(&self) -> bool {
        self.curve || self.setpoint_of.is_some()
    }
}

impl WordState {
    pub(in crate::panel) fn of(word: &description::Word<'_>) -> Self {
        let bit = |bit: u8| {
            let description::Bit { key, name, meaning, note, used, alarm } = (word.bit)(bit);
            BitState { bit, set: word.value >> bit & 1 != 0, key, name, meaning, note, used, alarm }
        };
        Self {
            key: word.key.to_string(),
            name: word.name.to_string(),
            value: word.value,
            bits: (0..16).map(bit).collect(),
        }
    }
}

impl Entry {
    pub(in crate::panel) fn of(entry: &ExchangeEntry<'_>) -> Self {
        Self {
            name: entry.name.into(),
            place: entry.place.to_string(),
            value: AmountState::of(entry.amount, None),
            unit: unit_of(entry.unit),
        }
    }
}

impl Process {
    pub(in crate::panel) fn of(exchange: &Exchange<'_>) -> Self {
        let mut entries = Vec::new();
        (exchange.each_entry)(&mut |entry| entries.push(Entry::of(&entry)));
        Self {
            key: exchange.key.to_string(),
            name: exchange.name.to_string(),
            from_master: exchange.from_master,
            slot: exchange.forced.map(|(slot, _)| slot),
            octets_hex: explain::hex(exchange.octets),
            forced_hex: exchange.forced.filter(|_| !exchange.from_master).map(|(_, mask)| explain::hex(mask)),
            details: exchange.details.map(|details| details.to_string()),
            entries,
        }
    }

    /// With words for what they say, if it says none.
    pub(super) fn explain(&mut self, details: &Option<String>) {
        if self.details.is_none() {
            self.details.clone_from(details);
        }
    }
}

impl Past {
    pub(in crate::panel) fn of(past: &description::Past<'_>) -> Self {
        Self {
            code: past.code.to_string(),
            text: past.text.to_string(),
            when: past.when.map(|when| when.to_string()),
        }
    }
}
