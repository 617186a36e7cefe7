//! Images: what a device keeps while it is switched off, as octets that name the product they are of.
//!
//! ```text
//! octet      0..8       8..10    10     11    12..14   14..len-4   last 4
//!         "PROFIDRV"  version  model  gear   length    content     CRC-32
//!
//! version 3:  model and gear are 0; the content begins with the length of the product's name (1 octet) and the name
//! ```
//!
//! - All numbers are big-endian; length: octets of the whole image; CRC-32 (IEEE 802.3) of all octets before it.
//! - Versions 1 and 2 are of the AG03 family, which has numbers for model and gear. Version 0.1.0 of this program wrote
//!   version 1, and it is written still.
//! - What lies in the content only the device knows.

pub(crate) mod storage;

use core::fmt;

use thiserror::Error;

pub use storage::{Eeprom, Generation, NotStored, StoreRequest};

const MAGIC: [u8; 8] = *b"PROFIDRV";
/// The version of images that name their product.
const NAMED: u16 = 3;
const HEADER_LEN: usize = 14;
const CRC_LEN: usize = 4;
/// Where the length lies.
const LENGTH: core::ops::Range<usize> = 12..HEADER_LEN;

/// Octets of an image beside its content and, in version 3, beside the octet of its length and the name.
pub(crate) const FRAME_LEN: usize = HEADER_LEN + CRC_LEN;

/// Octets that are no image for a device, or no room for one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ImageError {
    /// The buffer is too short.
    #[error("the image needs more than {got} octets")]
    NoRoom {
        /// Octets of the buffer.
        got: usize,
    },
    /// Octets are missing or too many.
    #[error("it has {got} octets, expected {expected}")]
    Length {
        /// Octets that it should have.
        expected: usize,
        /// Octets found.
        got: usize,
    },
    /// It does not begin as an image does.
    #[error("it is no EEPROM image")]
    Foreign,
    /// It was written by another version of this program.
    #[error("it has format version {got}, expected at most {expected}")]
    Version {
        /// The newest version that is read.
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
    /// It is of another product.
    #[error("it is of another device: {got}, expected {expected}")]
    OtherProduct {
        /// The product it was wanted for.
        expected: ProductName,
        /// The product it is of.
        got: ProductName,
    },
}

/// The name of a product in an image, as `ap10`.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct ProductName {
    octets: [u8; Self::MAX_LEN],
}

impl ProductName {
    /// The most octets; what is longer is cut off.
    pub(crate) const MAX_LEN: usize = 32;

    /// This name.
    pub(crate) fn new(name: &str) -> Self {
        let mut octets = [0; Self::MAX_LEN];
        for (place, octet) in octets.iter_mut().zip(name.bytes()) {
            *place = octet;
        }
        Self { octets }
    }

    fn as_octets(&self) -> &[u8] {
        let len = self.octets.iter().position(|octet| *octet == 0).unwrap_or(Self::MAX_LEN);
        self.octets.get(..len).unwrap_or_default()
    }
}

impl fmt::Display for ProductName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.as_octets().utf8_chunks().try_for_each(|chunk| f.write_str(chunk.valid()))
    }
}

impl fmt::Debug for ProductName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}")
    }
}

/// Writes an image from its beginning. What has no room is found out at the end.
pub(crate) struct Writer<'a> {
    into: &'a mut [u8],
    len: usize,
}

impl<'a> Writer<'a> {
    /// An image of a product with a name.
    pub(crate) fn named(into: &'a mut [u8], product: &str) -> Self {
        let mut writer = Self::numbered(into, NAMED, [0, 0]);
        let name = ProductName::new(product);
        let name = name.as_octets();
        writer.put(&[u8::try_from(name.len()).unwrap_or(u8::MAX)]);
        writer.put(name);
        writer
    }

    /// An image of a product with numbers for model and gear.
    pub(crate) fn numbered(into: &'a mut [u8], version: u16, numbers: [u8; 2]) -> Self {
        let mut writer = Self { into, len: 0 };
        writer.put(&MAGIC);
        writer.put(&version.to_be_bytes());
        writer.put(&numbers);
        writer.put(&[0; 2]);
        writer
    }

