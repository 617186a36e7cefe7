//! Files as they are met, read.

use super::*;
use crate::can_bus::canopen::NodeId;
use crate::can_bus::canopen::dictionary::ObjectType;
use crate::can_bus::canopen::value::DataType;

/// A file with the three objects of every node, and these sections.
fn file(sections: &str) -> String {
    format!(
        "[1000]\nParameterName=Device type\nObjectType=7\nDataType=7\nAccessType=ro\nDefaultValue=0x00020192\n\
         [1001]\nParameterName=Error register\nObjectType=7\nDataType=5\nAccessType=ro\n\
         [1018]\nParameterName=Identity\nObjectType=9\nSubNumber=2\n\
         [1018sub0]\nParameterName=Highest\nDataType=5\nAccessType=const\nDefaultValue=1\n\
         [1018sub1]\nParameterName=Vendor\nDataType=7\nAccessType=ro\nDefaultValue=0x195\n\
         [MandatoryObjects]\nSupportedObjects=3\n1=0x1000\n2=0x1001\n3=0x1018\n{sections}"
    )
}

fn read(sections: &str) -> Eds {
    Eds::read(file(sections).as_bytes()).unwrap()
}

/// What is said of these sections, without the places.
fn hints(sections: &str) -> Vec<String> {
    read(sections).hints.into_iter().map(|hint| hint.text).collect()
}

fn octets(eds: &Eds, index: u16, sub: u8, node: u8) -> Vec<u8> {
    eds.entry(index, sub).unwrap().octets(NodeId::new(node).unwrap())
}

#[test]
fn a_plain_file_has_nothing_odd() {
    let eds = read("");
    assert_eq!(eds.hints, []);
    assert_eq!(eds.profile(), Profile::Drive);
    assert_eq!(octets(&eds, 0x1018, 1, 1), [0x95, 1, 0, 0]);
    assert_eq!(eds.objects[&0x1000].group, Some(Group::Mandatory));
    assert_eq!((eds.objects[&0x1018].kind, eds.entry(0x1018, 2)), (ObjectType::Record, None));
}

#[test]
fn eds_02_what_is_no_eds_is_refused_with_the_reason() {
    for (text, error) in [
        ("", ReadError::Empty),
        (" \r\n", ReadError::Empty),
        ("hello", ReadError::NoSection),
        ("#Profibus_DP\nIdent_Number=1\n", ReadError::Gsd),
        ("[FileInfo]\nFileName=a.eds\n[0005]\nParameterName=Type\n[10]\n[1018subX]\n", ReadError::NoObject),
    ] {
        assert_eq!(Eds::read(text.as_bytes()), Err(error), "{text}");
    }
    let other = Eds::read(b"[File]\nDescText = \"x\";\n[Device]\nVendCode = 1;\n[Device Classification]\nClass1 = EtherNetIP;\n");
    assert!(matches!(other, Err(ReadError::OtherBus { place }) if place.line == 5), "{other:?}");
    assert_eq!(Eds::read(b"\xFF\xFE[\0"), Err(ReadError::Utf16));
    assert_eq!(Eds::read(&vec![b'\n'; MAX_FILE_LEN + 1]), Err(ReadError::TooLong { got: MAX_FILE_LEN + 1 }));
    let many: String = (0x2000..0x2400)
        .map(|index| format!("[{index:X}]\nObjectType=8\nCompactSubObj=254\nDataType=7\nAccessType=rw\n"))
        .collect();
    assert!(matches!(Eds::read(many.as_bytes()), Err(ReadError::TooManyEntries { .. })));
}

#[test]
fn eds_06_node_id_in_defaults_and_limits_at_two_nodes() {
    let eds = read(
        "[OptionalObjects]\n1=0x1014\n[1014]\nParameterName=EMCY\nDataType=7\nAccessType=rw\nDefaultValue=$NodeID+0x80\nLowLimit=$NODEID+0x80\nHighLimit=0xFFFFFFFF\n",
    );
    assert_eq!(eds.hints, []);
    assert_eq!(
        (octets(&eds, 0x1014, 0, 5), octets(&eds, 0x1014, 0, 127)),
        (vec![0x85, 0, 0, 0], vec![0xFF, 0, 0, 0])
    );
    let low = eds.entry(0x1014, 0).unwrap().low;
    assert_eq!(low, Some(Limit::Whole(Number { offset: 0x80, node_id: true })));
}

