//! Of PDOs, mappings, storage and LSS.

use super::*;

pub(super) fn process_data() -> Vec<Mistake> {
    let written = |mind: &Mind, frame: &Frame, sub: u8| is_sdo(frame) && mind.writes(0x1800, sub);
    let set_to = |row, what, index: u16, sub: u8, from: u8, to: u8| {
        hears(row, what, move |mind, frame| {
            let hit = is_sdo(&frame) && mind.writes(index, sub) && mind.sdo[4] == from;
            vec![if hit { write(index, sub, &[to]) } else { frame }]
        })
    };
    vec![
        says("N-Y02", "a TPDO that is too short", |_, frame| {
            vec![if is_tpdo(&frame) {
                data(0x185, &frame.octets()[..frame.octets().len() - 1])
            } else {
                frame
            }]
        }),
        says("N-Y02", "two TPDOs after a SYNC", |_, frame| {
            if is_tpdo(&frame) { vec![frame, frame] } else { vec![frame] }
        }),
        says("N-Y02", "other values than SDO shows", |_, frame| {
            let other: Vec<u8> = frame.octets().iter().map(|octet| !octet).collect();
            vec![if is_tpdo(&frame) { data(0x185, &other) } else { frame }]
        }),
        set_to("N-Y22", "type 3 is type 4", 0x1800, 2, 3, 4),
        tpdo_at_sync("N-Y01", "a TPDO in PRE-OPERATIONAL", |mind| mind.state == 0x7F),
        hears("N-Y06", "bit 31 does not matter", move |mind, frame| {
            if written(mind, &frame, 1) {
                mind.flag = mind.sdo[7] & 0x80 != 0;
            }
            if frame.id() == base(0x80) && mind.flag && mind.state == 5 {
                mind.inject.push(data(0x185, &TPDO));
            }
            vec![frame]
        }),
        hears("N-Y03", "bit 30 does not matter", move |mind, frame| {
            if written(mind, &frame, 1) {
                mind.flag = mind.sdo[7] & 0x40 != 0;
            }
            if frame.id() == base(0x185) && frame.is_remote() && mind.flag {
                mind.inject.push(data(0x185, &TPDO));
            }
            vec![frame]
        }),
        deaf("N-Y33", "remote requests are not answered", |frame| {
            frame.id() == base(0x185) && frame.is_remote()
        })
        .also(&[("N-Y04", "types 252 and 253 are asked by them")]),
        hears("N-Y04", "a TPDO of type 253 at a SYNC", move |mind, frame| {
            if written(mind, &frame, 2) {
                mind.flag = mind.sdo[4] >= 252 && mind.sdo[4] <= 253;
            }
            if frame.id() == base(0x80) && mind.flag && mind.state == 5 {
                mind.inject.push(data(0x185, &TPDO));
            }
            vec![frame]
        }),
        hears("N-Y05", "an event timer that is a third too slow", |mind, frame| {
            if is_sdo(&frame) && mind.writes(0x1800, 5) {
                let millis = u16::from_le_bytes([mind.sdo[4], mind.sdo[5]]);
                return vec![write(0x1800, 5, &(millis + millis / 3).to_le_bytes())];
            }
            vec![frame]
        }),
        forgets("N-Y25", "the inhibit time does not matter", 0x1800, 3),
        mute("N-Y26", "no TPDO on a change", |mind, frame| {
            is_tpdo(frame) && mind.at().0 == 0x2110 && mind.sdo[0] == 0x2B
        }),
        says("N-Y07", "the new identifier is not used", |_, frame| {
            vec![if frame.id() == base(0x3F0) { data(0x185, frame.octets()) } else { frame }]
        }),
        takes_in_spite_of(
            "N-Y47",
            "the identifier of a TPDO that is on is changed",
            (0x1800, 1),
            &[0x0800_0022],
        ),
        hears("N-Y54", "a SYNC with an octet is ignored", |mind, frame| {
            if mind.writes(0x1019, 0) {
                mind.flag = mind.sdo[4] != 0;
            }
            let long = frame.id() == base(0x80) && frame.octets().len() == 1;
            if long && !mind.flag { vec![] } else { vec![frame] }
        }),
        taken_for("N-Y12", "1005h does not matter", (0x1005, 0), 0xF8, 0x80),
        takes("N-Y15", "type 245 is taken", 0x1800, 2),
        takes_in_spite_of(
            "N-Y16",
            "a restricted identifier is taken",
            (0x1800, 1),
            &[0x0609_0030, 0x0604_0043],
        ),
        hears("N-Y18", "a SYNC of 29 bits", |_, frame| {
            let wide = frame.id().is_extended() && frame.id().number() == 0x80;
            vec![if wide { data(0x80, &[]) } else { frame }]
        }),
        hears("N-Y13", "a TPDO of type 0 at each SYNC", move |mind, frame| {
            if written(mind, &frame, 2) {
                mind.flag = mind.sdo[4] == 0;
            }
            if frame.id() == base(0x80) && mind.flag && mind.state == 5 {
                mind.inject.push(data(0x185, &TPDO));
            }
            vec![frame]
        }),
        Mistake {
            say: Box::new(|mind, frame| {
                let first = is_tpdo(&frame) && core::mem::take(&mut mind.flag);
                if first { vec![] } else { vec![frame] }
            }),
            ..hears("N-Y17", "no TPDO when OPERATIONAL is entered", move |mind, frame| {
                if written(mind, &frame, 2) {
                    mind.count = mind.sdo[4].into();
                }
                mind.flag |= is_nmt(&frame) && frame.octets() == [1, 5] && mind.count >= 254;
                vec![frame]
            })
        },
        says("N-Y45", "PDO parameters stay after 82h", |mind, frame| match answered(&frame) {
            Some([0x4F, a, b, c, ..]) if mind.reset == 0x82 && mind.reads(0x1800, 2) => {
                vec![answer([0x4F, a, b, c, 7, 0, 0, 0])]
            }
            _ => vec![frame],
        }),
        deaf("N-Y08", "RPDOs are ignored", |frame| frame.id() == base(0x205)),
        set_to("N-Y28", "an RPDO of type 1 is taken at once", 0x1400, 2, 1, 255),
        hears("N-Y09", "a short RPDO is taken", |_, frame| {
            let short = frame.id() == base(0x205) && frame.octets().len() == 2;
            let octets = [frame.octets(), &[0]].concat();
            vec![if short { data(0x205, &octets) } else { frame }]
        }),
        deaf("N-Y29", "a long RPDO is ignored", |frame| {
            frame.id() == base(0x205) && frame.octets().len() > 3
        }),
        hears("N-Y30", "an RPDO is taken in PRE-OPERATIONAL", |mind, frame| {
            if frame.id() == base(0x205) && mind.state == 0x7F {
                return vec![data(0, &[1, 5]), frame, data(0, &[0x80, 5])];
            }
            vec![frame]
        }),
        hears("N-Y30", "an RPDO of 29 bits is taken", |_, frame| {
            let wide = frame.id().is_extended() && frame.id().number() == 0x205;
            vec![if wide { data(0x205, frame.octets()) } else { frame }]
        }),
        says("N-Y10", "a TPDO has its former length", |_, frame| {
            vec![if is_tpdo(&frame) { data(0x185, &TPDO) } else { frame }]
        }),
        takes_in_spite_of("N-Y41", "what is not there is mapped", (0x1A00, 1), &[0x0602_0000, 0x0604_0041]),
        takes("N-Y42", "more than 64 bits are mapped", 0x1A00, 0),
        takes_in_spite_of(
            "N-Y43",
            "an entry of a mapping that is on is changed",
            (0x1A00, 1),
            &[0x0800_0022],
        ),
    ]
}

