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

#[cfg(test)]
mod tests {
    use crate::host::list::Device;

    /// Every octet of a data sheet comes from the rows of its device: a change of them is seen here.
    #[test]
    fn the_data_sheets_in_the_repository_are_those_of_the_rows() {
        for product in Device::products() {
            let file = format!("{}/tests/eds/{}.eds", env!("CARGO_MANIFEST_DIR"), product.name);
            let sheet = product.eds();
            if std::env::var_os("PROFIDRIVE_REWRITE").is_some() {
                std::fs::write(&file, &sheet).unwrap();
            }
            let kept = std::fs::read_to_string(&file).unwrap_or_default();
            let line = sheet.lines().zip(kept.lines()).find(|(is, was)| is != was);
            assert!(sheet == kept, "{file} differs at {line:?}; rewrite it with PROFIDRIVE_REWRITE=1");
        }
    }
}
