//! What stations keep over a kill with `--state-dir`: the address of Set_Slave_Add, parameters of a drive of the profile.

use core::time::Duration;
use std::fs;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::thread;
use std::time::Instant;

use profidrive::profibus::fdl::{FrameCount, FunctionCode, Service};
use serde_json::Value;

use crate::emulator::{Emulator, output};
use crate::panel_records;
use crate::patience::PATIENCE;
use crate::raw_master::RawMaster;
use crate::telegrams::telegram;

const MASTER: u8 = 2;
/// A short acknowledge, and what begins a telegram of any length.
const SC: u8 = 0xE5;
const SD2: u8 = 0x68;

fn gsd(folder: &Path) -> String {
    let text = fs::read_to_string(format!("{}/tests/gsd/modular.gsd", env!("CARGO_MANIFEST_DIR"))).unwrap();
    let path = folder.join("addressed.gsd");
    fs::write(&path, text.replace("Ident_Number = 0x0A02", "Ident_Number = 0x0A02\nSet_Slave_Add_supp = 1"))
        .unwrap();
    path.to_str().unwrap().to_owned()
}

/// The first octet that comes back, and the source of the telegram if it is one, after a request to each of these stations.
fn reply(emulator: &Emulator, addresses: &[u8], dsap: u8, data: &[u8]) -> (u8, u8) {
    let link = emulator.link().strip_prefix("tcp:").unwrap();
    let mut line = TcpStream::connect(link).unwrap();
    line.set_read_timeout(Some(PATIENCE)).unwrap();
    let fc = FunctionCode::request(Service::SrdHigh, FrameCount::First);
    for address in addresses {
        line.write_all(&telegram(*address, MASTER, fc, Some(dsap), data)).unwrap();
    }
    let mut head = [0; 6];
    line.read_exact(&mut head[..1]).unwrap();
    if head[0] != SC {
        line.read_exact(&mut head[1..]).unwrap();
    }
    (head[0], head[5] & 0x7F)
}

fn appears(file: &Path) {
    let start = Instant::now();
    while !file.exists() {
        assert!(start.elapsed() < PATIENCE, "{} is not written", file.display());
        thread::sleep(Duration::from_millis(2));
    }
}

#[test]
fn a_05_an_address_of_set_slave_add_survives_a_kill() {
    let folder = tempfile::tempdir().unwrap();
    let state = folder.path().join("state");
    let station = format!("7,gsd={}", gsd(folder.path()));
    let arguments =
        ["--link", "tcp:127.0.0.1:0", "--station", &station, "--state-dir", state.to_str().unwrap()];
    let emulator = Emulator::start(&arguments);
    assert_eq!(reply(&emulator, &[7], 55, &[9, 0x0A, 0x02, 0]), (SC, 0));
    assert_eq!(reply(&emulator, &[9], 60, &[]), (SD2, 9));
    appears(&state.join("gsd-0a02-007.eeprom"));
    emulator.signal("KILL");
    emulator.end();

    let emulator = Emulator::start(&arguments);
    assert!(emulator.ready.ends_with(" stations=9\n"), "{}", emulator.ready);
    assert_eq!(
        reply(&emulator, &[7, 9], 60, &[]),
        (SD2, 9),
        "at its new address, not at that of the command line"
    );
    emulator.signal("TERM");
    let (_, _, log) = emulator.end();
    assert!(log.contains("station 7: Set_Slave_Add gave it address 9, which is used"), "{log}");
}

fn asked(emulator: &Emulator, arguments: &[&str]) -> Value {
    let example = |name: &str| format!("{}/examples/{name}", env!("CARGO_MANIFEST_DIR"));
    let common = ["master", "--link", emulator.link(), "--address", "7", "--ppo", "1", "--json"];
    let described = ["--gsd", &example("ppo_drive.gsd"), "--parameters", &example("ppo_drive.toml")];
    let output = output(&[&common[..], &described, arguments].concat());
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    let said = String::from_utf8(output.stdout).unwrap();
    let last = said.lines().last().unwrap_or_default();
    serde_json::from_str(&said).or_else(|_| serde_json::from_str(last)).unwrap()
}

