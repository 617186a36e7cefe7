//! `gsd/SIKO0AC5.GSD` says what the slave does: read with an independent parser and compared with the code.

use std::path::{Path, PathBuf};

use gsd_parser::{GenericStationDescription, SupportedSpeeds};
use profidrive::devices::ag03::profibus::{
    CONFIGURATIONS, DEFAULT_APPLICATION_CYCLE, DESCRIPTION, IDENT_NUMBER,
};
use profidrive::profibus::dp;
use profidrive::time::BaudRate;

/// Octets of one Data_Exchange in each direction.
const PPO: u8 = profidrive::profibus::ppo::PPO_LEN as u8;

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
        BaudRate::K31_25 => SupportedSpeeds::B31250,
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
        BaudRate::K31_25 => gsd.max_tsdr.b31250,
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
        let body = line.strip_suffix("\r\n").unwrap_or_else(|| panic!("line {} lacks CRLF", number + 1));
        assert!(body.len() <= 80, "line {} is longer than 80 characters", number + 1);
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
    assert_eq!(gsd.ident_number, IDENT_NUMBER);
    assert_eq!(gsd.gsd_revision, 3);
    assert_eq!(gsd.vendor, "SIKO (emulated)");
    assert_eq!(gsd.model, "AG03, AG03/1 by profidrive");
    assert_eq!(gsd.revision, "V1.0");
    assert_eq!(gsd.hardware_release, "emulated");
    assert_eq!(gsd.software_release, "profidrive");
    assert_eq!(gsd.implementation_type, "software");
    for text in [&gsd.vendor, &gsd.model, &gsd.implementation_type] {
        assert!(text.len() <= 32, "{text:?} is longer than a GSD visible string may be");
    }
    for (name, value) in
        [("Protocol_Ident", "0"), ("Station_Type", "0"), ("FMS_supp", "0"), ("Slave_Family", "1")]
    {
        assert_eq!(keyword(name).as_deref(), Some(value), "{name}");
    }
}

#[test]
fn rates_and_reply_times_are_those_of_the_code() {
    let gsd = parsed();
    for rate in BaudRate::ALL {
        let supported = DESCRIPTION.rates.contains(rate);
        assert_eq!(gsd.supported_speeds.contains(speed_flag(rate)), supported, "{rate}");
        if supported {
            assert_eq!(Some(max_tsdr(&gsd, rate)), DESCRIPTION.rates.max_tsdr(rate), "{rate}");
        }
    }
    assert!(!gsd.supported_speeds.contains(SupportedSpeeds::B31250), "that rate is PROFIBUS-PA");
    assert_eq!(
        text().lines().filter(|line| line.starts_with("MaxTsdr_")).count(),
        DESCRIPTION.rates.iter().count(),
        "every time is written out, none is left to the parser's defaults"
    );
}

#[test]
fn services_are_those_of_the_slave() {
    let gsd = parsed();
    assert_eq!(gsd.freeze_mode_supported, DESCRIPTION.freeze_mode);
    assert_eq!(gsd.sync_mode_supported, DESCRIPTION.sync_mode);
    assert_eq!(gsd.set_slave_addr_supported, DESCRIPTION.set_slave_add);
    assert_eq!(gsd.fail_safe, DESCRIPTION.fail_safe);
    assert!(gsd.auto_baud_supported);
    assert_eq!(gsd.max_diag_data_length, DESCRIPTION.max_diag_len);
    assert_eq!(gsd.unit_diag, gsd_parser::UnitDiag::default(), "six octets leave no room for diagnosis bits");
    for (name, value) in [
        ("DPV1_Slave", "0"),
        ("WD_Base_1ms_supp", "0"),
        ("Redundancy", "0"),
        ("Repeater_Ctrl_Sig", "0"),
        ("24V_Pins", "0"),
    ] {
        assert_eq!(keyword(name).as_deref(), Some(value), "{name}");
    }
    let min_slave_interval: u32 =
        keyword("Min_Slave_Intervall").expect("mandatory").parse().expect("a number");
    assert_eq!(min_slave_interval * 100, DEFAULT_APPLICATION_CYCLE.as_micros() as u32, "in units of 100 us");
}

#[test]
fn set_prm_has_no_user_parameters() {
    let gsd = parsed();
    assert_eq!(keyword("User_Prm_Data_Len"), Some(DESCRIPTION.user_prm_len.to_string()));
    assert_eq!(gsd.user_prm_data.length, DESCRIPTION.user_prm_len);
    assert_eq!(
        gsd_parser::PrmBuilder::new(&gsd.user_prm_data).as_bytes(),
        vec![0; DESCRIPTION.user_prm_len.into()]
    );
    for module in &gsd.available_modules {
        assert_eq!(module.module_prm_data, gsd_parser::UserPrmData::default(), "{}", module.name);
    }
}

#[test]
fn the_one_module_is_the_configuration_the_slave_reports() {
    let gsd = parsed();
    assert!(!gsd.modular_station, "the drive is a compact station");
    let modules: Vec<_> = gsd.available_modules.iter().map(|module| module.config.as_slice()).collect();
    assert_eq!(modules, CONFIGURATIONS[..1]);
}

#[test]
fn lengths_are_those_of_every_configuration_the_slave_accepts() {
    let gsd = parsed();
    assert_eq!((gsd.max_output_length, gsd.max_input_length), (PPO, PPO));
    assert_eq!(gsd.max_data_length, 2 * u16::from(PPO));
    for identifiers in CONFIGURATIONS {
        let lengths = dp::IoLengths::of(identifiers).unwrap();
        assert_eq!((lengths.outputs, lengths.inputs), (PPO, PPO), "{identifiers:02X?}");
    }
}
