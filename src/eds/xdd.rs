//! XDD and XDC (CiA 311): the same device in XML, made the sections of an EDS.

use std::collections::HashMap;

use roxmltree::{Document, Node, ParsingOptions};

use super::ReadError;
use super::lines::{Key, Section};
use crate::device_file::Place;

/// The most elements, attributes and texts: real files have some ten thousand.
const MOST_NODES: u32 = 2_000_000;

/// Whether a text is XML.
pub(super) fn is_xml(text: &str) -> bool {
    text.trim_start().starts_with('<')
}

/// A section, whose keys are no text of the file.
pub(super) struct Written {
    name: String,
    place: Place,
    keys: Vec<(&'static str, String)>,
}

impl Written {
    fn new(name: impl Into<String>, place: Place) -> Self {
        Self { name: name.into(), place, keys: Vec::new() }
    }

    fn add(&mut self, key: &'static str, value: Option<impl Into<String>>) {
        self.keys.extend(value.map(|value| (key, value.into())));
    }

    /// As the reader takes it.
    pub(super) fn section(&self) -> Section<'_> {
        let keys = self.keys.iter().map(|(name, value)| Key { name, value, place: self.place });
        Section::new(&self.name, self.place, keys.collect())
    }
}

/// The sections of a file.
pub(super) fn sections(text: &str) -> Result<Vec<Written>, ReadError> {
    let options = ParsingOptions { nodes_limit: MOST_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).map_err(|error| {
        let position = error.pos();
        ReadError::Xml { place: Place { line: position.row, column: position.col } }
    })?;
    let reader = Reader::of(&document);
    let objects = reader.all("CANopenObject").collect::<Vec<_>>();
    if objects.is_empty() {
        return Err(ReadError::OtherXml { place: reader.place(document.root_element()) });
    }
    let mut sections = vec![reader.file_info(), reader.device_info()];
    sections.extend(reader.commissioning());
    sections.extend(reader.dummies());
    for object in objects {
        let index = object.attribute("index").unwrap_or_default();
        sections.push(reader.object(object, index.to_owned()));
        for sub in object.children().filter(|child| is(*child, "CANopenSubObject")) {
            let name = format!("{index}sub{}", sub.attribute("subIndex").unwrap_or_default());
            sections.push(reader.object(sub, name));
        }
    }
    Ok(sections)
}

/// Whether an element has that name in whatever namespace.
fn is(node: Node<'_, '_>, name: &str) -> bool {
    node.is_element() && node.tag_name().name() == name
}

struct Reader<'a, 'input> {
    document: &'a Document<'input>,
    /// Where each line begins.
    lines: Vec<usize>,
    /// What `uniqueIDRef` of an object refers to.
    parameters: HashMap<&'a str, Node<'a, 'input>>,
}

impl<'a, 'input> Reader<'a, 'input> {
    fn of(document: &'a Document<'input>) -> Self {
        let text = document.input_text();
        let lines = core::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect();
        let mut this = Self { document, lines, parameters: HashMap::new() };
        let named = this.all("parameter").filter_map(|node| Some((node.attribute("uniqueID")?, node)));
        this.parameters = named.collect();
        this
    }

    fn all(&self, name: &'static str) -> impl Iterator<Item = Node<'a, 'input>> + use<'a, 'input> {
        self.document.descendants().filter(move |node| is(*node, name))
    }

