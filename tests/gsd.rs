//! `gsd/SIKO0AC5.GSD` says what the slave does: read with an independent parser and compared with the code.

use std::path::{Path, PathBuf};

use gsd_parser::{GenericStationDescription, SupportedSpeeds};
use profidrive::time::BaudRate;

/// What the emulated drive does, in one place.
///
/// TO SWAP: replace the right-hand sides by the constants of `profidrive::device` once they exist. Everything the
/// tests below compare with the GSD is named here and nowhere else (rates and T_SDR come from `profidrive::time`).
mod device {
    use profidrive::time::BaudRate;

    /// Ident_Number of both drives (`ag03.md` 1).
    pub(crate) const IDENT_NUMBER: u16 = 0x0AC5;
    /// Chk_Cfg strings the slave accepts, the default first (`ag03.md` 16).
    pub(crate) const CONFIGURATIONS: [&[u8]; 2] = [&[0xF3, 0xF2], &[0xF6]];
    /// Octets from the master in one Data_Exchange.
    pub(crate) const OUTPUT_LEN: u8 = 14;
    /// Octets to the master in one Data_Exchange.
    pub(crate) const INPUT_LEN: u8 = 14;
    /// Octets of user parameters after the seven fixed ones of Set_Prm.
    pub(crate) const USER_PRM_LEN: u8 = 0;
    /// Octets of a Slave_Diag reply (`ag03.md` 12).
    pub(crate) const DIAG_LEN: u8 = 6;
    /// The application cycle a drive has by default, in microseconds.
    pub(crate) const APPLICATION_CYCLE_MICROS: u32 = 1_000;
    /// An empty Data_Exchange is a wrong length, not the order to take the safe state.
    pub(crate) const FAIL_SAFE: bool = false;
    /// Set_Slave_Add is answered with RS.
    pub(crate) const SET_SLAVE_ADD: bool = false;
    /// Global_Control Freeze and Sync are carried out.
    pub(crate) const FREEZE_AND_SYNC: bool = true;
    /// The rates the drive finds by itself (manual 7.2).
    pub(crate) fn supports(rate: BaudRate) -> bool {
        rate != BaudRate::K45_45
    }
}

fn path() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("gsd/SIKO0AC5.GSD")
}

fn text() -> String {
    std::fs::read_to_string(path()).expect("the GSD is plain ASCII text")
}

fn parsed() -> GenericStationDescription {
    gsd_parser::parser::parse(&path(), &text()).unwrap_or_else(|error| panic!("{error}"))
}

/// The value of a keyword the parser drops, as written.
fn keyword(name: &str) -> Option<String> {
    text().lines().find_map(|line| {
        let (key, value) = line.split(';').next()?.split_once('=')?;
        (key.trim() == name).then(|| value.trim().to_owned())
    })
}

fn speed_flag(rate: BaudRate) -> SupportedSpeeds {
    match rate {
        BaudRate::K9_6 => SupportedSpeeds::B9600,
        BaudRate::K19_2 => SupportedSpeeds::B19200,
        BaudRate::K45_45 => SupportedSpeeds::B45450,
        BaudRate::K93_75 => SupportedSpeeds::B93750,
        BaudRate::K187_5 => SupportedSpeeds::B187500,
        BaudRate::K500 => SupportedSpeeds::B500000,
        BaudRate::K1500 => SupportedSpeeds::B1500000,
        BaudRate::K3000 => SupportedSpeeds::B3000000,
        BaudRate::K6000 => SupportedSpeeds::B6000000,
        BaudRate::K12000 => SupportedSpeeds::B12000000,
    }
}

fn max_tsdr(gsd: &GenericStationDescription, rate: BaudRate) -> u16 {
    match rate {
        BaudRate::K9_6 => gsd.max_tsdr.b9600,
        BaudRate::K19_2 => gsd.max_tsdr.b19200,
        BaudRate::K45_45 => gsd.max_tsdr.b45450,
        BaudRate::K93_75 => gsd.max_tsdr.b93750,
        BaudRate::K187_5 => gsd.max_tsdr.b187500,
        BaudRate::K500 => gsd.max_tsdr.b500000,
        BaudRate::K1500 => gsd.max_tsdr.b1500000,
        BaudRate::K3000 => gsd.max_tsdr.b3000000,
        BaudRate::K6000 => gsd.max_tsdr.b6000000,
        BaudRate::K12000 => gsd.max_tsdr.b12000000,
    }
}

#[test]
fn the_file_follows_the_habits_of_gsd_files() {
    let text = text();
    assert!(text.is_ascii(), "configurators read Latin-1 at best");
    for (number, line) in text.split_inclusive('\n').enumerate() {
        let body = line
            .strip_suffix("\r\n")
            .unwrap_or_else(|| panic!("line {} lacks CRLF", number + 1));
        assert!(
            body.len() <= 80,
            "line {} is longer than 80 characters",
            number + 1
        );
    }
    let keywords: Vec<_> = text
        .lines()
        .filter_map(|line| line.split(';').next()?.split_once('='))
        .map(|(key, _)| key.trim())
        .filter(|key| !["Module", "Info_Text"].contains(key))
        .collect();
    for (at, key) in keywords.iter().enumerate() {
        assert!(!keywords[..at].contains(key), "{key} is written twice");
    }
}

