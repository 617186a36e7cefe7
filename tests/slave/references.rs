//! What code and tests cite can be read here: each document is in the repository, with the section or row cited.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

#[test]
fn every_document_that_is_cited_exists() {
    let missing: Vec<String> = lines()
        .filter(|line| {
            documents(&line.text).any(|name| {
                let beside = line.file.parent().unwrap();
                !["", "docs", "docs/reference", "docs/wireshark"]
                    .iter()
                    .map(|folder| root().join(folder))
                    .chain([beside.to_owned()])
                    .any(|folder| folder.join(name).is_file())
            })
        })
        .map(|line| line.shown())
        .collect();
    assert!(missing.is_empty(), "cited, but not in the repository:\n{}", missing.join("\n"));
}

#[test]
fn every_section_that_is_cited_exists() {
    for name in ["ag03.md", "dp-v0.md", "profidrive-v2.md"] {
        let text = fs::read_to_string(root().join("docs/reference").join(name)).unwrap();
        let headings: BTreeSet<&str> = text
            .lines()
            .filter(|line| line.starts_with("##"))
            .filter_map(|line| line.trim_start_matches(['#', ' ']).split(' ').next())
            .map(|number| number.trim_end_matches('.'))
            .collect();
        let missing: Vec<String> = lines()
            .filter(|line| sections(&line.text, name).any(|number| !headings.contains(number)))
            .map(|line| line.shown())
            .collect();
        assert!(missing.is_empty(), "no such section in {name}:\n{}", missing.join("\n"));
    }
}

#[test]
fn every_contradiction_and_row_that_is_cited_exists() {
    let text = fs::read_to_string(root().join("docs/reference/ag03.md")).unwrap();
    let rows: BTreeSet<&str> =
        text.lines().filter_map(|line| line.strip_prefix("| ")?.split(' ').next()).collect();
    let mut missing = Vec::new();
    for line in lines() {
        let of_drive =
            ["src/devices/ag03/drive", "src/client", "src/devices/ag03/profibus", "src/devices/ag03/param"]
                .iter()
                .any(|path| line.is_in(path));
        let of_other = documents(&line.text).any(|name| name == "dp-v0.md");
        let row = numbers_behind(&line.text, " row ").filter(|_| of_drive && !of_other);
        if numbers_behind(&line.text, "C-")
            .any(|number| number.len() == 2 && !rows.contains(&*format!("C-{number}")))
            || row.into_iter().any(|number| !rows.contains(number))
        {
            missing.push(line.shown());
        }
    }
    assert!(missing.is_empty(), "no such row in docs/reference/ag03.md:\n{}", missing.join("\n"));
}

#[test]
fn a_citation_is_found_in_a_line() {
    let line = "//! see `ag03.md` 2.6 and (`dp-v0.md` 7 row 9; C-14), docs/quirks.md";
    assert_eq!(documents(line).collect::<Vec<_>>(), ["ag03.md", "dp-v0.md", "docs/quirks.md"]);
    assert_eq!(sections(line, "ag03.md").collect::<Vec<_>>(), ["2.6"]);
    assert_eq!(sections(line, "dp-v0.md").collect::<Vec<_>>(), ["7"]);
    assert_eq!(numbers_behind(line, " row ").collect::<Vec<_>>(), ["9"]);
    assert_eq!(numbers_behind("in row 25b and C-05", " row ").collect::<Vec<_>>(), ["25b"]);
}

/// The documents named in a line, with the path as it is written.
fn documents(line: &str) -> impl Iterator<Item = &str> {
    line.match_indices(".md").filter_map(|(at, _)| {
        let of_name = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '/' | '.');
        let start = line[..at].rfind(|c| !of_name(c)).map_or(0, |before| before + 1);
        let ends = !line[at + 3..].starts_with(|c: char| c.is_ascii_alphanumeric() || c == '_');
        (ends && start < at).then_some(line[start..at + 3].trim_start_matches('/'))
    })
}

/// The sections of a document that a line cites.
fn sections<'a>(line: &'a str, name: &'a str) -> impl Iterator<Item = &'a str> {
    // Not behind `canopen-`: that is another document.
    let whole = line.match_indices(name).filter(|(at, _)| !line[..*at].ends_with('-'));
    whole.filter_map(move |(at, _)| {
        let behind = line[at + name.len()..].trim_start_matches(['`', ' ']);
        let behind = behind.strip_prefix("sections ").or(behind.strip_prefix("section ")).unwrap_or(behind);
        let end = behind.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(behind.len());
        Some(behind[..end].trim_end_matches('.')).filter(|number| !number.is_empty())
    })
}

/// The numbers, with a letter perhaps, that stand behind these words.
fn numbers_behind<'a>(line: &'a str, words: &'a str) -> impl Iterator<Item = &'a str> {
    line.match_indices(words).filter_map(move |(at, _)| {
        let behind = &line[at + words.len()..];
        let digits = behind.find(|c: char| !c.is_ascii_digit()).unwrap_or(behind.len());
        let end = if behind[digits..].starts_with('b') { digits + 1 } else { digits };
        (digits > 0).then_some(&behind[..end])
    })
}

struct Line {
    file: PathBuf,
    number: usize,
    text: String,
}

impl Line {
    fn shown(&self) -> String {
        format!("{}:{}: {}", self.file.display(), self.number, self.text.trim())
    }

    fn is_in(&self, folder: &str) -> bool {
        self.file.starts_with(root().join(folder))
    }
}

/// Every line of code and tests, but for this file.
fn lines() -> impl Iterator<Item = Line> {
    let mut folders: Vec<PathBuf> =
        ["src", "tests", "examples", "benches"].map(|name| root().join(name)).into();
    let mut found = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|ending| ending == "rs")
                && !path.ends_with("references.rs")
            {
                let text = fs::read_to_string(&path).unwrap();
                found.extend(text.lines().zip(1..).map(|(line, number)| Line {
                    file: path.clone(),
                    number,
                    text: line.into(),
                }));
            }
        }
    }
    found.into_iter()
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}
