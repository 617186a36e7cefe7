//! What a station keeps while it is switched off, beside its own process, and the file of it: the address that
//! Set_Slave_Add gave it, and the parameters that were written.
//!
//! The content of an [image](mod@crate::image) of the product `gsd-IDENT` or `ppo-IDENT`, numbers big-endian:
//!
//! ```text
//! octet 0      station address
//! octet 1      1: No_Add_Chg
//! octet 2      number n of octets of Rem_Slave_Data
//! 3..3+n       Rem_Slave_Data
//! then         parameters: number (2), element from 0 (1), bits (4)
//! ```

use super::state_dir::{ImageFile, Newest, StateDir, StateDirError};
use crate::image;
use crate::image::storage;
use crate::image::storage::Outcome;
use crate::image::{Generation, ImageError, NotStored, Writer};
use crate::profibus::dp::StoredAddress;
use crate::profibus::fdl::Address;

/// Room for the image of a station with every parameter that there can be.
const LONGEST: usize = 32 * 1024;

/// What a station keeps.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Kept {
    pub(super) address: StoredAddress,
    pub(super) rem_slave_data: Vec<u8>,
    pub(super) values: Vec<KeptValue>,
}

/// The bits of one element of a parameter.
pub(super) type KeptValue = ((u16, u8), u32);

impl Kept {
    fn encode(&self, product: &str) -> Vec<u8> {
        let mut octets = vec![0; LONGEST];
        let mut writer = Writer::named(&mut octets, product);
        let rem = self.rem_slave_data.get(..240).unwrap_or(&self.rem_slave_data);
        let rem_len = u8::try_from(rem.len()).unwrap_or_default();
        writer.put(&[self.address.address.number(), self.address.no_add_chg.into(), rem_len]);
        writer.put(rem);
        for ((pnu, place), bits) in &self.values {
            writer.put(&pnu.to_be_bytes());
            writer.put(&[*place]);
            writer.put(&bits.to_be_bytes());
        }
        // There is room for all of it.
        let len = writer.finish().unwrap_or_default();
        octets.truncate(len);
        octets
    }

    fn decode(octets: &[u8], product: &str) -> Result<Self, ImageError> {
        let content = image::open(octets)?.of(product)?;
        let (&[address, no_add_chg, rem_len], rest) =
            content.split_first_chunk().ok_or(ImageError::Foreign)?;
        let (rem, values) = rest.split_at_checked(rem_len.into()).ok_or(ImageError::Foreign)?;
        let address = Address::station(address).map_err(|_| ImageError::Foreign)?;
        let value = |&[a, b, place, c, d, e, f]: &[u8; 7]| {
            ((u16::from_be_bytes([a, b]), place), u32::from_be_bytes([c, d, e, f]))
        };
        Ok(Self {
            address: StoredAddress { address, no_add_chg: no_add_chg != 0 },
            rem_slave_data: rem.to_vec(),
            values: values.as_chunks().0.iter().map(value).collect(),
        })
    }
}

/// The image of a station, as its host takes it.
#[derive(Debug)]
pub(super) struct KeptImage {
    product: String,
    octets: Vec<u8>,
    newest: storage::Newest,
}

impl KeptImage {
    /// The file of the station that is added with this address, its image, and what it keeps. A station from the factory
    /// keeps nothing yet.
    ///
    /// # Errors
    /// [`StateDirError::Owned`], [`StateDirError::File`], [`StateDirError::Refused`]; the file is as before.
    pub(super) fn open(
        state: &StateDir,
        kind: &str,
        ident: u16,
        address: Address,
    ) -> Result<(ImageFile<Generation>, Self, Option<Kept>), StateDirError> {
        let product = format!("{kind}-{ident:04x}");
        let (file, found) = state.file(&format!("{product}-{:03}", address.number()), LONGEST)?;
        let mut this = Self { product, octets: Vec::new(), newest: storage::Newest::SAFE };
        let Some(Newest { octets, safe }) = found else { return Ok((file, this, None)) };
        let kept = Kept::decode(&octets, &this.product)
            .map_err(|cause| StateDirError::Refused { path: file.path(), cause: Box::new(cause) })?;
        tracing::info!("EEPROM from {}", file.path().display());
        if !safe {
            this.offer(octets);
        }
        Ok((file, this, Some(kept)))
    }

    fn offer(&mut self, octets: Vec<u8>) {
        self.octets = octets;
        self.newest.offer();
    }

    /// This is to be kept instead of all before it. `waits`: somebody waits for what [`KeptImage::report`] says.
    pub(super) fn keep(&mut self, kept: &Kept, waits: bool) {
        let octets = kept.encode(&self.product);
        self.offer(octets);
        if waits {
            self.newest.wait();
        }
    }

    /// The image to keep now.
    pub(super) fn poll(&mut self) -> Option<(Generation, Vec<u8>)> {
        self.newest.take().map(|generation| (generation, self.octets.clone()))
    }

    /// What became of an image, for whoever waits.
    pub(super) fn report(&mut self, generation: Generation, stored: bool) -> Outcome {
        self.newest.report(generation, if stored { Ok(()) } else { Err(NotStored) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::ProductName;

    #[test]
    fn what_was_encoded_is_decoded_and_refused_by_another_product() {
        let kept = Kept {
            address: StoredAddress { address: Address::station(9).unwrap(), no_add_chg: true },
            rem_slave_data: vec![0xAB; 240],
            values: vec![((100, 0), 5), ((915, 7), 0xFFFF_FFFF)],
        };
        let octets = kept.encode("ppo-5044");
        assert_eq!(Kept::decode(&octets, "ppo-5044"), Ok(kept));
        let (expected, got) = (ProductName::new("gsd-0a02"), ProductName::new("ppo-5044"));
        let error = Err(ImageError::OtherProduct { expected, got });
        assert_eq!(Kept::decode(&octets, "gsd-0a02"), error);
        for len in 0..octets.len() {
            assert!(Kept::decode(&octets[..len], "ppo-5044").is_err(), "{len} octets");
        }
    }
}
