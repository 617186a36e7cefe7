//! Device files from the disk.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

#[cfg(feature = "eds")]
use crate::eds::{self, Eds};
use crate::gsd::{self, Gsd};

/// A GSD, read.
///
/// # Errors
/// What is wrong with it, with its name.
pub(crate) fn gsd_of_file(file: &Path) -> Result<Gsd, String> {
    let octets = octets(file, gsd::MAX_FILE_LEN)?;
    let read = octets.map_err(|got| gsd::ReadError::TooLong { got }).and_then(|octets| Gsd::read(&octets));
    read.map_err(|error| format!("{}: {error}", file.display()))
}

/// An EDS, a DCF, an XDD or an XDC, read.
///
/// # Errors
/// What is wrong with it, with its name.
#[cfg(feature = "eds")]
pub(crate) fn eds_of_file(file: &Path) -> Result<Eds, String> {
    let octets = eds_octets_of_file(file)?;
    Eds::read(&octets).map_err(|error| format!("{}: {error}", file.display()))
}

/// The most octets of a domain.
#[cfg(feature = "eds")]
const MOST_DOMAIN: usize = 1 << 20;

/// The octets of one.
///
/// # Errors
/// As of [`eds_of_file`].
#[cfg(feature = "eds")]
pub(super) fn eds_octets_of_file(file: &Path) -> Result<Vec<u8>, String> {
    let octets = octets(file, eds::MAX_FILE_LEN)?;
    octets.map_err(|got| format!("{}: {}", file.display(), eds::ReadError::TooLong { got }))
}

/// The contents of a domain.
///
/// # Errors
/// What is wrong with the file, with its name.
#[cfg(feature = "eds")]
pub(super) fn domain_of_file(file: &Path) -> Result<Vec<u8>, String> {
    let octets = octets(file, MOST_DOMAIN)?;
    octets.map_err(|got| format!("{} has {got} octets, expected at most {MOST_DOMAIN}", file.display()))
}

/// The octets of a file, or how many it has if they are more than `most`: a terminal or a device may have no end.
fn octets(file: &Path, most: usize) -> Result<Result<Vec<u8>, usize>, String> {
    let read = || -> io::Result<_> {
        let file = File::open(file)?;
        let len = usize::try_from(file.metadata()?.len()).unwrap_or(usize::MAX);
        if len > most {
            return Ok(Err(len));
        }
        let mut octets = Vec::new();
        file.take(u64::try_from(most).unwrap_or(u64::MAX).saturating_add(1)).read_to_end(&mut octets)?;
        Ok(Ok(octets))
    };
    read().map_err(|error| format!("cannot read {}: {error}", file.display()))
}
