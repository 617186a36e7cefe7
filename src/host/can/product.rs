//! The list of CANopen devices. A new device has its folder in `device`, and an entry here.

use core::fmt;
use std::boxed::Box;
use std::string::String;
use std::vec::Vec;

use crate::can_bus::canopen::eds;
use crate::can_bus::canopen::eds::Sheet;
use crate::can_bus::canopen::storage::Eeprom;
use crate::can_bus::canopen::{NodeId, Object};
use crate::devices::CanopenDevice;
use crate::devices::Vocabulary;
use crate::devices::ag03;
use crate::devices::ag03::canopen::Ag03Node;
use crate::devices::ag03::profibus::Gear;
use crate::devices::ap10;
use crate::devices::ap10::canopen::Ap10;
use crate::devices::asda_a2;
use crate::devices::asda_a2::canopen::{AsdaA2, Level};
use crate::face::{Quirk, QuirkError};
use crate::time::Instant;

/// Every device that can be a node.
pub const PRODUCTS: &[Product] = &[
    Product {
        name: "ag03-1",
        sheet: ag03::canopen::objects::SHEET,
        vocabulary: &ag03::canopen::VOCABULARY,
        options: &[OptionName::Gear],
        objects: |choices| ag03::canopen::objects::objects(choices.gear),
        quirks: || rows(ag03::canopen::QUIRKS),
        make: |node, Choices { gear, quirks, .. }, memory, now| {
            let mut config =
                ag03::canopen::Config { gear, eeprom: memory, ..ag03::canopen::Config::new(node) };
            quirks.apply(ag03::canopen::QUIRKS, &mut config);
            Box::new(Ag03Node::new(config, now).unsupplied(now))
        },
    },
    Product {
        name: "ap10",
        sheet: ap10::canopen::EDS,
        vocabulary: &ap10::canopen::VOCABULARY,
        options: &[],
        objects: |_| ap10::canopen::OBJECTS,
        quirks: || rows(ap10::canopen::QUIRKS),
        make: |node, choices, memory, _| {
            let mut config = ap10::canopen::Config { memory, ..ap10::canopen::Config::new(node) };
            choices.quirks.apply(ap10::canopen::QUIRKS, &mut config.quirks);
            Box::new(Ap10::new(config))
        },
    },
    Product {
        name: "asda-a2",
        sheet: asda_a2::canopen::SHEET,
        vocabulary: &asda_a2::canopen::VOCABULARY,
        options: &[OptionName::Mode],
        objects: |choices| AsdaA2::objects(choices.level),
        quirks: || rows(asda_a2::canopen::QUIRKS),
        make: |node, choices, memory, now| {
            let mut quirks = asda_a2::canopen::Quirks::default();
            choices.quirks.apply(asda_a2::canopen::QUIRKS, &mut quirks);
            let config = asda_a2::canopen::Config {
                level: choices.level,
                ..asda_a2::canopen::Config::new(node.number())
            };
            Box::new(AsdaA2::new(config, quirks, now).with_memory(memory))
        },
    },
];

/// A device that can be bought, as a node.
pub struct Product {
    /// Its name on the command line, as `ap10`.
    pub name: &'static str,
    /// What its electronic data sheet says besides the objects; with it vendor, product and rates.
    pub sheet: Sheet<'static>,
    /// What it calls what it says.
    pub vocabulary: &'static Vocabulary,
    /// What can be chosen about it.
    pub options: &'static [OptionName],
    objects: fn(&Choices) -> &'static [Object],
    quirks: fn() -> Vec<QuirkRow>,
    make: fn(NodeId, Choices, Eeprom, Instant) -> Box<dyn CanopenDevice>,
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
    /// What is chosen where a manual leaves it open.
    pub quirks: ChosenQuirks,
}

/// A point on which the manual of a device contradicts itself or leaves a choice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QuirkRow {
    /// Its name in `NAME=VALUE`.
    pub name: &'static str,
    /// What it decides.
    pub about: &'static str,
    /// What it may be; the first is the default.
    pub values: &'static [&'static str],
}

