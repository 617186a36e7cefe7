//! Where masters find a bus of CAN.

use core::str::FromStr;
use std::path::PathBuf;

use thiserror::Error;

/// Where masters find the bus: `slcan-pty[:PATH]` or `slcan-tcp:HOST:PORT`; or where the bus goes on: `slcan-tty:PATH` or
/// `socketcan:INTERFACE`.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LinkSpec {
    /// A pseudo-terminal; the path becomes a symbolic link to it, which replaces an old link and never a file.
    Pty(Option<PathBuf>),
    /// A TCP port, `HOST:PORT`; port 0 is a free one. Each connection is an adapter of its own.
    Tcp(String),
    /// The terminal or port of an slcan adapter: the nodes take part in the bus behind it.
    Terminal(PathBuf),
    /// A CAN interface of Linux: the nodes take part in the bus behind it.
    Socket(String),
}

impl FromStr for LinkSpec {
    type Err = LinkSpecError;

    fn from_str(text: &str) -> Result<Self, LinkSpecError> {
        let (kind, place) = match text.split_once(':') {
            Some((kind, place)) => (kind, Some(place)),
            None => (text, None),
        };
        match (kind, place) {
            ("slcan-pty", None) => Ok(Self::Pty(None)),
            ("slcan-pty", Some(path)) if !path.is_empty() => Ok(Self::Pty(Some(path.into()))),
            ("slcan-tcp", Some(place)) if place.contains(':') => Ok(Self::Tcp(place.into())),
            ("slcan-tty", Some(path)) if !path.is_empty() => Ok(Self::Terminal(path.into())),
            ("socketcan", Some(name)) if !name.is_empty() => Ok(Self::Socket(name.into())),
            _ => Err(LinkSpecError { got: text.into() }),
        }
    }
}

/// A text that is no link of a CAN bus.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error(
    "'{got}' is no link of a CAN bus; expected slcan-pty:PATH, slcan-tcp:HOST:PORT, slcan-tty:PATH or socketcan:INTERFACE"
)]
pub struct LinkSpecError {
    /// The text found.
    pub got: String,
}
