//! Drives of the profile: their files read before anything starts, and their place on the bus.

use std::fs;
use std::path::Path;

use profidrive::devices::ppo_drive::profibus::{CONFIGURATIONS, IDENT_NUMBER, PpoDrive, PpoOnly};
use profidrive::devices::ppo_drive::table::{Row, Table};
use profidrive::devices::ppo_drive::{Drive, Settings};
use profidrive::gsd::{Policy, Station};
use profidrive::host::{Bus, HostedPpoDrive, PpoJudge, Refusals};
use profidrive::profibus::dp::{Description, Fixed};
use profidrive::profibus::fdl::Address;
use profidrive::profibus::ppo::PpoType;
use tracing::{info, warn};

use super::{Place, station};
use crate::command::Failure;
use crate::command::args::{PpoDriveSpec, StationSpec};

/// A drive whose files are right.
pub(crate) struct PpoDrivePlan {
    pub(crate) address: Address,
    pub(crate) slave: Slave,
    pub(crate) only: Option<PpoType>,
    pub(crate) table: Table,
}

/// What the drive is to its master: as the profile has it, with this ident number, or as a device file describes it.
pub(crate) enum Slave {
    Profile(u16),
    Gsd(Box<Station>),
}

/// The drives asked for. Nothing is started before all of their files are right.
pub(super) fn load(drives: &[PpoDriveSpec]) -> Result<Vec<PpoDrivePlan>, Failure> {
    let one = |spec: &PpoDriveSpec| {
        let table = spec.parameters.as_deref().map(parameters).transpose()?;
        let table = table.unwrap_or_else(Table::profile);
        Ok(PpoDrivePlan { address: spec.address, slave: slave(spec)?, only: spec.ppo, table })
    };
    drives.iter().map(one).collect()
}

/// What the drive is to its master.
pub(crate) fn slave(spec: &PpoDriveSpec) -> Result<Slave, Failure> {
    let Some(file) = &spec.gsd else { return Ok(Slave::Profile(spec.ident.unwrap_or(IDENT_NUMBER))) };
    let spec = StationSpec { address: spec.address, file: file.clone(), policy: Policy::PROPOSED };
    Ok(Slave::Gsd(Box::new(station::station(&spec)?)))
}

/// A table of parameters from its file.
pub(crate) fn parameters(file: &Path) -> Result<Table, Failure> {
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
    try_out(&table).map_err(|words| Failure::Usage(format!("{name}: {words}")))?;
    Ok(table)
}

/// Whether the drive takes what its parameters begin with.
pub(crate) fn try_out(table: &Table) -> Result<(), String> {
    table.set_up(&mut Drive::new(Settings::DEFAULT)).map_err(default_refused)
}

/// Puts a drive on the bus.
pub(super) fn connect(
    bus: &mut Bus,
    PpoDrivePlan { address, slave, only, table }: PpoDrivePlan,
    &Place { rate, now, listen, state }: &Place<'_>,
    refusals: &Refusals,
) -> Result<(), Failure> {
    let (description, inner) = match slave {
        Slave::Gsd(station) => (station.description(), PpoJudge::Gsd(station)),
        Slave::Profile(ident) => {
            let place_of = |kind: PpoType| CONFIGURATIONS.iter().position(|own| *own == kind.configuration());
            let configurations = match only.and_then(place_of) {
                Some(at) => CONFIGURATIONS.get(at..=at).unwrap_or(CONFIGURATIONS),
                None => CONFIGURATIONS,
            };
            let description = Description { ident, sync_mode: true, freeze_mode: true, ..Description::PLAIN };
            (description, PpoJudge::Profile(Fixed { configurations, ..Fixed::PLAIN }))
        }
    };
    let ppo = only.map_or_else(|| "PPO 1 to 5".into(), |kind| kind.to_string());
    info!("drive of PROFIDRIVE version 2, {ppo}, ident 0x{:04X}, at address {address}", description.ident);
    let drive = PpoDrive::new(address, rate, (description, PpoOnly { inner, only }), table, now)
        .map_err(|row| Failure::Usage(default_refused(&row)))?;
    let mut hosted = HostedPpoDrive::new(drive, refusals.clone());
    if let Some(state) = state {
        hosted = hosted.kept_in(state, now).map_err(|error| Failure::from_error(&error))?;
    }
    let in_force = hosted.drive().address();
    if in_force != address {
        warn!("drive {address}: Set_Slave_Add gave it address {in_force}, which is used");
    }
    let connected = if listen { bus.join(now, hosted) } else { bus.add(hosted) };
    connected.map_err(|error| Failure::from_error(&error))
}

fn default_refused(row: &Row) -> String {
    format!(
        "PNU {} {}: the drive does not take its default; times and loads are 0 or more, the reference speed is above 0",
        row.pnu, row.name
    )
}
