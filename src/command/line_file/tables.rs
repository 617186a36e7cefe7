//! The tables and keys of the file. Their words are the descriptions of the JSON Schema.

use core::fmt;
use core::ops::Range;
use std::collections::BTreeMap;

use crate::host::list::{Given, Group};
use serde::de::value::{self, MapAccessDeserializer, StringDeserializer};
use serde::de::{DeserializeSeed, Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use toml::Spanned;

/// A value, and where it stands.
#[derive(Clone, Debug, Deserialize)]
#[serde(transparent)]
pub(super) struct At<T>(Spanned<T>);

impl<T> At<T> {
    pub(super) fn span(&self) -> Range<usize> {
        self.0.span()
    }

    pub(super) fn get(&self) -> &T {
        self.0.get_ref()
    }
}

/// A file for `profidrive emulate --line`.
#[derive(Debug, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[cfg_attr(test, schemars(transform = super::schema::rules_of_file))]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct LineFile {
    /// The lines, each with a master of its own.
    pub(super) line: Vec<At<LineTable>>,
    /// Where the metrics of all lines are served to Prometheus, ADDR:PORT.
    pub(super) metrics: Option<At<String>>,
    /// Lets other machines read the metrics.
    pub(super) metrics_allow_remote: Option<At<bool>>,
}

/// A line of PROFIBUS with drives and stations, or a CAN bus with nodes.
#[derive(Debug)]
pub(super) struct LineTable {
    pub(super) keys: LineKeys,
    /// The tables of each group of the list, in their order.
    pub(super) devices: Vec<(Group, Vec<At<DeviceTable>>)>,
}

impl LineTable {
    /// The tables of a group.
    pub(super) fn of(&self, group: Group) -> impl Iterator<Item = &At<DeviceTable>> {
        self.devices.iter().filter(move |(known, _)| *known == group).flat_map(|(_, tables)| tables)
    }
}

/// What a line has beside its devices.
#[derive(Debug, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[cfg_attr(test, schemars(transform = super::schema::rules_of_line))]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct LineKeys {
    /// pty, pty:PATH, serial:DEVICE, tcp:HOST:PORT; of a CAN bus slcan-pty, slcan-pty:PATH, slcan-tcp:HOST:PORT, slcan-tty:PATH, socketcan:INTERFACE.
    pub(super) link: At<String>,
    /// Bit/s, or "auto".
    pub(super) baud: Option<At<Baud>>,
    /// The slot time of the master on a serial line, 37 to 16383 bit times.
    pub(super) slot_time: Option<At<u16>>,
    /// Do not listen first whether another station has an address.
    pub(super) force_address: Option<At<bool>>,
    /// Lets other machines connect to a tcp link.
    pub(super) allow_remote: Option<At<bool>>,
    /// Where the panel is served, ADDR:PORT.
    pub(super) panel: Option<At<String>>,
    /// Lets other machines reach the panel.
    pub(super) panel_allow_remote: Option<At<bool>>,
    /// The folder of device files and tables that may be named over HTTP.
    pub(super) panel_files: Option<At<String>>,
    /// Lets those who connect to the panel use a small master in this program.
    pub(super) bench: Option<At<bool>>,
    /// The directory in which the drives or nodes keep their EEPROMs.
    pub(super) state_dir: Option<At<String>>,
    /// The file for a capture, FILE.pcapng.
    pub(super) capture: Option<At<String>>,
    /// How all drives or nodes behave where the manuals are not clear: name and value (docs/quirks.md).
    #[serde(default)]
    pub(super) quirks: BTreeMap<String, At<String>>,
    /// Faults on purpose.
    #[serde(default)]
    pub(super) fault: Vec<FaultTable>,
}

/// A rate.
#[derive(Debug, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[cfg_attr(test, schemars(transform = super::schema::rules_of_baud))]
#[serde(untagged)]
pub(super) enum Baud {
    /// Bit/s.
    Rate(u32),
    /// "auto".
    Word(String),
}

/// A device: the keys of its specification.
#[derive(Debug)]
pub(super) struct DeviceTable {
    pub(super) given: Vec<(String, Given)>,
}

