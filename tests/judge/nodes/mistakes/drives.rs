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

/// The same in one mode alone.
fn status_in(
    mode: u8,
    row: &'static str,
    what: &'static str,
    wrong: impl Fn(u16) -> u16 + Send + 'static,
) -> Mistake {
    says(row, what, move |mind, frame| match answered(&frame) {
        Some([0x4B, a, b, c, d, e, ..]) if mind.reads(0x6041, 0) && mind.mode == mode => {
            let [d, e] = wrong(u16::from_le_bytes([d, e])).to_le_bytes();
            vec![answer([0x4B, a, b, c, d, e, 0, 0])]
        }
        _ => vec![frame],
    })
}

/// A number is taken for another one once the drive was enabled.
fn driven_for(row: &'static str, what: &'static str, at: (u16, u8), from: i32, to: i32) -> Mistake {
    let mut taken = taken_for(row, what, at, from, to);
    let mut hear = taken.hear;
    taken.hear = Box::new(move |mind, frame| if mind.was_enabled { hear(mind, frame) } else { vec![frame] });
    taken
}

/// What is written in that mode is forgotten.
fn forgets_in(mode: u8, row: &'static str, what: &'static str, (index, sub): (u16, u8)) -> Mistake {
    hears(row, what, move |mind, frame| {
        if is_sdo(&frame) && mind.writes(index, sub) && mind.mode == mode && mind.was_enabled {
            mind.done();
            return vec![];
        }
        vec![frame]
    })
}

/// A SYNC behind each RPDO of that identifier: what it carries acts at once.
fn at_once(row: &'static str, what: &'static str, id: u16) -> Mistake {
    hears(
        row,
        what,
        move |_, frame| {
            if frame.id() == base(id) { vec![frame, data(0x80, &[])] } else { vec![frame] }
        },
    )
}

fn states() -> Vec<Mistake> {
    vec![
        status("N-D01", "READY TO SWITCH ON after a reset", |word| {
            if word & 0x4F == 0x40 { word & !0x40 | 0x21 } else { word }
        })
        .also(&[("N-Y02", "a TPDO has another status word than SDO shows")]),
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
            if !is_sdo(&frame) || !mind.writes(0x6040, 0) {
                return vec![frame];
            }
            let was_off = mind.flag;
            mind.flag = mind.sdo[4] == 0;
            vec![if was_off && mind.sdo[4] == 7 { write(0x6040, 0, &[6, 0]) } else { frame }]
        }),
        hears("N-D09", "quick stop does nothing before OPERATION ENABLED", |mind, frame| {
            if is_sdo(&frame) && mind.writes(0x6040, 0) {
                let before = core::mem::replace(&mut mind.count, mind.sdo[4].into());
                if mind.sdo[4] == 2 && before < 0x0F {
                    mind.done();
                    return vec![];
                }
            }
            vec![frame]
        }),
    ]
}

fn modes() -> Vec<Mistake> {
    vec![
        reads("N-D06", "6061h does not follow", (0x6061, 0), &[1]),
        says("N-D06", "a mode that it refuses is shown", |mind, frame| match answered(&frame) {
            Some([0x4F, a, b, c, ..]) if mind.reads(0x6061, 0) && mind.mode == 8 => {
                vec![answer([0x4F, a, b, c, 9, 0, 0, 0])]
            }
            _ => vec![frame],
        }),
        reads("N-D07", "606Ch is half of what was asked for", (0x606C, 0), &[0xF4, 1, 0, 0]),
        status_in(1, "N-D08", "a new set-point is not acknowledged", |word| word & !0x1000),
        status_in(1, "N-D08", "the target is never reached", |word| word & !0x0400),
        hears("N-D10", "bit 6 does not matter: every set-point is absolute", |mind, frame| {
            let is_word = is_sdo(&frame) && mind.writes(0x6040, 0) && mind.sdo[0] == 0x2B;
            let relative = is_word && mind.was_enabled && mind.mode == 1;
            vec![if relative { write(0x6040, 0, &[mind.sdo[4] & !0x40, 0]) } else { frame }]
        }),
        says("N-D11", "6077h is 0 for ever", |mind, frame| match answered(&frame) {
            Some([0x4B, a, b, c, ..]) if mind.reads(0x6077, 0) && mind.mode == 4 => {
                vec![answer([0x4B, a, b, c, 0, 0, 0, 0])]
            }
            _ => vec![frame],
        }),
        driven_for("N-D12", "bit 6 does not matter", (0x6040, 0), 0x3F, 0x7F),
        reads("N-D12", "6044h is 0 for ever", (0x6044, 0), &[0, 0]),
        at_once("N-D13", "a cyclic position acts before its SYNC", 0x305),
        status_in(8, "N-D13", "bit 12 is 0 in csp", |word| word & !0x1000),
        Mistake {
            say: Box::new(|mind, frame| match answered(&frame) {
                Some([0x43, a, b, c, ..]) if mind.reads(0x6064, 0) && mind.mode == 8 && mind.flag => {
                    let [d, e, f, g] = mind.set_point[1].to_le_bytes();
                    vec![answer([0x43, a, b, c, d, e, f, g])]
                }
                _ => vec![frame],
            }),
            ..hears("N-D14", "it jumps from set-point to set-point", |mind, frame| {
                match (frame.id().number(), frame.octets()) {
                    (0x305, [_, _, a, b, c, d]) => mind.set_point[0] = i32::from_le_bytes([*a, *b, *c, *d]),
                    (0x80, []) => (mind.set_point[1], mind.flag) = (mind.set_point[0], mind.mode == 8),
                    _ => {}
                }
                mind.flag &= mind.mode == 8;
                vec![frame]
            })
        },
        at_once("N-D15", "a cyclic velocity acts before its SYNC", 0x405),
        status_in(9, "N-D15", "bit 12 is 0 in csv", |word| word & !0x1000),
        status_in(10, "N-D16", "bit 12 is 0 in cst", |word| word & !0x1000),
        status_in(7, "N-D32", "bit 12 is 0 in ip", |word| word & !0x1000),
        status_in(7, "N-D32", "bit 12 is 1 in ip without bit 4", |word| word | 0x1000),
        driven_for("N-D17", "607Ch does not matter", (0x607C, 0), 1235, 0),
        status_in(6, "N-D17", "homing is never attained", |word| word & !0x1000),
        says("N-D18", "homing by method 18 is attained and wrong at once", |mind, frame| {
            if mind.writes(0x6098, 0) {
                mind.flag = mind.sdo[4] == 18;
            }
            match answered(&frame) {
                Some([0x4B, a, b, c, d, e, ..]) if mind.reads(0x6041, 0) && mind.flag && e & 0x10 != 0 => {
                    vec![answer([0x4B, a, b, c, d, e | 0x20, 0, 0])]
                }
                _ => vec![frame],
            }
        }),
        says("N-D19", "a method of 60E3h is refused", |mind, frame| match answered(&frame) {
            Some([0x60, a, b, c, ..]) if mind.writes(0x6098, 0) && mind.sdo[4] == 7 => {
                vec![answer([0x80, a, b, c, 0x30, 0, 9, 6])]
            }
            _ => vec![frame],
        }),
        driven_for("N-D19", "method 3, which 60E3h does not name, is method 35", (0x6098, 0), 3, 35),
        hears("N-D20", "a homing whose bit 4 is taken back goes on", |mind, frame| {
            let is_it = is_sdo(&frame) && mind.writes(0x6040, 0) && mind.mode == 6;
            let began = is_it && core::mem::replace(&mut mind.flag, mind.sdo[4] == 0x1F);
            vec![if began && mind.sdo[4] == 0x0F { write(0x6040, 0, &[0x1F, 0]) } else { frame }]
        }),
    ]
}

