//! What a station keeps while it is switched off, beside its own process, and the file of it: the address that
//! Set_Slave_Add gave it, and the parameters and records that were written.
//!
//! The content of an [image](mod@crate::image) of the product `gsd-IDENT` or `ppo-IDENT`, numbers big-endian:
//!
//! ```text
//! octet 0      station address
//! octet 1      1: No_Add_Chg
//! octet 2      number n of octets of Rem_Slave_Data
//! 3..3+n       Rem_Slave_Data
//! then         of `ppo-`: parameters: number (2), element from 0 (1), bits (4)
//!              of `gsd-`: records: slot, index, number n of octets, n octets; of slot 0, index 255: number (2) of a block
//!              of identification and its 64 octets
//! ```

use super::state_dir::{ImageFile, Newest, StateDir, StateDirError};
use crate::devices::KeptValue;
use crate::image;
use crate::image::storage;
use crate::image::storage::Outcome;
use crate::image::{Generation, ImageError, NotStored, Writer};
use crate::profibus::dp::StoredAddress;
use crate::profibus::dpv1::CALL_INDEX;
use crate::profibus::dpv1::identification::LEN;
use crate::profibus::fdl::Address;

/// Room for the image of a station with every parameter or record that there can be.
const LONGEST: usize = 1024 * 1024;

/// Room for everything but the records.
const WITHOUT_RECORDS: usize = 32 * 1024;

/// Octets of a record beside its data.
const RECORD_HEAD: usize = 3;

/// The most records of a station: [`LONGEST`] holds all of them.
pub(super) const MAX_RECORDS: usize = 4000;

/// Names the stations whose images hold records.
const WITH_RECORDS: &str = "gsd";

/// What a station keeps.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Kept {
    pub(super) address: StoredAddress,
    pub(super) rem_slave_data: Vec<u8>,
    pub(super) values: Vec<KeptValue>,
    pub(super) records: Vec<KeptRecord>,
}

/// A record, or a block of identification and maintenance.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum KeptRecord {
    Record((u8, u8), Vec<u8>),
    Block(u16, [u8; LEN]),
}

impl Kept {
    fn encode(&self, product: &str) -> Vec<u8> {
        let room = self.records.iter().map(|record| RECORD_HEAD + record.len()).sum::<usize>();
        let mut octets = vec![0; WITHOUT_RECORDS + room];
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
        for record in &self.records {
            let len = u8::try_from(record.len()).unwrap_or_default();
            match record {
                KeptRecord::Record((slot, index), data) => {
                    writer.put(&[*slot, *index, len]);
                    writer.put(data);
                }
                KeptRecord::Block(block, octets) => {
                    writer.put(&[0, CALL_INDEX, len]);
                    writer.put(&block.to_be_bytes());
                    writer.put(octets);
                }
            }
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
        let (rem, rest) = rest.split_at_checked(rem_len.into()).ok_or(ImageError::Foreign)?;
        let with_records = product.starts_with(WITH_RECORDS);
        let (values, records) = if with_records { (&[][..], rest) } else { (rest, &[][..]) };
        let address = Address::station(address).map_err(|_| ImageError::Foreign)?;
        let value = |&[a, b, place, c, d, e, f]: &[u8; 7]| {
            ((u16::from_be_bytes([a, b]), place), u32::from_be_bytes([c, d, e, f]))
        };
        Ok(Self {
            address: StoredAddress { address, no_add_chg: no_add_chg != 0 },
            rem_slave_data: rem.to_vec(),
            values: values.as_chunks().0.iter().map(value).collect(),
            records: KeptRecord::all(records).ok_or(ImageError::Foreign)?,
        })
    }
}

impl KeptRecord {
    const fn len(&self) -> usize {
        match self {
            Self::Record(_, data) => data.len(),
            Self::Block(..) => 2 + LEN,
        }
    }

    fn all(mut octets: &[u8]) -> Option<Vec<Self>> {
        let mut records = Vec::new();
        while let Some((&[slot, index, len], rest)) = octets.split_first_chunk::<RECORD_HEAD>() {
            let (data, rest) = rest.split_at_checked(len.into())?;
            octets = rest;
            records.push(if index == CALL_INDEX {
                let (block, data) = data.split_first_chunk()?;
                Self::Block(u16::from_be_bytes(*block), data.try_into().ok()?)
            } else {
                Self::Record((slot, index), data.to_vec())
            });
        }
        octets.is_empty().then_some(records)
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
            records: Vec::new(),
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

    #[test]
    fn records_and_blocks_are_kept_octet_for_octet() {
        let kept = Kept {
            address: StoredAddress { address: Address::station(7).unwrap(), no_add_chg: false },
            rem_slave_data: vec![1, 2],
            values: Vec::new(),
            records: vec![
                KeptRecord::Record((1, 10), vec![0xAB; 240]),
                KeptRecord::Record((254, 0), vec![5]),
                KeptRecord::Block(1, [b'x'; LEN]),
            ],
        };
        let octets = kept.encode("gsd-0a02");
        assert_eq!(Kept::decode(&octets, "gsd-0a02"), Ok(kept.clone()));
        let none = Kept { records: Vec::new(), ..kept };
        assert_eq!(Kept::decode(&none.encode("gsd-0a02"), "gsd-0a02"), Ok(none));
        for cut in [&[1][..], &[1, 10, 2, 0], &[0, CALL_INDEX, 3, 0, 1, 9]] {
            assert_eq!(KeptRecord::all(cut), None, "{cut:02X?}");
        }
    }
}
