//! All settings of a drive at once: read, compared, written, read back.

use core::fmt;

use super::{Drive, DriveError, SessionError};
use crate::devices::ag03::param::{Access, Entry, Model, Value, parameters};
use crate::host::{Clock, Link};

/// A parameter that shall have another value.
#[derive(Clone, Copy, Debug)]
pub struct Change {
    /// The parameter.
    pub entry: &'static Entry,
    /// The value that the drive has.
    pub before: Value,
    /// The value that it shall have.
    pub after: Value,
}

/// What became of a change.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum WriteOutcome {
    /// The drive has confirmed it.
    Written,
    /// It was sent, and whether the drive has taken it is not known.
    Unconfirmed,
    /// The drive refused it, with this reason.
    Refused(String),
    /// It was not sent.
    NotWritten,
}

impl fmt::Display for WriteOutcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Written => "written",
            Self::Unconfirmed => "not confirmed",
            Self::Refused(_) => "refused",
            Self::NotWritten => "not written",
        })
    }
}

/// What became of a set of changes.
#[derive(Clone, Debug, Default)]
pub struct Restored {
    /// Each change. Behind the first that was not written nothing was.
    pub outcomes: Vec<(Change, WriteOutcome)>,
    /// Everything was read back and is in the drive.
    pub verified: bool,
    /// What came between.
    pub trouble: Option<String>,
}

/// Parameters with the values they shall have, [`Entry::number`] of them.
pub(crate) type Wanted = [(&'static Entry, i32)];

impl<L: Link, C: Clock> Drive<L, C> {
    /// Reads every parameter of this model that can be written: what is to be saved. `step` is called after each.
    ///
    /// # Errors
    /// As [`Drive::job`], and [`SessionError::Stopped`] if the end is requested.
    pub fn settings(
        &mut self,
        model: Model,
        step: &mut dyn FnMut(),
    ) -> Result<Vec<(&'static Entry, Value)>, DriveError> {
        let settings = parameters(model).filter(|entry| entry.access() == Access::ReadWrite);
        settings.map(|entry| Ok((entry, self.read_entry(entry, step)?))).collect()
    }

    /// Reads the parameters of `wanted` and says what the drive has of each, in the same order.
    ///
    /// # Errors
    /// As [`Drive::settings`].
    pub(crate) fn read_wanted(
        &mut self,
        wanted: &Wanted,
        step: &mut dyn FnMut(),
    ) -> Result<Vec<Value>, DriveError> {
        wanted.iter().map(|(entry, _)| self.read_entry(entry, step)).collect()
    }

    /// Gives the drive the values of `wanted`: reads, writes what differs, reads back. It must stand still, as some
    /// parameters take no value while the shaft turns.
    ///
    /// # Errors
    /// As [`Drive::settings`], before anything is written. What comes later is in [`Restored`].
    pub fn restore(&mut self, wanted: &Wanted) -> Result<Restored, DriveError> {
        let found = self.read_wanted(wanted, &mut || {})?;
        let mut restored = self.write_changes(changes(wanted, &found), &mut || {});
        self.verify(wanted, &mut restored, &mut || {});
        Ok(restored)
    }

    /// Writes until all of it is done or something comes between, the end requested included.
    pub(crate) fn write_changes(&mut self, changes: Vec<Change>, step: &mut dyn FnMut()) -> Restored {
        let mut restored = Restored::default();
        for change in changes {
            if restored.trouble.is_none() && self.is_stopped() {
                restored.trouble = Some(SessionError::Stopped.to_string());
            }
            let outcome = if restored.trouble.is_some() {
                WriteOutcome::NotWritten
            } else {
                let written = self.write(change.entry.pnu, change.after);
                restored.trouble = written.as_ref().err().map(ToString::to_string);
                step();
                outcome_of(&written)
            };
            restored.outcomes.push((change, outcome));
        }
        restored
    }

    /// Reads back all of `wanted`, unless there was trouble before.
    pub(crate) fn verify(&mut self, wanted: &Wanted, restored: &mut Restored, step: &mut dyn FnMut()) {
        if restored.trouble.is_some() {
            return;
        }
        for (entry, value) in wanted {
            let trouble = match self.read_entry(entry, step) {
                Ok(found) if found == Value::of(entry.width, *value) => None,
                Ok(found) => {
                    let (name, pnu, found) = (entry.name, entry.pnu, entry.number(found));
                    Some(format!("{name} (PNU {pnu}) reads back as {found} instead of {value}"))
                }
                Err(error) => Some(format!("{error}, while reading back")),
            };
            if trouble.is_some() {
                restored.trouble = trouble;
                return;
            }
        }
        restored.verified = true;
    }

    fn read_entry(&mut self, entry: &'static Entry, step: &mut dyn FnMut()) -> Result<Value, DriveError> {
        if self.is_stopped() {
            return Err(SessionError::Stopped.into());
        }
        let value = self.read(entry.pnu, None, entry.width)?;
        step();
        Ok(value)
    }
}

/// What differs between `wanted` and what was `found` of each.
pub fn changes(wanted: &Wanted, found: &[Value]) -> Vec<Change> {
    let changes = wanted.iter().zip(found).map(|((entry, value), before)| Change {
        entry,
        before: *before,
        after: Value::of(entry.width, *value),
    });
    changes.filter(|change| change.before != change.after).collect()
}

fn outcome_of(written: &Result<Value, DriveError>) -> WriteOutcome {
    match written {
        Ok(_) => WriteOutcome::Written,
        Err(DriveError::Job(error)) if error.is_certain() => WriteOutcome::Refused(error.to_string()),
        Err(DriveError::Job(_) | DriveError::Unanswered(_) | DriveError::OtherReply { .. }) => {
            WriteOutcome::Unconfirmed
        }
        Err(
            DriveError::Session(_)
            | DriveError::NotSubmitted(_)
            | DriveError::Goal(_)
            | DriveError::Hardware(_),
        ) => WriteOutcome::NotWritten,
    }
}
