//! A drive of PROFIDRIVE version 2: `read`, `write`, `params`, `status`, `monitor`, `faults`, `ack`, `enable`, `velocity`,
//! `stop`.
//!
//! Whatever ends a motion, OFF1 is given before, and the drive brakes on its ramp. If the line is lost, the drive has a fault of
//! its own for it.

mod place;

use core::time::Duration;
use std::path::Path;

use crate::client::{PpoGoal, PpoGoalError, Profile};
use crate::devices::ag03::param::{Pnu, Subindex, Value, Width};
use crate::devices::ppo_drive;
use crate::devices::ppo_drive::profibus::{IDENT_NUMBER, ppo_of};
use crate::devices::ppo_drive::profile::{StwBit, ZswBit, reasons};
use crate::devices::ppo_drive::table::{Kind, Row, Table, Tie};
use crate::gsd::{Gsd, Policy, Station};
use crate::host::list::table_of_file;
use crate::host::{Clock, Link, SystemClock};
use crate::master::{DriveError, ProfileDrive, ProfileReached, Session, SessionError, Slave, Values};
use crate::profibus::dp::Application;
use crate::profibus::ppo::{PpoType, Zsw};
use serde_json::json;

use self::place::Place;
use super::confirm::{Confirmed, confirm};
use super::device::{self, Commissioned};
use super::{link, say, wait};
use crate::command::Failure;
use crate::command::args::{Action, Asked, Master, Motion, Quantity};
use crate::command::gsd;
use crate::command::signals;

/// The fault numbers, of which the first eight are those that stand.
const FAULT_NUMBERS: Pnu = Pnu::from_low_bits(947);
const STANDING: u8 = 8;
/// The number of faults; 0 clears the buffer.
const FAULT_COUNT: Pnu = Pnu::from_low_bits(952);
/// Two arrays of the profile that list all parameters; the first ends with 0.
const LIST: Pnu = Pnu::from_low_bits(980);

/// Arrays of so many elements are named and not read with all parameters.
const LONG: u8 = 17;

/// Exchanges until the drive shows what it is, not what it was.
const LOOKS: usize = 5;

/// A setpoint of 100 %.
const FULL: f64 = 16384.0;

/// Does what is asked, once.
pub(super) fn master(args: &Master, kind: PpoType) -> Result<(), Failure> {
    let table = args.parameters.as_deref().map(table_of_file).transpose().map_err(Failure::Usage)?;
    let own = table.is_some();
    let table = table.unwrap_or_else(Table::profile);
    let slave = match &args.gsd {
        Some(file) => of_gsd(file, kind)?,
        None => Slave::ppo(args.ident.unwrap_or(IDENT_NUMBER), kind),
    };
    check(args, kind, &table)?;
    let leave = confirm(args)?;
    let address = args.drive().map_err(Failure::Usage)?;
    // Before the drive is taken, so that no signal ends the process with the drive moving.
    let stop = signals::stop_at_end().map_err(|error| Failure::from_error(&error))?;
    let (link, settings) = link::open(args)?;
    let session = Session::new(link, SystemClock::new(), stop, settings);
    let session = session.map_err(|error| Failure::from_error(&error))?;
    let take = || ProfileDrive::take(session, address, &slave, kind, Profile::PROFIDRIVE);
    let drive = wait(address, take)?;
    let mut taken = Taken { drive, table: &table, own, reference: args.reference_speed.map(f64::from) };
    let outcome = device::act(&mut taken, &args.action, leave, args.json);
    // Ctrl-C has ended what was under way, not this.
    taken.drive.session.stop().clear();
    let _ = taken.drive.session.release();
    outcome
}

/// What can be known without a drive is known before anything is sent.
fn check(args: &Master, kind: PpoType, table: &Table) -> Result<(), Failure> {
    if let Action::Read { parameter } | Action::Write { parameter, .. } = &args.action {
        let place = Place::find(table, &parameter.0)?;
        if let Action::Write { value, .. } = &args.action {
            place.check(value.number().map_err(Failure::Usage)?)?;
        }
        if !kind.has_pkw() {
            return Err(Failure::Usage(format!("{kind} has no parameter channel; choose PPO 1, 2 or 5")));
        }
    }
    let turns = matches!(args.action, Action::Motion(Motion::Velocity { .. }));
    if turns && args.reference_speed.is_none() && reference_row(table).is_none() {
        return Err(Failure::Usage(
            "the speed of 100 % is not known; add --reference-speed RPM, or --parameters with a parameter that is tied to \
             reference-speed"
                .into(),
        ));
    }
    Ok(())
}

