//! Configuration identifiers of Chk_Cfg and Get_Cfg. `dp::chk_cfg` draws the octets.

use super::field::Field;
use crate::devices::ag03::profibus::{APPLICATION, IDENT_NUMBER};
use crate::profibus::dp::chk_cfg::{IdentifierBit, NOT_COMPARED, Units};
use crate::profibus::dp::{Application, CfgFault, Identifier, IoLengths};

/// Who says the identifiers.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Said {
    /// A master in Chk_Cfg.
    Asked,
    /// The slave itself.
    Answered,
}

/// Sums in a few words, and a field for each identifier.
pub(super) fn explain(data: &[u8], at: usize, said: Said, ident: Option<u16>) -> (String, Vec<Field>) {
    let mut fields = Vec::new();
    let mut rest = data;
    while !rest.is_empty() {
        let read = Identifier::read(rest);
        let behind = read.map_or(&[][..], |(_, behind)| behind);
        let octets = rest.get(..rest.len() - behind.len()).unwrap_or(rest);
        let name = if octets.len() == 1 { "identifier" } else { "special identifier" };
        let field = |meaning| Field::octets(name, at + data.len() - rest.len(), octets, meaning);
        fields.push(match read {
            Ok((identifier, _)) => field(words(&identifier)),
            Err(_) => field(String::new()).mistaken("cut off: octets it announces are missing"),
        });
        rest = behind;
    }
    let summary = match IoLengths::of(data) {
        Ok(IoLengths { outputs, inputs }) => {
            let ppo = ppo_name(data).map_or(String::new(), |ppo| format!(" ({ppo})"));
            format!("{outputs} octets of outputs and {inputs} of inputs{ppo}")
        }
        Err(error) => error.to_string(),
    };
    // Another device has its own configurations.
    if let Err(refusal) = APPLICATION.judge_cfg(data, &[])
        && let Some(field) = fields.iter_mut().rev().find(|field| field.at <= at + refusal.index)
    {
        let fault = CfgFault::Refused(refusal);
        match (ident, said) {
            (Some(IDENT_NUMBER), _) => {
                *field = field.clone().mistaken(format!("an AG03 refuses it: {fault}"));
            }
            (None, Said::Asked) => *field = field.clone().hinted(format!("an AG03 would refuse it: {fault}")),
            (Some(_), _) | (None, Said::Answered) => {}
        }
    }
    (summary, fields)
}

/// The PPO these identifiers stand for (`profidrive-v2.md` 1).
fn ppo_name(identifiers: &[u8]) -> Option<&'static str> {
    Some(match *identifiers {
        [0xF3, 0xF1] => "PPO 1, PKW and 2 words PZD",
        [0xF3, 0xF5] => "PPO 2, PKW and 6 words PZD",
        // A widespread article has these two the other way round.
        [0xF1] => "PPO 3, 2 words PZD",
        [0xF5] => "PPO 4, 6 words PZD",
        [0xF3, 0xF9] => "PPO 5, PKW and 10 words PZD",
        [0xF3, 0xF2] | [0xF6] => "PPO of the AG03, PKW and 3 words PZD",
        [..] => return None,
    })
}

/// An identifier in words.
fn words(identifier: &Identifier) -> String {
    let Identifier { outputs, inputs, manufacturer } = *identifier;
    let Some(manufacturer) = manufacturer else {
        return match (outputs, inputs) {
            (Some(units), Some(_)) => in_direction(units, "input and output"),
            (Some(units), None) => in_direction(units, "output"),
            (None, Some(units)) => in_direction(units, "input"),
            (None, None) => String::new(),
        };
    };
    let outputs = outputs.map(|units| in_direction(units, "output"));
    let inputs = inputs.map(|units| in_direction(units, "input"));
    let empty = (outputs.is_none() && inputs.is_none()).then(|| "empty slot".into());
    let manufacturer = match manufacturer {
        0 => None,
        NOT_COMPARED => Some("the manufacturer's octets are not compared".into()),
        octets => Some(format!("{octets} octets of the manufacturer")),
    };
    let parts: Vec<String> = [empty, outputs, inputs, manufacturer].into_iter().flatten().collect();
    parts.join("; ")
}

fn in_direction(Units { count, words, whole }: Units, direction: &str) -> String {
    let unit = if words { "word" } else { "octet" };
    let plural = if count == 1 { "" } else { "s" };
    let whole = if whole { IdentifierBit::Whole.one() } else { IdentifierBit::Whole.zero() };
    format!("{count} {unit}{plural} {direction}, consistent {whole}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::explain::Mark;

    #[test]
    fn identifiers_are_read_one_by_one() {
        for (data, summary, lens) in [
            (
                &[0xF3, 0xF2][..],
                "14 octets of outputs and 14 of inputs (PPO of the AG03, PKW and 3 words PZD)",
                &[1, 1][..],
            ),
            (&[0xF6], "14 octets of outputs and 14 of inputs (PPO of the AG03, PKW and 3 words PZD)", &[1]),
            (&[0xF1], "4 octets of outputs and 4 of inputs (PPO 3, 2 words PZD)", &[1]),
            (&[0xF5], "12 octets of outputs and 12 of inputs (PPO 4, 6 words PZD)", &[1]),
            (&[0x23, 0x13], "4 octets of outputs and 4 of inputs", &[1, 1]),
            (&[0x00, 0x10, 0x10], "0 octets of outputs and 2 of inputs", &[1, 1, 1]),
            (&[0xC2, 0x41, 0x83, 1, 2, 0x20], "5 octets of outputs and 4 of inputs", &[5, 1]),
            (&[0xC2, 0x41], "the last configuration identifier is cut off", &[2]),
        ] {
            let (said, fields) = explain(data, 9, Said::Asked, None);
            assert_eq!(said, summary);
            assert_eq!(fields.iter().map(|field| field.len).collect::<Vec<_>>(), lens);
            assert_eq!(fields[0].at, 9);
        }
        let (_, fields) = explain(&[0xC2, 0x41, 0x83, 1, 2, 0x00], 0, Said::Asked, None);
        assert_eq!(
            fields[0].meaning,
            "2 words output, consistent unit by unit; 4 octets input, consistent as a whole; 2 octets of the manufacturer"
        );
        assert_eq!(fields[1].meaning, "empty slot");
    }

    #[test]
    fn a_drive_of_ours_says_which_identifier_it_refuses() {
        let (_, fields) = explain(&[0xF3, 0xF1], 0, Said::Asked, Some(IDENT_NUMBER));
        assert_eq!(fields[0].hints.len(), 0);
        assert!(fields[1].hints[0].contains("0xF1, expected 0xF2"), "{:?}", fields[1].hints);
        let (_, fields) = explain(&[0xF3], 0, Said::Asked, Some(IDENT_NUMBER));
        assert!(fields[0].hints[0].contains("the end, expected 0xF2"), "{:?}", fields[0].hints);
        assert_eq!(fields[0].mark, Mark::Mistake);
        for (said, ident) in
            [(Said::Asked, Some(0x80E0)), (Said::Answered, Some(0x80E0)), (Said::Answered, None)]
        {
            let (_, fields) = explain(&[0xF3, 0xF1], 0, said, ident);
            assert!(fields.iter().all(|field| field.hints.is_empty()), "another device");
        }
        let (_, fields) = explain(&[0xF3, 0xF1], 0, Said::Asked, None);
        assert!(fields[1].hints[0].starts_with("an AG03 would refuse it"), "{:?}", fields[1].hints);
        assert_eq!(fields[1].mark, Mark::Plain, "it may be another device");
    }
}
