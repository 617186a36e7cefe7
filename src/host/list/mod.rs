//! The list of all devices, and the specification by which each is asked for.
//!
//! | file | holds |
//! | --- | --- |
//! | here | `DEVICES`: name, options, quirks of each device and how it is made |
//! | `choice` | what can be chosen about a device, and what was chosen |
//! | `given` | what was written, in whichever form |
//! | `spec` | [`Spec`]: one specification for `a,k=v`, TOML and JSON |
//! | `objects` | what moves the inputs of nodes |
//! | `node_files` | nodes that a file describes |
//! | `slaves`, `profidrive4` | how the devices on PROFIBUS are made |
//! | `acyclic` | records of a station, and the alarms on its time line |
//! | `timed` | the diagnosis of a station on the time line |
//! | `signals`, `inputs` | the kinds of signals; the inputs of a station that follow them |
//! | `named` | parameters by number or name |
//!
//! A new device has its folder in `devices`, and an entry here.

pub(crate) mod acyclic;
mod choice;
mod given;
mod group;
pub(crate) mod inputs;
pub(crate) mod named;
#[cfg(feature = "eds")]
pub(crate) mod node_files;
#[cfg(test)]
#[cfg(feature = "eds")]
mod nouns;
pub(crate) mod objects;
mod profidrive4;
#[cfg(all(test, feature = "emulator"))]
mod schema;
#[cfg(all(test, feature = "emulator"))]
pub(crate) use schema::quirks_schema;
pub(crate) mod signals;
mod slaves;
mod spec;
pub(crate) mod timed;
mod wrong;

use core::fmt;
use std::path::Path;

pub use choice::Choices;
pub(crate) use choice::{Choice, QuirkRow, Takes};
pub(crate) use given::Given;
pub(crate) use group::Group;
pub use slaves::Ground;
pub(crate) use slaves::records_of_file;
pub(crate) use slaves::{MakeError, Prepared, Slave, ppo, table_of_file};
pub use spec::Spec;
pub(crate) use wrong::Wrong;

use crate::devices::ag03;
use crate::devices::ag03::canopen::Ag03Node;
use crate::devices::ag03::param::Model;
use crate::devices::ap10;
use crate::devices::ap10::canopen::Ap10;
use crate::devices::asda_a2;
use crate::devices::asda_a2::canopen::{AsdaA2, Level};
use crate::devices::named_word::NamedWords;
use crate::devices::profidrive4::profibus::Telegram;
use crate::host::can::Product;
use crate::profibus::fdl::Rates;
use choice::rows;

