//! What comes in: text in its forms, raw octets, captures; from arguments, stdin and files.

use std::fs;
use std::process::Output;

use super::{json_lines, run, run_with, stderr, stdout};

#[test]
fn text_raw_octets_and_files_are_read_from_stdin_and_by_name() {
    let text = "# a start-up\n68 05 05 68 85 82 6D 3C 3E EE 16\n680B0B688285083E3C020500FF0AC55E16\n";
    let expected =
        "2 -> 5  Slave_Diag request\n5 -> 2  diagnosis: not ready, wants parameters, no master, ident 0AC5\n";
    let lines = |output: &Output| -> String {
        let line = |line: &str| line.split_once(": ").map_or(String::new(), |line| format!("{}\n", line.1));
        stdout(output).lines().map(line).collect()
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("trace.txt");
    fs::write(&path, text).unwrap();
    for output in [
        run_with(&["decode", "--brief"], text.as_bytes()),
        run_with(&["decode", "--brief", "-"], text.as_bytes()),
        run(&["decode", "--brief", path.to_str().unwrap()]),
    ] {
        assert_eq!((output.status.code(), lines(&output).as_str()), (Some(0), expected));
        assert!(stdout(&output).starts_with("2: "), "the line is named");
    }
    let raw: Vec<u8> = text
        .lines()
        .skip(1)
        .map(|line| line.replace(' ', ""))
        .flat_map(|line| {
            (0..line.len())
                .step_by(2)
                .map(|at| u8::from_str_radix(&line[at..at + 2], 16).unwrap())
                .collect::<Vec<_>>()
        })
        .collect();
    let output = run_with(&["decode", "--brief"], &raw);
    assert_eq!((output.status.code(), lines(&output).as_str()), (Some(0), expected));
}

#[test]
fn text_in_the_utf_16_of_windows_is_text() {
    let units = "\u{feff}10 05 02 49 50 16\r\nE5\r\n".encode_utf16();
    let low: Vec<u8> = units.clone().flat_map(u16::to_le_bytes).collect();
    let high: Vec<u8> = units.flat_map(u16::to_be_bytes).collect();
    for input in [low, high] {
        let output = run_with(&["decode", "--brief"], &input);
        let expected = "1: 2 -> 5  FDL status request\n2: 5 -> 2  short acknowledge: request received\n";
        assert_eq!((output.status.code(), stdout(&output)), (Some(0), expected));
    }
}

#[test]
fn what_is_broken_off_is_named_with_the_line_it_began_in() {
    for (input, line) in [
        ("10 05 02 49 50 16\n10 05 02 49 50 16\n68", 3),
        ("10 05 02 49 50 16\n10 05 02 49 50 16\n68\n", 3),
        ("68\n# nothing\n\n", 1),
        ("\n68\n\n10 05 02 49 50 16\n", 2),
    ] {
        let output = run_with(&["decode", "--json"], input.as_bytes());
        let lines = json_lines(&output);
        let broken: Vec<_> = lines.iter().filter(|line| line["mark"] == "invalid").collect();
        assert_eq!(broken.len(), 1, "{input:?}");
        assert_eq!(broken[0]["line"], line, "{input:?}");
        assert!(broken[0]["summary"].as_str().unwrap().contains("broken off"), "{input:?}");
    }
}

#[test]
fn usual_forms_are_read_as_meant_or_refused_with_the_reason() {
    let pkw = "PKW job: write PNU 1016 Limit 1 = 250000 inc or 0.01 mm";
    let status = "2 -> 5  FDL status request";
    for (input, says) in [
        ("10 05 02 49 50 17", "2 -> 5  invalid at octet 5: end delimiter"),
        ("11 05 02 49 50 16", "invalid at octet 0: octet 0x11 starts no telegram"),
        ("0x33F8 0x0 0x3 0xD090", pkw),
        ("W#16#33F8 W#16#0 W#16#3 W#16#D090", pkw),
        ("16#33F8 16#0 16#3 16#D090", pkw),
        ("B#16#10 B#16#05 B#16#02 B#16#49 B#16#50 B#16#16", status),
        ("[12:00:01.123] 10 05 02 49 50 16", status),
        ("12:00:01 10 05 02 49 50 16", status),
        ("10:05:02:49:50:16", status),
    ] {
        let output = run(&["decode", "--brief", input]);
        let code = if says.contains("invalid") { 1 } else { 0 };
        assert_eq!(output.status.code(), Some(code), "{input}: {}", stderr(&output));
        assert!(stdout(&output).starts_with(says), "{input}: {}", stdout(&output));
    }
    let output = run(&["decode", "--brief", "--as", "words", "10 05 02 49 50 17"]);
    assert!(stdout(&output).starts_with("PZD: STW 1005"), "{}", stdout(&output));
    let output = run(&["decode", "\u{ff11}\u{ff10} 05"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        stderr(&output).contains("has full-width characters; write the digits 0 to 9"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn a_capture_is_known_by_its_beginning() {
    use profidrive::host::Link;
    use profidrive::host::SystemClock;
    use profidrive::host::capture::{Capture, Interface};
    use profidrive::host::link::memory::Wire;
    use profidrive::host::link::tap::{Batch, Tap};

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bus");
    let clock = SystemClock::new();
    let line = Interface { name: "memory", description: "a test", baud: None };
    let mut file = Capture::create(&path, &line, &clock).unwrap();
    let wire = Wire::new();
    let mut drives = Tap::new(wire.end(), clock, |batch: &Batch| file.write(batch).unwrap());
    drives.send(&[0x10, 0x02, 0x05, 0x00, 0x07, 0x16]).unwrap();
    drives.send(&[0xE5]).unwrap();
    drop(drives);

    let output = run(&["decode", "--json", path.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let packets = json_lines(&output);
    assert_eq!(packets.len(), 2);
    assert_eq!((&packets[0]["packet"], &packets[0]["summary"]), (&1.into(), &"here, a slave".into()));
    assert!(packets[0]["time"].as_str().unwrap().contains('.'));
    // Half a capture tells its beginning and fails.
    let whole = fs::read(&path).unwrap();
    fs::write(&path, &whole[..whole.len() - 3]).unwrap();
    let output = run(&["decode", "--brief", path.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(1));
    assert!(stdout(&output).starts_with("1: 5 -> 2  here, a slave"), "{}", stdout(&output));
    assert!(stderr(&output).contains("cut short"), "{}", stderr(&output));
}
