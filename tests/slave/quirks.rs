//! The quirks: every one is documented, and those of the bus have both their values tried.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::time::Duration;

use profidrive::devices::ag03;
use profidrive::devices::ag03::param::Model;
use profidrive::devices::ag03::profibus::{Config, DipSwitches, QUIRKS, Timing};
use profidrive::devices::ap10;
use profidrive::devices::asda_a2;
use profidrive::face::Quirk;
use profidrive::profibus::fdl::Address;

use crate::drive_line;
use crate::drive_line::Line;

/// A drive in Data_Exchange with a quirk.
struct Drive {
    line: Line,
    stw: u16,
}

impl Drive {
    fn with(model: Model, quirk: &str, value: &str) -> Self {
        let mut config = Config { model, timing: Timing::True, ..Config::new(Address::station(5).unwrap()) };
        config.set_quirk(quirk, value).unwrap();
        let mut line = Line::with(config);
        line.start_up();
        Self { line, stw: 0 }
    }

    /// Job words in, reply words out.
    fn job(&mut self, text: &str) -> String {
        let mut outputs = drive_line::hex(
            &text
                .replace(' ', "")
                .as_bytes()
                .chunks(2)
                .fold(String::new(), |text, octet| text + std::str::from_utf8(octet).unwrap() + " "),
        );
        outputs.extend(self.stw.to_be_bytes());
        outputs.extend([0; 4]);
        self.line.exchange(&outputs);
        self.line.wait(Duration::from_millis(3));
        let inputs = self.line.exchange(&outputs);
        let word = |n: usize| u16::from_be_bytes([inputs[2 * n], inputs[2 * n + 1]]);
        format!("{:04X} {:04X} {:04X} {:04X}", word(0), word(1), word(2), word(3))
    }

    fn zsw(&mut self, stw: u16) -> u16 {
        self.stw = stw;
        self.job("0000 0000 0000 0000");
        let inputs = self.line.exchange(&[&[0; 8], &stw.to_be_bytes()[..], &[0; 4]].concat());
        u16::from_be_bytes([inputs[8], inputs[9]])
    }
}

/// One job under each value of a quirk of the parameter channel or the parameters.
#[test]
fn each_value_of_a_quirk_of_the_parameters_has_its_reply() {
    for (id, model, job, replies) in [
        (
            "C-01 i-gain",
            Model::Ag03_1,
            "23E9 0000 0000 0000",
            &[("0", "13E9 0000 0000 0000"), ("1", "73E9 0000 0000 0002")][..],
        ),
        (
            "C-01 i-gain",
            Model::Ag03,
            "23E9 0000 0000 0000",
            &[("0", "13E9 0000 0000 0000"), ("1", "13E9 0000 0000 0000")],
        ),
        (
            "C-02 acceleration",
            Model::Ag03,
            "23EB 0000 0000 0000",
            &[("0", "13EB 0000 0000 0000"), ("1", "73EB 0000 0000 0002")],
        ),
        (
            "C-02 acceleration",
            Model::Ag03_1,
            "23EB 0000 0000 0000",
            &[("0", "73EB 0000 0000 0002"), ("1", "73EB 0000 0000 0002")],
        ),
        (
            "C-14 subindex",
            Model::Ag03,
            "63B1 0A00 0000 0000",
            &[
                ("high-else-low", "73B1 0A00 0000 0003"),
                ("high", "73B1 0A00 0000 0003"),
                ("low", "43B1 0A00 0000 0000"),
            ],
        ),
        (
            "C-14 subindex",
            Model::Ag03,
            "63B1 000A 0000 0000",
            &[
                ("high-else-low", "73B1 000A 0000 0003"),
                ("high", "43B1 000A 0000 0000"),
                ("low", "73B1 000A 0000 0003"),
            ],
        ),
        (
            "C-15 load-reply",
            Model::Ag03_1,
            "23CA 0000 0000 0005",
            &[("double-word", "23CA 0000 0000 0000"), ("word", "13CA 0000 0000 0000")],
        ),
        (
            "C-15 load-reply",
            Model::Ag03,
            "23CA 0000 0000 0005",
            &[("double-word", "13CA 0000 0000 0000"), ("word", "13CA 0000 0000 0000")],
        ),
        (
            "C-16 plain-array-read",
            Model::Ag03,
            "13B1 0000 0000 0000",
            &[("refuse", "73B1 0000 0000 0005"), ("element", "43B1 0000 0000 0000")],
        ),
        (
            "C-17 read-970",
            Model::Ag03,
            "13CA 0000 0000 0000",
            &[("0", "13CA 0000 0000 0000"), ("refuse", "73CA 0000 0000 0012")],
        ),
    ] {
        let (register, name) = id.split_once(' ').unwrap();
        assert_eq!(QUIRKS.iter().find(|quirk| quirk.name == name).unwrap().register, register);
        for (value, reply) in replies {
            assert_eq!(Drive::with(model, name, value).job(job), *reply, "{model}, {id}={value}");
        }
    }
}

