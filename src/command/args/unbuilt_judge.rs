//! `profidrive judge` of a program that was built without the feature `judge`.

use std::ffi::OsString;

/// Not in this program: it was built without the feature `judge`
///
/// With it: `cargo install --locked profidrive --features cli`, or `cargo run --features cli -- judge ...` in a
/// checkout.
#[derive(Debug, clap::Args)]
pub(crate) struct Judge {
    /// What is asked for, which only the judge understands.
    #[arg(hide = true, trailing_var_arg = true, allow_hyphen_values = true)]
    _arguments: Vec<OsString>,
}

impl Judge {
    /// # Errors
    /// Always: how to build the program with the judge.
    pub(crate) fn check(&self) -> Result<(), String> {
        Err("this program was built without the judge; build it with '--features cli'".into())
    }
}
