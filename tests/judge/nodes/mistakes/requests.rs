//! Of NMT and of SDO.

use super::*;

pub(super) fn network() -> Vec<Mistake> {
    let taken_as = |row, what, wrong: fn(&Frame) -> bool, as_if: [u8; 2]| {
        hears(row, what, move |_, frame| vec![if wrong(&frame) { data(0, &as_if) } else { frame }])
    };
    vec![
        says("N-K01", "a second boot-up after power-on", |mind, frame| {
            if is_boot_up(&frame) && mind.reset == 0 { vec![frame, frame] } else { vec![frame] }
        }),
        mute("N-K06", "no boot-up after 82h", |mind, frame| is_boot_up(frame) && mind.reset == 0x82),
        says("N-K06", "a second boot-up after a reset", |mind, frame| {
            if is_boot_up(&frame) && mind.reset != 0 { vec![frame, frame] } else { vec![frame] }
        }),
        says("N-K06", "an emergency before the boot-up", |_, frame| {
            if is_boot_up(&frame) { vec![data(0x85, &[0; 8]), frame] } else { vec![frame] }
        }),
        deaf("N-K02", "STOPPED is not entered", |frame| is_nmt(frame) && frame.octets() == [2, 5]),
        deaf("N-K02", "PRE-OPERATIONAL is not entered from OPERATIONAL", {
            |frame| is_nmt(frame) && frame.octets() == [0x80, 5]
        }),
        deaf("N-K03", "number 0 is ignored", |frame| is_nmt(frame) && frame.octets().last() == Some(&0)),
        taken_as(
            "N-K04",
            "number 133 is its own",
            |frame| is_nmt(frame) && frame.octets().get(1) == Some(&0x85),
            [1, 5],
        ),
        taken_as(
            "N-K04",
            "every number is its own",
            |frame| is_nmt(frame) && frame.octets() == [1, 4],
            [1, 5],
        ),
        taken_as("N-K05", "one octet is enough", |frame| is_nmt(frame) && frame.octets() == [1], [1, 5]),
        taken_as(
            "N-K05",
            "three octets are no matter",
            |frame| is_nmt(frame) && frame.octets().len() == 3,
            [1, 5],
        ),
        taken_as(
            "N-K05",
            "a remote frame starts it",
            |frame| frame.id() == base(0) && frame.is_remote(),
            [1, 5],
        ),
        taken_as(
            "N-K05",
            "29 bits are no matter",
            |frame| frame.id().is_extended() && frame.id().number() == 0,
            [1, 5],
        ),
        taken_as("N-K05", "command 03 stops it", |frame| is_nmt(frame) && frame.octets() == [3, 5], [2, 5]),
        hears("N-K08", "SDO is answered in STOPPED", |mind, frame| {
            if is_sdo(&frame) && mind.state == 4 {
                mind.inject.push(answer([0x43, 0, 0x10, 0, 0, 0, 0, 0]));
            }
            vec![frame]
        }),
        tpdo_at_sync("N-K08", "a TPDO in STOPPED", |mind| mind.state == 4)
            .also(&[("N-Y01", "it looks at STOPPED, too")]),
        hears("N-K09", "an abort when it is stopped within a transfer", |mind, frame| {
            if is_nmt(&frame) && frame.octets() == [2, 5] {
                mind.abort(0x0800_0022);
            }
            vec![frame]
        }),
    ]
}

