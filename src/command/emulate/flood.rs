//! Test: a minute of everything wrong at once at five slaves, or at five nodes, is at most 140 lines of the log: 120 complaints at
//! most (`host::tests::silence::flood`), and what the drives do meanwhile.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::io;
use std::sync::{Arc, Mutex};

use tracing_subscriber::fmt::MakeWriter;

use super::News;
use super::lines::Start;
use super::nodes::Nodes;
use crate::host::Bus;
use crate::host::can::{LinkSpec, Seat};
use crate::host::tests::silence::flood;
use crate::profibus::fdl::Timing;
use crate::time::BaudRate;

/// Lines of five devices in a minute.
const MOST: usize = 140;

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
