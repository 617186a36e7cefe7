//! Lines of 32 stations and of as many as there are addresses, over a terminal.

use std::time::Duration;

use tempfile::TempDir;

use super::masters::{Running, passed};
use super::start;
use crate::test_master::Settings;

/// The rows of `few`; with `PROFIDRIVE_EVERY_ROW` those of `many`, all of them if there are none.
fn judged(stations: &[u8], few: &[&str], many: &[&str]) {
    let dir = TempDir::new().unwrap();
    let bus = dir.path().join("bus");
    let link = format!("pty:{}", bus.display());
    let specs: Vec<String> =
        stations.iter().map(|number| format!("{number},ident=1234,cfg=2313,prm=0102,groups=01")).collect();
    let mut arguments = vec!["--link", &link, "--master", "2", "--slot", "100", "--retries", "2"];
    arguments.extend(["--watchdog", "6000"]);
    arguments.extend(specs.iter().flat_map(|spec| ["--station", spec]));
    let all = std::env::var_os("PROFIDRIVE_EVERY_ROW").is_some();
    let rows = if all { many } else { few }.join(",");
    if !rows.is_empty() {
        arguments.extend(["--only", &rows]);
    }
    let (child, ready, stdout) = start(&arguments);
    let listed: Vec<String> = stations.iter().map(ToString::to_string).collect();
    assert!(ready.ends_with(&format!(" stations={}\n", listed.join(","))), "{ready}");
    // A busy machine may take two seconds for a cycle.
    let watchdog = Duration::from_secs(6);
    let settings = Settings { watchdog, ..Settings::new(stations, Duration::from_millis(100)) };
    let _master = Running::configured(&bus, settings);
    passed(stdout, child, few);
}

/// 32 stations: a row of each group; with `PROFIDRIVE_EVERY_ROW` every row. 125 stations: some rows that need not be watched for
/// long; with `PROFIDRIVE_EVERY_ROW` those of the groups C, X, I and T.
#[test]
fn masters_of_32_and_of_125_stations_pass_over_terminals() {
    let of_each_group = [
        "M-F02", "M-T02", "M-C03", "M-U08", "M-P08", "M-G01", "M-X03", "M-D05", "M-O04", "M-L03", "M-E01",
        "M-I06",
    ];
    let (some, all): (Vec<u8>, Vec<u8>) =
        ((10..42).collect(), (0..=125).filter(|number| *number != 2).collect());
    // At the same time: most of it is waiting.
    std::thread::scope(|scope| {
        scope.spawn(|| judged(&some, &of_each_group, &[]));
        scope.spawn(|| judged(&all, &["M-C03", "M-T02", "M-I05"], &["M-C*", "M-X*", "M-I*", "M-T*"]));
    });
}
