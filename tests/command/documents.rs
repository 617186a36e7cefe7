//! Every console block of a document: each command behind `$` is run, and prints what the block shows.
//!
//! What runs until it is ended (`emulate`, a line that ends with `&`) runs to the end of its block. `/tmp/` is a folder of
//! the test, a port of 127.0.0.1 a free one; a port that is printed is not compared. `...` in what is shown stands for any
//! text up to the end of the line, a line of it for any lines.

use std::fs;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use super::emulator::Emulator;

/// A command of a block and what the block shows behind it.
#[derive(Debug, PartialEq)]
struct Shown {
    command: String,
    lines: Vec<String>,
}

impl Shown {
    fn runs_on(&self) -> bool {
        self.command.ends_with('&') || self.command.starts_with("profidrive emulate ")
    }
}

/// The blocks of a page.
fn blocks(page: &str) -> Vec<Vec<Shown>> {
    let mut blocks = Vec::new();
    let mut lines = page.lines();
    while lines.by_ref().any(|line| line.trim() == "```console") {
        let mut block: Vec<Shown> = Vec::new();
        let mut continued = false;
        for line in lines.by_ref().take_while(|line| line.trim() != "```") {
            if let Some(command) = line.strip_prefix("$ ") {
                block.push(Shown { command: command.into(), lines: Vec::new() });
            } else if continued {
                block.last_mut().unwrap().command.push_str(line.trim());
            } else {
                block.last_mut().expect("a block begins with a command").lines.push(line.trim_end().into());
            }
            continued = line.ends_with('\\');
            if continued {
                let command = &mut block.last_mut().unwrap().command;
                command.truncate(command.trim_end_matches(['\\', ' ']).len());
                command.push(' ');
            }
        }
        blocks.push(block);
    }
    blocks
}

/// Every document with a console block.
fn pages() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut pages: Vec<PathBuf> =
        fs::read_dir(root.join("docs")).unwrap().map(|entry| entry.unwrap().path()).collect();
    pages.push(root.join("README.md"));
    pages.retain(|page| page.extension().is_some_and(|extension| extension == "md"));
    pages.sort();
    pages
}

/// The same with the folder and the port of a test.
struct Place {
    folder: tempfile::TempDir,
    port: u16,
}

impl Place {
    fn new() -> Self {
        let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        Self { folder: tempfile::tempdir().unwrap(), port }
    }

    fn of(&self, text: &str) -> String {
        let folder = format!("{}/", self.folder.path().display());
        text.replace("127.0.0.1:5000", &format!("127.0.0.1:{}", self.port)).replace("/tmp/", &folder)
    }

    /// Runs in a shell, as it is written; only a master on PROFIBUS waits longer for replies, as a busy machine needs it.
    fn shell(&self, command: &str) -> Command {
        let patient = "profidrive master --watchdog 60s --baud 93750 --slot-time 300ms ";
        let command = match command.strip_prefix("profidrive master ") {
            Some(rest) if !rest.contains("--node") => format!("{patient}{rest}"),
            Some(_) | None => command.to_owned(),
        };
        let binary = Path::new(env!("CARGO_BIN_EXE_profidrive")).parent().unwrap();
        let path = format!("{}:{}", binary.display(), std::env::var("PATH").unwrap_or_default());
        let mut shell = Command::new("sh");
        shell.args(["-c", &format!("exec {command}")]).current_dir(self.folder.path());
        shell.env("PATH", path).env_remove("RUST_LOG").stdin(Stdio::null());
        shell
    }
}

/// Whether this was printed where that is shown.
fn is_shown(printed: &[&str], shown: &[String]) -> bool {
    let Some((first, shown)) = shown.split_first() else { return printed.is_empty() };
    if first == "..." {
        return (0..=printed.len()).any(|from| is_shown(&printed[from..], shown));
    }
    let Some((line, printed)) = printed.split_first() else { return false };
    let same = match first.strip_suffix("...") {
        Some(begin) => without_port(line).starts_with(&without_port(begin)),
        None => without_port(line) == without_port(first),
    };
    same && is_shown(printed, shown)
}

