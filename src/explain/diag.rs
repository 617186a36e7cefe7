//! Slave_Diag, octet by octet and bit by bit. `dp::slave_diag` and `dp::ext_diag` draw the octets.

use super::context::Learned;
use super::field::{Bits, Field, Mark};
use super::service::raw_data;
use super::set_prm::ident_name;
use crate::profibus::dp::ext_diag::ChannelError;
use crate::profibus::dp::{DiagBit, Tells};

pub(super) fn explain(data: &[u8], at: usize, learned: &mut Learned) -> (String, Vec<Field>) {
    let &[first, second, third, master, ident_high, ident_low, ref extended @ ..] = data else {
        let text = format!("diagnosis of {} octets, expected at least 6", data.len());
        let fields = raw_data(data, at).into_iter().map(|field| field.mistaken(&text)).collect();
        return (text, fields);
    };
    let ident = u16::from_be_bytes([ident_high, ident_low]);
    learned.own_ident = Some(ident);
    let owner = if master == NO_MASTER { "no master".into() } else { format!("master {master}") };
    let mut fields = Vec::from([
        status(0, at, first),
        status(1, at, second),
        status(2, at, third),
        Field::octet("Master_Add", at + 3, master, format!("owned by {owner}")),
        Field::word("Ident_Number", at + 4, ident, ident_name(ident)),
    ]);
    if let Some(field) = fields.get_mut(1).filter(|_| !DiagBit::Always1.is_set(data)) {
        *field = field.clone().mistaken("bit 2 must always be 1");
    }
    blocks(extended, at + 6, &mut fields);
    let ready = (!DiagBit::StationNotReady.is_set(data)).then_some("ready for data");
    let set = DiagBit::ALL.iter().filter(|bit| bit.is_set(data) && bit.tells() != Tells::Nothing);
    let said: Vec<&str> = ready.into_iter().chain(set.map(|bit| bit.one())).collect();
    let more = if extended.is_empty() { String::new() } else { format!(", {} octets more", extended.len()) };
    (format!("diagnosis: {}, {owner}, ident {ident:04X}{more}", said.join(", ")), fields)
}

const NO_MASTER: u8 = 255;
/// One of the three octets of bits, `octet` from 0.
fn status(octet: usize, at: usize, value: u8) -> Field {
    let at = at + octet;
    let bit = |n: u8| {
        let Some(bit) = DiagBit::at(octet, n) else {
            return Field::bit("reserved", at, n, value, "1", "");
        };
        let one =
            if bit.note().is_empty() { bit.one().into() } else { format!("{} ({})", bit.one(), bit.note()) };
        let trouble = bit.tells() == Tells::Trouble && value & bit.mask() != 0;
        Field::bit(bit.name(), at, n, value, one, "").marked_if(Mark::Trouble, trouble)
    };
    let name = format!("Station_status_{}", octet + 1);
    Field::octet(&name, at, value, "").with((0..8).rev().map(bit).collect())
}

/// The blocks of extended diagnosis.
fn blocks(mut rest: &[u8], mut at: usize, fields: &mut Vec<Field>) {
    while let Some(&header) = rest.first() {
        let (name, len) = match header >> 6 {
            0 => ("device-related block", usize::from(header & SIX_BITS)),
            1 => ("identifier-related block", usize::from(header & SIX_BITS)),
            2 => ("channel-related block", 3),
            _ => ("revision", 1),
        };
        let whole = rest.get(..len).filter(|block| !block.is_empty());
        let Some(block) = whole else {
            let text = format!("a block of {len} octets, of which there are {}", rest.len());
            fields.push(Field::octets(name, at, rest, text.clone()).mistaken(text));
            return;
        };
        fields.push(match *block {
            [_, channel, kind] if header >> 6 == 2 => channel_block(at, [header, channel, kind]),
            [_, ref data @ ..] if header >> 6 == 1 => {
                Field::octets(name, at, block, format!("modules with a diagnosis: {}", modules(data)))
            }
            [_] if header >> 6 == 3 => {
                Field::octet(name, at, header, format!("revision {}", header & SIX_BITS))
            }
            [..] => Field::octets(name, at, block, "of the device, in its GSD"),
        });
        at += block.len();
        rest = rest.get(block.len()..).unwrap_or_default();
    }
}

const SIX_BITS: u8 = 0x3F;

fn modules(bits: &[u8]) -> String {
    let numbers: Vec<String> = bits
        .iter()
        .enumerate()
        .flat_map(|(n, octet)| (0..8).filter(move |bit| octet >> bit & 1 != 0).map(move |bit| n * 8 + bit))
        .map(|number| format!("{number}"))
        .collect();
    if numbers.is_empty() { "none".into() } else { numbers.join(", ") }
}

