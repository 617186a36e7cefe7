//! `emulate --ppo-drive`: drives of the profile, as their users run them.

use crate::emulator::{Emulator, output};

fn file(name: &str) -> String {
    format!("{}/examples/{name}", env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn drives_of_the_profile_are_drives_of_the_ready_line() {
    let described = format!("7,gsd={},parameters={}", file("ppo_drive.gsd"), file("ppo_drive.toml"));
    let table = format!("8,ppo=2,ident=80D1,parameters={}", file("ppo_drive.csv"));
    let emulator = Emulator::start(&["--drive", "5", "--ppo-drive", &described, "--ppo-drive", &table]);
    assert!(emulator.ready.ends_with(" drives=5,7,8\n"), "{}", emulator.ready);
    emulator.signal("TERM");
    let (code, _, log) = emulator.end();
    assert_eq!(code, Some(0), "{log}");
    assert!(log.contains("drive of PROFIDRIVE version 2, PPO 2, ident 0x80D1, at address 8"), "{log}");
}

#[test]
fn what_is_wrong_with_a_drive_is_one_line_and_nothing_is_started() {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let twice = place("twice.csv", "pnu,name,type\n1,a,int16\n1,b,int16\n");
    let tie = place("tie.toml", "[[parameter]]\npnu = 1\nname = \"a\"\ntype = \"int16\"\ntie = \"lod\"\n");
    let zero = place("zero.csv", "pnu,name,type,default,tie\n1,a,int16,0,reference-speed\n");
    let text = place("table.txt", "");
    for (drives, words) in [
        (vec!["7,parameters=/nowhere.csv".to_owned()], "cannot read /nowhere.csv: "),
        (vec![format!("7,parameters={twice}")], "twice.csv: line 3: PNU 1 is in the table twice"),
        (vec![format!("7,parameters={tie}")], "tie.toml: line 5: there is nothing called 'lod'"),
        (vec![format!("7,parameters={zero}")], "PNU 1 a: the drive does not take its default"),
        (vec![format!("7,parameters={text}")], "the name of a table ends in .toml or .csv"),
        (vec!["7".into(), "7".into()], "two drives have address 7; give each drive its own"),
        (vec!["7,ppo=6".into()], "ppo '6' is unknown; expected 1, 2, 3, 4 or 5"),
    ] {
        let mut arguments = vec!["emulate"];
        arguments.extend(drives.iter().flat_map(|drive| ["--ppo-drive", drive]));
        let output = output(&arguments);
        let log = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0), "{log}");
        assert!(log.contains(words), "{log}");
    }
}
