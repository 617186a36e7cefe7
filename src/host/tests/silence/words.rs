//! What the words of a master ask a drive for, and whether it got that.

use super::slaves::Line;
use crate::chance::Random;
use crate::face::Description;

/// How outputs are laid out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Ag03,
    Ppo,
    Profidrive,
    Station,
}

impl Kind {
    /// Where the control word is; the setpoint is behind it.
    pub(super) const fn stw(self) -> Option<usize> {
        match self {
            Self::Ag03 | Self::Ppo => Some(8),
            Self::Profidrive => Some(0),
            Self::Station => None,
        }
    }

    const fn has_pkw(self) -> bool {
        matches!(self, Self::Ag03 | Self::Ppo)
    }
}

/// What is seen of a device, without what changes by itself.
pub(super) fn state(device: Option<&dyn Description>) -> String {
    let Some(device) = device else { return String::new() };
    let mut look = format!("{:?} {:?} ", device.supply(), device.drive_state());
    device.say_state(&mut |state| look += &state.to_string());
    device.tell_fault(&mut |code, _| look += &format!(" {code}"));
    look
}

/// Outputs, inputs and the drive at one moment.
pub(super) struct Seen {
    stw: u16,
    setpoint: i32,
    job: [u8; 8],
    reply: [u8; 8],
    zsw: u16,
    actual: Vec<u8>,
    positions: bool,
    moves: bool,
    pub(super) state: String,
}

impl Seen {
    pub(super) fn of(line: &Line) -> Self {
        let kind = line.target.kind;
        let word = |octets: &[u8], at: usize| {
            octets.get(at..at + 2).map_or(0, |two| u16::from_be_bytes([two[0], two[1]]))
        };
        let at = kind.stw().unwrap_or_default();
        let setpoint = match line.outputs.get(at + 2..at + 6) {
            Some(four) if kind == Kind::Ag03 => i32::from_be_bytes(four.try_into().unwrap()),
            _ => word(&line.outputs, at + 2).cast_signed().into(),
        };
        let eight =
            |octets: &[u8]| octets.first_chunk().copied().filter(|_| kind.has_pkw()).unwrap_or_default();
        let mut seen = Self {
            stw: word(&line.outputs, at),
            setpoint,
            job: eight(&line.outputs),
            reply: eight(&line.inputs),
            zsw: word(&line.inputs, at),
            actual: line.inputs.get(at + 2..).unwrap_or_default().to_vec(),
            positions: false,
            moves: line.bus.why(Line::slave()).is_some_and(|why| why.is_moving() == Some(true)),
            state: String::new(),
        };
        if let Some(device) = line.description() {
            device.say_state(&mut |state| seen.state += &state.to_string());
            device.tell_fault(&mut |code, _| seen.state += &format!(", fault {code}"));
            device.each_meaning(&mut |number, value| seen.positions |= number == 930 && value == Some(2));
            seen.state += if kind != Kind::Ag03 {
                ""
            } else if seen.positions {
                " (positions)"
            } else {
                " (velocity)"
            };
        }
        seen
    }

    fn has_fault(&self) -> bool {
        self.zsw & 8 != 0
    }
}

/// The names of what keeps the device from moving.
pub(super) fn reasons(line: &Line) -> Vec<&'static str> {
    let mut names = Vec::new();
    if let Some(why) = line.bus.why(Line::slave()) {
        why.each_reason(&mut |reason| names.push(reason.name));
    }
    names
}