    fn text(&self, name: &'static str) -> Option<&'a str> {
        self.all(name).find_map(|node| node.text().map(str::trim).filter(|text| !text.is_empty()))
    }

    fn attribute(&self, element: &'static str, name: &str) -> Option<&'a str> {
        self.all(element).find_map(|node| node.attribute(name))
    }

    fn place(&self, node: Node<'_, '_>) -> Place {
        let at = node.range().start;
        let line = self.lines.partition_point(|start| *start <= at);
        let start = line.checked_sub(1).and_then(|line| self.lines.get(line)).copied().unwrap_or_default();
        let before = self.document.input_text().get(start..at).unwrap_or_default();
        let number = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
        Place { line: number(line.max(1)), column: number(before.chars().count().saturating_add(1)) }
    }

    fn section_of(&self, name: &str, element: &'static str) -> Written {
        let place = self.all(element).next().map_or(Place { line: 1, column: 1 }, |node| self.place(node));
        Written::new(name, place)
    }

    fn file_info(&self) -> Written {
        let mut section = self.section_of("FileInfo", "ProfileBody");
        for (key, attribute) in [
            ("FileName", "fileName"),
            ("FileVersion", "fileVersion"),
            ("CreatedBy", "fileCreator"),
            ("CreationDate", "fileCreationDate"),
            ("ModificationDate", "fileModificationDate"),
        ] {
            section.add(key, self.attribute("ProfileBody", attribute));
        }
        let about = self.all("productText").flat_map(|node| node.descendants());
        section
            .add("Description", about.filter(|node| is(*node, "description")).find_map(|node| node.text()));
        section
    }

    fn device_info(&self) -> Written {
        let mut section = self.section_of("DeviceInfo", "DeviceIdentity");
        for (key, element) in [
            ("VendorName", "vendorName"),
            ("VendorNumber", "vendorID"),
            ("ProductName", "productName"),
            ("ProductNumber", "productID"),
            ("OrderCode", "orderNumber"),
        ] {
            section.add(key, self.text(element));
        }
        for (key, attribute) in
            [("Granularity", "granularity"), ("NrOfRXPDO", "nrOfRxPDO"), ("NrOfTXPDO", "nrOfTxPDO")]
        {
            section.add(key, self.attribute("CANopenGeneralFeatures", attribute));
        }
        let has_lss = self.attribute("CANopenGeneralFeatures", "layerSettingServiceSlave") == Some("true");
        section.add("LSS_Supported", has_lss.then_some("1"));
        let rates: Vec<_> =
            self.all("supportedBaudRate").filter_map(|rate| rate.attribute("value")).collect();
        for (key, rate) in [
            ("BaudRate_10", "10 Kbps"),
            ("BaudRate_20", "20 Kbps"),
            ("BaudRate_50", "50 Kbps"),
            ("BaudRate_125", "125 Kbps"),
            ("BaudRate_250", "250 Kbps"),
            ("BaudRate_500", "500 Kbps"),
            ("BaudRate_800", "800 Kbps"),
            ("BaudRate_1000", "1000 Kbps"),
        ] {
            section.add(key, rates.contains(&rate).then_some("1"));
        }
        section
    }

    /// Of an XDC.
    fn commissioning(&self) -> Option<Written> {
        let node = self.all("deviceCommissioning").next()?;
        let mut section = Written::new("DeviceComissioning", self.place(node));
        section.add("NodeID", node.attribute("nodeID"));
        section.add("NodeName", node.attribute("nodeName"));
        section.add("NetNumber", node.attribute("networkNumber"));
        section.add("NetworkName", node.attribute("networkName"));
        let rate = node.attribute("actualBaudRate").and_then(|rate| rate.split(' ').next());
        section.add("Baudrate", rate);
        Some(section)
    }

    /// `<dummy entry="Dummy0001=0"/>`
    fn dummies(&self) -> Option<Written> {
        const NAMES: [&str; 7] =
            ["Dummy0001", "Dummy0002", "Dummy0003", "Dummy0004", "Dummy0005", "Dummy0006", "Dummy0007"];
        let mut section = Written::new("DummyUsage", self.place(self.all("dummyUsage").next()?));
        for (name, value) in self.all("dummy").filter_map(|dummy| dummy.attribute("entry")?.split_once('=')) {
            let known = NAMES.iter().find(|known| known.eq_ignore_ascii_case(name.trim()));
            section.keys.extend(known.map(|known| (*known, value.trim().to_owned())));
        }
        Some(section)
    }

    /// An object or a part of it: what it says itself, else what its parameter says.
    fn object(&self, node: Node<'a, 'input>, name: String) -> Written {
        let mut section = Written::new(name, self.place(node));
        let parameter = node.attribute("uniqueIDRef").and_then(|id| self.parameters.get(id)).copied();
        let own = |name| node.attribute(name);
        let value_of = |name: &str| {
            let mut parts = parameter?.descendants();
            parts.find(|part| is(*part, name)).and_then(|part| part.attribute("value"))
        };
        section.add("ParameterName", own("name"));
        section.add("ObjectType", own("objectType"));
        let is_domain = own("objectType") == Some("2");
        let data = own("dataType").map(|digits| format!("0x{digits}"));
        let data = data.or_else(|| parameter.and_then(data_type).map(str::to_owned));
        section.add("DataType", data.filter(|_| !is_domain));
        let mapping = own("PDOmapping").unwrap_or("no");
        let access = own("accessType").or_else(|| {
            let access = parameter?.attribute("access").unwrap_or("read");
            Some(match (access, mapping) {
                ("read", _) => "ro",
                ("write", _) => "wo",
                ("readWrite", "TPDO") | ("readWriteInput", _) => "rwr",
                ("readWrite", "RPDO") | ("readWriteOutput", _) => "rww",
                ("readWrite", _) => "rw",
                (other, _) => other,
            })
        });
        section.add("AccessType", access);
        section.add("PDOMapping", Some(if mapping == "no" { "0" } else { "1" }));
        section.add("DefaultValue", own("defaultValue").or_else(|| value_of("defaultValue")));
        section.add("ParameterValue", own("actualValue").or_else(|| value_of("actualValue")));
        section.add("LowLimit", own("lowLimit").or_else(|| value_of("minValue")));
        section.add("HighLimit", own("highLimit").or_else(|| value_of("maxValue")));
        section.add("Denotation", own("denotation").or_else(|| parameter?.attribute("denotation")));
        section.add("ObjFlags", own("objFlags").map(|digits| format!("0x{digits}")));
        section
    }
}

/// The type that a parameter names as one of IEC 61131-3.
fn data_type(parameter: Node<'_, '_>) -> Option<&'static str> {
    parameter.children().filter(Node::is_element).find_map(|child| {
        Some(match child.tag_name().name() {
            "BOOL" => "0x01",
            "SINT" => "0x02",
            "INT" => "0x03",
            "DINT" => "0x04",
            "USINT" | "BYTE" | "CHAR" => "0x05",
            "UINT" | "WORD" => "0x06",
            "UDINT" | "DWORD" => "0x07",
            "REAL" => "0x08",
            "STRING" => "0x09",
            "BITSTRING" => "0x0A",
            "WSTRING" => "0x0B",
            "LREAL" => "0x11",
            "LINT" => "0x15",
            "ULINT" | "LWORD" => "0x1B",
            _ => return None,
        })
    })
}

#[cfg(test)]
mod tests {
    use crate::can_bus::canopen::NodeId;
    use crate::device_file::Hint;
    use crate::eds::{Eds, Group, Limit, Number, Rights};

