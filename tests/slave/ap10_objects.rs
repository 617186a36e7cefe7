//! The AP10 by SDO: its dictionary, printed frames and refusals (`canopen-ap10.md` 14 to 18).

use profidrive::can_bus::canopen::check::{Problem, each_problem};
use profidrive::can_bus::canopen::dictionary;
use profidrive::can_bus::canopen::dictionary::{Access, Mapping, Writable};
use profidrive::can_bus::canopen::{Address, DataType, NodeId, eds};
use profidrive::devices::CanopenDevice;
use profidrive::devices::ap10::canopen::{EDS, OBJECTS, Quirks, SdoCodes, SoftwareVersion};

use crate::ap10_node::Rig;

const RANGE: u32 = 0x0609_0030;

/// One row of the reference's dictionary.
struct Row {
    at: Address,
    name: &'static str,
    data: &'static str,
    access: &'static str,
    default: &'static str,
    range: &'static str,
    pdo: bool,
    eeprom: bool,
    note: &'static str,
}

fn rows() -> Vec<Row> {
    let text = include_str!("../helpers/ap10_node/objects.tsv");
    let rows = text.lines().skip(1).map(|line| {
        let cells: Vec<&str> = line.split('\t').collect();
        let hex = |text| u16::from_str_radix(text, 16).unwrap();
        Row {
            at: Address::new(hex(cells[0]), u8::try_from(hex(cells[1])).unwrap()),
            name: cells[2],
            data: cells[3],
            access: cells[4],
            default: cells[5],
            range: cells[6],
            pdo: cells[7] == "yes",
            eeprom: cells[8] == "yes",
            note: cells.get(9).copied().unwrap_or_default(),
        }
    });
    rows.collect()
}

/// The default of a row at node `node`, as SDO answers it.
fn default(row: &Row, node: u32) -> u32 {
    let number = |text: &str| match text.strip_suffix('h') {
        Some(hex) => u32::from_str_radix(hex, 16).unwrap(),
        None => u32::from_le_bytes(text.parse::<i64>().unwrap().to_le_bytes()[..4].try_into().unwrap()),
    };
    match row.default {
        // CN-114: 6507h says V301.
        "\"V100\"" => u32::from_le_bytes(*b"V301"),
        // CN-135: nothing came yet.
        "-" => 0,
        text if text.starts_with('"') => {
            u32::from_le_bytes(text.trim_matches('"').as_bytes().try_into().unwrap())
        }
        text => match text.strip_suffix("+n") {
            Some(base) => number(base) + node,
            None => number(text),
        },
    }
}

#[test]
fn the_table_is_the_dictionary_of_the_reference_row_by_row() {
    let rows = rows();
    assert_eq!(rows.len(), 149);
    let ours = OBJECTS.iter().flat_map(|object| {
        object.entries.iter().map(|entry| (Address { index: object.index, sub: entry.sub }, entry))
    });
    let ours: Vec<_> = ours.collect();
    assert_eq!(ours.len(), rows.len());
    for (row, (at, entry)) in rows.iter().zip(ours) {
        let at_text = format!("{at}");
        assert_eq!(row.at, at);
        let data = match entry.data {
            DataType::VisibleString => "VS4".to_owned(),
            data => format!("{data:?}"),
        };
        assert_eq!(row.data, data, "{at_text}");
        let access = match (entry.access, entry.writable) {
            (Access::Const, _) => "const",
            (Access::Ro, _) => "ro",
            (Access::Wo, _) => "wo",
            (Access::Rw, Writable::Always) => "rw",
            (Access::Rw, Writable::PreOperational) => "rwP",
        };
        assert_eq!(row.access, access, "{at_text}");
        assert_eq!(row.pdo, entry.mapping != Mapping::No, "{at_text}");
        // CN-118: the columns of the two are swapped.
        let eeprom = if row.at.index.0 == 0x5F1B { !row.eeprom && at.sub.0 == 2 } else { row.eeprom };
        assert_eq!(eeprom, entry.stored, "{at_text} {}", row.note);
        assert_eq!(row.name, entry.name, "{at_text}");
    }
}

#[test]
fn the_tables_agree_with_themselves_but_for_what_the_device_really_does() {
    let mut problems = Vec::new();
    each_problem(OBJECTS, &mut |problem| problems.push(problem));
    // 5F1Ch: sub-index 0 is data (CN-119).
    problems.retain(|problem| !matches!(problem, Problem::Highest { index, .. } if index.0 == 0x5F1C));
    assert!(problems.is_empty(), "{problems:?}");
    let mut text = String::new();
    eds::write(&EDS, OBJECTS, &mut text).unwrap();
    for line in ["NrOfRXPDO=2", "NrOfTXPDO=2", "[5F1Csub0]", "BaudRate_800=1", "DefaultValue=$NODEID+0x180"] {
        assert!(text.lines().any(|each| each == line), "{line}");
    }
}

