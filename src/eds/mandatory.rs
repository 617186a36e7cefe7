//! What every node has, whatever its file forgets, and PDOs that it names by their number only (`eds.md` 2 and 4).

use std::collections::BTreeMap;

use super::content::Content;
use super::number::Number;
use super::object::{Entry, Object, Rights};
use super::{Eds, Profile};
use crate::can_bus::canopen::Index;
use crate::can_bus::canopen::dictionary::ObjectType;
use crate::can_bus::canopen::value::{DataType, ValueKind};
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
        if self.device.compact_pdo != 0 {
            self.add_pdos(&mut added);
        }
        match self.profile() {
            Profile::InputsOutputs => self.fill_inputs_outputs(),
            Profile::Encoder => self.tie_cyclic_timer(&mut added),
            Profile::Drive | Profile::Other(_) | Profile::None => {}
        }
        added
    }

    /// Entries of CiA 401 without a default have that of the profile: with 0 no input would have an event, and no output
    /// would follow.
    fn fill_inputs_outputs(&mut self) {
        const ALL: i128 = 0xFFFF_FFFF;
        for (index, object) in &mut self.objects {
            let default = match index {
                0x6005 => 1,
                0x6006 | 0x6050..=0x6057 | 0x6106 | 0x6126 => ALL,
                0x6206 | 0x6250..=0x6257 | 0x6306 | 0x6326 => ALL,
                0x6208 | 0x6270..=0x6277 | 0x6308 | 0x6328 => ALL,
                0x6421 => 7,
                0x6443 => 1,
                _ => continue,
            };
            let is_array = object.entries.len() > 1;
            for (sub, entry) in &mut object.entries {
                let bits = entry.data.octets().unwrap_or_default() * 8;
                let is_mask = matches!(entry.data.kind(), ValueKind::Unsigned | ValueKind::Boolean);
                let mask = if entry.data == DataType::Boolean { 1 } else { (1_i128 << bits.min(32)) - 1 };
                if entry.content == Content::None && is_mask && (*sub > 0 || !is_array) {
                    entry.content = Content::Whole(Number { offset: default & mask, node_id: false });
                }
            }
        }
    }

    /// 6200h of CiA 406 is the event timer of TPDO 1 by another name: both have the same default.
    fn tie_cyclic_timer(&mut self, added: &mut Vec<String>) {
        let Some(cyclic) = self.entry(0x6200, 0).filter(|entry| entry.data == DataType::U16) else { return };
        let millis = cyclic.content.clone();
        let Some(tpdo) = self.objects.get_mut(&0x1800) else { return };
        let timer = tpdo.entries.entry(5).or_insert_with(|| {
            added.push("1800h:05 Event timer is missing: it is 6200h".into());
            Entry {
                content: Content::None,
                ..entry("Event timer", DataType::U16, Rights::ReadWrite, Number::default())
            }
        });
        if matches!(timer.content, Content::None) || timer.content == Content::Whole(Number::default()) {
            timer.content = millis;
        } else if let content = timer.content.clone()
            && let Some(cyclic) = self.entry_mut(0x6200, 0)
        {
            cyclic.content = content;
        }
    }

    /// PDOs without a section have the communication parameters of CompactPDO, and an empty mapping.
    fn add_pdos(&mut self, added: &mut Vec<String>) {
        const PARAMETERS: [(&str, DataType); 6] = [
            ("COB-ID", DataType::U32),
            ("Transmission type", DataType::U8),
            ("Inhibit time", DataType::U16),
            ("Reserved", DataType::U8),
            ("Event timer", DataType::U16),
            ("SYNC start value", DataType::U8),
        ];
        let [receive, transmit] = self.device.pdos;
        for (name, count, first, base) in
            [("RPDO", receive, 0x1400_u16, 0x200_u32), ("TPDO", transmit, 0x1800, 0x180)]
        {
            let count = u16::try_from(count.unwrap_or_default()).unwrap_or(u16::MAX).min(MOST_PDOS);
            for number in 0..count {
                let (index, mapping) = (first + number, first + number + TO_MAPPING);
                if self.objects.contains_key(&index) || self.objects.contains_key(&mapping) {
                    continue;
                }
                added.push(format!("{index:04X}h {name} {} is as CompactPDO says", number + 1));
                let mask = self.device.compact_pdo;
                let subs = (1_u8..).zip(PARAMETERS).filter(|(sub, _)| mask >> (sub - 1) & 1 == 1);
                let mut parameters = BTreeMap::new();
                for (sub, (name, data)) in subs {
                    let default = match sub {
                        1 if number < 4 => {
                            Number { offset: (base + 0x100 * u32::from(number)).into(), node_id: true }
                        }
                        1 => Number { offset: OFF, node_id: false },
                        2 => Number { offset: 255, node_id: false },
                        _other => Number::default(),
                    };
                    parameters.insert(sub, entry(name, data, Rights::ReadWrite, default));
                }
                let highest = parameters.keys().next_back().copied().unwrap_or_default();
                let highest = Number { offset: highest.into(), node_id: false };
                parameters.insert(0, entry("Highest sub-index", DataType::U8, Rights::ReadOnly, highest));
                let mut mapped: BTreeMap<u8, Entry> = (1..=8)
                    .map(|sub| {
                        (sub, entry("Mapped object", DataType::U32, Rights::ReadWrite, Number::default()))
                    })
                    .collect();
                let count = entry("Mapped objects", DataType::U8, Rights::ReadWrite, Number::default());
                mapped.insert(0, count);
                let number = number + 1;
                self.objects.insert(index, record(index, format!("{name} {number}"), parameters));
                self.objects.insert(mapping, record(mapping, format!("{name} {number} mapping"), mapped));
            }
        }
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
        let object = self.objects.entry(index).or_insert_with(|| match index {
            0x1018 => record(index, "Identity object".into(), BTreeMap::new()),
            _single => Object { kind: ObjectType::Var, ..record(index, name.into(), BTreeMap::new()) },
        });
        object.entries.insert(sub, entry(name, data, Rights::ReadOnly, number));
    }
}