impl<'de> Deserialize<'de> for DeviceTable {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(DeviceKeys)
    }
}

struct DeviceKeys;

impl<'de> Visitor<'de> for DeviceKeys {
    type Value = DeviceTable;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a table for each device")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<DeviceTable, A::Error> {
        let mut given = Vec::new();
        while let Some(entry) = map.next_entry()? {
            given.push(entry);
        }
        Ok(DeviceTable { given })
    }
}

impl<'de> Deserialize<'de> for LineTable {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(WholeLine)
    }
}

struct WholeLine;

impl<'de> Visitor<'de> for WholeLine {
    type Value = LineTable;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a table [[line]]")
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<LineTable, A::Error> {
        let mut devices = Vec::new();
        let rest = BesideDevices { map, devices: &mut devices };
        let keys = LineKeys::deserialize(MapAccessDeserializer::new(rest))?;
        Ok(LineTable { keys, devices })
    }
}

/// A table without the keys that are groups of devices, which are put aside.
struct BesideDevices<'a, A> {
    map: A,
    devices: &'a mut Vec<(Group, Vec<At<DeviceTable>>)>,
}

impl<'de, A: MapAccess<'de>> MapAccess<'de> for BesideDevices<'_, A> {
    type Error = A::Error;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, A::Error> {
        let mut key = self.map.next_key_seed(LineKey(seed))?;
        while let Some(Key::Group(group, seed)) = key {
            self.devices.push((group, self.map.next_value()?));
            key = self.map.next_key_seed(LineKey(seed))?;
        }
        Ok(match key {
            Some(Key::Other(value)) => Some(value),
            Some(Key::Group(..)) | None => None,
        })
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, A::Error> {
        self.map.next_value_seed(seed)
    }
}

/// A key of a line: a group of devices, with what is read if it is another one, or what was read.
enum Key<K, V> {
    Group(Group, K),
    Other(V),
}

struct LineKey<K>(K);

impl<'de, K: DeserializeSeed<'de>> DeserializeSeed<'de> for LineKey<K> {
    type Value = Key<K, K::Value>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Self::Value, D::Error> {
        let key = String::deserialize(deserializer)?;
        if let Some(group) = Group::ALL.into_iter().find(|group| group.name() == key) {
            return Ok(Key::Group(group, self.0));
        }
        let read = self.0.deserialize(StringDeserializer::<value::Error>::new(key));
        read.map(Key::Other).map_err(|error| {
            let groups = Group::ALL.map(|group| format!(", `{}`", group.name()));
            D::Error::custom(format!("{error}{}", groups.concat()))
        })
    }
}

/// A fault on purpose, and when it may act.
#[derive(Debug, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[cfg_attr(test, schemars(transform = super::schema::rules_of_fault))]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct FaultTable {
    /// As for `--fault` (docs/faults.md), for example "late=3ms,station=7,service=Data_Exchange,at=100".
    pub(super) fault: At<String>,
    /// Not before this time after the start of the line, for example "10s".
    pub(super) from: Option<At<String>>,
    /// Not after this time.
    pub(super) until: Option<At<String>>,
    /// Only while this is true.
    #[serde(rename = "while")]
    pub(super) while_input: Option<At<WhileTable>>,
}

/// A condition on an input of a station: one of `is`, `above`, `below`.
#[derive(Debug, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[cfg_attr(test, schemars(transform = super::schema::rules_of_condition))]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct WhileTable {
    /// The address of the station.
    pub(super) station: At<u8>,
    /// The number of the slot.
    pub(super) slot: At<u16>,
    /// Its first octet in the slot, from 0; 0 unless given.
    pub(super) octet: Option<At<u8>>,
    /// bit0 to bit7, unsigned8, unsigned16, unsigned32, signed8, signed16, signed32 or float32.
    #[serde(rename = "type")]
    pub(super) kind: At<String>,
    /// It has this value.
    pub(super) is: Option<At<f64>>,
    /// It is greater.
    pub(super) above: Option<At<f64>>,
    /// It is less.
    pub(super) below: Option<At<f64>>,
}
