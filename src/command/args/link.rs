//! `--link` and `--baud`: where the line is, and how fast.

use core::fmt;
use core::str::FromStr;
use std::path::PathBuf;

use crate::can_bus::can::BitRate;
use crate::host::can;
use crate::time::BaudRate;

/// Where the line is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum LinkSpec {
    Pty(Option<PathBuf>),
    Serial(String),
    /// Host and port.
    Tcp(String),
    /// A CAN bus.
    Can(can::LinkSpec),
}

const LINKS: &str = "expected pty, pty:PATH, serial:DEVICE or tcp:HOST:PORT, or for CANopen slcan-pty:PATH, slcan-tcp:HOST:PORT, \
                     slcan-tty:PATH or socketcan:INTERFACE";

impl FromStr for LinkSpec {
    type Err = String;

    fn from_str(spec: &str) -> Result<Self, String> {
        // The ready line is one line whatever the path is.
        if spec.chars().any(char::is_control) {
            return Err(format!("a link has no control characters; {LINKS}"));
        }
        match spec.split_once(':') {
            None if spec == "pty" => Ok(Self::Pty(None)),
            Some(("pty", "")) => Err(format!("the path is missing; {LINKS}")),
            Some(("pty", path)) => Ok(Self::Pty(Some(path.into()))),
            None if spec == "serial" => Err(format!("the device is missing; {LINKS}")),
            Some(("serial", "")) => Err(format!("the device is missing; {LINKS}")),
            Some(("serial", device)) => Ok(Self::Serial(device.into())),
            Some(("tcp", place)) => tcp(place).map(Self::Tcp),
            None if spec == "tcp" => Err(format!("host and port are missing; {LINKS}")),
            None if spec == "slcan-pty" => Ok(Self::Can(can::LinkSpec::Pty(None))),
            Some(("slcan-pty", "")) => Err(format!("the path is missing; {LINKS}")),
            Some(("slcan-pty", path)) => Ok(Self::Can(can::LinkSpec::Pty(Some(path.into())))),
            None if spec == "slcan-tcp" => Err(format!("host and port are missing; {LINKS}")),
            Some(("slcan-tcp", place)) => {
                let place = host_and_port(place, "slcan-tcp:127.0.0.1:5000", LINKS)?;
                Ok(Self::Can(can::LinkSpec::Tcp(place)))
            }
            None if matches!(spec, "slcan-tty" | "socketcan") => Err(format!("the name is missing; {LINKS}")),
            Some(("slcan-tty" | "socketcan", "")) => Err(format!("the name is missing; {LINKS}")),
            Some(("slcan-tty", path)) => Ok(Self::Can(can::LinkSpec::Terminal(path.into()))),
            Some(("socketcan", name)) => Ok(Self::Can(can::LinkSpec::Socket(name.into()))),
            _ => Err(format!("{}{LINKS}", meant(spec))),
        }
    }
}

/// `did you mean X? `, of a device or a place without its kind.
fn meant(spec: &str) -> String {
    let is_port = |port: &str| !port.is_empty() && port.bytes().all(|octet| octet.is_ascii_digit());
    let lower = spec.to_ascii_lowercase();
    let kind = match spec.rsplit_once(':') {
        Some((_, port)) if is_port(port) => "tcp",
        None if lower.starts_with("/dev/") || lower.strip_prefix("com").is_some_and(is_port) => "serial",
        None if lower.strip_prefix("can").is_some_and(is_port) => "socketcan",
        Some(_) | None => return String::new(),
    };
    format!("did you mean {kind}:{spec}? ")
}

pub(super) fn tcp(place: &str) -> Result<String, String> {
    host_and_port(place, "tcp:127.0.0.1:5050", LINKS)
}

