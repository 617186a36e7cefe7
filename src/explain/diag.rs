//! Slave_Diag, octet by octet and bit by bit. `dp::slave_diag` and `dp::ext_diag` draw the octets.

use std::format;
use std::string::String;
use std::vec::Vec;

use super::context::Learned;
use super::field::{Bits, Field, Mark};
use super::service::raw_data;
use super::set_prm::ident_name;

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
        status("Station_status_1", at, first, &STATUS_1),
        status("Station_status_2", at + 1, second, &STATUS_2),
        status("Station_status_3", at + 2, third, &STATUS_3),
        Field::octet("Master_Add", at + 3, master, format!("owned by {owner}")),
        Field::word("Ident_Number", at + 4, ident, ident_name(ident)),
    ]);
    if let Some(field) = fields.get_mut(1).filter(|_| second & ALWAYS_1 == 0) {
        *field = field.clone().mistaken("bit 2 must always be 1");
    }
    blocks(extended, at + 6, &mut fields);
    let ready = (first & NOT_READY == 0).then_some("ready for data");
    let said = [(first, &STATUS_1), (second, &STATUS_2), (third, &STATUS_3)].into_iter();
    let said = said.flat_map(|(octet, rows)| (0..8).zip(rows).filter(move |(n, _)| octet >> n & 1 != 0));
    let said: Vec<&str> =
        ready.into_iter().chain(said.map(|(_, row)| row.said).filter(|said| !said.is_empty())).collect();
    let more = if extended.is_empty() { String::new() } else { format!(", {} octets more", extended.len()) };
    (format!("diagnosis: {}, {owner}, ident {ident:04X}{more}", said.join(", ")), fields)
}

const NO_MASTER: u8 = 255;
const NOT_READY: u8 = 0x02;
const ALWAYS_1: u8 = 0x04;

/// One bit of the diagnosis.
struct Row {
    name: &'static str,
    /// What 1 means, in the summary; empty if it says nothing.
    said: &'static str,
    note: &'static str,
    trouble: bool,
}

const fn good(name: &'static str, said: &'static str, note: &'static str) -> Row {
    Row { name, said, note, trouble: false }
}

const fn bad(name: &'static str, said: &'static str, note: &'static str) -> Row {
    Row { name, said, note, trouble: true }
}

const RESERVED: Row = good("reserved", "", "");

const STATUS_1: [Row; 8] = [
    bad("Station_Non_Existent", "does not exist", "set by the master"),
    good("Station_Not_Ready", "not ready", "not ready for Data_Exchange"),
    bad("Cfg_Fault", "configuration fault", "the last Chk_Cfg was refused"),
    bad("Ext_Diag", "extended diagnosis", "the blocks behind show a fault"),
    bad("Not_Supported", "asked for what it cannot do", "for example Sync or Freeze"),
    bad("Invalid_Slave_Response", "answered wrongly", "set by the master"),
    bad("Prm_Fault", "parameter fault", "the last Set_Prm was refused: ident number, length or values"),
    bad("Master_Lock", "locked by another master", "set by the master"),
];

const STATUS_2: [Row; 8] = [
    good("Prm_Req", "wants parameters", "must be parameterised"),
    good("Stat_Diag", "cannot deliver valid data", "the master shall go on asking"),
    good("always 1", "", ""),
    good("WD_On", "watchdog on", ""),
    good("Freeze_Mode", "inputs frozen", ""),
    good("Sync_Mode", "outputs in Sync", ""),
    RESERVED,
    bad("Deactivated", "deactivated", "set by the master"),
];

const STATUS_3: [Row; 8] = [
    RESERVED,
    RESERVED,
    RESERVED,
    RESERVED,
    RESERVED,
    RESERVED,
    RESERVED,
    bad("Ext_Diag_Overflow", "more diagnosis than fits", ""),
];

fn status(name: &str, at: usize, octet: u8, rows: &[Row; 8]) -> Field {
    let mut bits: Vec<Field> = (0..8)
        .zip(rows)
        .map(|(n, row)| {
            let said = if row.said.is_empty() { "1" } else { row.said };
            let said = if row.note.is_empty() { said.into() } else { format!("{said} ({})", row.note) };
            Field::bit(row.name, at, n, octet, said, "")
                .marked_if(Mark::Trouble, row.trouble && octet >> n & 1 != 0)
        })
        .collect();
    bits.reverse();
    Field::octet(name, at, octet, "").with(bits)
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
    match error {
        1 => "short circuit",
        2 => "undervoltage",
        3 => "overvoltage",
        4 => "overload",
        5 => "overtemperature",
        6 => "line break",
        7 => "upper limit exceeded",
        8 => "lower limit exceeded",
        9 => "error",
        0 | 10..=15 => "reserved",
        16.. => "error of the manufacturer",
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
