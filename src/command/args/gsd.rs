//! `profidrive gsd`: which file, in which form.

use std::path::PathBuf;

/// Explains the device file (GSD) of a PROFIBUS-DP slave: identity, modules, parameters, and what is unusual in it
#[derive(Debug, clap::Args)]
#[command(
    args_conflicts_with_subcommands = true,
    arg_required_else_help = true,
    after_help = "Examples:\n  profidrive gsd valves.gsd\n  profidrive gsd --json valves.gsd\n  profidrive gsd io.gsd --list analog\n  profidrive gsd io.gsd --modules AI2,DO8 --set 1:Filter=3\n  profidrive gsd check valves.gsd"
)]
pub(crate) struct Gsd {
    /// The file
    #[arg(required = true)]
    pub(crate) file: Option<PathBuf>,

    /// One JSON object
    #[arg(long)]
    pub(crate) json: bool,

    /// Every module, parameter and text of the diagnosis, or those that contain TEXT
    #[arg(long, value_name = "TEXT", num_args = 0..=1, default_missing_value = "", conflicts_with = "modules")]
    pub(crate) list: Option<String>,

    /// Prints what a master sends for these modules, slot by slot: Chk_Cfg and the user parameters of Set_Prm
    #[arg(long, value_name = "NAME[,NAME..]")]
    pub(crate) modules: Vec<String>,

    /// With --modules: a parameter, by its text or number; SLOT: before the name where several modules have it
    #[arg(long, value_name = "[SLOT:]PARAMETER=TEXT", requires = "modules")]
    pub(crate) set: Vec<String>,

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
