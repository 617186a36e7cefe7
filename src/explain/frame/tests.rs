//! Telegrams in one line, field by field, and broken in every way.

use proptest::prelude::*;

use super::*;
use crate::explain::Explanation;

fn octets(hex: &str) -> Vec<u8> {
    hex.split(' ').map(|octet| u8::from_str_radix(octet, 16).unwrap()).collect()
}

fn alone(hex: &str) -> Explanation {
    Context::default().telegram(&octets(hex))
}

/// Every octet, and of every word every bit, belongs to exactly one innermost field.
pub(crate) fn check_cover(fields: &[Field], at: usize, len: usize) {
    let mut next = at;
    let mut bit = None;
    for field in fields {
        match field.bits {
            Some(bits) => {
                let whole = u8::try_from(field.len * 8).unwrap();
                assert_eq!((field.at, field.len), (at, len), "{field:?}");
                assert_eq!(bit.unwrap_or(whole), bits.high + 1, "{field:?}");
                bit = Some(bits.low);
            }
            None => {
                assert_eq!(field.at, next, "{field:?}");
                next += field.len;
            }
        }
        if !field.fields.is_empty() {
            check_cover(&field.fields, field.at, field.len);
        }
    }
    match bit {
        Some(lowest) => assert_eq!(lowest, 0),
        None => assert_eq!(next, at + len),
    }
}

#[test]
fn the_worked_start_up_of_the_reference_reads_as_a_conversation() {
    // `dp-v0.md` 10, in its order, with the ident number and PPO of the drives where the data are theirs.
    let mut context = Context::default();
    for (hex, line) in [
        ("10 05 02 49 50 16", "2 -> 5  FDL status request"),
        ("10 02 05 00 07 16", "5 -> 2  here, a slave"),
        ("68 05 05 68 85 82 6D 3C 3E EE 16", "2 -> 5  Slave_Diag request"),
        (
            "68 0B 0B 68 82 85 08 3E 3C 02 05 00 FF 12 34 D5 16",
            "5 -> 2  diagnosis: not ready, wants parameters, no master, ident 1234",
        ),
        (
            "68 0C 0C 68 85 82 5D 3D 3E 88 0A 0A 0B 12 34 00 CC 16",
            "2 -> 5  Set_Prm: lock the slave, watchdog 1000 ms, reply after 11 bit times",
        ),
        ("E5", "5 -> 2  short acknowledge: Set_Prm received"),
        ("68 07 07 68 85 82 7D 3E 3E 23 13 36 16", "2 -> 5  Chk_Cfg: 4 octets of outputs and 4 of inputs"),
        ("E5", "5 -> 2  short acknowledge: Chk_Cfg received"),
        ("68 05 05 68 85 82 5D 3C 3E DE 16", "2 -> 5  Slave_Diag request"),
        (
            "68 0B 0B 68 82 85 08 3E 3C 00 0C 00 02 12 34 DD 16",
            "5 -> 2  diagnosis: ready for data, watchdog on, master 2, ident 1234",
        ),
        (
            "68 07 07 68 FF 82 46 3A 3E 00 00 3F 16",
            "2 -> all  Global_Control: no command, the master is in Operate",
        ),
        ("68 07 07 68 05 02 7D 04 7E 00 00 06 16", "2 -> 5  Data_Exchange: 4 octets of outputs"),
        ("68 07 07 68 02 05 08 02 31 00 00 42 16", "5 -> 2  inputs: 4 octets of inputs"),
        ("68 07 07 68 05 02 5D 04 7F 00 00 E7 16", "2 -> 5  Data_Exchange: 4 octets of outputs"),
        (
            "68 07 07 68 02 05 0A 02 37 00 00 4A 16",
            "5 -> 2  inputs: 4 octets of inputs; a new diagnosis waits",
        ),
        ("10 02 05 03 0A 16", "5 -> 2  refused: RS: service or SAP not active now, or not for this master"),
        ("10 02 05 02 09 16", "5 -> 2  refused: RR: no resource for the data, or their length is wrong"),
        ("10 02 05 0A 11 16", "5 -> 2  inputs: no inputs; a new diagnosis waits"),
        (
            "68 0C 0C 68 85 82 7D 3D 3E 40 00 00 00 12 34 00 85 16",
            "2 -> 5  Set_Prm: unlock the slave for other masters, watchdog off",
        ),
        ("68 09 09 68 FE 82 6D 37 3E 07 12 34 00 AF 16", "2 -> 126  Set_Slave_Add: new address 7"),
        ("DC 02 02", "2 -> 2  token"),
    ] {
        let explanation = context.telegram(&octets(hex));
        assert_eq!(explanation.line(), line, "{hex}");
        check_cover(&explanation.fields, 0, octets(hex).len());
    }
}

