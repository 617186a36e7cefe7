//! Ranges of devices, names of devices, `--quirk`.

use core::str::FromStr;

use crate::can_bus::can::BitRate;
use crate::host::can::Product;
use crate::host::list::{self, DEVICES, Device, Group, QuirkRow, Spec};
use crate::profibus::fdl::Address;
use crate::profibus::ppo::PpoType;
use crate::time::BaudRate;
use clap::builder::{PossibleValue, TypedValueParser};

use super::nearest;

/// An address on PROFIBUS.
pub(super) fn address(text: &str, form: &str) -> Result<Address, String> {
    if text.is_empty() || !text.bytes().all(|octet| octet.is_ascii_digit()) {
        return Err(format!("'{text}' is no address; {form}"));
    }
    let station = text.parse().ok().and_then(|number| Address::station(number).ok());
    station.ok_or_else(|| format!("address {text} is outside 0 to 126"))
}

/// The type of a PPO by its number.
pub(super) fn ppo(value: &str) -> Result<PpoType, String> {
    list::ppo(value).ok_or_else(|| format!("ppo '{value}' is unknown; expected 1, 2, 3, 4 or 5"))
}

/// An ident number.
pub(super) fn ident(value: &str) -> Result<u16, String> {
    let digits = value.strip_prefix("0x").unwrap_or(value);
    u16::from_str_radix(digits, 16).map_err(|_| {
        format!("ident '{value}' is no ident number; expected four hexadecimal digits, for example 5044")
    })
}

/// Drives that differ in nothing but their addresses.
#[derive(Clone, Debug)]
pub(crate) struct RangeSpec {
    first: Spec,
    last: u8,
}

impl FromStr for RangeSpec {
    type Err = String;

    fn from_str(spec: &str) -> Result<Self, String> {
        let (range, options) = spec.split_once(',').map_or((spec, ""), |(range, options)| (range, options));
        let drive = |text: &str| Spec::parse(Group::Drive, text).map_err(|wrong| wrong.words);
        let in_range =
            |words: String| words.replace(&Group::Drive.form("ADDRESS"), &Group::Drive.form("FIRST-LAST"));
        let (first, last) = range.split_once('-').ok_or_else(|| {
            format!("'{range}' is no range of addresses; expected {}", Group::Drive.form("FIRST-LAST"))
        })?;
        let last = drive(last).map_err(in_range)?.place;
        let first = match options {
            "" => drive(first),
            options => drive(&format!("{first},{options}")),
        };
        let first = first.map_err(in_range)?;
        if last < first.place {
            let form = Group::Drive.form("FIRST-LAST");
            return Err(format!("the range {range} is empty; expected {form}"));
        }
        Ok(Self { first, last })
    }
}

impl RangeSpec {
    pub(super) fn drives(&self) -> impl Iterator<Item = Spec> + '_ {
        (self.first.place..=self.last).map(|place| Spec { place, ..self.first.clone() })
    }
}

/// The names of the devices on CANopen that need no file.
pub(super) fn product_names() -> String {
    Product::all().map(|product| product.name).collect::<Vec<_>>().join(", ")
}

/// A device on CANopen by its name.
pub(crate) fn device(name: &str) -> Result<&'static Product, String> {
    Product::named(name).ok_or_else(|| {
        let names: Vec<_> = Product::all().map(|product| product.name).collect();
        let near = nearest(name, names.iter().copied());
        format!("device '{name}' is unknown; {near}expected {}", names.join(" or "))
    })
}

/// Name and value of a quirk.
pub(crate) fn quirk_parts(spec: &str) -> Result<(&str, &str), String> {
    spec.split_once('=').ok_or_else(|| "expected NAME=VALUE, for example off1=brake".into())
}