#[test]
fn quirk_c03_bit_14_of_zsw_in_velocity_mode() {
    for (value, bit) in [("0", 0), ("1", 0x4000)] {
        let mut drive = Drive::with(Model::Ag03_1, "velocity-zsw14", value);
        assert_eq!(drive.zsw(0x000B) & 0x4000, 0, "positioning");
        drive.zsw(0x0000);
        drive.job("23A2 0000 0000 0001");
        assert_eq!(drive.zsw(0x0000) & 0xFE6F, 0x3E23 | bit);
        assert_eq!(drive.zsw(0x000B) & 0xFE7F, 0xBE37 | bit);
    }
}

#[test]
fn quirk_c19_calibration_by_command_only_or_by_the_value_too() {
    for (value, position) in [("command", "240C 0000 0000 0000"), ("value", "240C 0000 0000 03E8")] {
        let mut drive = Drive::with(Model::Ag03_1, "calibration", value);
        assert_eq!(drive.job("33FA 0000 0000 03E8"), "23FA 0000 0000 03E8");
        assert_eq!(drive.job("140C 0000 0000 0000"), position, "{value}");
        assert_eq!(drive.job("23CA 0000 0000 0005"), "23CA 0000 0000 0000");
        assert_eq!(drive.job("140C 0000 0000 0000"), "240C 0000 0000 03E8");
        drive.stw = 0x003B;
        drive.job("0000 0000 0000 0000");
        drive.stw = 0x007B;
        drive.job("0000 0000 0000 0000");
        let refused = drive.job("33FA 0000 0000 0000").starts_with("73FA 0000 0000 0011");
        assert_eq!(refused, value == "value", "during a travel job");
    }
}

#[test]
fn quirk_c21_bit_2_of_stw_is_ignored_or_takes_operation_enabled_away() {
    for (value, enabled) in [("ignored", 0x0004), ("must-be-0", 0)] {
        let mut drive = Drive::with(Model::Ag03_1, "stw2", value);
        assert_eq!(drive.zsw(0x000F) & 0x0004, enabled);
        assert_eq!(drive.zsw(0x000B) & 0x0004, 0x0004);
        assert_eq!(drive.zsw(0x000F) & 0x0004, enabled);
    }
}

#[test]
fn a_quirk_of_the_drive_reaches_it() {
    for (value, standing) in [("release", 0x0010), ("brake", 0)] {
        let mut drive = Drive::with(Model::Ag03_1, "off1", value);
        for stw in [0x003B, 0x020B] {
            drive.zsw(stw);
        }
        drive.line.wait(Duration::from_secs(1));
        drive.zsw(0x000A);
        drive.line.wait(Duration::from_millis(200));
        let ssw = drive.line.device.system_status();
        assert_eq!(ssw & 0x0010, standing, "{value}: it turns for 125 or 500 ms");
    }
}

#[test]
fn quirk_reset_patterns_decides_which_switches_ask_for_a_factory_reset() {
    use profidrive::devices::ag03::param::DefaultSet;
    let requested = |value: &str, number: u16| {
        let mut config = Config::new(Address::station(5).unwrap());
        config.set_quirk("reset-patterns", value).unwrap();
        config.reset_patterns.requested(DipSwitches::from_bits(number).with_reset(true))
    };
    for (value, controller, nothing) in [("command", 3, 4), ("one-switch", 4, 3)] {
        assert_eq!(requested(value, 1), Some(DefaultSet::All), "{value}");
        assert_eq!(requested(value, 2), Some(DefaultSet::Standard), "{value}");
        assert_eq!(requested(value, controller), Some(DefaultSet::Controller), "{value}");
        assert_eq!(requested(value, nothing), None, "{value}");
    }
}

#[test]
fn the_document_lists_the_quirks_of_the_code_and_no_other() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/quirks.md");
    let text = fs::read_to_string(path).unwrap();
    let rows = text.lines().filter(|line| line.starts_with("| `"));
    let documented: BTreeSet<[String; 3]> = rows
        .map(|line| {
            let cells: Vec<_> = line.trim_matches('|').split(" | ").map(str::trim).collect();
            let plain = |cell: &str| cell.replace('`', "");
            [plain(cells[0]), plain(cells[1]), plain(cells[2])]
        })
        .collect();
    fn of<C>(quirks: &[Quirk<C>]) -> impl Iterator<Item = [String; 3]> + '_ {
        quirks.iter().map(|quirk| [quirk.name.into(), quirk.register.into(), quirk.values.join(", ")])
    }
    let known = of(QUIRKS)
        .chain(of(ag03::canopen::QUIRKS))
        .chain(of(ap10::canopen::QUIRKS))
        .chain(of(asda_a2::canopen::QUIRKS));
    assert_eq!(documented, known.collect());
}
