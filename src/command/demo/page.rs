//! The page that a story is written to: titles, paragraphs, and lines with a time and a speaker.

use core::fmt::{Arguments, Display};
use std::io::{self, Write};

use crate::time::Instant;

/// The page is as wide as this.
pub(super) const WIDTH: usize = 80;
/// Where text begins beside the time and the speaker.
pub(super) const INDENT: usize = 18;

/// Why the story ends early.
#[derive(Debug)]
pub(super) enum Trouble {
    /// The page cannot be written.
    Out(io::Error),
    /// Master or device did something that does not belong to the story.
    Unexpected(String),
}

impl From<io::Error> for Trouble {
    fn from(error: io::Error) -> Self {
        Self::Out(error)
    }
}

pub(super) fn unexpected(error: impl Display) -> Trouble {
    Trouble::Unexpected(error.to_string())
}

/// A page of 80 columns.
pub(super) struct Page<'w> {
    out: &'w mut dyn Write,
    titles: u8,
}

impl<'w> Page<'w> {
    pub(super) fn new(out: &'w mut dyn Write) -> Self {
        Self { out, titles: 0 }
    }

    /// Begins a part of the story.
    pub(super) fn title(&mut self, title: &str) -> Result<(), Trouble> {
        self.titles += 1;
        let heading = format!("--- {} {title} ", self.titles);
        writeln!(self.out, "\n{heading:-<WIDTH$}")?;
        Ok(())
    }

    /// A paragraph.
    pub(super) fn text(&mut self, text: &str) -> Result<(), Trouble> {
        for line in wrap(text, WIDTH) {
            writeln!(self.out, "{line}")?;
        }
        Ok(())
    }

    /// What somebody says at a time.
    pub(super) fn line(&mut self, at: Instant, speaker: &str, text: Arguments<'_>) -> Result<(), Trouble> {
        let micros = at.as_nanos() / 1_000;
        self.entry(&format!("{:>5}.{:03}  {speaker:<7}", micros / 1_000, micros % 1_000), text)
    }

    /// What belongs to the line before.
    pub(super) fn line_without_time(&mut self, speaker: &str, text: Arguments<'_>) -> Result<(), Trouble> {
        self.entry(&format!("{:>9}  {speaker:<7}", ""), text)
    }

    /// Lines as they are.
    pub(super) fn picture(&mut self, lines: &[String]) -> Result<(), Trouble> {
        writeln!(self.out)?;
        for line in lines {
            writeln!(self.out, "{line}")?;
        }
        Ok(())
    }

    fn entry(&mut self, head: &str, text: Arguments<'_>) -> Result<(), Trouble> {
        let mut head = head;
        for line in wrap(&text.to_string(), WIDTH - INDENT) {
            writeln!(self.out, "{head:<INDENT$}{line}")?;
            head = "";
        }
        Ok(())
    }
}

/// The words of `text` in lines of at most `width` characters; a longer word has a line for itself. Double spaces
/// stay.
fn wrap(text: &str, width: usize) -> Vec<String> {
    let mut lines = Vec::new();
    let mut line = String::new();
    for word in text.split(' ') {
        if !line.is_empty() && line.chars().count() + 1 + word.chars().count() > width {
            lines.push(core::mem::take(&mut line));
        }
        if !line.is_empty() {
            line.push(' ');
        }
        line.push_str(word);
    }
    lines.push(line);
    lines
}
