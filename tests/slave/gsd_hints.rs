//! What the author of a device file is told, with the place, and what the reader makes of the line.

use profidrive::gsd::{Gsd, Level, Policy, Station};
use profidrive::profibus::dp::Application as _;

const HEAD: &str =
    "#Profibus_DP\nGSD_Revision=3\nIdent_Number=0x0ABC\n9.6_supp=1\nMaxTsdr_9.6=60\nMax_Diag_Data_Len=8\n";
const MODULE: &str = "Module=\"a\" 0x10\nEndModule\n";

fn read(text: &str) -> Gsd {
    Gsd::read(text.as_bytes()).unwrap()
}

fn warnings(gsd: &Gsd) -> Vec<String> {
    gsd.hints.iter().filter(|hint| hint.level == Level::Warning).map(ToString::to_string).collect()
}

/// Lines behind a head of six, and the warnings.
#[test]
fn each_mistake_of_a_file_is_told_with_its_place() {
    let cases: &[(&str, &[&str])] = &[
        (
            "Vendor_Name=\"no end\nModel_Name=\"M\"\n",
            &["line 7, column 13: warning: the string is not closed in its line; it ends there"],
        ),
        (
            "Max_Module=2\nMax_Module=3\n",
            &["line 8, column 1: warning: Max_Module is there twice; the last one is used"],
        ),
        (
            "Revision 3\nRevision=\"4\"\n",
            &["line 8, column 1: warning: Revision is there twice; the last one is used"],
        ),
        (
            "User_Prm_Data_Len=2\nUser_Prm_Data=1,256\n",
            &[
                "line 7, column 1: warning: User_Prm_Data_Len without User_Prm_Data; read as zeros",
                "line 8, column 1: warning: User_Prm_Data has a value that is no octet; it is ignored",
            ],
        ),
        (
            "User_Prm_Data_Len=3\nUser_Prm_Data=1,2\n",
            &[
                "line 7, column 1: warning: User_Prm_Data_Len is 3, User_Prm_Data has 2 octets; the length is used",
            ],
        ),
        (
            "Max_User_Prm_Data_Len=9\nExt_User_Prm_Data_Ref(0)=4\n",
            &["line 8, column 1: warning: no ExtUserPrmData 4; the reference is ignored"],
        ),
        (
            "Ext_User_Prm_Data_Const(237)=1\n",
            &["line 7, column 1: warning: Ext_User_Prm_Data_Const is behind octet 236; it is ignored"],
        ),
        (
            "Ext_User_Prm_Data_Const(0)=1,300\n",
            &[
                "line 7, column 1: warning: Ext_User_Prm_Data_Const has a value that is no octet; it is ignored",
            ],
        ),
        (
            "Ext_User_Prm_Data_Ref(0)=x\n",
            &["line 7, column 1: warning: Ext_User_Prm_Data_Ref has no number; it is ignored"],
        ),
        (
            "ExtUserPrmData=1 \"q\"\nUnsigned8\nEndExtUserPrmData\n",
            &["line 8, column 1: warning: parameter 'q' has no default; read as 0"],
        ),
        (
            "ExtUserPrmData=1 \"q\"\nUnsigned8 9 1-4\nEndExtUserPrmData\n",
            &["line 8, column 1: warning: parameter 'q': the default 9 is not among 1..4"],
        ),
        (
            "ExtUserPrmData=1 \"q\"\nBitArea(4-8) 1 0-3\nEndExtUserPrmData\n",
            &[
                "line 8, column 1: warning: parameter 'q': bits above 7, read in a word with bit 0 in its last octet",
            ],
        ),
        (
            "ExtUserPrmData=1 \"q\"\nBit(32) 0\nEndExtUserPrmData\n",
            &[
                "line 7, column 1: warning: parameter 'q' has no type; it is ignored",
                "line 8, column 1: warning: Bit names no bits of 0..31; the parameter is ignored",
            ],
        ),
        (
            "ExtUserPrmData=1 \"q\"\nBitArea(3-2) 0\nEndExtUserPrmData\n",
            &[
                "line 7, column 1: warning: parameter 'q' has no type; it is ignored",
                "line 8, column 1: warning: BitArea names no bits of 0..31; the parameter is ignored",
            ],
        ),
        (
            "ExtUserPrmData=1 \"q\"\nVisible=1\nUnsigned8 0\nEndExtUserPrmData\n",
            &["line 8, column 1: warning: Visible is before the type; it is ignored"],
        ),
        (
            "ExtUserPrmData=1 \"q\"\nUnsigned8 0\nPrm_Text_Ref=5\nEndExtUserPrmData\n",
            &["line 1, column 1: warning: the Prm_Text_Ref of parameter 'q' names no PrmText"],
        ),
        (
            "PrmText=1\nText(0)=\"x\"\nEndPrmText\nPrmText=1\nText(0)=\"y\"\nEndPrmText\n",
            &["line 10, column 1: warning: PrmText 1 is there twice; the last one is used"],
        ),
        (
            "ExtUserPrmData=1 \"q\"\nUnsigned8 0\nEndExtUserPrmData\nExtUserPrmData=1 \"r\"\nUnsigned8 0\nEndExtUserPrmData\n",
            &["line 10, column 1: warning: ExtUserPrmData 1 is there twice; the last one is used"],
        ),
        (
            "PrmText=x\nText(0)=\"x\"\nEndPrmText\n",
            &["line 7, column 1: warning: PrmText has no number; read as 0"],
        ),
        (
            "Unit_Diag_Area=9-8\nUnit_Diag_Area_End\n",
            &["line 7, column 1: warning: expected FIRST-LAST bits of the area; the area is ignored"],
        ),
        (
            "Unit_Diag_Bit(0)=\"in the first octet\"\nUnit_Diag_Bit(7)=\"too\"\nUnit_Diag_Bit(8)=\"in the second\"\n",
            &[
                "line 9, column 1: warning: bit 8 needs a diagnosis of 9 octets, Max_Diag_Data_Len is 8: raise it",
            ],
        ),
        ("19.2_supp=1\n", &["line 7, column 1: warning: no MaxTsdr for 19200 bit/s; read as 60 bit times"]),
        (
            "PrmText=1\nText(0)=\"x\"\n",
            &[
                "line 7, column 1: warning: the block that begins here is not closed; it ends where the next one begins",
            ],
        ),
        (
            "Module=\"half\" 0x40\nEndModule\n",
            &[
                "line 7, column 1: warning: the identifiers of module 'half' are incomplete; the module is ignored",
            ],
        ),
        (
            "Module=\"safe\" 0x10\nF_ParamDescCRC=1\nEndModule\n",
            &[
                "line 7, column 1: warning: module 'safe' has PROFIsafe parameters; its safety octets are not emulated",
            ],
        ),
    ];
    for (lines, expected) in cases {
        let gsd = read(&format!("{HEAD}{lines}{MODULE}"));
        assert_eq!(warnings(&gsd), *expected, "{lines}");
        assert_eq!(gsd.modules.last().map(|module| module.name.as_str()), Some("a"), "{lines}");
    }
}

