//! The list of CANopen devices. A new device has its folder in `device`, and an entry here.

use core::fmt;
use std::boxed::Box;
use std::string::String;

use crate::canopen::eds::{self, Sheet};
use crate::canopen::storage::Memory;
use crate::canopen::{NodeId, Object};
use crate::device::CanopenDevice;
use crate::device::ag03_canopen::{self, Ag03Node};
use crate::device::ap10_canopen::{self, Ap10};
use crate::device::asda_a2_canopen::{self, AsdaA2, Level};
use crate::device::{Eeprom, Gear};
use crate::time::Instant;

/// Every device that can be a node.
pub const PRODUCTS: &[Product] = &[
    Product {
        name: "ag03-1",
        sheet: ag03_canopen::objects::SHEET,
        options: &[OptionName::Gear],
        objects: |choices| ag03_canopen::objects::objects(choices.gear),
        make: |node, Choices { gear, .. }, memory, now| {
            let eeprom = match memory {
                Memory::Internal => Eeprom::Internal,
                Memory::Host => Eeprom::Host,
            };
            let config = ag03_canopen::Config { gear, eeprom, ..ag03_canopen::Config::new(node) };
            Box::new(Ag03Node::new(config, now).unsupplied(now))
        },
    },
    Product {
        name: "ap10",
        sheet: ap10_canopen::EDS,
        options: &[],
        objects: |_| ap10_canopen::OBJECTS,
        make: |node, _, memory, _| {
            Box::new(Ap10::new(ap10_canopen::Config { memory, ..ap10_canopen::Config::new(node) }))
        },
    },
    Product {
        name: "asda-a2",
        sheet: asda_a2_canopen::SHEET,
        options: &[OptionName::Mode],
        objects: |choices| AsdaA2::objects(choices.level),
        make: |node, choices, memory, now| {
            let config = asda_a2_canopen::Config {
                level: choices.level,
                ..asda_a2_canopen::Config::new(node.number())
            };
            Box::new(AsdaA2::new(config, asda_a2_canopen::Quirks::default(), now).with_memory(memory))
        },
    },
];

/// A device that can be bought, as a node.
pub struct Product {
    /// Its name on the command line, as `ap10`.
    pub name: &'static str,
    /// What its electronic data sheet says besides the objects; with it vendor, product and rates.
    pub sheet: Sheet<'static>,
    /// What can be chosen about it.
    pub options: &'static [OptionName],
    objects: fn(&Choices) -> &'static [Object],
    make: fn(NodeId, Choices, Memory, Instant) -> Box<dyn CanopenDevice>,
}

/// Something that can be chosen about a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum OptionName {
    /// [`Choices::gear`].
    Gear,
    /// [`Choices::level`].
    Mode,
}

/// What is chosen about a device; a device takes those of [`Product::options`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choices {
    /// The internal gear of the positioning drive.
    pub gear: Gear,
    /// How much of CiA 402 the servo follows.
    pub level: Level,
}

impl Default for Choices {
    fn default() -> Self {
        Self { gear: Gear::Ratio48, level: Level::Full }
    }
}

impl Product {
    /// The device of that name.
    pub fn named(name: &str) -> Option<&'static Self> {
        PRODUCTS.iter().find(|product| product.name == name)
    }

    /// A device without supply, with factory settings.
    pub fn make(
        &self,
        node: NodeId,
        choices: Choices,
        memory: Memory,
        now: Instant,
    ) -> Box<dyn CanopenDevice> {
        (self.make)(node, choices, memory, now)
    }

    /// Its object dictionary.
    pub fn objects(&self, choices: &Choices) -> &'static [Object] {
        (self.objects)(choices)
    }

    /// The EDS of the unconfigured device.
    pub fn eds(&self) -> String {
        let mut text = String::new();
        // A string takes everything.
        let _ = eds::write(&self.sheet, self.objects(&Choices::default()), &mut text);
        text
    }
}

impl fmt::Debug for Product {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Product").field(&self.name).finish()
    }
}

impl PartialEq for Product {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Eq for Product {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_device_starts_at_the_node_number_asked_for_and_has_a_sheet() {
        for product in PRODUCTS {
            assert_eq!(Product::named(product.name), Some(product));
            for number in [1, 5, 127] {
                let node = NodeId::new(number).unwrap();
                let mut device = product.make(node, Choices::default(), Memory::Internal, Instant::ZERO);
                device.power_on(Instant::ZERO);
                assert_eq!(device.node_id(), node, "{}", product.name);
                let boot_up = device.poll_transmit(Instant::ZERO).unwrap();
                assert_eq!(boot_up.id().number(), 0x700 + u32::from(number), "{}", product.name);
            }
            assert!(product.eds().starts_with("[FileInfo]\n"), "{}", product.name);
            assert!(product.sheet.kilobits.contains(&500), "{}: the rate of the command", product.name);
        }
    }
}
