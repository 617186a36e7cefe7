//! A node that a file describes, as a master sees it (`eds.md` 6, E-03 to E-51).
#![cfg(feature = "eds")]

use std::fs;
use std::path::Path;
use std::time::Duration;

use profidrive::can_bus::can::{Frame, Id};
use profidrive::can_bus::canopen::{Home, NodeId};
use profidrive::devices::CanopenDevice;
use profidrive::devices::from_eds::Dictionary;
use profidrive::eds::{Eds, Profile, Rights};
use profidrive::face::surroundings::Level;
use proptest::prelude::*;

use crate::file_node::{NODE, Rig, held, var};

#[test]
fn eds_14_to_16_what_is_not_there_and_what_may_not_be_done() {
    let text =
        var(0x2000, 5, "ro", "") + &var(0x2001, 5, "const", "DefaultValue=3") + &var(0x2002, 5, "wo", "");
    let mut rig = Rig::text(&text);
    assert_eq!(rig.read(0x2100, 0), Err(0x0602_0000));
    assert_eq!(rig.read(0x2000, 1), Err(0x0609_0011));
    assert_eq!(rig.write(0x2000, 0, &[1]), Err(0x0601_0002));
    assert_eq!(rig.write(0x2001, 0, &[1]), Err(0x0601_0002));
    assert_eq!(rig.read(0x2001, 0), Ok(vec![3]));
    assert_eq!(rig.write(0x2002, 0, &[1]), Ok(()));
    assert_eq!(rig.read(0x2002, 0), Err(0x0601_0001));
    assert_eq!(rig.sdo([0xE0, 0, 0x20, 0, 0, 0, 0, 0])[4..], 0x0504_0001_u32.to_le_bytes());
}

#[test]
fn eds_19_limits_in_every_form_that_files_have() {
    for (data, limits, good, low, high) in [
        (5, "LowLimit=2\nHighLimit=9", &[&[2][..], &[9]][..], &[1][..], &[10][..]),
        (3, "LowLimit=0xFFFE\nHighLimit=", &[&[0xFE, 0xFF], &[0xFF, 0x7F]], &[0xFD, 0xFF], &[]),
        (
            7,
            "LowLimit=$NODEID+0x600\nHighLimit=0x700",
            &[&[5, 6, 0, 0], &[0, 7, 0, 0]],
            &[4, 6, 0, 0],
            &[1, 7, 0, 0],
        ),
        (
            0x1B,
            "LowLimit=1\nHighLimit=0xFFFFFFFFFFFFFFFE",
            &[&[1, 0, 0, 0, 0, 0, 0, 0], &[0xFE, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF]],
            &[0; 8],
            &[0xFF; 8],
        ),
        (
            8,
            "LowLimit=-1\nHighLimit=1.5",
            &[&[0, 0, 0x80, 0xBF], &[0, 0, 0xC0, 0x3F]],
            &[0, 0, 0, 0xC0],
            &[0, 0, 0, 0x40],
        ),
    ] {
        let mut rig = Rig::text(&var(0x2000, data, "rw", limits));
        for value in good {
            assert_eq!(rig.write(0x2000, 0, value), Ok(()), "{limits}: {value:02X?}");
        }
        let last = rig.read(0x2000, 0);
        assert_eq!(rig.write(0x2000, 0, low), Err(0x0609_0032), "{limits}");
        if !high.is_empty() {
            assert_eq!(rig.write(0x2000, 0, high), Err(0x0609_0031), "{limits}");
        }
        assert_eq!(rig.read(0x2000, 0), last, "{limits}");
    }
}

#[test]
fn eds_25_the_heartbeat_of_the_file_runs_from_the_start() {
    let mut rig = Rig::file("pump.eds");
    assert_eq!(rig.pass(Duration::from_millis(1000)), ["705#7F", "705#7F"]);
    rig.write(0x1017, 0, &[100, 0]).unwrap();
    assert_eq!(rig.pass(Duration::from_millis(1000)).len(), 10);
    rig.write(0x1017, 0, &[0, 0]).unwrap();
    assert_eq!(rig.pass(Duration::from_secs(10)), [""; 0]);
}

