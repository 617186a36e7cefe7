use proptest::prelude::*;

use super::*;

/// A diagnosis and its short acknowledge: longer than a line of most dumps.
const OCTETS: [u8; 18] = [
    0x68, 0x0B, 0x0B, 0x68, 0x82, 0x85, 0x08, 0x3E, 0x3C, 0x02, 0x05, 0x00, 0xFF, 0x0A, 0xC5, 0x5E, 0x16,
    0xE5,
];

fn read(lines: &str) -> Result<Vec<u8>, TextError> {
    let mut text = HexText::default();
    let mut octets = Vec::new();
    for line in lines.lines() {
        octets.extend(text.octets(line)?);
    }
    Ok(octets)
}

#[test]
fn the_dumps_of_common_tools_are_read_without_offset_and_characters() {
    for dump in [
        // xxd
        "00000000: 680b 0b68 8285 083e 3c02 0500 ff0a c55e  h..h...><......^\n00000010: 16e5                                     ..",
        // xxd -g1, whose characters may look like hexadecimal digits
        "00000000: 68 0b 0b 68 82 85 08 3e 3c 02 05 00 ff 0a c5 5e  ab cd ef........\n00000010: 16 e5                                            ab",
        // hexdump -C
        "00000000  68 0b 0b 68 82 85 08 3e  3c 02 05 00 ff 0a c5 5e  |h..h...><......^|\n00000010  16 e5                                             |..|\n00000012",
        // od -tx1
        "0000000 68 0b 0b 68 82 85 08 3e 3c 02 05 00 ff 0a c5 5e\n0000020 16 e5\n0000022",
        // od -Ax -tx1
        "000000 68 0b 0b 68 82 85 08 3e 3c 02 05 00 ff 0a c5 5e\n000010 16 e5\n000012",
        // Wireshark
        "0000   68 0b 0b 68 82 85 08 3e 3c 02 05 00 ff 0a c5 5e   h..h...><......^\n0010   16 e5                                             ..",
        "0000   68 0b 0b 68 82 85 08 3e  3c 02 05 00 ff 0a c5 5e   h..h...> <......^\n0010   16 e5",
        // tcpdump -X
        "\t0x0000:  680b 0b68 8285 083e 3c02 0500 ff0a c55e  h..h...><......^\n\t0x0010:  16e5                                     ..",
    ] {
        assert_eq!(read(dump).as_deref(), Ok(&OCTETS[..]), "{dump}");
    }
}

#[test]
fn the_arrays_and_strings_of_programs_are_read() {
    for source in [
        "uint8_t reply[18] = {\n    0x68, 0x0B, 0x0B, 0x68, 0x82, 0x85, 0x08, 0x3E, 0x3C, // head\n    0x02, 0x05, 0x00, 0xFF, 0x0A, 0xC5, 0x5E, 0x16, /* end */\n    0xE5\n};",
        "let reply = [0x68u8, 0x0B, 0x0B, 0x68, 0x82, 0x85, 0x8, 0x3E, 0x3C, 0x02, 0x05, 0x00, 0xFF, 0x0A, 0xC5, 0x5E, 0x16, 0xE5];",
        r"b'h\x0b\x0bh\x82\x85\x08><\x02\x05\x00\xff\n\xc5^\x16\xe5'",
        r#""\x68\x0B\x0B\x68\x82\x85\x08\x3E\x3C\x02\x05\x00\xFF\x0A\xC5\x5E\x16\xE5""#,
        r"\x68\x0b\x0b\x68\x82\x85\x08\x3e\x3c\x02\x05\x00\xff\x0a\xc5\x5e\x16\xe5",
        "bytes.fromhex('680b0b688285083e3c020500ff0ac55e16e5')",
        "bytearray([0x68, 0x0b, 0x0b, 0x68, 0x82, 0x85, 0x08, 0x3e, 0x3c, 0x02, 0x05, 0x00, 0xff, 0x0a, 0xc5, 0x5e, 0x16, 0xe5])",
        "68h 0Bh 0Bh 68h 82h 85h 08h 3Eh 3Ch 02h 05h 00h 0FFh 0Ah 0C5h 5Eh 16h 0E5h",
        "# a comment\n; another\n\nRX -> 68:0b:0b:68:82:85:08:3e:3c:02:05:00:ff:0a:c5:5e:16 ; and more\nslave: E5",
        "$68 $0B $0B $68 $82 $85 $08 $3E $3C $02 $05 $00 $FF $0A $C5 $5E $16 $E5",
        "680B0B688285083E3C020500FF0AC55E16\nE5",
    ] {
        let octets = read(source);
        if source.contains("0FFh") {
            // Assemblers write a zero before a letter; such a number has an odd number of digits.
            assert_eq!(octets, Err(TextError::OddDigits { found: "0FFh".into() }));
        } else {
            assert_eq!(octets.as_deref(), Ok(&OCTETS[..]), "{source}");
        }
    }
}

#[test]
fn words_of_the_manual_are_octets_high_first() {
    assert_eq!(read("13FA 0000 0000 0000"), Ok(Vec::from([0x13, 0xFA, 0, 0, 0, 0, 0, 0])));
    assert_eq!(read("0000 0000 0000 0000").map(|octets| octets.len()), Ok(8), "no dump");
    assert_eq!(read("\u{feff}13FA"), Ok(Vec::from([0x13, 0xFA])));
    assert_eq!(read("0x13FA 0x0000 0x0003 0xD090").map(|octets| octets.len()), Ok(8));
}

