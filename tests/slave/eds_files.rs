//! Files of CANopen nodes, read (`eds.md`): our own, and with `PROFIDRIVE_EDS_FOLDER` all of a folder.
#![cfg(feature = "eds")]

use std::fs;
use std::path::Path;

use profidrive::can_bus::canopen::NodeId;
use profidrive::eds::{Eds, Profile};

fn file(name: &str) -> Eds {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/eds").join(name);
    Eds::read(&fs::read(path).unwrap()).unwrap()
}

fn octets(eds: &Eds, index: u16, sub: u8) -> Vec<u8> {
    eds.entry(index, sub).unwrap().octets(NodeId::new(5).unwrap())
}

#[test]
fn each_form_of_value_has_its_octets() {
    let pump = file("pump.eds");
    assert_eq!(pump.hints, []);
    for (index, sub, expected) in [
        (0x1003, 0, &[8][..]),
        (0x1003, 8, &[0, 0, 0, 0]),
        (0x1008, 0, b"Pump; seven # still the name"),
        (0x1014, 0, &[0x85, 0, 0, 0]),
        (0x1017, 0, &[0xF4, 0x01]),
        (0x1800, 1, &[0x85, 0x01, 0, 0x40]),
        (0x2000, 0, &[0x9C, 0xFF]),
        (0x2001, 0, &[0, 0, 0xC0, 0x3F]),
        (0x2002, 0, &[0xFE, 0xFF, 0xFF]),
        (0x2003, 0, &[0xFF; 8]),
        (0x2004, 0, &[0x01, 0xA1, 0x05]),
        (0x2005, 0, &[]),
        (0x2006, 0, &[0, 0, 0, 0, 0, 0, 0xD0, 0xBF]),
        (0x2007, 0, &[0x41, 0, 0x42, 0]),
        (0x2008, 0, &[0x85, 0x06, 0, 0]),
    ] {
        assert_eq!(octets(&pump, index, sub), expected, "{index:04X}h:{sub:02X}");
    }
    assert_eq!((pump.profile(), pump.device.lss, pump.dummies), (Profile::None, true, 1 << 5));
}

#[test]
fn a_dcf_is_configured_and_its_profile_is_that_of_its_objects() {
    let servo = file("servo.dcf");
    assert_eq!(servo.hints, []);
    assert_eq!(servo.profile(), Profile::Drive);
    assert_eq!((octets(&servo, 0x1017, 0), octets(&servo, 0x6060, 0)), (vec![100, 0], vec![1]));
    let commissioning = servo.commissioning.unwrap();
    assert_eq!((commissioning.node, commissioning.serial_number), (NodeId::new(9).ok(), Some(4711)));
}

#[test]
fn every_file_of_a_folder_is_read() {
    let Some(folder) = std::env::var_os("PROFIDRIVE_EDS_FOLDER") else { return };
    let (mut files, mut objects) = (0, 0);
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let eds = Eds::read(&fs::read(&path).unwrap())
            .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        files += 1;
        objects += eds.objects.len();
    }
    assert!(files > 0);
    println!("{files} files, {objects} objects");
}

/// Files of 10 MB of every bad form end with what was read or with a sentence; `PROFIDRIVE_LONG` adds slow ones.
#[test]
fn files_of_10_mb_end_with_a_sentence() {
    const LEN: usize = 10_000_000;
    let entries = || {
        let entry = |number: usize| {
            let (index, sub) = (0x2000 + number / 250, number % 250);
            let head = if sub == 0 { format!("[{index:04X}]\nObjectType=9\n") } else { String::new() };
            format!("{head}[{index:04X}sub{sub:X}]\nParameterName={number:0150}\nDataType=7\nAccessType=rw\n")
        };
        (0..LEN / 200).map(entry).collect::<String>().into_bytes()
    };
    let mut files = vec![
        vec![0; LEN],
        vec![b'['; LEN],
        [b"[1000]\nParameterName=", &vec![b'x'; LEN][..]].concat(),
        [b"[1000]\nDefaultValue=", &vec![b'9'; LEN][..]].concat(),
    ];
    if std::env::var_os("PROFIDRIVE_LONG").is_some() {
        files.extend([entries(), b"[1000]\n".repeat(LEN / 7), b"a=b\n".repeat(LEN / 4)]);
    }
    let mut read = 0;
    for file in files {
        match Eds::read(&file) {
            Ok(eds) => read += eds.objects.values().map(|object| object.entries.len()).sum::<usize>(),
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    }
    assert!(read >= 2, "{read}");
    assert!(Eds::read(&vec![b' '; 17 << 20]).is_err(), "17 MB");
}