fn channel_block(at: usize, octets: [u8; 3]) -> Field {
    let [module, channel, kind] = octets;
    let direction = match channel >> 6 {
        1 => "input",
        2 => "output",
        3 => "input and output",
        _ => "reserved",
    };
    let width = match kind >> 5 {
        1 => "1 bit",
        2 => "2 bits",
        3 => "4 bits",
        4 => "octet",
        5 => "word",
        6 => "2 words",
        _ => "reserved",
    };
    let error = channel_error(kind & 0x1F);
    let meaning =
        format!("module {}, {direction} {}, {width}: {error}", module & SIX_BITS, channel & SIX_BITS);
    // Each octet has two fields of bits.
    let octet = |n: usize, name: &str, octet: u8, lowest: u8, high: (&str, &str), low: (&str, String)| {
        let bits = |name, (high, low), meaning: String| {
            Field::bits(name, (at + n, 1), Bits { high, low }, octet.into(), meaning)
        };
        Field::octet(name, at + n, octet, "")
            .with(Vec::from([bits(high.0, (7, lowest), high.1.into()), bits(low.0, (lowest - 1, 0), low.1)]))
    };
    Field::octets("channel-related block", at, &octets, meaning).marked(Mark::Trouble).with(Vec::from([
        octet(
            0,
            "place",
            module,
            6,
            ("block", "channel-related"),
            ("module", format!("{}", module & SIX_BITS)),
        ),
        octet(
            1,
            "channel",
            channel,
            6,
            ("direction", direction),
            ("number", format!("{}", channel & SIX_BITS)),
        ),
        octet(2, "diagnosis", kind, 5, ("width", width), ("error", error.into())),
    ]))
}

const fn channel_error(error: u8) -> &'static str {
    match ChannelError::numbered(error) {
        Some(error) => match error.words() {
            Some(words) => words,
            None => "error of the manufacturer",
        },
        None => "reserved",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::explain::frame::tests::check_cover;

    fn said(data: &[u8]) -> String {
        explain(data, 0, &mut Learned::default()).0
    }

    #[test]
    fn a_diagnosis_in_one_line() {
        for (data, words) in [
            (
                &[0x02, 0x05, 0x00, 0xFF, 0x0A, 0xC5][..],
                "diagnosis: not ready, wants parameters, no master, ident 0AC5",
            ),
            (
                &[0x00, 0x0C, 0x00, 0x02, 0x0A, 0xC5],
                "diagnosis: ready for data, watchdog on, master 2, ident 0AC5",
            ),
            (
                &[0x42, 0x05, 0x00, 0xFF, 0x12, 0x34],
                "diagnosis: not ready, parameter fault, wants parameters, no master, ident 1234",
            ),
            (
                &[0x08, 0x0C, 0x80, 0x02, 0x12, 0x34, 0x42, 0x02],
                "diagnosis: ready for data, extended diagnosis, watchdog on, more diagnosis than fits, master 2, ident 1234, 2 octets more",
            ),
            (&[1], "diagnosis of 1 octets, expected at least 6"),
        ] {
            assert_eq!(said(data), words);
        }
    }

    #[test]
    fn the_blocks_behind_are_told_apart_and_measured() {
        let data = [0x08, 0x0C, 0, 2, 0x12, 0x34, 0x42, 0x02, 0x81, 0x83, 0x21, 0xC5, 0x03, 0xAA, 0xBB];
        let (_, fields) = explain(&data, 0, &mut Learned::default());
        check_cover(&fields, 0, data.len());
        let blocks: Vec<(usize, usize, &str)> =
            fields[5..].iter().map(|field| (field.at, field.len, field.meaning.as_str())).collect();
        assert_eq!(
            blocks,
            [
                (6, 2, "modules with a diagnosis: 1"),
                (8, 3, "module 1, output 3, 1 bit: short circuit"),
                (11, 1, "revision 5"),
                (12, 3, "of the device, in its GSD"),
            ]
        );
    }

    #[test]
    fn a_block_that_is_cut_off_or_has_no_length_ends_the_list() {
        for block in [&[0x04, 0xAA][..], &[0x00], &[0x82, 0x01]] {
            let data = [&[0, 4, 0, 2, 0x12, 0x34][..], block].concat();
            let (_, fields) = explain(&data, 0, &mut Learned::default());
            assert_eq!(fields.last().unwrap().mark, Mark::Mistake, "{block:02X?}");
            check_cover(&fields, 0, data.len());
        }
    }
}