/// `HOST:PORT`, an IPv6 address in brackets. Whether the host is there shows when it is listened at.
pub(super) fn host_and_port(place: &str, example: &str, form: &str) -> Result<String, String> {
    match place.rsplit_once(':') {
        None | Some(("", _)) => Err(format!("host and port must be given, for example {example}; {form}")),
        Some((host, port)) if port.is_empty() || !port.bytes().all(|octet| octet.is_ascii_digit()) => {
            Err(format!("'{port}' is no port of {host}; {form}"))
        }
        Some((_, port)) if port.parse::<u16>().is_err() => Err(format!("port {port} is outside 0 to 65535")),
        Some((host, _)) if host.contains(':') && !host.starts_with('[') => {
            Err(format!("an IPv6 address is written in brackets, for example [::1]:5050; {form}"))
        }
        Some(_) => Ok(place.into()),
    }
}

/// How fast the line is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BaudSpec {
    /// As the master sets it.
    Auto,
    /// Each of the device file.
    OfFile,
    Fixed(BaudRate),
    /// In bit/s, none of PROFIBUS: what it is on CAN the link says.
    Other(u32),
}

/// The rates that CiA 301 recommends and those that nodes have besides, in bit/s.
pub(crate) const CAN_RATES: [u32; 15] = [
    10_000, 15_625, 20_000, 25_000, 40_000, 50_000, 62_500, 100_000, 125_000, 200_000, 250_000, 500_000,
    750_000, 800_000, 1_000_000,
];

impl BaudSpec {
    /// The rate of a PROFIBUS line.
    pub(crate) const fn fixed(self) -> Option<BaudRate> {
        match self {
            Self::Fixed(rate) => Some(rate),
            Self::Auto | Self::OfFile | Self::Other(_) => None,
        }
    }

    /// The rate of a CAN bus.
    pub(crate) fn can(self) -> Option<BitRate> {
        let bits = match self {
            Self::Auto | Self::OfFile => return None,
            Self::Other(bits) => bits,
            Self::Fixed(rate) => rate.bits_per_second(),
        };
        BitRate::from_bits_per_second(bits).ok().filter(|_| CAN_RATES.contains(&bits))
    }

    /// # Errors
    /// It is no rate of PROFIBUS.
    pub(super) fn check_profibus(self) -> Result<(), String> {
        match self {
            Self::Auto | Self::Fixed(_) => Ok(()),
            Self::OfFile => Err("--baud gsd is for judge --slave ADDRESS,gsd=FILE".into()),
            Self::Other(bits) => {
                Err(format!("--baud {bits} is no rate of PROFIBUS; {}", expected_rates(BaudRate::ALL)))
            }
        }
    }

    /// # Errors
    /// It is no rate of CAN.
    pub(super) fn check_can(self) -> Result<(), String> {
        let rates = CAN_RATES.map(|rate| rate.to_string()).join(", ");
        match self {
            _ if self.can().is_some() => Ok(()),
            Self::Auto => Err(format!("--baud auto is for PROFIBUS; on a CAN bus expected one of {rates}")),
            Self::OfFile | Self::Other(_) | Self::Fixed(_) => {
                Err(format!("--baud {self} is no rate of a CAN bus; expected one of {rates}"))
            }
        }
    }
}

impl fmt::Display for BaudSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::OfFile => f.write_str("gsd"),
            Self::Fixed(rate) => rate.bits_per_second().fmt(f),
            Self::Other(bits) => bits.fmt(f),
        }
    }
}

impl FromStr for BaudSpec {
    type Err = String;

    fn from_str(spec: &str) -> Result<Self, String> {
        if spec == "auto" {
            return Ok(Self::Auto);
        }
        if spec == "gsd" {
            return Ok(Self::OfFile);
        }
        let bits = spec.parse().map_err(|_| {
            format!("'{spec}' is no rate; expected auto or bits per second, for example 500000")
        })?;
        Ok(BaudRate::from_bits_per_second(bits).map_or(Self::Other(bits), Self::Fixed))
    }
}