#[test]
fn eds_32_eds_38_eds_40_pdos_as_the_file_maps_them() {
    let mut rig = Rig::file("pump.eds");
    rig.start();
    // One octet that nobody takes, then the speed.
    rig.data(0x205, &[0xEE, 0x34, 0x12]);
    assert_eq!(rig.read(0x2000, 0), Ok(vec![0x34, 0x12]));
    assert_eq!(rig.sync(), ["185#0000C03FFEFFFF"], "pressure and position");
    rig.set("2001h", Level::Number(2.0));
    assert_eq!(rig.sync(), ["185#00000040FEFFFF"]);
    assert_eq!(rig.read(0x2001, 0), Ok(2.0_f32.to_le_bytes().to_vec()));
    assert_eq!(rig.data(0x205, &[0xEE, 1]), ["085#1082110000000000"], "too short");
    assert_eq!(rig.number(0x2000, 0), 0x1234);
}

#[test]
fn eds_41_a_mapping_changes_by_the_rule_only() {
    let mut rig = Rig::file("pump.eds");
    let word = |word: u32| word.to_le_bytes();
    assert_eq!(rig.write(0x1A00, 0, &[0]), Err(0x0800_0022), "the PDO is on");
    rig.write(0x1800, 1, &word(0xC000_0185)).unwrap();
    rig.write(0x1A00, 0, &[0]).unwrap();
    assert_eq!(rig.write(0x1A00, 1, &word(0x2100_0008)), Err(0x0602_0000));
    assert_eq!(rig.write(0x1A00, 1, &word(0x2003_0040)), Err(0x0604_0041), "PDOMapping is 0");
    assert_eq!(rig.write(0x1A00, 1, &word(0x2000_0010)), Err(0x0604_0041), "rww is received only");
    rig.write(0x1A00, 1, &word(0x2002_0018)).unwrap();
    rig.write(0x1A00, 2, &word(0x2001_0020)).unwrap();
    rig.write(0x1A00, 0, &[2]).unwrap();
    rig.write(0x1800, 1, &word(0x4000_0185)).unwrap();
    rig.start();
    assert_eq!(rig.sync(), ["185#FEFFFF0000C03F"]);
}

/// 1005h, 1006h, 1019h and a TPDO of type 2 that begins with the SYNC of the counter 3.
const SYNC: &str = "[1005]\nDataType=7\nAccessType=rw\nDefaultValue=0x80000080\n[1006]\nDataType=7\nAccessType=rw\n\
    [1019]\nDataType=5\nAccessType=rw\n[1800]\nObjectType=9\nSubNumber=4\n[1800sub0]\nDataType=5\nAccessType=ro\n\
    DefaultValue=6\n[1800sub1]\nDataType=7\nAccessType=rw\nDefaultValue=$NODEID+0x180\n[1800sub2]\nDataType=5\n\
    AccessType=rw\nDefaultValue=2\n[1800sub6]\nDataType=5\nAccessType=rw\nDefaultValue=3\n[1A00]\nObjectType=9\n\
    SubNumber=2\n[1A00sub0]\nDataType=5\nAccessType=rw\nDefaultValue=1\n[1A00sub1]\nDataType=7\nAccessType=rw\n\
    DefaultValue=0x20000008\n[2000]\nDataType=5\nAccessType=ro\nDefaultValue=7\nPDOMapping=1\n";

