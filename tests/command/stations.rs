//! `emulate --station` and `gsd`: stations from device files, as their users run them.

use crate::emulator::{Emulator, output};

fn file(name: &str) -> String {
    format!("{}/tests/gsd/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// The ready line, then SIGTERM; the exit code, what was logged.
fn emulated(arguments: &[&str]) -> (String, Option<i32>, String) {
    let emulator = Emulator::start(arguments);
    let ready = emulator.ready.clone();
    emulator.signal("TERM");
    let (code, _, log) = emulator.end();
    (ready, code, log)
}

#[test]
fn stations_stand_beside_drives_or_alone() {
    let (seven, nine) =
        (format!("7,gsd={}", file("modular.gsd")), format!("9,strict,gsd={}", file("slots.gsd")));
    let (ready, code, log) = emulated(&["--drive", "5", "--station", &seven, "--station", &nine]);
    assert!(
        ready.starts_with("ready link=/dev/pts/") && ready.ends_with(" drives=5 stations=7,9\n"),
        "{ready}"
    );
    assert_eq!(code, Some(0), "{log}");
    assert!(log.contains("profidrive Modular, ident 0x0A02, from its GSD at address 7"), "{log}");
    let (ready, code, _) = emulated(&["--station", &seven]);
    assert!(ready.starts_with("ready link=/dev/pts/") && ready.ends_with(" stations=7\n"), "{ready}");
    assert!(!ready.contains("drives="), "{ready}");
    assert_eq!(code, Some(0));
}

#[test]
fn a_station_is_on_a_line_of_31_25_or_45_45_kbit_where_its_file_offers_it() {
    for (rate, bits) in [("45.45", "45450"), ("31.25", "31250")] {
        a_station_is_on_a_line_where_its_file_offers_it(rate, bits);
    }
}

fn a_station_is_on_a_line_where_its_file_offers_it(rate: &str, bits: &str) {
    let folder = tempfile::tempdir().unwrap();
    let gsd = folder.path().join("slow.gsd");
    let text = std::fs::read_to_string(file("remote_io.gsd")).unwrap();
    let offered = format!("{rate}_supp = 1\nMaxTsdr_{rate} = 60\n9.6_supp");
    std::fs::write(&gsd, text.replacen("9.6_supp", &offered, 1)).unwrap();
    let (slow, other) = (format!("7,gsd={}", gsd.display()), format!("8,gsd={}", file("remote_io.gsd")));
    let (ready, code, log) = emulated(&["--baud", bits, "--station", &slow, "--station", &other]);
    assert!(ready.ends_with(" stations=7,8\n") && code == Some(0), "{ready}{log}");
    let silent = format!("station 8 hears nothing at {bits} bit/s: it does not offer this rate");
    assert!(log.contains(&silent), "{log}");
    assert!(!log.contains("station 7 hears nothing"), "{log}");
}

#[test]
fn what_is_wrong_with_a_station_is_one_line_and_nothing_is_started() {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str, octets: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, octets).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let utf16 = place("utf16.gsd", b"\xFF\xFE#\0P\0");
    let presets = "#Profibus_DP\nIdent_Number=1\nModular_Station=1\nFixPresetModules=1\nMax_Module=1\n\
                   Module=\"a\" 0x10\nPreset=1\nEndModule\nModule=\"b\" 0x10\nPreset=1\nEndModule\n";
    let presets = place("presets.gsd", presets.as_bytes());
    let link = folder.path().join("bus");
    let good = file("modular.gsd");
    for (stations, words) in [
        (vec!["7,gsd=/nowhere.gsd".to_owned()], "cannot read /nowhere.gsd: "),
        (vec![format!("7,gsd={utf16}")], "line 1, column 1: the file is UTF-16"),
        (
            vec![format!("7,gsd={presets}")],
            "2 modules are Preset with FixPresetModules, Max_Module is 1; raise it",
        ),
        (
            vec![format!("7,gsd={good}"), format!("7,gsd={good}")],
            "two stations have address 7; give each its own",
        ),
        (vec![format!("7,gsd={good}"), "8".to_owned()], "no file is named; expected ADDRESS,gsd=FILE"),
        (vec![format!("7,gsd={good}"), "8,gsd=/nowhere.gsd".to_owned()], "cannot read /nowhere.gsd: "),
        (
            vec!["7,gsd=/dev/zero".to_owned()],
            "/dev/zero: line 1, column 1: the file has 4194305 octets, expected at most 4194304",
        ),
    ] {
        let link_spec = format!("pty:{}", link.display());
        let mut arguments = vec!["emulate", "--link", &link_spec];
        arguments.extend(stations.iter().flat_map(|station| ["--station", station]));
        let output = output(&arguments);
        let log = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{log}");
        let last = log.lines().last().unwrap();
        assert!(last.starts_with("profidrive: ") && last.contains(words), "{log}");
        assert!(output.stdout.is_empty() && !link.exists());
    }
    let both = output(&["emulate", "--drive", "7", "--station", &format!("7,gsd={good}")]);
    assert_eq!(both.status.code(), Some(2));
    assert!(String::from_utf8(both.stderr).unwrap().contains("two stations have address 7"));
}

#[test]
fn a_file_is_explained_in_words_and_as_json() {
    let explained = output(&["gsd", &file("extended_prm.gsd")]);
    let text = String::from_utf8(explained.stdout).unwrap();
    for words in [
        "profidrive Extended, ident 0x0A05",
        "500000 bit/s, replies begin within 100 bit times",
        "  1 in: 10; 0 out, 1 in",
        "User parameters of the station, by default 80 59 FF FE",
        "  octet 1, Bit(3): Diagnosis = 1 (on); 0..1",
        "    0 = off",
        "  octet 1, BitArea(4-6): Range = 5; 0, 2, 5",
    ] {
        assert!(text.contains(words), "{words}\n{text}");
    }
    assert!(!text.contains("Diagnosis\n") && !text.contains("Odd\n"), "nothing to tell: {text}");
    let json = output(&["gsd", "--json", &file("dpv1.gsd")]);
    let json: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!(json["ident"], 0x0A07);
    assert_eq!(json["flags"]["DPV1_Slave"], true);
    assert_eq!(json["modules"][0]["default_prm"], serde_json::json!([0xA1, 0xA2]));
    assert_eq!(json["user_prm_lengths"], serde_json::json!([3, 9]));
}

#[test]
fn what_a_master_sends_for_chosen_modules_is_printed() {
    let twins = file("twins.gsd");
    let run = |arguments: &[&str]| {
        let output = output(&[&["gsd", &twins], arguments].concat());
        let said = |octets: Vec<u8>| String::from_utf8(octets).unwrap();
        (output.status.code(), said(output.stdout), said(output.stderr))
    };
    let (code, said, log) = run(&["--modules", "range,out", "--set", "Range=30"]);
    assert_eq!(code, Some(0), "{log}");
    for words in [
        "Ident number     0A09",
        "Chk_Cfg          13 23",
        "User parameters  00 A1 1E",
        "Data_Exchange    4 octets out, 4 in",
        "Slot 1: range\n  octet 2: Range = 30",
        "Slot 2: out",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    let (_, said, _) = run(&["--json", "--modules", "range", "--modules", "other", "--set", "2:Range=11"]);
    let json: serde_json::Value = serde_json::from_str(&said).unwrap();
    assert_eq!(json["chk_cfg"], serde_json::json!([0x13, 0x13]));
    assert_eq!(json["user_prm"], serde_json::json!([0, 0xA1, 20, 0xB2, 11]));
    assert_eq!(json["parameters"][1]["value"], 11);
    for (arguments, words) in [
        (&["--modules", "rage"][..], "there is no module 'rage'; did you mean 'range'?"),
        (
            &["--modules", "range", "--set", "Rnge=1"],
            "there is no parameter 'Rnge' here; did you mean 'Range'?",
        ),
        (&["--modules", "range", "--set", "Range=99"], "'Range' cannot be '99'; expected 10..30"),
        (&["--modules", "range,other", "--set", "Range=11"], "name one of them: '1:Range=11'"),
        (&["--modules", "out,out,out,out,out"], "the station takes 4 modules (Max_Module)"),
    ] {
        let (code, _, log) = run(arguments);
        assert!(code == Some(2) && log.contains(words), "{words}: {log}");
    }
    // Texts of a file are values, too; what is asked for is listed.
    let extended = output(&["gsd", &file("extended_prm.gsd"), "--modules", "1 in", "--set", "Diagnosis=off"]);
    let said = String::from_utf8(extended.stdout).unwrap();
    assert!(said.contains("octet 1: Diagnosis = 0 (off)"), "{said}");
    let (_, said, _) = run(&["--list", "HF"]);
    assert_eq!(said, "Modules\n  plain HF: 13; 0 out, 4 in\n");
}

#[test]
fn a_long_file_is_an_overview_and_what_is_asked_for() {
    use std::fmt::Write as _;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("long.gsd");
    let mut text =
        "#Profibus_DP\nGSD_Revision=4\nMax_Diag_Data_Len=32\nIdent_Number=1\n9.6_supp=1\nMaxTsdr_9.6=60\nPrmText=1\n".to_owned();
    for value in 0..200 {
        writeln!(text, "Text({value})=\"speed {value}\"").unwrap();
    }
    text += "EndPrmText\n";
    for number in 1..=60 {
        let name = format!("ExtUserPrmData={number} \"Parameter {number}\"");
        writeln!(text, "{name}\nUnsigned8 0 0-199\nPrm_Text_Ref=1\nEndExtUserPrmData").unwrap();
        writeln!(text, "Unit_Diag_Bit({number})=\"Fault {number}\"").unwrap();
        writeln!(text, "Ext_User_Prm_Data_Ref({})={number}", number - 1).unwrap();
    }
    text += "Module=\"io\" 0x30\nExt_Module_Prm_Data_Len=1\nExt_User_Prm_Data_Ref(0)=1\nEndModule\n";
    std::fs::write(&path, text).unwrap();
    let run = |arguments: &[&str]| {
        let output = output(&[&["gsd", path.to_str().unwrap()], arguments].concat());
        String::from_utf8(output.stdout).unwrap()
    };
    let overview = run(&[]);
    assert!(overview.lines().count() < 30, "{overview}");
    for words in [
        "  60 parameters; --list prints them, --list TEXT those whose names contain TEXT\n",
        "  60 texts; --list prints them, --list TEXT those that contain TEXT\n",
        "Parameter 1 = 0 (speed 0); 0..199\n      200 texts; --list prints them\n",
    ] {
        assert!(overview.contains(words), "{words}: {overview}");
    }
    let all = run(&["--list"]);
    assert!(all.contains("199 = speed 199") && all.contains("bit 60: Fault 60"), "{all}");
    assert!(all.lines().count() > 60 * 200, "{}", all.lines().count());
    let asked = run(&["--list", "fault 6"]);
    assert_eq!(asked, "Diagnosis\n  bit 6: Fault 6\n  bit 60: Fault 60\n");
    assert!(run(&["--list", "parameter 33"]).starts_with("User parameters of the station\n  octet 32, "));
}

#[test]
fn authors_are_told_what_is_odd_with_line_and_column() {
    assert_eq!(output(&["gsd", "check", &file("modular.gsd")]).status.code(), Some(0));
    let folder = tempfile::tempdir().unwrap();
    let odd = folder.path().join("odd.gsd");
    std::fs::write(
        &odd,
        "#Profibus_DP\nGSD_Revision=1\nIdent_Number=1\n24V Pins=0\n9.6_supp=1\nMaxTsdr_9.6=60\n",
    )
    .unwrap();
    let checked = output(&["gsd", "check", odd.to_str().unwrap()]);
    let said = String::from_utf8(checked.stdout).unwrap();
    assert!(said.contains("odd.gsd: line 4, column 1: warning: a blank in the keyword '24V Pins'"), "{said}");
    assert_eq!(checked.status.code(), Some(1));
    assert_eq!(output(&["gsd", "check", "/nowhere.gsd"]).status.code(), Some(2));
}
