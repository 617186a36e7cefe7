//! The command `profidrive`: emulated PROFIBUS-DP drives to test masters against.

mod command;

use std::process::ExitCode;

fn main() -> ExitCode {
    command::main()
}
