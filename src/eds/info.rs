//! What a file says of itself, of the device and of its commissioning; texts as they stand in the file.

use crate::can_bus::canopen::NodeId;

/// Section FileInfo.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FileInfo {
    /// FileName.
    pub name: String,
    /// FileVersion and FileRevision.
    pub version: String,
    /// EDSVersion: the version of CiA 306.
    pub eds_version: String,
    /// Description.
    pub description: String,
    /// CreatedBy.
    pub created_by: String,
    /// ModificationDate, or CreationDate without one.
    pub date: String,
}

/// Section DeviceInfo.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DeviceInfo {
    /// VendorName.
    pub vendor: String,
    /// VendorNumber.
    pub vendor_number: Option<u32>,
    /// ProductName.
    pub product: String,
    /// ProductNumber.
    pub product_number: Option<u32>,
    /// RevisionNumber.
    pub revision_number: Option<u32>,
    /// OrderCode.
    pub order_code: String,
    /// BaudRate_10 to BaudRate_1000, in kbit/s.
    pub kilobits: Vec<u16>,
    /// Granularity: the fewest bits that can be mapped; 0: mappings are fixed.
    pub granularity: Option<u8>,
    /// NrOfRXPDO and NrOfTXPDO.
    pub pdos: [Option<u32>; 2],
    /// CompactPDO: bit n is sub-index n+1 of the communication parameters of PDOs that have no section.
    pub compact_pdo: u8,
    /// LSS_Supported.
    pub lss: bool,
}

/// Section DeviceComissioning.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Commissioning {
    /// NodeID.
    pub node: Option<NodeId>,
    /// NodeName.
    pub node_name: String,
    /// Baudrate in kbit/s.
    pub kilobits: Option<u16>,
    /// NetNumber.
    pub net_number: Option<u32>,
    /// NetworkName.
    pub network_name: String,
    /// LSS_SerialNumber.
    pub serial_number: Option<u32>,
}
