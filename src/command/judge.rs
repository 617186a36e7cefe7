//! `profidrive judge`: a master under test, live or recorded; a device under test.

use core::time::Duration;
use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;

use crate::can_bus::can::BitRate;
use crate::gsd::{MasterGsd, Policy, Station};
use crate::host::can::{CanEndpoint, CanTap};
use crate::host::capture::can::CanInterface;
use crate::host::capture::{Capture, Interface};
use crate::host::link::tap::{Batch, Tap};
use crate::host::{Link, Received, Stop, SystemClock};
use crate::judge::{
    Ending, Judge, MasterClass, Operator, Outcome, Progress, Report, ReportOf, Requirement, Row, Scenario,
    Setup, Slave, live, rows_at_each,
};
use crate::profibus::dp::Application as _;
use crate::time::BaudRate;
use tracing::{info, warn};

use super::args::{self, JudgedStation, judge_millis};
use super::emulate::{Opened, open_link};
use super::{Failure, signals};

mod compare;
mod date;
mod device;
mod line;
mod node;
mod operated;
mod recorded;
mod scenarios;

use operated::Operated;

/// So many readings at most of what is forgotten.
const MOST_FORGOTTEN: u32 = 64;

/// Judges, and says the verdicts.
pub(crate) fn judge(args: &args::Judge) -> Result<ExitCode, Failure> {
    if let Some(args::Compare::Compare { before, after }) = &args.compare {
        return compare::compare(before, after);
    }
    if let Some(slave) = &args.slave {
        return device::slave(args, slave);
    }
    if let Some(judged) = &args.node {
        return node::node(args, judged);
    }
    let setup = setup(args)?;
    let rows = args::rows_of(&args.only);
    create_reports(args)?;
    if let Some(file) = &args.capture_file {
        let report = recorded::judge(file, setup, &rows)?;
        return finish(args, report, &subject(args));
    }
    let stop = stop(args)?;
    let more = scenarios::read(&args.scenarios, &setup)?;
    for scenario in &more {
        if !scenario.is_for(&rows) {
            warn!("scenario '{}' is not played: --only names none of its rows", scenario.name);
        }
    }
    if let Some(rates) = args.rates() {
        let report = at_rates(args, &rates, &setup, &rows, &more, &stop)?;
        return finish(args, report, &subject(args));
    }
    let place = args.link.of_master().map_err(Failure::Usage)?;
    let Opened { rate, link, path } = open_link(&place, args.rate(), args.allow_remote)?;
    let clock = SystemClock::new();
    let link = captured(args, link, &path, clock)?;
    announce(&path, &setup)?;
    let mut operator = args.ask.as_deref().map(Operated::new);
    let judge = judge_of(args, setup, &rows, more);
    let operator = operator.as_mut().map(|operator| -> &mut dyn Operator { operator });
    let report = live(judge, link, &clock, rate, &stop, operator, &mut say)
        .map_err(|error| Failure::from_error(&error))?;
    finish(args, report, &subject(args))
}

/// Before minutes of work.
fn create_reports(args: &args::Judge) -> Result<(), Failure> {
    for file in [&args.json, &args.junit, &args.html].into_iter().flatten() {
        std::fs::File::create(file).map_err(|error| unwritable(file, &error))?;
    }
    Ok(())
}

/// What ends it.
fn stop(args: &args::Judge) -> Result<Stop, Failure> {
    let stop = signals::stop_at_end().map_err(|error| Failure::from_error(&error))?;
    if args.end_with_stdin {
        let stop = stop.clone();
        signals::when_stdin_ends(move || stop.request()).map_err(|error| Failure::from_error(&error))?;
    }
    Ok(stop)
}

/// How it judges, with scenarios of the user.
fn judge_of(args: &args::Judge, setup: Setup, rows: &[Row], more: Vec<Scenario>) -> Judge {
    let mut judge = Judge::new(setup, rows);
    if let Some(seconds) = args.time {
        judge = judge.within(Duration::from_secs(seconds));
    }
    if let Some(lasts) = args.soak {
        judge = judge.soaking(lasts, args.seed);
    }
    judge.add(more);
    if args.ask.is_some() { judge.operated() } else { judge }
}

