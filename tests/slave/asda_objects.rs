//! The dictionary of the ASDA-A2, SDO and PDO mapping (`canopen-asda-a2.md` 11 to 13, 15).

use profidrive::can_bus::canopen::check;
use profidrive::can_bus::canopen::dictionary;
use profidrive::can_bus::canopen::dictionary::{Access, Default, Home, Mapping};
use profidrive::can_bus::canopen::value::DataType;
use profidrive::can_bus::canopen::{Address, NodeId};
use profidrive::devices::CanopenDevice;
use profidrive::devices::asda_a2::canopen::{AsdaA2, Quirks};
use profidrive::devices::asda_a2::{Config, Level};

use crate::asda_a2_node::{NODE, Rig, millis};

/// `canopen-od.tsv`, rows of the ASDA-A2: index, sub, type, access, default, lowest, highest, mapping, kept.
const TABLE: &str = include_str!("../helpers/asda_a2_node/objects.tsv");

const READ_ONLY: u32 = 0x0601_0002;
const RANGE: u32 = 0x0609_0030;
const LENGTH: u32 = 0x0607_0010;

/// How the names of parameters end that are kept only.
const WITHOUT_EFFECT: &str = " (stored, no effect)";

struct Row {
    at: Address,
    data: DataType,
    writable: bool,
    default: Option<i64>,
    range: Option<(i64, i64)>,
    mappable: bool,
    kept: bool,
}

fn rows() -> Vec<Row> {
    TABLE.lines().filter(|line| !line.starts_with('#')).map(row).collect()
}

fn row(line: &str) -> Row {
    let cells: Vec<_> = line.split_whitespace().collect();
    let number = |text: &str| -> Option<i64> {
        match text.strip_suffix('h') {
            Some(hex) => i64::from_str_radix(hex, 16).ok(),
            None => text.parse().ok(),
        }
    };
    let default = match cells[4].strip_suffix("+n") {
        Some(base) => number(base).map(|base| base + i64::from(NODE)),
        None => number(cells[4]),
    };
    let [index, sub] = [0, 1].map(|cell| u16::from_str_radix(cells[cell], 16).unwrap());
    Row {
        at: Address::new(index, sub as u8),
        data: match cells[2] {
            "U8" => DataType::U8,
            "U16" => DataType::U16,
            "U32" => DataType::U32,
            "I8" => DataType::I8,
            "I16" => DataType::I16,
            "I32" => DataType::I32,
            other => panic!("type {other}"),
        },
        writable: cells[3] == "rw",
        default,
        range: number(cells[5]).zip(number(cells[6])),
        mappable: cells[7] == "yes",
        kept: cells[8] == "yes",
    }
}

fn each_entry(mut take: impl FnMut(Row)) {
    rows().into_iter().for_each(&mut take);
}

/// Rows whose value after a start is not the default of the row, and why.
fn after_start(at: Address) -> Option<i64> {
    match at.pair() {
        // P1-01 is what the level needs.
        (0x2101, 0) => Some(0x0C),
        // CN-218, P3-12.Z = 0: the defaults of CANopen replace those of the keypad.
        (0x2120, 0) => Some(0x10),
        (0x212C | 0x212D, 0) => Some(1),
        // CN-219: live; switch on disabled, main circuit supplied.
        (0x6041, 0) => Some(0x0050),
        // P1-55 of this motor.
        (0x2137 | 0x6080, 0) => Some(5000),
        (0x607F, 0) => Some(50_000),
        (0x6040, 0) => Some(0x0004),
        (0x6075, 0) => Some(2600),
        (0x6076, 0) => Some(1270),
        _ => None,
    }
}

#[test]
fn the_tables_have_no_problem() {
    for level in [Level::Half, Level::Full] {
        let mut problems = Vec::new();
        check::each_problem(AsdaA2::objects(level), &mut |problem| problems.push(problem.to_string()));
        assert!(problems.is_empty(), "{level:?}: {problems:?}");
    }
}

