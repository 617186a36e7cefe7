//! Whoever follows what `why` says makes the drive move.

use core::time::Duration;

use super::slaves::{Line, MASTER};
use super::words::Kind;
use crate::profibus::dp;

/// What was found, and an example.
type Found = Result<(), (String, String)>;

fn why(line: &Line) -> Option<(Option<bool>, Vec<String>, String)> {
    let why = line.bus.why(Line::slave())?;
    let mut reasons = Vec::new();
    why.each_reason(&mut |reason| reasons.push(format!("{}: {reason}", reason.name)));
    Some((why.is_moving(), reasons, why.to_string()))
}

fn story(line: &Line, rest: &str) -> String {
    let from = line.story.len().saturating_sub(24);
    format!("{}\n{rest}", line.story[from..].join("\n"))
}

/// A drive that stands has a reason, or something to be sent.
pub(super) fn names_a_reason(line: &mut Line) -> Found {
    let Some((moves, reasons, text)) = why(line) else { return Ok(()) };
    if moves == Some(true) || !reasons.is_empty() || text.contains("next: ") {
        return Ok(());
    }
    // It is about to move.
    for _ in 0..30 {
        if line.state() == Some(dp::State::DataExch) {
            line.exchange(1);
        } else {
            line.wait(Duration::from_millis(10));
        }
        match why(line) {
            Some((Some(false) | None, ..)) => {}
            _ => return Ok(()),
        }
    }
    Err((format!("why: {text}"), story(line, "")))
}

/// Follows the advice, from whatever state it is in.
pub(super) fn makes_it_move(line: &mut Line) -> Found {
    if why(line).is_none() {
        return Ok(());
    }
    let mut trail = Vec::new();
    let begun = line.story.len();
    for _ in 0..14 {
        if line.story[begun..].iter().any(|told| told.contains("travel to") && told.contains("started")) {
            return Ok(());
        }
        let Some((moves, reasons, text)) = why(line) else { return Ok(()) };
        if moves == Some(true) {
            return Ok(());
        }
        trail.push(format!("  {text}"));
        if !follow(line, &reasons.join("; "), &text) {
            break;
        }
    }
    let last = trail.last().cloned().unwrap_or_default();
    let what: String = last.chars().map(|c| if c.is_ascii_digit() { '0' } else { c }).collect();
    Err((format!("advice does not make it move: {what}"), story(line, &trail.join("\n"))))
}

/// Does what the reasons say; whether there was anything to do.
fn follow(line: &mut Line, reasons: &str, text: &str) -> bool {
    let says = |words: &str| text.contains(words);
    let mut done = false;
    if says("switched off") {
        line.act(|device, now| device.switch_supply(now, true));
        done = true;
    }
    for outside in [
        "remove it",
        "remove its cause",
        "switch it on",
        "release it",
        "is blocked",
        "supply",
        "inputs of the drive",
    ] {
        if says(outside) {
            line.act(|device, now| device.make_nominal(now));
            done = true;
        }
    }
    let other = line.owner().filter(|owner| *owner != MASTER);
    if reasons.contains("NoDataExchange") || other.is_some() {
        if let Some(other) = other {
            let unlock = [&[0x40], &line.prm()[1..]].concat();
            line.ask(other, dp::Service::SetPrm, &unlock);
        }
        done |= line.start_up();
    }
    for (words, command) in [("Unsync", 0x10), ("Unfreeze", 0x04)] {
        if says(words) {
            line.control(MASTER, &[command, 0]);
            done = true;
        }
    }
    match line.target.kind {
        Kind::Ag03 => done |= follow_positions(line, text),
        Kind::Ppo => done |= follow_bits(line, text, 8),
        Kind::Profidrive => done |= follow_bits(line, text, 0),
        Kind::Station => {}
    }
    done
}

/// Words behind `next:` are sent, one after the other; setpoints are given where they are asked for.
fn follow_positions(line: &mut Line, text: &str) -> bool {
    let mut done = false;
    if text.contains("give a setpoint from")
        || text.contains("setpoint is 0")
        || text.contains("is at its setpoint")
    {
        let setpoint: i32 = match () {
            () if text.contains("is at its setpoint") => 1000,
            () if text.contains("give a setpoint from") => 200,
            () => 60 << 16,
        };
        line.outputs[10..14].copy_from_slice(&setpoint.to_be_bytes());
        done = true;
    }
    if text.contains("wait") || text.contains("turns") {
        line.exchange(100);
        done = true;
    }
    let Some((_, next)) = text.split_once("next: send STW ") else {
        if done {
            line.exchange(12);
        }
        return done;
    };
    for word in next.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| word.len() == 4) {
        let Ok(word) = u16::from_str_radix(word, 16) else { continue };
        line.outputs[8..10].copy_from_slice(&word.to_be_bytes());
        line.exchange(8);
        done = true;
    }
    done
}

/// `set STW bit 4`, `STW bit 0 = 0`.
fn follow_bits(line: &mut Line, text: &str, at: usize) -> bool {
    let mut word = u16::from_be_bytes([line.outputs[at], line.outputs[at + 1]]);
    let before = word;
    let mut done = false;
    if text.contains("from 0 to 1") {
        for bit in [0, 0x80] {
            word = word & !0x80 | bit | 0x400;
            line.outputs[at..at + 2].copy_from_slice(&word.to_be_bytes());
            line.exchange(8);
        }
        word &= !0x80;
        done = true;
    }
    if text.contains("give OFF1 once") {
        word = word & !1 | 6;
        done = true;
    }
    for (place, _) in text.match_indices("set STW") {
        let rest = &text[place..];
        let number: String = rest
            .split_once("bit ")
            .map(|(_, rest)| rest.chars().take_while(char::is_ascii_digit).collect())
            .unwrap_or_default();
        if let Ok(number) = number.parse::<u8>()
            && !(number == 0 && text.contains("give OFF1 once"))
        {
            word |= 1 << number;
        }
    }
    line.outputs[at..at + 2].copy_from_slice(&word.to_be_bytes());
    done |= word != before;
    if text.contains("is 0") && text.contains("send another") {
        line.outputs[at + 2..at + 4].copy_from_slice(&0x1000_u16.to_be_bytes());
        done = true;
    }
    line.exchange(12);
    done
}
