//! What survives power-off, as octets: the image of one unit's EEPROM and of its absolute encoder.
//!
//! All numbers are big-endian.
//!
//! ```text
//! octet      0..8       8..10    10     11    12..14        14..110        110..120  120..122  122..130  130..138
//!         "PROFIDRV"  version  model  gear   length   24 parameters, i32    faults     count      zero     shaft
//!         └──────────────── header ───────────────┘└──────────────────── EEPROM ──────────────────────┘ └encoder┘
//!
//! version 1, no settings of a bus:  138..142 CRC-32
//! version 2:                        138 number n of octets, 1 to 128   139..139+n settings of the bus   4 octets CRC-32
//! ```
//!
//! - model: 1 = AG03, 2 = AG03/1; gear: 24 or 48; length: octets of the whole image.
//! - parameters: those of the table that the EEPROM keeps, in the order of [`Parameter::all`]. PNU 1035 is none of
//!   them (manual chapter 6, no. 30). On an AG03 the place of d-Pos holds its default.
//! - faults, count, zero and shaft: see [`Memory`]; zero and shaft in increments as IEEE 754 binary64. The EEPROM of
//!   the real drive does not hold the shaft's angle, its battery-buffered encoder does; so it is a section of its own.
//!   Both lie in one image because they are only worth something together: the position is the difference of shaft and
//!   zero.
//! - settings of the bus: what the bus on which the unit is keeps there; only the bus knows what they mean. Version 1 is
//!   what version 0.1.0 of this program writes; it is still written where there are none.
//! - CRC-32 (IEEE 802.3) of all octets before it.
//!
//! The factory's data ([`Identity`](crate::devices::ag03::param::Identity)) and the DIP switches are no part of it.

use core::ops::{Deref, DerefMut};

use thiserror::Error;

use crate::devices::ag03::drive::{Fault, FaultBuffer, Memory};
use crate::devices::ag03::param::{Gear, Model, ParamError, Parameter, Store};

/// Octets of an image without settings of a bus.
pub const IMAGE_LEN: usize = BODY_LEN + CRC_LEN;
/// The most octets that an image has.
pub const MAX_IMAGE_LEN: usize = BODY_LEN + 1 + BusSettings::MAX_LEN + CRC_LEN;

const MAGIC: [u8; 8] = *b"PROFIDRV";
/// Without and with settings of a bus.
const VERSIONS: [u16; 2] = [1, 2];
const HEADER_LEN: usize = MAGIC.len() + 2 + 1 + 1 + 2;
/// The octets that every image has before its end.
const BODY_LEN: usize = HEADER_LEN + 4 * KEPT + FaultBuffer::LEN + 2 + 8 + 8;
const CRC_LEN: usize = 4;
const _: () = assert!(IMAGE_LEN == 142);
/// How many parameters are kept: all but PNU 1035.
const KEPT: usize = Parameter::COUNT - 1;
/// Angles up to here, in increments: beyond 2^53 a binary64 does not count single increments any more.
const LARGEST_ANGLE: f64 = 9_007_199_254_740_992.0;

/// What one unit keeps while it is switched off.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// The stored parameters, model and gear. What the EEPROM does not keep reads as its default after decoding.
    pub store: Store,
    /// Faults, zero and angle of the shaft.
    pub memory: Memory,
    /// What the bus keeps.
    pub bus: BusSettings,
}

/// What a bus keeps in the EEPROM of a unit: octets that only the bus understands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BusSettings {
    octets: [u8; Self::MAX_LEN],
    len: u8,
}

/// More octets than the EEPROM has for the settings of a bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("the EEPROM keeps at most {} octets for a bus, got {got}", BusSettings::MAX_LEN)]
pub struct BusSettingsError {
    /// How many octets.
    pub got: usize,
}

impl BusSettings {
    /// The most octets.
    pub const MAX_LEN: usize = 128;

    /// None.
    pub const EMPTY: Self = Self { octets: [0; Self::MAX_LEN], len: 0 };

    /// These octets.
    ///
    /// # Errors
    /// [`BusSettingsError`] if they are more than [`BusSettings::MAX_LEN`].
    pub fn new(octets: &[u8]) -> Result<Self, BusSettingsError> {
        let error = BusSettingsError { got: octets.len() };
        let mut settings = Self::EMPTY;
        settings.octets.get_mut(..octets.len()).ok_or(error)?.copy_from_slice(octets);
        settings.len = u8::try_from(octets.len()).map_err(|_| error)?;
        Ok(settings)
    }
}

impl Deref for BusSettings {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        self.octets.get(..usize::from(self.len)).unwrap_or_default()
    }
}

/// The octets of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageOctets {
    octets: [u8; MAX_IMAGE_LEN],
    len: usize,
}

impl Deref for ImageOctets {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        self.octets.get(..self.len).unwrap_or_default()
    }
}

impl DerefMut for ImageOctets {
    fn deref_mut(&mut self) -> &mut [u8] {
        self.octets.get_mut(..self.len).unwrap_or_default()
    }
}