#[test]
fn eds_07_a_parameter_value_wins_if_it_is_not_blank() {
    let eds = read(
        "[DeviceComissioning]\nNodeID=0x07\nBaudrate=250\nNodeName=Pump\nLSS_SerialNumber=99\n\
         [ManufacturerObjects]\n1=0x2000\n2=0x2001\n\
         [2000]\nParameterName=A\nDataType=6\nAccessType=rw\nDefaultValue=1\nParameterValue=2\n\
         [2001]\nParameterName=B\nDataType=6\nAccessType=rw\nDefaultValue=1\nParameterValue=\n",
    );
    assert_eq!(eds.hints, []);
    assert_eq!((octets(&eds, 0x2000, 0, 1), octets(&eds, 0x2001, 0, 1)), (vec![2, 0], vec![1, 0]));
    let commissioning = eds.commissioning.unwrap();
    assert_eq!(commissioning.node, NodeId::new(7).ok());
    assert_eq!((commissioning.kilobits, commissioning.serial_number), (Some(250), Some(99)));
}

#[test]
fn eds_12_compact_sub_objects_with_their_names_and_values() {
    let eds = read(
        "[OptionalObjects]\n1=0x1003\n\
         [1003]\nParameterName=Errors\nObjectType=8\nDataType=7\nAccessType=ro\nCompactSubObj=254\nDefaultValue=3\n\
         [1003Name]\nNrOfEntries=1\n2=Older\n[1003Value]\nNrOfEntries=1\n2=0x12\n[1003sub4]\nParameterName=Own\nDataType=5\nAccessType=rw\n",
    );
    assert_eq!(eds.hints, []);
    let object = &eds.objects[&0x1003];
    assert_eq!((object.kind, object.entries.len()), (ObjectType::Array, 255));
    assert_eq!(octets(&eds, 0x1003, 0, 1), [254]);
    assert_eq!(octets(&eds, 0x1003, 254, 1), [3, 0, 0, 0]);
    assert_eq!(
        (eds.entry(0x1003, 2).unwrap().name.as_str(), octets(&eds, 0x1003, 2, 1)),
        ("Older", vec![0x12, 0, 0, 0])
    );
    assert_eq!(eds.entry(0x1003, 4).unwrap().data, DataType::U8);
    assert_eq!(eds.entry(0x1003, 255), None);
}

#[test]
fn eds_13_lists_that_are_wrong_cost_nothing() {
    let sections = "[OptionalObjects]\nSupportedObjects=5\n1=0x1017\n2=0x1010\n\
         [1017]\nParameterName=Heartbeat\nDataType=6\nAccessType=rw\n[1005]\nParameterName=SYNC\nDataType=7\nAccessType=rw\n[2000]\nParameterName=X\nDataType=5\nAccessType=ro\n";
    assert_eq!(
        hints(sections),
        [
            "SupportedObjects is 5, but 2 objects follow: all of them count",
            "1010h has no section of its own: it is not served",
            "1005h stands in no list of objects, such as [OptionalObjects]: it is served",
            "section [ManufacturerObjects] is missing: 1 objects stand in no list and are served",
        ]
    );
    assert!(read(sections).entry(0x1005, 0).is_some());
}

#[test]
fn eds_14_sub_0_is_the_highest_where_the_file_says_nothing() {
    let eds = read(
        "[ManufacturerObjects]\n1=0x2000\n2=0x2001\n\
         [2000]\nParameterName=A\nObjectType=9\n[2000sub0]\nParameterName=n\nDataType=5\nAccessType=ro\n[2000sub5]\nParameterName=x\nDataType=5\nAccessType=ro\n\
         [2001]\nParameterName=B\nObjectType=9\n[2001sub1]\nParameterName=x\nDataType=5\nAccessType=ro\n",
    );
    assert_eq!((octets(&eds, 0x2000, 0, 1), octets(&eds, 0x2001, 0, 1)), (vec![5], vec![1]));
    assert_eq!(eds.entry(0x2000, 1), None);
    assert_eq!(eds.hints.len(), 1, "{:?}", eds.hints);
}

