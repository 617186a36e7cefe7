//! The tables and keys of the file. Their words are the descriptions of the JSON Schema.

use core::fmt;
use core::marker::PhantomData;
use core::ops::Range;
use std::collections::BTreeMap;

use crate::host::list::{Given, Group};
use serde::de::{MapAccess, Visitor};
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
#[derive(Debug, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[cfg_attr(test, schemars(transform = super::schema::rules_of_line))]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct LineTable {
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
    /// Drives on PROFIBUS.
    #[serde(default)]
    pub(super) drive: Vec<At<DeviceTable<Drive>>>,
    /// Drives with variable speed of PROFIDRIVE version 2 (docs/ppo-drive.md).
    #[serde(default)]
    pub(super) ppo_drive: Vec<At<DeviceTable<PpoDrive>>>,
    /// Servo drives of PROFIdrive 3 and 4, with DP-V1 (docs/profidrive.md).
    #[serde(default)]
    pub(super) profidrive: Vec<At<DeviceTable<Profidrive>>>,
    /// Stations that a GSD describes.
    #[serde(default)]
    pub(super) station: Vec<At<DeviceTable<Station>>>,
    /// CANopen nodes.
    #[serde(default)]
    pub(super) node: Vec<At<DeviceTable<Node>>>,
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

/// A group of devices, whose tables have the keys of its specification.
pub(super) trait OfGroup {
    const GROUP: Group;
}

/// [`Group::Drive`].
#[derive(Debug)]
pub(super) struct Drive;

/// [`Group::PpoDrive`].
#[derive(Debug)]
pub(super) struct PpoDrive;

/// [`Group::Profidrive`].
#[derive(Debug)]
pub(super) struct Profidrive;

/// [`Group::Station`].
#[derive(Debug)]
pub(super) struct Station;

/// [`Group::Node`].
#[derive(Debug)]
pub(super) struct Node;

impl OfGroup for Drive {
    const GROUP: Group = Group::Drive;
}

impl OfGroup for PpoDrive {
    const GROUP: Group = Group::PpoDrive;
}

impl OfGroup for Profidrive {
    const GROUP: Group = Group::Profidrive;
}

impl OfGroup for Station {
    const GROUP: Group = Group::Station;
}

impl OfGroup for Node {
    const GROUP: Group = Group::Node;
}

/// A device of a group: the keys of its specification.
#[derive(Debug)]
pub(super) struct DeviceTable<G> {
    pub(super) given: Vec<(String, Given)>,
    group: PhantomData<G>,
}

impl<'de, G: OfGroup> Deserialize<'de> for DeviceTable<G> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(Keys(PhantomData))
    }
}

struct Keys<G>(PhantomData<G>);

impl<'de, G: OfGroup> Visitor<'de> for Keys<G> {
    type Value = DeviceTable<G>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a table [[line.{}]]", G::GROUP.name())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<DeviceTable<G>, A::Error> {
        let mut given = Vec::new();
        while let Some(entry) = map.next_entry()? {
            given.push(entry);
        }
        Ok(DeviceTable { given, group: PhantomData })
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
