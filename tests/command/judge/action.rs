//! What the steps of action.yml run, with a release in a folder and the test master.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::thread;
use std::time::Duration;

use tempfile::TempDir;

use super::masters::Running;

const ACTION: &str = include_str!("../../../action.yml");
const VERSION: &str = "0.1.0";

/// The shell parts, in their order.
fn steps() -> Vec<String> {
    let mut parts: Vec<String> = Vec::new();
    for part in ACTION.split("      run: |\n").skip(1) {
        let lines = part.lines().map_while(|line| line.strip_prefix("        "));
        parts.push(lines.map(|line| format!("{line}\n")).collect());
    }
    parts
}

/// The place of a job: its folders, and a release that the program is taken from.
struct Job(TempDir);

impl Job {
    fn new() -> Self {
        let job = Self(TempDir::new().unwrap());
        let machine = Command::new("uname").arg("-m").output().unwrap();
        let machine = String::from_utf8(machine.stdout).unwrap();
        let name = format!("profidrive-{VERSION}-{}-unknown-linux-gnu", machine.trim());
        let release = job.path(&format!("owner/profidrive/releases/download/v{VERSION}"));
        let folder = release.join(&name);
        fs::create_dir_all(&folder).unwrap();
        let program = folder.join("profidrive");
        fs::write(&program, format!("#!/bin/sh\nexec {} \"$@\"\n", env!("CARGO_BIN_EXE_profidrive")))
            .unwrap();
        fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
        let pack = format!("tar -czf {name}.tgz {name} && sha256sum {name}.tgz >SHA256SUMS && rm -r {name}");
        assert!(Command::new("sh").args(["-c", &pack]).current_dir(release).status().unwrap().success());
        fs::create_dir(job.path("work")).unwrap();
        for file in ["path", "output", "summary"] {
            fs::write(job.path(file), "").unwrap();
        }
        job
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn text(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    /// Runs a step as a runner does, `PATH` and outputs of those before included.
    fn run(&self, step: &str, only: &str) -> Output {
        self.run_with(step, only, &[])
    }

    /// The same with other inputs.
    fn run_with(&self, step: &str, only: &str, inputs: &[(&str, &str)]) -> Output {
        let path = self.text("path");
        let path = format!("{}:{}", path.trim(), std::env::var("PATH").unwrap());
        let status = self.text("output").trim().trim_start_matches("status=").to_owned();
        let mut command = Command::new("bash");
        command.args(["--noprofile", "--norc", "-eo", "pipefail", "-c", step]).current_dir(self.path("work"));
        command
            .env("PATH", path)
            .env("RUNNER_TEMP", self.0.path())
            .env("STATUS", status)
            .env_remove("RUST_LOG");
        command.env("GITHUB_SERVER_URL", format!("file://{}", self.0.path().display()));
        for (name, file) in
            [("GITHUB_PATH", "path"), ("GITHUB_OUTPUT", "output"), ("GITHUB_STEP_SUMMARY", "summary")]
        {
            command.env(name, self.path(file));
        }
        for (name, value) in [
            ("VERSION", VERSION),
            ("RELEASED_BY", "owner/profidrive"),
            ("MASTER", "touch \"$RUNNER_TEMP/started\"; sleep 600"),
            ("STATIONS", "5,ident=1234,cfg=2313,prm=0102,groups=01\n"),
            ("DEVICE", ""),
            ("SLAVE", ""),
            ("NODE", ""),
            ("OPTIONS", &format!("--slot 100 --retries 2 --only {only}")),
            ("REPORT", "reports"),
        ] {
            assert!(ACTION.contains(&format!("{name}: ${{{{ ")), "{name}");
            command.env(name, value);
        }
        command.envs(inputs.iter().copied());
        command.output().unwrap()
    }
}

/// The test master at the terminal that the command of the user would open.
fn master(started: &Path, link: &Path) -> Running {
    while !started.exists() {
        thread::sleep(Duration::from_millis(20));
    }
    Running::on_terminal_with(link, &[5])
}

/// The status of the last step, and the summary.
fn judged(only: &str) -> (Option<i32>, String, Job) {
    let job = Job::new();
    let steps = steps();
    assert_eq!(steps.len(), 4);
    let fetched = job.run(&steps[0], only);
    assert!(fetched.status.success(), "{fetched:?}");
    let (started, link) = (job.path("started"), job.path("profibus"));
    let beside = thread::spawn(move || master(&started, &link));
    let judged = job.run(&steps[1], only);
    assert!(judged.status.success(), "{judged:?}");
    drop(beside.join().unwrap());
    let summed = job.run(&steps[2], only);
    assert!(summed.status.success(), "{summed:?}");
    let status = job.run(&steps[3], only).status.code();
    (status, job.text("summary"), job)
}

#[test]
fn the_steps_judge_a_master_and_sum_it_up() {
    let (status, summary, job) = judged("M-C03,M-F02");
    assert_eq!(status, Some(0), "{summary}");
    assert!(summary.contains("\n2 passed, 0 failed, 0 warnings, 0 not judged"), "{summary}");
    assert!(summary.contains("\n| M-C03 | pass | a retry keeps the FCB |\n"), "{summary}");
    for report in ["judgement.json", "judgement.xml", "judgement.html", "table.txt", "master.log"] {
        assert!(job.path("work/reports").join(report).exists(), "{report}");
    }
}

/// A device: the inputs, the rows, and what the summary says.
fn device(inputs: &[(&str, &str)], rows: &str, subject: &str) {
    let job = Job::new();
    let options = format!("--only {rows} --slot 100");
    let inputs = [&[("MASTER", ""), ("STATIONS", ""), ("OPTIONS", &options)], inputs].concat();
    for step in &steps()[..3] {
        let done = job.run_with(step, rows, &inputs);
        assert!(done.status.success(), "{done:?}");
    }
    let (summary, status) = (job.text("summary"), job.run(&steps()[3], rows).status.code());
    assert_eq!(status, Some(0), "{summary}");
    assert!(summary.starts_with(&format!("### Judgement of the {subject}\n")), "{summary}");
    assert!(summary.contains(" passed, 0 failed, 0 warnings, 0 not judged"), "{summary}");
    assert!(summary.contains("| pass |"), "{summary}");
    assert!(job.path("work/reports/device.log").exists());
}

#[test]
fn the_steps_judge_a_slave() {
    let start = "exec profidrive emulate --quiet --drive 5 --link serial:$LINK --baud 500000";
    device(&[("DEVICE", start), ("SLAVE", "5")], "S-P01,S-G01,S-X01", "PROFIBUS-DP slave 5");
}

#[test]
fn the_steps_judge_a_node() {
    let eds = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/eds/complete.eds");
    let start = format!("exec profidrive emulate --quiet --node 5,eds={eds} --link slcan-tty:$LINK");
    let node = format!("5,eds={eds}");
    let job = Job::new();
    let inputs =
        [("MASTER", ""), ("STATIONS", ""), ("OPTIONS", "--only N-B01"), ("DEVICE", &start), ("NODE", &node)];
    for step in &steps()[..3] {
        let done = job.run_with(step, "N-B01", &inputs);
        assert!(done.status.success(), "{done:?}");
    }
    let summary = job.text("summary");
    assert!(summary.starts_with("### Judgement of the CANopen node 5\n"), "{summary}");
    assert!(summary.contains("| N-B01 |"), "{summary}");
}

#[test]
fn the_last_step_ends_with_the_status_of_the_judgement() {
    let (status, summary, _job) = judged("M-K01,M-F02,M-K02");
    // It passes no token: of the group of the token nothing can be judged.
    assert_eq!(status, Some(0), "{summary}");
    assert!(summary.contains("| M-K01 | not_judged |"), "{summary}");
    let job = Job::new();
    assert!(job.run(&steps()[0], "M-F02").status.success());
    // No station of that form: the command line is wrong, and no master is waited for.
    let wrong = job.run(&steps()[1], "M-Q01");
    assert!(wrong.status.success(), "{wrong:?}");
    assert_eq!(job.run(&steps()[3], "M-Q01").status.code(), Some(2));
}

#[test]
fn an_archive_that_is_not_the_released_one_is_refused() {
    let job = Job::new();
    let sums = job.path(&format!("owner/profidrive/releases/download/v{VERSION}/SHA256SUMS"));
    let right = fs::read_to_string(&sums).unwrap();
    let first = if right.starts_with('0') { '1' } else { '0' };
    fs::write(&sums, format!("{first}{}", &right[1..])).unwrap();
    assert!(!job.run(&steps()[0], "M-F02").status.success());
    assert_eq!(job.text("path"), "");
}
