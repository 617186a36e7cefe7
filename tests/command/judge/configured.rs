//! What is configured in the master comes from files: stations of a line file, the master's own device file.

use std::fs;

use serde_json::Value;
use tempfile::TempDir;

use super::{DIAG, run};

/// The device file of station 5.
const STATION: &str = "#Profibus_DP\nGSD_Revision=1\nIdent_Number=0x1234\n500_supp=1\nMaxTsdr_500=100\nModular_Station=1\n\
    Max_Module=2\nMax_Diag_Data_Len=16\nModule=\"out\" 0x23\nEndModule\nModule=\"in\" 0x13\nEndModule\n";
const LINE: &str = "[[line]]\nlink = 'pty'\n[[line.drive]]\naddress = 7\n[[line.ppo-drive]]\naddress = 8\nppo = 3\n\
    [[line.station]]\naddress = 5\ngsd = 'io.gsd'\nmodules = ['out', 'in']\n";

struct Files(TempDir);

impl Files {
    fn new(files: &[(&str, &str)]) -> Self {
        let dir = TempDir::new().unwrap();
        let hex: Vec<String> = DIAG.iter().map(|octet| format!("{octet:02X}")).collect();
        for (name, text) in [("io.gsd", STATION), ("line.txt", &hex.join(" "))].iter().chain(files) {
            fs::write(dir.path().join(name), text).unwrap();
        }
        Self(dir)
    }

    fn path(&self, name: &str) -> String {
        self.0.path().join(name).to_str().unwrap().to_owned()
    }
}

#[test]
fn the_stations_of_a_line_file_are_those_of_the_master() {
    let files = Files::new(&[("line.toml", LINE)]);
    let (capture, line, json) = (files.path("line.txt"), files.path("line.toml"), files.path("v.json"));
    let more = ["--station", "9,ident=1234,cfg=2313,absent", "--only", "M-F06"];
    let (code, _, stderr) = run(&[&[&*capture, "--line", &line, "--json", &json][..], &more].concat());
    assert_eq!(code, Some(0), "{stderr}");
    let report: Value = serde_json::from_str(&fs::read_to_string(json).unwrap()).unwrap();
    let stations = serde_json::json!([
        "9,ident=1234,cfg=2313,absent",
        "7,ident=0AC5,cfg=F3F2",
        "8,ident=5044,cfg=F1",
        "5,ident=1234,cfg=2313",
    ]);
    assert_eq!(report["configuration"]["stations"], stations);
}

#[test]
fn a_line_file_that_is_no_line_of_one_master_is_refused() {
    let two = format!("{LINE}{}", LINE.replace("'pty'", "'pty:other'"));
    let nodes = "[[line]]\nlink = 'slcan-pty:can'\n[[line.node]]\nid = 5\n";
    let files = Files::new(&[("two.toml", &two), ("nodes.toml", nodes), ("one.toml", LINE)]);
    for (file, more, words) in [
        ("two.toml", &[][..], "two lines have stations, and the judge plays one line; give a file of one"),
        ("nodes.toml", &[], "no line has stations on PROFIBUS"),
        ("missing.toml", &[], "cannot read"),
        (
            "one.toml",
            &["--station", "5,ident=1234,cfg=2313"],
            "two stations have address 5; give each its own",
        ),
        ("one.toml", &["--master", "7"], "station 7 has the address of the master"),
    ] {
        let (code, stdout, stderr) = run(&[&["--line", &*files.path(file)][..], more].concat());
        assert_eq!((code, stdout.as_str()), (Some(2), ""), "{stderr}");
        assert!(stderr.contains(words) && stderr.lines().count() == 1, "{stderr}");
    }
}

#[test]
fn a_master_is_not_configured_beyond_its_device_file() {
    let master = "#Profibus_DP\nGSD_Revision=3\nVendor_Name=\"Test\"\nModel_Name=\"Master\"\nStation_Type=1\n500_supp=1\n\
        Max_Slaves_supp=1\n";
    let files = Files::new(&[("master.gsd", master)]);
    let (file, json) = (files.path("master.gsd"), files.path("v.json"));
    let station = ["--station", "5,ident=1234,cfg=2313", "--master-gsd", &file];
    let of_capture = [&*files.path("line.txt"), "--only", "M-F06", "--json", &json];
    let (code, _, stderr) = run(&[&station[..], &of_capture].concat());
    assert_eq!(code, Some(0), "{stderr}");
    let report: Value = serde_json::from_str(&fs::read_to_string(&json).unwrap()).unwrap();
    assert_eq!(report["configuration"]["master-gsd"], "Test Master");
    let slave = files.path("io.gsd");
    for (more, words) in [
        (&["--baud", "187500"][..], "master.gsd: it offers no 187500 bit/s, but 500000 bit/s"),
        (&["--station", "6,ident=1234,cfg=2313"], "Max_Slaves_supp is 1, and there are 2 stations"),
    ] {
        let (code, stdout, stderr) = run(&[&station[..], more].concat());
        assert_eq!((code, stdout.as_str()), (Some(2), ""), "{stderr}");
        assert!(stderr.contains(words) && stderr.lines().count() == 1, "{stderr}");
    }
    let (code, _, stderr) = run(&["--station", "5,ident=1234,cfg=2313", "--master-gsd", &slave]);
    assert_eq!(code, Some(2), "{stderr}");
    assert!(stderr.contains("Station_Type is 0, expected 1: this file describes no master"), "{stderr}");
}
