//! Groups of devices: by which option, table or route they are given.

use super::choice::{near, one_of};
use super::{Choice, DEVICES, Device, Takes, Wrong};
use crate::can_bus::canopen::NodeId;
use crate::profibus::fdl::Address;

/// By which option, table or route devices are given.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Group {
    /// Drives with a model of their own, on PROFIBUS: `--drive`.
    Drive,
    /// Drives of the profile, on PROFIBUS: `--ppo-drive`.
    PpoDrive,
    /// Drives of PROFIdrive 3 and 4, on PROFIBUS: `--profidrive`.
    Profidrive,
    /// What a file describes, on PROFIBUS: `--station`.
    Station,
    /// Nodes on CANopen: `--node`.
    Node,
}

impl Group {
    /// Every group.
    pub(crate) const ALL: [Self; 5] =
        [Self::Drive, Self::PpoDrive, Self::Profidrive, Self::Station, Self::Node];

    /// Its table in TOML; with `--` its option.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Drive => "drive",
            Self::PpoDrive => "ppo-drive",
            Self::Profidrive => "profidrive",
            Self::Station => "station",
            Self::Node => "node",
        }
    }

    /// One of its devices, in words.
    pub(crate) const fn one(self) -> &'static str {
        match self {
            Self::Drive => "A drive",
            Self::PpoDrive => "A drive with variable speed of PROFIDRIVE version 2",
            Self::Profidrive => "A servo drive of PROFIdrive 3 and 4 with DP-V1",
            Self::Station => "A station that a device file (GSD) describes",
            Self::Node => "A CANopen node",
        }
    }

    /// The page about it, behind its name.
    pub(crate) const fn page(self) -> &'static str {
        match self {
            Self::PpoDrive => " (docs/ppo-drive.md)",
            Self::Profidrive => " (docs/profidrive.md)",
            Self::Drive | Self::Station | Self::Node => "",
        }
    }

    /// What its option may be given.
    pub(crate) const fn example(self) -> &'static str {
        match self {
            Self::Drive | Self::Node => "5",
            Self::PpoDrive => "7,ppo=1,parameters=drive.toml",
            Self::Profidrive => "8,telegram=1",
            Self::Station => "9,gsd=valves.gsd",
        }
    }

    /// Whether its devices are on a CAN bus, not on PROFIBUS.
    pub(crate) const fn is_on_can(self) -> bool {
        match self {
            Self::Drive | Self::PpoDrive | Self::Profidrive | Self::Station => false,
            Self::Node => true,
        }
    }

    /// What the option of the group takes, in a line.
    pub(crate) fn help(self) -> String {
        let link = if self.is_on_can() { ", on a link of a CAN bus" } else { "" };
        let form = self.form(self.place().1);
        format!("{}{link}: {form}; repeat it for more{}", self.one(), self.page())
    }

    /// The same, with a line for everything that can be chosen.
    pub(crate) fn long_help(self) -> String {
        let named = self.choices().into_iter().map(|choice| (choice.form(true), choice.about));
        let named = named.filter(|(form, _)| !form.is_empty());
        let rows: String = named
            .map(|(form, about)| {
                let form = form.trim_start_matches(',');
                format!("\n  {form}\n      {about}")
            })
            .collect();
        format!("{}{rows}", self.help())
    }

    /// The usual device of the group at this place, with what is chosen about it unless something else is.
    pub(crate) fn usual(self, place: u8) -> String {
        let Some(device) = self.devices().next() else { return place.to_string() };
        let chosen = device.choices().iter().filter_map(|choice| {
            let Takes::OneOf(_, Some(usual)) = choice.takes else { return None };
            Some(format!(",{}={usual}", choice.key))
        });
        format!("{place},{}={}{}", self.device_key(), device.name(), chosen.collect::<String>())
    }

    /// The key of the place on the bus.
    pub(crate) const fn place_key(self) -> &'static str {
        match self {
            Self::Drive | Self::PpoDrive | Self::Profidrive | Self::Station => "address",
            Self::Node => "id",
        }
    }

    /// The key that says which device of the group it is.
    pub(crate) const fn device_key(self) -> &'static str {
        match self {
            Self::Drive => "model",
            Self::PpoDrive | Self::Profidrive | Self::Station | Self::Node => "device",
        }
    }

    /// The devices of the group, the usual one first.
    pub(crate) fn devices(self) -> impl Iterator<Item = &'static Device> {
        DEVICES.iter().filter(move |device| device.group() == self)
    }

    /// The names of its devices, sorted.
    pub(crate) fn names(self) -> Vec<&'static str> {
        let mut names: Vec<_> = self.devices().map(Device::name).collect();
        names.sort_unstable();
        names
    }

    /// Everything that can be chosen about one of its devices, each key once.
    pub(crate) fn choices(self) -> Vec<&'static Choice> {
        let mut all: Vec<&'static Choice> = Vec::new();
        for choice in self.devices().flat_map(|device| device.choices()) {
            if all.iter().all(|known| known.key != choice.key) {
                all.push(choice);
            }
        }
        all
    }

    /// The form of a specification, `place` before it: `ADDRESS[,model=ag03-1|ag03][,gear=24|48]`.
    pub(crate) fn form(self, place: &str) -> String {
        let device = match &*self.names() {
            [_] | [] => String::new(),
            several => format!("[,{}={}]", self.device_key(), several.join("|")),
        };
        let choices: String =
            self.choices().into_iter().map(|choice| choice.form(self.requires(choice))).collect();
        format!("{place}{device}{choices}")
    }

    /// Whether none of its devices can be without it.
    pub(super) fn requires(self, choice: &Choice) -> bool {
        let mut devices = self.devices();
        devices.all(|device| device.choices().iter().any(|own| own.key == choice.key && own.required))
    }

    /// What its place is called, and in a form.
    const fn place(self) -> (&'static str, &'static str) {
        match self {
            Self::Drive | Self::PpoDrive | Self::Profidrive | Self::Station => ("address", "ADDRESS"),
            Self::Node => ("node number", "ID"),
        }
    }

    pub(super) fn without_place(self) -> Wrong {
        Wrong::whole(format!("the {} is missing; {}", self.place().0, self.expected()))
    }

    pub(super) fn expected(self) -> String {
        format!("expected {}", self.form(self.place().1))
    }

    /// The device of that name.
    pub(super) fn device(self, name: &str) -> Result<&'static Device, String> {
        let key = self.device_key();
        self.devices().find(|device| device.name() == name).ok_or_else(|| {
            let names = self.names();
            let other = DEVICES.iter().find(|device| device.name() == name && device.group() != self);
            let near = match other.map(|device| device.group().name()) {
                Some(other) => format!("it is a device of --{other} (in a line file [[line.{other}]]); "),
                None => near(name, names.iter().copied()),
            };
            let known = if other.is_some() { "no device of this kind" } else { "unknown" };
            format!("{key} '{name}' is {known}; {near}expected {}", one_of(&names))
        })
    }

    /// The number of a place.
    pub(super) fn number(self, text: &str) -> Result<u8, String> {
        let (what, _) = self.place();
        if text.is_empty() || !text.bytes().all(|octet| octet.is_ascii_digit()) {
            let is_range = matches!(self, Self::Drive) && text.contains('-');
            let several = if is_range { "for several drives use --drives FIRST-LAST; " } else { "" };
            return Err(format!("'{text}' is no {what}; {several}{}", self.expected()));
        }
        let number = text.parse().ok().filter(|number| self.has_place(*number));
        number.ok_or_else(|| match self {
            Self::Drive | Self::PpoDrive | Self::Profidrive | Self::Station => {
                format!("address {text} is outside 0 to 126")
            }
            Self::Node => format!("node number {text} is outside 1 to 127"),
        })
    }

    fn has_place(self, number: u8) -> bool {
        match self {
            Self::Drive | Self::PpoDrive | Self::Profidrive | Self::Station => {
                Address::station(number).is_ok()
            }
            Self::Node => NodeId::new(number).is_ok(),
        }
    }
}
