//! Names of types: in one layer a public name stands once, and none of ours goes by another name where it is used.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use super::layers::{files_of, tokens};

/// Parts of a layer, the longest first, that say of another device or bus what the layer says of its own, in the same words: the module says
/// which one is meant, `ap10::canopen::Quirks`.
const PARTS: &[&str] = &[
    "devices/ag03/canopen",
    "devices/ag03/drive",
    "devices/ag03/param",
    "devices/ag03/profibus",
    "devices/ag03/unit",
    "devices/ap10/canopen",
    "devices/ap10",
    "devices/asda_a2/canopen",
    "devices/asda_a2",
    "devices/ppo_drive/profibus",
    "devices/ppo_drive/profile",
    "devices/ppo_drive",
    "devices/profidrive4/profibus",
    "devices/profidrive4",
    "can_bus/can",
    "can_bus/canopen",
    "can_bus/cia402",
    "profibus/dp",
    "profibus/dpv1",
    "profibus/fdl",
    "profibus/pkw",
    "profibus/ppo",
    "host/can",
    "judge/device/node",
    "judge/device/slave",
    "judge/device",
];

/// What takes the place of another file on a system that has not what that one needs.
const SUBSTITUTES: &[&str] = &["host/link/no_pty.rs", "host/link/terminal_windows.rs"];

fn source() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// The layers, and the program. Some have a file beside their folder.
fn modules() -> BTreeSet<String> {
    let entries = fs::read_dir(source()).unwrap().map(|entry| entry.unwrap().path());
    entries.map(|path| path.file_stem().unwrap().to_str().unwrap().to_owned()).collect()
}

/// A part of its layer, or the layer.
fn part(module: &str, file: &Path) -> String {
    let within = |part: &&&str| file.starts_with(source().join(part));
    PARTS.iter().find(within).map_or_else(|| module.to_owned(), |part| (*part).to_owned())
}

/// The names of the types that a file declares as public.
fn public_types(tokens: &[String]) -> impl Iterator<Item = &String> {
    tokens.windows(3).filter_map(|three| match three {
        [public, kind, name] if public == "pub" => {
            let declares = matches!(kind.as_str(), "struct" | "enum" | "trait" | "type" | "union");
            (declares && name.starts_with(char::is_alphabetic)).then_some(name)
        }
        _other => None,
    })
}

#[test]
fn a_public_name_of_a_type_stands_once_in_a_layer() {
    let mut places = BTreeMap::<(String, String), Vec<String>>::new();
    for module in modules() {
        for file in files_of(&module) {
            let place = file.strip_prefix(source()).unwrap().to_str().unwrap().to_owned();
            if SUBSTITUTES.contains(&place.as_str()) {
                continue;
            }
            for name in public_types(&tokens(&fs::read_to_string(&file).unwrap())) {
                places.entry((part(&module, &file), name.clone())).or_default().push(place.clone());
            }
        }
    }
    assert!(places.len() > 500, "{} types", places.len());
    places.retain(|_, files| files.len() > 1);
    assert!(places.is_empty(), "in one layer one name for several types: {places:#?}");
}

/// Of two types with one name OpenAPI has one schema, which is wrong for the other.
#[test]
fn a_name_of_a_schema_stands_once() {
    let mut places = BTreeMap::<String, Vec<String>>::new();
    for file in files_of("panel") {
        let text = fs::read_to_string(&file).unwrap();
        for (_, rest) in
            text.match_indices("derive(utoipa::ToSchema)").map(|(at, found)| text[at..].split_at(found.len()))
        {
            let item = rest.lines().find_map(|line| line.split_once("struct ").or(line.split_once("enum ")));
            let name = item.unwrap().1.split(|letter: char| !letter.is_alphanumeric()).next().unwrap();
            places.entry(name.to_owned()).or_default().push(file.display().to_string());
        }
    }
    assert!(places.len() > 50, "{} schemas", places.len());
    places.retain(|_, files| files.len() > 1);
    assert!(places.is_empty(), "one name for several schemas: {places:#?}");
}

/// The types of ours that a file imports under another name, as `Event as UnitEvent`.
fn renamed(tokens: &[String]) -> Vec<String> {
    let is_type = |name: &str| name.starts_with(char::is_uppercase) && name.contains(char::is_lowercase);
    let mut renamed = Vec::new();
    for (n, _) in tokens.iter().enumerate().filter(|(_, token)| *token == "use") {
        let end = tokens[n..].iter().position(|token| token == ";").map_or(tokens.len(), |len| n + len);
        let path = &tokens[n + 1..end];
        let ours = path
            .first()
            .is_some_and(|root| matches!(root.as_str(), "crate" | "super" | "self" | "profidrive"));
        for three in path.windows(3).filter(|three| ours && three[1] == "as") {
            if is_type(&three[0]) && is_type(&three[2]) {
                renamed.push(three.join(" "));
            }
        }
    }
    renamed
}

#[test]
fn no_type_of_ours_is_imported_under_another_name() {
    let mut breaches = Vec::new();
    for file in modules().iter().flat_map(|module| files_of(module)) {
        for found in renamed(&tokens(&fs::read_to_string(&file).unwrap())) {
            breaches.push(format!("{}: {found}", file.display()));
        }
    }
    assert!(breaches.is_empty(), "{}", breaches.join("\n"));
}

#[test]
fn other_names_are_seen_in_every_form() {
    for (code, seen) in [
        ("use crate::devices::ag03::unit::Event as UnitEvent;", "Event as UnitEvent"),
        ("pub use super::{a, b::{Event as UnitEvent, Power}};", "Event as UnitEvent"),
        ("use profidrive::devices::ag03::drive::{self, Inputs as Plant};", "Inputs as Plant"),
        ("use crate::profibus::dp::application::Application as _;", ""),
        ("use super::ppo_drives::parameters as ppo_parameters;", ""),
        ("use std::net::TcpStream as Socket;", ""),
        ("fn f() { use crate::devices::ag03::param::Unit as U; }", ""),
    ] {
        assert_eq!(renamed(&tokens(code)).join(", "), seen, "{code}");
    }
    let code = "pub struct A; pub(super) enum B {} enum C {} pub trait D {} macro_rules! m { () => { pub enum $name {} } }";
    assert_eq!(public_types(&tokens(code)).collect::<Vec<_>>(), ["A", "D"]);
}

/// Words that a technician did not understand at the first reading.
const UNCLEAR: &[&str] = &[
    "spoil",
    "struck",
    "`apart()`",
    "warning gone",
    "release is asked for",
    "no guarding request for the life time",
];

#[test]
fn no_unclear_word_is_in_a_sentence() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let pages = ["docs", "examples", "gsd", "python/profidrive", ""].iter().flat_map(|folder| {
        let files = fs::read_dir(root.join(folder)).unwrap().map(|entry| entry.unwrap().path());
        let is_page = |file: &PathBuf| {
            file.extension().is_some_and(|kind| kind == "md" || kind == "py" || kind == "txt")
        };
        // What has changed is told in the words of its time.
        files.filter(move |file| is_page(file) && !file.ends_with("CHANGELOG.md"))
    });
    let pages: Vec<_> = pages.collect();
    assert!(pages.len() > 40, "{} pages", pages.len());
    let mut found = Vec::new();
    for file in modules().iter().flat_map(|module| files_of(module)).chain(pages) {
        let text = fs::read_to_string(&file).unwrap().to_lowercase();
        let words = UNCLEAR.iter().filter(|word| text.contains(**word));
        found.extend(words.map(|word| format!("{}: {word}", file.display())));
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}
