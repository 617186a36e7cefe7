//! Images of EEPROMs, whole, damaged and forged: `restore(image(x)) = x` for an image and for a drive; every damaged
//! image is refused or equal; whatever is accepted is encoded to the same octets and makes a drive that works.

use std::time::Duration;

use arbitrary::{Arbitrary, Unstructured};
use profidrive::devices::ag03::drive::{Fault, FaultBuffer, Inputs};
use profidrive::devices::ag03::param::{Gear, Model, Parameter};
use profidrive::devices::ag03::profibus::{Config, Device};
use profidrive::devices::ag03::unit::{IMAGE_LEN, Image};
use profidrive::profibus::fdl::Address;
use profidrive::time::Instant;

use super::Octets;

/// Half the range of the encoder in increments: beyond it the position jumps to the other end.
const ENCODER_HALF: i64 = 65_536 / 2 * 1_600;

#[derive(Arbitrary, Debug)]
struct Session<'a> {
    ag03: bool,
    ratio_24: bool,
    contents: Contents,
    damage: Damage<'a>,
    /// What the drive goes through between two images.
    life: Vec<Event>,
}

#[derive(Arbitrary, Debug)]
struct Contents {
    values: [i32; 6],
    places: [u8; 6],
    faults: [u8; 10],
    fault_count: u16,
    /// In 1/1024 of an increment.
    zero: i64,
    shaft: i64,
}