#[test]
fn eds_19_limits_that_are_none_and_limits_that_hold() {
    let entry = |keys: &str| {
        let sections =
            format!("[ManufacturerObjects]\n1=0x2000\n[2000]\nParameterName=A\nAccessType=rw\n{keys}");
        let eds = read(&sections);
        let entry = eds.entry(0x2000, 0).unwrap();
        let whole = |limit| match limit {
            Some(Limit::Whole(number)) => Some(number.offset),
            Some(Limit::Real(_)) | None => None,
        };
        (whole(entry.low), whole(entry.high), eds.hints.len())
    };
    assert_eq!(entry("DataType=3\nLowLimit=0x8000\nHighLimit=0x7FFF\n"), (Some(-0x8000), Some(0x7FFF), 0));
    assert_eq!(entry("DataType=3\nLowLimit=\nHighLimit=100\n"), (None, Some(100), 0));
    assert_eq!(entry("DataType=3\nLowLimit=0\nHighLimit=0\n"), (None, None, 1));
    assert_eq!(entry("DataType=3\nLowLimit=5\nHighLimit=-5\n"), (None, None, 1));
    assert_eq!(entry("DataType=5\nLowLimit=0\nHighLimit=256\n"), (Some(0), None, 1));
    assert_eq!(entry("DataType=9\nLowLimit=0\nHighLimit=256\n"), (None, None, 0));
}

#[test]
fn what_is_wrong_with_an_object_is_told_and_costs_no_more() {
    for (keys, said, served) in [
        (
            "ObjectType=7\nDataType=7\nAccessType=nonsense\n",
            "AccessType is 'nonsense', expected ro, wo, rw, rwr, rww or const: ro is assumed",
            true,
        ),
        ("DataType=7\n", "AccessType of [2000] is missing: ro is assumed", true),
        (
            "DataType=0x40\nAccessType=rw\n",
            "DataType 0040h is no type of a value: UNSIGNED32 is assumed",
            true,
        ),
        ("AccessType=rw\n", "DataType is missing: UNSIGNED32 is assumed", true),
        (
            "DataType=5\nAccessType=rw\nDefaultValue=300\n",
            "DefaultValue: '300' is beyond its type: the value is 0",
            true,
        ),
        (
            "DataType=5\nAccessType=rw\nDefaultValue=0.0\n",
            "DefaultValue: a whole number has no decimal point",
            true,
        ),
        ("ObjectType=8\n", "2000h has no sub-index: it is not served", false),
        (
            "ObjectType=5\nDataType=7\nAccessType=ro\n",
            "ObjectType of 2000h is 5, expected 2, 7, 8 or 9: it is not served",
            false,
        ),
        (
            "DataType=7\nAccessType=rw\n[2000sub1]\nDataType=5\nAccessType=ro\n[2000sub0]\nDataType=5\nAccessType=ro\n",
            "2000h is a VAR with sub-indexes: it is taken as a RECORD",
            true,
        ),
    ] {
        let sections = format!("[2000]\nParameterName=A\n{keys}[ManufacturerObjects]\n1=0x2000\n");
        let eds = read(&sections);
        let texts: Vec<_> = eds.hints.iter().map(|hint| hint.text.as_str()).collect();
        assert!(texts.contains(&said), "{keys}: {texts:?}");
        assert_eq!(eds.objects.contains_key(&0x2000), served, "{keys}");
    }
}

#[test]
fn contradictions_between_parts_of_a_file_are_told() {
    let said = hints(
        "[DeviceInfo]\nVendorName=V\nVendorNumber=0x196\nNrOfTXPDO=4\nNrOfRXPDO=0\n[DummyUsage]\nDummy0005=1\n\
         [OptionalObjects]\n1=0x1800\n2=0x1A00\n[1800]\nParameterName=T\nObjectType=9\nSubNumber=2\n[1800sub0]\nDataType=5\nAccessType=ro\n\
         [1800sub1]\nDataType=7\nAccessType=rw\nDefaultValue=0x185\n\
         [1A00]\nParameterName=M\nObjectType=9\nSubNumber=6\n[1A00sub0]\nDataType=5\nAccessType=rw\n\
         [1A00sub1]\nDataType=7\nAccessType=rw\nDefaultValue=0x10010008\n[1A00sub2]\nDataType=7\nAccessType=rw\nDefaultValue=0x20000008\n\
         [1A00sub3]\nDataType=7\nAccessType=rw\nDefaultValue=0x00050008\n[1A00sub4]\nDataType=7\nAccessType=rw\nDefaultValue=0x00060010\n\
         [1A00sub5]\nDataType=7\nAccessType=rw\nDefaultValue=0x10000010\n",
    );
    for text in [
        "VendorNumber is 196h, but 1018h:1 is 195h: 1018h:1 holds",
        "NrOfTXPDO is 4, but 1 have communication parameters: these count",
        "1A00h:01 maps 1001h:00, whose PDOMapping is 0",
        "1A00h:02 maps 2000h:00, which the file does not have",
        "1A00h:04 maps 0006h:00, a gap that DummyUsage does not allow",
    ] {
        assert!(said.iter().any(|said| said == text), "{text} of {said:#?}");
    }
    assert!(!said.iter().any(|said| said.contains("1A00h:03")), "{said:#?}");
    assert!(said.iter().any(|said| said.contains("1800h:01 is 185h at every node-ID")), "{said:#?}");
    assert!(!said.iter().any(|said| said.starts_with("NrOfRXPDO")), "{said:#?}");
}