fn without_port(line: &str) -> String {
    let mut parts = line.split("127.0.0.1:");
    let mut text: String = parts.next().unwrap_or_default().trim_end().into();
    for part in parts {
        text.push_str("127.0.0.1:PORT");
        text.push_str(part.trim_start_matches(|digit: char| digit.is_ascii_digit()).trim_end());
    }
    text
}

#[test]
fn every_command_of_a_document_prints_what_the_document_shows() {
    let mut commands = 0;
    for page in pages() {
        for block in blocks(&fs::read_to_string(&page).unwrap()) {
            let (place, mut running) = (Place::new(), Vec::new());
            for shown in &block {
                let lines: Vec<String> = shown.lines.iter().map(|line| place.of(line)).collect();
                let command = place.of(shown.command.trim_end_matches(['&', ' ']));
                let printed = if shown.runs_on() {
                    let emulator = Emulator::spawn(&mut place.shell(&command));
                    let ready = emulator.ready.clone();
                    running.push(emulator);
                    if lines.is_empty() { String::new() } else { ready }
                } else {
                    let output = place.shell(&command).output().unwrap();
                    let stderr = String::from_utf8(output.stderr).unwrap();
                    String::from_utf8(output.stdout).unwrap() + &stderr
                };
                let printed: Vec<&str> = printed.trim_end().lines().collect();
                assert!(
                    is_shown(&printed, &lines),
                    "{}: $ {command}\n{}",
                    page.display(),
                    printed.join("\n")
                );
                commands += 1;
            }
        }
    }
    assert!(commands >= 15, "{commands} commands in all documents");
}

#[test]
fn the_readme_is_short_and_each_user_has_a_first_minute_in_it() {
    let readme = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md")).unwrap();
    assert!(readme.lines().count() <= 120, "{} lines", readme.lines().count());
    let minute = readme.split("\n## Your first minute\n").nth(1).unwrap().split("\n## ").next().unwrap();
    for user in ["Technician on Windows", "Test engineer", "Rust developer", "Embedded developer"] {
        let part = minute.split(&format!("### {user}\n")).nth(1).unwrap().split("\n### ").next().unwrap();
        assert!(part.contains('`'), "{user} has something to type");
    }
    assert_eq!(readme.matches("![").count(), 2, "one picture of a judged master, one of the panel");
}

/// A link in a document to a file of the repository leads there.
#[test]
fn every_link_of_a_document_leads_to_a_file() {
    for page in pages() {
        let text = fs::read_to_string(&page).unwrap();
        for link in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let file = link.split('#').next().unwrap_or_default();
            let there = file.is_empty() || file.contains("://") || page.parent().unwrap().join(file).exists();
            assert!(there, "{}: {link}", page.display());
        }
    }
}

#[test]
fn what_is_printed_is_compared_with_what_is_shown() {
    let shown = |lines: &[&str]| lines.iter().map(|&line| line.into()).collect::<Vec<String>>();
    for (printed, lines, same) in [
        (&["a", "b"][..], &["a", "b"][..], true),
        (&["a", "b"], &["a"], false),
        (&["a"], &["a", "b"], false),
        (&["a", "b", "c"], &["a", "...", "c"], true),
        (&["a", "c"], &["a", "...", "c"], true),
        (&["a", "b"], &["...", "c"], false),
        (&["panel=http://127.0.0.1:4711"], &["panel=http://127.0.0.1:8080"], true),
        (&["INFO all"], &["INFO ..."], true),
        (&["WARN all"], &["INFO ..."], false),
    ] {
        assert_eq!(is_shown(printed, &shown(lines)), same, "{printed:?} {lines:?}");
    }
    let page = "text\n```console\n$ one \\\n    two\nx\n$ three &\n```\n";
    let first = Shown { command: "one two".into(), lines: shown(&["x"]) };
    assert_eq!(blocks(page), [vec![first, Shown { command: "three &".into(), lines: Vec::new() }]]);
}
