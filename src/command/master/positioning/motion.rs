//! `enable`, `move`, `jog`, `velocity`, `stop`, `ack`: what a drive does, and how it ends.
//!
//! Whatever ends a command that lets the shaft turn (its goal, its time, Ctrl-C, a signal, a refusal), operation is
//! disabled before: the drive brakes with maximum deceleration, and only then is released. If the line is lost, the drive's
//! own watchdog releases the motor.

use core::time::Duration;

use crate::client::{Goal, GoalError};
use crate::devices::ag03::drive;
use crate::devices::ag03::drive::Mode;
use crate::devices::ag03::param::{Gear, LOAD_PARAMETER_SET, Parameter};
use crate::devices::ag03::profibus::bits::ZswBit;
use crate::explain::value::Lengths;
use crate::explain::words::said;
use crate::host::{Clock, Link};
use crate::master::{Drive, DriveError, Reached, Seen};
use serde_json::json;

use super::status::{actual, mode, travels};
use super::value::{fits, lengths, unit};
use crate::command::Failure;
use crate::command::args::{Asked, Direction, Motion, Quantity};
use crate::command::master::confirm::Confirmed;
use crate::command::master::say;
use crate::command::master::trouble::Trouble;

/// How long a drive that runs out is waited for.
const RUN_OUT: Duration = Duration::from_secs(30);

/// The question behind a write that replaces what the drive keeps; `None`: it is another parameter.
pub(in crate::command::master) fn replaces(asked: &Asked, value: Quantity) -> Option<String> {
    let spec = asked.parameter().ok().filter(|spec| spec.entry.pnu == LOAD_PARAMETER_SET)?;
    let command = value.plain().unwrap_or_default();
    let words = spec.entry.in_words(command, Lengths::Unknown);
    Some(format!(
        "carry out the command {words} of PNU {LOAD_PARAMETER_SET}; the present values are lost. Continue?"
    ))
}

/// Refuses a velocity that no gear has.
pub(in crate::command::master) fn check_velocity(rpm: i32) -> Result<(), Failure> {
    let fastest = i32::from(Gear::FASTEST.max_rpm());
    if rpm.abs() > fastest {
        return Err(Failure::Usage(format!(
            "a drive turns with at most {fastest} rpm, got {rpm}; see 'profidrive master velocity --help'"
        )));
    }
    Ok(())
}

fn way(direction: Direction) -> drive::Direction {
    match direction {
        Direction::Positive => drive::Direction::Positive,
        Direction::Negative => drive::Direction::Negative,
    }
}

/// What a command is about, once it is known how the drive counts.
struct Reading {
    mode: Mode,
    lengths: Lengths,
    json: bool,
}

impl Reading {
    fn of<L: Link, C: Clock>(drive: &mut Drive<L, C>, json: bool) -> Result<Self, Trouble> {
        Ok(Self { mode: mode(drive)?, lengths: lengths(drive)?, json })
    }

    /// What goes on until somebody ends it, for somebody who reads along.
    fn held(&self, what: &str) -> Result<(), Trouble> {
        let line = if what == "turned" { "turning" } else { "enabled" };
        say(format_args!("{line}; Ctrl-C ends it")).map_err(|_| Trouble::Ended("stdout is closed".into()))
    }

    /// One line for what has come of it.
    fn say(&self, what: &str, hiw: i32) -> Result<(), Failure> {
        match (self.json, self.mode) {
            (true, Mode::Positioning) => say(json!({ "outcome": what, "position": hiw })),
            (true, Mode::Velocity) => say(json!({ "outcome": what, "velocity": hiw })),
            (false, _) => say(format_args!("{what}; {}", actual(self.mode, self.lengths, hiw))),
        }
    }
}

