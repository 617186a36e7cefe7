//! `alarms`: alarms and status messages of a slave of DP-V1, as its master of class 1.

use core::time::Duration;
use std::path::Path;

use serde_json::{Value, json};

use super::say;
use crate::command::{Failure, gsd};
use crate::explain::hex;
use crate::gsd::{Gsd, Policy, Station};
use crate::host::{Clock, Link};
use crate::master::{OwnedSlave, Owner, RecordError, Reported, Session, SessionError};
use crate::profibus::dp::Application as _;
use crate::profibus::dp::chk_cfg::{Identifier, Units, identifiers};
use crate::profibus::dp::dpv1_status::Status1;
use crate::profibus::dpv1::TypedBlock;
use crate::profibus::fdl::Address;

/// How long an acknowledgement may take.
const PATIENCE: Duration = Duration::from_secs(10);

/// Between two cycles of data exchange.
const CYCLE: Duration = Duration::from_millis(10);

/// The slave of a device file with these modules, DP-V1 and each of its alarms enabled.
pub(super) fn slave(file: &Path, modules: &str) -> Result<OwnedSlave, Failure> {
    let usage = |words: String| Failure::Usage(format!("{}: {words}", file.display()));
    let gsd: Gsd = gsd::read(file)?;
    if !gsd.flags.dpv1 {
        return Err(usage("the slave has no DP-V1 (DPV1_Slave), so it has no alarms".into()));
    }
    let station = Station::new(gsd, Policy::PROPOSED).map_err(|error| usage(error.to_string()))?;
    let gsd = station.gsd();
    let places = gsd.modules_named(modules).map_err(|error| usage(error.to_string()))?;
    if gsd.is_modular() && places.is_empty() {
        let names: Vec<_> = gsd.modules.iter().map(|module| module.name.as_str()).collect();
        return Err(usage(format!(
            "which modules has the slave? Add --modules; the file has {}",
            names.join(", ")
        )));
    }
    let configuration = match places.as_slice() {
        [] => station.configuration(None).to_vec(),
        places => places
            .iter()
            .filter_map(|place| gsd.modules.get(*place))
            .flat_map(|module| module.identifiers.clone())
            .collect(),
    };
    let mut user_prm = gsd.default_user_prm(&places);
    let alarms = gsd.acyclic.alarms;
    for (octet, bits) in user_prm.iter_mut().zip([Status1::Enable.mask(), alarms]) {
        *octet |= bits;
    }
    let outputs = identifiers(&configuration)
        .filter_map(|octets| Identifier::read(octets).ok())
        .map(|(identifier, _)| identifier.outputs.map_or(0, Units::octets))
        .sum();
    Ok(OwnedSlave { ident: gsd.ident, user_prm, configuration, outputs: vec![0; outputs] })
}

/// Shows what comes until the time is over or somebody ends it; `keep`: without an acknowledgement.
pub(super) fn alarms<L: Link, C: Clock>(
    session: &mut Session<L, C>,
    address: Address,
    slave: OwnedSlave,
    (keep, limit): (bool, Option<Duration>),
    json: bool,
) -> Result<(), Failure> {
    let mut owner = Owner::take(session, address, slave, PATIENCE)?;
    let begun = owner.now();
    let ended = loop {
        if limit.is_some_and(|limit| owner.now().saturating_since(begun) >= limit) {
            break Ok(());
        }
        if let Err(error) = cycle(&mut owner, keep, json) {
            break Err(error);
        }
    };
    match ended {
        Ok(()) | Err(Ended::Stopped) => owner.release().map_err(Failure::from),
        Err(Ended::Failed(failure)) => {
            // What failed first is what is told.
            let _unlocked = owner.release();
            Err(failure)
        }
    }
}

/// Why no further cycle comes.
enum Ended {
    /// Somebody ended it.
    Stopped,
    Failed(Failure),
}

impl From<RecordError> for Ended {
    fn from(error: RecordError) -> Self {
        if matches!(error, RecordError::Session(SessionError::Stopped)) {
            Self::Stopped
        } else {
            Self::Failed(error.into())
        }
    }
}

/// One exchange, and what it brought.
fn cycle<L: Link, C: Clock>(owner: &mut Owner<'_, L, C>, keep: bool, json: bool) -> Result<(), Ended> {
    for reported in owner.exchange()? {
        let acknowledged = match &reported {
            Reported::Alarm { head, .. } if !keep => owner.acknowledge(*head).map(|()| true)?,
            Reported::Alarm { .. } | Reported::Status(_) => false,
        };
        show(&reported, acknowledged, json).map_err(Ended::Failed)?;
    }
    owner.pause(CYCLE).map_err(|error| RecordError::from(error).into())
}

fn show(reported: &Reported, acknowledged: bool, json: bool) -> Result<(), Failure> {
    match reported {
        Reported::Alarm { head, data } if json => say(json!({
            "type": head.kind.number(), "slot": head.slot, "sequence": head.sequence,
            "specifier": head.specifier.name(), "additional_ack": head.additional_ack, "data": hex(data),
            "acknowledged": acknowledged, "text": head.to_string(),
        })),
        Reported::Alarm { head, data } => {
            let data = if data.is_empty() { String::new() } else { format!(": {}", hex(data)) };
            say(format_args!(
                "{head}{data}{}",
                if acknowledged { "; acknowledged" } else { "; not acknowledged" }
            ))
        }
        Reported::Status(octets) => {
            let Some(TypedBlock::Status { kind, slot, specifier, data }) = TypedBlock::parse(octets) else {
                return Ok(());
            };
            if json {
                let message: Value = json!({ "status": kind.number(), "slot": slot, "specifier": specifier.name(), "data": hex(data) });
                return say(message);
            }
            say(format_args!("{kind} of slot {slot}: {}", hex(data)))
        }
    }
}