#[test]
fn eds_43_the_node_produces_sync_with_its_counter() {
    let mut rig = Rig::text(SYNC);
    let millis = Duration::from_millis;
    let cob_id = |number: u32| number.to_le_bytes();
    rig.write(0x1019, 0, &[4]).unwrap();
    assert_eq!(rig.write(0x1019, 0, &[241]), Err(0x0609_0030));
    rig.write(0x1006, 0, &cob_id(10_000)).unwrap();
    assert_eq!(rig.write(0x1019, 0, &[5]), Err(0x0800_0022), "SYNC has a period");
    assert_eq!(rig.pass(millis(50)), [""; 0], "bit 30 is 0");
    rig.write(0x1005, 0, &cob_id(0x4000_0080)).unwrap();
    assert_eq!(rig.write(0x1005, 0, &cob_id(0x4000_0081)), Err(0x0800_0022), "it is on");
    assert_eq!(rig.pass(millis(50)), ["080#01", "080#02", "080#03", "080#04", "080#01"]);
    rig.start();
    // Sub-index 6 is 3: that SYNC is the first that counts, and every second one is meant.
    assert_eq!(
        rig.pass(millis(60)),
        ["080#02", "080#03", "080#04", "185#07", "080#01", "080#02", "185#07", "080#03"]
    );
    rig.data(0, &[2, NODE]);
    assert_eq!(rig.pass(millis(50)), [""; 0], "STOPPED");
    rig.data(0, &[0x80, NODE]);
    assert_eq!(rig.pass(millis(20)), ["080#01", "080#02"]);
    rig.write(0x1005, 0, &cob_id(0x80)).unwrap();
    assert_eq!(rig.pass(millis(50)), [""; 0]);
}

#[test]
fn eds_43_the_counter_of_another_producer_starts_a_tpdo() {
    let mut rig = Rig::text(SYNC);
    rig.write(0x1019, 0, &[4]).unwrap();
    rig.start();
    let mut counted = |counter: u8| rig.data(0x80, &[counter]);
    assert_eq!([1, 2, 3].map(&mut counted), [const { Vec::<String>::new() }; 3]);
    assert_eq!([4, 1, 2].map(counted).concat(), ["185#07", "185#07"]);
}

/// A gap of one bit, two BOOLEAN, an INTEGER16 across octets, and back.
#[test]
fn eds_40_eds_44_bits_are_packed_low_bit_first_and_gaps_are_those_of_the_file() {
    let bits = |index: u16, access: &str| var(index, 1, access, "PDOMapping=1");
    let record = |index: u16, subs: &[(u8, u8, u32)]| {
        let entries = subs.iter().map(|(sub, data, default)| {
            format!("[{index:04X}sub{sub}]\nDataType={data}\nAccessType=rw\nDefaultValue={default}\n")
        });
        format!("[{index:04X}]\nObjectType=9\nSubNumber={}\n", subs.len()) + &entries.collect::<String>()
    };
    let words = |first: u32| [(1, 7, first), (2, 7, 0x2000_0001), (3, 7, 0x2001_0001), (4, 7, 0x2002_0010)];
    let text = "[DummyUsage]\nDummy0001=1\nDummy0005=0\n".to_owned()
        + &bits(0x2000, "rw")
        + &bits(0x2001, "rw")
        + &var(0x2002, 3, "rw", "PDOMapping=1")
        + &record(0x1400, &[(0, 5, 2), (1, 7, 0x205), (2, 5, 255)])
        + &record(0x1600, &[&[(0, 5, 4)][..], &words(0x0001_0001)].concat())
        + &record(0x1800, &[(0, 5, 2), (1, 7, 0x185), (2, 5, 1)])
        + &record(0x1A00, &[&[(0, 5, 3)][..], &words(0x2000_0001)].concat());
    let mut rig = Rig::text(&text);
    rig.start();
    // 1 | 0 | 1 | FFFEh
    rig.data(0x205, &[0b1111_0101, 0xFF, 0b0000_0111]);
    assert_eq!((rig.number(0x2000, 0), rig.number(0x2001, 0), rig.number(0x2002, 0)), (0, 1, 0xFFFE));
    rig.write(0x2000, 0, &[1]).unwrap();
    assert_eq!(rig.sync(), ["185#07"], "the first BOOLEAN twice, then the second");
    assert_eq!(rig.write(0x2000, 0, &[2]), Err(0x0609_0031));
    rig.write(0x1400, 1, &0x8000_0205_u32.to_le_bytes()).unwrap();
    rig.write(0x1600, 0, &[0]).unwrap();
    assert_eq!(rig.write(0x1600, 1, &0x0005_0008_u32.to_le_bytes()), Err(0x0604_0041), "Dummy0005 is 0");
    rig.write(0x1600, 1, &0x0001_0001_u32.to_le_bytes()).unwrap();
}

