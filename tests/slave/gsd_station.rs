//! Stations from device files on the bus: the golden cases of `docs/reference/gsd.md` 8, and the files of `tests/gsd`.

use profidrive::gsd::{CodePage, Gsd, Level, Policy, ReadError, Station};
use profidrive::profibus::dp::{Application, Policy as DpPolicy, State, Station as DpStation};
use profidrive::profibus::fdl::Address;
use profidrive::time::BaudRate;

use crate::slave_line::{Answer, MASTER, SLAVE, SlaveLine};

const HEAD: &str = "#Profibus_DP\nGSD_Revision=3\nVendor_Name=\"T\"\nModel_Name=\"M\"\nRevision=\"1\"\nIdent_Number=0x0ABC\n\
    Protocol_Ident=0\nStation_Type=0\nHardware_Release=\"1\"\nSoftware_Release=\"1\"\n9.6_supp=1\nMaxTsdr_9.6=60\n\
    Min_Slave_Intervall=1\nMax_Diag_Data_Len=8\n";

fn read(lines: &str) -> Gsd {
    Gsd::read(format!("{HEAD}{lines}").as_bytes()).unwrap()
}

fn line(gsd: &Gsd, policy: Policy) -> SlaveLine<Station> {
    let application = Station::new(gsd.clone(), policy).unwrap();
    let description = application.description();
    assert!(description.rates.contains(BaudRate::K9_6));
    // The line of these tests is faster than the device of the reference.
    let description = profidrive::profibus::dp::Description {
        rates: profidrive::profibus::fdl::Rates::CUSTOMARY,
        ..description
    };
    let address = Address::station(SLAVE).unwrap();
    let station = DpStation::new(address, BaudRate::K12000, None, description, application);
    SlaveLine::of(station.with_policy(DpPolicy::PROPOSED))
}

/// What a master gets that sends these user parameters and this configuration.
#[derive(Debug, PartialEq, Eq)]
enum Verdict {
    Ok,
    PrmFault(String),
    CfgFault(String),
}

fn verdict(gsd: &Gsd, policy: Policy, user_prm: &[u8], cfg: &[u8]) -> Verdict {
    let mut line = line(gsd, policy);
    let [high, low] = gsd.ident.to_be_bytes();
    let prm = [&[0x88, 1, 10, 11, high, low, 0][..], user_prm].concat();
    assert_eq!(line.request(MASTER, Some(61), &prm), Answer::Sc);
    let words = |line: &SlaveLine<Station>| line.station.explain(line.events.last().unwrap()).to_string();
    if line.station.slave().state() == State::WaitPrm {
        assert_eq!(line.diagnosis(MASTER)[0] & 0x40, 0x40);
        return Verdict::PrmFault(words(&line));
    }
    assert_eq!(line.request(MASTER, Some(62), cfg), Answer::Sc);
    if line.station.slave().state() == State::DataExch {
        return Verdict::Ok;
    }
    assert_eq!(line.diagnosis(MASTER)[0] & 0x04, 0x04);
    Verdict::CfgFault(words(&line))
}

fn judged(gsd: &Gsd, policy: Policy, user_prm: &[u8], cfg: &[u8]) -> &'static str {
    match verdict(gsd, policy, user_prm, cfg) {
        Verdict::Ok => "ok",
        Verdict::PrmFault(_) => "PF",
        Verdict::CfgFault(_) => "CF",
    }
}

/// Each configuration with what becomes of it, with the default user parameters of no module.
fn configurations(gsd: &Gsd, policy: Policy, rows: &[(&[u8], &str)]) {
    for (cfg, expected) in rows {
        assert_eq!(judged(gsd, policy, &gsd.default_user_prm(&[]), cfg), *expected, "{cfg:02X?}");
    }
}

const MODULES: &str =
    "Module=\"A\" 0x11\nEndModule\nModule=\"AB\" 0x11,0x21\nEndModule\nModule=\"B\" 0x21,0x10\nEndModule\n";
const SPLIT: &str = "Modular_Station=1\nMax_Module=2\nMax_Input_Len=8\nMax_Output_Len=8\nMax_Data_Len=16\n";

