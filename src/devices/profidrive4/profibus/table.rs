//! The parameters of the drive: those of the profile, its settings, what it measures, and those of a file.

use crate::map::Map;
use std::borrow::Cow;

use super::free::Way;
use super::value;
use crate::devices::ppo_drive::Quantity;
use crate::devices::ppo_drive::table::{Channel, Row, Tie};
use crate::devices::profidrive4::block::BLOCKS;
use crate::devices::profidrive4::{BlockField, Setting, SettingKind};
use crate::profibus::dpv1::base_mode::Format;

/// A parameter.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub(super) name: Cow<'static, str>,
    pub(super) format: Format,
    /// How many elements, from 0; `None`: it is no array.
    pub(super) elements: Option<u16>,
    /// The least and the greatest value, on the bus.
    pub(super) limits: (f64, f64),
    pub(super) unit: Cow<'static, str>,
    /// What 1 on the bus is, in the unit of its source.
    pub(super) scale: f64,
    pub(super) writable: bool,
    pub(super) source: Source,
    /// What its values stand for.
    pub(super) texts: &'static [&'static str],
}

/// Where its values are.
#[derive(Clone, Debug)]
pub(super) enum Source {
    Profile(Profile),
    Setting(Setting),
    Block(BlockField),
    Actual(Actual),
    /// Here, with those of a new drive.
    Own {
        values: Vec<f64>,
        first: Vec<f64>,
    },
}

/// What the drive measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Actual {
    Setpoint,
    Speed,
    Current,
    Torque,
    Position,
    Fault,
    Warning,
}

macro_rules! profile {
    ($($name:ident = $pnu:literal: $words:literal, $format:ident $([$elements:literal])?, $access:ident $($texts:expr)?;)*) => {
        /// A parameter of the profile.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(super) enum Profile {
            $($name,)*
            /// The last to the eighth-last warning, 953 to 960.
            Warning(u8),
        }

        fn of_profile() -> impl Iterator<Item = (u16, Entry)> {
            const ROWS: usize = [$($pnu),*].len();
            let all: [(u16, &'static str, Format, Option<u16>, &str, Profile, &[&'static [&'static str]]); ROWS] = [$((
                $pnu,
                $words,
                Format::$format,
                None$(.or(Some($elements)))?,
                stringify!($access),
                Profile::$name,
                &[$($texts)?],
            ),)*];
            all.into_iter().map(|(pnu, name, format, elements, access, profile, texts)| {
                let texts = texts.first().copied().unwrap_or_default();
                (pnu, Entry::of_profile(name, format, elements, access == "rw", profile, texts))
            })
        }
    };
}

const MODES: &[&str] = &["", "speed, ramp", "positioning", "speed, no ramp"];
const RATES: &[&str] = &[
    "9.6 kbit/s",
    "19.2 kbit/s",
    "93.75 kbit/s",
    "187.5 kbit/s",
    "500 kbit/s",
    "",
    "1.5 Mbit/s",
    "3 Mbit/s",
    "6 Mbit/s",
    "12 Mbit/s",
    "31.25 kbit/s",
    "45.45 kbit/s",
];
const STORING: &[&str] = &["done", "store"];