#[test]
fn eds_46_to_49_what_is_stored_comes_back_until_it_is_loaded_away() {
    let mut rig = Rig::file("pump.eds");
    let (save, load) = (0x6576_6173_u32.to_le_bytes(), 0x6461_6F6C_u32.to_le_bytes());
    assert_eq!(rig.write(0x1010, 1, &load), Err(0x0800_0020));
    rig.write(0x2007, 0, b"C\0D\0E\0").unwrap();
    rig.write(0x2000, 0, &[7, 0]).unwrap();
    rig.write(0x1017, 0, &[9, 0]).unwrap();
    rig.write(0x1010, 1, &save).unwrap();
    rig.write(0x2000, 0, &[8, 0]).unwrap();
    let mut rig = rig.again();
    assert_eq!(rig.read(0x2007, 0), Ok(b"C\0D\0E\0".to_vec()));
    assert_eq!((rig.number(0x2000, 0), rig.number(0x1017, 0)), (7, 9));
    rig.write(0x1011, 1, &load).unwrap();
    assert_eq!((rig.number(0x2000, 0), rig.number(0x1017, 0)), (7, 9), "until the next reset");
    rig.data(0, &[0x81, NODE]);
    assert_eq!((rig.number(0x2000, 0), rig.number(0x1017, 0)), (0xFF9C, 500));
    assert_eq!(rig.read(0x2007, 0), Ok(b"A\0B\0".to_vec()));
}

#[test]
fn eds_49_the_groups_of_1010h_have_their_own_objects() {
    let group = |index: u16| {
        let subs =
            (1..=4).map(|sub| format!("[{index:04X}sub{sub}]\nDataType=7\nAccessType=rw\nDefaultValue=1\n"));
        format!(
            "[{index:04X}]\nObjectType=8\nSubNumber=5\n[{index:04X}sub0]\nDataType=5\nAccessType=ro\nDefaultValue=4\n"
        ) + &subs.collect::<String>()
    };
    let objects = [0x1012, 0x2000, 0x6000].map(|index| var(index, 7, "rw", "DefaultValue=1"));
    let text = group(0x1010) + &group(0x1011) + &objects.concat();
    for (sub, kept) in [(1, [2, 2, 2]), (2, [2, 1, 1]), (3, [1, 1, 2]), (4, [1, 2, 1])] {
        let mut rig = Rig::text(&text);
        for index in [0x1012, 0x2000, 0x6000] {
            rig.write(index, 0, &[2, 0, 0, 0]).unwrap();
        }
        rig.write(0x1010, sub, b"save").unwrap();
        let mut rig = rig.again();
        assert_eq!([0x1012, 0x2000, 0x6000].map(|index| rig.number(index, 0)), kept, "1010h:{sub}");
        rig.write(0x1011, sub, b"load").unwrap();
        rig.data(0, &[0x81, NODE]);
        assert_eq!([0x1012, 0x2000, 0x6000].map(|index| rig.number(index, 0)), [1; 3], "1011h:{sub}");
    }
}

#[test]
fn eds_45_reset_communication_restores_1000h_to_1fffh() {
    let mut rig =
        Rig::text(&(var(0x1012, 7, "rw", "DefaultValue=1") + &var(0x2000, 7, "rw", "DefaultValue=1")));
    for index in [0x1012, 0x2000] {
        rig.write(index, 0, &[2, 0, 0, 0]).unwrap();
    }
    assert_eq!(rig.data(0, &[0x82, NODE]), ["705#00"]);
    assert_eq!((rig.number(0x1012, 0), rig.number(0x2000, 0)), (1, 2));
    rig.data(0, &[0x81, NODE]);
    assert_eq!(rig.number(0x2000, 0), 1);
}

