//! The command `profidrive`: emulated PROFIBUS-DP drives to test masters against.

use std::process::ExitCode;

fn main() -> ExitCode {
    profidrive::command::main()
}