/// The slave that a device file describes, with the modules of this PPO and the default user parameters.
fn of_gsd(file: &Path, kind: PpoType) -> Result<Slave, Failure> {
    let usage = |words: String| Failure::Usage(format!("{}: {words}", file.display()));
    let gsd: Gsd = gsd::read(file)?;
    let station = Station::new(gsd, Policy::PROPOSED).map_err(|error| usage(error.to_string()))?;
    // A module that is the whole PPO, what the file fixes, the customary configuration, the same with an empty slot ahead.
    let modules = station.gsd().modules.iter().map(|module| module.identifiers.clone());
    let fixed = station.configuration(None).to_vec();
    let customary = kind.configuration();
    let others = [fixed, customary.to_vec(), [&[0], customary].concat()];
    let fits = |octets: &Vec<u8>| ppo_of(octets) == Some(kind) && station.judge_cfg(octets, &[]).is_ok();
    let configuration = modules.chain(others).find(fits).ok_or_else(|| {
        usage(format!(
            "none of its modules is a {kind}; see 'profidrive gsd {}' for its modules",
            file.display()
        ))
    })?;
    let plugged = station.modules(&configuration, None).unwrap_or_default();
    let modules: Vec<usize> = plugged.iter().filter_map(|modules| modules.first().copied()).collect();
    let user_prm = station.gsd().default_user_prm(&modules);
    let (sync_mode, freeze_mode) = (station.gsd().flags.sync, station.gsd().flags.freeze);
    let ident = station.gsd().ident;
    // Two short lists, once in the life of the process.
    let (configuration, user_prm): (&[u8], &[u8]) = (configuration.leak(), user_prm.leak());
    Ok(Slave { configuration, user_prm, sync_mode, freeze_mode, ..Slave::ppo(ident, kind) })
}

fn reference_row(table: &Table) -> Option<&Row> {
    table.tied(Tie::Drive(ppo_drive::Quantity::ReferenceSpeed))
}

/// A drive that belongs to this master, and what is known of it.
struct Taken<'t, L, C> {
    drive: ProfileDrive<L, C>,
    table: &'t Table,
    /// The table is that of the user.
    own: bool,
    /// The speed of 100 %, rpm.
    reference: Option<f64>,
}

