//! `docs/what-it-says.md`: what is said to each way to fail. Each test program has sections of the page and compares them
//! with what it was told; `PROFIDRIVE_REWRITE=1` writes them instead.
#![allow(dead_code, reason = "each test program uses its part")]

use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

/// A way to fail: its number on the page, what is done, and what does it and returns the lines that appear.
pub(crate) type Row<'a> = (&'a str, &'a str, Box<dyn FnOnce() -> Vec<String> + 'a>);

/// Tests of one program run at the same time.
static PAGE: Mutex<()> = Mutex::new(());

/// Does everything in `rows` and compares it with the table of the section with this heading.
pub(crate) fn compare(heading: &str, rows: Vec<Row<'_>>) {
    let mut table = String::from("| id | what was done | what it says |\n| --- | --- | --- |\n");
    for (id, done, act) in rows {
        let said = act();
        assert!(said.iter().any(|line| !line.is_empty()), "{id}, {done}: nothing is said");
        let said: Vec<_> = said.iter().map(|line| line.trim_end().replace('|', "\\|")).collect();
        writeln!(table, "| {id} | {} | {} |", done.replace('|', "\\|"), said.join("<br>")).unwrap();
    }
    let _one_at_a_time = PAGE.lock().unwrap_or_else(PoisonError::into_inner);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/what-it-says.md");
    let page = fs::read_to_string(&path).unwrap();
    let title = format!("\n## {heading}\n");
    let begin =
        page.find(&title).unwrap_or_else(|| panic!("the page has no section {heading}")) + title.len();
    let end = page[begin..].find("\n## ").map_or(page.len(), |end| begin + end);
    if std::env::var_os("PROFIDRIVE_REWRITE").is_some() {
        fs::write(&path, format!("{}\n{table}{}", &page[..begin], &page[end..])).unwrap();
        return;
    }
    let committed = page[begin..end].trim();
    for (said, committed) in table.lines().zip(committed.lines()) {
        assert_eq!(
            said, committed,
            "section {heading} of docs/what-it-says.md; PROFIDRIVE_REWRITE=1 writes it anew"
        );
    }
    assert_eq!(table.trim(), committed, "section {heading}");
}
