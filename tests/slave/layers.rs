//! The import table: a layer uses the layers below it and no other, a bus no device and a device no bus.

use std::fs;
use std::path::{Path, PathBuf};

/// Module and what it may import of ours; a row includes what is below it and has no row of its own.
const TABLE: &[(&str, &[&str])] = &[
    ("time", &[]),
    // When a fault on purpose is injected.
    ("chance", &["time"]),
    // What is kept while a device is off, and the way to safety: of every device, on every bus.
    ("image", &[]),
    // A map of few keys, and news that wait; every layer may have them, the map where there is an allocator.
    ("map", &[]),
    ("untold", &[]),
    ("profibus::fdl", &["time"]),
    ("profibus::dp", &["profibus::fdl", "time"]),
    ("profibus::dpv1", &["profibus::dp", "profibus::fdl", "time"]),
    ("profibus::ppo", &[]),
    ("profibus::pkw", &["profibus::ppo"]),
    ("can_bus::can", &["time"]),
    ("can_bus::canopen", &["can_bus::can", "chance", "image", "time"]),
    ("can_bus::cia402", &[]),
    // What every device is asked: of the buses it has the place of an entry, the modes of drives, the names of alarms.
    ("face", &["can_bus::canopen", "can_bus::cia402", "profibus::dpv1", "time"]),
    // The devices without a bus, then on either bus.
    ("devices::ag03::param", &["face"]),
    ("devices::ag03::drive", &["devices::ag03::param", "time"]),
    ("devices::ag03::unit", &["devices::ag03::drive", "devices::ag03::param", "face", "image", "time"]),
    ("devices::ap10", &["face", "time"]),
    // Motor, load and motion of any servo drive; a drive of the profile, and one that can be bought.
    ("devices::servo", &["can_bus::cia402", "face", "time"]),
    ("devices::cia402_drive", &["can_bus::cia402", "devices::servo", "face", "time"]),
    ("devices::asda_a2", &["can_bus::cia402", "devices::servo", "face", "time"]),
    ("devices::ppo_drive", &[]),
    // A servo drive with the states, faults and tables of the drive of version 2.
    ("devices::profidrive4", &["devices::ppo_drive", "devices::servo", "time"]),
    ("devices::ppo_drive::profile", &["devices::ppo_drive", "face", "profibus::ppo"]),
    ("devices", &["can_bus", "devices", "face", "profibus", "time"]),
    ("devices::ag03::canopen", &["can_bus", "devices", "face", "image", "time"]),
    ("devices::ag03::profibus", &["devices", "face", "profibus", "time"]),
    ("devices::ap10::canopen", &["can_bus", "devices", "face", "time"]),
    ("devices::asda_a2::canopen", &["can_bus", "devices", "face", "time"]),
    // On CANopen only.
    ("devices::from_eds", &["can_bus", "device_file", "devices", "eds", "face", "image", "time"]),
    ("devices::ppo_drive::profibus", &["devices", "face", "profibus", "time"]),
    ("devices::profidrive4::profibus", &["devices", "face", "profibus", "time"]),
    // A slave at a UART: a drive, or a station of one's own. And the words of every layer for its log.
    ("embedded", &["can_bus", "devices", "face", "image", "profibus", "time"]),
    // The bits of the diagnosis.
    ("client", &["can_bus", "devices", "face", "profibus", "time"]),
    // A machine behind any slave.
    ("process", &["time"]),
    // Text of a device file, and what is odd in it.
    ("device_file", &[]),
    // A slave of any kind.
    ("gsd", &["device_file", "process", "profibus::dp", "profibus::dpv1", "profibus::fdl", "time"]),
    // A node of any kind.
    ("eds", &["can_bus::canopen", "device_file"]),
    ("explain", &["can_bus", "devices", "face", "profibus", "time"]),
    // One framer for a bus, generic slaves, links that keep telegrams apart or corrupt them on purpose, and buses of CAN.
    (
        "host",
        &[
            "can_bus",
            "chance",
            "device_file",
            "devices",
            "eds",
            "face",
            "gsd",
            "image",
            "process",
            "profibus",
            "time",
        ],
    ),
    ("bench", &["devices", "explain", "face", "host", "profibus", "time"]),
    // Stations on a line, live or simulated, and telegrams in words.
    (
        "judge",
        &[
            "bench", "can_bus", "chance", "client", "devices", "eds", "explain", "gsd", "host", "profibus",
            "time",
        ],
    ),
    ("panel", &["can_bus", "devices", "explain", "face", "gsd", "host", "process", "profibus", "time"]),
    // The numbers of lines, served as the panel is.
    ("metrics", &["can_bus", "devices", "face", "host", "panel", "profibus"]),
    ("master", &["bench", "can_bus", "client", "devices", "explain", "face", "host", "profibus", "time"]),
];

