//! A device that can be a node; [the list](mod@crate::host::list) of all devices has each.

use core::fmt;

use crate::can_bus::canopen::eds;
use crate::can_bus::canopen::eds::Sheet;
use crate::can_bus::canopen::node::storage::Eeprom;
use crate::can_bus::canopen::{Address, NodeId, Object};
use crate::devices::CanopenDevice;
use crate::devices::Vocabulary;
use crate::devices::story::NodeAct;
use crate::host::list::{Choice, Choices, DEVICES, Device, QuirkRow};
use crate::time::Instant;

/// A device that can be bought, as a node.
pub struct Product {
    /// Its name on the command line, as `ap10`.
    pub name: &'static str,
    /// What its electronic data sheet says besides the objects; with it vendor, product and rates.
    pub sheet: Sheet<'static>,
    /// What it calls what it says.
    pub vocabulary: &'static Vocabulary,
    /// What can be chosen about it.
    pub(crate) choices: &'static [Choice],
    /// The entry by which a real one tells what was chosen about it, and the choice that a value of it is.
    pub(crate) tells: Option<(Address, ChoiceTold)>,
    /// What `profidrive demo` plays behind its boot-up.
    pub(crate) story: &'static [NodeAct],
    pub(in crate::host) objects: &'static (dyn Fn(&Choices) -> &'static [Object] + Sync),
    pub(in crate::host) quirks: fn() -> Vec<QuirkRow>,
    pub(in crate::host) make: &'static Make,
}

/// The key and the value of the choice that a value of an entry stands for.
pub(crate) type ChoiceTold = fn(i64) -> Option<(&'static str, &'static str)>;

/// Makes a device without supply, with factory settings.
pub(in crate::host) type Make = dyn Fn(NodeId, &Choices, Eeprom, Instant) -> Box<dyn CanopenDevice> + Sync;

impl Product {
    /// Every device on CANopen that needs no file.
    pub fn all() -> impl Iterator<Item = &'static Self> {
        DEVICES.iter().filter_map(Device::product)
    }

    /// The device of that name.
    pub fn named(name: &str) -> Option<&'static Self> {
        Self::all().find(|product| product.name == name)
    }

    /// A device without supply, with factory settings.
    pub fn make(
        &self,
        node: NodeId,
        choices: &Choices,
        memory: Eeprom,
        now: Instant,
    ) -> Box<dyn CanopenDevice> {
        (self.make)(node, choices, memory, now)
    }

    /// The bit rates that it can have, in bit/s.
    pub(crate) fn rates(&self) -> Vec<u32> {
        let device = self.make(NodeId::MIN, &Choices::default(), Eeprom::Internal, Instant::ZERO);
        let own = device.rates();
        let of_sheet = || self.sheet.kilobits.iter().map(|kilo| u32::from(*kilo) * 1000).collect();
        if own.is_empty() { of_sheet() } else { own.to_vec() }
    }

    /// Every point on which its manual leaves a choice.
    pub(crate) fn quirks(&self) -> Vec<QuirkRow> {
        (self.quirks)()
    }

    /// Its choices, one of them chosen; `None`: it has no such choice.
    pub(crate) fn chosen(&self, key: &str, word: &str) -> Option<Choices> {
        Choices::of_word(self.choices, key, word)
    }

    /// Its object dictionary.
    pub(crate) fn objects(&self, choices: &Choices) -> &'static [Object] {
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

    /// What the manuals say all the same.
    #[cfg(feature = "eds")]
    const ODD: [(&str, &str); 5] = [
        ("ag03-1", "NrOfRXPDO is 3, but 4 have communication parameters: these count"),
        ("ag03-1", "NrOfTXPDO is 3, but 4 have communication parameters: these count"),
        ("ag03-1", "LowLimit and HighLimit leave no range: there are no limits"),
        ("ap10", "1600h:02 maps 5F16h:04 with 16 bits, expected 32"),
        ("ap10", "1601h:02 maps 5F16h:02 with 16 bits, expected 32"),
    ];

    #[cfg(feature = "eds")]
    #[test]
    fn the_sheet_of_each_device_reads_back_as_it_is() {
        use crate::device_file::Level;
        use crate::eds::Eds;

        let node = NodeId::new(5).unwrap();
        let mut odd = Vec::new();
        for product in Product::all() {
            let eds = Eds::read(product.eds().as_bytes()).unwrap();
            let warnings = eds.hints.iter().filter(|hint| hint.level == Level::Warning);
            odd.extend(warnings.map(|hint| (product.name, hint.text.clone())));
            for object in product.objects(&Choices::default()) {
                let read = &eds.objects[&object.index.0];
                assert_eq!(read.entries.len(), object.entries.len(), "{} {}", product.name, object.index);
                for entry in object.entries {
                    let read = &read.entries[&entry.sub.0];
                    let place = format!("{} {}:{}", product.name, object.index, entry.sub);
                    assert_eq!((read.data, read.name.as_str()), (entry.data, entry.name), "{place}");
                    let expected = entry.default_value(node).with_octets(<[u8]>::to_vec);
                    assert_eq!(read.octets(node), expected, "{place}");
                }
            }
        }
        assert_eq!(odd, ODD.map(|(name, text)| (name, text.to_owned())));
    }

    #[test]
    fn each_device_starts_at_the_node_number_asked_for_and_has_a_sheet() {
        for product in Product::all() {
            assert_eq!(Product::named(product.name), Some(product));
            for number in [1, 5, 127] {
                let node = NodeId::new(number).unwrap();
                let mut device = product.make(node, &Choices::default(), Eeprom::Internal, Instant::ZERO);
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
    fn a_quirk_of_a_product_acts() {
        let product = Product::named("ap10").unwrap();
        let mut choices = Choices::default();
        choices.quirk(&product.quirks(), "auto-rate", "listens").unwrap();
        let mut device = product.make(NodeId::MIN, &choices, Eeprom::Internal, Instant::ZERO);
        device.power_on(Instant::ZERO);
        assert_eq!(device.poll_transmit(Instant::ZERO), None, "it listens first");
    }
}
