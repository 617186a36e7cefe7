//! `profidrive master`: one thing done with a drive, as a DP master or as one of CANopen.
//!
//! | file | holds |
//! | --- | --- |
//! | `link` | the line, opened from the master's end |
//! | `drive` | [`Drive`]: parameters by job, words by exchange |
//! | `value` | values of parameters, read, with their unit and as JSON |
//! | `file` | where a parameter set is written |
//! | `canopen` | what is done with a node of CANopen |
//! | `ppo` | what is done with a drive of PROFIDRIVE version 2 |
//! | the others | one group of subcommands each |

mod access;
mod canopen;
mod diag;
mod faults;
mod file;
mod link;
mod motion;
mod ppo;
mod restore;
mod scan;
mod set;
mod status;
mod trouble;
mod value;

use core::panic::AssertUnwindSafe;
use core::time::Duration;
use std::io::{self, Write};
use std::panic;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use profidrive::client::PkwError;
use profidrive::devices::ag03::param::Parameter;
use profidrive::host::{Link, SystemClock};
use profidrive::master::{Session, SessionError};
use profidrive::profibus::fdl::Address;

use super::args::{Action, Master, ParameterSpec};
use super::{Failure, signals};
use profidrive::master::{Drive, DriveError};
use trouble::Trouble;

/// How often a wait that is shown is shown anew.
const TICK: Duration = Duration::from_millis(500);

/// Does what is asked, once. A panic, which would be a mistake in this program or in a crate it uses, ends it with one line
/// too.
pub(crate) fn master(args: &Master) -> Result<(), Failure> {
    panic::set_hook(Box::new(|_| {}));
    contained(|| act(args))
}

/// What it does, or the sentence of its panic.
fn contained(act: impl FnOnce() -> Result<(), Failure>) -> Result<(), Failure> {
    panic::catch_unwind(AssertUnwindSafe(act)).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no reason");
        Err(Failure::Other(format!(
            "this is a mistake in profidrive: {text}; please report it. Without its master the drive stops by its watchdog"
        )))
    })
}

fn act(args: &Master) -> Result<(), Failure> {
    if let Some(place) = args.can_place() {
        return canopen::master(args, &place);
    }
    if let Some(kind) = args.ppo.filter(|_| !matches!(args.action, Action::Scan { .. } | Action::Diag)) {
        return ppo::master(args, kind);
    }
    // What can be known without a drive is known before anything is sent.
    let json = args.json;
    match &args.action {
        Action::Scan { range } => scan::scan(&mut session(args)?, *range, json),
        Action::Diag => diag::diag(&mut session(args)?, address(args)?, json),
        Action::Read { parameter } => {
            let parameter = parameter.parameter().map_err(Failure::Usage)?;
            with(args, |drive| access::read(drive, &parameter, json))
        }
        Action::Write { parameter, value, .. } => {
            let parameter = parameter.parameter().map_err(Failure::Usage)?;
            access::check(&parameter, value.number_of(parameter.entry).map_err(Failure::Usage)?, "write")?;
            motion::confirm(args)?;
            with(args, |drive| access::write(drive, &parameter, *value, json))
        }
        Action::Params => with(args, |drive| access::params(drive, json)),
        Action::Save { file } => with(args, |drive| set::save(drive, file, json)),
        Action::Restore { file, dry_run, yes } => {
            let wanted = set::ParameterSet::load(file)?;
            let how = restore::How { dry_run: *dry_run, yes: *yes };
            with(args, |drive| restore::restore(drive, &wanted, how, json))
        }
        Action::Status => with(args, |drive| status::status(drive, json)),
        Action::Monitor { limit } => with(args, |drive| status::monitor(drive, *limit, json)),
        Action::Faults { clear } => with(args, |drive| faults::faults(drive, *clear, json)),
        Action::Calibrate { value, .. } => {
            if let Some(value) = value {
                let entry = Parameter::CalibrationValue.entry();
                let number = value.number_of(entry).map_err(Failure::Usage)?;
                access::check(&ParameterSpec { entry, element: None }, number, "calibrate")?;
            }
            motion::confirm(args)?;
            with(args, |drive| faults::calibrate(drive, *value, json))
        }
        Action::Stop => with(args, |drive| motion::stop(drive, json)),
        Action::Ack => with(args, |drive| motion::acknowledge(drive, json)),
        Action::Motion(motion) => {
            let leave = motion::confirm(args)?;
            with(args, |drive| motion::motion(drive, *motion, leave, json))
        }
    }
}