#[test]
fn do_01_the_table_is_the_dictionary_of_the_reference_row_by_row() {
    let objects = AsdaA2::objects(Level::Full);
    let known = objects.iter().filter(|object| !object.name.ends_with(WITHOUT_EFFECT));
    let mut entries = known.flat_map(|object| {
        object.entries.iter().map(|entry| (Address { index: object.index, sub: entry.sub }, entry))
    });
    let mut count = 0;
    each_entry(|row| {
        count += 1;
        let (at, entry) = entries.next().expect("a row more than entries");
        assert_eq!(at, row.at, "same order");
        assert_eq!(entry.data, row.data, "{at}");
        assert_eq!(entry.access == Access::Rw, row.writable, "{at}");
        assert_eq!(entry.mapping != Mapping::No, row.mappable, "{at}");
        let keeps = entry.stored || matches!(at.pair(), (0x2208, 0));
        assert_eq!(keeps, row.kept, "{at}");
        if let (Some(default), None, Home::Default | Home::Node) = (row.default, after_start(at), entry.home)
        {
            let node = NodeId::new(NODE).unwrap();
            assert_eq!(entry.default_value(node).number(), Some(default), "{at}");
        }
    });
    assert!(entries.next().is_none(), "an entry more than rows");
    assert_eq!(count, 233);
}

#[test]
fn the_data_sheet_has_the_defaults_that_the_guide_prints_for_what_is_only_read() {
    for index in [0x603F, 0x6041, 0x6061, 0x6062, 0x6063, 0x6064] {
        let entry = dictionary::entry(AsdaA2::objects(Level::Full), Address::new(index, 0)).unwrap();
        assert_eq!(entry.default, Default::Number(0), "{index:04X}h");
    }
}

#[test]
fn do_01_every_row_is_read_with_its_type_and_default() {
    let mut rig = Rig::full();
    each_entry(|row| {
        let (index, sub) = row.at.pair();
        let [a, b] = index.to_le_bytes();
        let answer = rig.sdo([0x40, a, b, sub, 0, 0, 0, 0]);
        let len = row.data.octets().unwrap();
        assert_eq!(answer[0], 0x43 | ((4 - len) << 2) as u8, "{} {answer:02X?}", row.at);
        let number = row.data.decode(&answer[4..4 + len]).unwrap().number().unwrap();
        if let Some(expected) = after_start(row.at).or(row.default) {
            assert_eq!(number, expected, "{}", row.at);
        }
    });
}

#[test]
fn do_02_read_only_range_and_length() {
    let mut rig = Rig::full();
    each_entry(|row| {
        let (index, sub) = row.at.pair();
        let len = row.data.octets().unwrap() as u8;
        let before = rig.read(index, sub);
        if !row.writable {
            assert_eq!(rig.write_len(index, sub, 0, len), Err(READ_ONLY), "{}", row.at);
            return;
        }
        let wrong = if len == 4 { 2 } else { len + 1 };
        assert_eq!(rig.write_len(index, sub, 0, wrong), Err(LENGTH), "{}", row.at);
        let (low, high) = row.data.range().unwrap();
        if let Some((least, most)) = row.range {
            for value in [least - 1, most + 1] {
                if (low..=high).contains(&value) {
                    assert_eq!(rig.write(index, sub, value), Err(RANGE), "{} := {value}", row.at);
                }
            }
        }
        assert_eq!(rig.read(index, sub), before, "{}", row.at);
    });
    for mode in [-1, 2, 5, 8, 127] {
        assert_eq!(rig.write(0x6060, 0, mode), Err(RANGE), "mode {mode}");
    }
    for kind in 241..=253 {
        assert_eq!(rig.write(0x1800, 2, kind), Err(RANGE), "type {kind}, CN-203");
    }
    for (index, value) in [
        // P3-09: E 1 to 9, T 0 to 9, D 0 to F, M 1 to F.
        (0x2309, 0x0055),
        (0x2309, 0xA055),
        (0x2309, 0x5A55),
        (0x2309, 0x5050),
        // P3-10: X and Y.
        (0x230A, 0x0002),
        (0x230A, 0x0020),
        (0x230A, 0x0100),
        // P3-11: X; Y has no function.
        (0x230B, 0x0002),
        (0x230B, 0x1000),
        // P3-12: X, Y and Z.
        (0x230C, 0x0002),
    ] {
        assert_eq!(rig.write(index, 0, value), Err(RANGE), "{index:04X}h := {value:04X}h");
    }
    for (index, value) in [(0x2309, 0x9901), (0x230A, 0x0011), (0x230B, 0x00F1), (0x230C, 0x0111)] {
        assert_eq!(rig.write(index, 0, value), Ok(()), "{index:04X}h := {value:04X}h");
    }
    assert_eq!(rig.read(0x1018, 4), Err(0x0609_0011));
}

