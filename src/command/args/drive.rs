//! `--drive` and `--drives`: which drives are emulated.

use core::fmt;
use core::str::FromStr;

use profidrive::devices::ag03::param::{Gear, Model};
use profidrive::profibus::fdl::Address;

use super::nearest;

/// One emulated drive, as asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct DriveSpec {
    pub(crate) address: Address,
    pub(crate) model: Model,
    pub(crate) gear: Gear,
}

const DRIVE_FORM: &str = "expected ADDRESS[,model=ag03|ag03-1][,gear=24|48]";

impl FromStr for DriveSpec {
    type Err = String;

    fn from_str(spec: &str) -> Result<Self, String> {
        let (number, options) = split(spec);
        let address = address(number, DRIVE_FORM)?;
        Self::with_options(address, options, DRIVE_FORM)
    }
}

impl DriveSpec {
    fn with_options<'a>(
        address: Address,
        options: impl Iterator<Item = &'a str>,
        form: &str,
    ) -> Result<Self, String> {
        let (mut model, mut gear) = (None, None);
        for part in options {
            let (key, value) =
                part.split_once('=').ok_or_else(|| format!("'{part}' is not understood; {form}"))?;
            let again = match (key, value) {
                ("model", "ag03") => model.replace(Model::Ag03).is_some(),
                ("model", "ag03-1") => model.replace(Model::Ag03_1).is_some(),
                ("model", _) => {
                    let near = nearest(value, ["ag03", "ag03-1"].into_iter());
                    return Err(format!("model '{value}' is unknown; {near}expected ag03 or ag03-1"));
                }
                ("gear", "24") => gear.replace(Gear::Ratio24).is_some(),
                ("gear", "48") => gear.replace(Gear::Ratio48).is_some(),
                ("gear", _) => return Err(format!("gear '{value}' is unknown; expected 24 or 48")),
                _ => {
                    let near = nearest(key, ["model", "gear"].into_iter());
                    return Err(format!("'{key}' is unknown; {near}{form}"));
                }
            };
            if again {
                return Err(format!("'{key}' is given twice; {form}"));
            }
        }
        let (model, gear) = (model.unwrap_or(Model::Ag03_1), gear.unwrap_or(Gear::Ratio48));
        Ok(Self { address, model, gear })
    }
}

/// Drives that differ in nothing but their addresses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct RangeSpec {
    first: DriveSpec,
    last: Address,
}

const RANGE_FORM: &str = "expected FIRST-LAST[,model=ag03|ag03-1][,gear=24|48]";

impl FromStr for RangeSpec {
    type Err = String;

    fn from_str(spec: &str) -> Result<Self, String> {
        let (range, options) = split(spec);
        let (first, last) = range
            .split_once('-')
            .ok_or_else(|| format!("'{range}' is no range of addresses; {RANGE_FORM}"))?;
        let (first, last) = (address(first, RANGE_FORM)?, address(last, RANGE_FORM)?);
        if last < first {
            return Err(format!("the range {range} is empty; {RANGE_FORM}"));
        }
        Ok(Self { first: DriveSpec::with_options(first, options, RANGE_FORM)?, last })
    }
}

impl RangeSpec {
    pub(super) fn drives(&self) -> impl Iterator<Item = DriveSpec> + use<> {
        let first = self.first;
        let numbers = first.address.number()..=self.last.number();
        numbers.map(move |number| DriveSpec { address: Address::from_octet(number), ..first })
    }
}

/// What stands before the first comma, and the options behind it.
fn split(spec: &str) -> (&str, impl Iterator<Item = &str>) {
    let mut parts = spec.split(',');
    (parts.next().unwrap_or_default(), parts)
}

pub(super) fn address(text: &str, form: &str) -> Result<Address, String> {
    if text.is_empty() || !text.bytes().all(|octet| octet.is_ascii_digit()) {
        return Err(format!("'{text}' is no address; {form}"));
    }
    let station = text.parse().ok().and_then(|number| Address::station(number).ok());
    station.ok_or_else(|| format!("address {text} is outside 0 to 126"))
}

impl fmt::Display for DriveSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "SIKO {}, gear {}:1, at address {}", self.model.product_name(), self.gear, self.address)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drive_is_its_address_and_what_differs_from_the_default() {
        let full = |number, model, gear| {
            let address = Address::station(number).unwrap();
            Ok(DriveSpec { address, model, gear })
        };
        for (spec, drive) in [
            ("5", full(5, Model::Ag03_1, Gear::Ratio48)),
            ("0,gear=24", full(0, Model::Ag03_1, Gear::Ratio24)),
            ("126,model=ag03", full(126, Model::Ag03, Gear::Ratio48)),
            ("7,gear=48,model=ag03-1", full(7, Model::Ag03_1, Gear::Ratio48)),
        ] {
            assert_eq!(spec.parse::<DriveSpec>(), drive, "{spec}");
        }
    }

    #[test]
    fn a_wrong_drive_is_answered_with_the_wrong_part() {
        for (spec, part) in [
            ("", "'' is no address; expected ADDRESS"),
            ("+5", "'+5' is no address"),
            ("x,gear=24", "'x' is no address"),
            ("127", "address 127 is outside 0 to 126"),
            ("99999999999999999999", "is outside 0 to 126"),
            ("5,", "'' is not understood; expected ADDRESS"),
            ("5,gear", "'gear' is not understood"),
            ("5,gear=36", "gear '36' is unknown; expected 24 or 48"),
            ("5,model=ag04", "model 'ag04' is unknown; did you mean ag03? expected ag03 or ag03-1"),
            ("5,color=red", "'color' is unknown; expected ADDRESS"),
            ("5,gera=24", "'gera' is unknown; did you mean gear? expected ADDRESS"),
            ("5,gear=24,gear=48", "'gear' is given twice"),
            ("5,gear=24,gear=24", "'gear' is given twice"),
        ] {
            let error = spec.parse::<DriveSpec>().unwrap_err();
            assert!(error.contains(part), "{spec}: {error}");
        }
    }

    #[test]
    fn a_range_is_its_bounds_and_what_its_drives_share() {
        let range: RangeSpec = "1-125,model=ag03,gear=24".parse().unwrap();
        let drives: Vec<_> = range.drives().collect();
        assert_eq!(drives.len(), 125);
        assert_eq!(drives[0].to_string(), "SIKO AG03, gear 24:1, at address 1");
        assert_eq!(drives[124].to_string(), "SIKO AG03, gear 24:1, at address 125");
        assert_eq!("7-7".parse::<RangeSpec>().unwrap().drives().count(), 1);
        for (spec, part) in [
            ("5", "'5' is no range of addresses; expected FIRST-LAST"),
            ("", "'' is no range"),
            ("5-", "'' is no address; expected FIRST-LAST"),
            ("-5", "'' is no address"),
            ("1-2-3", "'2-3' is no address"),
            ("6-5", "the range 6-5 is empty"),
            ("1-127", "address 127 is outside 0 to 126"),
            ("1-2,gear=36", "gear '36' is unknown"),
            ("1-2,color=red", "'color' is unknown; expected FIRST-LAST"),
        ] {
            let error = spec.parse::<RangeSpec>().unwrap_err();
            assert!(error.contains(part), "{spec}: {error}");
        }
    }
}