#[test]
fn case_1_a_compact_station_has_one_configuration_and_one_length_of_parameters() {
    let gsd = read(
        "Modular_Station=0\nUser_Prm_Data_Len=2\nUser_Prm_Data=0x01,0x02\nModule=\"a\" 0xF3,0xF1\nEndModule\n",
    );
    for (user_prm, expected) in
        [(&[1, 2][..], "ok"), (&[9, 9], "ok"), (&[1], "PF"), (&[1, 2, 3], "PF"), (&[], "PF")]
    {
        assert_eq!(judged(&gsd, Policy::PROPOSED, user_prm, &[0xF3, 0xF1]), expected, "{user_prm:?}");
    }
    configurations(
        &gsd,
        Policy::PROPOSED,
        &[
            (&[0xF3, 0xF1], "ok"),
            (&[0xF3], "CF"),
            (&[0xF1, 0xF3], "CF"),
            (&[0xF3, 0xF1, 0x00], "CF"),
            (&[0x73, 0x71], "CF"),
        ],
    );
}

#[test]
fn case_2_a_compact_station_of_two_modules_is_both_in_order() {
    let gsd = read("Max_Module=2\nModule=\"a\" 0x10\nEndModule\nModule=\"b\" 0x20\nEndModule\n");
    configurations(
        &gsd,
        Policy::PROPOSED,
        &[(&[0x10, 0x20], "ok"), (&[0x20, 0x10], "CF"), (&[0x10], "CF"), (&[0x10, 0x20, 0x10], "CF")],
    );
}

#[test]
fn modules_that_have_more_octets_together_than_a_compact_station_are_alternatives() {
    let modules = "Module=\"16 octets\" 0x3F\nEndModule\nModule=\"12 octets\" 0x3B\nEndModule\n";
    let alternatives = [(&[0x3F][..], "ok"), (&[0x3B], "ok"), (&[0x3F, 0x3B], "CF"), (&[0x3B, 0x3B], "CF")];
    let gsd = read(&format!("Max_Input_Len=20\nMax_Output_Len=20\n{modules}"));
    configurations(&gsd, Policy::PROPOSED, &alternatives);
    let gsd = read(&format!("Max_Input_Len=28\nMax_Output_Len=28\nMax_Data_Len=56\n{modules}"));
    configurations(&gsd, Policy::PROPOSED, &[(&[0x3F, 0x3B], "ok"), (&[0x3F], "CF")]);
}

#[test]
fn case_3_every_split_into_modules_is_found() {
    let gsd = read(&format!("{SPLIT}{MODULES}"));
    configurations(
        &gsd,
        Policy::PROPOSED,
        &[
            (&[0x11], "ok"),
            (&[0x11, 0x11], "ok"),
            (&[0x11, 0x21], "ok"),
            (&[0x11, 0x21, 0x10], "ok"),
            (&[0x11, 0x21, 0x21, 0x10], "ok"),
            (&[0x11, 0x11, 0x11], "CF"),
            (&[0x00, 0x11], "ok"),
            (&[0x11, 0x00, 0x11], "CF"),
            (&[0x21], "CF"),
            (&[], "CF"),
        ],
    );
    configurations(&gsd, Policy::STRICT, &[(&[0x00, 0x11], "CF"), (&[0x11, 0x21, 0x10], "ok")]);
    let station = Station::new(gsd, Policy::PROPOSED).unwrap();
    assert_eq!(station.modules(&[0x11, 0x21, 0x10], None), Ok(vec![vec![0], vec![2]]));
    assert_eq!(station.modules(&[0x11, 0x21, 0x11], None).unwrap()[0], [1], "G-07: the longest first");
    assert_eq!(station.modules(&[0x00, 0x11], None), Ok(vec![vec![], vec![0]]));
}

#[test]
fn case_4_the_sums_of_octets_have_limits() {
    let gsd = read(
        "Modular_Station=1\nMax_Module=4\nMax_Input_Len=4\nMax_Output_Len=4\nMax_Data_Len=6\nModule=\"i4\" 0x13\nEndModule\n\
         Module=\"o4\" 0x23\nEndModule\nModule=\"i2\" 0x11\nEndModule\nModule=\"o2\" 0x21\nEndModule\n",
    );
    configurations(
        &gsd,
        Policy::PROPOSED,
        &[
            (&[0x13, 0x21], "ok"),
            (&[0x13, 0x23], "CF"),
            (&[0x13, 0x11], "CF"),
            (&[0x11, 0x21, 0x11], "ok"),
            (&[0x11, 0x11, 0x11], "CF"),
        ],
    );
}