fn address(args: &Master) -> Result<Address, Failure> {
    args.drive().map_err(Failure::Usage)
}

/// The line, opened.
fn session(args: &Master) -> Result<Session<Box<dyn Link>, SystemClock>, Failure> {
    // Before the drive is taken, so that no signal ends the process with the drive moving.
    let stop = signals::stop_at_end().map_err(|error| Failure::from_error(&error))?;
    let (link, settings) = link::open(args)?;
    Session::new(link, SystemClock::new(), stop, settings).map_err(|error| Failure::from_error(&error))
}

/// Takes the drive over, does something with it, and lets it go.
fn with(
    args: &Master,
    act: impl FnOnce(&mut Drive<Box<dyn Link>, SystemClock>) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let address = address(args)?;
    let session = session(args)?;
    let drive = wait(address, || Drive::take(session, address));
    let mut drive = drive?;
    let outcome = act(&mut drive);
    // Ctrl-C has ended what was under way, not this. If the drive is lost, its watchdog lets it go.
    drive.session.stop().clear();
    let _ = drive.session.release();
    outcome
}

/// Says on a terminal what is waited for, and for how long by now.
fn wait<T>(address: Address, done: impl FnOnce() -> T) -> T {
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden());
    if let Ok(style) = ProgressStyle::with_template("{spinner} {msg} ({elapsed})") {
        bar.set_style(style);
    }
    bar.set_message(format!(
        "connecting to drive {address}: if there are other masters on the line, it can take half a minute until this one gets the token; Ctrl-C ends it"
    ));
    bar.set_draw_target(ProgressDrawTarget::stderr());
    bar.enable_steady_tick(TICK);
    let outcome = done();
    bar.finish_and_clear();
    outcome
}

/// Prints a result. Whoever reads it may have closed the pipe after the first lines (`| head`): that is no failure.
fn say(line: impl core::fmt::Display) -> Result<(), Failure> {
    match writeln!(io::stdout().lock(), "{line}") {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::Other(format!("cannot write to stdout: {error}")))
        }
        Ok(()) | Err(_) => Ok(()),
    }
}

/// A bar on stderr for something that takes a while, if that is a terminal.
fn watch(what: &'static str, steps: usize) -> ProgressBar {
    let steps = u64::try_from(steps).unwrap_or(u64::MAX);
    let bar = ProgressBar::with_draw_target(Some(steps), ProgressDrawTarget::stderr());
    // The template is ours and right; without it the bar looks as the crate likes it.
    if let Ok(style) = ProgressStyle::with_template("{msg} [{bar:30}] {pos}/{len}") {
        bar.set_style(style.progress_chars("=> "));
    }
    bar.set_message(what);
    bar
}

impl From<SessionError> for Failure {
    fn from(error: SessionError) -> Self {
        Self::Other(error.to_string())
    }
}

impl From<PkwError> for Failure {
    fn from(error: PkwError) -> Self {
        Self::Other(error.to_string())
    }
}

impl From<DriveError> for Failure {
    fn from(error: DriveError) -> Self {
        Self::Other(error.to_string())
    }
}

impl From<Trouble> for Failure {
    fn from(trouble: Trouble) -> Self {
        Self::Other(trouble.to_string())
    }
}

#[cfg(test)]
mod rig;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_ends_as_a_sentence() {
        let failure = contained(|| panic!("an {} of no use", "unwrap"));
        let Err(Failure::Other(line)) = failure else { panic!("{failure:?}") };
        assert!(line.starts_with("this is a mistake in profidrive: an unwrap of no use; please"), "{line}");
        assert!(contained(|| Ok(())).is_ok());
    }
}