/// The same at several rates: the command of the user configures the master for each and starts it.
fn at_rates(
    args: &args::Judge,
    rates: &[BaudRate],
    setup: &Setup,
    rows: &[Row],
    more: &[Scenario],
    stop: &Stop,
) -> Result<Report, Failure> {
    let mut runs = Vec::new();
    let place = args.link.of_master().map_err(Failure::Usage)?;
    for baud in rates {
        let setup = Setup { baud: Some(*baud), ..setup.clone() };
        setup.check_master().map_err(Failure::Usage)?;
        let Opened { rate, mut link, path } = open_link(&place, Some(*baud), args.allow_remote)?;
        let clock = SystemClock::new();
        announce(&path, &setup)?;
        let mut operator = Operated::new(args.ask.as_deref().unwrap_or_default());
        if !operator.run(&format!("rate {}", baud.bits_per_second())) {
            let command = args.ask.as_deref().unwrap_or_default();
            return Err(Failure::Other(format!(
                "'{command} rate {baud}' failed, so the master is not at that rate",
                baud = baud.bits_per_second()
            )));
        }
        forget(&mut *link);
        let judge = judge_of(args, setup, rows_at_each(rows), more.to_vec());
        let report = live(judge, link, &clock, rate, stop, Some(&mut operator), &mut say)
            .map_err(|error| Failure::from_error(&error))?;
        info!("at {baud}: {}", report.ending);
        runs.push((*baud, report));
        if stop.is_requested() {
            break;
        }
    }
    let mut report =
        Report::over_rates(&runs, rows).ok_or_else(|| Failure::Usage("--baud has no rate".into()))?;
    let all: Vec<String> = rates.iter().map(|rate| rate.bits_per_second().to_string()).collect();
    for (_, value) in report.configuration.iter_mut().filter(|(name, _)| *name == "baud") {
        *value = all.join(",");
    }
    Ok(report)
}

/// Forgets what a master has asked while nobody could answer.
fn forget(link: &mut dyn Link) {
    let mut octets = [0; 256];
    for _ in 0..MOST_FORGOTTEN {
        match link.receive(&mut octets) {
            Ok(Received::Octets(_)) => {}
            // A link that fails says so again.
            Ok(Received::Nothing | Received::Reset | Received::BrokenOff(_) | Received::Rate(_)) | Err(_) => {
                return;
            }
        }
    }
}

/// The link, written to a capture if one is wanted.
fn captured(
    args: &args::Judge,
    link: Box<dyn Link>,
    path: &str,
    clock: SystemClock,
) -> Result<Box<dyn Link>, Failure> {
    let Some(file) = &args.capture else {
        return Ok(link);
    };
    let line = Interface { name: path, description: "PROFIBUS line of a judgement", baud: args.rate() };
    let capture = Capture::create(file, &line, &clock).map_err(|error| Failure::from_error(&error))?;
    let mut capture = Some(capture);
    Ok(Box::new(Tap::new(link, clock, move |batch: &Batch| {
        if let Some(Err(error)) = capture.as_mut().map(|capture| capture.write(batch)) {
            warn!("the capture ends here: {error}");
            capture = None;
        }
    })))
}

/// The bus of a node, written to a capture if one is wanted.
fn captured_can(
    args: &args::Judge,
    endpoint: Box<dyn CanEndpoint>,
    name: &str,
    rate: BitRate,
    clock: SystemClock,
) -> Result<Box<dyn CanEndpoint>, Failure> {
    let Some(file) = &args.capture else {
        return Ok(endpoint);
    };
    let bus = CanInterface { name, description: "CANopen node of a judgement", rate };
    let capture = Capture::create_can(file, &bus, &clock).map_err(|error| Failure::from_error(&error))?;
    let mut capture = Some(capture);
    Ok(Box::new(CanTap::new(endpoint, clock, move |at, direction, frame| {
        if let Some(Err(error)) = capture.as_mut().map(|capture| capture.write_frame(at, direction, frame)) {
            warn!("the capture ends here: {error}");
            capture = None;
        }
    })))
}

fn say(progress: &Progress) {
    let Progress { number, of, name, left } = progress;
    let left = left.as_secs();
    if number > of {
        info!("again, about {left} s left: {name}");
    } else {
        info!("{number} of {of}, about {left} s left: {name}");
    }
}

/// Exit status where a file or the link fails.
pub(super) const BROKEN: u8 = 5;