#[test]
fn what_a_refusal_refuses_is_known_from_the_request() {
    let mut context = Context::default();
    context.telegram(&octets("68 05 05 68 85 82 6D 3C 3E EE 16"));
    let refused = context.telegram(&octets("10 02 05 03 0A 16"));
    assert!(refused.summary.starts_with("Slave_Diag refused: RS"), "{}", refused.summary);
    assert_eq!(refused.mark(), Mark::Trouble);
    // The next one stands alone again.
    let refused = context.telegram(&octets("10 02 05 03 0A 16"));
    assert!(refused.summary.starts_with("refused: RS"), "{}", refused.summary);
}

/// An SD2 telegram of these octets from DA to the last of the data.
fn sd2(body: &[u8]) -> Vec<u8> {
    let len = u8::try_from(body.len()).unwrap();
    let sum = body.iter().fold(0_u8, |sum, octet| sum.wrapping_add(*octet));
    [&[0x68, len, len, 0x68], body, &[sum, 0x16]].concat()
}

#[test]
fn bit_7_of_an_address_says_that_a_sap_follows() {
    let meaning = |hex: &str| alone(hex).fields.iter().map(|field| field.meaning.clone()).collect::<Vec<_>>();
    let (with, without) = (meaning("68 05 05 68 85 82 6D 3C 3E EE 16"), meaning("10 05 02 49 50 16"));
    assert_eq!(with[4..6], ["station 5, a SAP follows (bit 7)", "station 2, a SAP follows (bit 7)"]);
    assert_eq!(without[1..3], ["station 5", "station 2"]);
    assert_eq!(alone("68 05 05 68 85 82 6D 3C 3E EE 16").fields[4].raw, "85");
}

/// Only the contents of Set_Prm and Chk_Cfg are judged behind their acknowledge.
#[test]
fn an_acknowledge_of_contents_is_no_answer_to_them() {
    let requests: [(&[u8], bool); 4] = [
        (&[0x85, 0x82, 0x5D, 61, 62, 0x88, 10, 10, 11, 0x0A, 0xC5, 0], true),
        (&[0x85, 0x82, 0x5D, 62, 62, 0xF3, 0xF1], true),
        (&[0x85, 0x82, 0x5D, 55, 62, 9, 0x0A, 0xC5, 0], false),
        (&[0x05, 0x02, 0x5D, 1, 2], false),
    ];
    for (request, judged) in requests {
        let mut context = Context::default();
        context.telegram(&sd2(request));
        let said = context.telegram(&[0xE5]).to_string();
        assert_eq!(
            said.contains("the next Slave_Diag shows whether the slave accepts them"),
            judged,
            "{said}"
        );
    }
}

#[test]
fn a_drive_refuses_outputs_of_another_length_and_sends_inputs_of_any() {
    let mut context = Context::default();
    context.telegram(&sd2(&[0x85, 0x82, 0x5D, 61, 62, 0x88, 10, 10, 11, 0x0A, 0xC5, 0]));
    let outputs = context.telegram(&sd2(&[0x05, 0x02, 0x7D, 1, 2]));
    assert_eq!(outputs.mark(), Mark::Mistake, "{outputs}");
    assert!(outputs.to_string().contains("an AG03 refuses it: 2 octets, expected 14"), "{outputs}");
    let inputs = context.telegram(&sd2(&[0x02, 0x05, 0x08, 1, 2]));
    assert_eq!(inputs.mark(), Mark::Plain, "{inputs}");
    assert!(inputs.summary.contains("2 octets of inputs, not the 14 of these drives"), "{inputs}");
}

#[test]
fn a_repeated_request_is_seen_by_its_frame_count_bit() {
    let mut context = Context::default();
    let first = octets("68 05 05 68 85 82 6D 3C 3E EE 16");
    let even = octets("68 05 05 68 85 82 5D 3C 3E DE 16");
    for (octets, repeated) in [(&first, false), (&even, false), (&even, true), (&first, false)] {
        assert_eq!(context.telegram(octets).summary.ends_with("(repeated)"), repeated);
    }
    let fcb = alone("10 05 02 49 50 16").fields[3].fields[2].clone();
    assert_eq!((fcb.name.as_str(), fcb.meaning.as_str()), ("FCB", "not used"));
}

