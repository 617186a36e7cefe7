//! The data sheet: it agrees with what the node answers, and with itself (`canopen-link.md` 9).
//!
//! `tests/interop/canopen_eds.sh` shows the same file to python-canopen.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use profidrive::can_bus::canopen::check;
use profidrive::can_bus::canopen::check::Problem;
use profidrive::can_bus::canopen::dictionary;
use profidrive::can_bus::canopen::dictionary::{Entry, Object};
use profidrive::can_bus::canopen::eds;
use profidrive::can_bus::canopen::eds::Sheet;
use profidrive::can_bus::canopen::value::DataType::{U8, U16, U32};
use profidrive::can_bus::canopen::{Abort, Address, Index, Policy};

use crate::canopen_device::OBJECTS;
use crate::canopen_device::rig::Rig;

const SHEET: Sheet<'static> = Sheet {
    file_name: "plain.eds",
    file_version: 1,
    file_revision: 0,
    description: "Plain test node",
    time: "08:00AM",
    date: "11-22-2026",
    created_by: "profidrive",
    vendor_name: "profidrive",
    vendor_number: 0,
    product_name: "Plain test node",
    product_number: 0x401,
    revision_number: 0x0001_0002,
    order_code: "-",
    kilobits: &[125, 250, 500, 1000],
    granularity: 8,
};

type Sections = BTreeMap<String, BTreeMap<String, String>>;

fn sheet() -> String {
    let mut text = String::new();
    eds::write(&SHEET, OBJECTS, &mut text).unwrap();
    text
}

fn sections(text: &str) -> Sections {
    let mut sections = Sections::new();
    let mut name = String::new();
    for line in text.lines().filter(|line| !line.is_empty()) {
        if let Some(section) = line.strip_prefix('[') {
            name = section.trim_end_matches(']').to_ascii_lowercase();
            assert!(sections.insert(name.clone(), BTreeMap::new()).is_none(), "[{name}] twice");
        } else {
            let (key, value) = line.split_once('=').expect(line);
            let keys = sections.get_mut(&name).unwrap();
            assert!(keys.insert(key.to_ascii_lowercase(), value.to_owned()).is_none(), "{line} twice");
        }
    }
    sections
}

/// As in the file, at node 5.
fn number(text: &str) -> i64 {
    if let Some(base) = text.strip_prefix("$NODEID+") {
        return number(base) + 5;
    }
    match text.strip_prefix("0x") {
        Some(digits) => i64::from_str_radix(digits, 16).unwrap(),
        None => {
            assert!(text == "0" || !text.starts_with('0'), "{text} would be octal");
            text.parse().unwrap()
        }
    }
}

/// Every entry of the file with its section.
fn entries(sections: &Sections) -> BTreeMap<Address, &BTreeMap<String, String>> {
    let mut entries = BTreeMap::new();
    for (name, keys) in sections {
        let (index, sub) = name.split_once("sub").unwrap_or((name, "0"));
        let (Ok(index), Ok(sub)) = (u16::from_str_radix(index, 16), u8::from_str_radix(sub, 16)) else {
            continue;
        };
        if keys.contains_key("datatype") {
            entries.insert(Address::new(index, sub), keys);
        }
    }
    entries
}

#[test]
fn r_05_what_the_sheet_says_is_what_the_node_answers_and_nothing_else_answers() {
    let sections = sections(&sheet());
    let entries = entries(&sections);
    let mut rig = Rig::new(Policy::CIA_301);
    for (at, keys) in &entries {
        let (index, sub) = at.pair();
        let answer = rig.sdo([0x40, index.to_le_bytes()[0], index.to_le_bytes()[1], sub, 0, 0, 0, 0]);
        let code = u32::from_le_bytes(answer[4..].try_into().unwrap());
        if keys["accesstype"] == "wo" {
            assert_eq!((answer[0], code), (0x80, Abort::WRITE_ONLY.code()), "{at}");
            continue;
        }
        if index == 0x1003 && sub > 0 {
            assert_eq!((answer[0], code), (0x80, Abort::NO_DATA.code()), "{at}: no fault yet");
            continue;
        }
        let len = match number(&keys["datatype"]) {
            1 | 2 | 5 => 1,
            3 | 6 => 2,
            4 | 7 | 8 => 4,
            0x15 | 0x1B => 8,
            _ => 0,
        };
        if (1..=4).contains(&len) {
            assert_eq!(answer[0], 0x43 | (4 - len) << 2, "{at}");
            let expected = if keys["defaultvalue"].is_empty() { 0 } else { number(&keys["defaultvalue"]) };
            let mask = u32::MAX >> (32 - 8 * u32::from(len));
            assert_eq!(code, (expected as u32) & mask, "{at}");
        } else {
            assert_ne!(answer[0], 0x80, "{at}");
        }
    }
    let indices: BTreeSet<u16> = entries.keys().map(|at| at.index.0).collect();
    for index in 0..=0xFFFF_u16 {
        if indices.contains(&index) {
            for sub in 0..=255 {
                if !entries.contains_key(&Address::new(index, sub)) {
                    assert_eq!(rig.read(index, sub), Err(Abort::NO_SUB.code()), "{index:04X}h:{sub:02X}");
                }
            }
        } else {
            assert_eq!(rig.read(index, 0), Err(Abort::NO_OBJECT.code()), "{index:04X}h");
        }
    }
}