/// Does it, and leaves the drive standing.
pub(super) fn motion<L: Link, C: Clock>(
    drive: &mut Drive<L, C>,
    motion: Motion,
    _: Confirmed,
    json: bool,
) -> Result<(), Failure> {
    let reading = Reading::of(drive, json)?;
    if let Motion::Move { position, .. } = motion {
        fits(&position, reading.lengths)?;
    }
    let outcome = turn(drive, motion, &reading);
    let Rest { hiw, refused } = match wind_down(drive) {
        Ok(rest) => rest,
        Err(end) => return Err(not_stopped(drive, outcome.err().as_ref(), &end)),
    };
    let why = match (outcome, refused) {
        (Ok(End::Done(what)), None) => return reading.say(what, hiw),
        (Ok(End::Done(_)), Some(refused)) => refused.to_string(),
        (Ok(End::Interrupted), _) => "interrupted".into(),
        (Err(trouble), _) => trouble.to_string(),
    };
    Err(Failure::Other(format!("{why}; the drive stands, {}", at(&reading, hiw))))
}

fn at(reading: &Reading, hiw: i32) -> String {
    actual(reading.mode, reading.lengths, hiw)
}

/// What happens to a drive that was not seen to stand.
fn not_stopped<L: Link, C: Clock>(drive: &Drive<L, C>, outcome: Option<&Trouble>, end: &Trouble) -> Failure {
    if end.is_loss() {
        let watchdog = drive.session.settings().watchdog;
        // A lost line is lost for both; what came first says more.
        let why = outcome.unwrap_or(end);
        return Failure::Other(format!(
            "{why}; the drive did not report standstill: without this master its watchdog releases the motor within \
             {watchdog:?}, and the shaft coasts"
        ));
    }
    let first = outcome.map(|trouble| format!("{trouble}; ")).unwrap_or_default();
    Failure::Other(format!("{first}{end}; its motor is released now, a turning shaft coasts"))
}

