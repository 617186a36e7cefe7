//! One place per fact: the bits of the words stand in `device::bits`, those of the diagnosis in `dp::DiagBit`, and
//! whoever needs one takes it from there.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use profidrive::devices::ag03::drive::Mode;
use profidrive::devices::ag03::param::TABLE;
use profidrive::devices::ag03::profibus::bits::{Bit, Role, Word, bits};
use profidrive::profibus::dp::chk_cfg::{COUNT, IdentifierBit, LENGTH, NOT_COMPARED, SpecialBit};
use profidrive::profibus::dp::{ControlBit, DiagBit, PrmBit, Service};
use profidrive::profibus::dpv1;

#[test]
fn no_bit_of_a_word_is_named_by_its_number() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let folders = [
        "client",
        "command",
        "devices/ag03/profibus",
        "devices/ppo_drive/profibus",
        "devices/profidrive4/profibus",
        "explain",
        "master",
        "panel",
    ]
    .map(|name| root.join(name));
    let mut found = Vec::new();
    for file in folders.iter().flat_map(|folder| sources(folder)) {
        let text = fs::read_to_string(&file).unwrap();
        let code = text.split("#[cfg(test)]").next().unwrap();
        for (number, line) in code.lines().enumerate().filter(|(_, line)| names_a_raw_bit(line)) {
            found.push(format!("{}:{}: {}", file.display(), number + 1, line.trim()));
        }
    }
    assert!(
        found.is_empty(),
        "take the bit from the table of the device or dp::DiagBit:\n{}",
        found.join("\n")
    );
}

#[test]
fn a_bit_named_by_its_number_would_be_seen() {
    for line in [
        "if zsw.bit(13) {",
        "stw.with_bit(6, true)",
        "let travels = ssw >> 4 & 1 == 1;",
        "const TRAVELS: u32 = 1 << 4;",
        "if raw & 0x0048 != 0 {",
        "Self::Enabled => (0x000B, true),",
    ] {
        assert!(names_a_raw_bit(line), "{line}");
    }
    for line in
        ["//! 000B, ssw >> 4 & 1", "ZswBit::Fault.is_set(zsw)", "word >> bit & 1 != 0", "let a = 0x44;"]
    {
        assert!(!names_a_raw_bit(line), "{line}");
    }
}

/// Whether a line of code has the number of a bit, or a word of four digits.
fn names_a_raw_bit(line: &str) -> bool {
    let code = line.split("//").next().unwrap();
    let digit_after = |pattern: &str| {
        code.match_indices(pattern)
            .any(|(at, _)| code[at + pattern.len()..].starts_with(|c: char| c.is_ascii_digit()))
    };
    let shifted = code.match_indices(">> ").any(|(at, _)| {
        let rest = &code[at + 3..];
        let digits = rest.chars().take_while(char::is_ascii_digit).count();
        digits > 0 && rest[digits..].starts_with(" & 1")
    });
    let word_after = |pattern: &str| {
        code.match_indices(pattern).any(|(at, _)| {
            let rest = &code[at + pattern.len()..];
            let digits = rest.chars().take_while(char::is_ascii_hexdigit).count();
            // Eight digits are written in two groups.
            digits == 4 && !rest[digits..].starts_with('_')
        })
    };
    let word = ["& 0x", "Some(0x", "from_raw(0x", "=> (0x", "= (0x"].into_iter().any(word_after);
    shifted || word || digit_after(".bit(") || digit_after(".with_bit(") || digit_after("= 1 << ")
}

fn sources(folder: &Path) -> Vec<PathBuf> {
    // `dip` has the bits of the switches, `bits` those of the words.
    let (mut files, mut folders) = (Vec::new(), vec![folder.to_owned()]);
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
            if matches!(&name[..], "tests" | "dip" | "bits" | "rig") {
                continue;
            }
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|ending| ending == "rs") {
                files.push(path);
            }
        }
    }
    files
}

#[test]
fn the_dissector_has_the_tables_of_the_crate() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/wireshark/profibus.lua");
    let text = fs::read_to_string(&file).unwrap();
    let begin = "-- Bits: { number, name, text, words for 1, words for 0 }.\n";
    let end = "-- end of the generated tables";
    let (head, rest) = text.split_once(begin).unwrap();
    let (found, tail) = rest.split_once(end).unwrap();
    let tables = tables();
    if std::env::var_os("WRITE_DISSECTOR").is_some() {
        fs::write(&file, format!("{head}{begin}{tables}{end}{tail}")).unwrap();
        return;
    }
    assert_eq!(found, tables, "run this test with WRITE_DISSECTOR=1");
}

/// What the page and the Python package say of a device comes from the server.
#[test]
fn the_page_and_the_python_package_name_no_device() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let files = ["src/panel/page", "python/profidrive"]
        .into_iter()
        .flat_map(|folder| fs::read_dir(root.join(folder)).unwrap())
        .map(|entry| entry.unwrap().path());
    let is_script = |file: &PathBuf| file.extension().is_some_and(|ending| ending == "js" || ending == "py");
    let scripts: Vec<_> = files.filter(is_script).collect();
    assert!(scripts.len() > 30, "{scripts:?}");
    for file in scripts {
        let text = fs::read_to_string(&file).unwrap().to_lowercase();
        for name in ["ag03", "ap10", "asda", "ppo", "siko"] {
            assert!(!text.contains(name), "{} names {name}", file.display());
        }
    }
}

