//! `status` and `monitor`: what the drive says of itself.

use core::time::Duration;
use std::io::{self, IsTerminal, Write};

use crate::client::{Findings, Why};
use crate::devices::ag03::drive::Mode;
use crate::devices::ag03::param::{Model, Parameter, Reading, Subindex};
use crate::devices::ag03::profibus::bits::{Role, SswBit, Word, ZswBit, bits};
use crate::explain::value::Lengths;
use crate::explain::words::said;
use crate::host::{Clock, Link};
use crate::master::{Drive, DriveError, Seen};
use serde_json::json;

use super::value::lengths;
use crate::command::Failure;
use crate::command::master::say;
use crate::command::master::trouble::Trouble;

/// How often a live line is written at most.
const LIVE: Duration = Duration::from_millis(100);

/// The words of bits, and what counts in them.
struct Words {
    model: Model,
    mode: Mode,
    lengths: Lengths,
    /// What this master sends.
    stw: u16,
    seen: Seen,
    ssw: u16,
    general: u16,
    why: Why,
}

impl Words {
    fn read<L: Link, C: Clock>(drive: &mut Drive<L, C>) -> Result<Self, Trouble> {
        let mode = mode(drive)?;
        let lengths = lengths(drive)?;
        let model = drive.model()?;
        let ssw = read_word(drive, Reading::SystemStatus)?;
        let general = read_word(drive, Reading::GeneralStatus)?;
        let seen = drive.exchange()?;
        let fault = ZswBit::Fault.is_set(seen.zsw).then(|| newest_fault(drive)).transpose()?;
        let findings = Findings {
            zsw: Some(seen.zsw),
            ssw: Some(ssw),
            general_status: Some(general),
            mode: Some(mode),
            fault_code: fault,
            ..Findings::default()
        };
        Ok(Self { model, mode, lengths, stw: drive.stw().raw(), seen, ssw, general, why: findings.why() })
    }

    /// Every word with its heading and its 16 bits.
    fn all(&self) -> [(Word, &'static str, u16); 4] {
        [
            (Word::Stw, "control word, as this master sends it", self.stw),
            (Word::Zsw, "status word", self.seen.zsw.raw()),
            (Word::Ssw, "system status word, PNU 1020", self.ssw),
            (Word::GeneralStatus, "general status register, PNU 1031", self.general),
        ]
    }

    fn json(&self) -> serde_json::Value {
        let mut words = serde_json::Map::new();
        for (word, _, raw) in self.all() {
            let used = (0..)
                .zip(bits(word, self.mode, Some(self.model)))
                .filter(|(_, bit)| bit.role != Role::Unused);
            let bits = used.map(|(n, bit)| (bit.key.to_owned(), is_set(raw, n).into()));
            let bits: serde_json::Map<_, _> = bits.collect();
            words.insert(word.name().to_lowercase(), json!({ "word": raw, "bits": bits }));
        }
        words.insert("mode".into(), mode_name(self.mode).into());
        words.insert(actual_name(self.mode).into(), self.seen.hiw.into());
        let why = self.why;
        let hindrances: Vec<_> = why.iter().map(|obstacle| why.text(obstacle).to_string()).collect();
        let next = why.next().map(|next| next.to_string());
        words.insert("why".into(), json!({ "hindrances": hindrances, "next": next }));
        words.insert("text".into(), said(self.mode, self.seen.zsw.raw(), self.seen.zsw.raw()).into());
        words.into()
    }
}

/// Whether the shaft turns.
pub(super) fn travels<L: Link, C: Clock>(drive: &mut Drive<L, C>) -> Result<bool, DriveError> {
    Ok(SswBit::Travels.is_set(read_word(drive, Reading::SystemStatus)?))
}

fn read_word<L: Link, C: Clock>(drive: &mut Drive<L, C>, reading: Reading) -> Result<u16, DriveError> {
    let entry = reading.entry();
    Ok(u16::try_from(drive.read(entry.pnu, None, entry.width)?.bits()).unwrap_or_default())
}

/// PNU 945, element 0.
fn newest_fault<L: Link, C: Clock>(drive: &mut Drive<L, C>) -> Result<u8, DriveError> {
    let entry = Reading::FaultBuffer.entry();
    let code = drive.read(entry.pnu, Some(Subindex(0)), entry.width)?.bits();
    Ok(u8::try_from(code).unwrap_or_default())
}

/// Which mode the drive is in.
pub(super) fn mode<L: Link, C: Clock>(drive: &mut Drive<L, C>) -> Result<Mode, Trouble> {
    let mode = Parameter::OperatingMode.entry();
    let velocity = drive.read(mode.pnu, None, mode.width)?.bits() == u32::from(Mode::Velocity.number());
    Ok(if velocity { Mode::Velocity } else { Mode::Positioning })
}

/// ZSW, SSW and general status register, bit by bit.
pub(super) fn status<L: Link, C: Clock>(drive: &mut Drive<L, C>, json: bool) -> Result<(), Failure> {
    let words = Words::read(drive)?;
    if json {
        return say(words.json());
    }
    let zsw = words.seen.zsw.raw();
    let actual = actual(words.mode, words.lengths, words.seen.hiw);
    say(format_args!("{}: {}; {actual}", mode_name(words.mode), said(words.mode, zsw, zsw)))?;
    let why = words.why;
    for obstacle in why.iter() {
        say(format_args!("does not move: {}", why.text(obstacle)))?;
    }
    if let Some(next) = why.next() {
        say(format_args!("next: {next}"))?;
    }
    for (word, heading, raw) in words.all() {
        say(format_args!("\n{} {raw:04X}  {heading}", word.name()))?;
        for (n, bit) in
            (0..).zip(bits(word, words.mode, Some(words.model))).filter(|(_, bit)| bit.role != Role::Unused)
        {
            let set = is_set(raw, n);
            let note = if bit.note.is_empty() { String::new() } else { format!("  ({})", bit.note) };
            say(format_args!("  {n:>2}  {}  {}{note}", u8::from(set), bit.meaning(set)))?;
        }
    }
    Ok(())
}

fn is_set(word: u16, bit: u8) -> bool {
    word >> bit & 1 != 0
}

fn mode_name(mode: Mode) -> &'static str {
    match mode {
        Mode::Positioning => "positioning mode",
        Mode::Velocity => "velocity mode",
    }
}

