//! What makes a file useless.

use thiserror::Error;

use super::{MAX_ENTRIES, MAX_FILE_LEN};
use crate::device_file::Place;

/// Why a file is no EDS of a CANopen node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ReadError {
    /// More octets than any EDS has.
    #[error("line 1, column 1: the file has {got} octets, expected at most {MAX_FILE_LEN}: this is no EDS")]
    TooLong {
        /// Octets of the file.
        got: usize,
    },
    /// UTF-16.
    #[error(
        "line 1, column 1: the file is UTF-16, expected one octet a character: save it as ASCII or UTF-8"
    )]
    Utf16,
    /// Nothing but blanks.
    #[error("line 1, column 1: the file is empty")]
    Empty,
    /// `#Profibus_DP`.
    #[error(
        "line 1, column 1: this is a GSD of a PROFIBUS slave, no EDS: use it with --station ADDRESS,gsd=FILE"
    )]
    Gsd,
    /// The sections of another bus.
    #[error("{place}: this is an EDS of EtherNet/IP or DeviceNet, not of CANopen")]
    OtherBus {
        /// Its section `[Device Classification]` or `[Params]`.
        place: Place,
    },
    /// XML with a mistake.
    #[error("{place}: the file begins as XML and is none from here on")]
    Xml {
        /// Where it ends.
        place: Place,
    },
    /// XML of something else.
    #[error("{place}: XML without a CANopenObject: this is no XDD of a CANopen node")]
    OtherXml {
        /// Its root element.
        place: Place,
    },
    /// No line `[section]`.
    #[error("line 1, column 1: no line with a [section]: this is no EDS")]
    NoSection,
    /// No section of an object.
    #[error("line 1, column 1: no section of an object, such as [1000]: this is no EDS of a CANopen node")]
    NoObject,
    /// More entries than any device has.
    #[error("{place}: more than {MAX_ENTRIES} entries: this is no EDS of a device")]
    TooManyEntries {
        /// The object with the first too many.
        place: Place,
    },
}
