//! Electronic data sheets (CiA 306) from the tables of a device (`canopen-link.md` 9).

use core::fmt::{self, Write};

use super::dictionary::{Access, Default, Entry, Limits, Mapping, Object, ObjectType};
use super::value::{DataType, ValueKind};

/// What an EDS says besides the object dictionary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sheet<'a> {
    /// The name of the file, with `.eds`.
    pub file_name: &'a str,
    /// Version of the file.
    pub file_version: u8,
    /// Revision of the file.
    pub file_revision: u8,
    /// What it describes, at most 243 characters.
    pub description: &'a str,
    /// Time, `hh:mmAM`.
    pub time: &'a str,
    /// Date, `mm-dd-yyyy`.
    pub date: &'a str,
    /// Who made the file.
    pub created_by: &'a str,
    /// Name of the vendor.
    pub vendor_name: &'a str,
    /// As in 1018h:1.
    pub vendor_number: u32,
    /// Name of the device.
    pub product_name: &'a str,
    /// As in 1018h:2.
    pub product_number: u32,
    /// As in 1018h:3.
    pub revision_number: u32,
    /// Order code.
    pub order_code: &'a str,
    /// Rates in kbit/s. Those that CiA 306 has no key for are left out.
    pub kilobits: &'a [u16],
    /// 0 if mappings are fixed, 8 if they can be written.
    pub granularity: u8,
}

impl Sheet<'_> {
    /// A first file without names and numbers, of a device with fixed mappings and the rates that every tool offers.
    pub const PLAIN: Self = Self {
        file_name: "",
        file_version: 1,
        file_revision: 0,
        description: "",
        time: "12:00AM",
        date: "01-01-2026",
        created_by: "",
        vendor_name: "",
        vendor_number: 0,
        product_name: "",
        product_number: 0,
        revision_number: 0,
        order_code: "",
        kilobits: &[125, 250, 500, 1000],
        granularity: 0,
    };
}

/// The rates that have a key.
const RATES: [u16; 8] = [10, 20, 50, 125, 250, 500, 800, 1000];

/// Writes the EDS of a device: lines end with LF.
///
/// # Errors
/// What `out` returns.
pub fn write(sheet: &Sheet<'_>, objects: &[Object], out: &mut dyn Write) -> fmt::Result {
    write_file_info(sheet, out)?;
    write_device_info(sheet, objects, out)?;
    writeln!(out, "[DummyUsage]")?;
    for number in 1..=7 {
        let usable = u8::from(sheet.granularity != 0 && number >= 2);
        writeln!(out, "Dummy{number:04}={usable}")?;
    }
    writeln!(out, "\n[Comments]\nLines=0\n")?;
    for group in [Group::Mandatory, Group::Optional, Group::Manufacturer] {
        write_group(group, objects, out)?;
    }
    Ok(())
}

fn write_file_info(sheet: &Sheet<'_>, out: &mut dyn Write) -> fmt::Result {
    let Sheet { file_name, file_version, file_revision, description, time, date, created_by, .. } = sheet;
    writeln!(out, "[FileInfo]\nFileName={file_name}\nFileVersion={file_version}")?;
    writeln!(out, "FileRevision={file_revision}\nEDSVersion=4.0\nDescription={description}")?;
    writeln!(out, "CreationTime={time}\nCreationDate={date}\nCreatedBy={created_by}")?;
    writeln!(out, "ModificationTime={time}\nModificationDate={date}\nModifiedBy={created_by}\n")
}

fn write_device_info(sheet: &Sheet<'_>, objects: &[Object], out: &mut dyn Write) -> fmt::Result {
    writeln!(
        out,
        "[DeviceInfo]\nVendorName={}\nVendorNumber=0x{:08X}",
        sheet.vendor_name, sheet.vendor_number
    )?;
    writeln!(out, "ProductName={}\nProductNumber=0x{:08X}", sheet.product_name, sheet.product_number)?;
    writeln!(out, "RevisionNumber=0x{:08X}\nOrderCode={}", sheet.revision_number, sheet.order_code)?;
    for rate in RATES {
        writeln!(out, "BaudRate_{rate}={}", u8::from(sheet.kilobits.contains(&rate)))?;
    }
    let pdos = |base: u16| {
        let in_range = objects.iter().filter(move |object| object.index.0 & 0xFE00 == base);
        in_range
            .filter(|object| object.entries.iter().any(|entry| entry.sub.0 == 1 && is_kept(entry)))
            .count()
    };
    writeln!(out, "SimpleBootUpMaster=0\nSimpleBootUpSlave=1\nGranularity={}", sheet.granularity)?;
    writeln!(out, "DynamicChannelsSupported=0\nGroupMessaging=0")?;
    writeln!(out, "NrOfRXPDO={}\nNrOfTXPDO={}\nLSS_Supported=0\n", pdos(0x1400), pdos(0x1800))
}