/// The rates that may be given.
pub(super) fn expected_rates(rates: impl IntoIterator<Item = BaudRate>) -> String {
    let rates: Vec<_> = rates.into_iter().map(|rate| rate.bits_per_second().to_string()).collect();
    format!("expected auto or one of {}", rates.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_link_is_named_by_its_kind_and_place() {
        assert_eq!("pty".parse(), Ok(LinkSpec::Pty(None)));
        assert_eq!("pty:/tmp/a:b".parse(), Ok(LinkSpec::Pty(Some("/tmp/a:b".into()))));
        assert_eq!("serial:/dev/ttyUSB0".parse(), Ok(LinkSpec::Serial("/dev/ttyUSB0".into())));
        assert_eq!("tcp:localhost:0".parse(), Ok(LinkSpec::Tcp("localhost:0".into())));
        assert_eq!("tcp:[::1]:5050".parse(), Ok(LinkSpec::Tcp("[::1]:5050".into())));
        assert_eq!("slcan-pty".parse(), Ok(LinkSpec::Can(can::LinkSpec::Pty(None))));
        assert_eq!(
            "slcan-pty:/tmp/can".parse(),
            Ok(LinkSpec::Can(can::LinkSpec::Pty(Some("/tmp/can".into()))))
        );
        assert_eq!("slcan-tcp:[::1]:0".parse(), Ok(LinkSpec::Can(can::LinkSpec::Tcp("[::1]:0".into()))));
        assert_eq!(
            "slcan-tty:/dev/ttyACM0".parse(),
            Ok(LinkSpec::Can(can::LinkSpec::Terminal("/dev/ttyACM0".into())))
        );
        assert_eq!("socketcan:can0".parse(), Ok(LinkSpec::Can(can::LinkSpec::Socket("can0".into()))));
        for (spec, meant) in [
            ("COM3", "serial:COM3"),
            ("/dev/ttyUSB0", "serial:/dev/ttyUSB0"),
            ("127.0.0.1:5050", "tcp:127.0.0.1:5050"),
            ("can0", "socketcan:can0"),
        ] {
            let refused = spec.parse::<LinkSpec>().unwrap_err();
            assert!(refused.starts_with(&format!("did you mean {meant}? expected pty")), "{refused}");
        }
        for wrong in [
            "slcan-tty",
            "socketcan:",
            "",
            "pty:",
            "serial",
            "serial:",
            "tcp",
            "tcp:",
            "tcp:5050",
            "tcp::5050",
            "tcp:a:b",
            "tcp:::1:5",
            "usb",
            "slcan",
            "slcan-pty:",
            "slcan-tcp",
            "slcan-tcp:5000",
            "slcan-tcp:a:b",
            "pty:a\nb",
            "PTY",
        ] {
            assert!(wrong.parse::<LinkSpec>().unwrap_err().contains("pty:PATH"), "{wrong}");
        }
    }

    #[test]
    fn a_rate_is_one_that_the_drives_know_or_auto() {
        assert_eq!("auto".parse(), Ok(BaudSpec::Auto));
        assert_eq!("93750".parse(), Ok(BaudSpec::Fixed(BaudRate::K93_75)));
        assert_eq!("250000".parse(), Ok(BaudSpec::Other(250_000)));
        assert_eq!(BaudSpec::Other(250_000).can(), Some(BitRate::K250));
        assert_eq!(BaudSpec::Fixed(BaudRate::K500).can(), Some(BitRate::K500), "both buses have it");
        assert_eq!(BaudSpec::Fixed(BaudRate::K93_75).can(), None);
        for wrong in ["", "-1", "500k", "Auto"] {
            assert!(wrong.parse::<BaudSpec>().unwrap_err().contains("bits per second"), "{wrong}");
        }
    }

    #[test]
    fn a_wrong_rate_names_those_of_its_bus_only() {
        let wrong: BaudSpec = "115200".parse().unwrap();
        let (profibus, can) = (wrong.check_profibus().unwrap_err(), wrong.check_can().unwrap_err());
        assert!(profibus.contains("12000000") && !profibus.contains("15625"), "{profibus}");
        assert!(can.contains("15625") && !can.contains("12000000"), "{can}");
        assert!(BaudSpec::Auto.check_can().unwrap_err().contains("15625"));
    }
}