fn finish<R: Requirement>(
    args: &args::Judge,
    mut report: ReportOf<R>,
    subject: &str,
) -> Result<ExitCode, Failure> {
    report.required = args.require.iter().flat_map(args::Rows::of).collect();
    report.date = Some(date::now());
    let report = report;
    write(args.json.as_deref(), || report.json())?;
    write(args.junit.as_deref(), || report.junit())?;
    write(args.html.as_deref(), || report.html(subject))?;
    let mut stdout = io::stdout().lock();
    // Nobody may read it any more.
    let _ = write!(stdout, "{report}").and_then(|()| stdout.flush());
    let outcome = report.outcome();
    say_why(args, &outcome);
    Ok(ExitCode::from(outcome.status()))
}

/// Why there is no verdict on the master as a whole.
fn say_why(args: &args::Judge, outcome: &Outcome) {
    let Some(why) = outcome.trouble() else { return };
    let no_master = *why == Ending::NoMaster.to_string();
    let advice = match (&args.capture_file, no_master) {
        (None, true) => " within 10 s; start it after the ready line",
        (Some(_), true) => " in the capture",
        (_, false) => "",
    };
    let _ = writeln!(io::stderr(), "profidrive: {why}{advice}");
}

/// Writes a report, if it is wanted.
fn write(file: Option<&Path>, text: impl FnOnce() -> String) -> Result<(), Failure> {
    let Some(file) = file else { return Ok(()) };
    std::fs::write(file, text()).map_err(|error| unwritable(file, &error))
}

fn unwritable(file: &Path, error: &io::Error) -> Failure {
    Failure::Other(format!("cannot write {}: {error}", file.display()))
}

/// What was judged, for the page.
fn subject(args: &args::Judge) -> String {
    match (&args.capture_file, args.master) {
        (Some(file), _) => format!("Capture {}", file.display()),
        (None, Some(master)) => format!("DP master {master}"),
        (None, None) => "DP master".into(),
    }
}

fn announce(path: &str, setup: &Setup) -> Result<(), Failure> {
    let stations: Vec<String> = setup.stations.iter().map(|slave| slave.address.to_string()).collect();
    let mut stdout = io::stdout().lock();
    writeln!(stdout, "ready link={path} stations={}", stations.join(","))
        .and_then(|()| stdout.flush())
        .map_err(|error| Failure::from_error(&error))
}

fn setup(args: &args::Judge) -> Result<Setup, Failure> {
    let mut stations: Vec<Slave> = args.stations.iter().map(slave).collect::<Result<_, _>>()?;
    if let Some(file) = &args.line {
        stations.extend(line::stations(file)?);
        args.check_stations(stations.iter()).map_err(Failure::Usage)?;
    }
    let millis = |millis: Option<u64>| millis.map(Duration::from_millis);
    let setup = Setup {
        class: if args.class == 2 { MasterClass::Two } else { MasterClass::One },
        stations,
        master: args.master,
        watchdog: millis(args.watchdog),
        retries: args.retries,
        baud: args.rate(),
        slot: millis(args.slot),
        hsa: args.hsa,
        gap_factor: args.gap_factor,
        ttr: args.ttr.and_then(judge_millis),
        min_interval: args.min_interval.and_then(judge_millis),
        auto_clear: millis(args.auto_clear),
        master_gsd: args.master_gsd.as_deref().map(master_gsd).transpose()?.map(Box::new),
    };
    match (&args.master_gsd, setup.check_master()) {
        (Some(file), Err(words)) => Err(Failure::Usage(format!("{}: {words}", file.display()))),
        (_, Ok(()) | Err(_)) => Ok(setup),
    }
}

fn master_gsd(file: &Path) -> Result<MasterGsd, Failure> {
    let name = file.display();
    let octets =
        std::fs::read(file).map_err(|error| Failure::Usage(format!("cannot read {name}: {error}")))?;
    MasterGsd::read(&octets).map_err(|error| Failure::Usage(format!("{name}: {error}")))
}

fn slave(station: &JudgedStation) -> Result<Slave, Failure> {
    let mut slave = station.slave.clone();
    if let Some(file) = &station.gsd {
        let gsd = super::gsd::read(file)?;
        let described = Station::new(gsd, Policy::PROPOSED);
        let described = described.map_err(|error| Failure::Usage(format!("{}: {error}", file.display())))?;
        describe(&mut slave, &described);
    }
    Ok(slave)
}

/// What its device file says of a station.
fn describe(slave: &mut Slave, station: &Station) {
    let gsd = station.gsd();
    slave.ident = gsd.ident;
    slave.fail_safe |= gsd.flags.fail_safe;
    if slave.cfg.is_none() && station.is_fixed() {
        slave.cfg = Some(station.configuration(None).to_vec());
    }
    slave.gsd = Some(Box::new(gsd.clone()));
}