profile! {
    Setpoints = 915: "signals of the setpoints", UNSIGNED16 [0], rw;
    ActualValues = 916: "signals of the actual values", UNSIGNED16 [0], rw;
    Address = 918: "station address", UNSIGNED16, r;
    SystemNumber = 919: "device system number", VISIBLE_STRING [16], r;
    Telegram = 922: "telegram number", UNSIGNED16, r;
    Signals = 923: "parameter of each signal", UNSIGNED16 [0], r;
    ParameterRights = 927: "right to change parameters", UNSIGNED16, rw;
    ProcessRights = 928: "right to command by process data", UNSIGNED16, r;
    Mode = 930: "operating mode", UNSIGNED16, r MODES;
    FaultMessages = 944: "fault message counter", UNSIGNED16, r;
    FaultCodes = 945: "fault code", UNSIGNED16 [64], r;
    FaultNumbers = 947: "fault number", UNSIGNED16 [64], r;
    FaultTimes = 948: "fault time", TIME_DIFFERENCE [64], r;
    FaultValues = 949: "fault value", INTEGER32 [64], r;
    FaultScaling = 950: "situations and faults of the buffer", UNSIGNED16 [2], r;
    FaultList = 951: "fault numbers that there are", UNSIGNED16 [0], r;
    FaultSituations = 952: "number of fault situations", UNSIGNED16, rw;
    Rate = 963: "rate of the line", UNSIGNED16, r RATES;
    Identification = 964: "identification of the device", UNSIGNED16 [7], r;
    Version = 965: "profile and version", OCTET_STRING [2], r;
    ControlWord = 967: "control word 1", V2, r;
    StatusWord = 968: "status word 1", V2, r;
    Store = 971: "store parameters", UNSIGNED16, rw STORING;
    Reset = 972: "reset of the drive", UNSIGNED16, rw;
    BaseMode = 974: "length, parameters, requests at once", UNSIGNED16 [3], r;
    Object = 975: "identification of the drive object", UNSIGNED16 [8], r;
    Factory = 976: "settings of a new drive", UNSIGNED16, rw;
    Objects = 978: "drive objects", UNSIGNED8 [1], r;
    EncoderFormat = 979: "format of the encoder", UNSIGNED32 [31], r;
    List = 980: "parameters that there are", UNSIGNED16 [0], r;
    SpeedReference = 60000: "reference of the speed", FLOAT, r;
}

impl Profile {
    /// Which process data it names the signals of.
    pub(super) fn way(self) -> Option<Way> {
        let ways = [(Self::Setpoints, Way::Setpoints), (Self::ActualValues, Way::ActualValues)];
        ways.into_iter().find(|(profile, _)| *profile == self).map(|(_, way)| way)
    }
}

impl Entry {
    /// As [`Profile::way`].
    pub(super) fn way(&self) -> Option<Way> {
        if let Source::Profile(profile) = &self.source { profile.way() } else { None }
    }

    fn of_profile(
        name: &'static str,
        format: Format,
        elements: Option<u16>,
        writable: bool,
        profile: Profile,
        texts: &'static [&'static str],
    ) -> Self {
        let is_switch =
            matches!(profile, Profile::ParameterRights | Profile::Store | Profile::Factory | Profile::Reset);
        let limits = if is_switch { (0.0, 1.0) } else { value::range(format) };
        Self {
            name: Cow::Borrowed(name),
            format,
            elements,
            limits,
            unit: Cow::Borrowed(""),
            scale: 1.0,
            writable,
            source: Source::Profile(profile),
            texts,
        }
    }

    fn of_setting(setting: Setting) -> Self {
        Self {
            name: setting.name().into(),
            format: match setting.kind() {
                SettingKind::Float => Format::FLOAT,
                SettingKind::Word => Format::UNSIGNED16,
                SettingKind::Signed => Format::INTEGER32,
                SettingKind::Double => Format::UNSIGNED32,
            },
            elements: None,
            limits: setting.limits(),
            unit: setting.unit().into(),
            scale: 1.0,
            writable: true,
            source: Source::Setting(setting),
            texts: &[],
        }
    }

    fn of_block(field: BlockField) -> Self {
        Self {
            name: field.name().into(),
            format: Format::INTEGER32,
            elements: u16::try_from(BLOCKS).ok(),
            limits: field.limits(),
            unit: field.unit().into(),
            scale: 1.0,
            writable: true,
            source: Source::Block(field),
            texts: &[],
        }
    }

    fn measured(name: &'static str, format: Format, unit: &'static str, actual: Actual) -> Self {
        Self {
            name: name.into(),
            format,
            elements: None,
            limits: value::range(format),
            unit: unit.into(),
            scale: 1.0,
            writable: false,
            source: Source::Actual(actual),
            texts: &[],
        }
    }

    /// The parameter of a row of a file.
    fn of_row(row: &Row) -> Result<Self, String> {
        let count = usize::from(row.elements.unwrap_or(1));
        let given =
            |place: usize| row.default.as_ref().and_then(|all| all.get(place)).copied().unwrap_or(0.0);
        let first: Vec<f64> = (0..count).map(given).collect();
        let source = match row.tie {
            Tie::None => Source::Own { values: first.clone(), first },
            Tie::Drive(quantity) => of_quantity(quantity).ok_or_else(|| unknown(row, quantity.name()))?,
            Tie::Channel(channel) => of_channel(channel).ok_or_else(|| unknown(row, channel.name()))?,
        };
        let elements = match &source {
            Source::Own { .. } => row.elements.map(u16::from),
            Source::Profile(profile) => profile_elements(*profile),
            Source::Setting(_) | Source::Block(_) | Source::Actual(_) => None,
        };
        Ok(Self {
            name: row.name.clone().into(),
            format: Format(row.kind.number()),
            elements,
            limits: (row.low, row.high),
            unit: row.unit.clone().into(),
            scale: row.scale,
            writable: row.writable && !matches!(source, Source::Actual(_)),
            source,
            texts: &[],
        })
    }

    /// Whether what is written to it is kept when it is stored.
    pub(super) const fn is_kept(&self) -> bool {
        self.writable && matches!(self.source, Source::Setting(_) | Source::Block(_) | Source::Own { .. })
    }
}

