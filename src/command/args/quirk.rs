//! `--quirk NAME=VALUE`.

use core::str::FromStr;

use profidrive::devices::ag03::profibus::{Config, QUIRKS};
use profidrive::face::QuirkError;
use profidrive::host::can::{PRODUCTS, QuirkRow};
use profidrive::profibus::fdl::Address;

use super::nearest;

/// A quirk, checked to exist.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct QuirkSpec {
    name: String,
    value: String,
}

impl QuirkSpec {
    /// Sets the quirk.
    pub(crate) fn choose(&self, config: &mut Config) -> Result<(), QuirkError> {
        config.set_quirk(&self.name, &self.value)
    }
}

impl FromStr for QuirkSpec {
    type Err = String;

    fn from_str(spec: &str) -> Result<Self, String> {
        let (name, value) = parts(spec)?;
        let quirk = Self { name: name.into(), value: value.into() };
        let chosen = quirk.choose(&mut Config::new(Address::from_octet(0)));
        chosen.map_err(|error| refusal(name, value, &error))?;
        Ok(quirk)
    }
}

/// Name and value.
pub(super) fn parts(spec: &str) -> Result<(&str, &str), String> {
    spec.split_once('=').ok_or_else(|| "expected NAME=VALUE, for example off1=brake".into())
}

/// Why a quirk of a drive cannot be set.
pub(crate) fn refusal(name: &str, value: &str, error: &QuirkError) -> String {
    match error {
        QuirkError::Unknown => {
            let names: Vec<_> = QUIRKS.iter().map(|quirk| quirk.name).collect();
            let near = nearest(name, names.iter().copied());
            let of_node = PRODUCTS.iter().find(|node| node.quirks().iter().any(|quirk| quirk.name == name));
            let cure = match of_node {
                Some(node) => format!("it is one of a node {}; ", node.name),
                None => near,
            };
            format!("quirk '{name}' is unknown; {cure}expected one of {}", names.join(", "))
        }
        QuirkError::Value { name, values } => {
            format!("quirk {name} cannot be '{value}'; expected {}", values.join(" or "))
        }
    }
}

/// Every quirk with its values, the default first.
pub(super) fn help() -> String {
    let mut text = String::from(
        "How all drives behave where the manuals are not clear; repeat it for more.\nThe first value is the \
         default; docs/quirks.md has the reasons.\n",
    );
    for quirk in QUIRKS {
        text += &format!("\n  {}={}\n      {}", quirk.name, quirk.values.join("|"), quirk.about);
    }
    for product in PRODUCTS {
        text += &format!("\n\nOf a node {}:", product.name);
        for QuirkRow { name, values, about } in product.quirks() {
            text += &format!("\n  {name}={}\n      {about}", values.join("|"));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quirk_is_one_of_the_table() {
        assert!("off1=brake".parse::<QuirkSpec>().is_ok());
        for (wrong, part) in [
            ("off1", "expected NAME=VALUE"),
            ("off2=brake", "expected one of i-gain, "),
            ("of1=brake", "did you mean off1? expected one of"),
            (
                "sdo-size=42",
                "quirk 'sdo-size' is unknown; it is one of a node ag03-1; expected one of i-gain, ",
            ),
            ("off1=x", "quirk off1 cannot be 'x'; expected release or brake"),
        ] {
            let error = wrong.parse::<QuirkSpec>().unwrap_err();
            assert!(error.contains(part), "{wrong}: {error}");
        }
        for quirk in QUIRKS {
            assert!(help().contains(&format!("\n  {}={}", quirk.name, quirk.values.join("|"))));
        }
    }
}
