//! What `gsd` and `eds` say of any device file.

use std::io::{self, Write};
use std::path::Path;

use serde_json::{Value, json};

use super::Failure;
use crate::device_file::{Hint, Level};

/// What became of printing, and of the command.
pub(super) type Said = (io::Result<()>, Result<(), Failure>);

/// Prints to stdout, and says what became of the command.
pub(super) fn print(say: impl FnOnce(&mut dyn Write) -> Result<Said, Failure>) -> Result<(), Failure> {
    let mut out = io::BufWriter::new(io::stdout().lock());
    let (said, outcome) = say(&mut out)?;
    match said.and_then(|()| out.flush()) {
        // Whoever asked has closed the pipe after the first lines (`| head`).
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => outcome,
        Err(error) => Err(Failure::from_error(&error)),
        Ok(()) => outcome,
    }
}

/// Lists what is odd in a file, for its author; a failure if something is to be corrected.
pub(super) fn check(out: &mut dyn Write, file: &Path, hints: &[Hint]) -> Said {
    let said = hints.iter().try_for_each(|hint| writeln!(out, "{}: {hint}", file.display()));
    let outcome = match warnings(hints) {
        0 => Ok(()),
        1 => Err(Failure::Other(format!("{}: 1 warning", file.display()))),
        more => Err(Failure::Other(format!("{}: {more} warnings", file.display()))),
    };
    (said, outcome)
}

/// How many of them are to be corrected.
pub(super) fn warnings(hints: &[Hint]) -> usize {
    hints.iter().filter(|hint| hint.level == Level::Warning).count()
}

/// A file is missing on the command line.
pub(super) fn missing(command: &str) -> Failure {
    Failure::Usage(format!("a file is missing; see 'profidrive {command} --help'"))
}

/// What is odd, for programs.
pub(super) fn hints_json(hints: &[Hint]) -> Value {
    let one = |hint: &Hint| json!({ "line": hint.place.line, "column": hint.place.column, "warning": hint.level == Level::Warning, "text": hint.text });
    hints.iter().map(one).collect()
}
