//! `--ppo-drive`: which drives of the profile are emulated.

use core::str::FromStr;
use std::path::PathBuf;

use profidrive::profibus::fdl::Address;
use profidrive::profibus::ppo::PpoType;

use super::drive::address;

/// A drive of PROFIDRIVE version 2, as asked for.
#[derive(Clone, Debug)]
pub(crate) struct PpoDriveSpec {
    pub(crate) address: Address,
    /// The only PPO that is accepted.
    pub(crate) ppo: Option<PpoType>,
    pub(crate) ident: Option<u16>,
    pub(crate) parameters: Option<PathBuf>,
    pub(crate) gsd: Option<PathBuf>,
}

const FORM: &str = "expected ADDRESS[,ppo=1..5][,ident=HEX][,gsd=FILE][,parameters=FILE.toml|FILE.csv]";

impl FromStr for PpoDriveSpec {
    type Err = String;

    fn from_str(spec: &str) -> Result<Self, String> {
        let mut parts = spec.split(',');
        let address = address(parts.next().unwrap_or_default(), FORM)?;
        let mut this = Self { address, ppo: None, ident: None, parameters: None, gsd: None };
        for part in parts {
            let (key, value) =
                part.split_once('=').ok_or_else(|| format!("'{part}' is not understood; {FORM}"))?;
            let again = match key {
                "ppo" => this.ppo.replace(ppo(value)?).is_some(),
                "ident" => this.ident.replace(ident(value)?).is_some(),
                "parameters" => this.parameters.replace(file(key, value)?).is_some(),
                "gsd" => this.gsd.replace(file(key, value)?).is_some(),
                _ => return Err(format!("'{key}' is unknown; {FORM}")),
            };
            if again {
                return Err(format!("'{key}' is given twice; {FORM}"));
            }
        }
        this.check()?;
        Ok(this)
    }
}

impl PpoDriveSpec {
    /// What no single part shows.
    pub(crate) fn check(&self) -> Result<(), String> {
        match (&self.gsd, self.ident) {
            (Some(_), Some(_)) => Err("the ident number is that of the GSD; leave ident out".into()),
            (Some(_) | None, _) => Ok(()),
        }
    }
}

/// The type of a PPO by its number.
pub(super) fn ppo(value: &str) -> Result<PpoType, String> {
    match value {
        "1" => Ok(PpoType::Ppo1),
        "2" => Ok(PpoType::Ppo2),
        "3" => Ok(PpoType::Ppo3),
        "4" => Ok(PpoType::Ppo4),
        "5" => Ok(PpoType::Ppo5),
        _ => Err(format!("ppo '{value}' is unknown; expected 1, 2, 3, 4 or 5")),
    }
}

/// An ident number.
pub(super) fn ident(value: &str) -> Result<u16, String> {
    let digits = value.strip_prefix("0x").unwrap_or(value);
    u16::from_str_radix(digits, 16).map_err(|_| {
        format!("ident '{value}' is no ident number; expected four hexadecimal digits, for example 5044")
    })
}

fn file(key: &str, value: &str) -> Result<PathBuf, String> {
    if value.is_empty() {
        Err(format!("the name of the file of '{key}' is empty; {FORM}"))
    } else {
        Ok(value.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drive_is_its_address_and_what_it_stands_in_for() {
        let drive: PpoDriveSpec = "7,ppo=2,ident=0x80D1,parameters=a.csv".parse().unwrap();
        assert_eq!((drive.address.number(), drive.ppo, drive.ident), (7, Some(PpoType::Ppo2), Some(0x80D1)));
        assert_eq!(drive.parameters.unwrap().to_str(), Some("a.csv"));
        for (spec, part) in [
            ("x", "'x' is no address"),
            ("7,ppo=6", "ppo '6' is unknown; expected 1, 2, 3, 4 or 5"),
            ("7,ident=12345", "ident '12345' is no ident number"),
            ("7,gsd=", "the name of the file of 'gsd' is empty"),
            ("7,gsd=a,ident=1", "leave ident out"),
            ("7,ppo=1,ppo=1", "'ppo' is given twice"),
            ("7,model=x", "'model' is unknown; expected ADDRESS"),
            ("7,fast", "'fast' is not understood"),
        ] {
            let error = spec.parse::<PpoDriveSpec>().unwrap_err();
            assert!(error.contains(part), "{spec}: {error}");
        }
    }
}
