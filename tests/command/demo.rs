//! `profidrive demo`, run as a process.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::process::{Command, Stdio};

fn demo() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_profidrive"));
    command.arg("demo").env_remove("RUST_LOG").stdin(Stdio::null());
    command
}

#[test]
fn the_demo_ends_well_and_says_nothing_on_stderr() {
    let output = demo().output().unwrap();
    assert_eq!(String::from_utf8(output.stderr).unwrap(), "");
    assert_eq!(output.status.code(), Some(0));
    assert!(String::from_utf8(output.stdout).unwrap().ends_with("profidrive emulate --help.\n"));
}

#[test]
fn a_reader_who_leaves_early_is_no_failure() {
    let mut process = demo().stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(process.stdout.take());
    let output = process.wait_with_output().unwrap();
    assert_eq!(String::from_utf8(output.stderr).unwrap(), "");
    assert_eq!(output.status.code(), Some(0));
}

#[test]
fn the_demo_takes_no_arguments() {
    let output = demo().arg("5").output().unwrap();
    assert_eq!(output.status.code(), Some(2));
}