fn profile_elements(profile: Profile) -> Option<u16> {
    let is_it = |entry: &Entry| matches!(entry.source, Source::Profile(own) if own == profile);
    of_profile().find(|(_, entry)| is_it(entry)).and_then(|(_, entry)| entry.elements)
}

fn unknown(row: &Row, name: &str) -> String {
    format!("PNU {} {}: this drive has no '{name}' to be tied to; leave tie out", row.pnu, row.name)
}

/// What this drive has of what drives of version 2 have.
const fn of_quantity(quantity: Quantity) -> Option<Source> {
    Some(match quantity {
        Quantity::ReferenceSpeed => Source::Setting(Setting::ReferenceSpeed),
        Quantity::MaxSpeed => Source::Setting(Setting::MaxSpeed),
        Quantity::RampUp => Source::Setting(Setting::RampUp),
        Quantity::RampDown => Source::Setting(Setting::RampDown),
        Quantity::QuickStop => Source::Setting(Setting::QuickStop),
        Quantity::Inching1 => Source::Setting(Setting::Jog1),
        Quantity::Inching2 => Source::Setting(Setting::Jog2),
        Quantity::ComparisonSpeed => Source::Setting(Setting::ComparisonSpeed),
        Quantity::RatedCurrent => Source::Setting(Setting::ReferenceCurrent),
        Quantity::SetpointSpeed => Source::Actual(Actual::Setpoint),
        Quantity::ActualSpeed => Source::Actual(Actual::Speed),
        Quantity::Torque => Source::Actual(Actual::Torque),
        Quantity::Current => Source::Actual(Actual::Current),
        Quantity::Fault => Source::Actual(Actual::Fault),
        Quantity::Warning => Source::Actual(Actual::Warning),
        Quantity::FaultBuffer => Source::Profile(Profile::FaultNumbers),
        Quantity::FaultMessages => Source::Profile(Profile::FaultMessages),
        Quantity::FaultCount => Source::Profile(Profile::FaultSituations),
        Quantity::WarningBuffer | Quantity::Load | Quantity::RunUp => return None,
    })
}

const fn of_channel(channel: Channel) -> Option<Source> {
    Some(Source::Profile(match channel {
        Channel::ControlWord => Profile::ControlWord,
        Channel::StatusWord => Profile::StatusWord,
        Channel::Address => Profile::Address,
        Channel::Store => Profile::Store,
        Channel::List => Profile::List,
        Channel::PpoType | Channel::PzdSetpoint | Channel::PzdActual => return None,
    }))
}

fn check_first(setting: Setting, first: f64) -> Result<(), String> {
    let ((low, high), unit) = (setting.limits(), setting.unit());
    let gap = if unit.is_empty() { "" } else { " " };
    let words = || format!("the drive takes {low} to {high}{gap}{unit}, not {first}");
    (low..=high).contains(&first).then_some(()).ok_or_else(words)
}

