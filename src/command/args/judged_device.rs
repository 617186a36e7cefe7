//! `judge --slave`, `judge --node`: which device, and where.

use core::str::FromStr;
use std::path::PathBuf;

use crate::can_bus::canopen::NodeId;
use crate::profibus::fdl::Address;
use crate::profibus::ppo::PpoType;

use super::link::tcp;
use super::spec::{address, ident, ppo};

/// A slave under test.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct JudgedSlave {
    pub(crate) address: Address,
    pub(crate) gsd: Option<PathBuf>,
    /// Names of modules, slot by slot.
    pub(crate) modules: Vec<String>,
    pub(crate) ident: Option<u16>,
    pub(crate) cfg: Option<Vec<u8>>,
    pub(crate) prm: Option<Vec<u8>>,
    pub(crate) profile: Option<PpoType>,
    /// It is a drive of PROFIdrive 3 or 4.
    pub(crate) profidrive: bool,
    pub(crate) records: Option<PathBuf>,
    pub(crate) mirror: bool,
}

const FORM: &str = "expected ADDRESS[,gsd=FILE[,modules='A','B']][,ident=HEX][,cfg=HEX][,prm=HEX][,profile=ppo1..ppo5|profidrive][,records=FILE.toml][,mirror]";

impl FromStr for JudgedSlave {
    type Err = String;

    fn from_str(spec: &str) -> Result<Self, String> {
        let mut parts = parts(spec).into_iter();
        let address = address(&parts.next().unwrap_or_default(), FORM)?;
        let mut slave = Self {
            address,
            gsd: None,
            modules: Vec::new(),
            ident: None,
            cfg: None,
            prm: None,
            profile: None,
            profidrive: false,
            records: None,
            mirror: false,
        };
        let mut in_modules = false;
        for part in parts {
            if in_modules && part.starts_with('\'') {
                slave.modules.push(unquoted(&part));
                continue;
            }
            in_modules = false;
            let (key, value) = part.split_once('=').unwrap_or((&part, ""));
            match key {
                "gsd" if !value.is_empty() => slave.gsd = Some(value.into()),
                "modules" if !value.is_empty() => {
                    slave.modules.push(unquoted(value));
                    in_modules = true;
                }
                "ident" => slave.ident = Some(ident(value)?),
                "cfg" => slave.cfg = Some(octets(key, value)?),
                "prm" => slave.prm = Some(octets(key, value)?),
                "records" if !value.is_empty() => slave.records = Some(value.into()),
                "profile" if value == "profidrive" => slave.profidrive = true,
                "profile" => {
                    let number = value.strip_prefix("ppo").unwrap_or_default();
                    slave.profile = Some(ppo(number).map_err(|_| {
                        format!("profile '{value}' is unknown; expected ppo1 to ppo5, or profidrive")
                    })?);
                }
                "mirror" if value.is_empty() => slave.mirror = true,
                _ => return Err(format!("'{part}' is not understood; {FORM}")),
            }
        }
        if slave.gsd.is_none() && !slave.modules.is_empty() {
            return Err("modules= needs the device file that has them: gsd=FILE".into());
        }
        if slave.gsd.is_some() && slave.ident.is_some() {
            return Err("the ident number is in the device file already; leave ident= out".into());
        }
        if address.number() == 126 {
            return Err("126 is the address of a slave that has none yet; give it one first".into());
        }
        Ok(slave)
    }
}

/// A node under test.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct JudgedNode {
    pub(crate) node: NodeId,
    pub(crate) eds: Option<PathBuf>,
}

impl FromStr for JudgedNode {
    type Err = String;

    fn from_str(spec: &str) -> Result<Self, String> {
        const FORM: &str = "expected ID[,eds=FILE], ID 1 to 127";
        let (number, rest) = spec.split_once(',').unwrap_or((spec, ""));
        let number = number.parse::<u8>().map_err(|_| format!("'{number}' is no node number; {FORM}"))?;
        let node = NodeId::new(number).map_err(|error| format!("{error}; {FORM}"))?;
        let eds = match rest.strip_prefix("eds=") {
            Some("") => return Err(format!("eds= needs a file; {FORM}")),
            Some(file) => Some(file.into()),
            None if rest.is_empty() => None,
            None => return Err(format!("'{rest}' is not understood; {FORM}")),
        };
        Ok(Self { node, eds })
    }
}

/// Cut at commas that are not between quotes.
fn parts(spec: &str) -> Vec<String> {
    let mut parts = vec![String::new()];
    let mut quoted = false;
    for c in spec.chars() {
        match c {
            ',' if !quoted => parts.push(String::new()),
            _ => {
                quoted ^= c == '\'';
                if let Some(part) = parts.last_mut() {
                    part.push(c);
                }
            }
        }
    }
    parts
}

fn unquoted(name: &str) -> String {
    name.trim_matches('\'').into()
}