    /// As CANopenEditor writes it: objects refer to parameters.
    const BY_PARAMETER: &str = r#"<?xml version="1.0" encoding="utf-8"?>
<ISO15745ProfileContainer xmlns="http://www.canopen.org/xml/1.1"><ISO15745Profile>
<q1:ProfileBody xmlns:q1="http://www.canopen.org/xml/1.1" fileName="pump.xdd" fileCreator="me" fileVersion="3">
<q1:DeviceIdentity><q1:vendorName>profidrive</q1:vendorName><q1:vendorID>0x195</q1:vendorID>
<q1:productName>Pump &amp; valve</q1:productName></q1:DeviceIdentity>
<q1:parameterList>
<q1:parameter uniqueID="P1"><UDINT/><q1:defaultValue value="0x00000191"/></q1:parameter>
<q1:parameter uniqueID="P2" access="readWrite"><INT/><q1:defaultValue value="-5"/>
<q1:allowedValues><q1:range><q1:minValue value="-9"/><q1:maxValue value="9"/></q1:range></q1:allowedValues></q1:parameter>
<q1:parameter uniqueID="P3" access="readWriteOutput"><REAL/><q1:defaultValue value="1.5"/><q1:actualValue value="2.5"/></q1:parameter>
<q1:parameter uniqueID="P4" access="const"><STRING/><q1:defaultValue value="a &lt; b"/></q1:parameter>
</q1:parameterList></q1:ProfileBody>
<q2:CANopenObjectList xmlns:q2="x">
<q2:CANopenObject index="1000" name="Device type" objectType="7" PDOmapping="no" uniqueIDRef="P1"/>
<q2:CANopenObject index="1001" name="Error register" objectType="7" dataType="0005" accessType="ro"/><q2:CANopenObject index="1018" name="Identity" objectType="9"><q2:CANopenSubObject subIndex="00" name="Highest" dataType="0005" accessType="ro"/><q2:CANopenSubObject subIndex="01" name="Vendor" dataType="0007" accessType="ro" defaultValue="0x195"/></q2:CANopenObject>
<q2:CANopenObject index="1008" name="Name" objectType="7" uniqueIDRef="P4"/>
<q2:CANopenObject index="2000" name="Both" objectType="9" subNumber="3">
<q2:CANopenSubObject subIndex="00" name="Highest" objectType="7" dataType="0005" accessType="const" defaultValue="0x0B"/>
<q2:CANopenSubObject subIndex="01" name="Speed" objectType="7" PDOmapping="TPDO" uniqueIDRef="P2"/>
<q2:CANopenSubObject subIndex="0B" name="Gain" objectType="7" PDOmapping="optional" uniqueIDRef="P3"/>
</q2:CANopenObject>
<q2:CANopenObject index="2001" name="Program" objectType="2" accessType="rw" dataType="000F"/>
</q2:CANopenObjectList>
<dummyUsage><dummy entry="Dummy0005=1"/></dummyUsage>
<baudRate><supportedBaudRate value="125 Kbps"/><supportedBaudRate value="1000 Kbps"/></baudRate>
<CANopenGeneralFeatures nrOfRxPDO="0" layerSettingServiceSlave="true"/>
<deviceCommissioning nodeID="7" nodeName="Left" actualBaudRate="125 Kbps"/>
</ISO15745Profile></ISO15745ProfileContainer>"#;