/// The most PDOs of one direction.
const MOST_PDOS: u16 = 0x200;
/// From a communication parameter to its mapping.
const TO_MAPPING: u16 = 0x200;
/// Bit 31 of a COB-ID: the PDO is off.
const OFF: i128 = 1 << 31;
/// What no file says is at its beginning.
const NOWHERE: Place = Place { line: 1, column: 1 };

const fn record(index: u16, name: String, entries: BTreeMap<u8, Entry>) -> Object {
    Object {
        index: Index(index),
        name,
        denotation: String::new(),
        kind: ObjectType::Record,
        group: None,
        refuses_download: false,
        refuses_scan: false,
        entries,
        place: NOWHERE,
    }
}

fn entry(name: &str, data: DataType, rights: Rights, number: Number) -> Entry {
    Entry {
        name: name.into(),
        data,
        rights,
        content: Content::Whole(number),
        mappable: false,
        low: None,
        high: None,
        file: None,
        place: NOWHERE,
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
        let mut compact = Eds::read(
            b"[DeviceInfo]\nCompactPDO=0x13\nNrOfRXPDO=1\nNrOfTXPDO=5\n[1800]\nObjectType=9\n[1800sub0]\nDataType=5\nAccessType=ro\n",
        )
        .unwrap();
        compact.complete();
        assert_eq!(compact.objects[&0x1400].entries.keys().copied().collect::<Vec<_>>(), [0, 1, 2, 5]);
        assert_eq!(compact.entry(0x1801, 1).unwrap().octets(node), [0x85, 2, 0, 0]);
        assert_eq!(compact.entry(0x1804, 1).unwrap().octets(node), [0, 0, 0, 0x80]);
        assert_eq!(compact.entry(0x1A04, 8).unwrap().octets(node), [0; 4]);
        assert!(!compact.objects.contains_key(&0x1A00) && !compact.objects.contains_key(&0x1805));
        let mut bare =
            Eds::read(b"[6040]\nDataType=6\nAccessType=rw\n[6041]\nDataType=6\nAccessType=ro\n").unwrap();
        assert_eq!(bare.complete().len(), 7);
        assert_eq!(bare.number(0x1000, 0), Some(0x0002_0192));
        assert_eq!(bare.complete(), Vec::<String>::new());
    }

    #[test]
    fn masks_of_cia_401_are_unsigned() {
        let array = |data| format!("[6326]\nObjectType=8\n[6326sub1]\nDataType={data}\nAccessType=rw\n");
        let mask = |data| {
            let text = format!("[1000]\nDataType=7\nAccessType=ro\nDefaultValue=0x191\n{}", array(data));
            let mut eds = Eds::read(text.as_bytes()).unwrap();
            eds.complete();
            eds.number(0x6326, 1)
        };
        assert_eq!([mask(7), mask(5), mask(4)], [Some(0xFFFF_FFFF), Some(0xFF), None]);
    }
}