/// Every device; of a group the usual one first.
pub(crate) static DEVICES: &[Device] = &[
    Device::Slave(Slave {
        name: "ag03-1",
        group: Group::Drive,
        choices: &[GEAR, RESET, QUIRKS, VALUES],
        story: ag03::profibus::STORY,
        words: Some(&ag03::profibus::NAMED_WORDS),
        quirks: || rows(ag03::profibus::QUIRKS),
        prepare: |spec| slaves::ag03(spec, Model::Ag03_1),
    }),
    Device::Slave(Slave {
        name: "ag03",
        group: Group::Drive,
        choices: &[GEAR, RESET, QUIRKS, VALUES],
        story: ag03::profibus::STORY,
        words: Some(&ag03::profibus::NAMED_WORDS),
        quirks: || rows(ag03::profibus::QUIRKS),
        prepare: |spec| slaves::ag03(spec, Model::Ag03),
    }),
    Device::Slave(Slave {
        name: "ppo-drive",
        group: Group::PpoDrive,
        choices: &[
            Choice::of(
                "ppo",
                Takes::OneOf(&["1", "2", "3", "4", "5"], None),
                "1 to 5: only this PPO is accepted; unless given the master chooses.",
            ),
            Choice::of(
                "ident",
                Takes::Hexadecimal,
                "The ident number without a GSD, four hexadecimal digits; 5044 unless given.",
            ),
            Choice::of("gsd", Takes::File(&[]), "The device file of the drive."),
            Choice::of(
                "family",
                Takes::OneOf(&["profile", "micromaster", "611u"], None),
                "How parameters are numbered on the bus: micromaster has sub-indexes from 0 and pages of 2000, 611u \
                 sub-indexes from 0 in the low octet of IND. Unless given, that of the model in the GSD, else profile.",
            ),
            Choice::of(
                "parameters",
                Takes::File(&["toml", "csv"]),
                "The table of its parameters, .toml or .csv.",
            ),
            VALUES,
        ],
        story: &[],
        words: None,
        quirks: Vec::new,
        prepare: slaves::ppo_drive,
    }),
    Device::Slave(Slave {
        name: "profidrive",
        group: Group::Profidrive,
        choices: &[
            Choice::of(
                "telegram",
                Takes::OneOf(Telegram::WORDS, None),
                "Only this telegram is accepted; unless given the master chooses.",
            ),
            Choice::of(
                "ident",
                Takes::Hexadecimal,
                "The ident number without a GSD, four hexadecimal digits; 5034 unless given.",
            ),
            Choice::of(
                "gsd",
                Takes::File(&[]),
                "The device file of the drive; gsd/PDRV5034.GSD unless given.",
            ),
            Choice::of(
                "parameters",
                Takes::File(&["toml", "csv"]),
                "The table of its parameters beside those that every drive has, .toml or .csv.",
            ),
            VALUES,
        ],
        story: &[],
        words: None,
        quirks: Vec::new,
        prepare: profidrive4::prepare,
    }),
    Device::Slave(Slave {
        name: "gsd-station",
        group: Group::Station,
        choices: &[
            Choice { required: true, ..Choice::of("gsd", Takes::File(&[]), "The device file.") },
            Choice::of("strict", Takes::Flag, "Refuses everything that the GSD does not allow."),
            Choice::of(
                "records",
                Takes::File(&["toml"]),
                "The records that a master of DP-V1 reads and writes, and the identification of the station.",
            ),
            Choice::of(
                "modules",
                Takes::Names,
                "The names of the modules that are plugged in, slot by slot, \"\" for an empty slot. Without it the master \
                 chooses.",
            ),
            Choice::of("input", Takes::Inputs, "How its inputs change."),
            Choice::of("diagnosis", Takes::Diagnosis, "What its diagnosis reports, and when."),
            Choice::of("record", Takes::Records, "Records of DP-V1, beside those of the file 'records'."),
            Choice::of("alarm", Takes::Alarms, "Alarms that come by themselves, and when."),
            Choice::of(
                "unlike",
                Takes::OneOf(&["refuse", "report"], None),
                "Another configuration than that of modules is refused, or taken and reported as wrong and missing modules. \
                 Unless given it is reported if the GSD has texts for it.",
            ),
        ],
        story: &[],
        words: None,
        quirks: Vec::new,
        prepare: slaves::gsd_station,
    }),
    Device::Node(Product {
        name: "ag03-1",
        sheet: ag03::canopen::objects::SHEET,
        vocabulary: &ag03::canopen::VOCABULARY,
        tells: Some((ag03::canopen::objects::HARDWARE_VERSION, slaves::gear_told)),
        story: ag03::canopen::STORY,
        choices: &[GEAR, RESET, TWIN, QUIRKS, OBJECTS],
        objects: &|choices| ag03::canopen::objects::objects(slaves::gear(choices)),
        quirks: || rows(ag03::canopen::QUIRKS),
        make: &|node, choices, memory, now| {
            let gear = slaves::gear(choices);
            let mut config =
                ag03::canopen::Config { gear, eeprom: memory, ..ag03::canopen::Config::new(node) };
            choices.apply(ag03::canopen::QUIRKS, &mut config);
            let mut device = Ag03Node::new(config, now).unsupplied(now);
            if let Some(switches) = slaves::reset(choices, config.reset_patterns) {
                device.set_switches(switches);
            }
            Box::new(device)
        },
    }),
    Device::Node(Product {
        name: "ap10",
        sheet: ap10::canopen::EDS,
        vocabulary: &ap10::canopen::VOCABULARY,
        tells: None,
        story: ap10::canopen::STORY,
        choices: &[TWIN, QUIRKS, OBJECTS],
        objects: &|_| ap10::canopen::OBJECTS,
        quirks: || rows(ap10::canopen::QUIRKS),
        make: &|node, choices, memory, _| {
            let mut config = ap10::canopen::Config { memory, ..ap10::canopen::Config::new(node) };
            choices.apply(ap10::canopen::QUIRKS, &mut config.quirks);
            Box::new(Ap10::new(config))
        },
    }),
    Device::Node(Product {
        name: "asda-a2",
        sheet: asda_a2::canopen::SHEET,
        vocabulary: &asda_a2::canopen::VOCABULARY,
        tells: None,
        story: asda_a2::canopen::STORY,
        choices: &[
            Choice::of(
                "mode",
                Takes::OneOf(&["full", "half"], Some("full")),
                "How much of CiA 402 it follows; of an ASDA-A2 only.",
            ),
            TWIN,
            QUIRKS,
            OBJECTS,
        ],
        objects: &|choices| AsdaA2::objects(level(choices)),
        quirks: || rows(asda_a2::canopen::QUIRKS),
        make: &|node, choices, memory, now| {
            let mut quirks = asda_a2::canopen::Quirks::default();
            choices.apply(asda_a2::canopen::QUIRKS, &mut quirks);
            let config = asda_a2::canopen::Config {
                level: level(choices),
                ..asda_a2::canopen::Config::new(node.number())
            };
            Box::new(AsdaA2::new(config, quirks, now).with_memory(memory))
        },
    }),
    #[cfg(feature = "eds")]
    Device::NodeFile(NodeFile {
        name: "eds-node",
        choices: &[
            Choice {
                required: true,
                ..Choice::of("eds", Takes::File(&[]), "The EDS, DCF, XDD or XDC of the node.")
            },
            Choice::of(
                "profile",
                Takes::OneOf(&["file", "none"], Some("file")),
                "What is behind the objects: what the profile of its file asks for, or nothing but a memory.",
            ),
            TWIN,
            OBJECTS,
        ],
        number: node_files::number,
        product: node_files::product,
    }),
];

