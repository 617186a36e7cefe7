use proptest::prelude::*;

use super::*;
use crate::profibus::fdl::{FrameCount, ReplyStatus, Service};

fn hex(text: &str) -> Vec<u8> {
    text.split_whitespace().map(|octet| u8::from_str_radix(octet, 16).unwrap()).collect()
}

/// Telegrams of all kinds: the worked example of `dp-v0.md` 10 and traces of real buses (3, 6.2).
const GOLDEN: [&str; 22] = [
    "10 05 02 49 50 16",
    "10 02 05 00 07 16",
    "68 05 05 68 85 82 6D 3C 3E EE 16",
    "68 0B 0B 68 82 85 08 3E 3C 02 05 00 FF 12 34 D5 16",
    "68 0C 0C 68 85 82 5D 3D 3E 88 0A 0A 0B 12 34 00 CC 16",
    "E5",
    "68 07 07 68 85 82 7D 3E 3E 23 13 36 16",
    "68 05 05 68 85 82 5D 3C 3E DE 16",
    "68 0B 0B 68 82 85 08 3E 3C 00 0C 00 02 12 34 DD 16",
    "68 07 07 68 FF 82 46 3A 3E 00 00 3F 16",
    "68 07 07 68 05 02 7D 04 7E 00 00 06 16",
    "68 07 07 68 02 05 08 02 31 00 00 42 16",
    "68 07 07 68 05 02 5D 04 7F 00 00 E7 16",
    "68 07 07 68 02 05 0A 02 37 00 00 4A 16",
    "10 02 05 03 0A 16",
    "10 02 05 02 09 16",
    "10 02 05 0A 11 16",
    "68 0C 0C 68 85 82 7D 3D 3E 40 00 00 00 12 34 00 85 16",
    "68 09 09 68 FE 82 6D 37 3E 07 12 34 00 AF 16",
    "68 07 07 68 FF 81 46 3A 3E 00 00 3E 16",
    "A2 05 02 7D 01 02 03 04 05 06 07 08 A8 16",
    "DC 02 03",
];

#[test]
fn golden_telegrams_decode_whole_and_encode_to_the_same_octets() {
    for text in GOLDEN {
        let octets = hex(text);
        let Decoded::Telegram { telegram, len } = decode(&octets) else {
            panic!("{text}: {:?}", decode(&octets));
        };
        assert_eq!(len, octets.len(), "{text}");
        let mut buf = [0xA5; MAX_TELEGRAM_LEN + 1];
        assert_eq!(telegram.encode(&mut buf).unwrap(), octets, "{text}");
        assert!(buf[octets.len()..].iter().all(|octet| *octet == 0xA5), "{text}: wrote past its end");
    }
}

#[test]
fn a_diagnosis_request_is_read_field_by_field() {
    let octets = hex("68 05 05 68 85 82 6D 3C 3E EE 16");
    let expected = DataTelegram {
        format: Format::Sd2,
        da: Address::from_octet(5),
        sa: Address::from_octet(2),
        dsap: Sap::new(60),
        ssap: Sap::new(62),
        fc: FunctionCode::request(Service::SrdHigh, FrameCount::First),
        data: &[],
    };
    assert_eq!(decode(&octets), Decoded::Telegram { telegram: Telegram::Data(expected), len: 11 });
}

#[test]
fn data_are_borrowed_not_copied() {
    let octets = hex("68 07 07 68 02 05 08 02 31 00 00 42 16");
    let Decoded::Telegram { telegram: Telegram::Data(telegram), .. } = decode(&octets) else { panic!() };
    assert_eq!(telegram.data.as_ptr(), octets[7..].as_ptr());
    assert_eq!(telegram.fc, FunctionCode::response(ReplyStatus::DataLow));
}

#[test]
fn every_prefix_of_every_kind_is_incomplete() {
    for text in GOLDEN {
        let octets = hex(text);
        for len in 0..octets.len() {
            assert_eq!(decode(&octets[..len]), Decoded::Incomplete, "{text} cut at {len}");
        }
    }
}

