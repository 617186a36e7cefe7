//! Configuration identifiers of Chk_Cfg and Get_Cfg. `dp::chk_cfg` draws the octets.

use std::format;
use std::string::{String, ToString};
use std::vec::Vec;

use super::field::Field;
use crate::device::{APPLICATION, IDENT_NUMBER};
use crate::dp::{Application, CfgFault, IoLengths};

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
    let mut offset = 0;
    while let Some(rest) = data.get(offset..).filter(|rest| !rest.is_empty()) {
        let (len, meaning) = identifier(rest);
        let octets = rest.get(..len).unwrap_or(rest);
        let name = if octets.len() == 1 { "identifier" } else { "special identifier" };
        let field = Field::octets(name, at + offset, octets, meaning);
        let cut_off = len > rest.len();
        fields.push(if cut_off { field.mistaken("cut off: octets it announces are missing") } else { field });
        offset += octets.len();
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

/// Octets of the identifier at the front, and its meaning. More octets than there are if it is cut off.
fn identifier(octets: &[u8]) -> (usize, String) {
    let Some(&head) = octets.first() else { return (0, String::new()) };
    let unit = |octet: u8| if octet & 0x40 != 0 { "word" } else { "octet" };
    let plural = |count: u8| if count == 1 { "" } else { "s" };
    let consistent = |octet: u8| if octet & 0x80 != 0 { "as a whole" } else { "unit by unit" };
    let direction = match head & 0x30 {
        0x10 => "input",
        0x20 => "output",
        0x30 => "input and output",
        _ => return special(head, octets),
    };
    let count = (head & 0x0F) + 1;
    let meaning =
        format!("{count} {}{} {direction}, consistent {}", unit(head), plural(count), consistent(head));
    (1, meaning)
}

/// The special format: length octets and octets of the manufacturer follow.
fn special(head: u8, octets: &[u8]) -> (usize, String) {
    let mut len = 1;
    let mut parts = Vec::new();
    for (flag, direction) in [(0x80, "output"), (0x40, "input")] {
        if head & flag == 0 {
            continue;
        }
        parts.push(match octets.get(len) {
            Some(&length) => {
                let unit = if length & 0x40 != 0 { "words" } else { "octets" };
                let consistent = if length & 0x80 != 0 { "as a whole" } else { "unit by unit" };
                format!("{} {unit} {direction}, consistent {consistent}", (length & 0x3F) + 1)
            }
            None => format!("{direction} of a length that is missing"),
        });
        len += 1;
    }
    match head & 0x0F {
        0 => {}
        15 => parts.push("the manufacturer's octets are not compared".into()),
        manufacturer => {
            len += usize::from(manufacturer);
            parts.push(format!("{manufacturer} octets of the manufacturer"));
        }
    }
    if head & 0xC0 == 0 {
        parts.insert(0, "empty slot".into());
    }
    (len, parts.join("; "))
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
