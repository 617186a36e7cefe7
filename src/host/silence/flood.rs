//! A minute of everything wrong at once is at most 120 lines.

use core::time::Duration;

use super::slaves::{Line, TARGETS};
use super::{nodes, words};
use crate::chance::Random;
use crate::profibus::dp::Service;

/// Lines of five drives or nodes in a minute.
const MOST: usize = 120;
/// Of each of them.
const EACH: usize = MOST / 5;

/// What a person reads but for motion, which the log counts by itself.
fn read(news: &[String]) -> Vec<&String> {
    let motion = [
        "operation enabled",
        "operation disabled",
        "travel to",
        "state:",
        "drive state",
        "the shaft stands",
        "turning with",
    ];
    let complains = |text: &str| text.contains("refused") || text.contains("no effect");
    news.iter().filter(|text| complains(text) || !motion.iter().any(|words| text.contains(words))).collect()
}

#[test]
fn a_minute_of_everything_wrong_at_a_slave_is_a_few_lines() {
    for target in TARGETS {
        let mut line = Line::of(target);
        assert!(line.start_up(), "{}", target.name);
        line.take_news();
        let mut random = Random::new(7);
        let mut lines = Vec::new();
        for cycle in 0..6000_u32 {
            if cycle % 400 < 8 {
                words::change(&mut line.outputs, target.kind, &mut random);
            }
            line.exchange(1);
            match cycle % 10 {
                1 => _ = line.ask(3, Service::ChkCfg, target.cfg),
                2 => _ = line.ask(3, Service::SetPrm, &line.prm()),
                3 => line.control(2, &[0x60, 0]),
                4 => _ = line.ask(2, Service::RdInp, &[1]),
                5 => line.noise(),
                _ => {}
            }
            lines.extend(line.take_news());
        }
        line.wait(Duration::from_secs(5));
        lines.extend(line.take_news());
        let told = read(&lines);
        assert!(
            told.len() <= EACH,
            "{}: {} lines: {:#?}",
            target.name,
            told.len(),
            &told[..told.len().min(60)]
        );
    }
}

#[test]
fn a_minute_of_everything_wrong_at_a_node_is_a_few_lines() {
    for target in nodes::TARGETS {
        let mut bus = nodes::Bus::of(target);
        bus.nmt(1);
        bus.take_news();
        let mut random = Random::new(7);
        let mut lines = Vec::new();
        for cycle in 0..6000_u32 {
            match cycle % 6 {
                0 => _ = bus.write(0x6040, 0, [0x0F, 0x1F, 0x07][cycle as usize / 6 % 3], 2),
                1 => _ = bus.write(0x6060, 0, 99, 1),
                2 => _ = bus.sdo(&[0x40, random.octet(), 0x5F, 0, 0, 0, 0, 0]),
                3 => _ = bus.send(&nodes::frame(0x205, &[random.octet()])),
                4 => _ = bus.send(&nodes::frame(0, &[7, 5])),
                _ => _ = bus.write(0x607A, 0, i64::from(random.octet()), 4),
            }
            bus.wait(Duration::from_millis(7));
            lines.extend(bus.take_news());
        }
        bus.wait(Duration::from_secs(5));
        lines.extend(bus.take_news());
        let told = read(&lines);
        assert!(
            told.len() <= EACH,
            "{}: {} lines: {:#?}",
            target.name,
            told.len(),
            &told[..told.len().min(60)]
        );
    }
}