#[test]
fn case_5_special_identifiers_have_outputs_first_and_are_compared_octet_by_octet() {
    let gsd = read("Module=\"s\" 0xC2,0x01,0x43,0xAA,0xBB\nEndModule\n");
    assert_eq!((gsd.modules[0].lengths.outputs, gsd.modules[0].lengths.inputs), (2, 8));
    configurations(
        &gsd,
        Policy::PROPOSED,
        &[
            (&[0xC2, 0x01, 0x43, 0xAA, 0xBB], "ok"),
            (&[0xC2, 0x43, 0x01, 0xAA, 0xBB], "CF"),
            (&[0xC2, 0x01, 0x43, 0xAA], "CF"),
            (&[0xC2, 0x01, 0x43, 0xAA, 0xBC], "CF"),
        ],
    );
}

#[test]
fn case_6_an_empty_module_takes_its_octets_with_it() {
    let gsd = read(
        "Modular_Station=1\nMax_Module=3\nMax_Input_Len=2\nMax_Output_Len=2\nMax_Data_Len=4\n\
         Module=\"axis\" 0x01,0xFE\nEndModule\nModule=\"io\" 0x30\nEndModule\n",
    );
    configurations(
        &gsd,
        Policy::PROPOSED,
        &[(&[0x30, 0x01, 0xFE, 0x30], "ok"), (&[0x30, 0x01, 0x30], "CF"), (&[0x01, 0xFE], "ok")],
    );
}

const EXTENDED: &str = include_str!("../gsd/extended_prm.gsd");

#[test]
fn case_7_parameters_are_bits_of_octets_with_ranges() {
    let gsd = Gsd::read(EXTENDED.as_bytes()).unwrap();
    let default = [0x80, 0x59, 0xFF, 0xFE];
    assert_eq!(gsd.default_user_prm(&[]), default);
    let field = |id: u32| &gsd.parameters[&id];
    assert_eq!(gsd.text_of(field(1), 1), Some("on"));
    let judge = |policy, octets: &[u8]| judged(&gsd, policy, octets, &[0x10]);
    for (octets, expected) in [
        (&default[..], "ok"),
        (&[0x80, 0x59, 0xFF, 0xFE, 0x00], "ok"),
        (&[0x80, 0x59, 0xFF], "PF"),
        (&[0x80, 0x59, 0xFF, 0xFE, 0x00, 0x00], "PF"),
        (&[0x80, 0x59, 0x00, 0x0B], "ok"),
    ] {
        assert_eq!(judge(Policy::PROPOSED, octets), expected, "{octets:02X?}");
    }
    assert_eq!(judge(Policy::STRICT, &default), "ok");
    let Verdict::PrmFault(words) = verdict(&gsd, Policy::STRICT, &[0x80, 0x59, 0x00, 0x0B], &[0x10]) else {
        panic!("accepted")
    };
    assert!(words.ends_with("Set_Prm octet 10: 0x00: parameter 'Offset' is 11, expected -10..10"), "{words}");
    let station = Station::new(gsd.clone(), Policy::PROPOSED).unwrap();
    let remarks = station.remarks(&[0x10], &[0x80, 0x59, 0x00, 0x0B]);
    assert_eq!(remarks, ["parameter 'Offset' is 11, expected -10..10"]);
}