#[test]
fn no_single_bit_error_leaves_a_telegram_with_checksum() {
    for text in GOLDEN.into_iter().filter(|text| !matches!(&text[..2], "DC" | "E5")) {
        let octets = hex(text);
        for bit in 0..octets.len() * 8 {
            let mut damaged = octets.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            match decode(&damaged) {
                Decoded::Incomplete => {}
                Decoded::Invalid { skip, .. } => assert!((1..=damaged.len()).contains(&skip)),
                Decoded::Telegram { telegram, .. } => panic!("{text} bit {bit} reads as {telegram:?}"),
            }
        }
    }
}

#[test]
fn each_rule_of_the_format_is_checked_and_named() {
    for (text, error) in [
        ("00", FrameError::StartDelimiter { got: 0x00 }),
        ("68 03", FrameError::Length { got: 3 }),
        ("68 FA FA 68", FrameError::Length { got: 250 }),
        ("68 05 06", FrameError::RepeatedLength { expected: 5, got: 6 }),
        ("68 05 05 00", FrameError::SecondStartDelimiter { got: 0 }),
        ("10 05 02 49 50 17", FrameError::EndDelimiter { got: 0x17 }),
        ("10 05 02 49 51 16", FrameError::Checksum { expected: 0x50, got: 0x51 }),
        ("68 05 05 68 85 82 6D 3C 3E EF 16", FrameError::Checksum { expected: 0xEE, got: 0xEF }),
        ("A2 05 02 7D 01 02 03 04 05 06 07 08 A9 16", FrameError::Checksum { expected: 0xA8, got: 0xA9 }),
        ("10 85 02 49 D0 16", FrameError::ExtensionMissing),
        ("68 04 04 68 85 82 6D 3C B0 16", FrameError::ExtensionMissing),
        ("68 05 05 68 85 82 6D 7C 3E 2E 16", FrameError::Extension { got: 0x7C }),
        ("68 05 05 68 85 82 6D 3C BE 6E 16", FrameError::Extension { got: 0xBE }),
        ("DC 85", FrameError::TokenAddress { got: 0x85 }),
        ("DC 05 7F", FrameError::TokenAddress { got: 0x7F }),
    ] {
        let octets = hex(text);
        let Decoded::Invalid { error: got, skip } = decode(&octets) else {
            panic!("{text}: {:?}", decode(&octets));
        };
        assert_eq!(got, error, "{text}");
        assert!((1..=octets.len()).contains(&skip), "{text}");
    }
}

#[test]
fn a_damaged_sd2_is_dropped_whole_and_others_by_one_octet() {
    for (text, skipped) in [
        ("68 05 05 68 85 82 6D 3C 3E EF 16 E5", 11),
        ("68 05 05 68 85 82 6D 3C 3E EE 17 E5", 1),
        ("10 05 02 49 51 16 E5", 1),
    ] {
        let Decoded::Invalid { skip, .. } = decode(&hex(text)) else { panic!("{text}") };
        assert_eq!(skip, skipped, "{text}");
    }
}

#[test]
fn the_longest_telegram_has_246_octets_behind_the_function_code() {
    let data = [0x5A; 247];
    let telegram = |data| DataTelegram {
        format: Format::Sd2,
        da: Address::from_octet(5),
        sa: Address::from_octet(2),
        dsap: None,
        ssap: None,
        fc: FunctionCode::request(Service::SrdHigh, FrameCount::First),
        data,
    };
    let mut buf = [0xA5; 256];
    assert_eq!(telegram(&data[..246]).encode(&mut buf).unwrap().len(), MAX_TELEGRAM_LEN);
    let got = 247;
    let expected = (1, 246);
    assert_eq!(
        telegram(&data).encode(&mut buf),
        Err(EncodeError::PduLength { format: Format::Sd2, expected, got })
    );
    let mut short = [0xA5; 254];
    assert_eq!(
        telegram(&data[..246]).encode(&mut short),
        Err(EncodeError::BufferTooSmall { needed: 255, got: 254 })
    );
    assert_eq!(short, [0xA5; 254]);
}

