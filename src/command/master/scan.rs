//! `scan`: who is on the line.

use profidrive::device::IDENT_NUMBER;
use profidrive::fdl::{Address, StationType};
use profidrive::host::{Clock, Link};
use profidrive::master::{Session, SessionError};
use serde_json::json;

use super::{say, watch};
use crate::command::Failure;
use crate::command::args::AddressRange;

/// A station that answers.
struct Station {
    address: Address,
    station: StationType,
    /// Ident number and owner, of a slave that has a diagnosis.
    slave: Option<(u16, Option<Address>)>,
}

/// Asks every address, then every slave found for its diagnosis.
pub(super) fn scan<L: Link, C: Clock>(
    session: &mut Session<L, C>,
    range: AddressRange,
    json: bool,
) -> Result<(), Failure> {
    let own = session.settings().master;
    let addresses: Vec<Address> = (range.first.number()..=range.last.number())
        .map(Address::from_octet)
        .filter(|address| *address != own)
        .collect();
    let progress = watch("scanning", addresses.len());
    let mut found = Vec::new();
    session.find(addresses, |address, station| {
        progress.inc(1);
        found.extend(station.map(|station| Station { address, station, slave: None }));
    })?;
    progress.finish_and_clear();
    for station in found.iter_mut().filter(|station| station.station == StationType::Slave) {
        station.slave = match session.diagnosis(station.address) {
            Ok((diagnosis, _)) => Some((diagnosis.ident, diagnosis.master)),
            // It was there a moment ago: what is no DP slave has no diagnosis.
            Err(SessionError::NoSlave { .. } | SessionError::NoAnswer { .. }) => None,
            Err(error) => return Err(error.into()),
        };
    }
    if json {
        let stations: Vec<_> = found.iter().map(Station::json).collect();
        return say(json!({ "stations": stations }));
    }
    if found.is_empty() {
        return Err(Failure::Other(format!(
            "no station answers from {} to {}; check the cable, the rate and that somebody is switched on",
            range.first, range.last
        )));
    }
    for station in found {
        say(format_args!("{:>3}  {}", station.address, station.text()))?;
    }
    Ok(())
}

impl Station {
    fn text(&self) -> String {
        let kind = match self.station {
            StationType::Slave => match self.slave {
                None => return "passive station, no DP slave".into(),
                Some((IDENT_NUMBER, _)) => "SIKO AG03 or AG03/1",
                Some(_) => "another slave",
            },
            StationType::MasterNotReady => return "master, not ready for the token ring".into(),
            StationType::MasterReady => return "master, not in the token ring".into(),
            StationType::MasterInRing => return "master in the token ring".into(),
        };
        let (ident, owner) = self.slave.unwrap_or_default();
        let owner = owner.map_or("no master".into(), |owner| format!("belongs to master {owner}"));
        format!("{kind} (ident number {ident:04X}), {owner}")
    }

    fn json(&self) -> serde_json::Value {
        let kind = match self.station {
            StationType::Slave => "slave",
            StationType::MasterNotReady | StationType::MasterReady | StationType::MasterInRing => "master",
        };
        json!({
            "address": self.address.number(),
            "type": kind,
            "ident": self.slave.map(|(ident, _)| ident),
            "drive": self.slave.is_some_and(|(ident, _)| ident == IDENT_NUMBER),
            "master": self.slave.and_then(|(_, owner)| owner).map(Address::number),
        })
    }
}
