//! What a drive can be asked, whichever bus it is on and whatever profile it has.

use core::time::Duration;
use std::path::Path;

use serde_json::json;

use super::confirm::Confirmed;
use super::say;
use crate::command::Failure;
use crate::command::args::{Action, Asked, Motion, Quantity};

/// A drive that this master has. What a kind of drive has not is refused with the arguments.
pub(super) trait Commissioned {
    /// Shows a parameter or an entry.
    fn read(&mut self, asked: &Asked, json: bool) -> Result<(), Failure>;
    /// Writes it and reads it back.
    fn write(&mut self, asked: &Asked, value: Quantity, json: bool) -> Result<(), Failure>;
    /// What the drive says of itself, and what keeps it from moving.
    fn status(&mut self, json: bool) -> Result<(), Failure>;
    /// The faults it keeps.
    fn faults(&mut self, clear: bool, json: bool) -> Result<(), Failure>;
    /// Acknowledges a fault.
    fn acknowledge(&mut self, json: bool) -> Result<(), Failure>;
    /// Lets it stand.
    fn stop(&mut self, json: bool) -> Result<(), Failure>;
    /// Does it, and leaves the drive standing.
    fn motion(&mut self, motion: Motion, leave: Confirmed, json: bool) -> Result<(), Failure>;

    /// Every parameter.
    fn params(&mut self, _json: bool) -> Result<(), Failure> {
        not_here()
    }

    /// Every setting into a file.
    fn save(&mut self, _file: &Path, _json: bool) -> Result<(), Failure> {
        not_here()
    }

    /// The settings of the file that was read.
    fn restore(&mut self, _dry_run: bool, _yes: bool, _json: bool) -> Result<(), Failure> {
        not_here()
    }

    /// Sets the position.
    fn calibrate(&mut self, _value: Option<Quantity>, _json: bool) -> Result<(), Failure> {
        not_here()
    }

    /// Shows what changes.
    fn monitor(&mut self, _limit: Option<Duration>, _json: bool) -> Result<(), Failure> {
        not_here()
    }
}

/// It has none.
pub(super) fn not_here() -> Result<(), Failure> {
    Err(Failure::Usage("this drive has no such command".into()))
}

/// Does what is asked of a drive.
pub(super) fn act(
    drive: &mut dyn Commissioned,
    action: &Action,
    leave: Confirmed,
    json: bool,
) -> Result<(), Failure> {
    match action {
        Action::Read { parameter } => drive.read(parameter, json),
        Action::Write { parameter, value, .. } => drive.write(parameter, *value, json),
        Action::Params => drive.params(json),
        Action::Save { file } => drive.save(file, json),
        Action::Restore { dry_run, yes, .. } => drive.restore(*dry_run, *yes, json),
        Action::Status => drive.status(json),
        Action::Monitor { limit } => drive.monitor(*limit, json),
        Action::Faults { clear } => drive.faults(*clear, json),
        Action::Ack => drive.acknowledge(json),
        Action::Calibrate { value, .. } => drive.calibrate(*value, json),
        Action::Stop => drive.stop(json),
        Action::Motion(motion) => drive.motion(*motion, leave, json),
        // These are asked of the line.
        Action::Scan { .. }
        | Action::Diag
        | Action::Record { .. }
        | Action::Alarms { .. }
        | Action::Param { .. }
        | Action::Im { .. } => not_here(),
    }
}

/// A value of a drive as it is shown.
pub(super) struct Shown {
    /// Where it is and what it is called.
    pub(super) head: String,
    pub(super) text: String,
    /// The number alone.
    pub(super) number: serde_json::Value,
    pub(super) json: serde_json::Value,
}

impl Shown {
    pub(super) fn say(&self, json: bool) -> Result<(), Failure> {
        if json { say(&self.json) } else { say(format_args!("{} {}", self.head, self.text)) }
    }

    /// With what it was before, and a note.
    pub(super) fn say_changed(mut self, before: &Self, note: &str, json: bool) -> Result<(), Failure> {
        if json {
            if let Some(fields) = self.json.as_object_mut() {
                fields.insert("before".into(), json!(before.number));
            }
        } else {
            self.text = format!("{}, was {}{note}", self.text, before.text);
        }
        self.say(json)
    }
}
