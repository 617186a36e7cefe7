//! `scan`: who is on the line.

use crate::host::list::known_ident;
use crate::host::{Clock, Link};
use crate::master::{Session, SessionError};
use crate::profibus::fdl::{Address, StationType};
use indicatif::ProgressBar;
use serde_json::json;

use super::{say, watch};
use crate::command::Failure;
use crate::command::args::AddressRange;

/// A station that answers.
struct Station {
    address: Address,
    station: StationType,
    slave: Slave,
}

/// What the diagnosis of a station says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Slave {
    /// It was not asked: a master, or the scan ended before.
    Unasked,
    /// It has none.
    Other,
    Dp {
        ident: u16,
        owner: Option<Address>,
    },
}

/// So many addresses are asked before the slaves among them are asked for their diagnosis.
const AT_ONCE: usize = 8;

/// Asks every address, and every slave found for its diagnosis. Each is told when it is found: who has found the one he
/// looks for may end it.
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
    let mut asked = None;
    let mut outcome = Ok(());
    for part in addresses.chunks(AT_ONCE) {
        let before = found.len();
        outcome = ask(session, part, &progress, &mut found, &mut asked);
        let told = found.get(before..).unwrap_or_default();
        if !json {
            progress.suspend(|| told.iter().try_for_each(Station::say))?;
        }
        if outcome.is_err() {
            break;
        }
    }
    progress.finish_and_clear();
    if json {
        let stations: Vec<_> = found.iter().map(Station::json).collect();
        say(json!({ "stations": stations }))?;
    }
    match (outcome, asked) {
        (Err(error), Some(last)) => Err(Failure::Other(format!("{error}; asked up to address {last}"))),
        (Err(error), None) => Err(error.into()),
        (Ok(()), _) if found.is_empty() && !json => Err(Failure::Other(format!(
            "no station answers from {} to {}; check the cable, the rate and that a station is switched on",
            range.first, range.last
        ))),
        (Ok(()), _) => Ok(()),
    }
}

/// Adds who is at these addresses. After an error those are there that were found before.
fn ask<L: Link, C: Clock>(
    session: &mut Session<L, C>,
    addresses: &[Address],
    progress: &ProgressBar,
    found: &mut Vec<Station>,
    asked: &mut Option<Address>,
) -> Result<(), SessionError> {
    let before = found.len();
    session.find(addresses.iter().copied(), |address, station| {
        progress.inc(1);
        *asked = Some(address);
        found.extend(station.map(|station| Station { address, station, slave: Slave::Unasked }));
    })?;
    let slaves = found.iter_mut().skip(before).filter(|station| station.station == StationType::Slave);
    for station in slaves {
        station.slave = match session.diagnosis(station.address) {
            Ok((diagnosis, _)) => Slave::Dp { ident: diagnosis.ident, owner: diagnosis.master },
            // It was there a moment ago: what is no DP slave has no diagnosis.
            Err(SessionError::NoSlave { .. } | SessionError::NoAnswer { .. }) => Slave::Other,
            Err(error) => return Err(error),
        };
    }
    Ok(())
}

impl Station {
    fn say(&self) -> Result<(), Failure> {
        say(format_args!("{:>3}  {}", self.address, self.text()))
    }

    fn text(&self) -> String {
        match (self.station, self.slave) {
            (StationType::Slave, Slave::Unasked) => "passive station".into(),
            (StationType::Slave, Slave::Other) => "passive station, no DP slave".into(),
            (StationType::Slave, Slave::Dp { ident, owner }) => {
                let kind = known_ident(ident).unwrap_or("another slave");
                let owner = owner.map_or("no master".into(), |owner| format!("belongs to master {owner}"));
                format!("{kind} (ident number {ident:04X}), {owner}")
            }
            (StationType::MasterNotReady, _) => "master, not ready for the token ring".into(),
            (StationType::MasterReady, _) => "master, not in the token ring".into(),
            (StationType::MasterInRing, _) => "master in the token ring".into(),
        }
    }

    fn json(&self) -> serde_json::Value {
        let kind = match self.station {
            StationType::Slave => "slave",
            StationType::MasterNotReady | StationType::MasterReady | StationType::MasterInRing => "master",
        };
        let (ident, owner) = match self.slave {
            Slave::Unasked | Slave::Other => (None, None),
            Slave::Dp { ident, owner } => (Some(ident), owner),
        };
        json!({
            "address": self.address.number(),
            "type": kind,
            "ident": ident,
            "drive": ident.and_then(known_ident).is_some(),
            "master": owner.map(Address::number),
        })
    }
}
