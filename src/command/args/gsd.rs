//! `profidrive gsd`: which file, in which form.

use std::path::PathBuf;

/// Explains the device file (GSD) of a PROFIBUS-DP slave: identity, modules, parameters, and what is unusual in it
#[derive(Debug, clap::Args)]
#[command(
    args_conflicts_with_subcommands = true,
    arg_required_else_help = true,
    after_help = "Examples:\n  profidrive gsd valves.gsd\n  profidrive gsd --json valves.gsd\n  profidrive gsd check valves.gsd"
)]
pub(crate) struct Gsd {
    /// The file
    #[arg(required = true)]
    pub(crate) file: Option<PathBuf>,

    /// One JSON object
    #[arg(long)]
    pub(crate) json: bool,

    #[command(subcommand)]
    pub(crate) check: Option<Check>,
}

#[derive(Debug, clap::Subcommand)]
pub(crate) enum Check {
    /// For authors of device files: says what is wrong or unusual, with line and column; exit code 1 if there is anything
    #[command(after_help = "Example:\n  profidrive gsd check valves.gsd")]
    Check {
        /// The file
        file: PathBuf,
    },
}