#[test]
fn eds_50_without_1010h_nothing_is_kept() {
    let mut rig = Rig::text(&(var(0x2000, 7, "rw", "DefaultValue=1") + &var(0x1017, 6, "rw", "")));
    rig.write(0x2000, 0, &[2, 0, 0, 0]).unwrap();
    rig.write(0x1017, 0, &[2, 0]).unwrap();
    let mut rig = rig.again();
    assert_eq!((rig.number(0x2000, 0), rig.number(0x1017, 0)), (1, 0));
}

/// What a node answers on 7E4h.
fn lss(rig: &mut Rig, command: u8, octets: [u8; 4]) -> Vec<String> {
    let [a, b, c, d] = octets;
    rig.data(0x7E5, &[command, a, b, c, d, 0, 0, 0])
}

#[test]
fn eds_52_a_master_finds_the_node_by_its_identity_and_gives_it_a_number() {
    let word = |number: u32| number.to_le_bytes();
    let mut rig = Rig::file("pump.eds");
    rig.write(0x1017, 0, &[0, 0]).unwrap();
    assert_eq!(lss(&mut rig, 0x5E, [0; 4]), [""; 0], "it is not in the configuration state");
    // Any serial number up to 5.
    for (command, number) in [(0x46, 0x195), (0x47, 7), (0x48, 0), (0x49, 0xFFFF_FFFF), (0x4A, 0)] {
        assert_eq!(lss(&mut rig, command, word(number)), [""; 0]);
    }
    let identity = [(0x40, 0x195), (0x41, 7), (0x42, 0x0001_0002)];
    for wrong in 0..4 {
        for (place, (command, number)) in identity.into_iter().chain([(0x43, 0)]).enumerate() {
            let number = if place == wrong { number + 1 } else { number };
            assert_eq!(lss(&mut rig, command, word(number)), [""; 0], "part {wrong} is of another node");
        }
    }
    for (command, number) in identity {
        assert_eq!(lss(&mut rig, command, word(number)), [""; 0]);
    }
    assert_eq!(lss(&mut rig, 0x43, word(0)), ["7E4#4400000000000000"]);
    assert_eq!(lss(&mut rig, 0x5A, [0; 4]), ["7E4#5A95010000000000"]);
    assert_eq!(lss(&mut rig, 0x5C, [0; 4]), ["7E4#5C02000100000000"]);
    assert_eq!(lss(&mut rig, 0x5E, [0; 4]), ["7E4#5E05000000000000"]);
    assert_eq!(lss(&mut rig, 0x13, [0, 2, 0, 0]), ["7E4#1300000000000000"], "500 kbit/s");
    assert_eq!(lss(&mut rig, 0x13, [0, 1, 0, 0]), ["7E4#1301000000000000"], "800 kbit/s are not in the file");
    assert_eq!(lss(&mut rig, 0x11, [128, 0, 0, 0]), ["7E4#1101000000000000"]);
    assert_eq!(lss(&mut rig, 0x11, [9, 0, 0, 0]), ["7E4#1100000000000000"]);
    assert_eq!(lss(&mut rig, 0x17, [0; 4]), ["7E4#1700000000000000"]);
    assert_eq!(rig.data(0, &[0x82, NODE]), ["709#00"], "from the reset on");
    assert_eq!(rig.device.node().node_id().number(), 9);
    let rig = rig.again();
    assert_eq!(rig.device.node().node_id().number(), 9, "it is kept");
    let mut rig = Rig::file("servo.dcf");
    assert_eq!(lss(&mut rig, 0x04, [1, 0, 0, 0]), [""; 0]);
    assert_eq!(lss(&mut rig, 0x5E, [0; 4]), [""; 0], "LSS_Supported is 0");
}

