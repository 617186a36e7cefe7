//! An AG03 or AG03/1 on PROFIBUS: every command.
//!
//! | file | holds |
//! | --- | --- |
//! | `value` | values of parameters, read, with their unit and as JSON |
//! | the others | one group of subcommands each |

mod access;
mod faults;
mod motion;
mod restore;
#[cfg(test)]
mod rig;
mod set;
mod status;
mod value;

use core::time::Duration;
use std::path::Path;

use crate::devices::ag03::param::Parameter;
use crate::host::list::named::ParameterSpec;
use crate::host::{Clock, Link};
use crate::master::Drive;

use super::confirm::{Confirmed, confirm};
use super::device::{self, Commissioned};
use super::{address, session, wait};
use crate::command::Failure;
use crate::command::args::{Action, Asked, Master, Motion, Quantity};
use set::ParameterSet;
use value::number_of;

pub(super) use motion::{check_velocity, replaces};

/// A drive that belongs to this master, and the file that it shall be restored from.
struct Ag03<L, C> {
    drive: Drive<L, C>,
    wanted: Option<ParameterSet>,
}

/// Takes the drive over, does what is asked, and lets it go.
pub(super) fn master(args: &Master) -> Result<(), Failure> {
    let wanted = check(&args.action)?;
    let leave = confirm(args)?;
    let address = address(args)?;
    let session = session(args)?;
    let drive = wait(address, || Drive::take(session, address))?;
    let mut ag03 = Ag03 { drive, wanted };
    let outcome = device::act(&mut ag03, &args.action, leave, args.json);
    // Ctrl-C has ended what was under way, not this. If the drive is lost, its watchdog lets it go.
    ag03.drive.session.stop().clear();
    let _ = ag03.drive.session.release();
    outcome
}

/// What can be known without a drive is known before anything is sent.
fn check(action: &Action) -> Result<Option<ParameterSet>, Failure> {
    if let Action::Restore { file, .. } = action {
        return ParameterSet::load(file).map(Some);
    }
    if let Action::Read { parameter } | Action::Write { parameter, .. } = action {
        let spec = spec(parameter)?;
        if let Action::Write { value, .. } = action {
            access::check(&spec, number_of(value, spec.entry)?, "write")?;
        }
    }
    if let Action::Calibrate { value: Some(value), .. } = action {
        let entry = Parameter::CalibrationValue.entry();
        let number = number_of(value, entry)?;
        access::check(&ParameterSpec { entry, element: None }, number, "calibrate")?;
    }
    Ok(None)
}

fn spec(asked: &Asked) -> Result<ParameterSpec, Failure> {
    asked.parameter().map_err(Failure::Usage)
}

impl<L: Link, C: Clock> Commissioned for Ag03<L, C> {
    fn read(&mut self, asked: &Asked, json: bool) -> Result<(), Failure> {
        access::read(&mut self.drive, &spec(asked)?, json)
    }

    fn write(&mut self, asked: &Asked, value: Quantity, json: bool) -> Result<(), Failure> {
        access::write(&mut self.drive, &spec(asked)?, value, json)
    }

    fn params(&mut self, json: bool) -> Result<(), Failure> {
        access::params(&mut self.drive, json)
    }

    fn status(&mut self, json: bool) -> Result<(), Failure> {
        status::status(&mut self.drive, json)
    }

    fn monitor(&mut self, limit: Option<Duration>, json: bool) -> Result<(), Failure> {
        status::monitor(&mut self.drive, limit, json)
    }

    fn faults(&mut self, clear: bool, json: bool) -> Result<(), Failure> {
        faults::faults(&mut self.drive, clear, json)
    }

    fn acknowledge(&mut self, json: bool) -> Result<(), Failure> {
        motion::acknowledge(&mut self.drive, json)
    }

    fn stop(&mut self, json: bool) -> Result<(), Failure> {
        motion::stop(&mut self.drive, json)
    }

    fn motion(&mut self, motion: Motion, leave: Confirmed, json: bool) -> Result<(), Failure> {
        motion::motion(&mut self.drive, motion, leave, json)
    }

    fn save(&mut self, file: &Path, json: bool) -> Result<(), Failure> {
        set::save(&mut self.drive, file, json)
    }

    fn restore(&mut self, dry_run: bool, yes: bool, json: bool) -> Result<(), Failure> {
        let wanted = self.wanted.take().unwrap_or_default();
        restore::restore(&mut self.drive, &wanted, restore::How { dry_run, yes }, json)
    }

    fn calibrate(&mut self, value: Option<Quantity>, json: bool) -> Result<(), Failure> {
        faults::calibrate(&mut self.drive, value, json)
    }
}
