//! What the script of the GitLab example in docs/judge.md runs, with a release in a folder and the test master.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::process::Command;
use std::thread;
use std::time::Duration;

use tempfile::TempDir;

use super::masters::Running;

const MANUAL: &str = include_str!("../../../docs/judge.md");
const NAME: &str = "profidrive-0.1.0-x86_64-unknown-linux-gnu";

/// The lines of `script`, each part as a shell gets it, but for packages of the image.
fn script() -> String {
    let (_, example) = MANUAL.split_once("```yaml\njudge:\n").unwrap();
    let (_, script) = example.split_once("  script:\n").unwrap();
    let (script, _) = script.split_once("  artifacts:\n").unwrap();
    let mut lines = Vec::new();
    for line in script.lines() {
        let line = line.strip_prefix("    - ").or(line.strip_prefix("      ")).unwrap();
        if line != "|" && !line.starts_with("apt-get ") {
            lines.push(line);
        }
    }
    assert_eq!(lines.len(), 7, "{script}");
    lines.join("\n")
}

#[test]
fn the_script_of_the_gitlab_example_judges_a_master() {
    assert!(
        MANUAL.contains(&format!("    NAME: {NAME}\n")) && MANUAL.contains("      junit: judgement.xml\n")
    );
    let dir = TempDir::new().unwrap();
    let folder = dir.path().join("releases/v0.1.0").join(NAME);
    fs::create_dir_all(&folder).unwrap();
    let executable = |path: &std::path::Path, text: &str| {
        fs::write(path, text).unwrap();
        fs::set_permissions(path, fs::Permissions::from_mode(0o755)).unwrap();
    };
    let program = env!("CARGO_BIN_EXE_profidrive");
    executable(&folder.join("profidrive"), &format!("#!/bin/sh\nexec {program} \"$@\" --only M-C03,M-F02\n"));
    let pack = format!("tar -czf {NAME}.tgz {NAME}");
    let release = folder.parent().unwrap();
    assert!(Command::new("sh").args(["-c", &pack]).current_dir(release).status().unwrap().success());
    // The master of the user is started with the terminal.
    executable(
        &dir.path().join("master"),
        "#!/bin/sh\necho \"$1\" >started.new; mv started.new started\nexec sleep 5 >/dev/null 2>&1\n",
    );
    // A terminal of its own, whoever else has a /tmp/bus.
    let script = script().replace("/tmp/bus", "./bus");
    let started = dir.path().join("started");
    let bus = dir.path().join("bus");
    let beside = thread::spawn(move || {
        while !started.exists() {
            thread::sleep(Duration::from_millis(20));
        }
        Running::on_terminal_with(&bus, &[5])
    });
    let job = Command::new("bash")
        .args(["-eo", "pipefail", "-c", &script])
        .current_dir(dir.path())
        .env("RELEASES", format!("file://{}", dir.path().join("releases").display()))
        .env("NAME", NAME)
        .env_remove("RUST_LOG")
        .output()
        .unwrap();
    drop(beside.join().unwrap());
    assert!(job.status.success(), "{job:?}");
    let junit = fs::read_to_string(dir.path().join("judgement.xml")).unwrap();
    assert!(junit.contains("tests=\"3\"") && junit.contains("failures=\"0\""), "{junit}");
    assert!(dir.path().join("judgement.html").exists());
}
