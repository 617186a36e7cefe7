//! `diag`: the diagnosis of the slave in words.

use crate::explain::{Context, Field, hex};
use crate::host::{Clock, Link};
use crate::master::Session;
use crate::profibus::dp::{MASTER_SAP, Service};
use crate::profibus::fdl::{Address, DataTelegram, FunctionCode, MAX_TELEGRAM_LEN, ReplyStatus};
use serde_json::json;

use super::say;
use crate::command::Failure;

/// Asks for it and shows every bit that is set, and the octets.
pub(super) fn diag<L: Link, C: Clock>(
    session: &mut Session<L, C>,
    address: Address,
    json: bool,
) -> Result<(), Failure> {
    let (diagnosis, octets) = session.diagnosis(address)?;
    // As it was on the line, so that it is explained like every other telegram.
    let master = session.settings().master;
    let mut buf = [0; MAX_TELEGRAM_LEN];
    let (dsap, ssap) = (MASTER_SAP, Service::SlaveDiag.sap());
    let telegram = DataTelegram {
        format: DataTelegram::customary_format(dsap, ssap, &octets),
        da: master,
        sa: address,
        dsap,
        ssap,
        fc: FunctionCode::response(ReplyStatus::DataLow),
        data: &octets,
    };
    let telegram = telegram.encode(&mut buf).map_err(|error| Failure::from_error(&error))?;
    let explained = Context::default().telegram(telegram);
    if json {
        let master = diagnosis.master.map(Address::number);
        return say(json!({
            "address": address.number(),
            "octets": hex(&octets),
            "summary": explained.summary,
            "ident": diagnosis.ident,
            "master": master,
            "ready": !diagnosis.station_not_ready,
            "configuration_fault": diagnosis.cfg_fault,
            "parameter_fault": diagnosis.prm_fault,
            "parameters_required": diagnosis.prm_req,
            "watchdog": diagnosis.wd_on,
        }));
    }
    say(format_args!("{address}  {}", explained.summary))?;
    say(format_args!("    octets: {}", hex(&octets)))?;
    let mut lines = Vec::new();
    // FCS and ED follow.
    let first = telegram.len().saturating_sub(octets.len() + 2);
    explained.walk(&mut |_, field| lines.extend(line(field, first)));
    lines.iter().try_for_each(say)
}

/// What a bit that is set says, and where it is; `first` is the first octet of the diagnosis in the telegram.
fn line(field: &Field, first: usize) -> Option<String> {
    let bits = field.bits.filter(|_| field.raw == "1" && !field.meaning.is_empty())?;
    let octet = field.at.saturating_sub(first) + 1;
    Some(format!("    octet {octet} {bits}  {}: {}", field.name, field.meaning))
}
