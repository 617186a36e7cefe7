//! Files of Windows: a new one has the rights of its folder, and devices are written like files.

use std::fs::{File, Metadata, OpenOptions};
use std::io::{self, Write};
use std::path::Path;

/// There is nothing to keep: a read-only file is not replaced.
pub(super) fn keep(_: &File, _: &Metadata) -> io::Result<()> {
    Ok(())
}

/// Writes into a device.
pub(super) fn write_to_device(file: &Path, text: &str, _: &Metadata) -> io::Result<()> {
    OpenOptions::new().write(true).open(file)?.write_all(text.as_bytes())
}
