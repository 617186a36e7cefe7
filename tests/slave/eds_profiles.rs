//! Whatever a file of a profile says, a master writes and an input is: the node goes on, and entries keep their types.
#![cfg(feature = "eds")]

use std::time::Duration;

use profidrive::devices::CanopenDevice;
use profidrive::devices::from_eds::Dictionary;
use profidrive::eds::Eds;
use profidrive::face::surroundings::Level;
use proptest::prelude::*;

use crate::file_node::{NODE, Rig, array, pdo, var};

static IO: [u16; 30] = [
    0x6000, 0x6002, 0x6003, 0x6005, 0x6006, 0x6007, 0x6008, 0x6020, 0x6050, 0x6100, 0x6120, 0x6200, 0x6202,
    0x6206, 0x6207, 0x6208, 0x6220, 0x6300, 0x6320, 0x6401, 0x6403, 0x6411, 0x6421, 0x6422, 0x6423, 0x6424,
    0x6426, 0x6429, 0x6443, 0x6444,
];
static ENCODER: [u16; 22] = [
    0x6000, 0x6001, 0x6002, 0x6003, 0x6004, 0x6030, 0x6200, 0x6300, 0x6301, 0x6302, 0x6310, 0x6317, 0x6320,
    0x6327, 0x6330, 0x6400, 0x6401, 0x6402, 0x6500, 0x6501, 0x6502, 0x6509,
];
static DRIVE: [u16; 30] = [
    0x6007, 0x6040, 0x6041, 0x6042, 0x604C, 0x605A, 0x6060, 0x6061, 0x6064, 0x6067, 0x6071, 0x607A, 0x607B,
    0x607D, 0x6081, 0x6083, 0x608F, 0x6091, 0x6092, 0x6093, 0x6096, 0x6097, 0x6098, 0x60C1, 0x60C2, 0x60E3,
    0x60F2, 0x60F8, 0x60FF, 0x6502,
];

fn text(profile: u16, objects: &[u16], rows: &[(usize, bool, u16, bool, i64)]) -> String {
    let mut text = var(0x1000, 7, "ro", &format!("DefaultValue={profile}"))
        + &pdo(0x1400, "$NODEID+0x200", 255, &["0x62000108"])
        + &pdo(0x1800, "$NODEID+0x180", 255, &["0x60000108", "0x60040020"]);
    for (place, is_array, data, writable, default) in rows {
        let index = objects[place % objects.len()];
        let (access, default) = (if *writable { "rw" } else { "ro" }, default.to_string());
        text += &if *is_array {
            array(index, *data, access, &[&default, ""])
        } else {
            var(index, *data, access, &format!("DefaultValue={default}\nPDOMapping=1"))
        };
    }
    text
}

fn number() -> impl Strategy<Value = i64> {
    prop_oneof![Just(0), Just(1), -10_i64..70_000, any::<i32>().prop_map(i64::from), any::<i64>()]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, ..ProptestConfig::default() })]

    #[test]
    fn no_value_stops_a_node_of_a_profile(
        (profile, objects) in prop_oneof![
            Just((401, &IO[..])), Just((402, &DRIVE[..])), Just((406, &ENCODER[..])),
        ],
        rows in prop::collection::vec(
            (0_usize..30, any::<bool>(), prop::sample::select(vec![1_u16, 2, 3, 4, 5, 6, 7, 8, 21, 27]), any::<bool>(), number()),
            1..40,
        ),
        steps in prop::collection::vec((0_u8..6, 0_usize..200, number()), 0..60),
    ) {
        let Ok(mut eds) = Eds::read(text(profile, objects, &rows).as_bytes()) else { return Ok(()) };
        eds.complete();
        let dictionary = Dictionary::hold(eds);
        let mut rig = Rig::of(dictionary);
        rig.start();
        let entries: Vec<_> = dictionary.objects.iter()
            .flat_map(|object| object.entries.iter().map(|entry| (object.index.0, entry.sub.0, entry.data)))
            .filter(|(index, ..)| *index >= 0x6000)
            .collect();
        let mut inputs = Vec::new();
        rig.device.description().each_input(&mut |input, _| inputs.push(input.name.to_owned()));
        for (step, place, number) in steps {
            match step {
                0 | 1 if !entries.is_empty() => {
                    let (index, sub, data) = entries[place % entries.len()];
                    let len = data.octets().unwrap_or(8).min(8);
                    let _ = rig.write(index, sub, &number.to_le_bytes()[..len]);
                }
                2 if !inputs.is_empty() => {
                    let name = inputs[place % inputs.len()].clone();
                    rig.set(&name, Level::Number(number as f64));
                }
                3 => _ = rig.sync(),
                4 => {
                    let command = [1, 2, 0x80, 0x81, 0x82][place % 5];
                    rig.data(0, &[command, NODE]);
                    if command == 2 {
                        rig.data(0, &[0x80, NODE]);
                    }
                }
                _ => _ = rig.pass(Duration::from_millis(u64::from(number.to_le_bytes()[0]))),
            }
        }
        rig.data(0, &[0x80, NODE]);
        for (index, sub, data) in entries {
            match rig.read(index, sub) {
                Ok(octets) => prop_assert_eq!(Some(octets.len()), data.octets(), "{:04X}h:{}", index, sub),
                Err(code) => prop_assert_eq!(code, 0x0601_0001, "{:04X}h:{}", index, sub),
            }
        }
        rig.again();
    }
}