/// All parameters by number.
#[derive(Clone, Debug)]
pub(super) struct Table {
    entries: Map<u16, Entry>,
    /// What the settings of a new drive are, where a file says so.
    pub(super) firsts: Vec<(Setting, f64)>,
}

impl Table {
    /// Those of every drive, and these of a file; of two with the same number that of the file stands.
    ///
    /// # Errors
    /// What the drive does not have, or a first value that it does not take.
    pub(super) fn new(rows: &[Row]) -> Result<Self, String> {
        let mut entries: Map<u16, Entry> = of_profile().collect();
        for (pnu, before) in (953..=960).zip(0..) {
            let name = "one of the last eight warnings";
            let warning = Profile::Warning(before);
            entries.insert(pnu, Entry::of_profile(name, Format::UNSIGNED16, None, false, warning, &[]));
        }
        entries.extend(Setting::ALL.iter().map(|setting| (setting.pnu(), Entry::of_setting(*setting))));
        entries.extend(BlockField::ALL.iter().map(|field| (field.pnu(), Entry::of_block(*field))));
        for (pnu, name, format, unit, actual) in [
            (20, "Speed setpoint", Format::FLOAT, "rpm", Actual::Setpoint),
            (21, "Actual speed", Format::FLOAT, "rpm", Actual::Speed),
            (27, "Actual current", Format::FLOAT, "A", Actual::Current),
            (31, "Actual torque", Format::FLOAT, "Nm", Actual::Torque),
            (2521, "Actual position", Format::INTEGER32, "LU", Actual::Position),
            (2131, "Fault", Format::UNSIGNED16, "", Actual::Fault),
            (2132, "Warning", Format::UNSIGNED16, "", Actual::Warning),
        ] {
            entries.insert(pnu, Entry::measured(name, format, unit, actual));
        }
        let mut firsts = Vec::new();
        for row in rows {
            let entry = Entry::of_row(row)?;
            if let (Source::Setting(setting), Some(first)) = (&entry.source, &row.default) {
                let first = first.first().copied().unwrap_or_default() * row.scale;
                check_first(*setting, first)
                    .map_err(|words| format!("PNU {} {}: {words}", row.pnu, row.name))?;
                firsts.push((*setting, first));
            }
            entries.insert(row.pnu, entry);
        }
        Ok(Self { entries, firsts })
    }

    /// A setting begins with this value.
    pub(super) fn begin_with(&mut self, setting: Setting, first: f64) -> Result<(), String> {
        check_first(setting, first)?;
        self.firsts.push((setting, first));
        Ok(())
    }

    pub(super) fn entry(&self, pnu: u16) -> Option<&Entry> {
        self.entries.get(&pnu)
    }

    pub(super) fn entry_mut(&mut self, pnu: u16) -> Option<&mut Entry> {
        self.entries.get_mut(&pnu)
    }

    /// All in the order of their numbers.
    pub(super) fn entries(&self) -> impl Iterator<Item = (u16, &Entry)> {
        self.entries.iter().map(|(pnu, entry)| (*pnu, entry))
    }

    /// What a file gives is as in a new drive.
    pub(super) fn make_new(&mut self) {
        for entry in self.entries.values_mut() {
            if let Source::Own { values, first } = &mut entry.source {
                values.clone_from(first);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_numbers_of_the_profile_are_there() {
        let table = Table::new(&[]).unwrap();
        for pnu in [
            915, 916, 918, 919, 922, 923, 925, 927, 928, 930, 944, 945, 947, 948, 949, 950, 951, 952, 953,
            960, 963, 964, 965, 967, 968, 971, 972, 974, 975, 976, 978, 979, 980, 2000, 2006, 60000,
        ] {
            assert!(table.entry(pnu).is_some(), "PNU {pnu}");
        }
        assert_eq!(table.entry(964).unwrap().elements, Some(7));
        assert_eq!(table.entry(930).unwrap().texts, MODES);
        assert!(table.entry(971).unwrap().writable && !table.entry(944).unwrap().writable);
    }
}