/// Records that stand for compatibility only are nobody's PDO.
const fn is_kept(entry: &Entry) -> bool {
    matches!(entry.home, super::dictionary::Home::Node)
}

/// The three lists of objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Group {
    Mandatory,
    Optional,
    Manufacturer,
}

impl Group {
    const fn of(index: u16) -> Self {
        match index {
            0x1000 | 0x1001 | 0x1018 => Self::Mandatory,
            0x2000..=0x5FFF => Self::Manufacturer,
            0x0000..=0x0FFF | 0x1002..=0x1017 | 0x1019..=0x1FFF | 0x6000.. => Self::Optional,
        }
    }

    const fn section(self) -> &'static str {
        match self {
            Self::Mandatory => "MandatoryObjects",
            Self::Optional => "OptionalObjects",
            Self::Manufacturer => "ManufacturerObjects",
        }
    }
}

fn write_group(group: Group, objects: &[Object], out: &mut dyn Write) -> fmt::Result {
    let members = || objects.iter().filter(move |object| Group::of(object.index.0) == group);
    writeln!(out, "[{}]\nSupportedObjects={}", group.section(), members().count())?;
    for (number, object) in (1..).zip(members()) {
        let number: u16 = number;
        writeln!(out, "{number}=0x{:04X}", object.index.0)?;
    }
    writeln!(out)?;
    for object in members() {
        write_object(object, out)?;
    }
    Ok(())
}

fn write_object(object: &Object, out: &mut dyn Write) -> fmt::Result {
    let index = object.index.0;
    let code = object.object_type.code();
    writeln!(out, "[{index:04X}]\nParameterName={}\nObjectType=0x{code:X}", object.name)?;
    match object.object_type {
        ObjectType::Var => {
            for entry in object.entries {
                write_entry(entry, out)?;
            }
        }
        ObjectType::Array | ObjectType::Record => {
            writeln!(out, "SubNumber={}\n", object.entries.len())?;
            for entry in object.entries {
                writeln!(out, "[{index:04X}sub{:X}]\nParameterName={}", entry.sub.0, entry.name)?;
                writeln!(out, "ObjectType=0x{:X}", ObjectType::Var.code())?;
                write_entry(entry, out)?;
            }
        }
    }
    Ok(())
}

fn write_entry(entry: &Entry, out: &mut dyn Write) -> fmt::Result {
    writeln!(out, "DataType=0x{:04X}\nAccessType={}", entry.data.number(), access(entry))?;
    match entry.default {
        Default::None => writeln!(out, "DefaultValue=")?,
        Default::Number(number) => {
            out.write_str("DefaultValue=")?;
            write_number(entry.data, number, out)?;
            writeln!(out)?;
        }
        Default::NodeId(base) => writeln!(out, "DefaultValue=$NODEID+0x{base:X}")?,
        Default::Real(number) => writeln!(out, "DefaultValue={number}")?,
        Default::Text(text) => writeln!(out, "DefaultValue={text}")?,
    }
    if let Some((low, high)) = ends(entry.limits) {
        for (key, end) in [("LowLimit", low), ("HighLimit", high)] {
            write!(out, "{key}=")?;
            write_number(entry.data, end, out)?;
            writeln!(out)?;
        }
    }
    let mappable = entry.mapping != Mapping::No;
    writeln!(out, "PDOMapping={}\nObjFlags=0\n", u8::from(mappable))
}

/// Numbers with sign in decimal, others in hexadecimal: never with a leading zero that would make them octal.
fn write_number(data: DataType, number: i64, out: &mut dyn Write) -> fmt::Result {
    match data.kind() {
        ValueKind::Signed | ValueKind::Real => write!(out, "{number}"),
        ValueKind::Boolean | ValueKind::Unsigned | ValueKind::Text | ValueKind::Octets => {
            write!(out, "0x{number:X}")
        }
    }
}

const fn ends(limits: Limits) -> Option<(i64, i64)> {
    match limits {
        Limits::Type | Limits::MaxLen(_) => None,
        Limits::Range(low, high) => Some((low, high)),
        Limits::Ranges(ranges) => match (ranges.first(), ranges.last()) {
            (Some(&(low, _)), Some(&(_, high))) => Some((low, high)),
            (None, _) | (_, None) => None,
        },
    }
}

const fn access(entry: &Entry) -> &'static str {
    match (entry.access, entry.mapping) {
        (Access::Const, _) => "const",
        (Access::Ro, _) => "ro",
        (Access::Wo, _) => "wo",
        (Access::Rw, Mapping::Tpdo) => "rwr",
        (Access::Rw, Mapping::Rpdo) => "rww",
        (Access::Rw, Mapping::No | Mapping::Both) => "rw",
    }
}