#[test]
fn case_8_the_parameters_of_modules_follow_those_of_the_station() {
    let gsd = Gsd::read(include_bytes!("../gsd/dpv1.gsd")).unwrap();
    let user_prm = gsd.default_user_prm(&[0, 1, 0]);
    assert_eq!(user_prm, [0, 0, 0, 0xA1, 0xA2, 0xA1, 0xA2]);
    assert_eq!(judged(&gsd, Policy::PROPOSED, &user_prm, &[0x10, 0x20, 0x10]), "ok");
    assert_eq!(judged(&gsd, Policy::STRICT, &user_prm, &[0x10, 0x20, 0x10]), "ok");
    assert_eq!(judged(&gsd, Policy::PROPOSED, &user_prm, &[0x10]), "ok");
    assert_eq!(judged(&gsd, Policy::STRICT, &user_prm, &[0x10]), "CF", "the first request that shows it");
    assert_eq!(judged(&gsd, Policy::PROPOSED, &[0x80, 0, 0], &[0x20]), "ok");
    // Fail_Safe is there and not required: both are right. A base of 1 ms is there, parameter blocks are not.
    assert_eq!(judged(&gsd, Policy::PROPOSED, &[0xC4, 0, 0], &[0x20]), "ok");
    assert_eq!(judged(&gsd, Policy::PROPOSED, &[0x80, 0, 8], &[0x20]), "PF");
    let station = Station::new(gsd, Policy::PROPOSED).unwrap();
    assert_eq!(station.remarks(&[0x10], &user_prm), ["7 octets of user parameters, the modules have 5"]);
}

#[test]
fn case_9_fixed_preset_modules_are_first() {
    let gsd = Gsd::read(include_bytes!("../gsd/preset.gsd")).unwrap();
    configurations(
        &gsd,
        Policy::PROPOSED,
        &[
            (&[0x00, 0x10, 0x21], "ok"),
            (&[0x21], "CF"),
            (&[0x00, 0x10], "ok"),
            (&[0x21, 0x00, 0x10], "CF"),
            (&[0x00, 0x10, 0x21, 0x21, 0x21], "CF"),
        ],
    );
    assert_eq!(Station::new(gsd, Policy::PROPOSED).unwrap().configuration(None), [0x00, 0x10]);
}

#[test]
fn case_10_a_slot_takes_its_modules() {
    let gsd = Gsd::read(include_bytes!("../gsd/slots.gsd")).unwrap();
    configurations(
        &gsd,
        Policy::PROPOSED,
        &[(&[0x10, 0x30], "ok"), (&[0x20, 0x30], "ok"), (&[0x30, 0x30], "CF"), (&[0x10, 0x20], "CF")],
    );
}

#[test]
fn case_11_odd_spellings_are_read() {
    let file = HEAD.replace("#Profibus_DP", "#PROFIBUS_DP ; x");
    let mut file = file.into_bytes();
    file.extend(
        b"24V Pins=0\nMax_Data_len=2\nInfo_Text=\"a;b\\\nc\"\nUnit_Diag_!Bit(0)=\"fine\"\nUnit_Diag_Bit(0010)=\"bad\"\n\
          User_Prm_Data_Len=2\nUser_Prm_Data=1,\\ ; c\n2\nModule=\"gr\xFCn\" 0x10\nEndModule\n",
    );
    let gsd = Gsd::read(&file).unwrap();
    assert_eq!((gsd.info.as_str(), gsd.max_data_len, gsd.code_page), ("a;bc", Some(2), CodePage::Cp1252));
    assert_eq!((gsd.diag_bits[0].bit, gsd.diag_bits[0].inverted), (0, true));
    assert_eq!((gsd.diag_bits[1].bit, gsd.diag_bits[1].inverted), (10, false));
    assert_eq!(gsd.default_user_prm(&[]), [1, 2]);
    assert_eq!(gsd.modules[0].name, "gr\u{fc}n");
    let warnings: Vec<_> =
        gsd.hints.iter().filter(|hint| hint.level == Level::Warning).map(ToString::to_string).collect();
    assert_eq!(
        warnings,
        [
            "line 15, column 1: warning: a blank in the keyword '24V Pins', read as '_'",
            "line 20, column 1: warning: bit 10 needs a diagnosis of 9 octets, Max_Diag_Data_Len is 8: raise it",
        ]
    );
}