#[test]
fn every_layer_imports_only_what_the_table_allows() {
    let mut breaches = Vec::new();
    for &(module, allowed) in TABLE {
        let files = files_of(&module.replace("::", "/"));
        assert!(!files.is_empty(), "module {module} has no file");
        for file in files.iter().filter(|file| row(&place(file).join("::")) == module) {
            let text = fs::read_to_string(file).unwrap();
            for import in imports(&text, &place(file)) {
                let allowed = allowed.iter().chain(&["map", "untold"]).any(|above| is_in(&import, above));
                if !is_in(&import, module) && !allowed {
                    breaches.push(format!("{}: {import}", file.display()));
                }
            }
        }
    }
    assert!(breaches.is_empty(), "imports against the table:\n{}", breaches.join("\n"));
}

#[test]
fn a_bus_knows_no_device_and_a_device_no_bus() {
    for (module, allowed) in TABLE {
        // What every drive of CiA 402 is, whatever its bus, and the words of the profile.
        let of_profile = |known: &str| matches!(known, "can_bus::cia402" | "profibus::ppo");
        let on_a_bus = ["::profibus", "::canopen", "::from_eds"].iter().any(|bus| module.ends_with(bus));
        for known in *allowed {
            let breach = match module.split("::").next() {
                Some("profibus" | "can_bus") => known.starts_with("devices") || *known == "face",
                Some("devices") if *module != "devices" && !on_a_bus => {
                    (known.starts_with("profibus") || known.starts_with("can_bus")) && !of_profile(known)
                }
                _above => false,
            };
            assert!(!breach, "{module} may not import {known}");
        }
    }
}

/// Folders of the faces that name a kind of device, and why: what is not here asks the list of devices and the descriptions.
///
/// A master has no device of ours at its other end, and so no description of one: what it sends and expects are the words and
/// units of the drive. Each kind of drive has one folder for that, behind the trait `Commissioned`.
const NAMES_A_DEVICE: &[(&str, &str)] = &[
    ("command/master/positioning", "the master's end of the positioning drives"),
    ("command/master/ppo", "the master's end of any drive with variable speed of PROFIDRIVE"),
];

/// How kinds of devices are named, in modules, types, options and texts; without `_` and `-`, which may be there.
const KINDS: &[&str] =
    &["ag03", "ap10", "asda", "cia402drive", "edsnode", "fromeds", "gsdstation", "ppodrive", "profidrive4"];

/// The kinds that a file names in its code and texts. Of comments those that are texts: the help of an option is one.
fn kinds_named(text: &str, help: bool) -> Vec<&'static str> {
    let shown = |line: &&str| {
        let line = line.trim_start();
        !line.starts_with("//") || help && line.starts_with("///")
    };
    let code = text.split("#[cfg(test)]\nmod ").next().unwrap();
    let code: String = code.lines().filter(shown).collect::<Vec<_>>().join("\n");
    let plain = code.to_lowercase().replace(['_', '-'], "");
    KINDS.iter().copied().filter(|kind| plain.contains(kind)).collect()
}

#[test]
fn a_face_names_no_kind_of_device_but_where_it_must() {
    let mut unused: Vec<_> = NAMES_A_DEVICE.iter().map(|(file, _)| *file).collect();
    let mut breaches = Vec::new();
    for file in ["command", "metrics", "panel"].into_iter().flat_map(files_of) {
        let place = place(&file).join("/");
        let named = kinds_named(&fs::read_to_string(&file).unwrap(), place.starts_with("command/args"));
        if named.is_empty() {
            continue;
        }
        match NAMES_A_DEVICE.iter().find(|(file, _)| place == *file || place.starts_with(&format!("{file}/")))
        {
            Some((file, _)) => unused.retain(|row| row != file),
            None => breaches.push(format!("{place}: {}", named.join(", "))),
        }
    }
    assert_eq!(breaches, [""; 0], "ask the list of devices, or the description");
    assert_eq!(unused, [""; 0], "they name no kind of device any more: delete their rows");
}

#[test]
fn a_kind_of_device_is_seen_in_code_texts_and_help() {
    for (line, help, named) in [
        ("use crate::devices::ag03::param;", false, "ag03"),
        ("Group::PpoDrive => {}", false, "ppodrive"),
        ("let text = \"--device asda-a2\";", false, "asda"),
        ("    /// Of an AP10 only.", true, "ap10"),
        ("    /// Of an AP10 only.", false, ""),
        ("    // As the AP10 does it.", true, ""),
        ("let master = crate::profidrive();", false, ""),
        ("#[cfg(test)]\nmod tests { fn ag03() {} }", false, ""),
    ] {
        assert_eq!(kinds_named(line, help).join(" "), named, "{line}");
    }
}

