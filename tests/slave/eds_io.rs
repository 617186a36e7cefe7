//! Inputs and outputs of CiA 401 that a file describes, as a master sees them (`eds.md` 4, E-61 and E-62).
#![cfg(feature = "eds")]

use std::time::Duration;

use profidrive::devices::CanopenDevice;
use profidrive::face::surroundings::Level;

use crate::file_node::{NODE, Rig, array, pdo, var};

const U8: u16 = 5;
const U32: u16 = 7;
const I16: u16 = 3;
const I32: u16 = 4;

/// Sixteen inputs, sixteen outputs, two analogue inputs and outputs, each with all that the profile has for it.
fn station(more: &str) -> Rig {
    let text = var(0x1000, U32, "ro", "DefaultValue=0x000F0191")
        + &array(0x1016, U32, "rw", &["0"])
        + &pdo(0x1400, "$NODEID+0x200", 255, &["0x62000108", "0x62000208", "0x64110110"])
        + &pdo(0x1800, "$NODEID+0x180", 255, &["0x60000108", "0x60000208"])
        + &pdo(0x1801, "$NODEID+0x280", 255, &["0x64010110", "0x64010210"])
        + &array(0x6000, U8, "ro", &["", ""])
        + &array(0x6002, U8, "rw", &["", ""])
        + &array(0x6003, U8, "rw", &["", ""])
        + &var(0x6005, 1, "rw", "")
        + &array(0x6006, U8, "rw", &["", ""])
        + &array(0x6007, U8, "rw", &["", ""])
        + &array(0x6008, U8, "rw", &["", ""])
        + &array(0x6200, U8, "rw", &["", ""])
        + &array(0x6202, U8, "rw", &["", ""])
        + &array(0x6206, U8, "rw", &["0xF0", "0"])
        + &array(0x6207, U8, "rw", &["0xA0", "0xFF"])
        + &array(0x6208, U8, "rw", &["", ""])
        + &array(0x6401, I16, "ro", &["", ""])
        + &array(0x6411, I16, "rw", &["", ""])
        + &array(0x6421, U8, "rw", &["", ""])
        + &array(0x6422, U32, "ro", &[""])
        + &var(0x6423, 1, "rw", "")
        + &array(0x6424, I32, "rw", &["", ""])
        + &array(0x6425, I32, "rw", &["", ""])
        + &array(0x6426, U32, "rw", &["", ""])
        + &array(0x6443, U8, "rw", &["1", "0"])
        + &array(0x6444, I32, "rw", &["-5", "7"])
        + more;
    Rig::text(&text)
}

fn level(rig: &mut Rig, name: &str, number: f64) -> Vec<String> {
    rig.set(name, Level::Number(number))
}

fn shown(rig: &Rig, key: &str) -> Option<f64> {
    let mut found = None;
    rig.device.description().each_value(&mut |value| {
        if value.key == key {
            found = value.amount.number();
        }
    });
    found
}

#[test]
fn eds_61_each_change_of_an_input_is_sent_without_a_line_of_configuration() {
    let mut rig = station("");
    assert_eq!(rig.start(), ["185#0000", "285#00000000"]);
    assert_eq!(level(&mut rig, "6000h:01", 5.0), ["185#0500"]);
    assert_eq!(level(&mut rig, "6000h:01", 5.0), [""; 0]);
    assert_eq!(level(&mut rig, "6000h:02", 255.0), ["185#05FF"]);
    assert_eq!(rig.read(0x6000, 2), Ok(vec![255]));
    assert_eq!(rig.write(0x6000, 1, &[1]), Err(0x0601_0002));
    // Defaults of the profile where the file has none.
    assert_eq!(
        [(0x6005, 0), (0x6006, 2), (0x6007, 1), (0x6208, 1), (0x6421, 2)]
            .map(|(index, sub)| rig.number(index, sub)),
        [1, 255, 0, 255, 7]
    );
}