/// Each P-parameter of the ranges that the page names is a row of the table or marked, with the type of its group; each is
/// in the data sheet with the same name.
#[test]
fn each_p_parameter_is_in_the_table_or_marked_and_the_page_and_the_data_sheet_say_the_same() {
    const PAGE: &str = include_str!("../../docs/asda-a2-conformance.md");
    const SHEET: &str = include_str!("../eds/asda-a2.eds");
    let page = PAGE.split_whitespace().collect::<Vec<_>>().join(" ");
    let objects = AsdaA2::objects(Level::Full);
    let table: Vec<_> = rows().into_iter().map(|row| row.at.index.0).collect();
    let node = NodeId::new(NODE).unwrap();
    let (mut marked, mut known) = (0, 0);
    for group in 0..8_u16 {
        let from = page.find(&format!("P{group}-00 to ")).expect("a range") + "P0-00 to ".len();
        let last: u16 = page[from..from + 2].parse().unwrap();
        for number in 0..=last {
            let (index, name) = (0x2000 + 0x100 * group + number, format!("P{group}-{number:02}"));
            let object = objects.iter().find(|object| object.index.0 == index).expect(&name);
            assert!(SHEET.contains(&format!("ParameterName={}\n", object.name)), "{name}");
            if table.contains(&index) {
                assert!(object.name.starts_with(&name) && !object.name.ends_with(WITHOUT_EFFECT), "{name}");
                known += 1;
                continue;
            }
            marked += 1;
            assert_eq!(object.name, format!("{name}{WITHOUT_EFFECT}"));
            let [entry] = object.entries else { panic!("{name} has one entry") };
            let data = if group < 5 { DataType::I16 } else { DataType::I32 };
            assert_eq!((entry.sub.0, entry.data, entry.access), (0, data, Access::Rw), "{name}");
            assert!(entry.stored && entry.mapping != Mapping::No, "{name}");
            assert_eq!(entry.default_value(node).number(), Some(0), "{name}");
        }
    }
    let all = objects.iter().filter(|object| (0x2000..0x2800).contains(&object.index.0)).count();
    assert_eq!((marked + known, known), (all, 21));
}

