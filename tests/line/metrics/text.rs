//! The text that Prometheus reads, taken apart by its rules.

use std::collections::{BTreeMap, BTreeSet};

/// A metric as its text says it.
#[derive(Debug, Default)]
pub(super) struct Told {
    pub(super) kind: String,
    pub(super) help: String,
    pub(super) unit: Option<String>,
    /// Every label with its values.
    pub(super) labels: BTreeMap<String, BTreeSet<String>>,
    /// What its series are called.
    pub(super) names: BTreeSet<String>,
}

/// The families of a text in their order. What is against the rules fails.
pub(super) fn families(text: &str) -> Vec<(String, Told)> {
    let body = text.strip_suffix("# EOF\n").expect("the end");
    let mut families: Vec<(String, Told)> = Vec::new();
    for line in body.lines() {
        if let Some(meta) = line.strip_prefix("# ") {
            let mut words = meta.splitn(3, ' ');
            let (what, name, rest) =
                (words.next().unwrap(), words.next().unwrap(), words.next().unwrap().to_owned());
            if families.last().is_none_or(|(last, _)| last != name) {
                assert!(families.iter().all(|(other, _)| other != name), "{name} twice");
                families.push((name.to_owned(), Told::default()));
            }
            let (_, told) = families.last_mut().unwrap();
            match what {
                "HELP" => told.help = rest,
                "TYPE" => told.kind = rest,
                "UNIT" => {
                    assert!(name.ends_with(&format!("_{rest}")), "{name} is not in {rest}");
                    told.unit = Some(rest);
                }
                other => panic!("{other}: {line}"),
            }
        } else {
            let (family, told) = families.last_mut().unwrap();
            let (series, _) = line.rsplit_once(' ').unwrap();
            let (name, labels) = series.split_once('{').unwrap_or((series, "}"));
            let suffixes: &[&str] = match told.kind.as_str() {
                "counter" => &["_total"],
                "gauge" => &[""],
                "info" => &["_info"],
                "histogram" => &["_bucket", "_sum", "_count"],
                other => panic!("{other}"),
            };
            assert!(suffixes.iter().any(|suffix| format!("{family}{suffix}") == name), "{line}");
            told.names.insert(name.to_owned());
            for (label, value) in pairs(labels) {
                told.labels.entry(label).or_default().insert(value);
            }
        }
    }
    families
}

/// The labels behind `{`, without what escapes their values.
fn pairs(text: &str) -> Vec<(String, String)> {
    let mut pairs = Vec::new();
    let mut rest = text;
    while let Some((label, value)) = rest.split_once("=\"") {
        let (mut plain, mut letters) = (String::new(), value.char_indices());
        let end = loop {
            match letters.next().expect("a quote") {
                (at, '"') => break at,
                (_, '\\') => plain.push(match letters.next().unwrap().1 {
                    'n' => '\n',
                    same @ ('"' | '\\') => same,
                    other => panic!("\\{other}"),
                }),
                (_, letter) => plain.push(letter),
            }
        };
        pairs.push((label.trim_start_matches(',').to_owned(), plain));
        rest = &value[end + 1..];
    }
    assert_eq!(rest, "}", "{text}");
    pairs
}

/// Every series with its value; none twice.
pub(super) fn series(text: &str) -> BTreeMap<String, f64> {
    let mut series = BTreeMap::new();
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let (name, value) = line.rsplit_once(' ').unwrap();
        assert!(series.insert(name.to_owned(), value.parse().unwrap()).is_none(), "{name} twice");
    }
    series
}

/// Whether it only grows.
pub(super) fn is_counter(series: &str) -> bool {
    let name = series.split('{').next().unwrap();
    ["_total", "_bucket", "_sum", "_count"].iter().any(|suffix| name.ends_with(suffix))
}