/// How a motion that went well came to its end.
enum End {
    Done(&'static str),
    Interrupted,
}

/// Enables operation and does what is asked, until it is done or shall end.
fn turn<L: Link, C: Clock>(
    drive: &mut Drive<L, C>,
    motion: Motion,
    reading: &Reading,
) -> Result<End, Trouble> {
    let Reached::Done(_) = drive.reach(Goal::Enable)? else {
        return Ok(End::Interrupted);
    };
    let (goal, limit, held) = match motion {
        Motion::Enable { limit, .. } => (None, limit, "held enabled"),
        Motion::Jog { direction, limit, .. } => (Some(Goal::Jog(way(direction))), limit, "turned"),
        Motion::Velocity { rpm, limit, .. } => (Some(Goal::Velocity(rpm)), limit, "turned"),
        // Refused before: this is PROFIBUS.
        Motion::Home { .. } => return Ok(End::Interrupted),
        Motion::Move { position, .. } => {
            let position = position.position().map_err(Trouble::Ended)?;
            // Somebody else may have changed it while the drive was enabled.
            let now = lengths(drive)?;
            if now != reading.lengths {
                return Err(Trouble::Changed(format!(
                    "the spindle pitch (PNU {}) was changed meanwhile: positions are counted in {} now, expected {}; \
                     nothing was moved, give the command again",
                    Parameter::SpindlePitch.entry().pnu,
                    unit(Parameter::Limit1.entry(), now),
                    unit(Parameter::Limit1.entry(), reading.lengths)
                )));
            }
            return Ok(match drive.reach(Goal::MoveTo(position))? {
                Reached::Done(_) => End::Done("reached"),
                Reached::Interrupted => End::Interrupted,
            });
        }
    };
    let begun = drive.session.now();
    if let Some(goal) = goal
        && drive.reach(goal)? == Reached::Interrupted
    {
        return Ok(End::Done(held));
    }
    if !reading.json {
        reading.held(held)?;
    }
    // Inching comes to rest at a limit; an AG03 without its enable input stands with operation enabled.
    let must_turn = matches!(goal, Some(Goal::Jog(_)))
        || matches!(goal, Some(Goal::Velocity(rpm)) if rpm.unsigned_abs() > 1);
    loop {
        let ended = limit.is_some_and(|limit| drive.session.now().saturating_since(begun) >= limit);
        if drive.is_stopped() || ended {
            return Ok(End::Done(held));
        }
        let Seen { zsw, .. } = drive.exchange()?;
        if !ZswBit::OperationEnabled.is_set(zsw) || must_turn && ZswBit::Standstill.is_set(zsw) {
            return Err(Trouble::Ended(said(reading.mode, zsw.raw(), zsw.raw())));
        }
    }
}

/// A drive that stands.
struct Rest {
    hiw: i32,
    /// What it says against disabling operation: it stands all the same, with a fault latched, say.
    refused: Option<GoalError>,
}

/// Brakes with maximum deceleration and waits until the drive stands. A second Ctrl-C ends the wait.
fn wind_down<L: Link, C: Clock>(drive: &mut Drive<L, C>) -> Result<Rest, Trouble> {
    drive.session.stop().clear();
    match drive.reach(Goal::Disable) {
        Ok(Reached::Done(hiw)) => Ok(Rest { hiw, refused: None }),
        Ok(Reached::Interrupted) => {
            Err(Trouble::StillTurns("interrupted again while the drive brakes".into()))
        }
        // It goes on being asked for meanwhile.
        Err(DriveError::Goal(refused)) => Ok(Rest { hiw: run_out(drive)?, refused: Some(refused) }),
        Err(error) => Err(error.into()),
    }
}

/// Waits until the drive stands, whatever its state: with this actual value.
fn run_out<L: Link, C: Clock>(drive: &mut Drive<L, C>) -> Result<i32, Trouble> {
    let begun = drive.session.now();
    while travels(drive)? {
        if drive.is_stopped() {
            return Err(Trouble::StillTurns("interrupted; the shaft still coasts".into()));
        }
        if drive.session.now().saturating_since(begun) > RUN_OUT {
            return Err(Trouble::StillTurns(format!(
                "the drive still turns after {RUN_OUT:?}; switch its supply off"
            )));
        }
    }
    Ok(drive.exchange()?.hiw)
}

/// Brakes a drive that runs out, if it can be enabled, and waits until it stands in any case.
pub(super) fn stop<L: Link, C: Clock>(drive: &mut Drive<L, C>, json: bool) -> Result<(), Failure> {
    let reading = Reading::of(drive, json)?;
    let enabled = drive.reach(Goal::Enable);
    match enabled {
        Ok(Reached::Done(_) | Reached::Interrupted) => {
            wind_down(drive)?;
        }
        // A drive that cannot be enabled runs out.
        Err(DriveError::Goal(_)) => {}
        Err(trouble) => return Err(trouble.into()),
    }
    let hiw = run_out(drive)?;
    reading.say("the drive stands", hiw)
}

/// Acknowledges a fault and ends turn-on disabled.
pub(super) fn acknowledge<L: Link, C: Clock>(drive: &mut Drive<L, C>, json: bool) -> Result<(), Failure> {
    let reading = Reading::of(drive, json)?;
    match drive.reach(Goal::Acknowledge)? {
        Reached::Done(hiw) => reading.say("no fault is latched, operation can be enabled", hiw),
        Reached::Interrupted => Err(Failure::Other("interrupted".into())),
    }
}

#[cfg(test)]
mod tests {
    use crate::devices::ag03::drive::{Fault, Inputs};
    use crate::devices::ag03::param::{Model, Value, Width};
    use crate::master::SessionError;

    use super::*;
    use crate::command::args::Go;
    use crate::command::master::positioning::rig::{Cut, Rig};

    const GO: Go = Go { yes: true };
    const CONFIRMED: Confirmed = Confirmed::BY_TEST;

    fn ends(drive: &mut Drive<Rig, crate::bench::Port>, asked: Motion) -> String {
        match motion(drive, asked, CONFIRMED, false) {
            Err(Failure::Other(line) | Failure::Usage(line)) => line,
            Ok(()) => panic!("no failure"),
        }
    }

