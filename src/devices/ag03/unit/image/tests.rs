use proptest::prelude::*;

use super::*;
use crate::image::crc32;

/// An image of an AG03/1 with gear 48:1 in which every field differs from its neighbours.
fn sample() -> Image {
    let mut store = Store::new(Model::Ag03_1, Gear::Ratio48);
    store.set(Parameter::VPos, 77).unwrap();
    store.set(Parameter::Limit2, -250_000).unwrap();
    store.set(Parameter::OperatingMode, 1).unwrap();
    let faults = FaultBuffer::kept(*b"AJ\0\0\0\0\0\0\0\0", 2);
    let memory = Memory { faults, zero: -1600.5, shaft: 800.25 };
    Image { store, memory, bus: BusSettings::EMPTY }
}

/// The same with three octets of a bus.
fn with_bus() -> Image {
    Image { bus: BusSettings::new(&[1, 2, 3]).unwrap(), ..sample() }
}

fn decode(octets: &[u8]) -> Result<Image, ImageError> {
    Image::decode(octets, Model::Ag03_1, Gear::Ratio48)
}

/// The image with other octets from `at` on, and a checksum that holds.
fn forged(at: usize, octets: &[u8]) -> ImageOctets {
    changed(sample(), at, octets)
}

fn changed(image: Image, at: usize, octets: &[u8]) -> ImageOctets {
    let mut image = image.encode();
    image[at..at + octets.len()].copy_from_slice(octets);
    let end = image.len() - 4;
    let crc = crc32(&image[..end]);
    image[end..].copy_from_slice(&crc.to_be_bytes());
    image
}

#[test]
fn the_byte_map_octet_for_octet() {
    let rows = [
        "50524f464944525600010230008e0000",
        "00640000000500000000000000320000",
        "004d00000032000000320000001e0000",
        "000a0000000100000001000000000000",
        "0000000f4240fffc2f70000006400000",
        "00000000000000000001000000000000",
        "0000000003200000007d00000065414a",
        "00000000000000000002c09902000000",
        "00004089020000000000021d9eb6",
    ];
    let octets: Vec<_> = sample().encode().iter().map(|octet| format!("{octet:02x}")).collect();
    // A change here is a change of the format: it needs another version.
    assert_eq!(octets.concat(), rows.concat());
}

#[test]
fn the_settings_of_a_bus_lie_behind_the_encoder_in_version_2() {
    let image = with_bus();
    let octets = image.encode();
    assert_eq!(octets.len(), IMAGE_LEN + 4);
    assert_eq!((&octets[8..10], &octets[12..14]), (&[0, 2][..], &[0, 146][..]));
    assert_eq!(octets[14..138], sample().encode()[14..138]);
    assert_eq!(octets[138..142], [3, 1, 2, 3]);
    assert_eq!(decode(&octets), Ok(image));
    for len in 0..octets.len() {
        assert!(
            matches!(decode(&octets[..len]), Err(ImageError::Image(image::ImageError::Length { got, .. })) if got == len),
            "{len}"
        );
    }
    for bit in 0..8 * octets.len() {
        let mut damaged = octets;
        damaged[bit / 8] ^= 1 << (bit % 8);
        assert!(decode(&damaged).is_err(), "bit {bit}");
    }
    for count in [0, 2, 4, 129, 255] {
        assert!(
            matches!(
                decode(&changed(with_bus(), 138, &[count])),
                Err(ImageError::Image(image::ImageError::Length { .. }))
            ),
            "{count}"
        );
    }
    let most = BusSettings::new(&[7; BusSettings::MAX_LEN]).unwrap();
    let image = Image { bus: most, ..sample() };
    assert_eq!(image.encode().len(), MAX_IMAGE_LEN);
    assert_eq!(decode(&image.encode()), Ok(image));
    assert_eq!(BusSettings::new(&[0; 129]), Err(BusSettingsError { got: 129 }));
}

/// Written by version 0.1.0 (`profidrive emulate --state-dir`).
#[test]
fn an_image_of_0_1_0_is_still_loaded_and_written_as_it_was() {
    let golden = include_bytes!("0.1.0.eeprom");
    let image = decode(golden).unwrap();
    assert_eq!(image.store.value(Parameter::Limit1), 250_000);
    assert_eq!(image.store.value(Parameter::VPos), 77);
    assert_eq!(image.memory.faults.codes()[..2], *b"F\0");
    assert_eq!(image.memory.faults.count(), 1);
    assert_eq!((image.memory.zero, image.memory.shaft), (-523.0, 0.0));
    assert_eq!(image.encode()[..], golden[..]);
}

#[test]
fn every_truncation_and_every_octet_too_many_is_refused() {
    let image = sample().encode();
    for len in 0..IMAGE_LEN {
        let error = image::ImageError::Length { expected: IMAGE_LEN, got: len };
        assert_eq!(decode(&image[..len]), Err(error.into()), "{len}");
    }
    let mut longer = Vec::from(&image[..]);
    longer.push(0);
    let error = image::ImageError::Length { expected: IMAGE_LEN, got: IMAGE_LEN + 1 };
    assert_eq!(decode(&longer), Err(error.into()));
}

#[test]
fn every_single_bit_error_is_refused() {
    let image = sample().encode();
    for bit in 0..8 * IMAGE_LEN {
        let mut damaged = image;
        damaged[bit / 8] ^= 1 << (bit % 8);
        assert!(decode(&damaged).is_err(), "bit {bit}");
    }
}