#[derive(Arbitrary, Debug)]
enum Damage<'a> {
    /// Up to four bits: CRC-32 finds them all in an image of 142 octets.
    Bits([u16; 4]),
    /// A burst within 32 bits: CRC-32 finds them all.
    Burst {
        at: u8,
        mask: [u8; 4],
    },
    Shortened {
        by: u8,
    },
    Lengthened(Octets<'a>),
    /// Other contents under a checksum that holds: only what a drive can hold is accepted.
    Forged {
        at: u8,
        octets: Octets<'a>,
    },
    /// No image at all.
    Foreign(Octets<'a>),
}

#[derive(Arbitrary, Clone, Copy, Debug)]
enum Event {
    Wait { millis: u16 },
    Fault(u8),
    Nominal,
    PowerOff,
    PowerOn,
}

pub(crate) fn check(data: &[u8]) {
    let Ok(session) = Session::arbitrary_take_rest(Unstructured::new(data)) else { return };
    let model = if session.ag03 { Model::Ag03 } else { Model::Ag03_1 };
    let gear = if session.ratio_24 { Gear::Ratio24 } else { Gear::Ratio48 };
    let image = image(model, gear, &session.contents);
    let octets = image.encode();
    assert_eq!(Image::decode(&octets, model, gear), Ok(image));
    for other in Model::ALL.into_iter().flat_map(|model| Gear::ALL.map(|gear| (model, gear))) {
        assert_eq!(Image::decode(&octets, other.0, other.1).is_ok(), other == (model, gear));
    }
    judge(&octets, &session.damage, model, gear);
    live(&octets, &session.life, model, gear);
}

/// An image with any contents a drive can have.
fn image(model: Model, gear: Gear, contents: &Contents) -> Image {
    const CODES: [u8; 9] = *b"\0ABCDEFGJ";
    let mut image = Image::of_new(model, gear);
    let kept: Vec<_> = Parameter::all()
        .filter(|parameter| parameter.entry().persistent && image.store.entry(parameter.entry().pnu).is_ok())
        .collect();
    for (value, place) in contents.values.iter().zip(contents.places) {
        let parameter = kept[usize::from(place) % kept.len()];
        let range = image.store.range(parameter);
        let (low, high) = (i64::from(range.low), i64::from(range.high));
        let value = low + (i64::from(*value) - low).rem_euclid(high - low + 1);
        image
            .store
            .set(parameter, i32::try_from(value).expect("within its range"))
            .expect("within its range");
    }
    let codes = contents.faults.map(|fault| CODES[usize::from(fault) % CODES.len()]);
    image.memory.faults = FaultBuffer::kept(codes, contents.fault_count);
    image.memory.zero = contents.zero as f64 / 1024.0;
    image.memory.shaft = (contents.shaft % (1024 * ENCODER_HALF)) as f64 / 1024.0;
    image
}

fn judge(octets: &[u8], damage: &Damage<'_>, model: Model, gear: Gear) {
    let mut damaged = octets.to_vec();
    match damage {
        Damage::Bits(bits) => bits.iter().for_each(|bit| {
            let bit = usize::from(*bit) % (8 * IMAGE_LEN);
            damaged[bit / 8] ^= 1 << (bit % 8);
        }),
        Damage::Burst { at, mask } => {
            let at = usize::from(*at) % (IMAGE_LEN - mask.len() + 1);
            damaged[at..].iter_mut().zip(mask).for_each(|(octet, mask)| *octet ^= mask);
        }
        Damage::Shortened { by } => damaged.truncate(IMAGE_LEN.saturating_sub(usize::from(*by))),
        Damage::Lengthened(Octets(more)) => damaged.extend_from_slice(more),
        Damage::Forged { at, octets: forged } => {
            let body = IMAGE_LEN - 4;
            let at = usize::from(*at) % body;
            let rest = &mut damaged[at..body];
            rest.iter_mut().zip(forged.0).for_each(|(octet, forged)| *octet = *forged);
            let crc = crc32(&damaged[..body]).to_be_bytes();
            damaged[body..].copy_from_slice(&crc);
            return accept(&damaged, model, gear);
        }
        Damage::Foreign(Octets(foreign)) => return accept(foreign, model, gear),
    }
    match Image::decode(&damaged, model, gear) {
        Ok(_) => assert_eq!(damaged, octets, "damaged and accepted"),
        Err(error) => {
            assert_ne!(damaged, octets, "{error}");
            assert!(Device::restore(config(model, gear), &damaged, Instant::ZERO).is_err());
        }
    }
}

/// What cannot be told from an image of ours must be one in every octet, and make a drive that works.
fn accept(octets: &[u8], model: Model, gear: Gear) {
    match Image::decode(octets, model, gear) {
        Ok(image) => {
            assert_eq!(image.encode()[..], *octets);
            for parameter in Parameter::all() {
                let none = parameter == Parameter::DPos && model == Model::Ag03;
                assert!(none || image.store.range(parameter).contains(image.store.value(parameter)));
            }
            if image.memory.shaft.abs() <= ENCODER_HALF as f64 {
                live(octets, &[Event::Wait { millis: 50 }], model, gear);
            } else {
                let mut device =
                    Device::restore(config(model, gear), octets, Instant::ZERO).expect("accepted");
                device.handle_timeout(Instant::from_millis(50));
            }
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

/// A drive with this image keeps it, and what it keeps later makes the same drive again.
fn live(octets: &[u8], life: &[Event], model: Model, gear: Gear) {
    let config = config(model, gear);
    let mut now = Instant::from_millis(1);
    let mut device = Device::restore(config, octets, now).expect("an image of such a drive");
    assert_eq!(device.image()[..], *octets, "restored, and it is another");
    let mut inputs = Inputs::default();
    for event in life.iter().take(20) {
        match event {
            Event::Wait { millis } => {
                now = now.saturating_add(Duration::from_millis((*millis % 500).into()));
                device.handle_timeout(now);
            }
            Event::Fault(fault) => {
                inputs = inputs.provoking(Fault::ALL[usize::from(*fault) % Fault::ALL.len()]);
                device.set_inputs(now, inputs);
            }
            Event::Nominal => {
                inputs = Inputs::default();
                device.set_inputs(now, inputs);
            }
            Event::PowerOff => device.power_off(now),
            Event::PowerOn => device.power_on(now),
        }
        inputs = *device.inputs();
        while device.poll_event().is_some() {}
    }
    assert!(device.poll_timeout().is_none_or(|due| due > now));
    let kept = device.image();
    let again = Device::restore(config, &kept, now).expect("a drive keeps what it can restore");
    assert_eq!(again.image(), kept, "restored later, and it is another");
    for parameter in Parameter::all().filter(|parameter| parameter.entry().persistent) {
        assert_eq!(again.parameters().value(parameter), device.parameters().value(parameter));
    }
}

fn config(model: Model, gear: Gear) -> Config {
    Config { model, gear, ..Config::new(Address::station(5).expect("below 127")) }
}

/// CRC-32 of IEEE 802.3 once more, by the table, apart from the one under test.
fn crc32(octets: &[u8]) -> u32 {
    const TABLE: [u32; 256] = {
        let (mut table, mut index) = ([0; 256], 0);
        while index < 256 {
            let (mut crc, mut bit) = (index as u32, 0);
            while bit < 8 {
                crc = if crc & 1 == 1 { (crc >> 1) ^ 0xEDB8_8320 } else { crc >> 1 };
                bit += 1;
            }
            table[index] = crc;
            index += 1;
        }
        table
    };
    !octets.iter().fold(!0, |crc, octet| (crc >> 8) ^ TABLE[usize::from(crc as u8 ^ octet)])
}
