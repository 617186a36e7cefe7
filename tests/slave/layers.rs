//! The import table (`docs/design.md`): a layer uses the layers below it and no other.

use std::fs;
use std::path::{Path, PathBuf};

/// Module and what it may import of ours.
const TABLE: &[(&str, &[&str])] = &[
    ("time", &[]),
    ("fdl", &["time"]),
    ("dp", &["fdl", "time"]),
    ("can", &["time"]),
    ("canopen", &["can", "time"]),
    ("ppo", &[]),
    ("param", &[]),
    ("pkw", &["ppo", "param"]),
    ("drive", &["param", "time"]),
    ("ap10", &["time"]),
    ("device", &["time", "fdl", "dp", "ppo", "param", "pkw", "drive", "can", "canopen", "ap10"]),
    ("client", &["time", "ppo", "param", "pkw", "drive", "device"]),
    ("explain", &["time", "fdl", "dp", "ppo", "param", "pkw", "drive", "device"]),
    // One framer for a bus, generic slaves, links that keep telegrams apart or spoil them on purpose, and buses of CAN.
    ("host", &["device", "time", "fdl", "dp", "ppo", "can"]),
    ("panel", &["host", "device", "explain", "drive", "dp", "param", "ppo", "fdl", "time"]),
    ("master", &["host", "client", "device", "dp", "ppo", "fdl", "time"]),
];

#[test]
fn every_layer_imports_only_what_the_table_allows() {
    let mut breaches = Vec::new();
    for &(module, allowed) in TABLE {
        let files = files_of(module);
        assert!(!files.is_empty(), "module {module} has no file");
        for file in files {
            let text = fs::read_to_string(&file).unwrap();
            for (number, line) in text.lines().enumerate() {
                for imported in imports(line) {
                    if imported != module && !allowed.contains(&imported) {
                        breaches.push(format!("{}:{}: {}", file.display(), number + 1, line.trim()));
                    }
                }
            }
        }
    }
    assert!(breaches.is_empty(), "imports against the table:\n{}", breaches.join("\n"));
}

#[test]
fn every_module_is_in_the_table() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    for entry in fs::read_dir(source).unwrap() {
        let name = entry.unwrap().path().file_stem().unwrap().to_str().unwrap().to_owned();
        let known = TABLE.iter().any(|row| row.0 == name) || matches!(&name[..], "lib" | "main" | "command");
        assert!(known, "src/{name} is not in the table");
    }
}

#[test]
fn the_breach_of_the_table_would_be_seen() {
    assert_eq!(imports("use crate::drive::Status;").collect::<Vec<_>>(), ["drive"]);
    assert_eq!(imports("    let a = crate::fdl::decode(crate::dp::x);").collect::<Vec<_>>(), ["fdl", "dp"]);
    assert_eq!(imports("//! see [`dp`](crate::dp)").count(), 0, "a link in a comment is no import");
    assert_eq!(imports("use crate::{param, pkw};").collect::<Vec<_>>(), ["{param, pkw};"]);
}

/// The modules of ours that a line names, in code. A braced import is named whole, and so is never allowed.
fn imports(line: &str) -> impl Iterator<Item = &str> {
    let code = line.split("//").next().unwrap_or_default();
    code.split("crate::").skip(1).map(|rest| {
        if rest.starts_with('{') {
            return rest;
        }
        let end = rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(rest.len());
        &rest[..end]
    })
}

fn files_of(module: &str) -> Vec<PathBuf> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::from([source.join(format!("{module}.rs"))]);
    files.retain(|file| file.exists());
    let mut folders = Vec::from([source.join(module)]);
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).into_iter().flatten() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                files.push(path);
            }
        }
    }
    files
}
