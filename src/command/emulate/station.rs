//! Stations from device files: read before anything starts, and what they tell in the log.

use profidrive::gsd::{Level, Station};
use profidrive::host::{Bus, GsdStation, OutputBoard, Participant, Refusals};
use profidrive::profibus::fdl::Address;
use tracing::{info, warn};

use super::{Place, StationPlan, Watched};
use crate::command::Failure;
use crate::command::args::StationSpec;
use crate::command::gsd::read;

/// The stations asked for. Nothing is started before all of their files are right.
pub(super) fn load(stations: &[StationSpec]) -> Result<Vec<StationPlan>, Failure> {
    let one = |spec: &StationSpec| {
        let station = station(spec)?;
        Ok(StationPlan { address: spec.address, station, signals: Vec::new() })
    };
    stations.iter().map(one).collect()
}

/// The station of a file.
pub(crate) fn station(spec: &StationSpec) -> Result<Station, Failure> {
    let gsd = read(&spec.file)?;
    let file = spec.file.display();
    for hint in gsd.hints.iter().filter(|hint| hint.level == Level::Warning) {
        warn!("{file}: {hint}");
    }
    Station::new(gsd, spec.policy).map_err(|error| Failure::Usage(format!("{file}: {error}")))
}

/// Puts a station on the bus.
pub(super) fn connect(
    bus: &mut Bus,
    StationPlan { address, station, signals }: StationPlan,
    &Place { rate, now, listen, state }: &Place<'_>,
    (refusals, board): (&Refusals, &OutputBoard),
    watched: &[Watched],
) -> Result<Address, Failure> {
    let gsd = station.gsd();
    info!("{} {}, ident 0x{:04X}, from its GSD at address {address}", gsd.vendor, gsd.model, gsd.ident);
    if !gsd.rates.contains(rate) {
        warn!("station {address} hears nothing at {rate}: its GSD does not offer it");
    }
    if gsd.flags.needs_dpv1_services {
        warn!("station {address}: its GSD requires services of DPV1, which are not emulated");
    }
    let mut station = GsdStation::new(address, rate, station, refusals.clone()).on_board(board.clone());
    if let Some(state) = state {
        station = station.kept_in(state, now).map_err(|error| Failure::from_error(&error))?;
    }
    let in_force = Participant::address(&station);
    if in_force != address {
        warn!("station {address}: Set_Slave_Add gave it address {in_force}, which is used");
    }
    for signal in signals {
        station.connect(signal);
    }
    for (_, point, condition, switch) in watched.iter().filter(|watched| watched.0 == address) {
        station.watch(*point, *condition, switch.clone());
    }
    let connected = if listen { bus.join(now, station) } else { bus.add(station) };
    connected.map_err(|error| Failure::from_error(&error))?;
    Ok(in_force)
}

/// `drives=5 stations=7,9` of the ready line; either part is absent if there are none.
pub(super) fn ready(addresses: &[Address], stations: &[Address]) -> String {
    let (stations, drives): (Vec<_>, Vec<_>) =
        addresses.iter().partition(|address| stations.contains(address));
    let named = |name: &str, addresses: Vec<&Address>| {
        let addresses: Vec<_> = addresses.into_iter().map(Address::to_string).collect();
        (!addresses.is_empty()).then(|| format!("{name}={}", addresses.join(",")))
    };
    let parts: Vec<_> =
        [named("drives", drives), named("stations", stations)].into_iter().flatten().collect();
    parts.join(" ")
}
