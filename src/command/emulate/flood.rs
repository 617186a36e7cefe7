//! Test: a minute of everything wrong at once at five slaves, or at five nodes, is at most 120 lines of the log: complaints, and
//! what the drives do meanwhile.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::io;
use std::sync::{Arc, Mutex};

use tracing_subscriber::fmt::MakeWriter;

use super::News;
use super::lines::Start;
use super::nodes::Nodes;
use crate::host::Bus;
use crate::host::can::{LinkSpec, Seat};
use crate::host::tests::silence::{deeds, flood};
use crate::profibus::fdl::Timing;
use crate::time::BaudRate;

/// Lines of five devices in a minute.
const MOST: usize = 120;

/// Where the log is written.
#[derive(Clone, Default)]
struct Written(Arc<Mutex<Vec<u8>>>);

impl io::Write for Written {
    fn write(&mut self, octets: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap().extend(octets);
        Ok(octets.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl MakeWriter<'_> for Written {
    type Writer = Self;

    fn make_writer(&self) -> Self {
        self.clone()
    }
}

/// The lines of the log at its default level.
fn logged(act: impl FnOnce()) -> Vec<String> {
    let written = Written::default();
    let subscriber = tracing_subscriber::fmt()
        .with_writer(written.clone())
        .with_max_level(tracing::Level::INFO)
        .with_target(false)
        .with_ansi(false)
        .finish();
    tracing::subscriber::with_default(subscriber, act);
    let octets = written.0.lock().unwrap().clone();
    String::from_utf8(octets).unwrap().lines().map(str::to_owned).collect()
}

fn expect_few(lines: &[String]) {
    assert!(!lines.is_empty() && lines.len() <= MOST, "{} lines:\n{}", lines.len(), lines.join("\n"));
}

/// Notes where a person reads more of a thing that he did, or a complaint.
fn expect_no_more(deed: &str, most: usize, lines: &[String], read: &mut Vec<String>) {
    let complains =
        |line: &String| ["refused", "ignored", "hint", "no effect"].iter().any(|word| line.contains(word));
    if lines.len() > most || lines.iter().any(complains) {
        read.push(format!("{} lines, {deed}:\n  {}", lines.len(), lines.join("\n  ")));
    }
}

#[test]
fn what_a_person_does_with_a_correct_master_is_a_line_for_each_state_that_comes_of_it() {
    let mut read = Vec::new();
    let bus = Bus::on(BaudRate::K500, Timing::Untrue);
    let start = Start::alone();
    deeds::at_slaves(&mut |deed, most, events| {
        let mut news = News::new("link".into(), &bus, false, None, Vec::new(), &start);
        let lines = logged(|| events.into_iter().for_each(|(now, event)| news.say(now, event, None)));
        expect_no_more(&deed, most, &lines, &mut read);
    });
    deeds::at_nodes(&mut |deed, most, events| {
        let mut nodes = Nodes::of(&LinkSpec::Tcp(String::new()));
        let lines = logged(|| {
            events.iter().for_each(|(now, event)| nodes.say_of_node(*now, Seat::NOBODY, event));
        });
        expect_no_more(&deed, most, &lines, &mut read);
    });
    assert!(read.is_empty(), "{} things:\n{}", read.len(), read.join("\n"));
}

#[test]
fn a_minute_of_everything_wrong_at_five_slaves_is_a_few_lines() {
    expect_few(&logged(|| {
        let bus = Bus::on(BaudRate::K500, Timing::Untrue);
        let start = Start::alone();
        let mut news = News::new("link".into(), &bus, false, None, Vec::new(), &start);
        flood::minute_of_slaves(&mut |now, event| news.say(now, event, None));
        news.moving.end();
    }));
}

#[test]
fn a_minute_of_everything_wrong_at_five_nodes_is_a_few_lines() {
    expect_few(&logged(|| {
        let mut nodes = Nodes::of(&LinkSpec::Tcp(String::new()));
        flood::minute_of_nodes(&mut |now, event| nodes.say_of_node(now, Seat::NOBODY, &event));
        nodes.moving.end();
    }));
}