#[test]
fn eds_61_masks_and_the_global_enable_decide_which_changes_are_events() {
    let mut rig = station("");
    rig.write(0x6006, 1, &[0b0000_0001]).unwrap();
    rig.write(0x6007, 1, &[0b0000_0010]).unwrap();
    rig.write(0x6008, 1, &[0b0000_0100]).unwrap();
    rig.start();
    for (levels, sent) in [
        (0b0001_u8, &["185#0100"][..]),
        (0b0000, &["185#0000"]),
        (0b0010, &["185#0200"]),
        (0b0000, &[]),
        (0b0100, &[]),
        // The falling edge is an event though its value is that of the last frame.
        (0b0000, &["185#0000"]),
        (0b1000, &[]),
    ] {
        assert_eq!(level(&mut rig, "6000h:01", levels.into()), sent, "{levels:04b}");
        assert_eq!(rig.number(0x6000, 1), u32::from(levels));
    }
    rig.write(0x6005, 0, &[0]).unwrap();
    assert_eq!(level(&mut rig, "6000h:01", 1.0), [""; 0]);
    rig.write(0x6005, 0, &[1]).unwrap();
    assert_eq!(level(&mut rig, "6000h:01", 0.0), ["185#0000"]);
}

#[test]
fn eds_61_polarity_inverts_inputs_and_a_filter_holds_them_back() {
    let mut rig = station("");
    rig.start();
    assert_eq!(rig.write(0x6002, 1, &[0x0F]), Ok(()));
    assert_eq!(rig.number(0x6000, 1), 0x0F);
    assert_eq!(level(&mut rig, "6000h:01", 1.0), ["185#0E00"]);
    rig.write(0x6002, 1, &[0]).unwrap();
    rig.write(0x6003, 1, &[0x02]).unwrap();
    assert_eq!(level(&mut rig, "6000h:01", f64::from(0b101)), ["185#0500"], "not filtered");
    assert_eq!(level(&mut rig, "6000h:01", f64::from(0b111)), [""; 0]);
    rig.pass(Duration::from_millis(9));
    assert_eq!(rig.number(0x6000, 1), 0b101);
    assert_eq!(level(&mut rig, "6000h:01", f64::from(0b101)), [""; 0], "too short");
    assert_eq!(level(&mut rig, "6000h:01", f64::from(0b111)), [""; 0]);
    assert_eq!(rig.pass(Duration::from_millis(10)), ["185#0700"]);
}

#[test]
fn eds_61_objects_of_other_widths_show_the_same_lines() {
    let more = array(0x6020, 1, "ro", &[""; 16])
        + &array(0x6100, 6, "ro", &[""])
        + &array(0x6220, 1, "rw", &[""; 16])
        + &array(0x6300, 6, "rw", &[""]);
    let mut rig = station(&more);
    level(&mut rig, "6000h:02", 1.0);
    assert_eq!((rig.number(0x6100, 1), rig.number(0x6020, 9), rig.number(0x6020, 8)), (0x100, 1, 0));
    rig.set("6020h:01", Level::Switch(true));
    assert_eq!((rig.number(0x6000, 1), rig.number(0x6100, 1)), (1, 0x101));
    rig.write(0x6220, 16, &[1]).unwrap();
    rig.write(0x6200, 1, &[0x55]).unwrap();
    assert_eq!((rig.number(0x6300, 1), rig.number(0x6220, 1)), (0x8055, 1));
}

#[test]
fn eds_61_outputs_follow_rpdo_and_sdo_through_their_filter_mask() {
    let mut rig = station("");
    rig.start();
    rig.data(0x205, &[0x81, 0x18, 0xFE, 0xFF]);
    assert_eq!((rig.number(0x6200, 1), rig.number(0x6200, 2), rig.number(0x6411, 1)), (0x81, 0x18, 0xFFFE));
    rig.write(0x6208, 1, &[0x0F]).unwrap();
    rig.write(0x6200, 1, &[0x7E]).unwrap();
    assert_eq!(rig.number(0x6200, 1), 0x8E);
    rig.write(0x6202, 1, &[0xFF]).unwrap();
    assert_eq!(rig.number(0x6200, 1), 0x8E, "E-62");
    assert_eq!(shown(&rig, "6200h:01"), Some(f64::from(0x71)), "at the terminals");
}

