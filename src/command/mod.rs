//! The command: arguments in, one line per failure out.

mod args;
mod decode;
mod demo;
mod device_file;
mod eds;
mod emulate;
mod encode;
mod gsd;
#[cfg(feature = "judge")]
mod judge;
mod line_file;
mod log;
#[cfg(feature = "manual")]
mod manual;
mod master;
mod signals;

use core::error::Error;
use std::io::{self, Write};
use std::process::ExitCode;

use args::{Args, Command};

/// Why the command ends without success, in one line that says what to do.
#[derive(Debug)]
pub(crate) enum Failure {
    /// The command line asks for something that cannot be: exit code 2.
    Usage(String),
    /// It was asked for correctly but did not work: exit code 1.
    Other(String),
}

impl Failure {
    /// An error and its causes in one line.
    pub(crate) fn from_error(error: &dyn Error) -> Self {
        let mut line = error.to_string();
        let mut cause = error.source();
        while let Some(error) = cause {
            line.push_str(": ");
            line.push_str(&error.to_string());
            cause = error.source();
        }
        Self::Other(line)
    }

    /// What it says.
    pub(crate) fn into_line(self) -> String {
        match self {
            Self::Usage(line) | Self::Other(line) => line,
        }
    }
}

/// Runs the command with the arguments of this process. Never panics; what goes wrong is one line on stderr, and the exit
/// status says whose fault it is.
pub fn main() -> ExitCode {
    let args = match Args::from_command_line() {
        Ok(args) => args,
        Err(refusal) => return refusal.print(),
    };
    let json = args.wants_json();
    let log = log::start(args.log_verbosity());
    let outcome = match args.command {
        Command::Demo(args) => demo::demo(&args),
        Command::Try(tried) => match tried.emulate() {
            Ok(emulate) => emulate::emulate(emulate),
            Err(words) => Err(Failure::Usage(words)),
        },
        Command::Emulate(emulate) => emulate::emulate(emulate),
        Command::Master(master) => master::master(&master),
        Command::Decode(args) => decode::decode(&args),
        Command::Eds(args) => eds::eds(&args),
        Command::Encode(args) => encode::encode(&args),
        Command::Gsd(args) => gsd::gsd(&args),
        #[cfg(feature = "manual")]
        Command::Completions(args) => manual::completions(args),
        #[cfg(feature = "manual")]
        Command::Man(args) => manual::man(&args),
        #[cfg(feature = "judge")]
        Command::Judge(args) => {
            let outcome = judge::judge(&args);
            log.finish();
            return outcome.unwrap_or_else(|failure| report_as(&failure, json, judge::BROKEN));
        }
        #[cfg(not(feature = "judge"))]
        Command::Judge(args) => args.check().map_err(Failure::Usage),
    };
    // What was logged comes before the line that says how it ended.
    log.finish();
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => report(&failure, json),
    }
}

/// Prints the one line, for programs that read JSON an object on stdout too, and says the exit code.
pub(crate) fn report(failure: &Failure, json: bool) -> ExitCode {
    report_as(failure, json, 1)
}

/// The same, with the exit code of what is no error of the command line.
fn report_as(failure: &Failure, json: bool, other: u8) -> ExitCode {
    let (line, code): (_, u8) = match failure {
        Failure::Usage(line) => (line, 2),
        Failure::Other(line) => (line, other),
    };
    // Paths and arguments may hold line breaks; nobody is left to tell if this fails.
    let line: String = line.chars().map(|c| if c.is_control() { '?' } else { c }).collect();
    let _ = writeln!(io::stderr(), "profidrive: {line}");
    if json {
        let _ = writeln!(io::stdout(), "{}", serde_json::json!({ "error": line, "exit_code": code }));
    }
    ExitCode::from(code)
}