#[test]
fn an_acknowledged_parameter_of_a_drive_of_the_profile_survives_a_kill() {
    let folder = tempfile::tempdir().unwrap();
    let state = folder.path().join("state");
    let example = |name: &str| format!("{}/examples/{name}", env!("CARGO_MANIFEST_DIR"));
    let drive = format!("7,gsd={},parameters={}", example("ppo_drive.gsd"), example("ppo_drive.toml"));
    let arguments = ["--ppo-drive", &drive, "--state-dir", state.to_str().unwrap()];
    for (before, value) in [(20, 3), (3, 77), (77, 650)] {
        let emulator = Emulator::start(&arguments);
        let written = asked(&emulator, &["write", "ramp-up time", &value.to_string()]);
        let found = [&written["before"], &written["value"]].map(Value::as_f64);
        assert_eq!(found, [Some(f64::from(before)), Some(f64::from(value))]);
        asked(&emulator, &["write", "load", "12.5"]);
        emulator.signal("KILL");
        emulator.end();
    }
    let emulator = Emulator::start(&arguments);
    assert_eq!(asked(&emulator, &["read", "ramp-up time"])["value"], 650.0);
    // The machine is no part of the drive.
    assert_eq!(asked(&emulator, &["read", "load"])["value"], 10.0);
}

#[test]
fn a_record_and_a_block_that_a_master_wrote_survive_a_kill() {
    let folder = tempfile::tempdir().unwrap();
    let state = folder.path().join("state");
    let station = panel_records::station(folder.path());
    let arguments =
        ["--link", "tcp:127.0.0.1:0", "--station", &station, "--state-dir", state.to_str().unwrap()];
    let mut block = [b'x'; 68];
    for (before, value) in [([0x41, 0x42, 0, 0x44], 7_u8), ([7; 4], 9), ([9; 4], 11)] {
        let emulator = Emulator::start(&arguments);
        let mut master = RawMaster::new(emulator.link(), MASTER);
        panel_records::start(&mut master);
        assert_eq!(master.ms1(7, &[0x5E, 1, 10, 240])[4..], before);
        block[..4].copy_from_slice(&[8, 0, 0xFD, 0xE9]);
        assert_eq!(master.ms1(7, &[&[0x5F, 0, 255, 68][..], &block].concat()), [0x5F, 0, 255, 68]);
        assert_eq!(master.ms1(7, &[&[0x5F, 1, 10, 4][..], &[value; 4]].concat()), [0x5F, 1, 10, 4]);
        emulator.signal("KILL");
        emulator.end();
    }
    let emulator = Emulator::start(&arguments);
    let mut master = RawMaster::new(emulator.link(), MASTER);
    panel_records::start(&mut master);
    assert_eq!(master.ms1(7, &[0x5E, 1, 10, 240])[4..], [11; 4]);
    assert_eq!(master.ms1(7, &[0x5F, 0, 255, 4, 8, 0, 0xFD, 0xE9]), [0x5F, 0, 255, 4]);
    assert_eq!(master.ms1(7, &[0x5E, 0, 255, 240])[8..], [b'x'; 64]);
}

#[test]
fn parameters_of_a_drive_of_profidrive_survive_a_kill_once_they_are_stored() {
    let folder = tempfile::tempdir().unwrap();
    let own = folder.path().join("own.toml");
    let row = "[[parameter]]\npnu = 600\nname = \"own\"\ntype = \"uint16\"\nmax = 60000\ndefault = 150\n";
    std::fs::write(&own, row).unwrap();
    let state = folder.path().join("state");
    let drive = format!("7,telegram=1,parameters={}", own.display());
    let arguments =
        ["--link", "tcp:127.0.0.1:0", "--profidrive", &drive, "--state-dir", state.to_str().unwrap()];
    let param = |emulator: &Emulator, arguments: &[&str]| {
        let common = ["master", "--link", emulator.link(), "--address", "7", "param"];
        let output = output(&[&common[..], arguments].concat());
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    for (before, value) in [(150, 7), (7, 9)] {
        let emulator = Emulator::start(&arguments);
        assert!(param(&emulator, &["read", "600"]).starts_with(&format!("PNU 600: {before} ")), "{before}");
        param(&emulator, &["write", &format!("600={value}")]);
        param(&emulator, &["write", "971=1"]);
        while !param(&emulator, &["read", "971"]).starts_with("PNU 971: 0 ") {}
        // Not stored: it goes with the drive.
        param(&emulator, &["write", "600=1000"]);
        emulator.signal("KILL");
        emulator.end();
    }
    let emulator = Emulator::start(&arguments);
    assert!(param(&emulator, &["read", "600"]).starts_with("PNU 600: 9 "));
    // A file of another type of parameter: what does not fit it is left out.
    drop(emulator);
    std::fs::write(&own, row.replace("60000", "8").replace("150", "5")).unwrap();
    let emulator = Emulator::start(&arguments);
    let read = param(&emulator, &["read", "600"]);
    assert!(read.starts_with("PNU 600: 5 "), "{read}");
}
