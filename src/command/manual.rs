//! `profidrive completions` and `profidrive man`: what a package installs beside the program.

use std::io::{self, Write};

use clap::CommandFactory;

use super::Failure;
use super::args::{Args, Completions, Man};

/// Prints what completes this command in a shell.
pub(crate) fn completions(args: Completions) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Args::command(), "profidrive", &mut script);
    print(&script)
}

/// Prints the page of the command, or writes those of all commands.
pub(crate) fn man(args: &Man) -> Result<(), Failure> {
    let Some(folder) = &args.folder else {
        let mut page = Vec::new();
        clap_mangen::Man::new(Args::command())
            .render(&mut page)
            .map_err(|error| Failure::from_error(&error))?;
        return print(&page);
    };
    clap_mangen::generate_to(Args::command(), folder)
        .map_err(|error| Failure::Other(format!("cannot write to {}: {error}", folder.display())))
}

/// Whoever reads it may have closed the pipe after the first lines: that is no failure.
fn print(text: &[u8]) -> Result<(), Failure> {
    match io::stdout().write_all(text) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::Other(format!("cannot write to stdout: {error}")))
        }
        Ok(()) | Err(_) => Ok(()),
    }
}
