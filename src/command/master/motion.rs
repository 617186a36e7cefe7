//! `enable`, `move`, `jog`, `velocity`, `stop`, `ack`: what a drive does, and how it ends.
//!
//! Whatever ends a command that lets the shaft turn (its goal, its time, Ctrl-C, a signal, a refusal), operation is
//! disabled before: the drive brakes with maximum deceleration, and only then is let go. If the line is lost, the drive's
//! own watchdog lets the motor go.

use core::time::Duration;
use std::io::{self, BufRead, IsTerminal, Write};

use profidrive::client::Goal;
use profidrive::drive::{Direction as Way, Mode};
use profidrive::explain::value::Lengths;
use profidrive::explain::words::said;
use profidrive::host::{Clock, Link};
use profidrive::param::{Gear, Width};
use serde_json::json;

use super::drive::{Drive, Reached, Seen, Trouble};
use super::say;
use super::status::{SSW, actual, mode};
use super::value::lengths;
use crate::command::Failure;
use crate::command::args::{Action, Direction, Go, Master, Motion};

/// Bits of ZSW.
const OPERATION_ENABLED: u8 = 2;
const STANDSTILL: u8 = 13;
/// Bit of SSW.
const TRAVELS: u32 = 1 << 4;

/// How long a drive that runs out is waited for.
const RUN_OUT: Duration = Duration::from_secs(30);

/// Leave to let a shaft turn; also of commands that need none.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leave(());

/// Asks for leave, before anything is sent.
pub(super) fn leave(args: &Master) -> Result<Leave, Failure> {
    let Action::Motion(motion) = &args.action else {
        return Ok(Leave(()));
    };
    let (go, what) = match motion {
        Motion::Enable { go, .. } => (go, "take its motor into control".into()),
        Motion::Move { go, position, .. } => (go, format!("travel to {position}")),
        Motion::Jog { go, direction, .. } => (go, format!("turn in {} direction", way(*direction))),
        Motion::Velocity { go, rpm, .. } => {
            let fastest = i32::from(Gear::Ratio24.max_rpm());
            if rpm.abs() > fastest {
                return Err(Failure::Usage(format!(
                    "a drive turns with at most {fastest} rpm, got {rpm}; see 'profidrive master velocity --help'"
                )));
            }
            (go, format!("turn with {rpm} rpm"))
        }
    };
    let Go { yes } = go;
    if *yes {
        return Ok(Leave(()));
    }
    if !io::stdin().is_terminal() || !io::stderr().is_terminal() {
        return Err(Failure::Usage(
            "a command that can turn a shaft needs --yes, or somebody at a terminal who confirms it".into(),
        ));
    }
    let address = args.address.unwrap_or(args.master_address);
    let asked = write!(io::stderr(), "Drive {address} will {what}. Is everybody out of reach? [y/N] ");
    let mut answer = String::new();
    let answered = asked.and_then(|()| io::stdin().lock().read_line(&mut answer));
    match (answered, answer.trim()) {
        (Ok(_), "y" | "Y" | "yes" | "Yes") => Ok(Leave(())),
        (Ok(_) | Err(_), _) => Err(Failure::Other("not confirmed; nothing was done".into())),
    }
}

fn way(direction: Direction) -> Way {
    match direction {
        Direction::Positive => Way::Positive,
        Direction::Negative => Way::Negative,
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
    _: Leave,
    json: bool,
) -> Result<(), Failure> {
    let reading = Reading::of(drive, json)?;
    let outcome = turn(drive, motion, &reading);
    let ended = wind_down(drive);
    match (outcome, ended) {
        (Ok(End::Done(what)), Ok(hiw)) => reading.say(what, hiw),
        (Ok(End::Interrupted), Ok(hiw)) => {
            Err(Failure::Other(format!("interrupted; the drive stands, {}", at(&reading, hiw))))
        }
        (Err(trouble), Ok(hiw)) => {
            Err(Failure::Other(format!("{trouble}; the drive stands, {}", at(&reading, hiw))))
        }
        (Ok(_), Err(end)) => Err(not_stopped(drive, &end.to_string())),
        // A lost line is lost for both.
        (Err(trouble), Err(_)) => Err(not_stopped(drive, &trouble.to_string())),
    }
}

fn at(reading: &Reading, hiw: i32) -> String {
    actual(reading.mode, reading.lengths, hiw)
}

/// What happens to a drive that could not be stopped.
fn not_stopped<L: Link, C: Clock>(drive: &Drive<L, C>, why: &str) -> Failure {
    let watchdog = drive.session.settings().watchdog;
    Failure::Other(format!(
        "{why}; the drive was not seen to stand: without this master its watchdog lets the motor go within \
         {watchdog:?}, and it runs out"
    ))
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
        Motion::Move { position, .. } => {
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
    // Only inching can come to rest by itself, at a limit.
    let must_turn = matches!(goal, Some(Goal::Jog(_)));
    loop {
        let ended = limit.is_some_and(|limit| drive.session.now().saturating_since(begun) >= limit);
        if drive.is_stopped() || ended {
            return Ok(End::Done(held));
        }
        let Seen { zsw, .. } = drive.exchange()?;
        if !zsw.bit(OPERATION_ENABLED) || must_turn && zsw.bit(STANDSTILL) {
            return Err(Trouble::Ended(said(reading.mode, zsw.raw(), zsw.raw())));
        }
    }
}

/// Brakes with maximum deceleration and waits until the drive stands. A second Ctrl-C ends the wait.
fn wind_down<L: Link, C: Clock>(drive: &mut Drive<L, C>) -> Result<i32, Trouble> {
    drive.session.stop().clear();
    match drive.reach(Goal::Disable)? {
        Reached::Done(hiw) => Ok(hiw),
        Reached::Interrupted => Err(Trouble::Ended("interrupted again while the drive brakes".into())),
    }
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
        Err(Trouble::Goal(_)) => {}
        Err(trouble) => return Err(trouble.into()),
    }
    let begun = drive.session.now();
    while drive.read(SSW, None, Width::Word)?.bits() & TRAVELS != 0 {
        if drive.is_stopped() {
            return Err(Failure::Other("interrupted; the drive still runs out".into()));
        }
        if drive.session.now().saturating_since(begun) > RUN_OUT {
            return Err(Failure::Other(format!(
                "the drive still turns after {RUN_OUT:?}; switch its supply off"
            )));
        }
    }
    let Seen { hiw, .. } = drive.exchange()?;
    reading.say("the drive stands", hiw)
}

/// Acknowledges a fault and ends turn-on disabled.
pub(super) fn acknowledge<L: Link, C: Clock>(drive: &mut Drive<L, C>, json: bool) -> Result<(), Failure> {
    let reading = Reading::of(drive, json)?;
    match drive.reach(Goal::Acknowledge)? {
        Reached::Done(hiw) => reading.say("no fault is latched, ready to be enabled", hiw),
        Reached::Interrupted => Err(Failure::Other("interrupted".into())),
    }
}