    #[test]
    fn both_ways_to_say_what_an_object_is_are_read() {
        let eds = Eds::read(BY_PARAMETER.as_bytes()).unwrap();
        assert_eq!(eds.hints, Vec::<Hint>::new());
        // XDD has no lists of objects: the index says which group each belongs to.
        let groups = [(0x1000, Group::Mandatory), (0x1008, Group::Optional), (0x2000, Group::Manufacturer)];
        for (index, group) in groups {
            assert_eq!(eds.objects[&index].group, Some(group), "{index:04X}");
        }
        let node = NodeId::new(5).unwrap();
        let octets = |index, sub| eds.entry(index, sub).unwrap().octets(node);
        assert_eq!(octets(0x1000, 0), [0x91, 1, 0, 0]);
        assert_eq!(octets(0x1008, 0), b"a < b");
        assert_eq!([octets(0x2000, 0), octets(0x2000, 1)], [vec![11], vec![0xFB, 0xFF]]);
        assert_eq!(octets(0x2000, 11), 2.5_f32.to_le_bytes(), "what an XDC sets wins");
        assert_eq!(octets(0x2001, 0), b"");
        let (speed, gain) = (eds.entry(0x2000, 1).unwrap(), eds.entry(0x2000, 11).unwrap());
        assert_eq!((speed.rights, gain.rights), (Rights::ReadWriteSent, Rights::ReadWriteReceived));
        assert!(speed.mappable && gain.mappable && !eds.entry(0x1000, 0).unwrap().mappable);
        let limit = |offset| Some(Limit::Whole(Number { offset, node_id: false }));
        assert_eq!((speed.low, speed.high), (limit(-9), limit(9)));
        let device = &eds.device;
        assert_eq!((&*device.vendor, &*device.product, device.lss), ("profidrive", "Pump & valve", true));
        assert_eq!((&device.kilobits[..], eds.dummies), (&[125, 1000][..], 1 << 5));
        let commissioning = eds.commissioning.unwrap();
        assert_eq!((commissioning.node.map(NodeId::number), commissioning.kilobits), (Some(7), Some(125)));
    }

    #[test]
    fn a_mistake_has_its_line() {
        let odd = BY_PARAMETER
            .replace("dataType=\"0005\" accessType=\"const\"", "dataType=\"0099\" accessType=\"const\"");
        let hints: Vec<_> =
            Eds::read(odd.as_bytes()).unwrap().hints.iter().map(ToString::to_string).collect();
        assert_eq!(
            hints,
            ["line 18, column 1: warning: DataType 0099h is no type of a value: UNSIGNED32 is assumed"]
        );
    }

    #[test]
    fn what_is_no_xdd_is_refused_with_its_place() {
        let refused = |text: &str| Eds::read(text.as_bytes()).unwrap_err().to_string();
        assert_eq!(
            refused("<a>\n<b></c></a>"),
            "line 2, column 4: the file begins as XML and is none from here on"
        );
        assert_eq!(
            refused("<?xml version=\"1.0\"?>\n<svg/>"),
            "line 2, column 1: XML without a CANopenObject: this is no XDD of a CANopen node"
        );
        // Entities would grow.
        let bomb = "<!DOCTYPE a [<!ENTITY b \"cc\">]><a>&b;</a>";
        assert_eq!(refused(bomb), "line 1, column 1: the file begins as XML and is none from here on");
        for end in 0..BY_PARAMETER.len() {
            let _ = Eds::read(&BY_PARAMETER.as_bytes()[..end]);
        }
        let deep = "<a>".repeat(1 << 20);
        assert!(refused(&deep).contains("begins as XML"), "{:.80}", refused(&deep));
        let wide = format!("<a>{}</a>", "<b/>".repeat(1 << 21));
        assert!(refused(&wide).contains("begins as XML"), "{:.80}", refused(&wide));
    }
}