fn stops_and_limits() -> Vec<Mistake> {
    vec![
        driven_for("N-D21", "605Ah = 6 does not stay", (0x605A, 0), 6, 2),
        driven_for("N-D21", "605Ah = 2 brakes on the ramp of 1", (0x605A, 0), 2, 1),
        driven_for("N-D21", "605Ah = 5 brakes on the ramp of 6", (0x605A, 0), 5, 6),
        driven_for("N-D22", "605Bh = 1 brakes on no ramp", (0x605B, 0), 1, 0),
        driven_for("N-D23", "605Ch = 1 brakes on no ramp", (0x605C, 0), 1, 0),
        driven_for("N-D24", "605Dh = 2 brakes on the ramp of 1", (0x605D, 0), 2, 1),
        hears("N-D24", "halt is not taken back", |mind, frame| {
            if is_sdo(&frame) && mind.writes(0x6040, 0) {
                let halted = core::mem::replace(&mut mind.flag, mind.sdo[5] == 1);
                if halted && mind.sdo[4..6] == [0x0F, 0] {
                    mind.done();
                    return vec![];
                }
            }
            vec![frame]
        }),
        driven_for("N-D25", "605Eh = 2 brakes on the ramp of 1", (0x605E, 0), 2, 1),
        hears("N-D25", "a fault is left by shutdown", |mind, frame| {
            mind.flag |= is_nmt(&frame) && frame.octets() == [2, 5] && mind.mode == 3;
            let hit = is_sdo(&frame) && mind.writes(0x6040, 0) && core::mem::take(&mut mind.flag);
            vec![if hit { write(0x6040, 0, &[0x86, 0]) } else { frame }]
        }),
        driven_for("N-D26", "607Fh does not matter", (0x607F, 0), 500, 500_000),
        driven_for("N-D27", "6080h does not matter", (0x6080, 0), 30, 60),
        forgets_in(1, "N-D28", "607Dh:2 does not matter in pp", (0x607D, 2)),
        forgets_in(1, "N-D28", "607Dh:1 does not matter in pp", (0x607D, 1)),
        forgets_in(3, "N-D29", "607Dh does not matter in pv", (0x607D, 2)),
        forgets_in(1, "N-D30", "6065h does not matter", (0x6065, 0)),
        driven_for("N-D30", "6066h does not matter", (0x6066, 0), 60_000, 0),
        forgets_in(4, "N-D31", "6072h does not matter", (0x6072, 0)),
    ]
}

/// Those of a drive of CiA 402: `tests/eds/drive.eds`.
pub(crate) fn of_drives() -> Vec<Mistake> {
    let lss = hears("N-S00", "LSS is answered, which the data sheet does not offer", |mind, frame| {
        if frame.id() == base(0x7E5) && frame.octets().first() == Some(&0x5E) {
            mind.inject.push(data(0x7E4, &[0x5E, 5, 0, 0, 0, 0, 0, 0]));
        }
        vec![frame]
    });
    [states(), modes(), stops_and_limits(), vec![lss]].into_iter().flatten().collect()
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
