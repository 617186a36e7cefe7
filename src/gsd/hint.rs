//! What makes a file useless.

use thiserror::Error;

pub use crate::device_file::{Hint, Level, Place, did_you_mean};

/// Why a file is no GSD of a DP slave.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ReadError {
    /// More octets than any GSD has.
    #[error("line 1, column 1: the file has {got} octets, expected at most {most}: this is no GSD", most = super::MAX_FILE_LEN)]
    TooLong {
        /// Octets of the file.
        got: usize,
    },
    /// UTF-16.
    #[error(
        "line 1, column 1: the file is UTF-16, expected one octet a character: save it as ANSI (CP1252) or UTF-8"
    )]
    Utf16,
    /// No line `#Profibus_DP`.
    #[error("line 1, column 1: no line '#Profibus_DP': this is no GSD, or its first line is missing")]
    NoHeader,
    /// It is the data sheet of a CANopen node.
    #[error("line 1, column 1: this is an EDS of a CANopen node, no GSD: use it with --node ID,eds=FILE")]
    IsEds,
    /// Ident_Number is absent or no number of 16 bits.
    #[error(
        "{place}: no Ident_Number of 16 bits: add the one of the device, for example Ident_Number = 0x0ABC"
    )]
    NoIdent {
        /// The wrong line, or the header if there is none.
        place: Place,
    },
    /// Protocol_Ident or Station_Type is not 0.
    #[error("{place}: {keyword} is {got}, expected 0: this file describes no slave of PROFIBUS-DP")]
    NotDpSlave {
        /// Where.
        place: Place,
        /// Protocol_Ident or Station_Type.
        keyword: &'static str,
        /// Its value.
        got: i64,
    },
    /// Station_Type is not 1.
    #[error("{place}: Station_Type is {got}, expected 1: this file describes no master of PROFIBUS-DP")]
    NotDpMaster {
        /// Where, or the header if it is missing.
        place: Place,
        /// Its value.
        got: i64,
    },
    /// There are modules, and the identifiers of none can be read.
    #[error(
        "{place}: the identifiers of module '{name}' are incomplete, and no other module is left: correct them"
    )]
    NoModuleLeft {
        /// The first of them.
        place: Place,
        /// Its name.
        name: String,
    },
    /// More modules than any GSD has.
    #[error("{place}: more than {most} modules: this is no GSD of a device", most = super::MAX_MODULES)]
    TooManyModules {
        /// The first too many.
        place: Place,
    },
}