#[test]
fn every_module_is_in_the_table() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    for entry in fs::read_dir(source).unwrap() {
        let name = entry.unwrap().path().file_stem().unwrap().to_str().unwrap().to_owned();
        let known = TABLE.iter().any(|row| is_in(row.0, &name))
            || matches!(&name[..], "lib" | "main" | "command" | "profibus" | "can_bus");
        assert!(known, "src/{name} is not in the table");
    }
}

/// The row of a module: the longest path that it is in; empty if there is none.
fn row(module: &str) -> &'static str {
    let rows = TABLE.iter().map(|row| row.0).filter(|row| is_in(module, row));
    rows.max_by_key(|row| row.len()).unwrap_or_default()
}

/// Whether a path is that module or below it.
fn is_in(path: &str, module: &str) -> bool {
    path.strip_prefix(module).is_some_and(|rest| rest.is_empty() || rest.starts_with("::"))
}

#[test]
fn every_form_of_path_to_another_layer_is_seen() {
    let at = |place: &[&str], code: &str| {
        let place: Vec<_> = place.iter().map(|name| (*name).to_owned()).collect();
        let imports = imports(code, &place);
        let mut roots: Vec<_> = imports.iter().map(|import| import.split("::").next().unwrap()).collect();
        roots.dedup();
        roots.join(" ")
    };
    for (code, seen) in [
        ("use crate::drive::Status;", "drive"),
        ("let a = crate::fdl::decode(crate::dp::x);", "fdl dp"),
        ("use crate::{param, pkw};", "param pkw"),
        ("use crate::{\n    fdl::{Address, Telegram},\n    dp::{self as d},\n};", "fdl dp"),
        ("use crate :: dp;", "dp"),
        ("use super::super::dp::Slave;", "dp"),
        ("use super::super as root;", "crate root"),
        ("use super::{super::fdl, states};", "fdl unit"),
        ("use self::super::super::fdl::Address;", "fdl"),
        ("pub(in crate::panel) fn x() {}", "panel"),
        ("pub use crate::device::Config;", "device"),
        ("use ::profidrive::host::run;", "host"),
        ("use profidrive::explain;", "explain"),
        ("macro_rules! m { () => { $crate::master::Session } }", "master"),
        ("use crate::*;", "crate root"),
        ("use crate as all;", "crate root"),
        ("mod tests { use super::super::super::dp; }", "dp"),
        ("mod tests { mod deeper { use super::super::Unit; } } use super::super::ppo;", "unit ppo"),
        ("fn f() { super::g(); self::h(); }", "unit"),
        ("//! see [`dp`](crate::dp)\n/* crate::dp /* crate::fdl */ */", ""),
        ("let s = \"crate::dp\"; let r = r#\"crate::\"dp\"#; let c = '\"'; crate::time::x", "time"),
        ("pub(crate) fn f() {} pub(super) fn g<'a>(x: &'a str) {}", ""),
        ("let superb::x = selfish::y;", ""),
    ] {
        assert_eq!(at(&["unit", "storage"], code), seen, "{code}");
    }
}

/// The modules of a file in `src`: `src/host/bus/hint.rs` is in host, bus, hint.
fn place(file: &Path) -> Vec<String> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let names = file.strip_prefix(source).unwrap().with_extension("");
    let names = names.iter().map(|name| name.to_str().unwrap().to_owned());
    names.filter(|name| name != "mod").collect()
}

/// Where paths in the code of a file lead to, by any form of path: from the root, from above, in
/// braces, in macros. A path to the root itself could lead anywhere and is named so.
fn imports(text: &str, place: &[String]) -> Vec<String> {
    let tokens = tokens(text);
    let mut found = Vec::new();
    // The module at hand, and how deep in braces each inline module began.
    let (mut here, mut inline, mut depth) = (place.to_vec(), Vec::new(), 0);
    for (n, token) in tokens.iter().enumerate() {
        match token.as_str() {
            "{" => {
                depth += 1;
                if n >= 2 && tokens[n - 2] == "mod" {
                    here.push(tokens[n - 1].clone());
                    inline.push(depth);
                }
            }
            "}" => {
                if inline.last() == Some(&depth) {
                    inline.pop();
                    here.pop();
                }
                depth -= 1;
            }
            root @ ("crate" | "profidrive" | "super" | "self") => {
                let follows_a_name = n >= 2 && is_name(&tokens[n - 2]) && tokens[n - 2] != "use";
                let starts = n < 1 || tokens[n - 1] != "::" || !follows_a_name;
                let leads_on =
                    tokens.get(n + 1).is_some_and(|next| next == "::" || next == "as" && root == "crate");
                // In the braces of a longer path it was seen with that one.
                let in_braces =
                    matches!(root, "super" | "self") && n >= 1 && matches!(tokens[n - 1].as_str(), "{" | ",");
                if starts && leads_on && !(in_braces && opened_by_path(&tokens, n)) {
                    tree(&tokens, n, here.clone(), &mut found);
                }
            }
            _other => {}
        }
    }
    found.dedup();
    found
}