/// The tables in Lua.
fn tables() -> String {
    let mut lua = String::from("local PNU = {\n");
    let names: BTreeMap<u16, &str> = TABLE.iter().map(|entry| (entry.pnu.number(), entry.name)).collect();
    for (pnu, name) in names {
        writeln!(lua, "    [{pnu}] = \"{name}\",").unwrap();
    }
    lua.push_str("}\n");
    for (place, table) in (0..3).zip(["DIAG_BITS_1", "DIAG_BITS_2", "DIAG_BITS_3"]) {
        let bits = DiagBit::ALL.iter().rev().filter(|bit| bit.octet() == place);
        octet(&mut lua, table, bits.map(|bit| (bit.number(), bit.name())));
    }
    lua.push_str("local SERVICE_OF_SAP = {\n");
    for service in Service::ALL {
        if let Some(sap) = service.sap() {
            writeln!(lua, "    [{sap}] = \"{}\",", service.name()).unwrap();
        }
    }
    lua.push_str("}\n");
    let mut numbered = |table: &str, rows: Vec<(u16, &str)>| {
        writeln!(lua, "local {table} = {{").unwrap();
        for (number, words) in rows {
            writeln!(lua, "    [{number}] = \"{words}\",").unwrap();
        }
        lua.push_str("}\n");
    };
    let functions = dpv1::Function::ALL.iter();
    numbered("V1_FUNCTION", functions.map(|function| (function.number().into(), function.name())).collect());
    let codes = dpv1::ErrorCode::ALL.iter();
    numbered("V1_ERROR", codes.filter_map(|code| Some((code.0.into(), code.words()?))).collect());
    let errors = (0..=0xFF).map(|number| (number, dpv1::base_mode::ParameterError(number).words()));
    numbered(
        "PARAMETER_ERROR",
        errors
            .filter(|(_, words)| !words.starts_with("a reserved") && !words.starts_with("an error of"))
            .collect(),
    );
    let formats = dpv1::base_mode::Format::ALL.iter();
    numbered("FORMAT", formats.clone().map(|format| (format.0.into(), format.words())).collect());
    writeln!(lua, "local FORMAT_SIZE = {{").unwrap();
    for format in formats {
        writeln!(lua, "    [{}] = {},", format.0, format.size().unwrap()).unwrap();
    }
    lua.push_str("}\n");
    octet(&mut lua, "PRM_BITS", PrmBit::ALL.iter().map(|bit| (bit.number(), bit.name())));
    octet(&mut lua, "CONTROL_BITS", ControlBit::ALL.iter().map(|bit| (bit.number(), bit.name())));
    octet(&mut lua, "IDENTIFIER_BITS", IdentifierBit::ALL.iter().map(|bit| (bit.number(), bit.name())));
    octet(&mut lua, "SPECIAL_BITS", SpecialBit::ALL.iter().map(|bit| (bit.number(), bit.name())));
    writeln!(lua, "local COUNTS, LENGTHS, NOT_COMPARED = {}, {}, {NOT_COMPARED}", COUNT + 1, LENGTH + 1)
        .unwrap();
    for (word, table) in [(Word::Stw, "STW_BITS"), (Word::Zsw, "ZSW_BITS"), (Word::Ssw, "SSW_BITS")] {
        writeln!(lua, "local {table} = {{").unwrap();
        let modes = bits(word, Mode::Positioning, None).into_iter().zip(bits(word, Mode::Velocity, None));
        for (n, (positioning, velocity)) in modes.enumerate() {
            if positioning.role != Role::Unused {
                writeln!(lua, "    {{ {n}, {} }},", row(positioning, velocity)).unwrap();
            }
        }
        lua.push_str("}\n");
    }
    lua
}

/// The bits of an octet, the highest first.
fn octet<'a>(lua: &mut String, table: &str, bits: impl Iterator<Item = (u8, &'a str)>) {
    writeln!(lua, "local {table} = {{").unwrap();
    for (number, name) in bits {
        let key = name.to_lowercase().replace(' ', "_");
        writeln!(lua, "    {{ {number}, \"{key}\", \"{name}\" }},").unwrap();
    }
    lua.push_str("}\n");
}

/// Name, text and words of a bit; the dissector does not know the operating mode.
fn row(positioning: &Bit, velocity: &Bit) -> String {
    let key = positioning.key.replace('-', "_");
    let name = positioning.name;
    let text = match (positioning.role, velocity.role) {
        (Role::Fixed(true), _) => format!("{name}, always 1"),
        (Role::Fixed(false), _) => format!("{name}, must be 0"),
        (_, Role::Fixed(value)) => format!("positioning: {name}; velocity: always {}", u8::from(value)),
        (_, Role::Unused) => format!("{name} (positioning)"),
        (_, Role::Level | Role::Edge) if velocity.name == name => name.into(),
        (_, Role::Level | Role::Edge) => format!("positioning: {name}; velocity: {}", velocity.name),
    };
    let same =
        velocity.role == Role::Unused || (velocity.one, velocity.zero) == (positioning.one, positioning.zero);
    if positioning.role == Role::Level && same {
        format!("\"{key}\", \"{text}\", \"{}\", \"{}\"", positioning.one, positioning.zero)
    } else {
        format!("\"{key}\", \"{text}\"")
    }
}