#[test]
fn po_01_every_row_reads_its_default() {
    for node in [1, 125] {
        let mut rig = Rig::new(node);
        for row in rows() {
            let expected = match row.at.pair() {
                (0x1003, 1..) => Err(0x0800_0024),
                (0x5F0A, 1) => Ok(u32::from(node)),
                _ => Ok(default(&row, node.into())),
            };
            let (index, sub) = row.at.pair();
            let len = dictionary::entry(OBJECTS, row.at).unwrap().data.octets().unwrap_or(4);
            let mask = if len == 4 { u32::MAX } else { (1 << (8 * len)) - 1 };
            let expected = expected.map(|value| value & mask);
            assert_eq!(rig.read(index, sub), expected, "{} {}", row.at, row.note);
        }
    }
    let quirks = Quirks { software_version: SoftwareVersion::V100, ..Quirks::DEFAULT };
    assert_eq!(Rig::with(1, quirks).read(0x100A, 0), Ok(u32::from_le_bytes(*b"V100")));
}

#[test]
fn po_02_printed_frames() {
    let mut rig = Rig::new(1);
    rig.write(0x6003, 0, 510, 4).unwrap();
    assert_eq!(
        rig.data(0x601, &[0x40, 0x03, 0x60, 0x00, 0x55, 0xAA, 0x55, 0xAA]),
        ["581#43 03 60 00 FE 01 00 00"],
        "S1, S2"
    );
    assert_eq!(
        rig.data(0x601, &[0x2B, 0x14, 0x5F, 0x00, 0x94, 0x11, 0x00, 0x00]),
        ["581#60 14 5F 00 00 00 00 00"],
        "S3, S4"
    );
    assert_eq!(rig.read(0x5F14, 0), Ok(4500));
    let mut rig = Rig::new(125);
    let seen = rig.data(0x67D, &[0x2F, 0x0A, 0x5F, 0x02, 0x05, 0, 0, 0]);
    assert!(seen.is_empty(), "S5 waits for a key: {seen:?}");
    assert_eq!(rig.rows(), ["New ID", ""]);
    assert_eq!(rig.tap(profidrive::devices::ap10::Key::Left), ["5FD#60 0A 5F 02 00 00 00 00"], "S6");
}

#[test]
fn po_03_ranges_access_and_missing_subs() {
    let mut rig = Rig::new(1);
    for object in OBJECTS {
        for entry in object.entries {
            let (index, sub, len) = (object.index.0, entry.sub.0, entry.data.octets().unwrap_or(4));
            let len = u8::try_from(len).unwrap();
            let at = Address { index: object.index, sub: entry.sub };
            if !entry.is_writable() {
                assert_eq!(rig.write(index, sub, 0, len), Err(0x0601_0002), "{at}");
                continue;
            }
            let outside: &[i64] = match entry.limits {
                dictionary::Limits::Range(low, high) => &[low - 1, high + 1],
                dictionary::Limits::Ranges(ranges) => {
                    &[ranges.first().unwrap().0 - 1, ranges.last().unwrap().1 + 1]
                }
                dictionary::Limits::Type | dictionary::Limits::MaxLen(_) => &[],
            };
            let (low, high) = entry.data.range().unwrap();
            for value in outside.iter().filter(|value| (low..=high).contains(*value)) {
                let octets = u32::from_le_bytes(value.to_le_bytes()[..4].try_into().unwrap());
                let before = rig.read(index, sub);
                assert_eq!(rig.write(index, sub, octets, len), Err(RANGE), "{at} := {value}");
                assert_eq!(rig.read(index, sub), before);
            }
        }
    }
    for (index, sub) in
        [(0x1400, 4), (0x1401, 4), (0x1800, 4), (0x1801, 4), (0x1800, 6), (0x1801, 6), (0x2005, 4)]
    {
        assert_eq!(rig.read(index, sub), Err(0x0609_0011), "{index:04X}h:{sub}");
    }
    assert_eq!(rig.read(0x1016, 0), Err(0x0602_0000));
    assert_eq!(rig.write(0x5F12, 3, 0, 2), Err(0x0601_0000), "a wrong length is wrong access (CN-102)");
    assert_eq!(rig.sdo([0xE0, 0, 0x10, 0, 0, 0, 0, 0]), ["581#80 00 10 00 00 00 01 06"]);
    assert_eq!(rig.write(0x2002, 0, 0, 1), Err(RANGE));
    assert_eq!(rig.write(0x2002, 0, 2, 1), Err(RANGE));
    assert_eq!(rig.write(0x2005, 1, 0, 1), Err(RANGE), "CN-115");
    assert_eq!(rig.write(0x5F1C, 0, 1, 1), Err(RANGE));
    let quirks = Quirks { sdo_codes: SdoCodes::Cia301, ..Quirks::DEFAULT };
    let mut rig = Rig::with(1, quirks);
    assert_eq!(rig.write(0x5F12, 3, 0, 2), Err(0x0607_0010));
}