impl AsRef<[u8]> for ImageOctets {
    fn as_ref(&self) -> &[u8] {
        self
    }
}

/// Why octets are no image of a drive's EEPROM.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum ImageError {
    /// Octets are missing or too many.
    #[error("it has {got} octets, expected {expected}")]
    Length {
        /// Octets of an image.
        expected: usize,
        /// Octets found, or announced.
        got: usize,
    },
    /// It does not begin as an image does.
    #[error("it is no EEPROM image")]
    Foreign,
    /// It was written by another version of this program.
    #[error("it has format version {got}, expected at most {expected}")]
    Version {
        /// The newest version this program reads and writes.
        expected: u16,
        /// The version found.
        got: u16,
    },
    /// Octets were changed since it was written.
    #[error("it is damaged: its checksum is {got:08X}, expected {expected:08X}")]
    Checksum {
        /// The checksum of the octets found.
        expected: u32,
        /// The checksum found.
        got: u32,
    },
    /// No known drive has this model or gear.
    #[error("it is of a drive unknown to this version (model {model}, gear {gear})")]
    UnknownDrive {
        /// The number of the model.
        model: u8,
        /// The reduction of the gear.
        gear: u8,
    },
    /// It is of another drive.
    #[error("it is of an {} with gear {}, expected an {} with gear {}", got.0, got.1, expected.0, expected.1)]
    OtherDrive {
        /// The drive it was wanted for.
        expected: (Model, Gear),
        /// The drive it is of.
        got: (Model, Gear),
    },
    /// A parameter has a value it cannot have.
    #[error("its value of {parameter} is {got}, which must be within {low} to {high}")]
    OutOfRange {
        /// Which one.
        parameter: Parameter,
        /// Smallest value allowed.
        low: i32,
        /// Largest value allowed.
        high: i32,
        /// The value found.
        got: i32,
    },
    /// The fault buffer holds something that is no fault.
    #[error("its fault buffer holds {got:#04X}, which is no fault code")]
    FaultCode {
        /// The code found.
        got: u8,
    },
    /// An angle is no number or too large.
    #[error("its shaft angle or zero point is {got}, which is no angle")]
    Angle {
        /// The number found.
        got: f64,
    },
}

impl Image {
    /// The image of a unit as it left the factory, its shaft at 0.
    pub fn of_new(model: Model, gear: Gear) -> Self {
        Self { store: Store::new(model, gear), memory: Memory::default(), bus: BusSettings::EMPTY }
    }

    /// The octets of the image. What the EEPROM does not keep is left out.
    pub fn encode(&self) -> ImageOctets {
        let Self { store, memory: Memory { faults, zero, shaft }, bus } = self;
        let [plain, with_bus] = VERSIONS;
        let (version, len) =
            if bus.is_empty() { (plain, IMAGE_LEN) } else { (with_bus, IMAGE_LEN + 1 + bus.len()) };
        let mut image = ImageOctets { octets: [0; MAX_IMAGE_LEN], len };
        let mut writer = Writer { rest: &mut image };
        writer.put(&MAGIC);
        writer.put(&version.to_be_bytes());
        writer.put(&[model_number(store.model()), gear_number(store.gear())]);
        writer.put(&u16::try_from(len).unwrap_or(u16::MAX).to_be_bytes());
        for parameter in kept() {
            writer.put(&store.value(parameter).to_be_bytes());
        }
        writer.put(&faults.codes());
        writer.put(&faults.count().to_be_bytes());
        writer.put(&zero.to_be_bytes());
        writer.put(&shaft.to_be_bytes());
        if !bus.is_empty() {
            writer.put(&[bus.len]);
            writer.put(bus);
        }
        if let Some((body, crc)) = image.split_last_chunk_mut::<CRC_LEN>() {
            *crc = crc32(body).to_be_bytes();
        }
        image
    }

    /// Reads the image of a unit of this model and gear.
    ///
    /// # Errors
    /// [`ImageError`]; the first of its variants, in their order, that applies.
    pub fn decode(octets: &[u8], model: Model, gear: Gear) -> Result<Self, ImageError> {
        if !MAGIC.starts_with(octets) && !octets.starts_with(&MAGIC) {
            return Err(ImageError::Foreign);
        }
        let length = |expected| ImageError::Length { expected, got: octets.len() };
        let (body, crc) = octets.split_last_chunk::<CRC_LEN>().ok_or(length(IMAGE_LEN))?;
        let mut reader = Reader { rest: body, length: length(IMAGE_LEN) };
        let _magic: [u8; MAGIC.len()] = reader.take()?;
        let version = u16::from_be_bytes(reader.take()?);
        let [plain, with_bus] = VERSIONS;
        let expected = if version == plain {
            IMAGE_LEN
        } else if version == with_bus {
            let settings = octets
                .get(BODY_LEN)
                .copied()
                .filter(|len| (1..=BusSettings::MAX_LEN).contains(&(*len).into()));
            IMAGE_LEN + 1 + usize::from(settings.unwrap_or(1))
        } else {
            return Err(ImageError::Version { expected: with_bus, got: version });
        };
        if octets.len() != expected {
            return Err(length(expected));
        }
        let sum = (crc32(body), u32::from_be_bytes(*crc));
        if sum.0 != sum.1 {
            return Err(ImageError::Checksum { expected: sum.0, got: sum.1 });
        }
        reader.drive((model, gear), expected)?;
        let image = reader.contents(model, gear)?;
        let bus = match reader.rest.split_first() {
            None => BusSettings::EMPTY,
            Some((_, settings)) => BusSettings::new(settings).map_err(|_| length(expected))?,
        };
        Ok(Self { bus, ..image })
    }
}