pub(super) fn requests() -> Vec<Mistake> {
    vec![
        says("N-O01", "the address is not repeated", |_, frame| match answered(&frame) {
            Some([command @ (0x43 | 0x4B | 0x4F), _, _, _, rest @ ..]) => {
                let [d, e, f, g] = rest;
                vec![answer([command, 0, 0, 0, d, e, f, g])]
            }
            _ => vec![frame],
        }),
        says("N-O01", "one octet with the command of four", |_, frame| match answered(&frame) {
            Some([0x4F, rest @ ..]) => {
                let [a, b, c, d, e, f, g] = rest;
                vec![answer([0x43, a, b, c, d, e, f, g])]
            }
            _ => vec![frame],
        }),
        says("N-O01", "unused octets are not 0", |_, frame| match answered(&frame) {
            Some([0x4F, a, b, c, d, ..]) => vec![answer([0x4F, a, b, c, d, 0xCC, 0xCC, 0xCC])],
            _ => vec![frame],
        }),
        hears("N-O02", "22h is refused", |mind, frame| {
            if is_sdo(&frame) && frame.octets()[0] == 0x22 {
                mind.abort(0x0504_0001);
                return vec![];
            }
            vec![frame]
        }),
        refuses("N-O03", "another code for a missing object", 0x0602_0000, 0x0800_0000),
        refuses("N-O03", "another code for a missing sub-index", 0x0609_0011, 0x0602_0000),
        takes("N-O04", "a write of 1000h is taken", 0x1000, 0).also(&[("N-X15", "1000h is one of those")]),
        refuses("N-O04", "another code for a write of what is ro", 0x0601_0002, 0x0601_0001)
            .also(&[("N-X15", "it is the same code for all")]),
        takes("N-O05", "a write that is too long is taken", 0x1017, 0),
        says("N-O05", "a code that has nothing to do with it", |mind, frame| match answered(&frame) {
            Some([0x80, a, b, c, ..]) if mind.writes(0x1017, 0) => {
                vec![answer([0x80, a, b, c, 0x30, 0, 9, 6])]
            }
            _ => vec![frame],
        }),
        deaf("N-O07", "an unknown command is not answered", |frame| {
            is_sdo(frame) && frame.octets()[0] == 0xE0
        }),
        hears("N-O07", "a segment without a transfer", |mind, frame| {
            let before = core::mem::replace(&mut mind.count, u32::from(mind.sdo[0]));
            if is_sdo(&frame) && frame.octets() == [0x60, 0, 0, 0, 0, 0, 0, 0] && before == 0xE0 {
                mind.inject.push(answer([0x0F, 0, 0, 0, 0, 0, 0, 0]));
                return vec![];
            }
            vec![frame]
        }),
        hears("N-O10", "an abort is answered", |mind, frame| {
            if is_sdo(&frame) && frame.octets()[0] == 0x80 {
                mind.abort(0x0800_0000);
            }
            vec![frame]
        })
        .also(&[("N-O15", "nobody waits for that answer")]),
        hears("N-O12", "seven octets are enough", |_, frame| {
            let short = frame.id() == base(0x605) && frame.octets().len() == 7;
            vec![if short { data(0x605, &[0x40, 0, 0x10, 0, 0, 0, 0, 0]) } else { frame }]
        }),
        hears("N-O12", "a remote frame is answered", |mind, frame| {
            if frame.id() == base(0x605) && frame.is_remote() {
                mind.inject.push(answer([0x80, 0, 0, 0, 0, 0, 0, 8]));
            }
            vec![frame]
        }),
        hears("N-O12", "29 bits are no matter", |_, frame| {
            let wide = frame.id().is_extended() && frame.id().number() == 0x605;
            vec![if wide { data(0x605, frame.octets()) } else { frame }]
        })
        .also(&[("N-B01", "there are such frames among those of others")]),
        hears("N-B01", "29 bits are no matter", |_, frame| {
            let wide = frame.id().is_extended() && frame.id().number() == 0x605;
            vec![if wide { data(0x605, frame.octets()) } else { frame }]
        })
        .also(&[("N-O12", "it sends one such frame")]),
        hears("N-O14", "it answers for its neighbour", |_, frame| {
            vec![if frame.id() == base(0x604) { data(0x605, frame.octets()) } else { frame }]
        }),
        says("N-O15", "every answer comes twice", |_, frame| {
            if answered(&frame).is_some() { vec![frame, frame] } else { vec![frame] }
        })
        .also(&[
            ("N-K09", "the second answer comes where there must be silence"),
            ("N-O10", "the second answer comes where there must be silence"),
            ("N-O12", "the second answer comes where there must be silence"),
            ("N-O14", "the second answer comes where there must be silence"),
            ("N-B01", "the second answer comes where there must be silence"),
            ("N-B02", "the second answer comes where there must be silence"),
            ("N-T01", "the second answer comes where there must be silence"),
            ("N-O17", "the second answer is taken for a segment"),
            ("N-O22", "the second answer is taken for a segment"),
            ("N-K01", "the second answer comes before the boot-up"),
        ]),
        hears("N-O15", "a request right behind the last one is lost", |mind, frame| {
            let soon = mind.now.saturating_since(mind.said_at) < Duration::from_micros(600);
            if is_sdo(&frame) && soon { vec![] } else { vec![frame] }
        })
        .also(&[
            ("N-O10", "the abort of the client comes as soon"),
            ("N-O17", "the start of a block comes as soon"),
            ("N-O18", "the first segment of a block comes as soon"),
        ]),
        says("N-O20", "answers after 400 ms", |mind, frame| {
            mind.delay = Duration::from_millis(if answered(&frame).is_some() { 400 } else { 0 });
            vec![frame]
        })
        .also(&[
            ("N-E02", "heartbeats begin before the write of 1017h is answered"),
            ("N-E09", "heartbeats begin before the write of 1017h is answered"),
            ("N-Y53", "SYNCs begin before the write of 1005h is answered"),
        ]),
    ]
}

