//! `profidrive judge compare A.json B.json`.

use std::fs;
use std::path::PathBuf;

use serde_json::{Value, json};
use tempfile::TempDir;

use super::run;

/// A report with a verdict on each of these rows.
fn report(dir: &TempDir, name: &str, slot: &str, rows: &[(&str, &str, f64)]) -> String {
    let row = |(id, verdict, seconds): &(&str, &str, f64)| json!({"id": id, "verdict": verdict, "reason": "why", "seconds": seconds});
    let rows: Vec<Value> = rows.iter().map(row).collect();
    let report = json!({
        "version": 1, "ended": "everything was tried", "status": 1, "program": "profidrive 0.1.0", "seconds": 71.25,
        "date": "2026-11-23T01:16:56Z", "configuration": {"stations": ["5"], "slot": slot}, "rows": rows,
    });
    let path: PathBuf = dir.path().join(name);
    fs::write(&path, report.to_string()).unwrap();
    path.to_str().unwrap().to_owned()
}

#[test]
fn what_changed_is_told_and_new_failures_are_the_status() {
    let dir = TempDir::new().unwrap();
    let rows = |verdicts: [&'static str; 3]| {
        let [one, two, three] = verdicts;
        [("M-C03", one, 1.0), ("M-E01", two, 1.0), ("M-E02", three, 1.0)]
    };
    let before = report(&dir, "a.json", "100", &rows(["pass", "fail", "pass"]));
    for (verdicts, status, words) in [
        (["pass", "fail", "pass"], 0, "M-E01 fails still: why\n"),
        (["pass", "pass", "pass"], 0, "M-E01 no longer fails\n"),
        (["warn", "fail", "pass"], 0, "M-E01 fails still: why\n"),
        (["fail", "pass", "not_judged"], 1, "M-C03 fails, and did not: why\n"),
        (["pass", "pass", "not_judged"], 4, "M-E02 is no longer judged: why\n"),
        (["pass", "not_judged", "pass"], 4, "M-E01 is no longer judged: why\n"),
    ] {
        let after = report(&dir, "b.json", "100", &rows(verdicts));
        let (code, stdout, stderr) = run(&["compare", &before, &after]);
        assert_eq!((code, stderr.as_str()), (Some(status), ""), "{stdout}");
        assert!(stdout.contains(words), "{stdout}");
        assert!(
            stdout.starts_with("before: 2026-11-23T01:16:56Z profidrive 0.1.0, 71.2 s, ended: "),
            "{stdout}"
        );
    }
    let (code, stdout, _) = run(&["compare", &before, &before]);
    assert_eq!(code, Some(0), "{stdout}");
}

#[test]
fn rows_that_are_gone_times_and_the_configuration_are_told() {
    let dir = TempDir::new().unwrap();
    let before = report(
        &dir,
        "a.json",
        "100",
        &[("M-C03", "pass", 1.0), ("M-L02", "pass", 3.0), ("M-R01", "not_judged", 0.0)],
    );
    let after = report(&dir, "b.json", "200", &[("M-L02", "pass", 9.5), ("M-P01", "pass", 0.0)]);
    let (code, stdout, stderr) = run(&["compare", &before, &after]);
    assert_eq!((code, stderr.as_str()), (Some(4), ""), "{stdout}");
    let told: Vec<&str> = stdout.lines().skip(2).collect();
    assert_eq!(
        told,
        [
            "configuration: slot is \"200\", and was \"100\"",
            "M-C03 is no longer judged",
            "M-P01 is judged, and was not",
            "M-L02 takes 9.5 s, and took 3.0 s",
        ]
    );
}

#[test]
fn a_file_that_is_no_report_is_told_in_one_line() {
    let dir = TempDir::new().unwrap();
    let right = report(&dir, "a.json", "100", &[("M-C03", "pass", 1.0)]);
    let wrong = dir.path().join("wrong.json");
    let wrong = wrong.to_str().unwrap();
    let other = fs::read_to_string(&right).unwrap().replace("\"version\":1", "\"version\":2");
    for (text, words) in [
        ("<?xml version=\"1.0\"?>", "no report of a judgement, as `judge --json FILE` writes it: "),
        ("{\"version\":1,\"ended\":\"\"}", "missing field `rows`"),
        (other.as_str(), "a report of version 2; this program reads version 1"),
    ] {
        fs::write(wrong, text).unwrap();
        for files in [[&right, wrong], [wrong, &right]] {
            let (code, stdout, stderr) = run(&["compare", files[0], files[1]]);
            assert_eq!((code, stdout.as_str()), (Some(5), ""), "{stderr}");
            assert!(stderr.contains(words) && stderr.contains(wrong), "{stderr}");
            assert_eq!(stderr.lines().count(), 1, "{stderr}");
        }
    }
    let (code, _, stderr) = run(&["compare", &right, "/nowhere.json"]);
    assert_eq!(code, Some(5), "{stderr}");
    assert!(stderr.contains("/nowhere.json: cannot be read"), "{stderr}");
    let (code, _, stderr) = run(&["compare", &right]);
    assert_eq!(code, Some(2), "{stderr}");
}
