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
use nom::combinator::{cond, map};
use nom::error::{ErrorKind, ParseError};
use nom::number::complete::be_u8;
use nom::{IResult, Parser};
use thiserror::Error;

use super::Refusal;
use super::octet_bits::octet_bits;

/// The most input or output octets of a slave.
pub(crate) const MAX_IO_LEN: usize = 244;

octet_bits! {
    /// A bit of an identifier in the general format, or of a length octet, which has the first two.
    IdentifierBit {
        Whole = 7: "consistency", "as a whole", "unit by unit";
        Words = 6: "unit", "words", "octets";
        Output = 5: "output", "output", "no output";
        Input = 4: "input", "input", "no input";
    }
}

octet_bits! {
    /// A bit of the first octet of an identifier in the special format.
    SpecialBit {
        Outputs = 7: "output length", "an output length follows", "no output";
        Inputs = 6: "input length", "an input length follows", "no input";
    }
}

/// The bits of a general identifier that count units, from one; in a special one the octets of the manufacturer.
pub const COUNT: u8 = 0x0F;
/// The bits of a length octet that count units, from one.
pub const LENGTH: u8 = 0x3F;
/// The count of octets of the manufacturer that says: none, and none are compared.
pub const NOT_COMPARED: u8 = 15;

/// One identifier of a configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Identifier {
    /// Master to slave.
    pub outputs: Option<Units>,
    /// Slave to master.
    pub inputs: Option<Units>,
    /// In the special format, the count of octets of the manufacturer, 0 to 15; see [`NOT_COMPARED`]. `None` in the
    /// general format, in which outputs and inputs are alike.
    pub manufacturer: Option<u8>,
}

/// How much an identifier has in one direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Units {
    /// 1 to 64.
    pub count: u8,
    /// Words instead of octets.
    pub words: bool,
    /// Consistent as a whole instead of unit by unit.
    pub whole: bool,
}

impl Units {
    const fn of(octet: u8, count: u8) -> Self {
        let (words, whole) = (IdentifierBit::Words.is_set(octet), IdentifierBit::Whole.is_set(octet));
        Self { count: (octet & count) + 1, words, whole }
    }

    /// The octets of all units.
    pub(crate) fn octets(self) -> usize {
        usize::from(self.count) * if self.words { 2 } else { 1 }
    }
}

impl Identifier {
    /// Takes the first identifier off the octets of a configuration; with it comes what is behind it.
    ///
    /// # Errors
    /// [`CfgSyntax::CutOff`], also without any octet.
    pub(crate) fn read(octets: &[u8]) -> Result<(Self, &[u8]), CfgSyntax> {
        let (behind, identifier) = identifier(octets).map_err(|_| CfgSyntax::CutOff)?;
        Ok((identifier, behind))
    }
}

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
            let (identifier, behind) = Identifier::read(rest)?;
            outputs += identifier.outputs.map_or(0, Units::octets);
            inputs += identifier.inputs.map_or(0, Units::octets);
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
pub(crate) fn identifiers(configuration: &[u8]) -> impl Iterator<Item = &[u8]> {
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
#[non_exhaustive]
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
#[non_exhaustive]
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

fn identifier(input: &[u8]) -> IResult<&[u8], Identifier, CutOff> {
    let (rest, head) = be_u8(input)?;
    let (output, input) = (IdentifierBit::Output.is_set(head), IdentifierBit::Input.is_set(head));
    if output || input {
        let units = Units::of(head, COUNT);
        let (outputs, inputs) = (output.then_some(units), input.then_some(units));
        return Ok((rest, Identifier { outputs, inputs, manufacturer: None }));
    }
    let length = || map(be_u8, |octet| Units::of(octet, LENGTH));
    let (rest, outputs) = cond(SpecialBit::Outputs.is_set(head), length()).parse(rest)?;
    let (rest, inputs) = cond(SpecialBit::Inputs.is_set(head), length()).parse(rest)?;
    let manufacturer = head & COUNT;
    let (rest, _) = take(if manufacturer == NOT_COMPARED { 0 } else { manufacturer })(rest)?;
    Ok((rest, Identifier { outputs, inputs, manufacturer: Some(manufacturer) }))
}

#[cfg(test)]
mod tests {

    use super::*;
    use crate::profibus::dp::application::{Expected, Reason};

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
