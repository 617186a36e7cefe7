//! Of drives, and of nodes that do not live on.

use super::*;

/// Another status word.
fn status(row: &'static str, what: &'static str, wrong: impl Fn(u16) -> u16 + Send + 'static) -> Mistake {
    says(row, what, move |mind, frame| match answered(&frame) {
        Some([0x4B, a, b, c, d, e, ..]) if mind.reads(0x6041, 0) => {
            let [d, e] = wrong(u16::from_le_bytes([d, e])).to_le_bytes();
            vec![answer([0x4B, a, b, c, d, e, 0, 0])]
        }
        _ => vec![frame],
    })
}

/// Another control word.
fn control(row: &'static str, what: &'static str, from: u16, to: Option<u16>) -> Mistake {
    hears(row, what, move |mind, frame| {
        if !is_sdo(&frame)
            || !mind.writes(0x6040, 0)
            || u16::from_le_bytes([mind.sdo[4], mind.sdo[5]]) != from
        {
            return vec![frame];
        }
        match to {
            Some(to) => vec![write(0x6040, 0, &to.to_le_bytes())],
            None => {
                mind.done();
                vec![]
            }
        }
    })
}

/// Those of a drive of CiA 402.
pub(crate) fn of_drives() -> Vec<Mistake> {
    vec![
        status("N-D01", "READY TO SWITCH ON after a reset", |word| {
            if word & 0x4F == 0x40 { word & !0x40 | 0x21 } else { word }
        }),
        control("N-D02", "shutdown does nothing", 0x06, None),
        control("N-D02", "switch on does nothing", 0x07, None),
        control("N-D02", "enable operation does nothing", 0x0F, None),
        status("N-D02", "OPERATION ENABLED without bit 2", |word| {
            if word & 0x6F == 0x27 { word & !4 } else { word }
        }),
        hears("N-D03", "disable voltage does nothing once it is enabled", |mind, frame| {
            if is_sdo(&frame) && mind.writes(0x6040, 0) {
                mind.flag |= mind.sdo[4] == 0x0F;
                if mind.sdo[4] == 0 && mind.flag {
                    mind.done();
                    return vec![];
                }
            }
            vec![frame]
        }),
        control("N-D04", "quick stop does nothing", 0x02, None),
        hears("N-D05", "switch on in SWITCH ON DISABLED does shutdown", |mind, frame| {
            let hit = is_sdo(&frame) && mind.writes(0x6040, 0) && mind.sdo[4] == 7;
            vec![if hit { write(0x6040, 0, &[6, 0]) } else { frame }]
        }),
        reads("N-D06", "6061h does not follow", (0x6061, 0), &[1]),
        says("N-D06", "a mode that it lacks is shown", |mind, frame| {
            if mind.writes(0x6060, 0) {
                mind.count = mind.sdo[4].into();
            }
            match answered(&frame) {
                Some([0x4F, a, b, c, ..]) if mind.reads(0x6061, 0) => {
                    vec![answer([0x4F, a, b, c, mind.count as u8, 0, 0, 0])]
                }
                Some([0x80, a, b, c, ..]) if mind.writes(0x6060, 0) => {
                    vec![answer([0x60, a, b, c, 0, 0, 0, 0])]
                }
                _ => vec![frame],
            }
        }),
        reads("N-D07", "606Ch is half of what was asked for", (0x606C, 0), &[0xF4, 1, 0, 0]),
        status("N-D08", "a new set-point is not acknowledged", |word| word & !0x1000),
        status("N-D08", "the target is never reached", |word| word & !0x0400),
    ]
}

/// Nodes that do not live on.
pub(crate) fn that_end() -> Vec<Mistake> {
    vec![
        says("N-O03", "it dies at an object that it does not know", |mind, frame| {
            mind.flag |= mind.at().0 == 0x9999;
            if mind.flag { vec![] } else { vec![frame] }
        }),
        Mistake {
            every: Some(Duration::from_micros(300)),
            ..says("N-B02", "it floods the bus", |mind, frame| {
                if frame.id() != base(0x7FF) {
                    return vec![frame];
                }
                mind.count += 1;
                // Not from the start, when nothing could be judged.
                if mind.count > 600 { vec![data(0x3F5, &[1])] } else { vec![] }
            })
        },
    ]
}
