//! What survives power-off, as octets: the image of one drive's EEPROM and of its absolute encoder.
//!
//! All numbers are big-endian, as on the bus.
//!
//! ```text
//! octet      0..8       8..10    10     11    12..14        14..110        110..120  120..122  122..130  130..138  138..142
//!         "PROFIDRV"  version  model  gear   length   24 parameters, i32    faults     count      zero     shaft     CRC-32
//!         └──────────────── header ───────────────┘└──────────────────── EEPROM ──────────────────────┘ └ encoder ┘
//! ```
//!
//! - model: 1 = AG03, 2 = AG03/1; gear: 24 or 48; length: octets of the whole image.
//! - parameters: those of the table that the EEPROM keeps, in the order of [`Parameter::all`]. PNU 1035 is none of
//!   them (manual chapter 6, no. 30). On an AG03 the place of d-Pos holds its default.
//! - faults and count: PNU 945, newest first, and PNU 952.
//! - zero: shaft angle at the user position 0, in increments, as IEEE 754 binary64; calibration sets it.
//! - shaft: angle of the output shaft in increments, likewise. The EEPROM of the real drive does not hold it, its
//!   battery-buffered encoder does; so it is a section of its own. Both lie in one image because they are only worth
//!   something together: the position is the difference of shaft and zero.
//! - CRC-32 (IEEE 802.3) of all octets before it.
//!
//! The factory's data ([`super::Identity`]) and the DIP switches are no part of it.

use thiserror::Error;

use super::{FAULT_BUFFER_LEN, Gear, Model, ParamError, Parameter, Store};

/// Octets of an image.
pub const IMAGE_LEN: usize = HEADER_LEN + 4 * KEPT + FAULT_BUFFER_LEN as usize + 2 + 8 + 8 + CRC_LEN;

const MAGIC: [u8; 8] = *b"PROFIDRV";
const VERSION: u16 = 1;
const HEADER_LEN: usize = MAGIC.len() + 2 + 1 + 1 + 2;
const CRC_LEN: usize = 4;
/// [`IMAGE_LEN`] as the header says it.
const ANNOUNCED_LEN: u16 = 142;
const _: () = assert!(ANNOUNCED_LEN as usize == IMAGE_LEN);
/// How many parameters are kept: all but PNU 1035.
const KEPT: usize = Parameter::COUNT - 1;
/// Angles up to here, in increments: beyond 2^53 a binary64 does not count single increments any more.
const LARGEST_ANGLE: f64 = 9_007_199_254_740_992.0;
/// What a place of the fault buffer can hold besides 0 (`ag03.md` 3.1, PNU 945).
const FAULT_CODES: &[u8] = b"ABCDEFGJ";

/// What one drive keeps while it is switched off.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// The stored parameters, model and gear. What the EEPROM does not keep reads as its default after decoding.
    pub store: Store,
    /// PNU 945, codes of the last ten faults, newest first, 0 = unused.
    pub fault_buffer: [u8; FAULT_BUFFER_LEN as usize],
    /// PNU 952, number of faults.
    pub fault_count: u16,
    /// Shaft angle at the user position 0, in increments.
    pub zero: f64,
    /// Angle of the output shaft in increments, which the battery-buffered encoder knows.
    pub shaft: f64,
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
    #[error("it has format version {got}, expected {expected}")]
    Version {
        /// The version this program reads and writes.
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
    /// The image of a drive as it left the factory, its shaft at 0.
    pub fn of_new(model: Model, gear: Gear) -> Self {
        let store = Store::new(model, gear);
        Self { store, fault_buffer: [0; FAULT_BUFFER_LEN as usize], fault_count: 0, zero: 0.0, shaft: 0.0 }
    }

    /// The octets of the image. What the EEPROM does not keep is left out.
    pub fn encode(&self) -> [u8; IMAGE_LEN] {
        let mut octets = [0; IMAGE_LEN];
        let mut writer = Writer { rest: &mut octets };
        writer.put(&MAGIC);
        writer.put(&VERSION.to_be_bytes());
        writer.put(&[model_number(self.store.model()), gear_number(self.store.gear())]);
        writer.put(&ANNOUNCED_LEN.to_be_bytes());
        for parameter in kept() {
            writer.put(&self.store.value(parameter).to_be_bytes());
        }
        writer.put(&self.fault_buffer);
        writer.put(&self.fault_count.to_be_bytes());
        writer.put(&self.zero.to_be_bytes());
        writer.put(&self.shaft.to_be_bytes());
        if let Some((body, crc)) = octets.split_last_chunk_mut::<CRC_LEN>() {
            *crc = crc32(body).to_be_bytes();
        }
        octets
    }

    /// Reads the image of a drive of this model and gear.
    ///
    /// # Errors
    /// [`ImageError`]; the first of its variants, in their order, that applies.
    pub fn decode(octets: &[u8], model: Model, gear: Gear) -> Result<Self, ImageError> {
        if !MAGIC.starts_with(octets) && !octets.starts_with(&MAGIC) {
            return Err(ImageError::Foreign);
        }
        let length = ImageError::Length { expected: IMAGE_LEN, got: octets.len() };
        let (body, crc) = octets.split_last_chunk::<CRC_LEN>().ok_or(length)?;
        let mut reader = Reader { rest: body, length };
        let _magic: [u8; MAGIC.len()] = reader.take()?;
        let version = u16::from_be_bytes(reader.take()?);
        if version != VERSION {
            return Err(ImageError::Version { expected: VERSION, got: version });
        }
        if octets.len() != IMAGE_LEN {
            return Err(length);
        }
        let (expected, got) = (crc32(body), u32::from_be_bytes(*crc));
        if expected != got {
            return Err(ImageError::Checksum { expected, got });
        }
        reader.drive((model, gear))?;
        reader.contents(model, gear)
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
    fn drive(&mut self, expected: (Model, Gear)) -> Result<(), ImageError> {
        let [model] = self.take()?;
        let [gear] = self.take()?;
        let announced = u16::from_be_bytes(self.take()?);
        if announced != ANNOUNCED_LEN {
            return Err(ImageError::Length { expected: IMAGE_LEN, got: announced.into() });
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
        let fault_buffer: [u8; FAULT_BUFFER_LEN as usize] = self.take()?;
        if let Some(&got) = fault_buffer.iter().find(|code| **code != 0 && !FAULT_CODES.contains(code)) {
            return Err(ImageError::FaultCode { got });
        }
        let fault_count = u16::from_be_bytes(self.take()?);
        let (zero, shaft) = (self.angle()?, self.angle()?);
        Ok(Image { store, fault_buffer, fault_count, zero, shaft })
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
