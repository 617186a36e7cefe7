//! The stations of a line file, as a master has them configured.

use core::time::Duration;
use std::path::Path;

use super::describe;
use crate::command::emulate::SlavePlan;
use crate::command::{Failure, line_file};
use crate::host::list::{Ground, Prepared};
use crate::host::{Refusals, ValueBoard};
use crate::judge::Slave;
use crate::profibus::dp;
use crate::profibus::fdl::telegram::{Decoded, decode};
use crate::profibus::fdl::{
    Address, DataTelegram, FrameCount, FunctionCode, MAX_TELEGRAM_LEN, Service, Telegram,
};
use crate::time::{BaudRate, Instant};

/// The address from which a device is asked for its configuration, before the judgement.
const ASKING: Address = Address::from_octet(0);
/// A device has started after so long.
const STARTED: Duration = Duration::from_secs(10);
/// A device answers before so many of its deadlines have passed.
const DEADLINES: u32 = 100;

/// The stations of the file's line.
pub(super) fn stations(file: &Path) -> Result<Vec<Slave>, Failure> {
    let usage = |words: &str| Failure::Usage(format!("{}: {words}", file.display()));
    let mut lines = line_file::read(file)?.lines.into_iter().filter(|line| !line.slaves.is_empty());
    match (lines.next(), lines.next()) {
        (None, _) => Err(usage("no line has stations on PROFIBUS")),
        (Some(_), Some(_)) => {
            Err(usage("two lines have stations, and the judge plays one line; give a file of one"))
        }
        (Some(line), None) => {
            line.slaves.into_iter().map(|plan| slave(plan).map_err(|words| usage(&words))).collect()
        }
    }
}

fn slave(plan: SlavePlan) -> Result<Slave, String> {
    let mut slave = Slave::new(plan.address(), 0, Vec::new());
    match &plan.prepared.station {
        Some(station) => {
            slave.cfg = None;
            describe(&mut slave, station);
        }
        None => {
            let address = slave.address;
            let asked = ask(plan.prepared, address)?;
            let silent =
                || format!("station {address} says no ident number and configuration; give it by --station");
            (slave.ident, slave.cfg) = asked.map(|(ident, cfg)| (ident, Some(cfg))).ok_or_else(silent)?;
        }
    }
    Ok(slave)
}

/// The ident number of a device, and the configuration that Get_Cfg reports.
fn ask(prepared: Prepared, address: Address) -> Result<Option<(u16, Vec<u8>)>, String> {
    let (refusals, board) = (Refusals::default(), ValueBoard::default());
    let mut now = Instant::ZERO;
    let ground = Ground { now, rate: BaudRate::K500, state: None, refusals: &refusals, board: &board };
    let mut device = prepared.make(&ground).map_err(|error| error.to_string())?;
    let fc = FunctionCode::request(Service::SrdHigh, FrameCount::First);
    let (dsap, ssap) = (dp::Service::GetCfg.sap(), dp::MASTER_SAP);
    let format = DataTelegram::customary_format(dsap, ssap, &[]);
    let request = DataTelegram { format, da: address, sa: ASKING, dsap, ssap, fc, data: &[] };
    device.set_baud(ground.rate);
    now = now + STARTED;
    device.handle_timeout(now, &mut |_| {});
    device.handle_telegram(now, &Telegram::Data(request), &mut |_| {});
    let mut buf = [0; MAX_TELEGRAM_LEN];
    for _ in 0..DEADLINES {
        if let Some(len) = device.poll_transmit(now, &mut buf, &mut |_| {}) {
            let ident = device.appearance().ident;
            return Ok(ident.zip(buf.get(..len).and_then(configuration)));
        }
        let Some(due) = device.poll_timeout() else { break };
        now = now.max(due);
        device.handle_timeout(now, &mut |_| {});
    }
    Ok(None)
}

/// The data of a reply.
fn configuration(octets: &[u8]) -> Option<Vec<u8>> {
    match decode(octets) {
        Decoded::Telegram { telegram: Telegram::Data(reply), .. } if !reply.data.is_empty() => {
            Some(reply.data.to_vec())
        }
        Decoded::Telegram { .. } | Decoded::Incomplete | Decoded::Invalid { .. } => None,
    }
}
