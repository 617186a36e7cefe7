//! What a package installs beside the program: completions and manual pages.

use std::fs;
use std::io::Write;
use std::process::{Command, Stdio};

use crate::emulator;
use crate::process::end_of;

/// Exit status, stdout, stderr.
fn output(arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = emulator::output(arguments);
    let text = |octets| String::from_utf8(octets).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

#[test]
fn each_shell_gets_completions_of_every_command() {
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let (status, script, _) = output(&["completions", shell]);
        assert_eq!(status, Some(0), "{shell}");
        for command in ["emulate", "master", "decode", "judge", "completions"] {
            assert!(script.contains(command), "{shell}: {command}");
        }
    }
    let (_, script, _) = output(&["completions", "bash"]);
    let mut bash = Command::new("bash").arg("-n").stdin(Stdio::piped()).spawn().unwrap();
    bash.stdin.take().unwrap().write_all(script.as_bytes()).unwrap();
    assert!(end_of(&mut bash).success(), "bash reads it");
    let (status, _, line) = output(&["completions", "cmd"]);
    assert_eq!(status, Some(2));
    assert!(line.contains("'cmd'"), "{line}");
}

#[test]
fn there_is_a_manual_page_of_every_command() {
    let (status, page, _) = output(&["man"]);
    assert_eq!(status, Some(0));
    assert!(page.contains(".TH profidrive 1"), "{page}");
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(output(&["man", folder.path().to_str().unwrap()]).0, Some(0));
    for command in ["profidrive", "profidrive-emulate", "profidrive-judge", "profidrive-master-move"] {
        let page = fs::read_to_string(folder.path().join(command).with_extension("1")).unwrap();
        assert!(page.contains(&format!(".TH {command} 1")), "{page}");
    }
    let (status, _, line) = output(&["man", "/no-such-folder"]);
    assert_eq!(status, Some(1));
    assert!(line.contains("cannot write to /no-such-folder"), "{line}");
}