#[test]
fn parameters_without_a_function_are_kept_and_have_no_effect() {
    let objects = AsdaA2::objects(Level::Full);
    let stored: Vec<_> = objects
        .iter()
        .filter(|object| object.name.ends_with(WITHOUT_EFFECT))
        .map(|o| (o.index.0, o.name))
        .collect();
    // Groups 0 to 7 without the 21 that the table above has.
    assert_eq!(stored.len(), 47 + 78 + 72 + 13 + 25 + 100 + 100 + 28 - 21);
    for (index, name) in [(0x2000, "P0-00"), (0x220A, "P2-10"), (0x2216, "P2-22"), (0x2663, "P6-99")] {
        assert!(stored.contains(&(index, &*format!("{name}{WITHOUT_EFFECT}"))), "{name}");
    }
    let mut rig = Rig::full();
    for (index, value, len) in [(0x2204, -35, 2), (0x220A, 0x101, 2), (0x2605, -70_000, 4)] {
        assert_eq!(rig.read(index, 0), Ok(0));
        assert_eq!(rig.write_len(index, 0, value as u32, len), Ok(()));
        assert_eq!(rig.write_len(index, 0, value as u32, 6 - len), Err(LENGTH));
    }
    rig.set(0x1010, 1, 0x6576_6173);
    rig.set(0x2204, 0, 1);
    rig.nmt(0x81);
    assert_eq!([rig.read(0x2204, 0), rig.read(0x220A, 0)], [Ok(0xFFDD), Ok(0x101)], "as saved");
    assert_eq!(rig.signed(0x2605), -70_000);
    let mut memory = [0; 4096];
    let len = rig.device.node().image(rig.device.application(), &mut memory).unwrap();
    let mut other = Rig::full();
    other.device = AsdaA2::new(Config::new(NODE), Quirks::default(), other.now);
    other.device.recall(other.now, &memory[..len]).unwrap();
    other.device.power_on(other.now);
    assert_eq!([other.read(0x2204, 0), other.read(0x2201, 0)], [Ok(0xFFDD), Ok(0)], "from the image");
    rig.set(0x1011, 1, 0x6461_6F6C);
    rig.nmt(0x81);
    assert_eq!([rig.read(0x2204, 0), rig.read(0x2605, 0)], [Ok(0); 2], "defaults");
}

#[test]
fn digit_c_of_p1_01_forgets_the_inputs_and_outputs_with_another_mode() {
    for (control_mode, kept) in [(0x000C, 0x101), (0x100C, 0)] {
        let mut rig = Rig::full();
        rig.set(0x2101, 0, control_mode);
        rig.set(0x6060, 0, 1);
        for index in [0x2209, 0x220A, 0x2216] {
            rig.set(index, 0, 0x101);
        }
        rig.set(0x6060, 0, 3);
        assert_eq!([rig.read(0x220A, 0), rig.read(0x2216, 0)], [Ok(kept); 2], "{control_mode:04X}h");
        assert_eq!(rig.read(0x2209, 0), Ok(0x101), "P2-09 is none of them");
    }
}

#[test]
fn parameters_without_a_function_are_absent_if_they_shall_be() {
    let quirks = Quirks { other_parameters_absent: true, ..Quirks::default() };
    let mut rig = Rig::with(Config::new(NODE), quirks);
    for index in [0x2000, 0x2204, 0x220A, 0x2700] {
        assert_eq!(rig.write(index, 0, 0), Err(0x0602_0000), "CN-237");
    }
    assert_eq!(rig.read(0x2223, 0), Ok(3_840_000));
    let mut rig = Rig::full();
    for index in [0x202F, 0x230D, 0x2664, 0x271C] {
        assert_eq!(rig.read(index, 0), Err(0x0602_0000), "{index:04X}h: the drive has no such parameter");
    }
}

#[test]
fn do_03_unknown_commands() {
    let mut rig = Rig::full();
    for command in [0x00, 0x21, 0x60, 0xA0, 0xC6, 0xFF] {
        let answer = rig.sdo([command, 0x00, 0x10, 0, 0, 0, 0, 0]);
        assert_eq!((answer[0], &answer[4..]), (0x80, &[0x01, 0x00, 0x04, 0x05][..]), "{command:02X}h");
    }
}