impl<L: Link, C: Clock> Taken<'_, L, C> {
    fn value(&mut self, place: &Place<'_>) -> Result<Value, DriveError> {
        let width = place.row.map(|row| if row.kind.is_double() { Width::Double } else { Width::Word });
        self.drive.read(place.pnu, place.element, width)
    }

    /// PNU 980: the numbers of the parameters, up to the first 0.
    fn listed(&mut self) -> Result<Vec<u16>, Failure> {
        let mut numbers = Vec::new();
        for element in 1..=u8::MAX {
            let read = self.drive.read(LIST, Some(Subindex(element)), None);
            match (read, numbers.is_empty()) {
                (Ok(value), _) if value.bits() != 0 => {
                    numbers.push(u16::try_from(value.bits()).unwrap_or_default())
                }
                (Ok(_) | Err(DriveError::Job(_)), false) => break,
                (Ok(_) | Err(DriveError::Job(_)), true) => {
                    return Err(Failure::Other(
                        "the drive has no list of its parameters (PNU 980); give them with --parameters"
                            .into(),
                    ));
                }
                (Err(error), _) => return Err(error.into()),
            }
        }
        Ok(numbers)
    }

    /// Several exchanges, so that the drive has answered this master.
    fn look(&mut self) -> Result<Values, SessionError> {
        for _ in 0..LOOKS {
            self.drive.exchange()?;
        }
        self.drive.exchange()
    }

    /// The numbers of the faults that stand; none where the drive has no such array.
    fn standing(&mut self) -> Result<Vec<u32>, Failure> {
        let mut numbers = Vec::new();
        for element in 1..=STANDING {
            if !self.drive.has_parameters() {
                break;
            }
            match self.drive.read(FAULT_NUMBERS, Some(Subindex(element)), None) {
                Ok(value) if value.bits() != 0 => numbers.push(value.bits()),
                Ok(_) | Err(DriveError::Job(_)) => break,
                Err(error) => return Err(error.into()),
            }
        }
        Ok(numbers)
    }

    /// The speed of 100 %, as given or as the drive says.
    fn reference(&mut self) -> Result<Option<f64>, Failure> {
        let Some(row) = reference_row(self.table).filter(|_| self.reference.is_none()) else {
            return Ok(self.reference);
        };
        if !self.drive.has_parameters() {
            return Ok(None);
        }
        let place = Place::of(row, None);
        let value = self.value(&place)?;
        self.reference = Some(row.kind.value(value.bits()) * row.scale);
        Ok(self.reference)
    }

    fn actual(&self, actual: i16) -> String {
        let part = f64::from(actual) / FULL;
        let rpm =
            self.reference.map(|reference| format!(" ({:.0} rpm)", part * reference)).unwrap_or_default();
        format!("actual value {:.1} %{rpm}", part * 100.0)
    }

    fn done(&self, json: bool, what: &str, actual: i16) -> Result<(), Failure> {
        if json {
            return say(json!({ "outcome": what, "actual": actual }));
        }
        say(format_args!("{what}; {}", self.actual(actual)))
    }

    /// Reaches a goal and holds it until its time is over or somebody ends it: the last actual value, or why not.
    fn hold(
        &mut self,
        goal: PpoGoal,
        limit: Option<Duration>,
        json: bool,
    ) -> Result<Result<i16, PpoGoalError>, SessionError> {
        let begun = self.drive.session.now();
        let mut actual = match self.drive.reach(goal)? {
            ProfileReached::Done(actual) => actual,
            ProfileReached::Failed(error) => return Ok(Err(error)),
            ProfileReached::Interrupted => 0,
        };
        if !json {
            // Nobody may read along.
            let _ = say(format_args!("{goal}: reached, {}; Ctrl-C ends it", self.actual(actual)));
        }
        loop {
            let since = self.drive.session.now().saturating_since(begun);
            if self.drive.is_stopped() || limit.is_some_and(|limit| since >= limit) {
                return Ok(Ok(actual));
            }
            let seen = self.drive.exchange()?;
            actual = seen.actual;
            if ZswBit::Fault.is_set(seen.zsw) {
                return Ok(Err(PpoGoalError::Fault));
            }
            if !ZswBit::OperationEnabled.is_set(seen.zsw) {
                return Ok(Err(PpoGoalError::Ended { zsw: seen.zsw }));
            }
        }
    }

    /// The setpoint of a speed.
    fn setpoint(&mut self, rpm: i32) -> Result<i16, Failure> {
        let reference = self.reference()?.filter(|reference| *reference > 0.0);
        let reference = reference.ok_or_else(|| {
            Failure::Other("the speed of 100 % is not known; add --reference-speed RPM".into())
        })?;
        let setpoint = (f64::from(rpm) / reference * FULL).round();
        if !(f64::from(i16::MIN)..=f64::from(i16::MAX)).contains(&setpoint) {
            return Err(Failure::Other(format!(
                "a setpoint goes to 199.99 % of {reference} rpm, got {rpm} rpm; nothing was moved"
            )));
        }
        #[expect(clippy::cast_possible_truncation, reason = "within the range")]
        let setpoint = setpoint as i16;
        Ok(setpoint)
    }
}

