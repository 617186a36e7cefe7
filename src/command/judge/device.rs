//! `judge --slave`: a device under test.

use core::time::Duration;
use std::io::{self, Write};
use std::process::ExitCode;

use super::{captured, create_reports, finish, say, stop};
use crate::command::args::{self, DeviceLink, JudgedSlave, LinkSpec, rows_of};
use crate::command::emulate::{Opened, open_link};
use crate::command::{Failure, gsd};
use crate::gsd::Gsd;
use crate::host::link::serial::Serial;
use crate::host::link::tcp::Connection;
#[cfg(unix)]
use crate::host::link::terminal::Terminal;
use crate::host::list::records_of_file;
use crate::host::{Link, SystemClock};
use crate::judge::device::Attendant;
use crate::judge::device::slave::{Live, Setup, Sight, live};
use crate::time::BaudRate;
use tracing::info;

/// The rate where there is none.
const UNTIMED_RATE: BaudRate = BaudRate::K500;

/// Judges a slave, and says the verdicts.
pub(super) fn slave(args: &args::Judge, slave: &JudgedSlave) -> Result<ExitCode, Failure> {
    let setup = setup(args, slave)?;
    create_reports(args)?;
    let stop = stop(args)?;
    let clock = SystemClock::new();
    let of_file = setup.gsd.as_ref().map(|gsd| gsd.rates.iter().collect()).unwrap_or_default();
    let (rate, rates) = args.rates_of_slave(of_file);
    let setup = Setup { rates, ..setup };
    let (link, path, sight) = open(args, rate)?;
    let link = captured(args, link, &path, clock)?;
    announce(&path, slave)?;
    let line = Live { link, clock: Box::new(clock), sight, rate: rate.unwrap_or(UNTIMED_RATE), stop };
    let attendant = args.ask.as_deref().map(attendant);
    let report = live(setup, &rows_of(&args.only), line, attendant, &mut say);
    finish(args, report, &format!("DP slave {}", slave.address))
}

/// Who does things at the device: the command of the user.
pub(super) fn attendant(command: &str) -> Box<dyn Attendant> {
    let command = command.to_string();
    Box::new(move |action: &str| {
        info!("asking: {command} {action}");
        super::operated::output(&command, action)
    })
}

/// The line to the device, what is at its other end, and how far its times can be trusted.
fn open(args: &args::Judge, rate: Option<BaudRate>) -> Result<(Box<dyn Link>, String, Sight), Failure> {
    let failed = |error| Failure::from_error(&error);
    let listening = |spec: LinkSpec| {
        let rate = Some(rate.unwrap_or(UNTIMED_RATE));
        open_link(&spec, rate, args.allow_remote)
            .map(|Opened { link, path, .. }| (link, path, Sight::Untimed))
    };
    match args.link.of_device().map_err(Failure::Usage)? {
        DeviceLink::Pty(path) => listening(LinkSpec::Pty(path)),
        DeviceLink::TcpListen(place) => listening(LinkSpec::Tcp(place)),
        DeviceLink::Tcp(place) => {
            let link = Connection::open(&place).map_err(failed)?;
            Ok((Box::new(link), format!("tcp:{place}"), Sight::Untimed))
        }
        DeviceLink::Serial(device) => {
            let Some(rate) = rate else {
                return Err(Failure::Usage("a serial line needs its rate: --baud RATE".into()));
            };
            let link = Serial::open(&device, rate).map_err(failed)?;
            Ok((Box::new(link), device, Sight::Measured))
        }
        #[cfg(unix)]
        DeviceLink::Terminal(path) => {
            let link = Terminal::open(&path, rate.unwrap_or(UNTIMED_RATE)).map_err(failed)?;
            Ok((Box::new(link), path.display().to_string(), Sight::Untimed))
        }
        #[cfg(not(unix))]
        DeviceLink::Terminal(path) => Err(Failure::Usage(format!(
            "{} is no link on Windows; name a port as serial:COM3, or use tcp:HOST:PORT",
            path.display()
        ))),
    }
}

fn announce(path: &str, slave: &JudgedSlave) -> Result<(), Failure> {
    let mut stdout = io::stdout().lock();
    writeln!(stdout, "ready link={path} slave={}", slave.address)
        .and_then(|()| stdout.flush())
        .map_err(|error| Failure::from_error(&error))
}

fn setup(args: &args::Judge, slave: &JudgedSlave) -> Result<Setup, Failure> {
    let gsd = slave.gsd.as_deref().map(gsd::read).transpose()?;
    let modules = match &gsd {
        Some(gsd) => modules(gsd, &slave.modules).map_err(Failure::Usage)?,
        None => Vec::new(),
    };
    let plain = Setup::new(slave.address);
    let cfg = match (&slave.cfg, &gsd) {
        (Some(cfg), _) => Some(cfg.clone()),
        (None, Some(gsd)) if !modules.is_empty() => Some(identifiers(gsd, &modules)),
        (None, _) => None,
    };
    let owner = args.master.unwrap_or(plain.owner);
    if owner == slave.address {
        return Err(Failure::Usage(format!("--master {owner} is the address of the slave")));
    }
    Ok(Setup {
        ident: slave.ident,
        cfg,
        prm: slave.prm.clone(),
        gsd: gsd.map(Box::new),
        modules,
        profile: slave.profile,
        profidrive: slave.profidrive,
        records: slave
            .records
            .as_deref()
            .map(records_of_file)
            .transpose()
            .map_err(Failure::Usage)?
            .map(Box::new),
        mirror: slave.mirror,
        owner,
        slot: args.slot.map(Duration::from_millis),
        moves_allowed: args.moves_allowed,
        writes_allowed: args.write,
        soak: args.soak_of_device(),
        quick: args.quick,
        limit: args.time.map(Duration::from_secs),
        ..plain
    })
}

/// The modules of these names, slot by slot.
fn modules(gsd: &Gsd, names: &[String]) -> Result<Vec<usize>, String> {
    let mut places = Vec::new();
    for name in names {
        places.extend(gsd.modules_named(name).map_err(|error| error.to_string())?);
    }
    Ok(places)
}

/// Chk_Cfg of these modules.
fn identifiers(gsd: &Gsd, modules: &[usize]) -> Vec<u8> {
    let of = |place: &usize| gsd.modules.get(*place).map(|module| module.identifiers.clone());
    modules.iter().filter_map(of).flatten().collect()
}