/// Whether the brace around token `n` belongs to a path.
fn opened_by_path(tokens: &[String], n: usize) -> bool {
    let mut closed = 0;
    for at in (0..n).rev() {
        match tokens[at].as_str() {
            "}" => closed += 1,
            "{" if closed > 0 => closed -= 1,
            "{" => return at > 0 && tokens[at - 1] == "::",
            _other => {}
        }
    }
    false
}

/// Follows the path that goes on at token `n` below the module `at`; returns where it ends.
fn tree(tokens: &[String], mut n: usize, mut at: Vec<String>, found: &mut Vec<String>) -> usize {
    loop {
        match tokens.get(n).map(String::as_str) {
            Some("crate" | "profidrive") => at.clear(),
            Some("self") => {}
            Some("super") => _ = at.pop(),
            Some("{") => {
                n += 1;
                while tokens.get(n).is_some_and(|token| token != "}") {
                    n = tree(tokens, n, at.clone(), found);
                    while tokens.get(n).is_some_and(|token| token != "," && token != "}") {
                        n += 1;
                    }
                    n += usize::from(tokens.get(n).is_some_and(|token| token == ","));
                }
                return n + 1;
            }
            Some(name) if is_name(name) => at.push(name.to_owned()),
            _end => break,
        }
        if tokens.get(n + 1).is_none_or(|next| next != "::") {
            break;
        }
        n += 2;
    }
    let path = at.join("::");
    found.push(if path.is_empty() { "crate root".to_owned() } else { path });
    n + 1
}

fn is_name(token: &str) -> bool {
    token.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

/// Names, `::`, and every other sign by itself; without comments, texts and characters.
pub(crate) fn tokens(text: &str) -> Vec<String> {
    let mut tokens = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let len = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            comment(rest)
        } else if first == 'r' && rest[1..].trim_start_matches('#').starts_with('"') {
            let hashes = rest[1..].find('"').unwrap();
            let end = format!("\"{}", "#".repeat(hashes));
            let from = 2 + hashes;
            rest[from..].find(&end).map_or(rest.len(), |at| from + at + end.len())
        } else if first == '"' {
            quoted(rest, '"')
        } else if first == '\'' {
            // A character, not a lifetime.
            let character = rest[1..].starts_with('\\') || rest.chars().nth(2) == Some('\'');
            if character { quoted(rest, '\'') } else { 1 }
        } else if first.is_alphanumeric() || first == '_' {
            let len = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
            tokens.push(rest[..len].to_owned());
            len
        } else if rest.starts_with("::") {
            tokens.push("::".to_owned());
            2
        } else {
            if !first.is_whitespace() {
                tokens.push(first.to_string());
            }
            first.len_utf8()
        };
        rest = &rest[len..];
    }
    tokens
}

/// The length of a block comment, with those inside it.
fn comment(text: &str) -> usize {
    let (mut depth, mut at) = (0, 0);
    while at < text.len() {
        let rest = &text.as_bytes()[at..];
        at += if rest.starts_with(b"/*") {
            depth += 1;
            2
        } else if rest.starts_with(b"*/") {
            depth -= 1;
            2
        } else {
            1
        };
        if depth == 0 {
            break;
        }
    }
    at
}

/// The length of a text or character, its quotes included.
fn quoted(text: &str, quote: char) -> usize {
    let mut escaped = false;
    for (at, c) in text.char_indices().skip(1) {
        match c {
            _any if escaped => escaped = false,
            '\\' => escaped = true,
            end if end == quote => return at + 1,
            _other => {}
        }
    }
    text.len()
}

pub(crate) fn files_of(module: &str) -> Vec<PathBuf> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::from([source.join(format!("{module}.rs"))]);
    files.retain(|file| file.exists());
    let mut folders = Vec::from([source.join(module)]);
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).into_iter().flatten() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                files.push(path);
            }
        }
    }
    files
}