#[test]
fn a_format_refuses_data_it_cannot_carry() {
    let telegram = |format, data: &'static [u8]| {
        let fc = FunctionCode::from_octet(0x7D);
        let (da, sa) = (Address::from_octet(5), Address::from_octet(2));
        DataTelegram { format, da, sa, dsap: None, ssap: None, fc, data }
            .encode(&mut [0; 255])
            .map(<[u8]>::len)
    };
    let wrong = |format, expected, got| Err(EncodeError::PduLength { format, expected, got });
    assert_eq!(telegram(Format::Sd1, &[1]), wrong(Format::Sd1, (0, 0), 1));
    assert_eq!(telegram(Format::Sd2, &[]), wrong(Format::Sd2, (1, 246), 0));
    assert_eq!(telegram(Format::Sd3, &[1; 7]), wrong(Format::Sd3, (8, 8), 7));
    assert_eq!(telegram(Format::Sd3, &[1; 8]), Ok(14));
}

#[cfg(feature = "alloc")]
#[test]
fn a_telegram_is_put_into_bytes() {
    let mut buf = bytes::BytesMut::new();
    let octets = hex("68 07 07 68 02 05 08 02 31 00 00 42 16");
    let Decoded::Telegram { telegram, .. } = decode(&octets) else { panic!() };
    telegram.put(&mut buf).unwrap();
    Telegram::ShortAcknowledge.put(&mut buf).unwrap();
    assert_eq!(buf, [octets.as_slice(), &[0xE5]].concat());
    let mut full = [0; 3];
    assert_eq!(telegram.put(&mut &mut full[..]), Err(EncodeError::BufferTooSmall { needed: 13, got: 3 }));
}

prop_compose! {
    pub(crate) fn any_data_telegram()(
        da in 0u8..128, sa in 0u8..128, fc: u8,
        dsap in proptest::option::of(0u8..64), ssap in proptest::option::of(0u8..64),
        data in proptest::collection::vec(any::<u8>(), 0..=244),
    ) -> Vec<u8> {
        let (dsap, ssap) = (dsap.and_then(Sap::new), ssap.and_then(Sap::new));
        let telegram = DataTelegram {
            format: DataTelegram::customary_format(dsap, ssap, &data),
            da: Address::from_octet(da), sa: Address::from_octet(sa), dsap, ssap,
            fc: FunctionCode::from_octet(fc), data: &data,
        };
        telegram.encode(&mut [0xA5; MAX_TELEGRAM_LEN]).unwrap().to_vec()
    }
}

proptest! {
    #[test]
    fn what_is_encoded_is_decoded_alike(octets in any_data_telegram()) {
        let Decoded::Telegram { telegram, len } = decode(&octets) else { panic!("{octets:02X?}") };
        prop_assert_eq!(len, octets.len());
        let mut buf = [0xA5; MAX_TELEGRAM_LEN];
        prop_assert_eq!(telegram.encode(&mut buf).unwrap(), &octets[..]);
        for len in 0..octets.len() {
            prop_assert_eq!(decode(&octets[..len]), Decoded::Incomplete);
        }
    }

    #[test]
    fn any_octets_are_judged_without_panic_and_reencode_if_accepted(
        octets in proptest::collection::vec(prop_oneof![any::<u8>(), Just(0x68), Just(0x10), Just(0x16), Just(4)], 0..300)
    ) {
        match decode(&octets) {
            Decoded::Incomplete => prop_assert!(octets.len() < MAX_TELEGRAM_LEN),
            Decoded::Invalid { skip, .. } => prop_assert!((1..=octets.len()).contains(&skip)),
            Decoded::Telegram { telegram, len } => {
                let mut buf = [0xA5; MAX_TELEGRAM_LEN];
                prop_assert_eq!(telegram.encode(&mut buf).unwrap(), &octets[..len]);
            }
        }
    }
}
