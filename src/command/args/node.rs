//! `--node` and `eds`: which CANopen devices.

use core::fmt;
use core::str::FromStr;

use profidrive::can_bus::canopen::NodeId;
use profidrive::devices::ag03::profibus::Gear;
use profidrive::devices::asda_a2::Level;
use profidrive::host::can::{Choices, OptionName, PRODUCTS, Product};

use super::nearest;

/// The device of a node that names none.
const DEFAULT_DEVICE: &str = "ag03-1";

/// One emulated node, as asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct NodeSpec {
    pub(crate) id: NodeId,
    pub(crate) product: &'static Product,
    pub(crate) choices: Choices,
    /// Another node may have its number.
    pub(crate) twin: bool,
    /// Its own quirks, NAME=VALUE, which go before those of all.
    pub(crate) quirks: Vec<String>,
}

impl FromStr for NodeSpec {
    type Err = String;

    fn from_str(spec: &str) -> Result<Self, String> {
        let mut parts = spec.split(',');
        let id = node_id(parts.next().unwrap_or_default())?;
        let (mut product, mut mode, mut gear) = (None, None, None);
        let mut twin = false;
        for part in parts {
            if part == "twin" && !twin {
                twin = true;
                continue;
            }
            let (key, value) =
                part.split_once('=').ok_or_else(|| format!("'{part}' is not understood; {}", form()))?;
            let again = match key {
                "device" => product.replace(device(value)?).is_some(),
                "mode" => mode.replace(level(value)?).is_some(),
                "gear" => gear.replace(gear_ratio(value)?).is_some(),
                _ => return Err(format!("'{key}' is unknown; {}", form())),
            };
            if again {
                return Err(format!("'{key}' is given twice; {}", form()));
            }
        }
        let product = product.map_or_else(|| device(DEFAULT_DEVICE), Ok)?;
        if gear.is_some() && !product.options.contains(&OptionName::Gear) {
            return Err(format!("gear is for the device ag03-1 only, not for {}", product.name));
        }
        if mode.is_some() && !product.options.contains(&OptionName::Mode) {
            return Err(format!("mode is for the device asda-a2 only, not for {}", product.name));
        }
        let mut choices = Choices::default();
        choices.level = mode.unwrap_or(choices.level);
        choices.gear = gear.unwrap_or(choices.gear);
        Ok(Self { id, product, choices, twin, quirks: Vec::new() })
    }
}

impl fmt::Display for NodeSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} as node {}", self.product.sheet.product_name, self.id)
    }
}

/// A device by its name.
pub(crate) fn device(name: &str) -> Result<&'static Product, String> {
    Product::named(name).ok_or_else(|| {
        let near = nearest(name, PRODUCTS.iter().map(|product| product.name));
        format!("device '{name}' is unknown; {near}expected {}", devices(" or "))
    })
}

/// The names of all devices.
pub(crate) fn devices(between: &str) -> String {
    PRODUCTS.iter().map(|product| product.name).collect::<Vec<_>>().join(between)
}

fn gear_ratio(text: &str) -> Result<Gear, String> {
    match text {
        "24" => Ok(Gear::Ratio24),
        "48" => Ok(Gear::Ratio48),
        _ => Err(format!("gear '{text}' is unknown; expected 24 or 48")),
    }
}

fn level(text: &str) -> Result<Level, String> {
    match text {
        "full" => Ok(Level::Full),
        "half" => Ok(Level::Half),
        _ => Err(format!("mode '{text}' is unknown; expected full or half")),
    }
}

fn node_id(text: &str) -> Result<NodeId, String> {
    if text.is_empty() || !text.bytes().all(|octet| octet.is_ascii_digit()) {
        return Err(format!("'{text}' is no node number; {}", form()));
    }
    let node = text.parse().ok().and_then(|number| NodeId::new(number).ok());
    node.ok_or_else(|| format!("node number {text} is outside 1 to 127"))
}

fn form() -> String {
    format!("expected ID[,device={}][,gear=24|48][,mode=full|half][,twin]", devices("|"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_is_its_number_its_device_and_what_is_chosen_about_it() {
        for (spec, id, name, level) in [
            ("5", 5, "ag03-1", Level::Full),
            ("1,device=ap10", 1, "ap10", Level::Full),
            ("127,device=asda-a2", 127, "asda-a2", Level::Full),
            ("5,mode=half,device=asda-a2", 5, "asda-a2", Level::Half),
            ("5,device=asda-a2,mode=full", 5, "asda-a2", Level::Full),
        ] {
            let node: NodeSpec = spec.parse().unwrap();
            let expected = (id, name, level);
            assert_eq!((node.id.number(), node.product.name, node.choices.level), expected, "{spec}");
            assert_eq!(node.choices.gear, Gear::Ratio48, "{spec}");
        }
        let node: NodeSpec = "5,gear=24".parse().unwrap();
        assert_eq!(node.choices.gear, Gear::Ratio24);
    }

    #[test]
    fn a_wrong_node_is_answered_with_the_wrong_part() {
        for (spec, part) in [
            ("", "'' is no node number; expected ID"),
            ("x,device=ap10", "'x' is no node number"),
            ("+5", "'+5' is no node number"),
            ("0", "node number 0 is outside 1 to 127"),
            ("128,device=ap10", "node number 128 is outside 1 to 127"),
            ("99999999999999999999", "is outside 1 to 127"),
            ("5,", "'' is not understood; expected ID"),
            ("5,ap10", "'ap10' is not understood"),
            ("5,model=ap10", "'model' is unknown"),
            ("5,device=ap01", "device 'ap01' is unknown; did you mean ap10? expected "),
            ("5,device=asda_a2", "did you mean asda-a2?"),
            ("5,device=lathe", "device 'lathe' is unknown; expected "),
            ("5,device=ap10,device=ap10", "'device' is given twice"),
            ("5,device=ap10,mode=full", "mode is for the device asda-a2 only, not for ap10"),
            ("5,device=asda-a2,mode=some", "mode 'some' is unknown; expected full or half"),
            ("5,gear=12", "gear '12' is unknown; expected 24 or 48"),
            ("5,device=asda-a2,gear=24", "gear is for the device ag03-1 only, not for asda-a2"),
        ] {
            let error = spec.parse::<NodeSpec>().unwrap_err();
            assert!(error.contains(part), "{spec}: {error}");
        }
    }
}