#[test]
fn eds_62_outputs_take_their_error_values_where_the_error_mode_says_so() {
    let stop = |rig: &mut Rig| {
        rig.data(0, &[2, NODE]);
    };
    let silence = |rig: &mut Rig| {
        rig.data(0x711, &[5]);
        rig.pass(Duration::from_millis(60));
    };
    for (name, fail) in [("STOPPED", &stop as &dyn Fn(&mut Rig)), ("heartbeat", &silence)] {
        let mut rig = station("");
        rig.write(0x1016, 1, &0x0011_0032_u32.to_le_bytes()).unwrap();
        rig.write(0x6202, 1, &[0xFF]).unwrap();
        rig.start();
        rig.data(0x205, &[0x55, 0x18, 100, 0]);
        rig.write(0x6411, 2, &[100, 0]).unwrap();
        fail(&mut rig);
        assert_eq!(shown(&rig, "6200h:01"), Some(f64::from(0xAA)), "{name}: four failed, four are inverted");
        rig.data(0, &[0x80, NODE]);
        assert_eq!((rig.number(0x6200, 1), rig.number(0x6200, 2)), (0xA5, 0x18), "{name}");
        assert_eq!((rig.number(0x6411, 1), rig.number(0x6411, 2)), (0xFFFB, 100), "{name}");
        rig.write(0x6200, 1, &[0xA5]).unwrap();
        assert_eq!(shown(&rig, "6200h:01"), Some(f64::from(0x5A)), "{name}: written anew");
        rig.data(0, &[0x81, NODE]);
        assert_eq!(rig.number(0x6200, 1), 0, "{name}");
    }
}

#[test]
fn eds_61_analogue_inputs_are_sent_as_6421h_to_6426h_say() {
    let mut rig = station("");
    rig.start();
    assert_eq!(level(&mut rig, "6401h:01", 500.0), [""; 0], "6423h is FALSE by its default");
    rig.write(0x6423, 0, &[1]).unwrap();
    assert_eq!(level(&mut rig, "6401h:01", 501.0), ["285#F5010000"]);
    rig.write(0x6424, 1, &1000_i32.to_le_bytes()).unwrap();
    rig.write(0x6425, 1, &(-1000_i32).to_le_bytes()).unwrap();
    rig.write(0x6426, 1, &50_u32.to_le_bytes()).unwrap();
    for (value, sent) in [
        (900.0, &[][..]),
        (1000.0, &["285#E8030000"]),
        (1050.0, &[]),
        (1051.0, &["285#1B040000"]),
        (-1000.0, &[]),
        (-1001.0, &["285#17FC0000"]),
    ] {
        assert_eq!(level(&mut rig, "6401h:01", value), sent, "{value}");
    }
    assert_eq!(rig.number(0x6422, 1), 1, "channel 1 had events");
    assert_eq!(rig.number(0x6422, 1), 0, "since it was read");
    assert_eq!(level(&mut rig, "6401h:02", 3.0), ["285#17FC0300"]);
    assert_eq!(rig.number(0x6422, 1), 2);
    rig.write(0x6421, 2, &[0]).unwrap();
    assert_eq!(level(&mut rig, "6401h:02", 9.0), [""; 0]);
    assert_eq!(rig.read(0x6401, 2), Ok(vec![9, 0]));
}

#[test]
fn eds_61_inputs_stay_over_resets_and_nominal_is_what_the_file_says() {
    let mut rig = station("");
    level(&mut rig, "6000h:01", 3.0);
    level(&mut rig, "6401h:01", 7.0);
    rig.data(0, &[0x81, NODE]);
    assert_eq!((rig.number(0x6000, 1), rig.number(0x6401, 1)), (3, 7));
    let now = rig.now;
    rig.device.act(now, &mut |device| device.make_nominal(now));
    assert_eq!((rig.number(0x6000, 1), rig.number(0x6401, 1)), (0, 0));
}
