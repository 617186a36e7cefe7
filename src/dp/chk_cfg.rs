//! Chk_Cfg (SAP 62) and Get_Cfg (SAP 59): configuration identifiers.
//!
//! ```text
//! general   b7 consistency over the whole  b6 unit is a word  b5 output  b4 input  b3..b0 units - 1
//! special   b7 an output length octet follows  b6 an input length octet follows  b5 b4 = 0
//!           b3..b0 manufacturer octets behind them: 0..=14; 15 = none, not compared
//! length    b7 consistency  b6 unit is a word  b5..b0 units - 1
//! ```
//!
//! Input and output are seen from the master. A special octet with b7 = b6 = 0 is an empty slot. Output length
//! comes before input length. Source: `dp-v0.md` 6.1.

use nom::bytes::complete::take;
use nom::combinator::cond;
use nom::error::{ErrorKind, ParseError};
use nom::number::complete::be_u8;
use nom::{IResult, Parser};
use thiserror::Error;

use super::Refusal;

/// The most input or output octets of a slave.
pub const MAX_IO_LEN: usize = 244;

/// How many octets a configuration exchanges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct IoLengths {
    /// Master to slave, 0..=244.
    pub outputs: u8,
    /// Slave to master, 0..=244.
    pub inputs: u8,
}

impl IoLengths {
    /// Adds up the identifiers of a configuration.
    ///
    /// # Errors
    /// [`CfgSyntax`] if an identifier is cut off or a sum exceeds 244 octets.
    pub fn of(identifiers: &[u8]) -> Result<Self, CfgSyntax> {
        let (mut outputs, mut inputs) = (0_usize, 0_usize);
        let mut rest = identifiers;
        while !rest.is_empty() {
            let (behind, lengths) = identifier(rest).map_err(|_| CfgSyntax::CutOff)?;
            outputs += lengths.0;
            inputs += lengths.1;
            rest = behind;
        }
        let octets = |got: usize| match u8::try_from(got) {
            Ok(octets) if got <= MAX_IO_LEN => Ok(octets),
            Ok(_) | Err(_) => Err(CfgSyntax::TooLong { got }),
        };
        Ok(Self { outputs: octets(outputs)?, inputs: octets(inputs)? })
    }
}

/// The identifiers of a configuration one by one, each with its length and manufacturer octets. Ends before one that is
/// cut off.
pub fn identifiers(configuration: &[u8]) -> impl Iterator<Item = &[u8]> {
    let mut rest = configuration;
    core::iter::from_fn(move || {
        let (behind, _) = identifier(rest).ok()?;
        let (this, _) = rest.split_at_checked(rest.len() - behind.len())?;
        rest = behind;
        Some(this)
    })
}

/// Why a string of octets is no configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum CfgSyntax {
    /// A special identifier announces octets that are missing.
    #[error("the last configuration identifier is cut off")]
    CutOff,
    /// More inputs or outputs than a slave can have.
    #[error("the configuration has {got} octets in one direction, expected at most 244")]
    TooLong {
        /// Octets in that direction.
        got: usize,
    },
}

/// What is wrong with a Chk_Cfg.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum CfgFault {
    /// The application does not accept it.
    #[error("{}", Refused(.0))]
    Refused(Refusal),
    /// The application accepts it, and no slave can exchange it.
    #[error("Chk_Cfg: {0}")]
    Impossible(CfgSyntax),
}

/// A refusal, as a person reads it.
struct Refused<'a>(&'a Refusal);

impl core::fmt::Display for Refused<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        self.0.write(f, "Chk_Cfg", 1)
    }
}

/// An announced octet is missing: all that can go wrong within one identifier.
struct CutOff;

impl ParseError<&[u8]> for CutOff {
    fn from_error_kind(_: &[u8], _: ErrorKind) -> Self {
        Self
    }

    fn append(_: &[u8], _: ErrorKind, other: Self) -> Self {
        other
    }
}

/// One identifier: its octets of output and of input.
fn identifier(input: &[u8]) -> IResult<&[u8], (usize, usize), CutOff> {
    let (rest, head) = be_u8(input)?;
    let (output, input) = (head & 0x20 != 0, head & 0x10 != 0);
    if output || input {
        let octets = unit(head) * (usize::from(head & 0x0F) + 1);
        return Ok((rest, (if output { octets } else { 0 }, if input { octets } else { 0 })));
    }
    let (rest, outputs) = cond(head & 0x80 != 0, length).parse(rest)?;
    let (rest, inputs) = cond(head & 0x40 != 0, length).parse(rest)?;
    let manufacturer = match head & 0x0F {
        15 => 0,
        octets => octets,
    };
    let (rest, _) = take(manufacturer)(rest)?;
    Ok((rest, (outputs.unwrap_or(0), inputs.unwrap_or(0))))
}