    /// Writes octets of the content.
    pub(crate) fn put(&mut self, octets: &[u8]) {
        let free = self.into.get_mut(self.len..).and_then(|free| free.split_at_mut_checked(octets.len()));
        if let Some((room, _)) = free {
            room.copy_from_slice(octets);
        }
        self.len = self.len.saturating_add(octets.len());
    }

    /// Writes length and checksum. Says how many octets the image has.
    ///
    /// # Errors
    /// [`ImageError::NoRoom`].
    pub(crate) fn finish(self) -> Result<usize, ImageError> {
        let Self { into, len } = self;
        let no_room = ImageError::NoRoom { got: into.len() };
        let whole = len.saturating_add(CRC_LEN);
        let image = into.get_mut(..whole).ok_or(no_room)?;
        let length = u16::try_from(whole).map_err(|_| no_room)?;
        image.get_mut(LENGTH).ok_or(no_room)?.copy_from_slice(&length.to_be_bytes());
        let (body, crc) = image.split_last_chunk_mut().ok_or(no_room)?;
        *crc = crc32(body).to_be_bytes();
        Ok(whole)
    }
}

/// A whole image.
pub(crate) struct Opened<'a> {
    pub(crate) version: u16,
    /// Of model and gear.
    pub(crate) numbers: [u8; 2],
    pub(crate) content: &'a [u8],
}

/// Opens an image of any product.
///
/// # Errors
/// All but [`ImageError::OtherProduct`].
pub(crate) fn open(octets: &[u8]) -> Result<Opened<'_>, ImageError> {
    if !MAGIC.starts_with(octets) && !octets.starts_with(&MAGIC) {
        return Err(ImageError::Foreign);
    }
    let length = |expected| ImageError::Length { expected, got: octets.len() };
    let (body, crc) = octets.split_last_chunk().ok_or(length(FRAME_LEN))?;
    let (header, content) = body.split_first_chunk::<HEADER_LEN>().ok_or(length(FRAME_LEN))?;
    let [_, _, _, _, _, _, _, _, high, low, model, gear, long, short] = *header;
    let version = u16::from_be_bytes([high, low]);
    if !(1..=NAMED).contains(&version) {
        return Err(ImageError::Version { expected: NAMED, got: version });
    }
    let announced = usize::from(u16::from_be_bytes([long, short]));
    if announced != octets.len() {
        return Err(length(announced));
    }
    let (expected, got) = (crc32(body), u32::from_be_bytes(*crc));
    if expected != got {
        return Err(ImageError::Checksum { expected, got });
    }
    Ok(Opened { version, numbers: [model, gear], content })
}

impl<'a> Opened<'a> {
    /// The content of an image of this product.
    ///
    /// # Errors
    /// [`ImageError::OtherProduct`].
    pub(crate) fn of(self, product: &str) -> Result<&'a [u8], ImageError> {
        let expected = ProductName::new(product);
        let (got, content) = self.product();
        if got == expected { Ok(content) } else { Err(ImageError::OtherProduct { expected, got }) }
    }

    /// Whose it is, and the content behind the name.
    pub(crate) fn product(&self) -> (ProductName, &'a [u8]) {
        let named = match self.content.split_first() {
            Some((len, rest)) if self.version == NAMED => rest.split_at_checked(usize::from(*len)),
            Some(_) | None => None,
        };
        match named {
            Some((name, content)) => {
                (ProductName::new(core::str::from_utf8(name).unwrap_or("unknown")), content)
            }
            None => (ProductName::new("AG03 or AG03/1"), self.content),
        }
    }
}

/// The checksum of zlib, PNG and Ethernet, bit by bit: an image is short and rarely written.
pub(crate) fn crc32(octets: &[u8]) -> u32 {
    !octets.iter().fold(u32::MAX, |crc, octet| {
        (0..8).fold(
            crc ^ u32::from(*octet),
            |crc, _| {
                if crc & 1 == 0 { crc >> 1 } else { crc >> 1 ^ 0xEDB8_8320 }
            },
        )
    })
}

#[cfg(test)]
mod tests;
