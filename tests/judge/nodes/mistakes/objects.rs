//! Of objects, error control, emergencies.

use super::*;

pub(super) fn objects() -> Vec<Mistake> {
    vec![
        reads("N-R04", "another device type", (0x1000, 0), &[0x91, 1, 0, 0])
            .also(&[("N-X04", "1000h has a default")]),
        reads("N-X21", "another product", (0x1018, 2), &[1, 0, 0, 0])
            .also(&[("N-S01", "LSS has the right one, and SDO another")]),
        reads("N-X09", "two octets are four", (0x2000, 0), &[100, 0, 0, 0]),
        says("N-X09", "an entry is missing", |mind, frame| match answered(&frame) {
            Some([_, a, b, c, ..]) if mind.reads(0x2007, 3) => vec![answer([0x80, a, b, c, 0x11, 0, 9, 6])],
            _ => vec![frame],
        }),
        reads("N-X04", "another constant", (0x2006, 0), &[1, 1, 1, 1]),
        reads("N-X04", "another default", (0x2007, 2), &[3, 0])
            .also(&[("N-X60", "it is read whatever was written")]),
        reads("N-X12", "another highest sub-index", (0x2007, 0), &[2]),
        reads("N-X14", "an object that is not listed", (0x2112, 0), &[1]),
        reads("N-X14", "a sub-index that is not listed", (0x2007, 4), &[1]),
        takes("N-X15", "a write of what is ro is taken", 0x2004, 0),
        reads("N-X16", "what is wo is read", (0x2003, 0), &[1, 2, 3, 4]),
        says("N-X17", "what is rw is not written", |mind, frame| match answered(&frame) {
            Some([0x60, a, b, c, ..]) if mind.writes(0x2005, 0) => vec![answer([0x80, a, b, c, 2, 0, 1, 6])],
            _ => vec![frame],
        }),
        taken_for("N-X60", "what is written is forgotten", (0x2000, 0), 101, 100),
        takes_in_spite_of(
            "N-X18",
            "another length is taken",
            (0x2000, 0),
            &[0x0607_0010, 0x0607_0012, 0x0607_0013],
        ),
        takes_in_spite_of("N-X19", "limits are not looked at", (0x2005, 0), &[0x0609_0031, 0x0609_0032]),
        refuses("N-X19", "another code for a value that is too high", 0x0609_0031, 0x0800_0000),
        says("N-X10", "a zero at the end of a text", |mind, frame| match answered(&frame) {
            Some([0x41, a, b, c, d, e, f, g]) if mind.reads(0x1008, 0) => {
                mind.flag = true;
                vec![answer([0x41, a, b, c, d + 1, e, f, g])]
            }
            Some([0x03, rest @ ..]) if core::mem::take(&mut mind.flag) => {
                let [a, b, c, d, e, f, g] = rest;
                vec![answer([0x01, a, b, c, d, e, f, g])]
            }
            _ => vec![frame],
        })
        .also(&[("N-X04", "the text has a default"), ("N-O17", "read in blocks it has no zero")]),
    ]
}

