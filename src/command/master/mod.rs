//! `profidrive master`: one thing done with a drive, as a DP master or as one of CANopen.
//!
//! | file | holds |
//! | --- | --- |
//! | `link` | the line, opened from the master's end |
//! | `file` | where a parameter set is written |
//! | `device` | [`Commissioned`](device::Commissioned): what every drive can be asked |
//! | `positioning` | a positioning drive on PROFIBUS |
//! | `confirm` | what somebody confirms before anything is sent |
//! | `canopen` | what is done with a node of CANopen |
//! | `ppo` | what is done with a drive of PROFIDRIVE version 2 |
//! | `alarms` | alarms of a slave of DP-V1 |
//! | `records` | records, parameters by record 47, identification of a slave of DP-V1 |
//! | the others | one group of subcommands each |

mod alarms;
mod canopen;
mod confirm;
mod device;
mod diag;
mod file;
mod link;
mod positioning;
mod ppo;
mod records;
mod scan;
mod trouble;

use core::panic::AssertUnwindSafe;
use core::time::Duration;
use std::io::{self, Write};
use std::panic;

use crate::client::PkwError;
use crate::host::{Link, SystemClock};
use crate::master::{Session, SessionError};
use crate::profibus::fdl::Address;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::args::{Action, Master};
use super::{Failure, signals};
use crate::master::DriveError;
pub(super) use canopen::open as open_can;
use trouble::Trouble;

/// How often a wait that is shown is shown anew.
const TICK: Duration = Duration::from_millis(500);

/// Does what is asked, once. A panic, which would be a mistake in this program or in a crate it uses, ends it with one line
/// too.
pub(crate) fn master(args: &Master) -> Result<(), Failure> {
    panic::set_hook(Box::new(|_| {}));
    contained(|| dispatch(args))
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

fn dispatch(args: &Master) -> Result<(), Failure> {
    if let Some(place) = args.can_place() {
        return canopen::master(args, &place);
    }
    if let Action::Scan { range } = &args.action {
        return scan::scan(&mut session(args)?, *range, args.json);
    }
    if let Action::Diag = &args.action {
        return diag::diag(&mut session(args)?, address(args)?, args.json);
    }
    if let Action::Record { action } = &args.action {
        return records::record(&mut session(args)?, address(args)?, action, args.json);
    }
    if let Action::Param { action } = &args.action {
        return records::param(&mut session(args)?, address(args)?, action, args.json);
    }
    if let (Action::Alarms { modules, keep, limit }, Some(file)) = (&args.action, &args.gsd) {
        let slave = alarms::slave(file, modules)?;
        return alarms::alarms(&mut session(args)?, address(args)?, slave, (*keep, *limit), args.json);
    }
    if let Action::Im { block, slot } = &args.action {
        return records::identification(&mut session(args)?, address(args)?, (*slot, *block), args.json);
    }
    match args.ppo {
        Some(kind) => ppo::master(args, kind),
        None => positioning::master(args),
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
