//! Mistakes, each with the row that must find it.

use std::time::Duration;

use profidrive::can_bus::can::Frame;

mod drives;
mod objects;
mod process_data;
mod requests;

pub(crate) use drives::{of_drives, that_end};

use super::wrong::{Hook, Mind, answer, answered, base, data, write};

pub(crate) struct Mistake {
    /// The row that must find it.
    pub(crate) row: &'static str,
    /// Others that it breaks, too, and why.
    pub(crate) also: &'static [(&'static str, &'static str)],
    pub(crate) what: &'static str,
    pub(crate) hear: Hook,
    pub(crate) say: Hook,
    pub(crate) every: Option<Duration>,
}

impl Mistake {
    /// It breaks other rows, too, each for a reason.
    fn also(self, also: &'static [(&'static str, &'static str)]) -> Self {
        Self { also, ..self }
    }
}

fn same(_: &mut Mind, frame: Frame) -> Vec<Frame> {
    vec![frame]
}

/// It hears something else than was sent.
fn hears(
    row: &'static str,
    what: &'static str,
    hear: impl FnMut(&mut Mind, Frame) -> Vec<Frame> + Send + 'static,
) -> Mistake {
    Mistake { row, also: &[], what, hear: Box::new(hear), say: Box::new(same), every: None }
}

/// It says something else than is right.
fn says(
    row: &'static str,
    what: &'static str,
    say: impl FnMut(&mut Mind, Frame) -> Vec<Frame> + Send + 'static,
) -> Mistake {
    Mistake { row, also: &[], what, hear: Box::new(same), say: Box::new(say), every: None }
}

/// Another answer to a read of this entry.
fn reads(row: &'static str, what: &'static str, at: (u16, u8), octets: &'static [u8]) -> Mistake {
    says(row, what, move |mind, frame| match answered(&frame) {
        Some(_) if mind.reads(at.0, at.1) => {
            let [a, b] = at.0.to_le_bytes();
            let mut all = [0x43 | (4 - octets.len() as u8) << 2, a, b, at.1, 0, 0, 0, 0];
            all[4..4 + octets.len()].copy_from_slice(octets);
            vec![answer(all)]
        }
        _ => vec![frame],
    })
}

/// A refusal of this entry becomes an acknowledgement.
fn takes(row: &'static str, what: &'static str, index: u16, sub: u8) -> Mistake {
    says(row, what, move |mind, frame| match answered(&frame) {
        Some([0x80, a, b, c, ..]) if mind.writes(index, sub) => vec![answer([0x60, a, b, c, 0, 0, 0, 0])],
        _ => vec![frame],
    })
}

/// A write of this entry is acknowledged and forgotten.
fn forgets(row: &'static str, what: &'static str, index: u16, sub: u8) -> Mistake {
    hears(row, what, move |mind, frame| {
        if is_sdo(&frame) && mind.writes(index, sub) {
            mind.done();
            return vec![];
        }
        vec![frame]
    })
}

/// The right signature is acknowledged, and nothing happens.
fn signed_for_nothing(row: &'static str, what: &'static str, index: u16, signature: [u8; 4]) -> Mistake {
    hears(row, what, move |mind, frame| {
        if is_sdo(&frame) && mind.writes(index, 1) && mind.sdo[4..] == signature {
            mind.done();
            return vec![];
        }
        vec![frame]
    })
}

/// A number is taken for another one.
fn taken_for(row: &'static str, what: &'static str, (index, sub): (u16, u8), from: i32, to: i32) -> Mistake {
    hears(row, what, move |mind, frame| {
        let is_it = is_sdo(&frame) && mind.writes(index, sub) && mind.sdo[0] & 1 == 1;
        let len = 4 - usize::from(mind.sdo[0] >> 2 & 3);
        let hit = is_it && mind.sdo[4..4 + len] == from.to_le_bytes()[..len];
        vec![if hit { write(index, sub, &to.to_le_bytes()[..len]) } else { frame }]
    })
}

/// A refusal of this entry with one of these codes becomes an acknowledgement.
fn takes_in_spite_of(
    row: &'static str,
    what: &'static str,
    (index, sub): (u16, u8),
    codes: &'static [u32],
) -> Mistake {
    says(row, what, move |mind, frame| match answered(&frame) {
        Some([0x80, a, b, c, d, e, f, g])
            if mind.writes(index, sub) && codes.contains(&u32::from_le_bytes([d, e, f, g])) =>
        {
            vec![answer([0x60, a, b, c, 0, 0, 0, 0])]
        }
        _ => vec![frame],
    })
}

/// Another code.
fn refuses(row: &'static str, what: &'static str, right: u32, wrong: u32) -> Mistake {
    says(row, what, move |_, frame| match answered(&frame) {
        Some([0x80, a, b, c, d, e, f, g]) if u32::from_le_bytes([d, e, f, g]) == right => {
            let [d, e, f, g] = wrong.to_le_bytes();
            vec![answer([0x80, a, b, c, d, e, f, g])]
        }
        _ => vec![frame],
    })
}

fn is_sdo(frame: &Frame) -> bool {
    frame.id() == base(0x605) && frame.octets().len() == 8
}

fn is_boot_up(frame: &Frame) -> bool {
    frame.id() == base(0x705) && frame.octets() == [0]
}

fn is_nmt(frame: &Frame) -> bool {
    frame.id() == base(0) && !frame.is_remote()
}

fn is_tpdo(frame: &Frame) -> bool {
    frame.id() == base(0x185) && !frame.is_remote()
}

const TPDO: [u8; 3] = [0, 0, 0];

/// Frames with this identifier are lost on the way in.
fn deaf(row: &'static str, what: &'static str, lost: impl Fn(&Frame) -> bool + Send + 'static) -> Mistake {
    hears(row, what, move |_, frame| if lost(&frame) { vec![] } else { vec![frame] })
}

/// Frames are lost on the way out.
fn mute(
    row: &'static str,
    what: &'static str,
    lost: impl Fn(&Mind, &Frame) -> bool + Send + 'static,
) -> Mistake {
    says(row, what, move |mind, frame| if lost(mind, &frame) { vec![] } else { vec![frame] })
}

/// A TPDO at a SYNC when it must not come.
fn tpdo_at_sync(
    row: &'static str,
    what: &'static str,
    when: impl Fn(&Mind) -> bool + Send + 'static,
) -> Mistake {
    hears(row, what, move |mind, frame| {
        if frame.id() == base(0x80) && when(mind) {
            mind.inject.push(data(0x185, &TPDO));
        }
        vec![frame]
    })
}

/// Those of a node of CiA 301: `tests/eds/complete.eds`.
pub(crate) fn of_nodes() -> Vec<Mistake> {
    [
        requests::network(),
        requests::requests(),
        requests::segments(),
        objects::objects(),
        objects::error_control(),
        process_data::process_data(),
        process_data::counter(),
        process_data::storage(),
    ]
    .into_iter()
    .flatten()
    .collect()
}