#[test]
fn eds_64_without_a_device_type_the_objects_of_a_profile_tell_it() {
    let profile = |sections: &str| {
        let text = format!("[1000]\nDataType=7\nAccessType=ro\n{sections}");
        Eds::read(text.as_bytes()).unwrap().profile()
    };
    let word = |index| format!("[{index}]\nDataType=6\nAccessType=rw\n");
    assert_eq!(profile(""), Profile::None);
    assert_eq!(profile(&(word("6040") + &word("6041"))), Profile::Drive);
    assert_eq!(profile(&word("6040")), Profile::None);
    assert_eq!(profile(&word("6200")), Profile::InputsOutputs);
    // 6000h of CiA 406 is one number, that of CiA 401 an array.
    assert_eq!(profile(&(word("6000") + &word("6004"))), Profile::Encoder);
    assert_eq!(profile(&(word("6000") + &word("6000sub1") + &word("6004"))), Profile::InputsOutputs);
    assert_eq!(Profile::Other(410).to_string(), "CiA 410");
}

#[test]
fn any_end_and_any_damage_of_a_file_is_read_or_refused() {
    let text = file(
        "[DeviceComissioning]\nNodeID=5\n[1003]\nParameterName=E\nObjectType=8\nDataType=7\nAccessType=ro\nCompactSubObj=3\n\
         [1A00]\nParameterName=M\nObjectType=9\n[1A00sub0]\nDataType=5\nAccessType=rw\n[1A00sub1]\nDataType=7\nAccessType=rw\nDefaultValue=0x10010008\n\
         [2000]\nParameterName=S\nDataType=9\nAccessType=ro\nDefaultValue=f\u{fc}r\nLowLimit=-0x80\nHighLimit=$NODEID+1\n",
    );
    for end in 0..text.len() {
        let _ = Eds::read(&text.as_bytes()[..end]);
    }
    for at in 0..text.len() {
        for octet in [0, b'0', b'-', b'$', b'[', b'=', 0xFF] {
            let mut damaged = text.clone().into_bytes();
            damaged[at] = octet;
            if let Ok(eds) = Eds::read(&damaged) {
                for entry in eds.objects.values().flat_map(|object| object.entries.values()) {
                    let _ = entry.octets(NodeId::new(127).unwrap());
                }
            }
        }
    }
}

#[test]
fn sections_with_0x_in_their_name_are_objects() {
    let eds = read(
        "[OptionalObjects]\n1=0x1017\n2=0x1003\n[0x1017]\nParameterName=Heartbeat\nDataType=6\nAccessType=rw\nDefaultValue=9\n\
         [0X1003]\nParameterName=Errors\nObjectType=8\n[0x1003sub0]\nDataType=5\nAccessType=rw\n[0x1003sub1]\nDataType=7\nAccessType=ro\n",
    );
    assert_eq!(
        eds.hints.iter().map(ToString::to_string).collect::<Vec<_>>(),
        ["line 34, column 1: warning: '0x' in the name of a section, as in [0x1017], is left out"]
    );
    assert_eq!((octets(&eds, 0x1017, 0, 1), octets(&eds, 0x1003, 0, 1)), (vec![9, 0], vec![1]));
}

#[test]
fn a_highest_sub_index_beyond_its_type_is_0() {
    let array = "[OptionalObjects]\n1=0x6020\n[6020]\nParameterName=Inputs\nObjectType=8\n[6020sub0]\nDataType=1\nAccessType=ro\n\
         [6020sub3]\nDataType=1\nAccessType=ro\n";
    assert_eq!(
        hints(array),
        ["sub-index 0 of 6020h has no default, and the highest sub-index, 3, is beyond BOOLEAN: it is 0"]
    );
    assert_eq!(octets(&read(array), 0x6020, 0, 1), [0]);
}
