//! `profidrive eds`: the data sheet of a device on stdout.

use std::io::{self, Write};

use super::Failure;
use super::args::Eds;

/// Prints it.
pub(crate) fn eds(args: &Eds) -> Result<(), Failure> {
    match io::stdout().lock().write_all(args.device.eds().as_bytes()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::Other(format!("cannot write to stdout: {error}")))
        }
        Ok(()) | Err(_) => Ok(()),
    }
}
