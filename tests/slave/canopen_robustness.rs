//! Whatever comes from the bus: the invariants of the fuzz targets for random inputs on a stable compiler.

use proptest::prelude::*;

use crate::fuzz_corpus::invariants;

/// Eight octets that are an SDO request for an entry that exists, more often than chance would have it.
fn request() -> impl Strategy<Value = Vec<u8>> {
    let command = prop_oneof![
        Just(0x40),
        Just(0x60),
        Just(0x70),
        Just(0x21),
        Just(0x22),
        Just(0x23),
        Just(0x2B),
        Just(0x2F),
        any::<u8>()
    ];
    let index = prop_oneof![
        0x1000..0x1020_u16,
        0x1400..0x1404_u16,
        0x1600..0x1604_u16,
        0x1800..0x1804_u16,
        0x1A00..0x1A04_u16,
        0x2000..0x2012_u16,
        any::<u16>()
    ];
    (command, index, 0..10_u8, any::<[u8; 4]>()).prop_map(|(command, index, sub, data)| {
        let [low, high] = index.to_le_bytes();
        let mut octets = vec![command, low, high, sub];
        octets.extend(data);
        octets
    })
}

/// A frame as `canopen_node` reads it.
fn frame() -> impl Strategy<Value = Vec<u8>> {
    let id = prop_oneof![
        Just(0x000_u16),
        Just(0x080),
        Just(0x185),
        Just(0x205),
        Just(0x305),
        Just(0x605),
        Just(0x705),
        Just(0x709),
        any::<u16>()
    ];
    let data = prop_oneof![
        request(),
        prop::collection::vec(any::<u8>(), 0..=8),
        prop_oneof![Just(1_u8), Just(2), Just(0x80), Just(0x81), Just(0x82)]
            .prop_map(|command| vec![command, 5]),
    ];
    (prop_oneof![9 => Just(0_u8), 1 => 0..4_u8], id, data).prop_map(|(flags, id, data)| {
        let [low, high] = id.to_le_bytes();
        let mut step = vec![0, flags, data.len() as u8, low, high];
        if flags & 2 == 0 {
            step.extend(data);
        }
        step
    })
}

fn step() -> impl Strategy<Value = Vec<u8>> {
    prop_oneof![
        8 => frame(),
        1 => (0..500_u16).prop_map(|millis| [&[0x40][..], &millis.to_le_bytes()].concat()),
        1 => (0x60..0xA1_u8, any::<[u8; 3]>()).prop_map(|(kind, rest)| [&[kind][..], &rest].concat()),
    ]
}

proptest! {
    #[test]
    fn any_sdo_requests_keep_the_invariants(requests in prop::collection::vec(request(), 0..60)) {
        invariants::sdo_server::check(&requests.concat());
    }

    #[test]
    fn any_steps_keep_the_invariants(steps in prop::collection::vec(step(), 0..60)) {
        invariants::canopen_node::check(&steps.concat());
    }

    #[test]
    fn any_octets_keep_the_invariants(octets in prop::collection::vec(any::<u8>(), 0..500)) {
        invariants::sdo_server::check(&octets);
        invariants::canopen_node::check(&octets);
    }
}
