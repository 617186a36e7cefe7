//! Values of stations that other tables name.

use super::line::address;
use super::tables::At;
use super::wrong::Wrong;
use crate::command::emulate::SlavePlan;
use crate::gsd::Station;
use crate::host::list::inputs::{self, Direction};
use crate::host::list::{self, Group};
use crate::process::Point;
use crate::profibus::fdl::Address;

/// The stations of a line, in the order of their tables.
pub(super) struct Stations<'a>(Vec<(Address, Option<&'a Station>)>);

impl<'a> Stations<'a> {
    pub(super) fn of(plans: &'a [SlavePlan]) -> Self {
        let is_station = |plan: &&SlavePlan| plan.spec.device.group() == Group::Station;
        let stations = plans.iter().filter(is_station);
        Self(stations.map(|plan| (plan.address(), plan.prepared.station.as_ref())).collect())
    }

    pub(super) fn addresses(&self) -> impl Iterator<Item = Address> + '_ {
        self.0.iter().map(|(address, _)| *address)
    }

    pub(super) fn at(&self, address: Address) -> Option<&'a Station> {
        self.0.iter().find(|(known, _)| *known == address)?.1
    }
}

/// The address of a station of the line.
pub(super) fn known(number: &At<u8>, stations: impl Iterator<Item = Address>) -> Result<Address, Wrong> {
    let wanted = address(number)?;
    let there: Vec<Address> = stations.collect();
    if there.contains(&wanted) {
        return Ok(wanted);
    }
    let there: Vec<_> = there.iter().map(Address::to_string).collect();
    Err(Wrong::at(
        number.span(),
        format!("there is no station {wanted} on this line; expected one of {}", there.join(", ")),
    ))
}

/// A value in a slot.
pub(super) fn point(slot: &At<u16>, octet: Option<&At<u8>>, kind: &At<String>) -> Result<Point, Wrong> {
    let offset = octet.map_or(0, |octet| usize::from(*octet.get()));
    let kind = kind.get().parse().map_err(|error| Wrong::at(kind.span(), error))?;
    Ok(Point { slot: *slot.get(), offset, kind })
}

/// Whether the station has this input. Where the master chooses the modules, it may.
pub(super) fn check(station: &Station, point: Point, slot: &At<u16>, kind: &At<String>) -> Result<(), Wrong> {
    inputs::check(station, point, Direction::Input).map_err(|list::Wrong { path, words, .. }| {
        let of_slot = path.first().is_some_and(|key| key == "slot");
        Wrong::at(if of_slot { slot.span() } else { kind.span() }, words)
    })
}
