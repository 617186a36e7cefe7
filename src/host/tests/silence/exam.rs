//! Sixty mistakes that no other test has, and what a person has to read of each: the cause, where it shows, what was expected,
//! what to do.

use core::time::Duration;

use super::nodes::{self, Bus};
use super::slaves::{self, Line};

mod bus;
mod line;

use bus::ON_BUS;
use line::ON_LINE;

/// What is missing of the words in what was read.
fn missing(words: &[&str], read: &str) -> Vec<String> {
    words.iter().filter(|word| !read.contains(**word)).map(|word| format!("'{word}'")).collect()
}

#[test]
fn of_sixty_mistakes_the_cause_the_place_and_the_cure_are_read() {
    let mut table = String::new();
    let mut failed = 0;
    let mut note = |target: &str, what: &str, words: &[&str], read: &[String]| {
        let missing = missing(words, &read.join("\n"));
        failed += usize::from(!missing.is_empty());
        let score = if missing.is_empty() { "2".to_owned() } else { format!("lacks {}", missing.join(", ")) };
        table += &format!("{target}: {what}: {score}\n    {}\n", read.join("\n    "));
    };
    for (what, name, act, words) in ON_LINE {
        let mut line = Line::of(slaves::TARGETS.iter().find(|target| target.name == *name).unwrap());
        act(&mut line);
        line.wait(Duration::from_millis(50));
        let mut read = line.take_news();
        read.extend(line.bus.why(Line::slave()).map(|why| format!("why: {why}")));
        note(name, what, words, &read);
    }
    for (what, name, act, words) in ON_BUS {
        let mut bus = Bus::of(nodes::TARGETS.iter().find(|target| target.name == *name).unwrap());
        act(&mut bus);
        bus.wait(Duration::from_millis(50));
        let mut read = bus.take_news();
        read.extend(bus.why().map(|why| format!("why: {why}")));
        note(name, what, words, &read);
    }
    assert_eq!(ON_LINE.len() + ON_BUS.len(), 60);
    assert!(failed == 0, "{failed} of 60:\n{table}");
}