#[test]
fn eds_52_the_number_that_is_not_kept_is_gone_with_the_power() {
    let mut rig = Rig::file("pump.eds");
    lss(&mut rig, 0x04, [1, 0, 0, 0]);
    assert_eq!(lss(&mut rig, 0x11, [9, 0, 0, 0]), ["7E4#1100000000000000"]);
    // All of the identity, any serial number.
    let parts = [(0x46, 0x195_u32), (0x47, 7), (0x48, 0), (0x49, 0xFFFF_FFFF), (0x4A, 0)];
    for (command, number) in parts {
        assert_eq!(lss(&mut rig, command, number.to_le_bytes()), [""; 0]);
    }
    assert_eq!(lss(&mut rig, 0x4B, [5, 0, 0, 0]), ["7E4#4F00000000000000"]);
    assert_eq!(rig.data(0, &[0x81, NODE]), ["709#00"]);
    assert_eq!(rig.again().device.node().node_id().number(), 5);
}

/// Each object answers as its file says: its default in the octets of its type, its rights, nothing beside it.
fn answers_as_its_file(name: &str, dictionary: &'static Dictionary) {
    let mut rig = Rig::of(dictionary);
    let node = NodeId::new(NODE).unwrap();
    let empty = |home: Home| home == Home::Node;
    let is_drive = rig.device.description().is_drive();
    let is_encoder = dictionary.eds.profile() == Profile::Encoder;
    // Where the first axis has an object.
    let first = |index: u16| match index {
        0x6000..0xA000 if is_drive => 0x6000 + index % 0x800,
        _ => index,
    };
    // What the device behind the values says of itself now.
    let is_told = |index| match first(index) {
        0x603F | 0x6041 | 0x6043 | 0x6044 | 0x6061..=0x6064 | 0x606B | 0x606C | 0x6074 | 0x6077 => is_drive,
        0x6078 | 0x60F4 | 0x60FC | 0x60FD | 0x6502 => is_drive,
        0x6300 | 0x6400 | 0x6500 => is_encoder,
        _ => false,
    };
    for object in dictionary.objects {
        let file = &dictionary.eds.objects[&object.index.0];
        assert_eq!(object.entries.len(), file.entries.len(), "{name} {}", object.index);
        for entry in object.entries {
            let (said, index, sub) = (&file.entries[&entry.sub.0], object.index.0, entry.sub.0);
            let place = format!("{name} {index:04X}h:{sub:02X}");
            let read = rig.read(index, sub);
            match (said.rights, index) {
                (Rights::WriteOnly, _) => assert_eq!(read, Err(0x0601_0001), "{place}"),
                (_, index) if is_told(index) => {}
                // What the node tells of itself now.
                (_, 0x1001 | 0x1003 | 0x1010 | 0x1011) if empty(entry.home) => {}
                _ => assert_eq!(read, Ok(said.octets(node)), "{place}"),
            }
            if !said.rights.is_writable() {
                assert_eq!(rig.write(index, sub, &said.octets(node)), Err(0x0601_0002), "{place}");
            } else if index >= 0x2000 && said.rights != Rights::WriteOnly {
                let octets = said.octets(node);
                match rig.write(index, sub, &octets) {
                    Ok(()) if is_told(index) => {}
                    Ok(()) => assert_eq!(rig.read(index, sub), Ok(octets), "{place}"),
                    // A mode that the file has no objects for.
                    Err(0x0609_0030) if is_drive && matches!(first(index), 0x605A..=0x6060 | 0x6098) => {}
                    // A default outside of its limits.
                    Err(code) => assert!(matches!(code, 0x0609_0031 | 0x0609_0032), "{place}: {code:08X}"),
                }
            }
        }
        let absent = (0..=255).find(|sub| !file.entries.contains_key(sub));
        if let Some(sub) = absent {
            assert_eq!(rig.read(object.index.0, sub), Err(0x0609_0011), "{name} {}:{sub}", object.index);
        }
        let next = object.index.0.saturating_add(1);
        if !dictionary.eds.objects.contains_key(&next) {
            assert_eq!(rig.read(next, 0), Err(0x0602_0000), "{name} {next:04X}h");
        }
    }
    rig.start();
    rig.sync();
    rig.pass(Duration::from_millis(200));
}

