//! `--link` of `profidrive master`: where the line is.

use core::str::FromStr;
use std::path::PathBuf;

use super::link::tcp;

/// Where a master finds the line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum MasterLink {
    Terminal(PathBuf),
    Serial(String),
    /// Host and port.
    Tcp(String),
    /// A bus of CAN.
    Can(CanPlace),
}

/// Where a master finds a bus of CAN.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum CanPlace {
    /// A terminal or a port with an slcan adapter.
    Terminal(PathBuf),
    /// Host and port of an slcan adapter.
    Tcp(String),
    /// An interface of Linux.
    Socket(String),
}

const LINKS: &str = if cfg!(windows) {
    "expected serial:PORT such as serial:COM3, or tcp:HOST:PORT; of CANopen slcan-tty:PORT or slcan-tcp:HOST:PORT"
} else {
    "expected a terminal such as /dev/pts/3, pty:PATH, serial:DEVICE or tcp:HOST:PORT; of CANopen slcan-tty:PATH, \
     slcan-tcp:HOST:PORT or socketcan:INTERFACE"
};

impl FromStr for MasterLink {
    type Err = String;

    fn from_str(spec: &str) -> Result<Self, String> {
        if spec.chars().any(char::is_control) {
            return Err(format!("a link has no control characters; {LINKS}"));
        }
        match spec.split_once(':') {
            Some(("pty" | "serial", "")) | None if matches!(spec, "pty:" | "pty" | "serial:" | "serial") => {
                Err(format!("the path is missing; {LINKS}"))
            }
            Some(("pty", path)) => Ok(Self::Terminal(path.into())),
            Some(("serial", device)) => Ok(Self::Serial(device.into())),
            Some(("tcp", place)) => tcp(place).map(Self::Tcp),
            Some(("slcan-tty" | "slcan-pty" | "socketcan", "")) => {
                Err(format!("the name is missing; {LINKS}"))
            }
            // What an emulator prints.
            Some(("slcan-tty" | "slcan-pty", path)) => Ok(Self::Can(CanPlace::Terminal(path.into()))),
            Some(("slcan-tcp", place)) => tcp(place).map(|place| Self::Can(CanPlace::Tcp(place))),
            Some(("socketcan", name)) => Ok(Self::Can(CanPlace::Socket(name.into()))),
            // A bare path is what an emulator prints. Is it a real port, its rate matters.
            None if spec.contains('/') => {
                let target = std::fs::canonicalize(spec).unwrap_or_else(|_| spec.into());
                Ok(match target.starts_with("/dev") && !target.starts_with("/dev/pts") {
                    true => Self::Serial(spec.into()),
                    false => Self::Terminal(spec.into()),
                })
            }
            Some(_) | None => Err(LINKS.into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_link_is_what_an_emulator_prints_or_a_kind_and_a_place() {
        let terminal = |path: &str| Ok(MasterLink::Terminal(path.into()));
        assert_eq!("/dev/pts/3".parse(), terminal("/dev/pts/3"));
        assert_eq!("/tmp/no-such/bus".parse(), terminal("/tmp/no-such/bus"));
        assert_eq!("pty:bus".parse(), terminal("bus"));
        assert_eq!("/dev/null".parse(), Ok(MasterLink::Serial("/dev/null".into())));
        assert_eq!("serial:/dev/ttyS0".parse(), Ok(MasterLink::Serial("/dev/ttyS0".into())));
        assert_eq!("tcp:127.0.0.1:5050".parse(), Ok(MasterLink::Tcp("127.0.0.1:5050".into())));
        for wrong in ["", "pty", "pty:", "serial", "serial:", "tcp", "tcp:5050", "usb", "usb:1", "/tmp/a\nb"]
        {
            let error = wrong.parse::<MasterLink>().unwrap_err();
            assert!(error.contains("tcp:HOST:PORT"), "{wrong}: {error}");
        }
    }
}
