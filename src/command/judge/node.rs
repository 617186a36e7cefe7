//! `judge --node`: a CANopen node under test.

use core::time::Duration;
use std::io::{self, Write};
use std::process::ExitCode;

use super::device::attendant;
use super::{captured_can, create_reports, finish, say, stop};
use crate::can_bus::can::BitRate;
use crate::command::Failure;
use crate::command::args::{self, CanPlace, JudgedNode, rows_of};
use crate::command::master;
use crate::host::can::{CanEndpoint, LineEnd, LinkSpec};
use crate::host::{Reach, Stop, SystemClock, eds_of_file};
use crate::judge::device::node::{Live, Setup, live};

/// So long after the ready line somebody must have opened the adapter.
const PATIENCE: Duration = Duration::from_secs(10);
/// Exit status without a device.
const NO_DEVICE: u8 = 3;

/// Judges a node, and says the verdicts.
pub(super) fn node(args: &args::Judge, judged: &JudgedNode) -> Result<ExitCode, Failure> {
    let eds = judged.eds.as_deref().map(eds_of_file).transpose().map_err(Failure::Usage)?;
    let eds = eds.map(|mut eds| {
        eds.complete();
        Box::new(eds)
    });
    let setup = Setup {
        eds,
        write: args.write,
        moves_allowed: args.moves_allowed,
        quick: args.quick,
        soak: args.soak_of_device(),
        limit: args.time.map(Duration::from_secs),
        ..Setup::new(judged.node)
    };
    create_reports(args)?;
    let stop = stop(args)?;
    let rate = args.baud.first().and_then(|baud| baud.can()).unwrap_or(BitRate::K500);
    let Some(endpoint) = open(args, judged, rate, &stop)? else { return Ok(ExitCode::from(NO_DEVICE)) };
    let clock = SystemClock::new();
    let endpoint = captured_can(args, endpoint, args.link.text(), rate, clock)?;
    let bus = Live { endpoint, clock: Box::new(clock), stop };
    let attendant = args.ask.as_deref().map(attendant);
    let report = live(setup, &rows_of(&args.only), bus, attendant, &mut say);
    finish(args, report, &format!("CANopen node {}", judged.node))
}

/// The bus of the node, behind an adapter or an interface, or one of this process with an adapter for the node; `None`:
/// nobody has opened that.
fn open(
    args: &args::Judge,
    judged: &JudgedNode,
    rate: BitRate,
    stop: &Stop,
) -> Result<Option<Box<dyn CanEndpoint>>, Failure> {
    let place = match args.link.of_node().map_err(Failure::Usage)? {
        spec @ LinkSpec::Pty(_) => {
            let failed = |error| Failure::from_error(&error);
            let mut line = LineEnd::open(&spec, rate, Reach::ThisMachine).map_err(failed)?;
            announce(line.name(), judged)?;
            if line.wait_for_somebody(PATIENCE, stop).map_err(failed)? {
                return Ok(Some(Box::new(line)));
            }
            let _ = writeln!(
                io::stderr(),
                "profidrive: nobody opened the adapter within {} s",
                PATIENCE.as_secs()
            );
            return Ok(None);
        }
        LinkSpec::Tcp(place) => CanPlace::Tcp(place),
        LinkSpec::Terminal(path) => CanPlace::Terminal(path),
        LinkSpec::Socket(name) => CanPlace::Socket(name),
    };
    let endpoint = master::open_can(&place, rate)?;
    announce(args.link.text(), judged)?;
    Ok(Some(endpoint))
}

fn announce(path: &str, judged: &JudgedNode) -> Result<(), Failure> {
    let mut stdout = io::stdout().lock();
    writeln!(stdout, "ready link={path} node={}", judged.node)
        .and_then(|()| stdout.flush())
        .map_err(|error| Failure::from_error(&error))
}