pub(super) fn counter() -> Vec<Mistake> {
    vec![
        takes_in_spite_of("N-Y50", "1019h = 241 is taken", (0x1019, 0), &[0x0609_0030]),
        takes_in_spite_of("N-Y51", "1019h is taken while 1006h is not 0", (0x1019, 0), &[0x0800_0022]),
        hears("N-Y52", "the SYNC start value does not matter", |mind, frame| {
            if is_sdo(&frame) && mind.writes(0x1800, 6) && mind.sdo[4] == 5 {
                mind.done();
                return vec![];
            }
            vec![frame]
        }),
        hears("N-Y53", "SYNCs come at half of 1006h", |mind, frame| {
            let is_period = is_sdo(&frame) && mind.writes(0x1006, 0) && mind.sdo[4..6] == [0x50, 0xC3];
            vec![if is_period { write(0x1006, 0, &25_000_u32.to_le_bytes()) } else { frame }]
        }),
        says("N-Y53", "SYNCs do not count", |_, frame| {
            vec![if frame.id() == base(0x80) { data(0x80, &[1]) } else { frame }]
        }),
        hears("N-T01", "a TIME is answered", |mind, frame| {
            if frame.id() == base(0x100) && !frame.is_remote() {
                mind.inject.push(data(0x85, &[0x50, 0x82, 0x11, 0, 0, 0, 0, 0]));
            }
            vec![frame]
        }),
    ]
}