#[test]
fn eds_04_eds_05_every_object_answers_as_its_file_says() {
    let ours = [
        "ag03-1.eds",
        "ap10.eds",
        "asda-a2.eds",
        "pump.eds",
        "servo.dcf",
        "two-axes.eds",
        "terminal.eds",
        "encoder.eds",
    ];
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/eds");
    let mut files: Vec<_> = ours.map(|name| folder.join(name)).into();
    if let Some(folder) = std::env::var_os("PROFIDRIVE_EDS_FOLDER") {
        files.extend(fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()));
    }
    let tried = files.len();
    let refused = files.iter().filter(|file| {
        std::panic::catch_unwind(|| answers_as_its_file(&file.display().to_string(), held(file))).is_err()
    });
    let refused: Vec<_> = refused.collect();
    assert!(refused.is_empty(), "{} of {tried}: {refused:#?}", refused.len());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    /// Whatever a file says and a master sends.
    #[test]
    fn no_file_and_no_frame_makes_a_node_panic(
        lines in prop::collection::vec(
            prop_oneof![
                (0x1000_u16..0x1020).prop_map(|index| format!("[{index:04X}]")),
                (prop::sample::select(vec![0x1003_u16, 0x1016, 0x1018, 0x1400, 0x1600, 0x1800, 0x1A00, 0x2000, 0x6000]), 0_u8..10)
                    .prop_map(|(index, sub)| format!("[{index:04X}sub{sub:X}]")),
                prop::sample::select(vec![0x1003_u16, 0x1400, 0x1800, 0x1A00, 0x2000, 0x6041, 0xFFFF])
                    .prop_map(|index| format!("[{index:04X}]")),
                (0_u16..0x30).prop_map(|data| format!("DataType={data}")),
                prop::sample::select(vec!["ro", "rw", "wo", "const", "rwr", "rww"]).prop_map(|access| format!("AccessType={access}")),
                any::<i64>().prop_map(|number| format!("DefaultValue={number}")),
                any::<u32>().prop_map(|number| format!("DefaultValue=$NODEID+{number}")),
                prop::sample::select(vec!["DefaultValue=0x20000020", "DefaultValue=0x60000108", "DefaultValue=255", "DefaultValue=1"])
                    .prop_map(str::to_owned),
                any::<i64>().prop_map(|number| format!("LowLimit={number}")),
                any::<i64>().prop_map(|number| format!("HighLimit={number}")),
                Just("PDOMapping=1".to_owned()),
                (0_u16..300).prop_map(|count| format!("CompactSubObj={count}")),
                (0_u8..12).prop_map(|kind| format!("ObjectType={kind}")),
                "[ -~]{0,20}",
            ],
            0..60,
        ),
        frames in prop::collection::vec((0_u16..0x800, prop::collection::vec(any::<u8>(), 0..9), any::<bool>()), 0..60),
        requests in prop::collection::vec((0_u8..0xFF, 0_usize..200, any::<[u8; 4]>()), 0..60),
    ) {
        let Ok(mut eds) = Eds::read(lines.join("\n").as_bytes()) else { return Ok(()) };
        eds.complete();
        let dictionary = Dictionary::hold(eds);
        let mut rig = Rig::of(dictionary);
        rig.start();
        let places: Vec<_> = dictionary.objects.iter()
            .flat_map(|object| object.entries.iter().map(|entry| (object.index.0, entry.sub.0)))
            .collect();
        for (command, place, [d, e, f, g]) in requests {
            let (index, sub) = places[place % places.len()];
            let [a, b] = index.to_le_bytes();
            rig.data(0x600 + u16::from(NODE), &[command, a, b, sub, d, e, f, g]);
        }
        for (id, octets, remote) in frames {
            let id = Id::base(id).unwrap();
            let frame = if remote {
                Frame::remote(id, octets.len() as u8).unwrap()
            } else {
                Frame::data(id, &octets).unwrap()
            };
            rig.device.handle_frame(rig.now, &frame);
            rig.drain();
            rig.pass(Duration::from_millis(1));
        }
        rig.device.power_off(rig.now);
        rig.device.power_on(rig.now);
        rig.drain();
        rig.again();
    }
}