const fn model_number(model: Model) -> u8 {
    match model {
        Model::Ag03 => 1,
        Model::Ag03_1 => 2,
    }
}

const fn gear_number(gear: Gear) -> u8 {
    match gear {
        Gear::Ratio24 => 24,
        Gear::Ratio48 => 48,
    }
}

/// The parameters in the image.
fn kept() -> impl Iterator<Item = Parameter> {
    Parameter::all().filter(|parameter| parameter.entry().persistent)
}

/// The checksum of zlib, PNG and Ethernet, bit by bit: an image is short and rarely written.
fn crc32(octets: &[u8]) -> u32 {
    !octets.iter().fold(u32::MAX, |crc, octet| {
        (0..8).fold(
            crc ^ u32::from(*octet),
            |crc, _| {
                if crc & 1 == 0 { crc >> 1 } else { crc >> 1 ^ 0xEDB8_8320 }
            },
        )
    })
}

/// The octets of an image still to be written.
struct Writer<'a> {
    rest: &'a mut [u8],
}

impl Writer<'_> {
    /// Writes a field. The fields together are as long as the image.
    fn put(&mut self, field: &[u8]) {
        if let Some(place) = self.rest.split_off_mut(..field.len()) {
            place.copy_from_slice(field);
        }
    }
}

/// The octets of an image still to be read.
struct Reader<'a> {
    rest: &'a [u8],
    /// What to say when they are too few.
    length: ImageError,
}

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], ImageError> {
        let (field, rest) = self.rest.split_first_chunk().ok_or(self.length)?;
        self.rest = rest;
        Ok(*field)
    }

    /// The rest of the header, behind magic and version.
    fn drive(&mut self, expected: (Model, Gear), len: usize) -> Result<(), ImageError> {
        let [model] = self.take()?;
        let [gear] = self.take()?;
        let announced = u16::from_be_bytes(self.take()?);
        if usize::from(announced) != len {
            return Err(ImageError::Length { expected: len, got: announced.into() });
        }
        let got = (
            Model::ALL.into_iter().find(|known| model_number(*known) == model),
            Gear::ALL.into_iter().find(|known| gear_number(*known) == gear),
        );
        match got {
            (Some(model), Some(gear)) if (model, gear) == expected => Ok(()),
            (Some(model), Some(gear)) => Err(ImageError::OtherDrive { expected, got: (model, gear) }),
            (Some(_), None) | (None, Some(_) | None) => Err(ImageError::UnknownDrive { model, gear }),
        }
    }

    /// Both sections, behind the header.
    fn contents(&mut self, model: Model, gear: Gear) -> Result<Image, ImageError> {
        let mut store = Store::new(model, gear);
        for parameter in kept() {
            self.parameter(&mut store, parameter)?;
        }
        let codes: [u8; FaultBuffer::LEN] = self.take()?;
        if let Some(&got) = codes.iter().find(|code| **code != 0 && Fault::of_code(**code).is_none()) {
            return Err(ImageError::FaultCode { got });
        }
        let faults = FaultBuffer::kept(codes, u16::from_be_bytes(self.take()?));
        let (zero, shaft) = (self.angle()?, self.angle()?);
        Ok(Image { store, memory: Memory { faults, zero, shaft }, bus: BusSettings::EMPTY })
    }

    fn parameter(&mut self, store: &mut Store, parameter: Parameter) -> Result<(), ImageError> {
        let got = i32::from_be_bytes(self.take()?);
        let default = parameter.setting().default;
        match store.set(parameter, got) {
            Ok(()) => Ok(()),
            Err(ParamError::OutOfRange { low, high, got }) => {
                Err(ImageError::OutOfRange { parameter, low, high, got })
            }
            // The model does not have it.
            Err(_) if got == default => Ok(()),
            Err(_) => Err(ImageError::OutOfRange { parameter, low: default, high: default, got }),
        }
    }

    fn angle(&mut self) -> Result<f64, ImageError> {
        let got = f64::from_be_bytes(self.take()?);
        // Not a comparison that a NaN would pass.
        if got.abs() <= LARGEST_ANGLE { Ok(got) } else { Err(ImageError::Angle { got }) }
    }
}

#[cfg(test)]
mod tests;
