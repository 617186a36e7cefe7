//! What somebody confirms before anything is sent.

use std::io::{self, BufRead, IsTerminal, Write};

use super::positioning;
use crate::command::Failure;
use crate::command::args::{Action, Direction, Master, Motion};

/// Kinds of commands that somebody has to confirm.
const TURNS: &str = "can turn a shaft";
const REPLACES: &str = "replaces what the drive keeps";

/// Somebody has confirmed that a shaft may turn; also for commands that turn none.
#[derive(Clone, Copy, Debug)]
pub(super) struct Confirmed(());

/// Asks for confirmation, before anything is sent.
pub(super) fn confirm(args: &Master) -> Result<Confirmed, Failure> {
    if let Action::Write { parameter, value, sure } = &args.action
        && args.can_place().is_none()
        && args.ppo.is_none()
        && let Some(question) = positioning::replaces(parameter, *value)
    {
        return ask(args, sure.yes, REPLACES, &question);
    }
    if let Action::Calibrate { sure, .. } = &args.action {
        return ask(args, sure.yes, REPLACES, "get another zero point. Continue?");
    }
    let Action::Motion(motion) = &args.action else { return Ok(Confirmed(())) };
    let (go, what) = match motion {
        Motion::Enable { go, .. } => (go, "enable its motor".into()),
        Motion::Home { go } => (go, "search its home position".into()),
        Motion::Move { go, position } => {
            position.position().map_err(Failure::Usage)?;
            if args.can_place().is_some() {
                position.plain().map_err(Failure::Usage)?;
            }
            (go, format!("travel to {position}"))
        }
        Motion::Jog { go, direction, .. } => {
            let way = match direction {
                Direction::Positive => "positive",
                Direction::Negative => "negative",
            };
            (go, format!("turn in {way} direction"))
        }
        Motion::Velocity { go, rpm, .. } => {
            // How fast another drive turns its parameters say.
            if args.ppo.is_none() {
                positioning::check_velocity(*rpm)?;
            }
            (go, format!("turn with {rpm} rpm"))
        }
    };
    ask(args, go.yes, TURNS, &format!("{what}. Are all people away from it?"))
}

fn ask(args: &Master, yes: bool, kind: &str, what: &str) -> Result<Confirmed, Failure> {
    if yes {
        return Ok(Confirmed(()));
    }
    if !io::stdin().is_terminal() || !io::stderr().is_terminal() {
        return Err(Failure::Usage(format!(
            "a command that {kind} needs --yes, or a terminal at which you confirm it"
        )));
    }
    let number = match args.node {
        Some(node) => node.number(),
        None => args.drive().map_err(Failure::Usage)?.number(),
    };
    let asked = write!(io::stderr(), "Drive {number} will {what} [y/N] ");
    let mut answer = String::new();
    let answered = asked.and_then(|()| io::stdin().lock().read_line(&mut answer));
    match (answered, answer.trim()) {
        (Ok(_), "y" | "Y" | "yes" | "Yes") => Ok(Confirmed(())),
        (Ok(_) | Err(_), _) => Err(Failure::Other("not confirmed; nothing was done".into())),
    }
}

#[cfg(test)]
impl Confirmed {
    /// A test is sure.
    pub(super) const BY_TEST: Self = Self(());
}
