//! Owners, devices and FIFOs of Unix.

use std::fs::{File, Metadata, OpenOptions};
use std::io::{self, Write};
use std::os::unix::fs::{FileTypeExt, MetadataExt, OpenOptionsExt, fchown};
use std::path::Path;

use rustix::fs::OFlags;

/// Gives the new file the owner and the permissions of the old one.
pub(super) fn keep(part: &File, before: &Metadata) -> io::Result<()> {
    let now = part.metadata()?;
    if (now.uid(), now.gid()) != (before.uid(), before.gid()) {
        // Only root can give a file away: somebody else who may write it owns the new one.
        let _ = fchown(part, Some(before.uid()), Some(before.gid()));
    }
    part.set_permissions(before.permissions())
}

/// Writes into a device or a FIFO.
pub(super) fn write_to_device(file: &Path, text: &str, found: &Metadata) -> io::Result<()> {
    let fifo = found.file_type().is_fifo();
    // To open a FIFO nobody reads would wait for ever and ignore Ctrl-C.
    let flags = OFlags::NOCTTY | OFlags::NONBLOCK;
    let opened = OpenOptions::new().write(true).custom_flags(flags.bits().cast_signed()).open(file);
    let mut file = opened.map_err(|error| match rustix::io::Errno::from_io_error(&error) {
        Some(rustix::io::Errno::NXIO) if fifo => io::Error::other("nobody reads this FIFO"),
        _ => error,
    })?;
    if !fifo {
        rustix::io::ioctl_fionbio(&file, false)?;
    }
    file.write_all(text.as_bytes())
}