impl<L: Link, C: Clock> Commissioned for Taken<'_, L, C> {
    fn read(&mut self, asked: &Asked, json: bool) -> Result<(), Failure> {
        let place = Place::find(self.table, &asked.0)?;
        place.shown(self.value(&place)?).say(json)
    }

    fn write(&mut self, asked: &Asked, value: Quantity, json: bool) -> Result<(), Failure> {
        let place = Place::find(self.table, &asked.0)?;
        let number = value.number().map_err(Failure::Usage)?;
        let before = self.value(&place)?;
        let bits = match place.row {
            Some(row) => row.kind.bits(number),
            // Whole, and of 32 bits: that is checked.
            None if number < 0.0 => Kind::Int32.bits(number),
            None => Kind::Uint32.bits(number),
        };
        let [_, _, high, low] = bits.to_be_bytes();
        let value = match before {
            Value::Word(_) => Value::Word(u16::from_be_bytes([high, low])),
            Value::Double(_) => Value::Double(bits),
        };
        self.drive.write(place.pnu, place.element, value)?;
        let after = self.value(&place)?;
        // A command keeps nothing, a drive may round.
        let note =
            if after == value { String::new() } else { format!(", written was {}", place.shown(value).text) };
        place.shown(after).say_changed(&place.shown(before), &note, json)
    }

    /// All of the table, or of the list of the drive.
    fn params(&mut self, json: bool) -> Result<(), Failure> {
        let numbers: Vec<u16> =
            if self.own { self.table.rows().map(|row| row.pnu).collect() } else { self.listed()? };
        let mut items = Vec::new();
        for pnu in numbers {
            let row = self.table.row(pnu);
            let places: Vec<Place<'_>> = match (row, row.and_then(|row| row.elements)) {
                // The list itself, and the fault buffer.
                (Some(row), Some(count @ LONG..)) => {
                    let name = &row.name;
                    if json {
                        items.push(json!({ "pnu": pnu, "name": name, "elements": count }));
                    } else {
                        say(format_args!(
                            "{pnu:<6} {name:<27} array of {count}: read {pnu}.1 to {pnu}.{count}"
                        ))?;
                    }
                    continue;
                }
                (Some(row), Some(count)) => {
                    (1..=count).map(|element| Place::of(row, Some(element))).collect()
                }
                (Some(row), None) => vec![Place::of(row, None)],
                (None, _) => vec![Place { pnu: Pnu::from_low_bits(pnu), element: None, row: None }],
            };
            for place in places {
                if self.drive.is_stopped() {
                    return Err(Failure::Other("interrupted".into()));
                }
                match self.value(&place) {
                    Ok(value) if json => items.push(place.shown(value).json),
                    Ok(value) => place.shown(value).say(json)?,
                    Err(error @ DriveError::Job(_)) if json => {
                        items.push(json!({ "pnu": pnu, "name": place.name(), "error": error.to_string() }));
                    }
                    Err(error @ DriveError::Job(_)) => {
                        say(format_args!("{:<6} {:<27} {error}", place.number(), place.name()))?;
                    }
                    Err(error) => return Err(error.into()),
                }
            }
        }
        if json { say(format_args!("{:#}", json!({ "parameters": items }))) } else { Ok(()) }
    }

    fn status(&mut self, json: bool) -> Result<(), Failure> {
        self.reference()?;
        let Values { stw, zsw, actual } = self.look()?;
        let faults = if ZswBit::Fault.is_set(zsw) { self.standing()? } else { Vec::new() };
        let why: Vec<String> = reasons(stw, zsw).map(|reason| reason.to_string()).collect();
        if json {
            let stw_bits: serde_json::Map<_, _> =
                StwBit::ALL.iter().map(|bit| (bit.name().into(), bit.is_set(stw).into())).collect();
            let zsw_bits: serde_json::Map<_, _> =
                ZswBit::ALL.iter().map(|bit| (bit.name().into(), bit.is_set(zsw).into())).collect();
            return say(json!({
                "state": state(zsw),
                "stw": { "word": stw.raw(), "bits": stw_bits },
                "zsw": { "word": zsw.raw(), "bits": zsw_bits },
                "actual": actual,
                "actual_percent": f64::from(actual) / FULL * 100.0,
                "why": why,
                "faults": faults,
            }));
        }
        say(format_args!("{}; {}", state(zsw), self.actual(actual)))?;
        for fault in faults {
            say(format_args!("fault {fault}"))?;
        }
        for reason in why {
            say(format_args!("does not move: {reason}"))?;
        }
        say(format_args!("\nSTW {stw}  control word, as this master sends it"))?;
        for bit in StwBit::ALL {
            say(format_args!("  {:>2}  {}  {}", bit.number(), u8::from(bit.is_set(stw)), bit.name()))?;
        }
        say(format_args!("\nZSW {zsw}  status word"))?;
        for bit in ZswBit::ALL {
            say(format_args!("  {:>2}  {}  {}", bit.number(), u8::from(bit.is_set(zsw)), bit.name()))?;
        }
        Ok(())
    }

    fn monitor(&mut self, limit: Option<Duration>, json: bool) -> Result<(), Failure> {
        self.reference()?;
        let begun = self.drive.session.now();
        let mut shown = None;
        loop {
            let since = self.drive.session.now().saturating_since(begun);
            if self.drive.is_stopped() || limit.is_some_and(|limit| since >= limit) {
                return Ok(());
            }
            let Values { zsw, actual, .. } = self.drive.exchange()?;
            if shown.replace((zsw, actual)) == Some((zsw, actual)) {
                continue;
            }
            let (seconds, state) = (since.as_secs_f64(), state(zsw));
            if json {
                say(json!({ "time": seconds, "zsw": zsw.raw(), "actual": actual, "state": state }))?;
            } else {
                say(format_args!("{seconds:>9.3}  {zsw}  {}  {state}", self.actual(actual)))?;
            }
        }
    }

    fn faults(&mut self, clear: bool, json: bool) -> Result<(), Failure> {
        if clear {
            self.drive.write(FAULT_COUNT, None, Value::Word(0))?;
        }
        let standing = self.standing()?;
        let mut before = Vec::new();
        for element in STANDING + 1..=64 {
            match self.drive.read(FAULT_NUMBERS, Some(Subindex(element)), None) {
                Ok(value) if value.bits() != 0 => before.push((element, value.bits())),
                Ok(_) => {}
                Err(DriveError::Job(_)) => break,
                Err(error) => return Err(error.into()),
            }
        }
        if json {
            let before: Vec<_> = before.iter().map(|(_, number)| number).collect();
            return say(json!({ "standing": standing, "acknowledged": before }));
        }
        say(if clear {
            "cleared; active faults (PNU 947.1 to 947.8):"
        } else {
            "active faults (PNU 947.1 to 947.8):"
        })?;
        if standing.is_empty() {
            say("  none")?;
        }
        for (number, place) in standing.iter().zip(1..) {
            say(format_args!("  947.{place:<3} {number}"))?;
        }
        for (place, number) in before {
            say(format_args!("  947.{place:<3} {number}, acknowledged"))?;
        }
        Ok(())
    }

    fn acknowledge(&mut self, json: bool) -> Result<(), Failure> {
        match self.drive.reach(PpoGoal::Acknowledge)? {
            ProfileReached::Done(actual) => {
                self.done(json, "no active fault, operation can be enabled", actual)
            }
            ProfileReached::Failed(error) => {
                let standing = self.standing()?;
                Err(Failure::Other(format!(
                    "the fault stays, {standing:?}: its cause is still present; {error}"
                )))
            }
            ProfileReached::Interrupted => Err(Failure::Other("interrupted".into())),
        }
    }

    fn stop(&mut self, json: bool) -> Result<(), Failure> {
        match self.drive.reach(PpoGoal::Disable)? {
            ProfileReached::Done(actual) => self.done(json, "OFF1, operation is disabled", actual),
            ProfileReached::Failed(error) => Err(Failure::Other(error.to_string())),
            ProfileReached::Interrupted => Err(Failure::Other("interrupted; the drive still brakes".into())),
        }
    }

    /// Does it, and leaves the drive out of operation.
    fn motion(&mut self, motion: Motion, _: Confirmed, json: bool) -> Result<(), Failure> {
        let (goal, limit, what) = match motion {
            Motion::Velocity { rpm, limit, .. } => (PpoGoal::Run(self.setpoint(rpm)?), limit, "turned"),
            Motion::Enable { limit, .. } => (PpoGoal::Enable, limit, "held enabled"),
            Motion::Move { .. } | Motion::Jog { .. } | Motion::Home { .. } => {
                return Err(Failure::Usage("with --ppo only velocity and enable can move the drive".into()));
            }
        };
        let outcome = self.hold(goal, limit, json);
        // A second Ctrl-C ends the wait.
        self.drive.session.stop().clear();
        let ended = self.drive.reach(PpoGoal::Disable);
        match (outcome, ended) {
            (Ok(reached), Ok(ProfileReached::Done(_))) => match reached {
                Ok(actual) => self.done(json, what, actual),
                Err(error) => {
                    let faults = self.standing()?;
                    let faults =
                        if faults.is_empty() { String::new() } else { format!(" (faults {faults:?})") };
                    Err(Failure::Other(format!("{error}{faults}; OFF1 is given, operation is disabled")))
                }
            },
            (Err(error), _) | (Ok(_), Err(error)) => Err(Failure::Other(format!(
                "{error}; the drive did not report that operation is disabled: without this master it has a fault and releases \
                 the motor"
            ))),
            (Ok(_), Ok(ProfileReached::Failed(_) | ProfileReached::Interrupted)) => Err(Failure::Other(
                "the drive did not report that operation is disabled; switch its supply off".into(),
            )),
        }
    }
}

/// The state that a status word shows.
fn state(zsw: Zsw) -> &'static str {
    let is = |bit: ZswBit| bit.is_set(zsw);
    if is(ZswBit::Fault) {
        "fault"
    } else if is(ZswBit::OperationEnabled) {
        "operation enabled"
    } else if is(ZswBit::SwitchingOnInhibited) {
        "switching on inhibited"
    } else if is(ZswBit::Ready) {
        "switched on"
    } else if is(ZswBit::ReadyToSwitchOn) {
        "ready for switching on"
    } else {
        "not ready for switching on"
    }
}