fn length(input: &[u8]) -> IResult<&[u8], usize, CutOff> {
    let (rest, octet) = be_u8(input)?;
    Ok((rest, unit(octet) * (usize::from(octet & 0x3F) + 1)))
}

/// Octets of one unit: bit 6 means words.
const fn unit(octet: u8) -> usize {
    if octet & 0x40 == 0 { 1 } else { 2 }
}

#[cfg(test)]
mod tests {
    use std::string::ToString;
    use std::vec;

    use super::*;
    use crate::dp::application::{Expected, Reason};

    #[test]
    fn g_06_every_form_of_identifier_has_its_lengths() {
        for (identifiers, outputs, inputs) in [
            (&[0xF3, 0xF2][..], 14, 14),
            (&[0xF6], 14, 14),
            (&[0x23, 0x13], 4, 4),
            (&[0x10, 0x10], 0, 2),
            (&[0x3F], 16, 16),
            (&[0x7F, 0x7F], 64, 64),
            (&[0x00], 0, 0),
            (&[0x40, 0x3F], 0, 64),
            (&[0x80, 0x7F], 128, 0),
            (&[0xC0, 0xC0, 0x81], 2, 2),
            (&[0xC2, 0x00, 0x01, 0xAA, 0xBB], 1, 2),
            (&[0x4F, 0x03], 0, 4),
            (&[0x02, 0xAA, 0xBB, 0x20], 1, 0),
        ] {
            assert_eq!(IoLengths::of(identifiers), Ok(IoLengths { outputs, inputs }), "{identifiers:02X?}");
        }
    }

    #[test]
    fn g_06_an_identifier_that_is_cut_off_is_refused() {
        for identifiers in [&[0x40][..], &[0xC0, 0x00], &[0xC2, 0x00, 0x00, 0xAA], &[0xF3, 0x80], &[0x01]] {
            assert_eq!(IoLengths::of(identifiers), Err(CfgSyntax::CutOff), "{identifiers:02X?}");
        }
    }

    #[test]
    fn g_07_244_octets_each_way_are_accepted_and_245_are_not() {
        let most = [0xC0, 0x7F, 0x7F, 0xC0, 0x79, 0x79];
        assert_eq!(IoLengths::of(&most), Ok(IoLengths { outputs: 244, inputs: 244 }));
        let more = [&most[..], &[0x20]].concat();
        assert_eq!(IoLengths::of(&more), Err(CfgSyntax::TooLong { got: 245 }));
    }

    #[test]
    fn a_fault_says_octet_expected_got_and_the_words_of_the_application() {
        let refusal = Refusal {
            index: 1,
            expected: Expected::Octet(0xF2),
            got: None,
            reason: Reason::Text("choose the module"),
        };
        for (refusal, text) in [
            (refusal, "Chk_Cfg octet 2: the end, expected 0xF2: choose the module"),
            (
                Refusal { got: Some(0x13), expected: Expected::End, ..refusal },
                "Chk_Cfg octet 2: 0x13, expected the end: choose the module",
            ),
            (
                Refusal { expected: Expected::AsReasoned, reason: Reason::Numbered(7), ..refusal },
                "Chk_Cfg octet 2: the end",
            ),
        ] {
            assert_eq!(CfgFault::Refused(refusal).to_string(), text);
        }
        let fault = CfgFault::Impossible(CfgSyntax::TooLong { got: 245 });
        assert_eq!(
            fault.to_string(),
            "Chk_Cfg: the configuration has 245 octets in one direction, expected at most 244"
        );
    }

    proptest::proptest! {
        #[test]
        fn any_octets_are_measured_without_panic(identifiers in proptest::collection::vec(0u8.., 0..250)) {
            if let Ok(lengths) = IoLengths::of(&identifiers) {
                assert!(usize::from(lengths.inputs) <= MAX_IO_LEN && usize::from(lengths.outputs) <= MAX_IO_LEN);
            }
        }
    }

    #[test]
    fn a_long_configuration_of_empty_slots_is_measured() {
        assert_eq!(IoLengths::of(&vec![0x00; 244]), Ok(IoLengths::default()));
    }
}