pub(super) fn storage() -> Vec<Mistake> {
    vec![
        takes("N-R03", "a wrong signature is taken", 0x1010, 1),
        reads("N-R05", "1010h:1 says that it stores nothing", (0x1010, 1), &[0, 0, 0, 0])
            .also(&[("N-X04", "1010h has a default")]),
        signed_for_nothing("N-R01", "what is saved is forgotten", 0x1010, *b"save"),
        signed_for_nothing("N-R02", "load does nothing", 0x1011, *b"load"),
        hears("N-X46", "81h takes nothing back", |mind, frame| {
            if is_sdo(&frame) {
                mind.flag =
                    mind.writes(0x1017, 0) && mind.sdo[4..6] == [0xC4, 9] || mind.flag && mind.sdo[0] == 0x40;
            }
            if is_nmt(&frame) && frame.octets() == [0x81, 5] && mind.flag {
                mind.inject.push(data(0x705, &[0]));
                return vec![data(0, &[0x80, 5])];
            }
            vec![frame]
        }),
        says("N-S01", "LSS tells another number", |_, frame| {
            let own = frame.id() == base(0x7E4) && frame.octets()[0] == 0x5E;
            vec![if own { data(0x7E4, &[0x5E, 6, 0, 0, 0, 0, 0, 0]) } else { frame }]
        }),
        says("N-S01", "LSS tells another vendor", |_, frame| {
            let own = frame.id() == base(0x7E4) && frame.octets()[0] == 0x5A;
            vec![if own { data(0x7E4, &[0x5A, 6, 0, 0, 0, 0, 0, 0]) } else { frame }]
        }),
        hears("N-S02", "LSS tells its number in the waiting state", |_, frame| {
            let asked = frame.id() == base(0x7E5) && frame.octets().first() == Some(&0x5E);
            let configuration = data(0x7E5, &[4, 1, 0, 0, 0, 0, 0, 0]);
            if asked { vec![configuration, frame] } else { vec![frame] }
        }),
        hears("N-S04", "the number 128 is 5", |_, frame| {
            let hit = frame.id() == base(0x7E5) && frame.octets().starts_with(&[0x11, 128]);
            vec![if hit { data(0x7E5, &[0x11, 5, 0, 0, 0, 0, 0, 0]) } else { frame }]
        }),
        hears("N-S04", "a new number is acknowledged and forgotten", |mind, frame| {
            let hit = frame.id() == base(0x7E5) && frame.octets().starts_with(&[0x11, 4]);
            if hit {
                mind.inject.push(data(0x7E4, &[0x11, 0, 0, 0, 0, 0, 0, 0]));
                return vec![];
            }
            vec![frame]
        }),
        hears("N-S05", "every rate is taken", |_, frame| {
            let hit = frame.id() == base(0x7E5) && frame.octets().starts_with(&[0x13, 0, 200]);
            vec![if hit { data(0x7E5, &[0x13, 0, 2, 0, 0, 0, 0, 0]) } else { frame }]
        }),
        hears("N-S06", "identify does not look at the serial number", |_, frame| {
            let asks = frame.id() == base(0x7E5) && matches!(frame.octets().first(), Some(0x4A | 0x4B));
            let own = |command| data(0x7E5, &[command, 7, 0, 0, 0, 0, 0, 0]);
            vec![if asks { own(frame.octets()[0]) } else { frame }]
        }),
        hears("N-S03", "any serial number selects it", |_, frame| {
            let serial = frame.id() == base(0x7E5) && frame.octets().first() == Some(&0x43);
            vec![if serial { data(0x7E5, &[0x43, 7, 0, 0, 0, 0, 0, 0]) } else { frame }]
        }),
    ]
}
