//! Drives of the profile: their files read before anything starts, and their place on the bus.

use std::fs;
use std::path::Path;

use profidrive::device::ppo_drive::{CONFIGURATIONS, IDENT_NUMBER, PpoDrive, PpoOnly};
use profidrive::dp::{Description, Fixed};
use profidrive::fdl::Address;
use profidrive::gsd::{Policy, Station};
use profidrive::host::{Bus, HostedPpoDrive, Refusals};
use profidrive::ppo::PpoType;
use profidrive::ppo_drive::table::{Row, Table};
use profidrive::ppo_drive::{Drive, Settings};
use profidrive::time::{BaudRate, Instant};
use tracing::info;

use crate::command::Failure;
use crate::command::args::PpoDriveSpec;
use crate::command::gsd::read;

/// A drive whose files are right.
pub(super) struct Loaded {
    address: Address,
    description: Description,
    judge: Judge,
    only: Option<PpoType>,
    table: Table,
}

enum Judge {
    Profile,
    Gsd(Box<Station>),
}

/// The drives asked for. Nothing is started before all of their files are right.
pub(super) fn load(drives: &[PpoDriveSpec]) -> Result<Vec<Loaded>, Failure> {
    drives.iter().map(one).collect()
}

fn one(spec: &PpoDriveSpec) -> Result<Loaded, Failure> {
    let table = spec.parameters.as_deref().map(parameters).transpose()?.unwrap_or_else(Table::profile);
    let (description, judge) = match &spec.gsd {
        None => {
            let ident = spec.ident.unwrap_or(IDENT_NUMBER);
            (Description { ident, sync_mode: true, freeze_mode: true, ..Description::PLAIN }, Judge::Profile)
        }
        Some(file) => {
            let station = Station::new(read(file)?, Policy::PROPOSED)
                .map_err(|error| Failure::Usage(format!("{}: {error}", file.display())))?;
            (station.description(), Judge::Gsd(Box::new(station)))
        }
    };
    Ok(Loaded { address: spec.address, description, judge, only: spec.ppo, table })
}

fn parameters(file: &Path) -> Result<Table, Failure> {
    let name = file.display();
    let text =
        fs::read_to_string(file).map_err(|error| Failure::Usage(format!("cannot read {name}: {error}")))?;
    let extension = file.extension().and_then(|extension| extension.to_str()).map(str::to_lowercase);
    let table = match extension.as_deref() {
        Some("toml") => Table::from_toml(&text),
        Some("csv") => Table::from_csv(&text),
        Some(_) | None => {
            return Err(Failure::Usage(format!("{name}: the name of a table ends in .toml or .csv")));
        }
    };
    let table = table.map_err(|error| Failure::Usage(format!("{name}: {error}")))?;
    let tried = table.set_up(&mut Drive::new(Settings::DEFAULT));
    tried.map_err(|row| Failure::Usage(format!("{name}: {}", default_refused(row))))?;
    Ok(table)
}

/// Puts a drive on the bus.
pub(super) fn connect(
    bus: &mut Bus,
    loaded: Loaded,
    rate: BaudRate,
    now: Instant,
    listen: bool,
    refusals: &Refusals,
) -> Result<(), Failure> {
    let Loaded { address, description, judge, only, table } = loaded;
    let ppo = only.map_or_else(|| "PPO 1 to 5".into(), |kind| kind.to_string());
    info!("drive of PROFIDRIVE version 2, {ppo}, ident 0x{:04X}, at address {address}", description.ident);
    let place = (address, rate, now);
    let connected = match judge {
        Judge::Gsd(station) => {
            let hosted = hosted(place, description, PpoOnly { inner: *station, only }, table, refusals)?;
            if listen { bus.join(now, hosted) } else { bus.add(hosted) }
        }
        Judge::Profile => {
            let place_of = |kind: PpoType| CONFIGURATIONS.iter().position(|own| *own == kind.configuration());
            let configurations = match only.and_then(place_of) {
                Some(at) => CONFIGURATIONS.get(at..=at).unwrap_or(CONFIGURATIONS),
                None => CONFIGURATIONS,
            };
            let inner = Fixed { configurations, ..Fixed::PLAIN };
            let hosted = hosted(place, description, PpoOnly { inner, only }, table, refusals)?;
            if listen { bus.join(now, hosted) } else { bus.add(hosted) }
        }
    };
    connected.map_err(|error| Failure::from_error(&error))
}

fn hosted<A: profidrive::dp::Application>(
    (address, rate, now): (Address, BaudRate, Instant),
    description: Description,
    application: A,
    table: Table,
    refusals: &Refusals,
) -> Result<HostedPpoDrive<A>, Failure> {
    let drive = PpoDrive::new(address, rate, (description, application), table, now)
        .map_err(|row| Failure::Usage(default_refused(&row)))?;
    Ok(HostedPpoDrive::new(drive, refusals.clone()))
}

fn default_refused(row: &Row) -> String {
    format!(
        "PNU {} {}: the drive does not take its default; times and loads are 0 or more, the reference speed is above 0",
        row.pnu, row.name
    )
}