#[test]
fn identity() {
    let gsd = parsed();
    assert_eq!(gsd.ident_number, device::IDENT_NUMBER);
    assert_eq!(gsd.gsd_revision, 3);
    assert_eq!(gsd.vendor, "SIKO (emulated)");
    assert_eq!(gsd.model, "AG03, AG03/1 by profidrive");
    assert_eq!(gsd.revision, "V1.0");
    assert_eq!(gsd.hardware_release, "emulated");
    assert_eq!(gsd.software_release, "profidrive");
    assert_eq!(gsd.implementation_type, "software");
    for text in [&gsd.vendor, &gsd.model, &gsd.implementation_type] {
        assert!(
            text.len() <= 32,
            "{text:?} is longer than a GSD visible string may be"
        );
    }
    for (name, value) in [
        ("Protocol_Ident", "0"),
        ("Station_Type", "0"),
        ("FMS_supp", "0"),
        ("Slave_Family", "1"),
    ] {
        assert_eq!(keyword(name).as_deref(), Some(value), "{name}");
    }
}

#[test]
fn rates_and_reply_times_are_those_of_the_code() {
    let gsd = parsed();
    for rate in BaudRate::ALL {
        let supported = device::supports(rate);
        assert_eq!(
            gsd.supported_speeds.contains(speed_flag(rate)),
            supported,
            "{rate}"
        );
        if supported {
            assert_eq!(max_tsdr(&gsd, rate), rate.max_tsdr_bits(), "{rate}");
        }
    }
    assert!(
        !gsd.supported_speeds.contains(SupportedSpeeds::B31250),
        "that rate is PROFIBUS-PA"
    );
    assert_eq!(
        text().lines().filter(|line| line.starts_with("MaxTsdr_")).count(),
        BaudRate::ALL
            .into_iter()
            .filter(|&rate| device::supports(rate))
            .count(),
        "every time is written out, none is left to the parser's defaults"
    );
}

#[test]
fn services_are_those_of_the_slave() {
    let gsd = parsed();
    assert_eq!(gsd.freeze_mode_supported, device::FREEZE_AND_SYNC);
    assert_eq!(gsd.sync_mode_supported, device::FREEZE_AND_SYNC);
    assert_eq!(gsd.set_slave_addr_supported, device::SET_SLAVE_ADD);
    assert_eq!(gsd.fail_safe, device::FAIL_SAFE);
    assert!(gsd.auto_baud_supported);
    assert_eq!(gsd.max_diag_data_length, device::DIAG_LEN);
    assert_eq!(
        gsd.unit_diag,
        gsd_parser::UnitDiag::default(),
        "six octets leave no room for diagnosis bits"
    );
    for (name, value) in [
        ("DPV1_Slave", "0"),
        ("Redundancy", "0"),
        ("Repeater_Ctrl_Sig", "0"),
        ("24V_Pins", "0"),
    ] {
        assert_eq!(keyword(name).as_deref(), Some(value), "{name}");
    }
    let min_slave_interval: u32 = keyword("Min_Slave_Intervall")
        .expect("mandatory")
        .parse()
        .expect("a number");
    assert_eq!(
        min_slave_interval * 100,
        device::APPLICATION_CYCLE_MICROS,
        "in units of 100 us"
    );
}

#[test]
fn set_prm_has_no_user_parameters() {
    let gsd = parsed();
    assert_eq!(
        keyword("User_Prm_Data_Len"),
        Some(device::USER_PRM_LEN.to_string())
    );
    assert_eq!(gsd.user_prm_data.length, device::USER_PRM_LEN);
    assert_eq!(
        gsd_parser::PrmBuilder::new(&gsd.user_prm_data).as_bytes(),
        [0; device::USER_PRM_LEN as usize]
    );
    for module in &gsd.available_modules {
        assert_eq!(
            module.module_prm_data,
            gsd_parser::UserPrmData::default(),
            "{}",
            module.name
        );
    }
}

#[test]
fn modules_are_the_configurations_the_slave_accepts() {
    let gsd = parsed();
    assert!(gsd.modular_station);
    assert_eq!(gsd.max_modules, 1);
    assert_eq!(gsd.max_input_length, device::INPUT_LEN);
    assert_eq!(gsd.max_output_length, device::OUTPUT_LEN);
    assert_eq!(
        gsd.max_data_length,
        u16::from(device::INPUT_LEN) + u16::from(device::OUTPUT_LEN)
    );

    let modules: Vec<_> = gsd
        .available_modules
        .iter()
        .map(|module| module.config.as_slice())
        .collect();
    assert_eq!(modules, device::CONFIGURATIONS);
    let references: Vec<_> = gsd
        .available_modules
        .iter()
        .map(|module| module.reference)
        .collect();
    assert_eq!(references, [Some(1), Some(2)]);

    // `Preset` is what makes the first module the default; the parser drops it.
    let text = text();
    let preset = text.find("Preset = 1").expect("one module is preset");
    let ends: Vec<_> = text.match_indices("EndModule").map(|(at, _)| at).collect();
    assert!(preset < ends[0], "the preset module is the first");
    assert_eq!(text.matches("Preset =").count(), 1);
}

#[test]
fn every_module_carries_seven_words_both_ways() {
    for module in &parsed().available_modules {
        let octets: u8 = module
            .config
            .iter()
            .map(|&identifier| {
                // dp-v0.md 6.1, general format: b7 whole consistency, b6 words, b5..b4 in and out, b3..b0 length - 1.
                assert_eq!(
                    identifier & 0xF0,
                    0xF0,
                    "{}: consistent words in and out",
                    module.name
                );
                ((identifier & 0x0F) + 1) * 2
            })
            .sum();
        assert_eq!(
            (octets, octets),
            (device::INPUT_LEN, device::OUTPUT_LEN),
            "{}",
            module.name
        );
    }
}