pub(super) fn error_control() -> Vec<Mistake> {
    let lost = |mind: &Mind, frame: &Frame| {
        frame.id() == base(0x85) && frame.octets()[..2] != [0, 0] && mind.state != 0
    };
    vec![
        hears("N-E01", "a heartbeat that is a third too slow", |mind, frame| {
            if is_sdo(&frame) && mind.writes(0x1017, 0) && mind.sdo[0] == 0x2B && mind.sdo[5] == 0 {
                let millis = u16::from(mind.sdo[4]);
                return vec![write(0x1017, 0, &(millis + millis / 3).to_le_bytes())];
            }
            vec![frame]
        }),
        hears("N-E01", "1017h = 0 does not stop it", |mind, frame| {
            if is_sdo(&frame) && mind.writes(0x1017, 0) && mind.sdo[0] == 0x2B && mind.sdo[4..6] == [0, 0] {
                mind.done();
                return vec![];
            }
            vec![frame]
        }),
        says("N-E02", "the heartbeat is that of PRE-OPERATIONAL for ever", |mind, frame| {
            if mind.writes(0x1017, 0) {
                mind.flag = mind.sdo[4..6] != [0, 0];
            }
            // Guarding is answered as it should be.
            let alive = frame.id() == base(0x705) && frame.octets() != [0] && mind.flag;
            vec![if alive { data(0x705, &[0x7F]) } else { frame }]
        }),
        says("N-E03", "the toggle bit of guarding is 0 for ever", |_, frame| {
            let alive = frame.id() == base(0x705) && frame.octets() != [0];
            vec![if alive { data(0x705, &[frame.octets()[0] & 0x7F]) } else { frame }]
        }),
        says("N-E03", "the toggle bit is 1 first after a reset", |mind, frame| {
            let alive = frame.id() == base(0x705) && frame.octets() != [0] && mind.reset == 0x82;
            vec![if alive { data(0x705, &[frame.octets()[0] ^ 0x80]) } else { frame }]
        }),
        mute("N-E04", "no emergency when guarding stops", lost)
            .also(&[("N-E05", "no emergency comes at all")]),
        mute("N-E05", "no emergency when heartbeats stop", lost)
            .also(&[("N-E04", "no emergency comes at all")]),
        reads("N-E05", "1001h has no bit for it", (0x1001, 0), &[0]),
        forgets("N-E06", "1029h does not matter", 0x1029, 1),
        takes("N-E07", "a node is supervised twice", 0x1016, 2),
        says("N-E09", "a heartbeat with the write of 1017h", |mind, frame| {
            let is_set = mind.writes(0x1017, 0) && mind.sdo[4..6] == [200, 0];
            match answered(&frame) {
                Some([0x60, ..]) if is_set => vec![frame, data(0x705, &[0x7F])],
                _ => vec![frame],
            }
        }),
        says("N-M01", "an emergency without 1001h", |_, frame| {
            let own = frame.id() == base(0x85) && frame.octets().len() == 8;
            let mut octets = frame.octets().to_vec();
            if own {
                octets[2] = 0;
            }
            vec![if own { data(0x85, &octets) } else { frame }]
        }),
        says("N-M01", "an emergency of seven octets", |_, frame| {
            vec![if frame.id() == base(0x85) { data(0x85, &frame.octets()[..7]) } else { frame }]
        }),
        reads("N-M01", "1003h does not have it", (0x1003, 0), &[0]),
        says("N-M02", "an emergency comes twice", |_, frame| {
            if frame.id() == base(0x85) { vec![frame, frame] } else { vec![frame] }
        }),
        says("N-E08", "1014h does not move it", |_, frame| {
            vec![if frame.id() == base(0xF0) { data(0x85, frame.octets()) } else { frame }]
        }),
        forgets("N-E08", "bit 31 of 1014h does not matter", 0x1014, 0),
        takes("N-M03", "1003h:0 = 1 is taken", 0x1003, 0),
        says("N-M04", "1003h beyond its count", |mind, frame| match answered(&frame) {
            Some([0x80, a, b, c @ 1..=4, ..]) if mind.reads(0x1003, c) => {
                vec![answer([0x43, a, b, c, 1, 2, 3, 4])]
            }
            _ => vec![frame],
        }),
        hears("N-M05", "an emergency of STOPPED comes later", |mind, frame| {
            if is_nmt(&frame) && frame.octets() == [0x80, 5] && mind.state == 4 {
                mind.inject.push(data(0x85, &[0x30, 0x81, 0x11, 0, 0, 0, 0, 0]));
            }
            vec![frame]
        }),
        forgets("N-M06", "1015h does not matter", 0x1015, 0),
        Mistake {
            every: Some(Duration::from_millis(70)),
            ..says("N-B02", "a frame each 70 ms that nobody asked for", |_, frame| {
                vec![if frame.id() == base(0x7FF) { data(0x3F5, &[1]) } else { frame }]
            })
        },
    ]
}
