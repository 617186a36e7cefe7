//! What is asked of `profidrive completions` and `profidrive man`.

use std::path::PathBuf;

use clap_complete::Shell;

/// Prints the completion script of this command for a shell
#[derive(Clone, Copy, Debug, clap::Args)]
#[command(after_help = "\
Examples:
  profidrive completions bash > ~/.local/share/bash-completion/completions/profidrive
  profidrive completions powershell >> $PROFILE")]
pub(crate) struct Completions {
    /// The shell
    #[arg(value_enum)]
    pub(crate) shell: Shell,
}

/// Prints the manual page, or writes those of all commands
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "\
Examples:
  profidrive man | man -l -                   reads it
  profidrive man ~/.local/share/man/man1      writes profidrive.1, profidrive-emulate.1 and the others")]
pub(crate) struct Man {
    /// The folder for the pages of all commands; without it the page of profidrive is printed
    #[arg(value_name = "DIR")]
    pub(crate) folder: Option<PathBuf>,
}