#[test]
fn what_is_wrong_is_said_with_expected_and_got() {
    for (octets, error, text) in [
        (Vec::from(*b"#!/bin/sh\n"), image::ImageError::Foreign.into(), "it is no EEPROM image"),
        (
            Vec::new(),
            image::ImageError::Length { expected: IMAGE_LEN, got: 0 }.into(),
            "it has 0 octets, expected 142",
        ),
        (
            forged(8, &[0, 4]).to_vec(),
            image::ImageError::Version { expected: 3, got: 4 }.into(),
            "it has format version 4, expected at most 3",
        ),
        (
            forged(12, &[0, 141]).to_vec(),
            image::ImageError::Length { expected: 141, got: 142 }.into(),
            "it has 142 octets, expected 141",
        ),
        (
            forged(10, &[3]).to_vec(),
            ImageError::UnknownDrive { model: 3, gear: 48 },
            "it is of a drive unknown to this version (model 3, gear 48)",
        ),
        (
            forged(10, &[1, 24]).to_vec(),
            ImageError::OtherDrive {
                expected: (Model::Ag03_1, Gear::Ratio48),
                got: (Model::Ag03, Gear::Ratio24),
            },
            "it is of an ag03 with gear 24, expected an ag03-1 with gear 48",
        ),
        (
            forged(14, &501_i32.to_be_bytes()).to_vec(),
            ImageError::OutOfRange { parameter: Parameter::ControllerP, low: 1, high: 500, got: 501 },
            "its value of Controller parameter P is 501, which must be within 1 to 500",
        ),
        (
            forged(110, b"K").to_vec(),
            ImageError::FaultCode { got: b'K' },
            "its fault buffer holds 0x4B, which is no fault code",
        ),
        (
            forged(122, &f64::INFINITY.to_be_bytes()).to_vec(),
            ImageError::Angle { got: f64::INFINITY },
            "its shaft angle or zero point is inf, which is no angle",
        ),
    ] {
        assert_eq!(decode(&octets), Err(error));
        assert_eq!(error.to_string(), text);
    }
    assert!(matches!(decode(&forged(130, &f64::NAN.to_be_bytes())), Err(ImageError::Angle { .. })));
    let mut damaged = sample().encode();
    damaged[20] ^= 1;
    assert!(decode(&damaged).unwrap_err().to_string().starts_with("it is damaged: its checksum is "));
}

#[test]
fn an_ag03_has_no_d_pos_to_keep() {
    let store = Store::new(Model::Ag03, Gear::Ratio48);
    let image = Image { store, ..sample() };
    assert_eq!(Image::decode(&image.encode(), Model::Ag03, Gear::Ratio48), Ok(image));

    let place = 14 + 4 * kept().position(|parameter| parameter == Parameter::DPos).unwrap();
    let mut octets = forged(place, &50_i32.to_be_bytes());
    assert!(decode(&octets).is_ok());
    octets[10] = 1;
    let crc = crc32(&octets[..IMAGE_LEN - 4]);
    octets[IMAGE_LEN - 4..].copy_from_slice(&crc.to_be_bytes());
    let error = ImageError::OutOfRange { parameter: Parameter::DPos, low: 101, high: 101, got: 50 };
    assert_eq!(Image::decode(&octets, Model::Ag03, Gear::Ratio48), Err(error));
}

/// Any value a drive can hold.
fn images() -> impl Strategy<Value = Image> {
    let choices = proptest::collection::vec(any::<i32>(), Parameter::COUNT);
    let codes = proptest::collection::vec(proptest::sample::select(b"\0ABCDEFGJ".to_vec()), 10);
    let angle = -LARGEST_ANGLE..=LARGEST_ANGLE;
    let bus = proptest::collection::vec(any::<u8>(), 0..=BusSettings::MAX_LEN);
    (0..2usize, 0..2usize, choices, codes, any::<u16>(), angle.clone(), angle, bus).prop_map(
        |(model, gear, choices, codes, fault_count, zero, shaft, bus)| {
            let (model, gear) = (Model::ALL[model], Gear::ALL[gear]);
            let mut store = Store::new(model, gear);
            for (parameter, choice) in Parameter::all().zip(choices) {
                let range = store.range(parameter);
                let value = range.low + choice.rem_euclid(range.high - range.low + 1);
                // On an AG03 the store refuses d-Pos.
                let _ = store.set(parameter, value);
            }
            let faults = FaultBuffer::kept(codes.try_into().unwrap(), fault_count);
            let bus = BusSettings::new(&bus).unwrap();
            Image { store, memory: Memory { faults, zero, shaft }, bus }
        },
    )
}

proptest! {
    #[test]
    fn what_was_encoded_is_decoded_but_for_what_the_eeprom_does_not_keep(image in images()) {
        let decoded = Image::decode(&image.encode(), image.store.model(), image.store.gear()).unwrap();
        let mut kept = image;
        kept.store.power_on();
        prop_assert_eq!(&decoded, &kept);
        prop_assert_eq!(decoded.store.value(Parameter::OffsetInch2), 100);
        prop_assert_eq!(decoded.encode(), kept.encode());
    }

    #[test]
    fn any_octets_are_refused_without_a_panic(octets in proptest::collection::vec(any::<u8>(), 0..200)) {
        prop_assert!(decode(&octets).is_err());
    }

    #[test]
    fn any_contents_under_a_right_checksum_are_refused_or_an_image_that_can_be_written_again(
        at in 14..IMAGE_LEN - 4, octets in proptest::collection::vec(any::<u8>(), 1..8),
    ) {
        let len = octets.len().min(IMAGE_LEN - 4 - at);
        let octets = forged(at, &octets[..len]);
        if let Ok(image) = decode(&octets) {
            prop_assert_eq!(image.encode(), octets);
        }
    }
}