#[test]
fn a_length_of_the_diagnosis_is_read_as_the_nearest_that_there_is() {
    for (written, read_as) in [("5", 6), ("0", 6), ("245", 244), ("1000", 244)] {
        let gsd = read(&format!("{}{MODULE}", HEAD.replace("Len=8", &format!("Len={written}"))));
        let expected = format!(
            "line 6, column 1: warning: Max_Diag_Data_Len is {written}, expected 6..244; read as {read_as}"
        );
        assert_eq!((warnings(&gsd), gsd.max_diag_len), (vec![expected], read_as));
    }
    for whole in [6_u8, 244] {
        let gsd = read(&format!("{}{MODULE}", HEAD.replace("Len=8", &format!("Len={whole}"))));
        assert_eq!((warnings(&gsd), gsd.max_diag_len), (Vec::new(), whole));
    }
}

#[test]
fn a_block_that_the_file_ends_in_is_read_to_there() {
    let gsd = read(&format!("{HEAD}Module=\"a\" 0x10"));
    let words = "line 7, column 1: warning: the block that begins here is not closed; it ends with the file";
    assert_eq!((warnings(&gsd), gsd.modules.len()), (vec![words.to_owned()], 1));
}

#[test]
fn a_file_without_its_revision_or_a_rate_is_read_as_usual() {
    let gsd = read(&format!("#Profibus_DP\nIdent_Number=1\nMax_Diag_Data_Len=6\n{MODULE}"));
    assert_eq!(
        warnings(&gsd),
        [
            "line 1, column 1: warning: no rate of PROFIBUS-DP is offered; read as every rate",
            "line 1, column 1: warning: no GSD_Revision; read as 1",
        ]
    );
}

/// As many fixed modules as there are slots are no contradiction; one more is.
#[test]
fn fixed_modules_may_fill_every_slot() {
    let preset = "Module=\"p\" 0x10\nPreset=1\nEndModule\n";
    let file = |slots: u8| {
        format!("{HEAD}Modular_Station=1\nFixPresetModules=1\nMax_Module={slots}\n{preset}{preset}")
    };
    let station = Station::new(read(&file(2)), Policy::STRICT).unwrap();
    assert_eq!(station.configuration(None), [0x10, 0x10]);
    let refused = Station::new(read(&file(1)), Policy::STRICT).unwrap_err();
    assert_eq!(refused.to_string(), "2 modules are Preset with FixPresetModules, Max_Module is 1; raise it");
}

/// One module that no configuration can have is a mistake of the file; two that fit one at a time are alternatives.
#[test]
fn modules_are_alternatives_only_if_there_are_several() {
    let compact = "Modular_Station=0\nMax_Input_Len=2\nMax_Output_Len=2\nMax_Data_Len=4\n";
    let module = |name: &str| format!("Module=\"{name}\" 0x11\nEndModule\n");
    assert!(!read(&format!("{HEAD}{compact}Module=\"a\" 0x13\nEndModule\n")).is_modular());
    assert!(!read(&format!("{HEAD}{compact}{}", module("a"))).is_modular());
    assert!(read(&format!("{HEAD}{compact}{}{}", module("a"), module("b"))).is_modular());
}

/// The octets of DPV1_Status come first, and are no user parameters of the slave.
#[test]
fn with_dp_v1_the_first_three_user_parameters_are_its_status() {
    let described = |dpv1: u8| {
        let lines = format!("DPV1_Slave={dpv1}\nUser_Prm_Data_Len=5\nUser_Prm_Data=0,0,0,1,2\n{MODULE}");
        let description =
            Station::new(read(&format!("{HEAD}{lines}")), Policy::STRICT).unwrap().description();
        (description.user_prm_len, description.max_user_prm_len)
    };
    assert_eq!(described(0), (5, 5));
    assert_eq!(described(1), (2, 2));
}
