//! The sections that are no objects.

use super::Reader;
use crate::can_bus::canopen::NodeId;
use crate::eds::info::{Commissioning, DeviceInfo, FileInfo};

/// The rates that have a key, in kbit/s.
const RATES: [u16; 8] = [10, 20, 50, 125, 250, 500, 800, 1000];

impl Reader<'_> {
    pub(super) fn file_info(&self) -> FileInfo {
        let Some(section) = self.sections.named("FileInfo") else { return FileInfo::default() };
        let text = |name| section.text(name).to_owned();
        let version = match (section.text("FileVersion"), section.text("FileRevision")) {
            (version, "") => version.to_owned(),
            (version, revision) => format!("{version}.{revision}"),
        };
        let date = match section.text("ModificationDate") {
            "" => section.text("CreationDate"),
            date => date,
        };
        FileInfo {
            name: text("FileName"),
            version,
            eds_version: text("EDSVersion"),
            description: text("Description"),
            created_by: text("CreatedBy"),
            date: date.to_owned(),
        }
    }

    pub(super) fn device_info(&mut self) -> DeviceInfo {
        let Some(section) = self.sections.named("DeviceInfo") else { return DeviceInfo::default() };
        let text = |name| section.text(name).to_owned();
        DeviceInfo {
            vendor: text("VendorName"),
            vendor_number: self.number(section, "VendorNumber"),
            product: text("ProductName"),
            product_number: self.number(section, "ProductNumber"),
            revision_number: self.number(section, "RevisionNumber"),
            order_code: text("OrderCode"),
            kilobits: RATES
                .into_iter()
                .filter(|rate| self.flag(section, &format!("BaudRate_{rate}")))
                .collect(),
            granularity: self.number(section, "Granularity").and_then(|bits| u8::try_from(bits).ok()),
            pdos: [self.number(section, "NrOfRXPDO"), self.number(section, "NrOfTXPDO")],
            compact_pdo: self
                .number(section, "CompactPDO")
                .and_then(|bits| u8::try_from(bits).ok())
                .unwrap_or(0),
            lss: self.flag(section, "LSS_Supported"),
        }
    }

    /// The section has one m in the standard; files write both.
    pub(super) fn commissioning(&mut self) -> Option<Commissioning> {
        let named = |name| self.sections.named(name);
        let section = named("DeviceComissioning").or_else(|| named("DeviceCommissioning"))?;
        let node = section.key("NodeID").copied().and_then(|key| Some((key, self.number_of(&key)?)));
        let node = node.and_then(|(key, number)| {
            let node = u8::try_from(number).ok().and_then(|number| NodeId::new(number).ok());
            if node.is_none() {
                self.warn(key.place, format!("NodeID is {number}, expected 1..127: it is ignored"));
            }
            node
        });
        Some(Commissioning {
            node,
            node_name: section.text("NodeName").to_owned(),
            kilobits: self.number(section, "Baudrate").and_then(|rate| u16::try_from(rate).ok()),
            net_number: self.number(section, "NetNumber"),
            network_name: section.text("NetworkName").to_owned(),
            serial_number: self.number(section, "LSS_SerialNumber"),
        })
    }

    pub(super) fn dummies(&mut self) -> u8 {
        let Some(section) = self.sections.named("DummyUsage") else { return 0 };
        (1..=7)
            .filter(|number| self.flag(section, &format!("Dummy{number:04}")))
            .fold(0, |bits, number| bits | 1 << number)
    }
}