/// Quirks of one device at most.
const MAX_QUIRKS: usize = 32;

/// Which value of each quirk of a device is chosen, by [`Product::choose`]; at first the default of each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ChosenQuirks([u8; MAX_QUIRKS]);

impl ChosenQuirks {
    fn apply<C>(self, table: &[Quirk<C>], config: &mut C) {
        for (quirk, place) in table.iter().zip(self.0) {
            if let Some(value) = quirk.values.get(usize::from(place)) {
                // Both are of the table.
                let _ = Quirk::set(table, config, quirk.name, value);
            }
        }
    }
}

fn rows<C>(table: &'static [Quirk<C>]) -> Vec<QuirkRow> {
    table.iter().map(|Quirk { name, about, values, .. }| QuirkRow { name, about, values }).collect()
}

impl Default for Choices {
    fn default() -> Self {
        Self { gear: Gear::Ratio48, level: Level::Full, quirks: ChosenQuirks::default() }
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
        memory: Eeprom,
        now: Instant,
    ) -> Box<dyn CanopenDevice> {
        (self.make)(node, choices, memory, now)
    }

    /// Every point on which its manual leaves a choice.
    pub fn quirks(&self) -> Vec<QuirkRow> {
        (self.quirks)()
    }

    /// Chooses the value of a quirk.
    ///
    /// # Errors
    /// [`QuirkError`] if the device has no such quirk, or the quirk no such value; nothing is changed then.
    pub fn choose(&self, choices: &mut Choices, name: &str, value: &str) -> Result<(), QuirkError> {
        let rows = self.quirks();
        let mut both = rows.iter().zip(&mut choices.quirks.0);
        let (row, place) = both.find(|(row, _)| row.name == name).ok_or(QuirkError::Unknown)?;
        let found =
            row.values.iter().position(|known| *known == value).and_then(|found| u8::try_from(found).ok());
        *place = found.ok_or(QuirkError::Value { name: row.name, values: row.values })?;
        Ok(())
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
                let mut device = product.make(node, Choices::default(), Eeprom::Internal, Instant::ZERO);
                device.power_on(Instant::ZERO);
                assert_eq!(device.node_id(), node, "{}", product.name);
                let boot_up = device.poll_transmit(Instant::ZERO).unwrap();
                assert_eq!(boot_up.id().number(), 0x700 + u32::from(number), "{}", product.name);
            }
            assert!(product.eds().starts_with("[FileInfo]\n"), "{}", product.name);
            assert!(product.sheet.kilobits.contains(&500), "{}: the rate of the command", product.name);
        }
    }

    #[test]
    fn every_value_of_every_quirk_can_be_chosen() {
        for product in PRODUCTS {
            let rows = product.quirks();
            assert!(rows.len() <= MAX_QUIRKS, "{}", product.name);
            let mut choices = Choices::default();
            for row in &rows {
                for value in row.values.iter().rev() {
                    product.choose(&mut choices, row.name, value).unwrap();
                    let chosen = choices.quirks != ChosenQuirks::default();
                    assert_eq!(
                        chosen,
                        row.values.first() != Some(value),
                        "{} {}={value}",
                        product.name,
                        row.name
                    );
                    product.make(NodeId::MIN, choices, Eeprom::Internal, Instant::ZERO);
                }
                assert!(product.choose(&mut choices, row.name, "no such value").is_err());
            }
            assert_eq!(product.choose(&mut choices, "none", "x"), Err(QuirkError::Unknown));
        }
    }

    #[test]
    fn a_quirk_of_a_product_acts() {
        let product = Product::named("ap10").unwrap();
        let mut choices = Choices::default();
        product.choose(&mut choices, "auto-rate", "listens").unwrap();
        let mut device = product.make(NodeId::MIN, choices, Eeprom::Internal, Instant::ZERO);
        device.power_on(Instant::ZERO);
        assert_eq!(device.poll_transmit(Instant::ZERO), None, "it listens first");
    }
}