/// Another word, setpoint or job.
pub(super) fn change(outputs: &mut [u8], kind: Kind, random: &mut Random) {
    let Some(at) = kind.stw() else {
        outputs.iter_mut().for_each(|octet| *octet = random.octet());
        return;
    };
    let pick = |random: &mut Random, of: &[u16]| of[random.below(of.len())];
    let before = u16::from_be_bytes([outputs[at], outputs[at + 1]]);
    let bit = 1 << random.below(16);
    let word = match (kind, random.below(4)) {
        (_, 0) => before ^ bit,
        (Kind::Ag03, _) => pick(
            random,
            &[
                0, 0x3A, 0x3B, 0x7B, 0x3B, 0x7B, 0x0B, 0x4B, 0xBB, 0x3A, 0x13B, 0x23B, 0x33B, 0x2B, 0x1B,
                0x3B00, 0x47E, 0x47F, 0x43F,
            ],
        ),
        (_, 1) => {
            pick(random, &[0x7E04, 0x7F04, 0x7F, 0x7E, 0x43E, 0x43F, 0x53F, 0x63F, 0x47B, 0x477, 0x40F])
        }
        _ => pick(random, &[0, 0x400, 0x47E, 0x47F, 0x47E, 0x47F, 0x47F, 0x4FE, 0x46F, 0x45F, 0x43F]),
    };
    outputs[at..at + 2].copy_from_slice(&word.to_be_bytes());
    if kind == Kind::Ag03 && random.below(2) == 0 {
        let setpoints = [0, 100, 20_000, -20_000, 5_000_000, 0x003C_0000, -0x003C_0000, 0x012C_0000];
        let setpoint: i32 = setpoints[random.below(setpoints.len())];
        outputs[at + 2..at + 6].copy_from_slice(&setpoint.to_be_bytes());
    } else if kind != Kind::Ag03 && random.below(2) == 0 {
        let setpoint = pick(random, &[0, 0x1000, 0x4000, 0xC000, 0x7FFF]);
        outputs[at + 2..at + 4].copy_from_slice(&setpoint.to_be_bytes());
    }
    if kind.has_pkw() && random.below(3) == 0 {
        let (mode, pnu) =
            (pick(random, &[930, 930, 1004, 1012, 1016, 1029, 945, 1, 999, 918, 970, 1040]), random.below(8));
        let pnu = if pnu == 0 { u16::from(random.octet()) << 3 } else { mode };
        let job = pick(random, &[0, 1, 1, 2, 2, 3, 3, 4, 6, 7, 9, 11, 13]);
        let value = pick(random, &[0, 1, 2, 2, 50, 5000, 0xFFFF]);
        let pke = job << 12 | pnu & 0x7FF;
        outputs[..2].copy_from_slice(&pke.to_be_bytes());
        outputs[2..6].fill(0);
        outputs[6..8].copy_from_slice(&value.to_be_bytes());
        if random.below(6) == 0 {
            outputs[2] = random.octet();
        }
    }
}

/// What the outputs of `after` ask for that those of `before` did not, and whether it came.
pub(super) fn wants(kind: Kind, before: &Seen, after: &Seen) -> Vec<(String, bool)> {
    let mut wants = Vec::new();
    let mut want = |asked: bool, what: &str, met: bool| {
        if asked {
            wants.push((what.to_owned(), met));
        }
    };
    let rises = |bit: u16| after.stw & !before.stw & bit != 0;
    let moved = after.moves || after.actual != before.actual;
    let word_changed = after.stw != before.stw;
    let changed = word_changed || after.setpoint != before.setpoint;
    let all = |word: u16, bits: u16| word & bits == bits;
    want(rises(0x80) && before.has_fault(), "acknowledge", !after.has_fault());
    want(rises(0x80) && !before.has_fault() && after.stw & 1 == 0, "acknowledge without a fault", true);
    match kind {
        Kind::Ag03 => {
            want(all(after.stw, 0x0B) && !all(before.stw, 0x0B), "enable", after.zsw & 4 != 0);
            let starts = (after.stw ^ before.stw) & 0x40 != 0 && all(after.stw, 0x0B);
            want(starts && after.positions, "start", moved);
            let turns = all(after.stw, 0x4B) && !after.positions && after.setpoint >> 16 != 0;
            want(turns && changed, "turn", moved);
            want(rises(0x100) && after.stw & 0x200 == 0, "inching 1", moved);
            want(rises(0x200), "inching 2", moved);
        }
        Kind::Ppo | Kind::Profidrive => {
            let lacks = word_changed && after.stw & 0x400 == 0 && (after.stw != 0 || after.zsw & 4 != 0);
            want(lacks, "a word without control by PLC", false);
            want(all(after.stw, 0x40F) && !all(before.stw, 0x40F), "enable", after.zsw & 4 != 0);
            let operates = after.zsw & 4 != 0;
            want(operates && all(after.stw, 0x47F) && after.setpoint != 0 && changed, "turn", moved);
            let inches = rises(0x300) && before.stw & 0x300 == 0 && after.stw & 0x400 != 0;
            want(inches, "inching", moved);
        }
        Kind::Station => {}
    }
    if kind.has_pkw() && after.job != before.job && after.job[0] >> 4 != 0 {
        let (job, answer) = (after.job[0] >> 4, after.reply[0] >> 4);
        want(true, &format!("job {job}, answer {answer}"), answer != 0 && answer != 7);
    }
    wants
}
