//! What every node has, whatever its file forgets (`eds.md` 2 and 4).

use std::collections::BTreeMap;

use super::content::Content;
use super::number::Number;
use super::object::{Entry, Object, Rights};
use super::{Eds, Profile};
use crate::can_bus::canopen::Index;
use crate::can_bus::canopen::dictionary::ObjectType;
use crate::can_bus::canopen::value::DataType;
use crate::device_file::Place;

impl Eds {
    /// Adds the objects that every node has and the identity that only DeviceInfo says. Says what it added.
    pub fn complete(&mut self) -> Vec<String> {
        let mut added = Vec::new();
        let device_type = match self.profile() {
            // A servo, as files without a default are.
            Profile::Drive => 0x0002_0192,
            Profile::InputsOutputs => 401,
            Profile::Encoder => 406,
            Profile::Other(number) => number.into(),
            Profile::None => 0,
        };
        self.fill(0x1000, 0, ("Device type", DataType::U32), Some(device_type), &mut added);
        self.fill(0x1001, 0, ("Error register", DataType::U8), None, &mut added);
        let device = &self.device;
        let serial = self.commissioning.as_ref().and_then(|commissioning| commissioning.serial_number);
        let identity = [
            (1, "Vendor-ID", device.vendor_number),
            (2, "Product code", device.product_number),
            (3, "Revision number", device.revision_number),
            (4, "Serial number", serial),
        ];
        let has_identity = self.objects.contains_key(&0x1018);
        for (sub, name, number) in identity {
            if !has_identity || self.entry(0x1018, sub).is_some() {
                self.fill(0x1018, sub, (name, DataType::U32), number, &mut added);
            }
        }
        if !has_identity {
            self.fill(0x1018, 0, ("Highest sub-index", DataType::U8), Some(4), &mut added);
        }
        let product = self.code_page.encode(&self.device.product);
        if let Some(name) = self.entry_mut(0x1008, 0)
            && name.content == Content::None
            && name.data == DataType::VisibleString
            && !product.is_empty()
        {
            name.content = Content::Octets(product);
        }
        added
    }

    fn entry_mut(&mut self, index: u16, sub: u8) -> Option<&mut Entry> {
        self.objects.get_mut(&index)?.entries.get_mut(&sub)
    }

    /// Gives an entry that is missing or has no default this number.
    fn fill(
        &mut self,
        index: u16,
        sub: u8,
        (name, data): (&str, DataType),
        number: Option<u32>,
        added: &mut Vec<String>,
    ) {
        let number = Number { offset: number.unwrap_or_default().into(), node_id: false };
        if let Some(entry) = self.entry_mut(index, sub) {
            if entry.content == Content::None && entry.data.kind().is_whole() {
                entry.content = Content::Whole(number);
            }
            return;
        }
        added.push(format!("{index:04X}h:{sub:02X} {name} is missing: it is {}", number.offset));
        let place = Place { line: 1, column: 1 };
        let object = self.objects.entry(index).or_insert_with(|| Object {
            index: Index(index),
            name: if index == 0x1018 { "Identity object".into() } else { name.into() },
            denotation: String::new(),
            kind: if index == 0x1018 { ObjectType::Record } else { ObjectType::Var },
            group: None,
            refuses_download: false,
            refuses_scan: false,
            entries: BTreeMap::new(),
            place,
        });
        let entry = Entry {
            name: name.into(),
            data,
            rights: Rights::ReadOnly,
            content: Content::Whole(number),
            mappable: false,
            low: None,
            high: None,
            file: None,
            place,
        };
        object.entries.insert(sub, entry);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::can_bus::canopen::NodeId;

    #[test]
    fn what_every_node_has_is_there_and_said() {
        let mut eds = Eds::read(
            b"[DeviceInfo]\nVendorNumber=0x196\nProductName=Pump\n[1018]\nObjectType=9\nSubNumber=2\n[1018sub0]\n\
              DataType=5\nAccessType=ro\nDefaultValue=1\n[1018sub1]\nDataType=7\nAccessType=ro\n[1008]\nDataType=9\nAccessType=const\n",
        )
        .unwrap();
        let added = eds.complete();
        assert_eq!(
            added,
            ["1000h:00 Device type is missing: it is 0", "1001h:00 Error register is missing: it is 0"]
        );
        let node = NodeId::new(5).unwrap();
        assert_eq!(eds.entry(0x1018, 1).unwrap().octets(node), [0x96, 1, 0, 0]);
        assert_eq!(eds.entry(0x1018, 2), None);
        assert_eq!(eds.entry(0x1008, 0).unwrap().octets(node), b"Pump");
        let mut bare =
            Eds::read(b"[6040]\nDataType=6\nAccessType=rw\n[6041]\nDataType=6\nAccessType=ro\n").unwrap();
        assert_eq!(bare.complete().len(), 7);
        assert_eq!(bare.number(0x1000, 0), Some(0x0002_0192));
        assert_eq!(bare.complete(), Vec::<String>::new());
    }
}