#[test]
fn every_range_of_the_reference_is_ours() {
    for row in rows() {
        let Some((low, high)) = row.range.split_once("..") else { continue };
        let number = |text: &str| match text.trim().strip_suffix('h') {
            Some(hex) => i64::from_str_radix(hex, 16).ok(),
            None => text.trim().parse::<i64>().ok(),
        };
        let (Some(low), Some(high)) = (number(low), number(high)) else { continue };
        let entry = dictionary::entry(OBJECTS, row.at).unwrap();
        match (row.at.pair(), entry.limits) {
            // 1003h: only 0 is written. 2005h:1: CN-115. 5F0Ah:2: judged by the device.
            ((0x1003, 0) | (0x2005, 1) | (0x5F0A, 2), _) => {}
            (_, dictionary::Limits::Range(ours_low, ours_high)) => {
                assert_eq!((low, high), (ours_low, ours_high), "{}", row.at);
            }
            (_, dictionary::Limits::Ranges(ranges)) => {
                assert_eq!((low, high), (ranges[0].0, ranges.last().unwrap().1), "{}", row.at);
            }
            (_, dictionary::Limits::Type | dictionary::Limits::MaxLen(_)) => {
                assert_eq!(entry.data.range(), Some((low, high)), "{}", row.at);
            }
        }
    }
}

#[test]
fn po_04_times_between_0_and_10_ms_are_refused() {
    let mut rig = Rig::new(1);
    for (index, sub) in [(0x1017, 0), (0x5F09, 1)] {
        assert_eq!(rig.write(index, sub, 9, 2), Err(RANGE));
        assert_eq!(rig.write(index, sub, 10, 2), Ok(()));
        assert_eq!(rig.write(index, sub, 0, 2), Ok(()));
    }
}

#[test]
fn po_05_an_empty_history_has_no_data() {
    let mut rig = Rig::new(1);
    assert_eq!(rig.read(0x1003, 1), Err(0x0800_0024));
    assert_eq!(rig.read(0x1003, 0), Ok(0));
    assert_eq!(rig.write(0x1003, 0, 1, 1), Err(RANGE));
    assert_eq!(rig.write(0x1003, 0, 0, 1), Ok(()));
}

#[test]
fn po_06_identifiers_change_in_pre_operational_with_bit_31() {
    let mut rig = Rig::new(1);
    const STATE: u32 = 0x0800_0022;
    for (index, id) in [(0x1400, 0x201), (0x1401, 0x301), (0x1800, 0x181), (0x1801, 0x281)] {
        assert_eq!(rig.write(index, 1, 0x222, 4), Err(STATE), "valid");
        assert_eq!(rig.write(index, 1, 0x8000_0000 | id, 4), Ok(()));
        assert_eq!(rig.write(index, 1, 0x8000_0222, 4), Ok(()));
        assert_eq!(rig.write(index, 1, 0x222, 4), Ok(()));
        assert_eq!(rig.read(index, 1), Ok(0x222));
        assert_eq!(rig.write(index, 1, 0x8000_0000 | id, 4), Ok(()));
    }
    assert_eq!(rig.write(0x1005, 0, 0x85, 4), Ok(()), "no such step for SYNC (CN-101)");
    assert_eq!(rig.write(0x1005, 0, 0x4000_0085, 4), Err(RANGE));
    rig.start();
    assert_eq!(rig.write(0x1400, 1, 0x8000_0201, 4), Err(STATE));
    assert_eq!(rig.write(0x1005, 0, 0x80, 4), Err(STATE));
    assert_eq!(rig.write(0x1014, 0, 0x8000_0081, 4), Err(STATE));
    assert_eq!(rig.write(0x1400, 2, 0, 1), Ok(()), "CN-136");
    assert_eq!(NodeId::new(1), Ok(rig.device.node().node_id()));
}

#[test]
fn the_total_of_steps_follows_the_resolution() {
    let mut rig = Rig::new(1);
    for (steps, total) in [(1, 0x001E_DC52), (440, 0x0500_0003), (880, 0x0A00_0007), (65_535, 0x7FFF_FFFF)] {
        rig.write(0x6001, 0, steps, 4).unwrap();
        assert_eq!(rig.read(0x6002, 0), Ok(total));
        rig.write(0x6002, 0, 0x0200_0000, 4).unwrap();
        assert_eq!(rig.read(0x6002, 0), Ok(total), "a write is without effect (CN-122)");
    }
    assert_eq!(rig.write(0x6002, 0, 0x001E_DC51, 4), Err(RANGE));
}
