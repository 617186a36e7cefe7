//! A minute of everything wrong at once, at five slaves and at five nodes, is at most 120 lines. The command has the same test with
//! its log.

use core::time::Duration;

use super::slaves::{self, Line};
use super::{nodes, words};
use crate::chance::Random;
use crate::devices::CanopenEvent;
use crate::host::BusEvent;
use crate::profibus::dp::Service;
use crate::time::Instant;

const MINUTE: Duration = Duration::from_secs(60);
/// A minute goes by without anything behind it, so that what was counted is told.
const END: Duration = Duration::from_secs(5);

/// A slave of each kind, each with a master that makes every mistake in turn.
pub(crate) fn minute_of_slaves(tell: &mut dyn FnMut(Instant, BusEvent)) {
    let lines = slaves::TARGETS.iter().map(|target| {
        let mut line = Line::of(target);
        assert!(line.start_up(), "{}", target.name);
        line.events.clear();
        (line, Random::new(7))
    });
    let mut lines: Vec<_> = lines.collect();
    for cycle in 0_u32.. {
        if lines.iter().all(|(line, _)| line.now.saturating_since(Instant::ZERO) > MINUTE) {
            break;
        }
        for (place, (line, random)) in lines.iter_mut().enumerate() {
            let target = line.target;
            if cycle % 4 == 0 {
                words::change(&mut line.outputs, target.kind, random);
            }
            line.exchange(1);
            match cycle % 10 {
                1 => _ = line.ask(slaves::OTHER, Service::ChkCfg, target.cfg),
                2 => _ = line.ask(slaves::OTHER, Service::SetPrm, &line.prm()),
                3 => line.control(slaves::MASTER, &[0x60, 0]),
                4 => _ = line.ask(slaves::MASTER, Service::RdInp, &[1]),
                5 => line.noise(),
                _ => {}
            }
            // Five slaves are on one line: what is said of the line is said once.
            let of_line = |event: &BusEvent| place > 0 && matches!(event, BusEvent::Hint(_));
            line.events
                .drain(..)
                .filter(|(_, event)| !of_line(event))
                .for_each(|(at, event)| tell(at, event));
        }
    }
    for (line, _) in &mut lines {
        line.wait(END);
        line.events.drain(..).for_each(|(at, event)| tell(at, event));
    }
}

/// A node of each kind, and the same.
pub(crate) fn minute_of_nodes(tell: &mut dyn FnMut(Instant, CanopenEvent)) {
    let of = |target| {
        let mut bus = nodes::Bus::of(target);
        bus.nmt(1);
        (bus, Random::new(7))
    };
    let mut buses: Vec<_> = nodes::TARGETS.iter().take(5).map(of).collect();
    for cycle in 0_u32.. {
        if buses.iter().all(|(bus, _)| bus.now.saturating_since(Instant::ZERO) > MINUTE) {
            break;
        }
        for (bus, random) in &mut buses {
            match cycle % 6 {
                0 => _ = bus.write(0x6040, 0, [0x0F, 0x1F, 0x07][cycle as usize / 6 % 3], 2),
                1 => _ = bus.write(0x6060, 0, 99, 1),
                2 => _ = bus.sdo(&[0x40, random.octet(), 0x5F, 0, 0, 0, 0, 0]),
                3 => _ = bus.send(&nodes::frame(0x205, &[random.octet()])),
                4 => _ = bus.send(&nodes::frame(0, &[7, 5])),
                _ => _ = bus.write(0x607A, 0, i64::from(random.octet()), 4),
            }
            bus.wait(Duration::from_millis(7));
            bus.events.drain(..).for_each(|(at, event)| tell(at, event));
        }
    }
    for (bus, _) in &mut buses {
        bus.wait(END);
        bus.events.drain(..).for_each(|(at, event)| tell(at, event));
    }
}

/// Lines of five devices in a minute.
const MOST: usize = 120;

/// Fails if a person reads too much, but for motion and noise, which the log counts by itself.
fn expect_few(news: &[String]) {
    let counted_by_the_log = [
        "ignored octets",
        "operation enabled",
        "operation disabled",
        "travel to",
        "travel paused",
        "inching",
        "state:",
        "drive state",
        "the shaft stands",
        "turning with",
    ];
    let complains = |text: &str| text.contains("refused") || text.contains("no effect");
    let is_read =
        |text: &&String| complains(text) || !counted_by_the_log.iter().any(|words| text.contains(words));
    let read: Vec<_> = news.iter().filter(is_read).collect();
    assert!(!read.is_empty() && read.len() <= MOST, "{} lines: {read:#?}", read.len());
}

#[test]
fn a_minute_of_everything_wrong_at_five_slaves_is_a_few_lines() {
    let mut news = Vec::new();
    minute_of_slaves(&mut |_, event| news.extend((!event.is_detail()).then(|| event.to_string())));
    expect_few(&news);
}

#[test]
fn a_minute_of_everything_wrong_at_five_nodes_is_a_few_lines() {
    let mut news = Vec::new();
    minute_of_nodes(&mut |_, event| news.extend((!event.is_detail()).then(|| event.to_string())));
    expect_few(&news);
}
