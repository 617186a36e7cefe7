//! What must hold for any input, one file a target. The fuzzer calls `check`, and so does `tests/slave/fuzz_corpus.rs`,
//! which replays the corpora on a stable compiler.
#![allow(dead_code, reason = "each target uses its own file")]

pub(crate) mod ag03_node;
#[path = "../../tests/helpers/canopen_device/mod.rs"]
pub(crate) mod canopen_device;
pub(crate) mod canopen_node;
#[cfg(all(feature = "capture", feature = "judge"))]
pub(crate) mod capture;
pub(crate) mod clients;
#[cfg(feature = "std")]
pub(crate) mod decode_cli;
pub(crate) mod dpv1;
#[cfg(feature = "eds")]
pub(crate) mod eds;
#[cfg(feature = "eds")]
pub(crate) mod eds_node;
pub(crate) mod eeprom_image;
pub(crate) mod framer;
#[cfg(feature = "std")]
pub(crate) mod gsd;
#[cfg(feature = "judge")]
pub(crate) mod observer;
pub(crate) mod pkw_ops;
#[cfg(feature = "parameters")]
pub(crate) mod ppo_drive;
#[cfg(feature = "std")]
pub(crate) mod products;
pub(crate) mod sdo_server;
pub(crate) mod slave_ops;
pub(crate) mod slcan;
pub(crate) mod telegram;

use arbitrary::{Arbitrary, Unstructured};

/// Octets in one piece behind their number, so that a telegram stands in an input as it stands on the line: the
/// fuzzer can splice golden vectors, which it cannot with the `Vec<u8>` of the derived format.
#[derive(Debug)]
pub(crate) struct Octets<'a>(pub(crate) &'a [u8]);

impl<'a> Arbitrary<'a> for Octets<'a> {
    fn arbitrary(input: &mut Unstructured<'a>) -> arbitrary::Result<Self> {
        let announced: u8 = input.arbitrary()?;
        input.bytes(usize::from(announced).min(input.len())).map(Self)
    }
}