/// Why no device of those that are `there` has a quirk.
pub(crate) fn unknown_quirk(there: &[&'static Device], name: &str) -> String {
    let names = |device: &Device| device.quirks().iter().map(|row| row.name).collect::<Vec<_>>();
    if there.iter().any(|device| device.group() == Group::Node) {
        let known = |device: &&Device| match &*names(device) {
            [] => format!("{} has none", device.name()),
            names => format!("{} has {}", device.name(), names.join(", ")),
        };
        let known: Vec<_> = there.iter().map(known).collect();
        return format!("no node has a quirk '{name}'; {}", known.join("; "));
    }
    let known: Vec<_> = there.iter().flat_map(|device| names(device)).collect();
    let cure = match DEVICES.iter().find(|device| names(device).contains(&name)) {
        Some(device) => format!("it is one of a {} {}; ", device.group().name(), device.name()),
        None => nearest(name, known.iter().copied()),
    };
    format!("quirk '{name}' is unknown; {cure}expected one of {}", known.join(", "))
}

/// The devices with quirks, those with the same ones once.
fn with_quirks() -> Vec<(&'static Device, Vec<QuirkRow>)> {
    let mut all: Vec<(&'static Device, Vec<QuirkRow>)> = Vec::new();
    for device in DEVICES {
        let rows = device.quirks();
        if !rows.is_empty() && all.iter().all(|(_, known)| *known != rows) {
            all.push((device, rows));
        }
    }
    all
}

/// Every quirk with its values, the default first.
pub(super) fn quirks_help() -> String {
    let mut text = String::from(
        "How all devices behave where the manuals are not clear; repeat it for more.\nThe first value is the \
         default; docs/quirks.md has the reasons.\n",
    );
    for (device, rows) in with_quirks() {
        text += &format!("\nOf a {} {}:", device.group().name(), device.name());
        for QuirkRow { name, values, about } in rows {
            text += &format!("\n  {name}={}\n      {about}", values.join("|"));
        }
        text += "\n";
    }
    text
}

/// A value of which a shell can offer some.
#[derive(Clone)]
pub(crate) struct Offered<T> {
    pub(crate) read: fn(&str) -> Result<T, String>,
    pub(crate) offers: fn() -> Vec<String>,
}

impl<T: Clone + Send + Sync + 'static> TypedValueParser for Offered<T> {
    type Value = T;

    fn parse_ref(
        &self,
        command: &clap::Command,
        arg: Option<&clap::Arg>,
        value: &std::ffi::OsStr,
    ) -> Result<T, clap::Error> {
        self.read.parse_ref(command, arg, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new((self.offers)().into_iter().map(PossibleValue::new)))
    }
}

/// One of the devices on CANopen.
pub(crate) fn offered_device() -> Offered<&'static Product> {
    Offered { read: device, offers: || Product::all().map(|product| product.name.to_owned()).collect() }
}

/// Every quirk with every value.
pub(crate) fn offered_quirk() -> Offered<String> {
    let offers = || {
        let rows = with_quirks().into_iter().flat_map(|(_, rows)| rows);
        let mut all: Vec<_> = rows
            .flat_map(|row| row.values.iter().map(move |value| format!("{}={value}", row.name)))
            .collect();
        all.sort_unstable();
        all.dedup();
        all
    };
    Offered { read: |text| Ok(text.to_owned()), offers }
}

/// The rates of both buses.
pub(crate) fn offered_baud() -> Offered<super::BaudSpec> {
    let offers = || {
        let can = Product::all().flat_map(Product::rates);
        let can = can.filter(|bits| BitRate::from_bits_per_second(*bits).is_ok());
        let mut rates: Vec<u32> =
            BaudRate::ALL.iter().map(|rate| rate.bits_per_second()).chain(can).collect();
        rates.sort_unstable();
        rates.dedup();
        rates.iter().map(u32::to_string).chain(["auto".to_owned()]).collect()
    };
    Offered { read: str::parse, offers }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_is_its_bounds_and_what_its_drives_share() {
        let range: RangeSpec = "1-125,model=ag03,gear=24".parse().unwrap();
        let drives: Vec<_> = range.drives().collect();
        assert_eq!(drives.len(), 125);
        for (drive, place) in [(&drives[0], 1), (&drives[124], 125)] {
            let gear = drive.choices.word("gear");
            assert_eq!((drive.place, drive.device.name(), gear), (place, "ag03", Some("24")));
        }
        assert_eq!("7-7".parse::<RangeSpec>().unwrap().drives().count(), 1);
        for (spec, part) in [
            ("5", "'5' is no range of addresses; expected FIRST-LAST"),
            ("", "'' is no range"),
            ("5-", "'' is no address; expected FIRST-LAST"),
            ("-5", "'' is no address"),
            ("1-2-3", "'2-3' is no address"),
            ("6-5", "the range 6-5 is empty"),
            ("1-127", "address 127 is outside 0 to 126"),
            ("1-2,gear=36", "gear '36' is unknown"),
            ("1-2,color=red", "'color' is unknown; expected FIRST-LAST"),
        ] {
            let error = spec.parse::<RangeSpec>().unwrap_err();
            assert!(error.contains(part), "{spec}: {error}");
        }
    }

    #[test]
    fn every_quirk_is_in_the_help_and_is_offered() {
        let offers = (offered_quirk().offers)();
        for row in DEVICES.iter().flat_map(Device::quirks) {
            assert!(quirks_help().contains(&format!("\n  {}={}", row.name, row.values.join("|"))));
            for value in row.values {
                assert!(offers.contains(&format!("{}={value}", row.name)), "{}={value}", row.name);
            }
        }
    }
}
