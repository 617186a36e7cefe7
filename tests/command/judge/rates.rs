//! A master that is configured for one rate after the other, over a terminal.

use std::fs;
use std::io::Read as _;
use std::path::Path;
use std::thread;
use std::time::Duration;

use profidrive::time::BaudRate;
use tempfile::TempDir;

use super::masters::Running;
use super::start;
use crate::process::end_of;
use crate::test_master::Settings;
use crate::test_master::mistakes::Mistake;

/// Asks with the file `rate` in its folder, which is gone when the master runs at that rate.
const ASK: &str =
    "test $1 = rate || exit 1; echo $2 > $0.new; mv $0.new $0; while [ -e $0 ]; do sleep 0.02; done";

/// The exit status and the table; `mistake` is made at 12 Mbit/s.
fn judged(mistake: Option<Mistake>) -> (Option<i32>, String, Vec<u32>) {
    let dir = TempDir::new().unwrap();
    let (bus, rate) = (dir.path().join("bus"), dir.path().join("rate"));
    let (link, ask) = (format!("pty:{}", bus.display()), format!("sh -c '{ASK}' {}", rate.display()));
    let arguments = [
        "--link",
        &link,
        "--station",
        "5,ident=1234,cfg=2313,prm=0102,groups=01",
        "--slot",
        "20",
        "--retries",
        "2",
        "--baud",
        "500000,12000000",
        "--ask",
        &ask,
        "--only",
        "M-B*,M-C03,M-F02",
    ];
    let (mut child, ready, mut stdout) = start(&arguments);
    assert!(ready.starts_with("ready "), "{ready}");
    let (mut masters, mut rates) = (None, Vec::new());
    while child.try_wait().unwrap().is_none() {
        if let Some(asked) = asked(&rate) {
            drop(masters.take());
            let baud = BaudRate::from_bits_per_second(asked).unwrap();
            let settings = Settings { baud, ..Settings::new(&[5], Duration::from_millis(20)) };
            masters = Some(Running::mistaken(&bus, settings, mistake));
            rates.push(asked);
            fs::remove_file(&rate).unwrap();
        }
        thread::sleep(Duration::from_millis(5));
    }
    let mut table = String::new();
    stdout.read_to_string(&mut table).unwrap();
    child.stderr.take().unwrap().read_to_string(&mut table).unwrap();
    (end_of(&mut child).code(), table, rates)
}

fn asked(file: &Path) -> Option<u32> {
    fs::read_to_string(file).ok()?.trim().parse().ok()
}

#[test]
fn a_master_is_judged_at_one_rate_after_the_other() {
    let (code, table, rates) = judged(None);
    assert_eq!((code, rates), (Some(0), vec![500_000, 12_000_000]), "{table}");
    for line in ["pass       M-B01", "pass       M-B03", "not_judged M-B02", "pass       M-C03"] {
        assert!(table.contains(line), "{line}: {table}");
    }
}

#[test]
fn a_watchdog_time_that_follows_the_rate_fails() {
    let (code, table, _) = judged(Some(Mistake::WatchdogOfTop));
    assert_eq!(code, Some(1), "{table}");
    assert!(table.contains("FAIL M-B03") && !table.contains("FAIL M-B01"), "{table}");
    assert!(table.contains("the watchdog time is"), "{table}");
}