#[test]
fn r_06_the_sheet_agrees_with_itself() {
    let sections = sections(&sheet());
    let entries = entries(&sections);
    assert_eq!(sections["fileinfo"]["filename"], SHEET.file_name);
    assert_eq!(sections["deviceinfo"]["nrofrxpdo"], "4");
    assert_eq!(sections["deviceinfo"]["nroftxpdo"], "4");
    assert_eq!(sections["deviceinfo"]["baudrate_500"], "1");
    assert_eq!(sections["deviceinfo"]["baudrate_20"], "0");
    let mut listed = BTreeSet::new();
    for list in ["mandatoryobjects", "optionalobjects", "manufacturerobjects"] {
        let keys = &sections[list];
        assert_eq!(number(&keys["supportedobjects"]), keys.len() as i64 - 1);
        for place in 1..keys.len() {
            let index = number(&keys[&place.to_string()]);
            assert!(listed.insert(index), "{index:04X}h is listed twice");
            assert!(sections.contains_key(&format!("{index:04x}")), "{index:04X}h has no section");
            let group = match index {
                0x1000 | 0x1001 | 0x1018 => "mandatoryobjects",
                0x2000..=0x5FFF => "manufacturerobjects",
                _ => "optionalobjects",
            };
            assert_eq!(list, group, "{index:04X}h");
        }
    }
    assert_eq!(listed.len(), OBJECTS.len());
    for (at, keys) in &entries {
        assert!(listed.contains(&i64::from(at.index.0)), "{at} is not listed");
        assert!(!keys["parametername"].is_empty() && keys["parametername"].len() <= 241);
        let default = &keys["defaultvalue"];
        if let (Some(low), Some(high)) = (keys.get("lowlimit"), keys.get("highlimit")) {
            assert!(number(low) <= number(high), "{at}");
            assert!((number(low)..=number(high)).contains(&number(default)), "{at}");
        }
        let (index, sub) = at.pair();
        if matches!(index, 0x1600..=0x17FF | 0x1A00..=0x1BFF) && sub > 0 && number(default) != 0 {
            let [bits, sub, low, high] = (number(default) as u32).to_le_bytes();
            let mapped = entries[&Address::new(u16::from_le_bytes([low, high]), sub)];
            assert_eq!(mapped["pdomapping"], "1", "{at}");
            let expected = if index < 0x1800 { &["rw", "rww", "wo"] } else { &["ro", "rw", "rwr"] };
            assert!(expected.contains(&&mapped["accesstype"][..]), "{at}");
            assert!(bits % 8 == 0 && bits > 0);
        }
    }
    for object in OBJECTS {
        let keys = &sections[&format!("{:04x}", object.index.0)];
        if let Some(count) = keys.get("subnumber") {
            let subs = entries.keys().filter(|at| at.index == object.index).count();
            assert_eq!(number(count), subs as i64, "{}", object.index);
        }
    }
}

#[test]
fn the_tables_of_the_test_device_have_no_problem() {
    let mut problems = Vec::new();
    check::each_problem(OBJECTS, &mut |problem| problems.push(problem));
    assert_eq!(problems, []);
}

#[test]
fn each_problem_of_a_table_is_found() {
    const FAULTY: &[Object] = &[
        Object::var(0x1001, &[Entry::ro(0, "", U8).node()]),
        Object::var(0x1000, &[Entry::ro(0, "Device type", U8).number(300)]),
        Object::array(
            0x1600,
            "Mapping",
            &[Entry::ro(0, "Count", U8), Entry::ro(1, "1", U32).number(0x2001_0008)],
        ),
        Object::array(0x2000, "Array", &[Entry::ro(0, "Highest", U8).number(3), Entry::ro(2, "Two", U8)]),
        Object::var(0x2001, &[Entry::rw(0, "Small", U8).number(1).range(0, 256)]),
        Object::var(0x2002, &[Entry::rw(0, "Of the node", U16).node()]),
        Object::var(0x2003, &[Entry::rw(0, "Nobody", U16).home(profidrive::can_bus::canopen::Home::Default)]),
    ];
    let mut problems = Vec::new();
    check::each_problem(FAULTY, &mut |problem| problems.push(problem));
    for problem in [
        Problem::Missing(Index(0x1018)),
        Problem::Name(Address::new(0x1001, 0)),
        Problem::ObjectOrder(Index(0x1000)),
        Problem::Default(Address::new(0x1000, 0)),
        Problem::Mapping(Address::new(0x1600, 1)),
        Problem::Highest { index: Index(0x2000), says: 3, highest: 2 },
        Problem::Limits(Address::new(0x2001, 0)),
        Problem::NotOfNode(Address::new(0x2002, 0)),
        Problem::Homeless(Address::new(0x2003, 0)),
    ] {
        assert!(problems.contains(&problem), "{problem}: {problems:?}");
    }
}

/// The sheet and what it says, for `tests/interop/canopen_eds.sh`.
#[test]
fn the_sheet_is_written_for_python_canopen() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("canopen-eds");
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join(SHEET.file_name), sheet()).unwrap();
    let mut table = String::new();
    for object in OBJECTS {
        for entry in object.entries {
            let value = entry.default_value(profidrive::can_bus::canopen::NodeId::new(5).unwrap());
            let default = match value {
                _ if entry.default == dictionary::Default::None => String::new(),
                profidrive::can_bus::canopen::Value::Octets(octets) => {
                    String::from_utf8(octets.to_vec()).unwrap()
                }
                value => value.to_string(),
            };
            let (index, sub) = (object.index.0, entry.sub.0);
            let (code, mapped) = (entry.data.number(), entry.receivable() || entry.sendable());
            writeln!(
                table,
                "{index:04X}\t{sub:02X}\t{code}\t{}\t{}\t{default}",
                entry.name,
                u8::from(mapped)
            )
            .unwrap();
        }
    }
    fs::write(folder.join("plain.tsv"), table).unwrap();
}
