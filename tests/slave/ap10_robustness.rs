//! Whatever comes over the bus or from a person: an AP10 does not panic, its display fits and it still answers.

use profidrive::can_bus::can::{Frame, Id};
use profidrive::devices::CanopenDevice;
use profidrive::devices::ap10::{Fault, Key};
use proptest::prelude::*;

use crate::ap10_node::Rig;

#[derive(Clone, Debug)]
enum Step {
    Frame {
        id: u16,
        octets: Vec<u8>,
    },
    Remote(u16),
    /// A write to an entry of the dictionary.
    Write {
        place: usize,
        value: u32,
    },
    Key {
        key: usize,
        down: bool,
    },
    Turn(f64),
    Fault {
        place: usize,
        begins: bool,
    },
    Power(bool),
    Pass(u64),
}

fn step() -> impl Strategy<Value = Step> {
    let ids = prop_oneof![
        Just(0x000_u16),
        Just(0x080),
        Just(0x67D),
        Just(0x27D),
        Just(0x37D),
        Just(0x1FD),
        Just(0x2FD),
        Just(0x77D),
        0_u16..0x800
    ];
    prop_oneof![
        4 => (ids.clone(), prop::collection::vec(any::<u8>(), 0..=8)).prop_map(|(id, octets)| Step::Frame { id, octets }),
        1 => ids.prop_map(Step::Remote),
        4 => (0_usize..200, prop_oneof![0_u32..12, any::<u32>()]).prop_map(|(place, value)| Step::Write { place, value }),
        2 => (0_usize..3, any::<bool>()).prop_map(|(key, down)| Step::Key { key, down }),
        2 => prop_oneof![-200_000.0..200_000.0_f64, any::<f64>()].prop_map(Step::Turn),
        1 => (0_usize..3, any::<bool>()).prop_map(|(place, begins)| Step::Fault { place, begins }),
        1 => any::<bool>().prop_map(Step::Power),
        2 => (0_u64..20_000).prop_map(Step::Pass),
    ]
}

proptest! {
    #![proptest_config(crate::long::cases(64, 20))]

    #[test]
    fn nothing_makes_it_panic(steps in prop::collection::vec(step(), 1..80)) {
        let mut rig = Rig::operational();
        let entries: Vec<_> = profidrive::devices::ap10::canopen::OBJECTS
            .iter()
            .flat_map(|object| object.entries.iter().map(|entry| (object.index.0, entry)))
            .filter(|(index, entry)| entry.is_writable() && !matches!(index, 0x1017 | 0x1800 | 0x6200))
            .collect();
        for step in steps {
            match step {
                Step::Frame { id, octets } => {
                    rig.data(id, &octets);
                }
                Step::Remote(id) => {
                    rig.frame(&Frame::remote(Id::base(id).unwrap(), 8).unwrap());
                }
                Step::Write { place, value } => {
                    let (index, entry) = entries[place % entries.len()];
                    let [a, b] = index.to_le_bytes();
                    let [d, e, f, g] = value.to_le_bytes();
                    let len = u8::try_from(entry.data.octets().unwrap()).unwrap();
                    rig.sdo([0x23 | (4 - len) << 2, a, b, entry.sub.0, d, e, f, g]);
                }
                Step::Key { key, down: true } => rig.device.press(rig.now, Key::ALL[key]),
                Step::Key { key, down: false } => rig.device.release(rig.now, Key::ALL[key]),
                Step::Turn(turns) => rig.turns(turns),
                Step::Fault { place, begins: true } => rig.device.provoke(rig.now, Fault::ALL[place]),
                Step::Fault { place, begins: false } => rig.device.end_fault(rig.now, Fault::ALL[place]),
                Step::Power(true) => rig.device.power_on(rig.now),
                Step::Power(false) => rig.device.power_off(rig.now),
                Step::Pass(millis) => {
                    rig.pass(millis);
                }
            }
            rig.drain();
            let display = rig.display();
            for row in &display.rows {
                prop_assert!(row.text().len() <= 8);
            }
            prop_assert!(!display.to_string().is_empty());
        }
        rig.power_cycle();
        prop_assert_eq!(rig.read(0x6507, 0), Ok(0x012D_0302));
    }
}