#[test]
fn numbers_without_their_leading_zeros_are_words_if_one_is() {
    let pkw = Vec::from([0x33, 0xF8, 0, 0, 0, 3, 0xD0, 0x90]);
    for line in [
        "0x33F8 0x0 0x3 0xD090",
        "$33F8, $0, $3, $D090",
        "16#33F8 16#0 16#3 16#D090",
        "W#16#33F8 W#16#0 W#16#3 W#16#D090",
        "w#16#33f8, DW#16#3, word#16#d090",
        "W#16#33_F8 DWORD#16#0000_0003 B#16#D0 BYTE#16#90 // a comment",
        "L W#16#33F8 W#16#0 W#16#3 W#16#D090 # a comment",
    ] {
        assert_eq!(read(line).as_ref(), Ok(&pkw), "{line}");
    }
    assert_eq!(read("16#10 16#05 16#2"), Ok(Vec::from([0x10, 5, 2])));
    assert_eq!(read("0x10 0x5"), Ok(Vec::from([0x10, 5])));
    assert_eq!(read("0x3AB"), Ok(Vec::from([3, 0xAB])));
    assert_eq!(read("10 05 16#FDL status, no number"), Ok(Vec::from([0x10, 5, 0x16])));
    assert_eq!(read("10 05 16# 1"), Ok(Vec::from([0x10, 5, 0x16])));
}

#[test]
fn a_time_stamp_or_a_label_in_brackets_is_left_out() {
    for line in [
        "12:00:01 E5 10",
        "[12:00:01.123] E5 10",
        "[12:00:01.123] TX: E5 10",
        "[   12.345678] E5 10",
        "(1700000000.123) 0xE5, 0x10",
        "[1234] e510",
        "E5:10",
    ] {
        assert_eq!(read(line), Ok(Vec::from([0xE5, 0x10])), "{line}");
    }
    assert_eq!(read("[E5 10]"), Ok(Vec::from([0xE5, 0x10])));
    assert_eq!(read("[E5 10] an answer"), Ok(Vec::from([0xE5, 0x10])));
}

#[test]
fn what_cannot_be_read_says_why() {
    let unlike = "is not written like the numbers beside it: write each octet with two digits or each word with \
                  four, and a space before a comment";
    for (line, error) in [
        ("0x13FA 0x00 0x00", "'0x00'"),
        ("0x680505 0x3", "'0x3'"),
        ("0x33F8 0x0 10", "'0x0'"),
        ("10 05 02 49 50 16#1", "'16#1'"),
        ("W#16#13FA 0000", "'W#16#13FA'"),
    ] {
        assert_eq!(read(line).unwrap_err().to_string(), format!("{error} {unlike}"), "{line}");
    }
    for (line, error) in [
        ("68 0", "'0' has an odd number of digits; write each octet with two"),
        ("68 0G 05", "'0G' is no hexadecimal octet; comments begin with # or //"),
        ("1O 05 02", "'1O' is no hexadecimal octet; comments begin with # or //"),
        ("hello", "'hello' is no hexadecimal octet; comments begin with # or //"),
        ("hello world", "'world' is no hexadecimal octet; comments begin with # or //"),
        ("00000000: 00\n*", "'*' stands for lines that were left out; dump with hexdump -v, od -v or xxd"),
        (
            "0000000 0b68 680b",
            "this is a dump of 16-bit words, which may have their octets swapped; dump with hexdump -C or od -tx1",
        ),
        (
            "\u{ff11}\u{ff10} 05",
            "'\u{ff11}\u{ff10}' has full-width characters; write the digits 0 to 9 and the letters A to F",
        ),
        (
            "\u{ff25}\u{ff25} 05",
            "'\u{ff25}\u{ff25}' has full-width characters; write the digits 0 to 9 and the letters A to F",
        ),
        ("\u{661}\u{660} 05", "'\u{661}\u{660}' is no hexadecimal octet; comments begin with # or //"),
        ("B#16#1005", "'B#16#1005' has more digits than its type holds"),
        ("0x13F 0", "'0x13F' has an odd number of digits; write each octet with two"),
        ("0x13F 00", "'0x13F' has an odd number of digits; write each octet with two"),
        ("68 \u{fffd}", "'\u{fffd}' is no hexadecimal octet; comments begin with # or //"),
    ] {
        assert_eq!(read(line).unwrap_err().to_string(), error, "{line}");
    }
    let long = "x".repeat(1000);
    assert!(read(&long).unwrap_err().to_string().len() < 100);
}

proptest! {
    #[test]
    fn any_text_is_read_or_refused_and_never_gives_more_octets_than_characters(text: String) {
        let mut reader = HexText::default();
        for line in text.lines() {
            if let Ok(octets) = reader.octets(line) {
                prop_assert!(octets.len() <= line.len());
            }
        }
    }

    #[test]
    fn octets_survive_every_way_of_writing_them(octets in proptest::collection::vec(any::<u8>(), 1..40)) {
        let join = |format: fn(&u8) -> String, between: &str| {
            octets.iter().map(format).collect::<Vec<_>>().join(between)
        };
        for text in [
            join(|octet| format!("{octet:02x}"), " "),
            join(|octet| format!("{octet:02X}"), "-"),
            join(|octet| format!("0x{octet:X}"), ", "),
            join(|octet| format!("\\x{octet:02x}"), ""),
            join(|octet| format!("{octet:02X}"), ""),
        ] {
            prop_assert_eq!(HexText::default().octets(&text), Ok(octets.clone()), "{}", text);
        }
    }
}