fn octets(key: &str, value: &str) -> Result<Vec<u8>, String> {
    crate::host::octets_of_hex(value)
        .filter(|octets| !octets.is_empty() && octets.len() <= 244)
        .ok_or_else(|| format!("'{value}' does not fit {key}; expected octets in hex, such as F3F2"))
}

/// Where a device under test is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum DeviceLink {
    /// The judge makes the terminal, the program of the device opens it.
    Pty(Option<PathBuf>),
    /// A terminal that is there.
    Terminal(PathBuf),
    Serial(String),
    /// It connects there.
    Tcp(String),
    /// The device connects there.
    TcpListen(String),
}

const LINKS: &str =
    "expected pty:PATH, the path of a terminal, serial:DEVICE, tcp:HOST:PORT or tcp-listen:HOST:PORT";

impl FromStr for DeviceLink {
    type Err = String;

    fn from_str(spec: &str) -> Result<Self, String> {
        if spec.chars().any(char::is_control) {
            return Err(format!("a link has no control characters; {LINKS}"));
        }
        match spec.split_once(':') {
            None if spec == "pty" => Ok(Self::Pty(None)),
            Some(("pty" | "serial", "")) => Err(format!("the path is missing; {LINKS}")),
            Some(("pty", path)) => Ok(Self::Pty(Some(path.into()))),
            Some(("serial", device)) => Ok(Self::Serial(device.into())),
            Some(("tcp", place)) => tcp(place).map(Self::Tcp),
            Some(("tcp-listen", place)) => tcp(place).map(Self::TcpListen),
            None if spec.contains('/') => Ok(Self::Terminal(spec.into())),
            Some(_) | None => Err(LINKS.into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slave_is_an_address_and_what_is_known_of_it() {
        let slave: JudgedSlave =
            "5,gsd=io.gsd,modules='8 DI, 24 V','8 DO',prm=0102,profile=ppo2,mirror".parse().unwrap();
        assert_eq!((slave.address.number(), slave.gsd), (5, Some("io.gsd".into())));
        assert_eq!(slave.modules, ["8 DI, 24 V", "8 DO"]);
        assert_eq!((slave.prm, slave.profile, slave.mirror), (Some(vec![1, 2]), Some(PpoType::Ppo2), true));
        let plain: JudgedSlave = "7,ident=1234,cfg=2313".parse().unwrap();
        assert_eq!((plain.ident, plain.cfg, plain.mirror), (Some(0x1234), Some(vec![0x23, 0x13]), false));
        let longest: JudgedSlave = format!("5,cfg={}", "23".repeat(244)).parse().unwrap();
        assert_eq!(longest.cfg.map(|cfg| cfg.len()), Some(244));
        let longer = format!("5,cfg={}", "23".repeat(245)).parse::<JudgedSlave>().unwrap_err();
        assert!(longer.contains("does not fit cfg"), "{longer}");
        for (spec, part) in [
            ("", "no address"),
            ("126", "has none yet"),
            ("127", "outside 0 to 126"),
            ("5,often", "'often' is not understood"),
            ("5,cfg=2", "does not fit cfg"),
            ("5,profile=ppo6", "profile 'ppo6' is unknown"),
            ("5,modules='A'", "needs the device file"),
            ("5,gsd=x,ident=1234", "in the device file already"),
        ] {
            let error = spec.parse::<JudgedSlave>().unwrap_err();
            assert!(error.contains(part), "{spec}: {error}");
        }
    }

    #[test]
    fn a_node_is_a_number_and_its_data_sheet() {
        let node: JudgedNode = "7,eds=my, own.eds".parse().unwrap();
        assert_eq!((node.node.number(), node.eds), (7, Some("my, own.eds".into())));
        assert_eq!("127".parse::<JudgedNode>().unwrap().eds, None);
        for wrong in ["", "0", "128", "x", "5,", "5,eds=", "5,gsd=x"] {
            let parsed = wrong.parse::<JudgedNode>();
            assert_eq!(parsed.is_err(), wrong != "5,", "{wrong}: {parsed:?}");
        }
    }

    #[test]
    fn a_device_is_at_a_terminal_a_port_or_behind_tcp() {
        assert_eq!("pty:/tmp/bus".parse(), Ok(DeviceLink::Pty(Some("/tmp/bus".into()))));
        assert_eq!("/tmp/bus".parse(), Ok(DeviceLink::Terminal("/tmp/bus".into())));
        assert_eq!("tcp-listen:127.0.0.1:0".parse(), Ok(DeviceLink::TcpListen("127.0.0.1:0".into())));
        for wrong in ["", "usb", "pty:", "serial:", "tcp:5050", "a\nb"] {
            let error = wrong.parse::<DeviceLink>().unwrap_err();
            assert!(error.contains("tcp-listen:HOST:PORT") || error.contains("port"), "{wrong}: {error}");
        }
    }
}
