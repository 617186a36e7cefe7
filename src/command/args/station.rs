//! `--station`: which stations from device files are emulated.

use core::str::FromStr;
use std::path::PathBuf;

use profidrive::gsd::Policy;
use profidrive::profibus::fdl::Address;

use super::drive::address;

/// A station that a GSD describes, as asked for.
#[derive(Clone, Debug)]
pub(crate) struct StationSpec {
    pub(crate) address: Address,
    pub(crate) file: PathBuf,
    pub(crate) policy: Policy,
}

const FORM: &str = "expected ADDRESS,gsd=FILE or ADDRESS,strict,gsd=FILE";

impl FromStr for StationSpec {
    type Err = String;

    fn from_str(spec: &str) -> Result<Self, String> {
        if spec.starts_with("gsd=") {
            return Err(format!("the address is missing; {FORM}"));
        }
        let (number, rest) = spec.split_once(',').ok_or_else(|| format!("no file is named; {FORM}"))?;
        let address = address(number, FORM)?;
        let (policy, rest) = match rest.strip_prefix("strict,") {
            Some(rest) => (Policy::STRICT, rest),
            None => (Policy::PROPOSED, rest),
        };
        // The last part, since a name may hold commas.
        match rest.strip_prefix("gsd=") {
            Some("") => Err(format!("the name of the file is empty; {FORM}")),
            Some(file) => Ok(Self { address, file: file.into(), policy }),
            None => Err(format!("'{rest}' is not understood; {FORM}")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_station_is_its_address_and_its_file() {
        let station: StationSpec = "7,gsd=a,b.gsd".parse().unwrap();
        assert_eq!((station.address.number(), station.file.to_str()), (7, Some("a,b.gsd")));
        assert_eq!(station.policy, Policy::PROPOSED);
        assert_eq!("7,strict,gsd=x".parse::<StationSpec>().unwrap().policy, Policy::STRICT);
        for (spec, part) in [
            ("7", "no file is named; expected ADDRESS,gsd=FILE"),
            ("127,gsd=x", "address 127 is outside 0 to 126"),
            ("x,gsd=x", "'x' is no address"),
            ("gsd=x", "the address is missing; expected ADDRESS,gsd=FILE"),
            ("7,gsd=", "the name of the file is empty"),
            ("7,file=x", "'file=x' is not understood"),
        ] {
            let error = spec.parse::<StationSpec>().unwrap_err();
            assert!(error.contains(part), "{spec}: {error}");
        }
    }
}