/// A request to 67Fh and its answer on 5FFh, from chapter 13 of the reference.
const TELEGRAMS: &[([u8; 8], [u8; 8])] = &[
    ([0x40, 0x00, 0x10, 0, 0, 0, 0, 0], [0x43, 0x00, 0x10, 0, 0x92, 0x01, 0x02, 0x04]),
    ([0x40, 0x18, 0x10, 1, 0, 0, 0, 0], [0x43, 0x18, 0x10, 1, 0xDD, 0x01, 0, 0]),
    ([0x40, 0x00, 0x23, 0, 0, 0, 0, 0], [0x4B, 0x00, 0x23, 0, 0x7F, 0, 0, 0]),
    ([0x40, 0x2C, 0x21, 0, 0, 0, 0, 0], [0x43, 0x2C, 0x21, 0, 1, 0, 0, 0]),
    ([0x40, 0x02, 0x65, 0, 0, 0, 0, 0], [0x43, 0x02, 0x65, 0, 0x6D, 0, 0, 0]),
    ([0x2F, 0x60, 0x60, 0, 1, 0, 0, 0], [0x60, 0x60, 0x60, 0, 0, 0, 0, 0]),
    ([0x2B, 0x40, 0x60, 0, 0x06, 0, 0, 0], [0x60, 0x40, 0x60, 0, 0, 0, 0, 0]),
    ([0x2B, 0x40, 0x60, 0, 0x07, 0, 0, 0], [0x60, 0x40, 0x60, 0, 0, 0, 0, 0]),
    ([0x2B, 0x40, 0x60, 0, 0x0F, 0, 0, 0], [0x60, 0x40, 0x60, 0, 0, 0, 0, 0]),
    ([0x23, 0x10, 0x10, 1, 0x73, 0x61, 0x76, 0x65], [0x60, 0x10, 0x10, 1, 0, 0, 0, 0]),
    ([0x23, 0x10, 0x10, 1, 0, 0, 0, 0], [0x80, 0x10, 0x10, 1, 0x20, 0, 0, 0x08]),
    ([0x2F, 0x60, 0x60, 0, 2, 0, 0, 0], [0x80, 0x60, 0x60, 0, 0x30, 0, 0x09, 0x06]),
];

#[test]
fn do_04_telegrams_of_the_reference_octet_for_octet() {
    let mut rig = Rig::full();
    for (request, answer) in TELEGRAMS {
        assert_eq!(rig.sdo(*request), *answer, "{request:02X?}");
    }
}

/// RPDO 1 := 60C1h:1 and 6040h, type 1: chapter 13.
const MAP_RPDO: [[u8; 8]; 7] = [
    [0x23, 0x00, 0x14, 1, 0x7F, 0x02, 0x00, 0x80],
    [0x2F, 0x00, 0x16, 0, 0, 0, 0, 0],
    [0x23, 0x00, 0x16, 1, 0x20, 0x01, 0xC1, 0x60],
    [0x23, 0x00, 0x16, 2, 0x10, 0x00, 0x40, 0x60],
    [0x2F, 0x00, 0x16, 0, 2, 0, 0, 0],
    [0x2F, 0x00, 0x14, 2, 1, 0, 0, 0],
    [0x23, 0x00, 0x14, 1, 0x7F, 0x02, 0x00, 0x00],
];

#[test]
fn dm_01_mapping() {
    let mut rig = Rig::full();
    for request in MAP_RPDO {
        let answer = rig.sdo(request);
        assert_eq!(
            (answer[0], &answer[1..4], &answer[4..]),
            (0x60, &request[1..4], &[0; 4][..]),
            "{request:02X?}"
        );
    }
    assert_eq!(rig.write(0x1600, 1, 0x607A_0020), Err(0x0800_0022), "count is not 0");
    rig.set(0x1400, 1, 0x8000_027F);
    rig.set(0x1600, 0, 0);
    assert_eq!(rig.write(0x1600, 1, 0x605B_0010), Err(0x0604_0041), "605Bh cannot be mapped (CN-208)");
    for (sub, mapped) in [(1, 0x607A_0020), (2, 0x6081_0020), (3, 0x6060_0008)] {
        rig.set(0x1600, sub, mapped);
    }
    assert_eq!(rig.write(0x1600, 0, 3), Err(0x0604_0042), "nine octets");
    assert_eq!(rig.write(0x1600, 0, 2), Ok(()));
}