#[test]
fn each_fault_of_a_frame_names_its_octet_and_reason() {
    for (hex, summary) in [
        ("FF", "invalid at octet 0: octet 0xFF starts no telegram, expected 10, 68, A2, DC or E5"),
        ("68 03 03 68", "invalid at octet 1: length octet LE is 3, expected 4..249"),
        ("68 05 06 68", "invalid at octet 2: repeated length octet LEr is 6, expected 5 as in LE"),
        ("68 05 05 00", "invalid at octet 3: second start delimiter is 0x00, expected 0x68"),
        (
            "68 05 05 68 85 82 6D 3C 3E EF 16",
            "invalid at octet 9: frame check sequence is 0xEF, expected 0xEE; Slave_Diag request",
        ),
        (
            "68 05 05 68 85 82 6D 3C 3E EE 17",
            "invalid at octet 10: end delimiter is 0x17, expected 0x16; Slave_Diag request",
        ),
        (
            "68 05 05 68 85 82 6D 3C 7E 2E 16",
            "invalid at octet 8: extension octet 0x7E is no service access point, expected 0x00..0x3F",
        ),
        (
            "68 05 05 68 85 82 6D 7C 3E 2E 16",
            "invalid at octet 7: extension octet 0x7C is no service access point, expected 0x00..0x3F",
        ),
        (
            "10 85 02 49 D0 16",
            "invalid at octet 4: an extension octet is announced by bit 7 of DA or SA and missing",
        ),
        ("DC 02 FF", "invalid at octet 2: token address octet is 0xFF, expected 0x00..0x7E"),
        ("DC 80 80", "invalid at octet 1: token address octet is 0x80, expected 0x00..0x7E"),
        ("68 05 05 68 85", "invalid at octet 5: telegram broken off after 5 octets, 6 more are missing"),
        ("68", "invalid at octet 1: telegram broken off after 1 octets"),
        (
            "E5 E5",
            "invalid at octet 1: behind the end of the telegram, which has 1 octets; short acknowledge: request received",
        ),
    ] {
        let explanation = alone(hex);
        assert_eq!(explanation.summary, summary, "{hex}");
        assert_eq!(explanation.mark(), Mark::Invalid, "{hex}");
        check_cover(&explanation.fields, 0, octets(hex).len());
    }
}

#[test]
fn a_wrong_checksum_and_a_wrong_end_are_both_shown() {
    let explanation = alone("10 05 02 49 51 17");
    let marks: Vec<(usize, &str)> = explanation
        .fields
        .iter()
        .filter(|field| field.mark == Mark::Invalid)
        .map(|field| (field.at, field.meaning.as_str()))
        .collect();
    assert_eq!(marks, [(4, "should be 50"), (5, "end delimiter is 0x17, expected 0x16")]);
}

#[test]
fn a_broken_telegram_teaches_nothing() {
    let mut context = Context::default();
    context.telegram(&octets("68 05 05 68 85 82 6D 3C 3E EF 16"));
    assert_eq!(context.telegram(&octets("E5")).line(), "short acknowledge: request received");
}

proptest! {
    #[test]
    fn any_octets_are_covered_by_their_explanation(octets in proptest::collection::vec(any::<u8>(), 1..300)) {
        let mut context = Context::default();
        let explanation = context.telegram(&octets);
        check_cover(&explanation.fields, 0, octets.len());
        prop_assert_eq!(explanation.octets, octets);
    }

    #[test]
    fn any_telegram_is_covered_and_in_order(
        da: u8,
        sa: u8,
        fc: u8,
        sap in proptest::option::of(0u8..64),
        data in proptest::collection::vec(any::<u8>(), 0..200),
    ) {
        let sap = sap.and_then(crate::profibus::fdl::Sap::new);
        let telegram = DataTelegram {
            format: DataTelegram::customary_format(sap, sap, &data),
            da: Address::from_octet(da),
            sa: Address::from_octet(sa),
            dsap: sap,
            ssap: sap,
            fc: crate::profibus::fdl::FunctionCode::from_octet(fc),
            data: &data,
        };
        let mut buf = [0; MAX_TELEGRAM_LEN];
        let octets = telegram.encode(&mut buf).unwrap();
        let explanation = Context::default().telegram(octets);
        check_cover(&explanation.fields, 0, octets.len());
        prop_assert_ne!(explanation.mark(), Mark::Invalid);
    }
}
