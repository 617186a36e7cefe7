//! What survives power-off, as octets: the image of one unit's EEPROM and of its absolute encoder.
//!
//! The content of an [image](mod@crate::image); all numbers are big-endian:
//!
//! ```text
//! octet        0..96          96..106   106..108  108..116  116..124
//!       24 parameters, i32    faults     count      zero     shaft
//!       └──────────────────── EEPROM ──────────────────────┘ └encoder┘
//!
//! version 2:   124 number n of octets, 1 to 128   125..125+n settings of the bus
//! ```
//!
//! - model: 1 = AG03, 2 = AG03/1; gear: 24 or 48.
//! - parameters: those of the table that the EEPROM keeps, in the order of [`Parameter::all`]. PNU 1035 is none of
//!   them (manual chapter 6, no. 30). On an AG03 the place of d-Pos holds its default.
//! - faults, count, zero and shaft: see [`Memory`]; zero and shaft in increments as IEEE 754 binary64. The EEPROM of
//!   the real drive does not hold the shaft's angle, its battery-buffered encoder does; so it is a section of its own.
//!   Both lie in one image because they are only worth something together: the position is the difference of shaft and
//!   zero.
//! - settings of the bus: what the bus on which the unit is keeps there; only the bus knows what they mean. Version 1 is
//!   what version 0.1.0 of this program writes; it is still written where there are none.
//!
//! The factory's data ([`Identity`](crate::devices::ag03::param::Identity)) and the DIP switches are no part of it.

use core::ops::{Deref, DerefMut};

use thiserror::Error;

use crate::devices::ag03::drive::{Fault, FaultBuffer, Memory};
use crate::devices::ag03::param::{Gear, Model, ParamError, Parameter, Store};
use crate::image;
use crate::image::{FRAME_LEN, Writer};

/// Octets of an image without settings of a bus.
pub const IMAGE_LEN: usize = FRAME_LEN + 4 * Parameter::KEPT + FaultBuffer::LEN + 2 + 8 + 8;
/// The most octets that an image has.
pub const MAX_IMAGE_LEN: usize = IMAGE_LEN + 1 + BusSettings::MAX_LEN;

/// Without settings of a bus.
const PLAIN: u16 = 1;
/// With settings of a bus.
const WITH_BUS: u16 = 2;
const _: () = assert!(IMAGE_LEN == 142);
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
    pub(crate) const MAX_LEN: usize = 128;

    /// None.
    pub(crate) const EMPTY: Self = Self { octets: [0; Self::MAX_LEN], len: 0 };

    /// These octets.
    ///
    /// # Errors
    /// [`BusSettingsError`] if they are more than [`BusSettings::MAX_LEN`].
    pub(crate) fn new(octets: &[u8]) -> Result<Self, BusSettingsError> {
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
    /// It is no whole image, or one of another product.
    #[error(transparent)]
    Image(#[from] image::ImageError),
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
        let version = if bus.is_empty() { PLAIN } else { WITH_BUS };
        let mut octets = [0; MAX_IMAGE_LEN];
        let numbers = [model_number(store.model()), gear_number(store.gear())];
        let mut writer = Writer::numbered(&mut octets, version, numbers);
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
        // There is room for all of it.
        let len = writer.finish().unwrap_or_default();
        ImageOctets { octets, len }
    }

    /// Reads the image of a unit of this model and gear.
    ///
    /// # Errors
    /// [`ImageError`]; the first of its variants, in their order, that applies.
    pub fn decode(octets: &[u8], model: Model, gear: Gear) -> Result<Self, ImageError> {
        let length = |expected| image::ImageError::Length { expected, got: octets.len() };
        let opened = image::open(octets);
        // What is too short for the head does not say how long it should be.
        if octets.len() < FRAME_LEN && matches!(opened, Err(image::ImageError::Length { .. })) {
            return Err(length(IMAGE_LEN).into());
        }
        let opened = opened?;
        if !matches!(opened.version, PLAIN | WITH_BUS) {
            let (got, _) = opened.product();
            let expected = image::ProductName::new(model.product_name());
            return Err(image::ImageError::OtherProduct { expected, got }.into());
        }
        judge_drive(opened.numbers, (model, gear))?;
        let mut reader = Reader { rest: opened.content, length: length(IMAGE_LEN).into() };
        let image = reader.contents(model, gear)?;
        let bus = match reader.rest.split_first() {
            None if opened.version == PLAIN => BusSettings::EMPTY,
            Some((len, settings)) if opened.version == WITH_BUS && usize::from(*len) == settings.len() => {
                let most = length(MAX_IMAGE_LEN);
                BusSettings::new(settings).ok().filter(|settings| !settings.is_empty()).ok_or(most)?
            }
            None | Some(_) => return Err(length(IMAGE_LEN).into()),
        };
        Ok(Self { bus, ..image })
    }
}

/// Whether the numbers of an image are those of this drive.
fn judge_drive([model, gear]: [u8; 2], expected: (Model, Gear)) -> Result<(), ImageError> {
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