#[test]
fn dm_02_process_data() {
    let mut rig = Rig::full();
    for (pdo, kind) in [(0, 1), (1, 255), (2, 255)] {
        rig.set(0x1800 + pdo, 1, 0x8000_0000 | i64::from(0x1FF + pdo * 0x100));
        rig.set(0x1A00 + pdo, 1, 0x6041_0010);
        rig.set(0x1A00 + pdo, 0, 1);
        rig.set(0x1800 + pdo, 2, kind);
    }
    rig.set(0x1801, 3, 100);
    rig.set(0x1802, 5, 20);
    for pdo in 0..3 {
        rig.set(0x1800 + pdo, 1, i64::from(0x1FF + pdo * 0x100));
    }
    rig.set(0x1400, 1, 0x8000_027F);
    rig.set(0x1600, 1, 0x6040_0010);
    rig.set(0x1600, 0, 1);
    rig.set(0x1400, 2, 1);
    rig.set(0x1400, 1, 0x27F);
    assert_eq!(rig.start(), ["2FF#50 02", "3FF#50 02"], "at the start of type 255");
    assert_eq!(rig.sync(), ["1FF#50 02"]);
    // RPDO of type 1: not before the SYNC.
    rig.pass(millis(20));
    assert!(rig.data(0x27F, &[0x06, 0x00]).is_empty());
    let seen = rig.sync();
    assert!(seen.contains(&"1FF#31 02".to_owned()), "{seen:?}");
    assert!(seen.contains(&"2FF#31 02".to_owned()), "{seen:?}");
    // The inhibit time of 10 ms, then the timer of 20 ms.
    rig.data(0x27F, &[0x07, 0x00]);
    let seen = rig.sync();
    assert!(!seen.contains(&"2FF#33 02".to_owned()), "{seen:?}");
    let seen = rig.pass(millis(20));
    assert!(seen.contains(&(10_000, "2FF#33 02".to_owned())), "{seen:?}");
    assert_eq!(seen.iter().filter(|(_, frame)| frame.starts_with("3FF")).count(), 1, "{seen:?}");
}

#[test]
fn half_can_open_has_its_own_60c1h_6099h_and_60c0h() {
    let mut rig = Rig::new(Level::Half);
    assert_eq!(rig.read(0x6040, 0), Ok(0));
    assert_eq!(rig.read(0x2101, 0), Ok(0x0B));
    assert_eq!(rig.read(0x60C1, 0), Ok(3));
    rig.set(0x60C1, 1, 0x5678);
    rig.set(0x60C1, 2, 0xFFFE);
    assert_eq!([rig.read(0x60C1, 1), rig.read(0x60C1, 2)], [Ok(0x5678), Ok(0xFFFE)]);
    assert_eq!(rig.write(0x60C0, 0, -2), Ok(()));
    assert_eq!([rig.write(0x6099, 1, 2001), rig.write(0x6099, 2, 501)], [Err(RANGE); 2]);
    let mut full = Rig::full();
    assert_eq!(full.write(0x60C0, 0, -2), Err(RANGE));
    assert_eq!([full.write(0x6099, 1, 20_000), full.write(0x6099, 2, 5000)], [Ok(()); 2], "CN-225");
}

#[test]
fn parameters_of_the_keypad_and_objects_are_one_value() {
    let mut rig = Rig::full();
    for (parameter, index, sub, written, read) in [
        (0x2122, 0x6083, 0, 300, 300),
        (0x2123, 0x6084, 0, 301, 301),
        (0x2124, 0x6087, 0, 302, 302),
        (0x2126, 0x606F, 0, 303, 303),
        (0x212C, 0x6093, 1, 128, 128),
        (0x212D, 0x6093, 2, 10, 10),
        (0x212F, 0x606D, 0, 30, 300),
        (0x2131, 0x606E, 0, 304, 304),
        (0x2223, 0x6065, 0, 305, 305),
        (0x2120, 0x605B, 0, 0x00, 0xFFFF),
        (0x2120, 0x605B, 0, 0x10, 0x0000),
    ] {
        rig.set(parameter, 0, written);
        assert_eq!(rig.read(index, sub), Ok(read), "{parameter:04X}h");
    }
    rig.set(0x605B, 0, -1);
    assert_eq!(rig.read(0x2120, 0), Ok(0));
    rig.set(0x2301, 0, 0x0405);
    assert_eq!(rig.read(0x2301, 0), Ok(0x0403), "CN-201: digit Z only");
    assert_eq!(rig.write(0x2301, 0, 0x0500), Err(RANGE));
}
