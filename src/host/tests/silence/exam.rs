//! A hundred and twenty mistakes that no other test has, and what a person has to read of each: the cause, where it shows,
//! what was expected, what to do.

use core::time::Duration;

use super::nodes::{self, Bus};
use super::slaves::{self, Line};

mod bus;
mod line;
mod records;
mod transfers;

pub(super) use bus::enable as enable_node;
use bus::{ON_BUS, OnBus};
use line::{ON_LINE, OnLine};
pub(super) use line::{job, word};
use records::RECORDS;
use transfers::TRANSFERS;

/// What was read of each mistake.
#[derive(Default)]
struct Exam {
    table: String,
    asked: usize,
    failed: usize,
}

impl Exam {
    fn note(&mut self, target: &str, what: &str, words: &[&str], read: &[String]) {
        let all = read.join("\n");
        let missing: Vec<_> = words.iter().filter(|word| !all.contains(**word)).collect();
        self.asked += 1;
        self.failed += usize::from(!missing.is_empty());
        let score = if missing.is_empty() { "2".to_owned() } else { format!("lacks {missing:?}") };
        self.table += &format!("{target}: {what}: {score}\n    {}\n", read.join("\n    "));
    }

    fn line(&mut self, (what, name, act, words): &OnLine) {
        let mut line = Line::of(slaves::TARGETS.iter().find(|target| target.name == *name).unwrap());
        act(&mut line);
        line.wait(Duration::from_millis(50));
        let mut read = line.take_news();
        read.extend(line.bus.why(Line::slave()).map(|why| format!("why: {why}")));
        self.note(name, what, words, &read);
    }

    fn bus(&mut self, (what, name, act, words): &OnBus) {
        let mut bus = Bus::of(nodes::TARGETS.iter().find(|target| target.name == *name).unwrap());
        act(&mut bus);
        bus.wait(Duration::from_millis(50));
        let mut read = bus.take_news();
        read.extend(bus.why().map(|why| format!("why: {why}")));
        self.note(name, what, words, &read);
    }
}

#[test]
fn of_each_mistake_the_cause_the_place_and_the_cure_are_read() {
    let mut exam = Exam::default();
    ON_LINE.iter().chain(RECORDS).for_each(|mistake| exam.line(mistake));
    ON_BUS.iter().chain(TRANSFERS).for_each(|mistake| exam.bus(mistake));
    let Exam { table, asked, failed } = exam;
    assert_eq!(asked, 120);
    assert!(failed == 0, "{failed} of {asked}:\n{table}");
}
