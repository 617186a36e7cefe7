//! The conformance pages and the tests agree: what they name exists, and what a test claims is in one of them. No two
//! pages have rows with the same letter.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Each page with how many rows it has, and of which list.
const PAGES: &[(&str, usize, &str)] = &[
    ("docs/conformance.md", 117, "dp-v0.md 13"),
    ("docs/dpv1-conformance.md", 92, "dp-v1.md 11"),
    ("docs/canopen-conformance.md", 92, "canopen-link.md 14, canopen-ag03.md 17"),
    ("docs/ap10-conformance.md", 18, "canopen-ap10.md 18"),
    ("docs/asda-a2-conformance.md", 19, "canopen-asda-a2.md 15"),
];

/// A test function and the file that holds it.
type Claim = (String, String);

#[test]
fn every_test_named_in_the_document_exists() {
    let tests: BTreeSet<Claim> = claims().into_iter().map(|(_, claim)| claim).collect();
    let mut named = 0;
    for (id, claim) in
        rows().into_iter().flat_map(|row| row.claims.into_iter().map(move |claim| (row.id.clone(), claim)))
    {
        assert!(tests.contains(&claim), "{id}: there is no test {} in {}", claim.0, claim.1);
        named += 1;
    }
    assert!(named > 80, "the document was read: {named} tests named");
}

#[test]
fn every_row_a_test_claims_names_that_test() {
    let rows = rows();
    for (id, claim) in claims() {
        let row = rows.iter().find(|row| row.id == id);
        let row = row.unwrap_or_else(|| panic!("{} claims {id}, which is no row", claim.0));
        assert!(row.claims.contains(&claim), "{id} does not name {} in {}", claim.0, claim.1);
    }
}

#[test]
fn every_row_says_how_it_stands() {
    for (page, count, list) in PAGES {
        assert_eq!(rows_of(page).len(), *count, "rows of {list}");
    }
    for row in rows() {
        let says_why =
            ["not yet", "cannot apply", "`tests/line/interop", "`tests/interop/", "`tests/canopen/"]
                .iter()
                .any(|word| row.shown.starts_with(word));
        assert!(!row.claims.is_empty() || says_why, "{}: {:?}", row.id, row.shown);
    }
}

struct Row {
    id: String,
    shown: String,
    claims: Vec<Claim>,
}

fn rows() -> Vec<Row> {
    PAGES.iter().flat_map(|(page, ..)| rows_of(page)).collect()
}

#[test]
fn each_row_is_in_one_place() {
    let mut seen = BTreeSet::new();
    for row in rows() {
        assert!(seen.insert(row.id.clone()), "{} stands twice", row.id);
    }
}

fn rows_of(page: &str) -> Vec<Row> {
    let text = fs::read_to_string(root().join(page)).expect("the page is there");
    let rows = text.lines().filter_map(|line| {
        let cells: Vec<_> = line.trim_matches('|').split(" | ").map(str::trim).collect();
        let (&id, &shown) = (cells.first()?, cells.last()?);
        let is_id = matches!(
            id.as_bytes(),
            [b'A'..=b'Z', b'-', b'0'..=b'9', b'0'..=b'9']
                | [b'A'..=b'Z', b'A'..=b'Z', b'-', b'0'..=b'9', b'0'..=b'9']
                | [b'V', b'1', b'-', b'R', b'0'..=b'9', b'0'..=b'9']
        );
        is_id.then(|| Row { id: id.to_owned(), shown: shown.to_owned(), claims: named(shown) })
    });
    rows.collect()
}

/// The tests of a cell like "`name` in `file`<br>`name` in `file`".
fn named(cell: &str) -> Vec<Claim> {
    let claims = cell.split("<br>").filter_map(|part| {
        let (name, file) = part.split_once("` in `")?;
        Some((name.trim_start_matches('`').to_owned(), file.trim_end_matches('`').to_owned()))
    });
    claims.collect()
}

/// Every row a test claims by the beginning of its name, as in `fn f_01_f_02_what_it_shows`.
fn claims() -> Vec<(String, Claim)> {
    let mut claims = Vec::new();
    let mut folders = vec![root().join("src"), root().join("tests")];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).expect("the folder is there").flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            if path.extension().is_none_or(|extension| extension != "rs") {
                continue;
            }
            let file = path.strip_prefix(root()).expect("below the root").display().to_string();
            for line in fs::read_to_string(&path).expect("a source file is text").lines() {
                let Some(rest) = line.trim_start().strip_prefix("fn ") else { continue };
                let Some((name, _)) = rest.split_once('(') else { continue };
                claims.extend(ids(name).map(|id| (id, (name.to_owned(), file.clone()))));
            }
        }
    }
    claims
}

fn ids(name: &str) -> impl Iterator<Item = String> {
    let parts: Vec<&str> = name.split('_').collect();
    let pairs: Vec<String> = parts
        .chunks(2)
        .map_while(|pair| match pair {
            ["v1", row] if row.len() == 3 && row.starts_with('r') => {
                Some(format!("V1-{}", row.to_uppercase()))
            }
            [letters, number]
                if matches!(letters.len(), 1 | 2) && number.len() == 2 && number.parse::<u8>().is_ok() =>
            {
                Some(format!("{}-{number}", letters.to_uppercase()))
            }
            _ => None,
        })
        .collect();
    pairs.into_iter()
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).to_path_buf()
}
