//! Whole judgements of a correct master, over each link, operated, with scenarios of the user, and again from the capture.

use core::sync::atomic::{AtomicBool, Ordering};
use std::fs;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout};
use std::sync::Arc;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use profidrive::host::link::pty::Pty;
use profidrive::host::link::tcp::Connection;
use profidrive::host::link::terminal::Terminal;
use profidrive::host::{Link, Stop};
use profidrive::time::BaudRate;
use tempfile::TempDir;

use crate::process::end_of;

use super::{run, start};
use crate::test_master::mistakes::Mistake;
use crate::test_master::{Settings, TestMaster, serve};

/// Two stations as the test master has them, and what it is configured to.
const STATIONS: &[&str] = &[
    "--station",
    "5,ident=1234,cfg=2313,prm=0102,groups=01",
    "--station",
    "6,ident=1234,cfg=2313,prm=0102,groups=01",
    "--master",
    "2",
    "--slot",
    "100",
    "--retries",
    "2",
    "--watchdog",
    "1000",
];

/// The test master on a thread of its own, until it is dropped.
pub(super) struct Running {
    end: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Running {
    /// `actions`: a folder in which a file `action` says what the user asks for. It is gone when that is done.
    fn start(link: Box<dyn Link + Send>, actions: Option<PathBuf>) -> Self {
        Self::of_stations(&[5, 6], link, actions)
    }

    fn of_stations(stations: &[u8], link: Box<dyn Link + Send>, actions: Option<PathBuf>) -> Self {
        Self::with(Settings::new(stations, Duration::from_millis(100)), link, actions)
    }

    /// On a terminal, with a mistake or without.
    pub(super) fn mistaken(path: &Path, settings: Settings, mistake: Option<Mistake>) -> Self {
        let link = Box::new(Terminal::open(path, BaudRate::K500).unwrap());
        Self::of(TestMaster::new(settings, mistake), link, None)
    }

    fn with(settings: Settings, link: Box<dyn Link + Send>, actions: Option<PathBuf>) -> Self {
        Self::of(TestMaster::new(settings, None), link, actions)
    }

    fn of(master: TestMaster, mut link: Box<dyn Link + Send>, actions: Option<PathBuf>) -> Self {
        let end = Arc::new(AtomicBool::new(false));
        let ends = Arc::clone(&end);
        let thread = thread::spawn(move || {
            serve(master, &mut *link, &ends, |master, now| {
                let Some(file) = actions.as_ref().map(|folder| folder.join("action")) else { return };
                if let Ok(action) = fs::read_to_string(&file)
                    && action.ends_with('\n')
                {
                    assert!(master.do_action(action.trim_end(), now), "{action}");
                    fs::remove_file(file).unwrap();
                }
            });
        });
        Self { end, thread: Some(thread) }
    }

    pub(super) fn on_terminal_with(path: &Path, stations: &[u8]) -> Self {
        Self::of_stations(stations, Box::new(Terminal::open(path, BaudRate::K500).unwrap()), None)
    }

    pub(super) fn configured(path: &Path, settings: Settings) -> Self {
        Self::with(settings, Box::new(Terminal::open(path, BaudRate::K500).unwrap()), None)
    }

    fn on_terminal(path: &Path, actions: Option<PathBuf>) -> Self {
        Self::start(Box::new(Terminal::open(path, BaudRate::K500).unwrap()), actions)
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.end.store(true, Ordering::Relaxed);
        let ended = self.thread.take().map(JoinHandle::join);
        assert!(thread::panicking() || ended.is_some_and(|ended| ended.is_ok()));
    }
}

/// What the judge says of a master that is right, to the end. Returns its log.
pub(super) fn passed(mut stdout: BufReader<ChildStdout>, mut child: Child, passes: &[&str]) -> String {
    let mut table = String::new();
    stdout.read_to_string(&mut table).unwrap();
    let mut log = String::new();
    child.stderr.take().unwrap().read_to_string(&mut log).unwrap();
    assert_eq!(end_of(&mut child).code(), Some(0), "{table}{log}");
    for row in passes {
        assert!(table.contains(&format!("  pass       {row}")), "{row}: {table}{log}");
    }
    assert!(table.contains(" 0 failed, 0 warnings"), "{table}");
    assert!(table.ends_with("ended: everything was tried\n"), "{table}");
    log
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

#[test]
fn a_correct_master_passes_a_scenario_of_the_user_and_so_does_the_capture() {
    let dir = TempDir::new().unwrap();
    let (bus, capture, scenarios) =
        (dir.path().join("bus"), dir.path().join("c.pcapng"), dir.path().join("s.toml"));
    let late = "[[scenario]]\nname = \"Chk_Cfg late\"\nstation = 6\nfirst = \"power-on\"\n\
        faults = [\"late=1.5slot,station=S,service=Chk_Cfg,count=1\"]\nrows = [\"M-C03\"]\nreturns = [\"M-L02\"]\n";
    fs::write(&scenarios, late).unwrap();
    let (link, rows) = (format!("pty:{}", text(&bus)), ["--only", "M-L02,M-F*"]);
    let more = ["--link", &link, "--capture", text(&capture), "--scenarios", text(&scenarios)];
    // The scenario of the user is for M-C03, which is not judged; M-L02 is what it must return to.
    let (child, ready, stdout) = start(&[STATIONS, &more, &rows].concat());
    assert!(ready.starts_with("ready link="), "{ready}");
    let master = Running::on_terminal(&bus, None);
    let log = passed(stdout, child, &["M-L02", "M-F02"]);
    assert!(log.contains("Chk_Cfg late"), "{log}");
    drop(master);
    let (code, table, stderr) = run(&[STATIONS, &[text(&capture)]].concat());
    assert_eq!(code, Some(0), "{table}{stderr}");
    for row in ["M-F02", "M-C02", "M-U01", "M-P08", "M-G01", "M-X01"] {
        assert!(table.contains(&format!("  pass       {row}")), "{row}: {table}");
    }
    // Nothing but the capture is known.
    let (code, table, stderr) = run(&[text(&capture)]);
    assert_eq!(code, Some(0), "{table}{stderr}");
    assert!(table.contains("  pass       M-C02"), "{table}");
}

#[test]
fn a_scenario_for_a_station_that_is_not_there_is_refused() {
    let dir = TempDir::new().unwrap();
    let file = dir.path().join("s.toml");
    for (scenario, words) in [
        (
            "station = 16\nfirst = \"power-on\"",
            "station 16 is not one of those that are present: 5, 6; did you mean 6?",
        ),
        (
            "faults = [\"no-reply,station=7\"]",
            "station 7 is not one of those that are present: 5, 6; did you mean 6?",
        ),
        ("faults = [\"no-rply\"]", "no-rply"),
        ("rows = [\"M-Q1\"]", "'M-Q1' is no row"),
    ] {
        fs::write(&file, format!("[[scenario]]\nname = \"mine\"\n{scenario}\n")).unwrap();
        let (code, stdout, stderr) = run(&[STATIONS, &["--scenarios", text(&file)]].concat());
        assert_eq!((code, stdout.as_str()), (Some(2), ""), "{scenario}: {stderr}");
        assert!(stderr.contains("mine: ") && stderr.contains(words), "{stderr}");
        assert_eq!(stderr.lines().count(), 1, "{stderr}");
    }
}

#[test]
fn a_master_that_is_operated_passes() {
    let dir = TempDir::new().unwrap();
    let (bus, script) = (dir.path().join("bus"), dir.path().join("ask.sh"));
    let wait = "echo \"$@\" > new; mv new action; while [ -e action ]; do sleep 0.02; done";
    fs::write(&script, format!("cd {}\n{wait}\n", text(dir.path()))).unwrap();
    let (link, ask) = (format!("pty:{}", text(&bus)), format!("sh {}", text(&script)));
    let more = ["--link", &link, "--ask", &ask, "--only", "M-O02,M-O03,M-O10,M-X04,M-Z01,M-Z02,M-Z04"];
    let (child, _, stdout) = start(&[STATIONS, &more].concat());
    let _master = Running::on_terminal(&bus, Some(dir.path().into()));
    passed(stdout, child, &["M-O02", "M-O03", "M-O10", "M-X04", "M-Z01", "M-Z02", "M-Z04"]);
}

#[test]
fn a_master_that_cannot_be_operated_is_not_accused() {
    let dir = TempDir::new().unwrap();
    let bus = dir.path().join("bus");
    let link = format!("pty:{}", text(&bus));
    let (mut child, _, mut stdout) =
        start(&[STATIONS, &["--link", &link, "--ask", "false", "--only", "M-O02,M-Z02"]].concat());
    let _master = Running::on_terminal(&bus, None);
    let mut table = String::new();
    stdout.read_to_string(&mut table).unwrap();
    assert_eq!(end_of(&mut child).code(), Some(4), "{table}");
    assert!(table.contains("no row was judged"), "{table}");
    assert!(table.contains("the command of --ask failed: clear"), "{table}");
    assert!(table.contains("the command of --ask failed: stop"), "{table}");
}

/// Every row with `PROFIDRIVE_EVERY_ROW`.
#[test]
fn a_correct_master_with_an_absent_station_passes_over_a_terminal() {
    let dir = TempDir::new().unwrap();
    let bus = dir.path().join("bus");
    let link = format!("pty:{}", text(&bus));
    let more = ["--station", "9,ident=1234,cfg=2313,absent", "--link", &link];
    let all = std::env::var_os("PROFIDRIVE_EVERY_ROW").is_some();
    let rows: &[&str] = if all { &[] } else { &["--only", "M-C10,M-I03,M-T02,M-T03,M-E05"] };
    let (child, _, stdout) = start(&[STATIONS, &more, rows].concat());
    let begin = Instant::now();
    let terminal = Terminal::open(&bus, BaudRate::K500).unwrap();
    let _master = Running::of_stations(&[5, 6, 9], Box::new(terminal), None);
    let log = passed(stdout, child, &["M-C10", "M-I03", "M-T02", "M-T03", "M-E05"]);
    let took = begin.elapsed();
    // The first forecast is from before a cycle was seen.
    let (_, left) = log.split_once(" 2 of ").and_then(|(_, rest)| rest.split_once(", about ")).unwrap();
    let left: f64 = left.split(' ').next().unwrap().parse().unwrap();
    println!("{} s, about {left} s left at the second scenario", took.as_secs());
    // Every row takes 230 s: a cycle waits 100 ms for the absent station.
    assert!(took < Duration::from_secs(300), "{took:?}");
    assert!(!all || (left > took.as_secs_f64() / 1.5 && left < took.as_secs_f64() * 1.5), "{left} s said");
}

/// Every row of a master with a cycle of 2 ms, with `PROFIDRIVE_LONG`: at most 90 s.
#[test]
fn every_row_over_a_terminal_takes_at_most_ninety_seconds() {
    let dir = TempDir::new().unwrap();
    let (bus, json) = (dir.path().join("bus"), dir.path().join("v.json"));
    let link = format!("pty:{}", text(&bus));
    let all = std::env::var_os("PROFIDRIVE_LONG").is_some();
    let rows: &[&str] = if all { &[] } else { &["--only", "M-C03,M-E01"] };
    let (child, _, stdout) = start(&[STATIONS, &["--link", &link, "--json", text(&json)], rows].concat());
    let _master = Running::on_terminal(&bus, None);
    let log = passed(stdout, child, &["M-C03", "M-E01"]);
    let report: serde_json::Value = serde_json::from_str(&fs::read_to_string(&json).unwrap()).unwrap();
    let took = report["seconds"].as_f64().unwrap();
    println!("{took} s, {}", report["figures"]);
    assert!(took < 90.0, "{took} s");
    // What is said of the rest at the beginning is about right.
    let (_, left) = log.split_once(", about ").unwrap();
    let left: f64 = left.split(' ').next().unwrap().parse().unwrap();
    println!("about {left} s left at the first scenario");
    assert!(!all || (left > took / 2.0 && left < took * 2.0), "{left} s said, {took} s taken");
}

#[test]
fn a_soak_repeats_scenarios_and_reports_figures() {
    let dir = TempDir::new().unwrap();
    let (bus, json) = (dir.path().join("bus"), dir.path().join("v.json"));
    let link = format!("pty:{}", text(&bus));
    let soak = ["--soak", "4s", "--seed", "9", "--only", "M-C03,M-E01", "--json", text(&json)];
    let (child, _, stdout) = start(&[STATIONS, &["--link", &link], &soak].concat());
    let _master = Running::on_terminal(&bus, None);
    let log = passed(stdout, child, &["M-C03", "M-E01"]);
    assert!(log.contains("again, about "), "{log}");
    let report: serde_json::Value = serde_json::from_str(&fs::read_to_string(&json).unwrap()).unwrap();
    let figures = &report["figures"];
    assert!(figures["cycles"].as_u64() > Some(10) && figures["retries"].as_u64() > Some(2), "{figures}");
    assert_eq!(
        (&report["configuration"]["soak"], &report["configuration"]["seed"]),
        (&"4s".into(), &"9".into())
    );
    for (arguments, words) in [
        (&["--soak", "4"][..], "'4' is no such time; expected for example 90s, 10min or 8h"),
        (&["--soak", "0s"], "'0s' is no such time"),
        (&["--soak", "9h", "--time", "5"], "cannot be used with"),
        (&["--seed", "5"], "--soak"),
    ] {
        let (code, _, stderr) = run(&[STATIONS, arguments].concat());
        assert_eq!(code, Some(2), "{stderr}");
        assert!(stderr.contains(words), "{stderr}");
    }
}

#[test]
fn a_correct_master_passes_over_tcp() {
    let (child, ready, stdout) =
        start(&[STATIONS, &["--link", "tcp:127.0.0.1:0", "--only", "M-C03,M-E01"]].concat());
    let place = ready.strip_prefix("ready link=").and_then(|rest| rest.split(' ').next()).unwrap();
    let place = place.strip_prefix("tcp:").unwrap_or(place);
    let _master = Running::start(Box::new(Connection::open(place).unwrap()), None);
    passed(stdout, child, &["M-C03", "M-E01"]);
}

#[test]
fn a_correct_master_passes_over_a_serial_line() {
    let mut line = Pty::open(None).unwrap();
    line.follow_rate(false);
    let device = format!("serial:{}", line.path().display());
    let (child, ready, stdout) =
        start(&[STATIONS, &["--link", &device, "--baud", "500000", "--only", "M-C03,M-E01"]].concat());
    assert!(ready.starts_with("ready link="), "{ready}");
    let _master = Running::start(Box::new(line), None);
    passed(stdout, child, &["M-C03", "M-E01"]);
}

#[test]
fn noise_ends_the_judgement_with_3_and_a_clear_word() {
    let dir = TempDir::new().unwrap();
    let bus = dir.path().join("bus");
    let link = format!("pty:{}", text(&bus));
    let (mut child, _, mut stdout) = start(&["--link", &link, "--station", "5,ident=1234,cfg=2313"]);
    let mut link = Terminal::open(&bus, BaudRate::K500).unwrap();
    let stop = Stop::new().unwrap();
    let mut table = String::new();
    let noise: Vec<u8> = (0..200_u32).map(|at| (at.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    while child.try_wait().unwrap().is_none() {
        let _ = link.send(&noise);
        let _ = link.wait(Some(Duration::from_millis(2)), &stop);
    }
    stdout.read_to_string(&mut table).unwrap();
    let mut stderr = String::new();
    child.stderr.take().unwrap().read_to_string(&mut stderr).unwrap();
    assert_eq!(end_of(&mut child).code(), Some(3), "{table}{stderr}");
    assert!(stderr.contains("only octets that are no telegrams were heard"), "{stderr}");
    assert!(table.contains("0 passed, 0 failed, 0 warnings"), "{table}");
}