    #[test]
    fn a_spindle_pitch_that_was_changed_meanwhile_moves_nothing() {
        let rig = Rig::new(Model::Ag03_1);
        let mut drive = rig.drive();
        let checked =
            Reading { mode: Mode::Positioning, lengths: Lengths::HundredthMillimetres, json: false };
        let asked = Motion::Move { position: "8mm".parse().unwrap(), go: GO };
        let Err(trouble) = turn(&mut drive, asked, &checked) else { panic!("it was moved") };
        assert_eq!(
            trouble.to_string(),
            "the spindle pitch (PNU 1012) was changed meanwhile: positions are counted in inc now, expected 0.01 mm; \
             nothing was moved, give the command again"
        );
        assert_eq!(drive.exchange().unwrap().hiw, 0);
    }

    #[test]
    fn a_drive_with_a_latched_fault_is_seen_to_stand() {
        let rig = Rig::new(Model::Ag03_1);
        let mut drive = rig.drive();
        rig.set_inputs(Inputs::default().provoking(Fault::B));
        let blocked = ends(&mut drive, Motion::Move { position: "1000".parse().unwrap(), go: GO });
        assert!(blocked.contains("; the drive stands, position 0 inc"), "{blocked}");
        rig.set_inputs(Inputs::default());
        for asked in [
            Motion::Enable { go: GO, limit: Some(Duration::from_secs(1)) },
            Motion::Move { position: "0".parse().unwrap(), go: GO },
        ] {
            let line = ends(&mut drive, asked);
            assert!(line.contains("fault") && line.contains("; the drive stands, position 0 inc"), "{line}");
        }
        stop(&mut drive, false).unwrap();
    }

    #[test]
    fn a_drive_that_runs_out_with_a_fault_is_waited_for() {
        let mut turning = 0;
        for telegrams in (0..400).step_by(40) {
            let rig = Rig::new(Model::Ag03_1);
            let mut drive = rig.drive();
            rig.cut(telegrams, Cut::Heat);
            let line = ends(&mut drive, Motion::Move { position: "100000".parse().unwrap(), go: GO });
            assert!(line.contains("; the drive stands, position "), "{telegrams}: {line}");
            assert!(!rig.turns() && !rig.is_whole(), "{telegrams}: {line}");
            turning += usize::from(!line.contains("position 0 inc"));
        }
        assert!(turning > 3, "{turning}");
    }

    #[test]
    fn a_velocity_that_ends_because_the_enable_input_is_gone_is_said() {
        for model in Model::ALL {
            let rig = Rig::new(model);
            let mut drive = rig.drive();
            drive.write(Parameter::OperatingMode.entry().pnu, Value::Word(1)).unwrap();
            rig.cut(2000, Cut::Enable);
            let limit = Some(Duration::from_secs(60));
            let line = ends(&mut drive, Motion::Velocity { rpm: 60, go: GO, limit });
            assert!(line.contains("; the drive stands"), "{model:?}: {line}");
        }
    }

    #[test]
    fn a_link_that_has_failed_is_not_waited_for() {
        let rig = Rig::new(Model::Ag03_1);
        let mut drive = rig.drive();
        rig.cut(20, Cut::Link);
        let pnu = Parameter::OperatingMode.entry().pnu;
        while drive.read(pnu, None, Width::Word).is_ok() {}
        let (lost, cycle) = (rig.now(), drive.session.settings().cycle);
        let error = drive.session.release().unwrap_err();
        assert!(matches!(error, SessionError::Link(_)), "{error}");
        let waited = rig.now().saturating_since(lost);
        assert!(waited <= cycle, "no more than until the next exchange is due: {waited:?}");
    }

    #[test]
    fn a_lost_line_is_said_with_what_the_drive_does_then() {
        let rig = Rig::new(Model::Ag03_1);
        let mut drive = rig.drive();
        rig.cut(200, Cut::Answers);
        let line = ends(&mut drive, Motion::Move { position: "100000".parse().unwrap(), go: GO });
        assert!(line.contains("its watchdog releases the motor within 1s, and the shaft coasts"), "{line}");
    }
}