/// The ident numbers that say which device it is.
const IDENTS: &[(u16, &str)] = &[(ag03::profibus::IDENT_NUMBER, "SIKO AG03 or AG03/1")];

/// Which device a slave with this ident number is; `None`: no device of the list.
pub(crate) fn known_ident(ident: u16) -> Option<&'static str> {
    IDENTS.iter().find(|(number, _)| *number == ident).map(|(_, name)| *name)
}

/// The rates that the positioning drives know.
pub(crate) const RATES: Rates = ag03::profibus::DESCRIPTION.rates;

const GEAR: Choice = Choice {
    also: Some("gear_ratio"),
    ..Choice::of(
        "gear",
        Takes::OneOf(&["24", "48"], Some("48")),
        "The internal gear, of an AG03 or AG03/1 only.",
    )
};

const RESET: Choice = Choice::of(
    "reset",
    Takes::OneOf(&["all", "standard", "controller"], None),
    "Its DIP switches ask for this factory reset at the start (SW8 on): its parameters are reset, and it is not on the bus.",
);

const TWIN: Choice = Choice::of("twin", Takes::Flag, "Another node may have its number: a fault on purpose.");

const OBJECTS: Choice = Choice::of("value", Takes::Objects, "How objects change that a master cannot write.");

const QUIRKS: Choice = Choice::of(
    "quirks",
    Takes::Quirks,
    "How it behaves where the manuals are not clear; has priority over the quirks of the line.",
);

const VALUES: Choice = Choice::of(
    "values",
    Takes::Values,
    "Start values of its parameters, by number or name, of an array with the element: numbers on the bus.",
);

fn level(choices: &Choices) -> Level {
    match choices.word("mode") {
        Some("half") => Level::Half,
        Some(_) | None => Level::Full,
    }
}

