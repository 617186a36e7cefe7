//! `profidrive decode` and `profidrive encode`, run as processes: every worked telegram of the manuals and every vector of
//! `ag03.md` 2.5 and 2.6 both ways, the mistakes of public texts, what comes in and what goes out.

mod input;

use std::fmt::Write as _;
use std::fs;
use std::io::Write;
use std::process::{Command, Output, Stdio};

use profidrive::profibus::fdl::{FrameCount, FunctionCode, Service};
use serde_json::Value;

use crate::emulator::{output as run, profidrive};
use crate::process::end_of;
use crate::telegrams::telegram;

fn run_with(arguments: &[&str], input: &[u8]) -> Output {
    let mut command = profidrive(arguments);
    let mut process =
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut stdin = process.stdin.take().unwrap();
    let input = input.to_vec();
    let writer = std::thread::spawn(move || {
        let _ = stdin.write_all(&input);
    });
    let output = process.wait_with_output().unwrap();
    writer.join().unwrap();
    output
}

fn stdout(output: &Output) -> &str {
    std::str::from_utf8(&output.stdout).unwrap()
}

fn stderr(output: &Output) -> &str {
    std::str::from_utf8(&output.stderr).unwrap()
}

fn json_lines(output: &Output) -> Vec<Value> {
    stdout(output).lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// What `encode` is asked, the words it builds, and what `decode` says of them.
const VECTORS: [(&str, &str, &str); 33] = [
    // `ag03.md` 2.5: the worked telegrams of both manuals (chapters 7.6.1 and 7.6.2).
    ("pkw read 1018", "13FA 0000 0000 0000", "PKW job: read PNU 1018 Calibration value"),
    (
        "pkw reply 1018 10000",
        "23FA 0000 0000 2710",
        "PKW reply: PNU 1018 Calibration value = 10000 inc or 0.01 mm",
    ),
    (
        "pkw write limit1 250000",
        "33F8 0000 0003 D090",
        "PKW job: write PNU 1016 Limit 1 = 250000 inc or 0.01 mm",
    ),
    ("pkw reply limit1 250000", "23F8 0000 0003 D090", "PKW reply: PNU 1016 Limit 1 = 250000 inc or 0.01 mm"),
    // The examples of single values there.
    ("pkw reply 1020 0x2948", "13FC 0000 0000 2948", "PKW reply: PNU 1020 System status word = 2948h"),
    ("pkw reply 1033 1234567", "2409 0000 0012 D687", "PKW reply: PNU 1033 Serial number = 1234567"),
    (
        "pkw reply 1034 0x15072009",
        "240A 0000 1507 2009",
        "PKW reply: PNU 1034 Date of production = 15.07.2009",
    ),
    ("pkw reply 965 0x0101", "13C5 0000 0000 0101", "PKW reply: PNU 965 Software version = 1.01"),
    // `ag03.md` 2.6, row by row.
    ("pkw read limit2", "13F9 0000 0000 0000", "PKW job: read PNU 1017 Limit 2"),
    (
        "pkw reply limit2 -1000000",
        "23F9 0000 FFF0 BDC0",
        "PKW reply: PNU 1017 Limit 2 = -1000000 inc or 0.01 mm",
    ),
    (
        "pkw write limit2 -9999999",
        "33F9 0000 FF67 6981",
        "PKW job: write PNU 1017 Limit 2 = -9999999 inc or 0.01 mm",
    ),
    (
        "pkw reply limit2 -9999999",
        "23F9 0000 FF67 6981",
        "PKW reply: PNU 1017 Limit 2 = -9999999 inc or 0.01 mm",
    ),
    (
        "pkw write delta-inch -1600",
        "33FB 0000 FFFF F9C0",
        "PKW job: write PNU 1019 Delta inch = -1600 inc or 0.01 mm",
    ),
    (
        "pkw reply delta-inch -1600",
        "23FB 0000 FFFF F9C0",
        "PKW reply: PNU 1019 Delta inch = -1600 inc or 0.01 mm",
    ),
    (
        "pkw write operating-mode 1",
        "23A2 0000 0000 0001",
        "PKW job: write PNU 930 Operating mode = 1 (velocity mode)",
    ),
    (
        "pkw reply operating-mode 1",
        "13A2 0000 0000 0001",
        "PKW reply: PNU 930 Operating mode = 1 (velocity mode)",
    ),
    (
        "pkw write a-Pos 101 --force",
        "23EB 0000 0000 0065",
        "PKW job: write PNU 1003 a-Pos = 101 % of 4 rev/s^2",
    ),
    (
        "pkw refuse a-Pos 2",
        "73EB 0000 0000 0002",
        "PKW reply: PNU 1003 a-Pos refused: error 2, value outside the limits",
    ),
    (
        "pkw write 1000 100 --width double --force",
        "33E8 0000 0000 0064",
        "PKW job: write PNU 1000 Controller parameter P = 100",
    ),
    (
        "pkw refuse 1000 5",
        "73E8 0000 0000 0005",
        "PKW reply: PNU 1000 Controller parameter P refused: error 5, wrong data type",
    ),
    ("pkw write 918 5 --force", "2396 0000 0000 0005", "PKW job: write PNU 918 Profibus address = 5"),
    (
        "pkw refuse 918 1",
        "7396 0000 0000 0001",
        "PKW reply: PNU 918 Profibus address refused: error 1, value cannot be changed",
    ),
    (
        "pkw read 999 --force",
        "13E7 0000 0000 0000",
        "PKW job: read PNU 999 (list of changed parameter numbers in the profile)",
    ),
    (
        "pkw refuse 999 0",
        "73E7 0000 0000 0000",
        "PKW reply: PNU 999 (list of changed parameter numbers in the profile) refused: error 0, no such parameter number",
    ),
    ("pkw read 945.3", "63B1 0300 0000 0000", "PKW job: read element 3 of PNU 945 Fault buffer"),
    (
        "pkw reply 945.3 0x41",
        "43B1 0300 0000 0041",
        "PKW reply: element 3 of PNU 945 Fault buffer = fault A (supply voltage too low)",
    ),
    ("pkw count 945", "93B1 0000 0000 0000", "PKW job: read how many elements PNU 945 Fault buffer has"),
    ("pkw reply-count 945 10", "63B1 0000 0000 000A", "PKW reply: PNU 945 Fault buffer has 10 elements"),
    (
        "pkw write 970 5",
        "23CA 0000 0000 0005",
        "PKW job: write PNU 970 Load parameter data record = 5 (calibrate)",
    ),
    // The AG03/1's acknowledge; the AG03's, 13CA, reads like a job and needs its direction said.
    (
        "pkw reply 970 0 --width double",
        "23CA 0000 0000 0000",
        "PKW reply: PNU 970 Load parameter data record = 0 (carried out)",
    ),
    (
        "pkw refuse 970 17",
        "73CA 0000 0000 0011",
        "PKW reply: PNU 970 Load parameter data record refused: error 17, not possible in this operating state",
    ),
    (
        "stw enable --value 5000",
        "000B 0000 1388",
        "PZD: STW 000B (ON, no OFF2, enable operation); setpoint 5000",
    ),
    (
        "stw start --value -5000",
        "007B FFFF EC78",
        "PZD: STW 007B (ON, no OFF2, enable operation, no stop, no intermediate stop); setpoint -5000",
    ),
];

#[test]
fn every_vector_of_the_reference_goes_both_ways() {
    for (what, words, said) in VECTORS {
        let arguments: Vec<&str> = ["encode"].into_iter().chain(what.split(' ')).collect();
        let built = run(&arguments);
        assert_eq!(built.status.code(), Some(0), "{what}: {}", stderr(&built));
        let printed = format!("words   {words}\n");
        assert!(stdout(&built).starts_with(&printed), "{what}: {}", stdout(&built));
        assert!(stdout(&built).contains(&format!("\n\n{said}\n")), "{what}: {}", stdout(&built));

        let decoded = run(&["decode", "--brief", words]);
        assert_eq!(decoded.status.code(), Some(0), "{words}");
        assert_eq!(stdout(&decoded).lines().next(), Some(said), "{words}");
    }
    // Two rows that need to be told something: whose words, which operating mode.
    let load = run(&["encode", "pkw", "reply", "970", "0", "--octets"]);
    assert_eq!(stdout(&load), "13 CA 00 00 00 00 00 00\n");
    let load = run(&["decode", "--brief", "--as", "inputs", "13CA 0000 0000 0000"]);
    assert_eq!(stdout(&load), "PKW reply: PNU 970 Load parameter data record = 0 (carried out)\n");
    let velocity = run(&["encode", "stw", "run", "--value", "-72", "--mode", "velocity", "--octets"]);
    assert_eq!(stdout(&velocity), "00 4B FF FF FF B8\n");
    let velocity = run(&["decode", "--brief", "--mode", "velocity", "004B FFFF FFB8"]);
    let said = "PZD: STW 004B (ON, no OFF2, enable operation, setpoint released); setpoint -72\n";
    assert_eq!(stdout(&velocity), said);
}

#[test]
fn the_worked_telegrams_of_the_bus_are_built_and_explained() {
    // `dp-v0.md` 10.
    for (what, octets) in [
        ("fdl-status", "10 05 02 49 50 16"),
        ("raw --fc 00 --address 2 --master 5", "10 02 05 00 07 16"),
        ("diag", "68 05 05 68 85 82 6D 3C 3E EE 16"),
        (
            "raw --address 2 --master 5 --dsap 62 --ssap 60 02 05 00 FF 12 34",
            "68 0B 0B 68 82 85 08 3E 3C 02 05 00 FF 12 34 D5 16",
        ),
        (
            "set-prm --ident 1234 --watchdog 1000 --fcb 0 --force",
            "68 0C 0C 68 85 82 5D 3D 3E 88 0A 0A 0B 12 34 00 CC 16",
        ),
        ("short-acknowledge", "E5"),
        ("chk-cfg 23 13 --fcb 1 --force", "68 07 07 68 85 82 7D 3E 3E 23 13 36 16"),
        ("diag --fcb 0", "68 05 05 68 85 82 5D 3C 3E DE 16"),
        ("global-control --address 127", "68 07 07 68 FF 82 46 3A 3E 00 00 3F 16"),
        ("data-exchange 04 7E 00 00 --fcb 1 --force", "68 07 07 68 05 02 7D 04 7E 00 00 06 16"),
        ("raw --fc 0A --address 2 --master 5 02 37 00 00", "68 07 07 68 02 05 0A 02 37 00 00 4A 16"),
        ("raw --fc 03 --address 2 --master 5", "10 02 05 03 0A 16"),
        (
            "set-prm --unlock --watchdog 0 --min-tsdr 0 --ident 1234 --fcb 1",
            "68 0C 0C 68 85 82 7D 3D 3E 40 00 00 00 12 34 00 85 16",
        ),
        (
            "set-slave-add 7 --address 126 --ident 1234 --force",
            "68 09 09 68 FE 82 6D 37 3E 07 12 34 00 AF 16",
        ),
        ("token --address 3", "DC 03 02"),
    ] {
        let arguments: Vec<&str> =
            ["encode", "telegram"].into_iter().chain(what.split(' ')).chain(["--octets"]).collect();
        let built = run(&arguments);
        assert_eq!(stdout(&built), format!("{octets}\n"), "{what}: {}", stderr(&built));
        let decoded = run(&["decode", octets]);
        assert_eq!(decoded.status.code(), Some(0), "{octets}: {}", stderr(&decoded));
        assert!(!stdout(&decoded).contains('X'), "{}", stdout(&decoded));
    }
}

#[test]
fn a_sub_index_in_the_low_octet_is_shown_where_it_is() {
    let said = run(&["decode", "63B1 0007 0000 0000"]);
    let said = stdout(&said);
    assert!(said.contains("high octet  00                       0: the low octet counts"), "{said}");
    assert!(said.contains("low octet   07                       sub-index 7"), "{said}");
}

/// A whole start-up and 40 exchanges of 14 octets with a station that says ident 1234h.
#[test]
fn what_another_device_exchanges_is_not_judged_as_words_of_a_drive() {
    let mut lines = String::new();
    let mut say = |octets: &[u8]| {
        for octet in octets {
            write!(lines, "{octet:02X} ").unwrap();
        }
        lines.push('\n');
    };
    let (master, slave) = (2, 7);
    let to = |count, dsap, data: &[u8]| {
        telegram(slave, master, FunctionCode::request(Service::SrdHigh, count), dsap, data)
    };
    let reply = |data: &[u8]| telegram(master, slave, FunctionCode::from_octet(0x08), None, data);
    say(&to(FrameCount::First, Some(61), &[0x88, 10, 10, 11, 0x12, 0x34, 0]));
    say(&[0xE5]);
    say(&to(FrameCount::Even, Some(62), &[0x1D, 0x2D]));
    say(&[0xE5]);
    let mut octet = 7_u8;
    for round in 0..40 {
        let mut data = || {
            [0; 14].map(|_: u8| {
                octet = octet.wrapping_mul(141).wrapping_add(47);
                octet
            })
        };
        say(&to(if round % 2 == 0 { FrameCount::Odd } else { FrameCount::Even }, None, &data()));
        say(&reply(&data()));
    }
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("foreign.hex");
    std::fs::write(&file, lines).unwrap();
    let strict = run(&["decode", "--strict", file.to_str().unwrap()]);
    assert_eq!((strict.status.code(), stderr(&strict)), (Some(0), ""), "{}", stdout(&strict));
    assert!(stdout(&strict).contains("14 octets of outputs of another device"), "{}", stdout(&strict));
}

#[test]
fn the_mistakes_of_public_texts_are_explained_as_wrong_and_not_built_without_force() {
    for (words, hint) in [
        (
            "33E8 0000 0000 0064",
            "the parameter is a word, got a double word; use job 2, write word: PKE 23E8",
        ),
        ("13BB 0000 0000 0000", "3BBh is 955; some documents write it for PNU 947, which is 3B3h"),
        ("1BFA 0000 0000 0000", "bit 11 is the toggle bit of spontaneous messages (SPM)"),
        ("73B1 0300 0000 0000", "Job 7 writes; to read an element use job 6"),
        ("AC1A 0000 0000 0001", "which would be AA1A (538 = 21Ah)"),
        ("1C08 0000 0000 0001", "which would be 1A08 with bit 11 set"),
    ] {
        let output = run(&["decode", words]);
        assert!(stdout(&output).contains(hint), "{words}: {}", stdout(&output));
        assert!(stdout(&output).contains("\nX "), "{words}: {}", stdout(&output));
        assert_eq!(output.status.code(), Some(0), "valid octets");
        let strict = run(&["decode", "--strict", words]);
        assert_eq!((strict.status.code(), stderr(&strict)), (Some(1), "profidrive: 1 of 1 is a mistake\n"));
    }
    // PPO 3 and 4, which an article swaps.
    for (identifiers, ppo) in [("F1", "PPO 3, 2 words PZD"), ("F5", "PPO 4, 6 words PZD")] {
        let output = run(&["encode", "telegram", "chk-cfg", identifiers, "--force"]);
        assert!(stdout(&output).contains(ppo), "{}", stdout(&output));
    }
    for (what, says) in [
        (
            "pkw write a-Pos 101",
            "the value must be within 1 to 100, got 101 % of 4 rev/s^2; --force builds it nevertheless",
        ),
        ("pkw read 999", "there is no parameter 999; near it are 1000 Controller parameter P"),
        ("pkw read v-Poss", "there is no parameter 'v-Poss'; close to it are 1004 v-Pos"),
        ("pkw write 918 5", "the parameter is read-only; --force"),
        (
            "pkw write limit1 99999999999",
            "99999999999 does not fit Limit 1, which is a double word: expected -2147483648 to 4294967295",
        ),
        ("pkw read 945", "Fault buffer is an array of 10: name the element, for example 945.0; --force"),
        ("pkw write 945 1", "name the element, for example 945.0; --force"),
        ("pkw write v-Pos -5", "v-Pos takes 1 to 200, got -5; --force"),
        ("pkw reply v-Pos -5", "v-Pos takes 1 to 200, got -5; --force"),
        ("pkw reply 1033 -5", "Serial number is never negative, got -5; --force"),
        ("stw 030B", "inching 1 and inching 2 exclude each other; --force"),
        ("stw 047F", "bit 2 (OFF3) is not implemented and must be 0 by the manual"),
        ("stw enable 10=1", "bits 10 to 14 are not supported"),
        ("telegram data-exchange --stw 047F", "bit 2 (OFF3) is not implemented"),
        ("telegram data-exchange 01 02", "an AG03 refuses it: 2 octets, expected 14; --force"),
        ("telegram chk-cfg F3 F1", "an AG03 refuses it: Chk_Cfg octet 2: 0xF1, expected 0xF2"),
        ("telegram set-prm --ident 1234", "an AG03 refuses it: Set_Prm octets 5-6: ident number 0x1234"),
        ("telegram set-prm --watchdog 5", "a watchdog of 5 ms is too short; the shortest is 10 ms"),
        ("telegram set-slave-add 9", "an AG03 refuses it with RS: its address is set with switches"),
        ("telegram set-slave-add 9 --ident 1234", "an AG03 refuses it with RS"),
        ("telegram fdl-status --address 127", "this request needs a reply, and no station replies"),
        ("telegram diag --address 127", "this request needs a reply, and no station replies"),
        ("telegram data-exchange --address 127", "this request needs a reply, and no station replies"),
        ("telegram diag --address 2 --master 2", "station 2 sends it to itself: no other station accepts it"),
        ("telegram diag --master 127", "127 means all stations; no station has this address"),
        ("stw enabel", "'enabel' is no state, bit or word of four digits"),
        ("telegram diag --fcs 00", "frame check sequence is 0x00, expected 0xEE"),
        ("telegram raw --sd3 01", "Sd3 carries 8..8 data octets, got 1"),
        ("telegram data-exchange --pkw 13FA", "a PKW has four words"),
    ] {
        let arguments: Vec<&str> = ["encode"].into_iter().chain(what.split(' ')).collect();
        let output = run(&arguments);
        assert_eq!(output.status.code(), Some(2), "{what}");
        assert_eq!(stdout(&output), "", "{what}");
        assert!(stderr(&output).contains(says), "{what}: {}", stderr(&output));
        assert_eq!(stderr(&output).lines().count(), 1, "{what}");
    }
    let forced = run(&["encode", "telegram", "diag", "--fcs", "00", "--force", "--octets"]);
    assert_eq!(stdout(&forced), "68 05 05 68 85 82 6D 3C 3E 00 16\n");
}

#[test]
fn what_only_an_ag03_refuses_is_a_hint_until_the_station_is_known_as_one() {
    let cfg = "68 07 07 68 85 82 6D 3E 3E F3 F1 D4 16";
    let prm = "68 0C 0C 68 85 82 5D 3D 3E 88 0A 0A 0B 12 34 00 CC 16";
    let diag = "68 0B 0B 68 82 85 08 3E 3C 02 05 00 FF 0A C5 5E 16";
    for (input, mark) in [
        (cfg.to_string(), "plain"),
        (prm.to_string(), "plain"),
        (format!("{diag}\n{cfg}"), "mistake"),
        (format!("{diag}\n{prm}"), "mistake"),
    ] {
        let output = run_with(&["decode", "--json"], input.as_bytes());
        let last = json_lines(&output).pop().unwrap();
        assert_eq!(last["mark"], mark, "{input}");
        assert!(last["hints"][0].as_str().unwrap().starts_with("an AG03 "), "{input}: {}", last["hints"]);
    }
    // Whose diagnosis says that it is another device is not measured by ours.
    let other = "68 0B 0B 68 82 85 08 3E 3C 02 05 00 FF 12 34 D5 16";
    let output = run_with(&["decode", "--json"], format!("{other}\n{prm}\n{cfg}").as_bytes());
    for line in json_lines(&output) {
        assert_eq!(line["hints"].as_array().unwrap().len(), 0, "{}", line["summary"]);
    }
}

#[test]
fn json_has_the_members_that_are_documented() {
    let documented = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/decode.md")).unwrap();
    let input = b"68 0B 0B 68 82 85 08 3E 3C 02 05 00 FF 0A C5 5E 16\n33E8 0000 0000 0064\nFF\nfoo\n";
    let output = run_with(&["decode", "--json"], input);
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(stderr(&output), "profidrive: 1 of 3 is invalid; lines that cannot be read: 1\n");
    let lines = json_lines(&output);
    assert_eq!(lines.len(), 4);
    assert_eq!(lines[0]["service"], "Slave_Diag");
    assert_eq!((&lines[0]["from"], &lines[0]["to"], &lines[0]["at"]), (&5.into(), &2.into(), &0.into()));
    assert_eq!(
        (&lines[1]["mark"], &lines[1]["kind"], &lines[1]["sender"]),
        (&"mistake".into(), &"pkw".into(), &"master".into())
    );
    assert_eq!(
        (&lines[2]["mark"], &lines[2]["kind"], &lines[2]["line"]),
        (&"invalid".into(), &"noise".into(), &3.into())
    );
    assert!(lines[3]["error"].as_str().unwrap().contains("'foo' is no hexadecimal octet"));
    fn check(value: &Value, documented: &str) {
        match value {
            Value::Object(members) => {
                for (name, value) in members {
                    assert!(documented.contains(&format!("`{name}`")), "{name} is not in docs/decode.md");
                    check(value, documented);
                }
            }
            Value::Array(values) => values.iter().for_each(|value| check(value, documented)),
            Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {}
        }
    }
    lines.iter().for_each(|line| check(line, &documented));
    let built = run(&["encode", "pkw", "read", "1018", "--json"]);
    let built = &json_lines(&built)[0];
    assert_eq!(built["words"], serde_json::json!(["13FA", "0000", "0000", "0000"]));
    check(built, &documented);
}

#[test]
fn an_endless_line_of_noise_takes_no_more_memory_than_a_short_one() {
    // Two million octets without a line break, in a process that may hold 400 MB of addresses.
    let input = "FF".repeat(2_000_000);
    let arguments =
        ["-c", "ulimit -v 400000; exec \"$0\" decode --brief | tail -n 1", env!("CARGO_BIN_EXE_profidrive")];
    let mut command = Command::new("sh");
    command.args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut process = command.spawn().unwrap();
    let mut stdin = process.stdin.take().unwrap();
    let writer = std::thread::spawn(move || stdin.write_all(input.as_bytes()));
    let output = process.wait_with_output().unwrap();
    writer.join().unwrap().unwrap();
    assert!(stdout(&output).contains("starts no telegram"), "{} {}", stdout(&output), stderr(&output));
    assert!(stderr(&output).contains("are invalid"), "{}", stderr(&output));
}

#[test]
fn a_reader_who_leaves_early_is_no_failure() {
    let mut process = profidrive(&["decode", "--brief"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(process.stdout.take());
    let mut stdin = process.stdin.take().unwrap();
    let writer = std::thread::spawn(move || {
        // Until nobody reads any more.
        while stdin.write_all(&b"10 05 02 49 50 16\n".repeat(1000)).is_ok() {}
    });
    let output = process.wait_with_output().unwrap();
    writer.join().unwrap();
    assert_eq!((output.status.code(), stderr(&output)), (Some(0), ""));
}

#[test]
fn each_telegram_of_a_live_stream_is_told_before_the_next_comes() {
    use std::io::{BufRead, BufReader};
    let mut process =
        profidrive(&["decode", "--brief", "-"]).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let mut stdin = process.stdin.take().unwrap();
    let mut told = BufReader::new(process.stdout.take().unwrap()).lines();
    for line in 1..=3 {
        stdin.write_all(b"10 05 02 49 50 16\n").unwrap();
        stdin.flush().unwrap();
        let expected = format!("{line}: 2 -> 5  FDL status request");
        assert_eq!(told.next().unwrap().unwrap(), expected);
    }
    drop(stdin);
    assert!(end_of(&mut process).success());
}

#[test]
fn the_exit_code_says_what_is_wrong() {
    for (arguments, code, says) in [
        (&["decode", "10", "05", "02", "49", "50", "16"][..], 0, ""),
        (&["decode", "10", "05", "02", "49", "51", "16"], 1, "profidrive: 1 of 1 is invalid\n"),
        (&["decode", "68", "0G"], 2, "'0G' is no hexadecimal octet"),
        (&["decode", "no/such/file"], 1, "there is no file no/such/file"),
        (&["decode"], 1, "there are no octets in the input"),
        (&["decode", "--json", "--brief", "E5"], 2, "see 'profidrive decode --help'"),
        (&["encode"], 2, "see 'profidrive encode --help'"),
        (&["encode", "pkw", "write", "limit1"], 2, "see 'profidrive encode --help'"),
    ] {
        let output = run(arguments);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(says), "{arguments:?}: {}", stderr(&output));
        assert!(stderr(&output).lines().count() <= 1, "{arguments:?}: {}", stderr(&output));
    }
}

#[test]
fn every_help_has_an_example_that_works() {
    let mut helps: Vec<Vec<&str>> =
        ["decode", "encode", "encode pkw", "encode stw", "encode zsw", "encode telegram"]
            .map(|command| command.split(' ').collect())
            .into();
    // `args::tests` walks the tree for those that have none.
    for leaf in ["none", "read", "write", "count", "raw", "reply", "reply-count", "refuse"] {
        helps.push(vec!["encode", "pkw", leaf]);
    }
    for leaf in [
        "fdl-status",
        "diag",
        "set-prm",
        "chk-cfg",
        "get-cfg",
        "data-exchange",
        "global-control",
        "rd-inp",
        "rd-outp",
        "set-slave-add",
        "token",
        "short-acknowledge",
        "raw",
    ] {
        helps.push(vec!["encode", "telegram", leaf]);
    }
    for command in helps {
        let output = run(&[command.as_slice(), &["--help"]].concat());
        assert_eq!(output.status.code(), Some(0));
        let examples: Vec<&str> =
            stdout(&output).lines().filter_map(|line| line.strip_prefix("  profidrive ")).collect();
        assert!(!examples.is_empty(), "{command:?}");
        // Those that need no file.
        for example in examples.iter().filter(|line| !line.contains(['<', '-']) || line.starts_with("encode"))
        {
            let script = format!("\"$0\" {example}");
            let output =
                Command::new("sh").args(["-c", &script, env!("CARGO_BIN_EXE_profidrive")]).output().unwrap();
            assert_eq!(output.status.code(), Some(0), "{example}: {}", stderr(&output));
        }
    }
}