pub(super) fn segments() -> Vec<Mistake> {
    vec![
        says("N-O08", "another length is announced", |_, frame| match answered(&frame) {
            Some([0x41, a, b, c, d, e, f, g]) => vec![answer([0x41, a, b, c, d + 1, e, f, g])],
            _ => vec![frame],
        })
        .also(&[("N-X09", "it reads texts, too")]),
        says("N-O08", "the toggle bit does not alternate", |_, frame| match answered(&frame) {
            Some([command, rest @ ..]) if command >> 5 == 0 => {
                let [a, b, c, d, e, f, g] = rest;
                vec![answer([command & 0xEF, a, b, c, d, e, f, g])]
            }
            _ => vec![frame],
        })
        .also(&[("N-X09", "it reads texts, too")]),
        says("N-O08", "unused octets of the last segment are not 0", |_, frame| match answered(&frame) {
            Some([command, a, b, c, d, e, f, _]) if command >> 5 == 0 && command & 0x0F > 1 => {
                vec![answer([command, a, b, c, d, e, f, 0xCC])]
            }
            _ => vec![frame],
        })
        .also(&[("N-O17", "so are segments of a block")]),
        hears("N-O09", "a wrong toggle bit is no matter", |mind, frame| {
            let first = core::mem::replace(&mut mind.flag, is_sdo(&frame) && frame.octets()[0] == 0x40);
            let wrong = first && frame.octets().first() == Some(&0x70);
            vec![if wrong { data(0x605, &[0x60, 0, 0, 0, 0, 0, 0, 0]) } else { frame }]
        }),
        refuses("N-O09", "another code for a wrong toggle bit", 0x0503_0000, 0x0504_0001)
            .also(&[("N-O23", "it is the code of writes, too")]),
        hears("N-O11", "a new request within a transfer is refused", |mind, frame| {
            let begins = is_sdo(&frame) && mind.reads(0x1008, 0);
            let within = core::mem::replace(&mut mind.flag, begins);
            if within && is_sdo(&frame) && mind.reads(0x1000, 0) {
                mind.abort(0x0504_0001);
                return vec![];
            }
            vec![frame]
        }),
        says("N-O17", "a wrong checksum of a block", |_, frame| match answered(&frame) {
            Some([command, low, rest @ ..]) if command & 0xE3 == 0xC1 => {
                let [b, c, d, e, f, g] = rest;
                vec![answer([command, !low, b, c, d, e, f, g])]
            }
            _ => vec![frame],
        }),
        says("N-O17", "segments of a block count from 2", |mind, frame| match answered(&frame) {
            Some([number @ (1..=3 | 0x81..=0x83), a, b, c, d, e, f, g])
                if matches!(mind.sdo[0], 0xA2 | 0xA3) =>
            {
                vec![answer([number + 1, a, b, c, d, e, f, g])]
            }
            _ => vec![frame],
        })
        .also(&[("N-O15", "nobody waits for those that follow")]),
        says("N-O22", "the toggle bit of the answer to a segment is wrong", |_, frame| {
            match answered(&frame) {
                Some([command @ (0x20 | 0x30), ..]) => vec![answer([command ^ 0x10, 0, 0, 0, 0, 0, 0, 0])],
                _ => vec![frame],
            }
        })
        .also(&[("N-X17", "it writes texts, too")]),
        hears("N-O23", "a wrong toggle bit in a write is no matter", |mind, frame| {
            let first = core::mem::replace(&mut mind.flag, is_sdo(&frame) && frame.octets()[0] == 0x21);
            let mut octets = frame.octets().to_vec();
            if first && is_sdo(&frame) && octets[0] & 0xF0 == 0x10 {
                octets[0] &= 0xEF;
                return vec![data(0x605, &octets)];
            }
            vec![frame]
        }),
        says("N-O18", "a wrong checksum is no matter", |_, frame| match answered(&frame) {
            Some([0x80, _, _, _, 0x04, 0, 0x04, 0x05]) => vec![answer([0xA1, 0, 0, 0, 0, 0, 0, 0])],
            _ => vec![frame],
        }),
        says("N-O25", "a lost segment of a block is taken for none", |_, frame| match answered(&frame) {
            Some([0xA2, 1, rest @ ..]) => {
                let [b, c, d, e, f, g] = rest;
                vec![answer([0xA2, 3, b, c, d, e, f, g])]
            }
            _ => vec![frame],
        }),
        hears("N-O26", "what the client has not taken of a block is lost", |_, frame| {
            let fewer = is_sdo(&frame) && frame.octets()[..3] == [0xA2, 1, 127];
            vec![if fewer { data(0x605, &[0xA2, 2, 127, 0, 0, 0, 0, 0]) } else { frame }]
        }),
        says("N-O24", "more octets than the object has are taken", |mind, frame| match answered(&frame) {
            Some([0x80, ..]) if mind.sdo[0] == 0x01 => vec![answer([0x20, 0, 0, 0, 0, 0, 0, 0])],
            _ => vec![frame],
        }),
    ]
}