#[test]
fn case_12_what_is_no_gsd_of_a_slave_is_refused_with_its_place() {
    for (file, words) in [
        (
            String::new(),
            "line 1, column 1: no line '#Profibus_DP': this is no GSD, or its first line is missing",
        ),
        (
            "[FileInfo]\nFileName=pump.eds\n".to_owned(),
            "line 1, column 1: this is an EDS of a CANopen node, no GSD: use it with --node ID,eds=FILE",
        ),
        (
            HEAD.replace("Ident_Number=0x0ABC\n", ""),
            "line 1, column 1: no Ident_Number of 16 bits: add the one of the device, for example Ident_Number = 0x0ABC",
        ),
        (
            HEAD.replace("Station_Type=0", "Station_Type=1"),
            "line 8, column 1: Station_Type is 1, expected 0: this file describes no slave of PROFIBUS-DP",
        ),
        (
            format!("{HEAD}Module=\"x\" 0xC0,0x01\nEndModule\n"),
            "line 15, column 1: the identifiers of module 'x' are incomplete, and no other module is left: correct them",
        ),
    ] {
        assert_eq!(Gsd::read(file.as_bytes()).unwrap_err().to_string(), words);
    }
    assert_eq!(Gsd::read(b"\xFF\xFE#\0"), Err(ReadError::Utf16));
}

#[test]
fn a_refused_configuration_says_octet_module_expected_and_got() {
    let modular = Gsd::read(include_bytes!("../gsd/modular.gsd")).unwrap();
    let slots = Gsd::read(include_bytes!("../gsd/slots.gsd")).unwrap();
    let preset = Gsd::read(include_bytes!("../gsd/preset.gsd")).unwrap();
    let compact = Gsd::read(include_bytes!("../gsd/compact.gsd")).unwrap();
    for (gsd, user_prm, cfg, words) in [
        (
            &modular,
            &[][..],
            &[0x11, 0x21, 0x20][..],
            "Chk_Cfg octet 3: 0x20: slot 2: no module begins with this; expected '2 inputs', '2 in, 2 out', '2 out, 1 in', 'empty slot'",
        ),
        (
            &modular,
            &[],
            &[0x21, 0x11],
            "Chk_Cfg octet 2: 0x11, expected 0x10: slot 1: no module fits; the nearest module is '2 out, 1 in' (21 10)",
        ),
        (
            &preset,
            &[],
            &[0x00, 0x11],
            "Chk_Cfg octet 2: 0x11, expected 0x10: slot 1: no module fits; the preset module is 'head' (00 10)",
        ),
        (
            &modular,
            &[],
            &[0x11, 0x11, 0x11, 0x11, 0x11],
            "Chk_Cfg octet 5: 0x11: the station takes 4 modules (Max_Module): take the others out",
        ),
        (
            &slots,
            &[],
            &[0x10, 0x20],
            "Chk_Cfg octet 2: 0x20: module 'out' may not be in slot 2 'tail'; expected 'both'",
        ),
        (
            &compact,
            &[1, 2],
            &[0xF3, 0xF5],
            "Chk_Cfg octet 2: 0xF5, expected 0xF1: module 'PPO 1' stands here; the station has the one configuration F3 F1",
        ),
    ] {
        let Verdict::CfgFault(said) = verdict(gsd, Policy::PROPOSED, user_prm, cfg) else {
            panic!("{cfg:02X?}")
        };
        assert!(said.ends_with(words), "{said}");
    }
}

#[test]
fn every_file_of_ours_is_read_without_a_warning_and_brought_up_with_its_defaults() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/gsd");
    let mut revisions = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "gsd") {
            continue;
        }
        let gsd = Gsd::read(&std::fs::read(&path).unwrap()).unwrap();
        let warnings: Vec<_> = gsd.hints.iter().filter(|hint| hint.level == Level::Warning).collect();
        assert!(warnings.is_empty(), "{}: {warnings:?}", path.display());
        revisions.push(gsd.gsd_revision);
        let station = Station::new(gsd.clone(), Policy::STRICT).unwrap();
        let mut cfg = station.configuration(None).to_vec();
        if gsd.model == "Slots" {
            cfg = vec![0x10, 0x30];
        }
        let plugged = station.modules(&cfg, None).unwrap();
        let modules: Vec<_> = plugged.iter().filter_map(|modules| modules.first().copied()).collect();
        let user_prm = gsd.default_user_prm(&modules);
        assert_eq!(verdict(&gsd, Policy::STRICT, &user_prm, &cfg), Verdict::Ok, "{}", path.display());
    }
    revisions.sort_unstable();
    assert_eq!(revisions, [1, 2, 3, 3, 3, 4, 4, 5, 5]);
}

