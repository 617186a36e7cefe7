//! Masters that pass the token, over a terminal.

use std::path::Path;
use std::time::Duration;

use tempfile::TempDir;

use super::masters::{Running, passed};
use super::start;
use crate::test_master::Settings;

fn in_ring() -> Settings {
    Settings {
        token: true,
        hsa: 12,
        ttr: Some(Duration::from_secs(1)),
        ..Settings::new(&[5, 6], Duration::from_millis(20))
    }
}

fn arguments<'a>(link: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let stations = [
        "--station",
        "5,ident=1234,cfg=2313,prm=0102,groups=01",
        "--station",
        "6,ident=1234,cfg=2313,prm=0102,groups=01",
    ];
    let master = ["--link", link, "--master", "2", "--slot", "20", "--retries", "2", "--hsa", "12"];
    [&stations[..], &master, more].concat()
}

fn link(bus: &Path) -> String {
    format!("pty:{}", bus.display())
}

/// Every row with `PROFIDRIVE_EVERY_ROW`.
#[test]
fn a_master_of_class_2_passes_over_a_terminal() {
    let dir = TempDir::new().unwrap();
    let bus = dir.path().join("bus");
    let rows = ["M-R01", "M-R02", "M-R03", "M-R09", "M-C03", "M-E01", "M-E08"];
    let only = rows.join(",");
    let link = link(&bus);
    let all = std::env::var_os("PROFIDRIVE_EVERY_ROW").is_some();
    let more: &[&str] = if all { &["--class", "2"] } else { &["--class", "2", "--only", &only] };
    let (child, _, stdout) = start(&arguments(&link, more));
    let _master = Running::configured(&bus, Settings { class_2: true, ..in_ring() });
    passed(stdout, child, &rows);
}

/// Every row with `PROFIDRIVE_EVERY_ROW`.
#[test]
fn a_master_in_a_ring_passes_over_a_terminal() {
    let dir = TempDir::new().unwrap();
    let bus = dir.path().join("bus");
    let rows = ["M-R03", "M-R05", "M-R06", "M-R08"];
    let only = rows.join(",");
    let link = link(&bus);
    let all = std::env::var_os("PROFIDRIVE_EVERY_ROW").is_some();
    let more: &[&str] = if all { &["--ttr", "1000"] } else { &["--ttr", "1000", "--only", &only] };
    let (child, _, stdout) = start(&arguments(&link, more));
    let _master = Running::configured(&bus, in_ring());
    passed(stdout, child, &rows);
}