/// A device that can be emulated, on the bus that it is made for.
pub(crate) enum Device {
    /// On PROFIBUS.
    Slave(Slave),
    /// On CANopen.
    Node(Product),
    /// On CANopen, whatever its file describes.
    NodeFile(NodeFile),
}

/// A device on CANopen that a file describes.
pub(crate) struct NodeFile {
    /// Its name on the command line.
    pub(crate) name: &'static str,
    /// What can be chosen about it.
    pub(crate) choices: &'static [Choice],
    /// The number that a configuration file gives its node.
    number: fn(&Path) -> Result<Option<u8>, String>,
    /// The device of the file that is chosen.
    product: fn(&Self, &Choices) -> Result<&'static Product, Wrong>,
}

impl Device {
    /// Its name on the command line, as `ag03-1`. On one bus no two have the same.
    pub(crate) const fn name(&self) -> &'static str {
        match self {
            Self::Slave(slave) => slave.name,
            Self::Node(product) => product.name,
            Self::NodeFile(file) => file.name,
        }
    }

    /// By which option, table or route it is given.
    pub(crate) const fn group(&self) -> Group {
        match self {
            Self::Slave(slave) => slave.group,
            Self::Node(_) | Self::NodeFile(_) => Group::Node,
        }
    }

    /// What can be chosen about it.
    pub(crate) const fn choices(&self) -> &'static [Choice] {
        match self {
            Self::Slave(slave) => slave.choices,
            Self::Node(product) => product.choices,
            Self::NodeFile(file) => file.choices,
        }
    }

    /// Every point on which its manual leaves a choice.
    pub(crate) fn quirks(&self) -> Vec<QuirkRow> {
        match self {
            Self::Slave(slave) => (slave.quirks)(),
            Self::Node(product) => product.quirks(),
            Self::NodeFile(_) => Vec::new(),
        }
    }

    /// Its control and status word in names, if it has names for them.
    pub(crate) const fn words(&self) -> Option<&'static NamedWords> {
        match self {
            Self::Slave(slave) => slave.words,
            Self::Node(_) | Self::NodeFile(_) => None,
        }
    }

    /// The device on CANopen, if it needs no file.
    pub(crate) const fn product(&self) -> Option<&Product> {
        match self {
            Self::Slave(_) | Self::NodeFile(_) => None,
            Self::Node(product) => Some(product),
        }
    }

    /// The device on CANopen that a file describes.
    fn of_file() -> Option<&'static NodeFile> {
        DEVICES.iter().find_map(|device| match device {
            Self::NodeFile(file) => Some(file),
            Self::Slave(_) | Self::Node(_) => None,
        })
    }
}

impl fmt::Debug for Device {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Device").field(&self.name()).finish()
    }
}

impl PartialEq for Device {
    fn eq(&self, other: &Self) -> bool {
        (self.name(), self.group()) == (other.name(), other.group())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::can_bus::canopen::node::storage::Eeprom;
    use crate::time::Instant;

    #[test]
    fn names_are_unique_in_a_group_and_every_group_has_a_device() {
        for group in Group::ALL {
            let mut names = group.names();
            let count = names.len();
            names.dedup();
            assert_eq!((names.len(), count > 0), (count, true), "{group:?}");
        }
    }

    #[test]
    fn every_value_of_every_quirk_can_be_chosen_and_the_device_is_made_with_it() {
        for device in DEVICES {
            let mut spec = Spec::plain(device, 5);
            let rows = device.quirks();
            for row in &rows {
                for value in row.values.iter().rev() {
                    spec.choose_quirk(row.name, value).unwrap();
                    assert!(spec.choices.quirks.contains(&(row.name, *value)), "{}={value}", row.name);
                    if let Some(product) = device.product() {
                        product.make(spec.node(), &spec.choices, Eeprom::Internal, Instant::ZERO);
                    } else {
                        spec.prepare().unwrap();
                    }
                }
                assert!(spec.choose_quirk(row.name, "no such value").is_err());
            }
            assert_eq!(spec.choices.quirks.len(), rows.len(), "{}", device.name());
            assert!(spec.choose_quirk("none", "x").is_err());
        }
    }
}
