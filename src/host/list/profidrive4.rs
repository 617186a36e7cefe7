//! How a drive of PROFIdrive 3 and 4 is made from its specification.

use std::path::Path;

use super::named::{self, Named};
use super::{Prepared, Spec, Wrong, slaves};
use crate::devices::ppo_drive::table::Row;
use crate::devices::profidrive4::profibus::{
    Family, IDENT_NUMBER, ProfidriveDevice, Settable, Telegram, TelegramOnly,
};
use crate::gsd::{Gsd, Policy, Station};
use crate::host::HostedProfidrive;
use crate::profibus::dp::Description;
use crate::profibus::dpv1::{Identification, Text};

/// The device file of a drive that is nobody's in particular.
const GSD: &[u8] = include_bytes!("../../../gsd/PDRV5034.GSD");

/// The least Send_Timeout of a connection, times 10 ms.
const MIN_SEND_TIMEOUT: u16 = 10;

/// The profile of drives, in I&M0.
const PROFILE: u16 = 0x3A00;

/// A drive of PROFIdrive 3 and 4.
pub(super) fn prepare(spec: &Spec) -> Result<Prepared, Wrong> {
    let choices = &spec.choices;
    let only = choices.word("telegram").and_then(|word| Telegram::numbered(word.parse().ok()?));
    let (station, ident) = match (choices.file("gsd"), choices.hexadecimal("ident")) {
        (Some(_), Some(_)) => {
            return Err(Wrong::at("ident", "the ident number is that of the GSD; leave ident out"));
        }
        (Some(file), None) => {
            let station = slaves::station(file, Policy::PROPOSED).map_err(|words| Wrong::at("gsd", words))?;
            check(&station, file, only)?;
            let ident = station.gsd().ident;
            (station, ident)
        }
        (None, ident) => (own()?, ident.unwrap_or(IDENT_NUMBER)),
    };
    let description = Description { ident, ..station.description() };
    let station = plug(station, only);
    let family = family(spec)?;
    let address = spec.address();
    let which = only.map_or_else(|| "any telegram".to_owned(), |only| format!("telegram {}", only.number));
    let about = format!("drive of PROFIdrive 4, {which}, ident 0x{ident:04X}, at address {address}");
    Ok(Prepared::new(about, move |ground, _| {
        let gsd = station.gsd();
        let offer = gsd.acyclic.offer(MIN_SEND_TIMEOUT);
        let order = if gsd.order_number.is_empty() { &gsd.model } else { &gsd.order_number };
        let identification =
            Identification { order_id: Text::of(order), profile_id: PROFILE, ..Identification::PLAIN };
        let what = (description, TelegramOnly { inner: station, only });
        let drive =
            ProfidriveDevice::new(address, ground.rate, what, (offer, identification), family, ground.now);
        let hosted = HostedProfidrive::new(drive, ground.refusals.clone());
        Ok(hosted.kept_in(ground.state, ground.now)?)
    }))
}

/// The station of our own device file.
fn own() -> Result<Station, Wrong> {
    let gsd = Gsd::read(GSD).map_err(|error| Wrong::at("gsd", error))?;
    Station::new(gsd, Policy::PROPOSED).map_err(|error| Wrong::at("gsd", error))
}

/// With the one telegram plugged in Get_Cfg reports it, if it is one module.
fn plug(station: Station, only: Option<&'static Telegram>) -> Station {
    let is_it = |identifiers: &[u8]| Telegram::of_configuration(identifiers, only).is_some();
    let place = station.gsd().modules.iter().position(|module| is_it(&module.identifiers));
    match (only, place) {
        (Some(_), Some(place)) => station.clone().plugged(&[place]).unwrap_or(station),
        (_, _) => station,
    }
}

/// Refuses a device file that has no telegram, or not the one that is wanted, or no services of DP-V1.
fn check(station: &Station, file: &Path, only: Option<&'static Telegram>) -> Result<(), Wrong> {
    let (gsd, name) = (station.gsd(), file.display());
    if !(gsd.flags.dpv1 && (gsd.acyclic.c1 || gsd.acyclic.c2)) {
        let words = format!(
            "{name} has no services of DP-V1 (DPV1_Slave with C1_Read_Write_supp or C2_Read_Write_supp), by which such a drive \
             is parameterised; use --ppo-drive for it"
        );
        return Err(Wrong::at("gsd", words));
    }
    let has = |only| {
        gsd.modules.iter().any(|module| Telegram::of_configuration(&module.identifiers, only).is_some())
    };
    match only {
        _ if has(only) => Ok(()),
        Some(only) if has(None) => {
            let words = format!("{name} has no module of telegram {}; leave telegram out", only.number);
            Err(Wrong::at("telegram", words))
        }
        _ => Err(Wrong::at("gsd", format!("{name} has no module that is a telegram; use --station for it"))),
    }
}

/// The parameters of every drive and of the file, with what they begin with.
fn family(spec: &Spec) -> Result<Family, Wrong> {
    let choices = &spec.choices;
    let rows = match choices.file("parameters") {
        Some(file) => of_file(file).map_err(|words| Wrong::at("parameters", words))?,
        None => Vec::new(),
    };
    let mut family = Family::new(&rows).map_err(|words| Wrong::at("parameters", words))?;
    let settable = family.settable();
    for (name, number) in &choices.values {
        let wrong = |words: String| Wrong::within("values", name, words);
        let (parameter, element) = named::find(settable.iter(), name).map_err(wrong)?;
        let begun = family.begin_with(parameter.number, element.unwrap_or(0), *number);
        begun.map_err(|words| wrong(format!("'{name}': {words}")))?;
    }
    Ok(family)
}

impl Named for Settable {
    fn number(&self) -> u16 {
        self.number
    }

    fn name(&self) -> &str {
        &self.name
    }

    fn elements(&self) -> Option<(u8, u8)> {
        self.elements.map(|count| (0, count))
    }
}

#[cfg(feature = "parameters")]
fn of_file(file: &Path) -> Result<Vec<Row>, String> {
    slaves::of_file(file, Row::all_of_toml, Row::all_of_csv)
}

#[cfg(not(feature = "parameters"))]
fn of_file(file: &Path) -> Result<Vec<Row>, String> {
    Err(slaves::no_tables(file))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profibus::dp::Application as _;

    #[test]
    fn the_device_file_has_a_module_for_each_telegram() {
        let station = own().map_err(|wrong| wrong.words).unwrap();
        assert_eq!(station.gsd().ident, IDENT_NUMBER);
        assert!(station.gsd().hints.is_empty(), "{:?}", station.gsd().hints);
        for telegram in Telegram::ALL {
            let module = station
                .gsd()
                .modules
                .iter()
                .find(|module| Telegram::of_configuration(&module.identifiers, Some(telegram)).is_some());
            let module = module.unwrap_or_else(|| panic!("telegram {}", telegram.number));
            assert!(module.name.ends_with(&format!("elegram {}", telegram.number)), "{}", module.name);
            assert!(station.judge_cfg(&module.identifiers, &[0x80, 0, 0]).is_ok(), "{}", module.name);
        }
    }
}