#[test]
fn no_panic_on_any_prefix_or_damage_of_a_file() {
    for file in
        [&include_bytes!("../gsd/unit_diag.gsd")[..], EXTENDED.as_bytes(), include_bytes!("../gsd/slots.gsd")]
    {
        for end in 0..file.len() {
            let _ = Gsd::read(&file[..end])
                .map(|gsd| Station::new(gsd, Policy::PROPOSED).map(|station| station.description()));
            let mut damaged = file.to_vec();
            damaged[end] ^= 1 << (end % 8);
            if let Ok(Ok(station)) = Gsd::read(&damaged).map(|gsd| Station::new(gsd, Policy::PROPOSED)) {
                let _ = station.judge_cfg(&[0x10, 0x30], &[]);
            }
        }
    }
}

#[test]
fn odd_spellings_of_real_files_are_read_without_a_warning() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/gsd/oddities");
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let gsd = Gsd::read(&std::fs::read(&path).unwrap()).unwrap();
        let warnings: Vec<_> = gsd.hints.iter().filter(|hint| hint.level == Level::Warning).collect();
        assert!(warnings.is_empty(), "{}: {warnings:?}", path.display());
        assert_eq!(gsd.modules[0].prm.len, Some(1), "{}: behind a data area in a module", path.display());
        Station::new(gsd, Policy::PROPOSED).unwrap();
    }
}

#[test]
fn a_keyword_that_is_nearly_one_is_asked_about() {
    for (line, words) in [
        ("Max_Modul = 4", "'Max_Modul' is no keyword and has no effect; did you mean Max_Module?"),
        (
            "Modular_Satation = 1",
            "'Modular_Satation' is no keyword and has no effect; did you mean Modular_Station?",
        ),
        (
            "Max_Inputs_Len = 8",
            "'Max_Inputs_Len' is no keyword and has no effect; did you mean Max_Input_Len?",
        ),
        ("Max_Module = four", "Max_Module is no number; it is left out"),
        ("Max_Module = 0", "Max_Module is 0, expected 1 or more"),
        ("Max_Input_Len = 0", "module 'a' has 1 octets, Max_Input_Len is 0: it cannot be configured"),
        ("Failsafe = 1", "'Failsafe' is no keyword and has no effect; did you mean Fail_Safe?"),
        ("Prm_Text_Ref = 1", "'Prm_Text_Ref' has no effect outside of its block"),
        (
            "ExtUserPrmData = 1 \"q\"\nUnsigned8 1 4-1\nEndExtUserPrmData",
            "parameter 'q': no value lies between the limits 4 and 1",
        ),
    ] {
        let gsd = read(&format!("{line}\nModule=\"a\" 0x10\nEndModule\n"));
        let warnings: Vec<_> = gsd.hints.iter().filter(|hint| hint.level == Level::Warning).collect();
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        assert_eq!(warnings[0].text, words);
    }
    // What makers add of their own is a note.
    let gsd = read("DS248_FCT = 1\nIsMaster = 0\nETERDelay = 3\n");
    assert!(gsd.hints.iter().all(|hint| hint.level == Level::Note), "{:?}", gsd.hints);
}

#[test]
fn a_layout_tells_slots_octets_and_identifiers() {
    let gsd = Gsd::read(include_bytes!("../gsd/modular.gsd")).unwrap();
    let station = Station::new(gsd, Policy::PROPOSED).unwrap();
    let layout = station.layout(&[0x21, 0x10, 0x00, 0x11, 0x11, 0x21], None);
    let rows: Vec<_> = layout
        .iter()
        .map(|placed| {
            let slot = &placed.slot;
            (
                slot.number,
                placed.names(station.gsd())[0],
                placed.identifiers.clone(),
                slot.inputs.clone(),
                slot.outputs.clone(),
            )
        })
        .collect();
    assert_eq!(
        rows,
        [
            (1, "2 out, 1 in", 0..2, 0..1, 0..2),
            (2, "empty slot", 2..3, 1..1, 2..2),
            (3, "2 inputs", 3..4, 1..3, 2..2),
            (4, "2 in, 2 out", 4..6, 3..5, 2..4),
        ]
    );
    assert!(station.layout(&[0x20], None).is_empty());
}