fn actual_name(mode: Mode) -> &'static str {
    match mode {
        Mode::Positioning => "position",
        Mode::Velocity => "velocity",
    }
}

/// The actual value in words.
pub(super) fn actual(mode: Mode, lengths: Lengths, hiw: i32) -> String {
    match mode {
        Mode::Positioning => format!("position {}", lengths.position(hiw.into())),
        Mode::Velocity => format!("velocity {hiw} rpm"),
    }
}

/// Shows what changes until Ctrl-C.
pub(super) fn monitor<L: Link, C: Clock>(
    drive: &mut Drive<L, C>,
    limit: Option<Duration>,
    json: bool,
) -> Result<(), Failure> {
    let (mode, lengths) = (mode(drive)?, lengths(drive)?);
    let live = !json && io::stdout().is_terminal();
    let begun = drive.session.now();
    let mut shown: Option<(Seen, Duration)> = None;
    let outcome = loop {
        if drive.is_stopped() {
            break Ok(());
        }
        let since = drive.session.now().saturating_since(begun);
        if limit.is_some_and(|limit| since >= limit) {
            break Ok(());
        }
        let seen = match drive.exchange() {
            Ok(seen) => seen,
            Err(error) => break Err(error.into()),
        };
        let due = shown.is_none_or(|(before, at)| {
            before != seen && (!live || before.zsw != seen.zsw || since.saturating_sub(at) >= LIVE)
        });
        if due {
            let before = shown.map_or(seen, |(before, _)| before);
            shown = Some((seen, since));
            line(before, seen, since, (mode, lengths), live, json)?;
        }
    };
    if live {
        say("")?;
    }
    outcome
}

/// One line of the monitor; a live one is written over the one before.
fn line(
    before: Seen,
    seen: Seen,
    since: Duration,
    (mode, lengths): (Mode, Lengths),
    live: bool,
    json: bool,
) -> Result<(), Failure> {
    let words = said(mode, before.zsw.raw(), seen.zsw.raw());
    let seconds = since.as_secs_f64();
    if json {
        return say(json!({
            "time": seconds,
            "zsw": seen.zsw.raw(),
            actual_name(mode): seen.hiw,
            "text": words,
        }));
    }
    let text = format!("{seconds:>9.3}  {}  {}  {words}", seen.zsw, actual(mode, lengths, seen.hiw));
    if !live {
        return say(text);
    }
    let mut stdout = io::stdout().lock();
    // Nobody is left to tell if the terminal has gone.
    let _ = write!(stdout, "\r\x1b[K{text}").and_then(|()| stdout.flush());
    Ok(())
}
