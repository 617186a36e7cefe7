//! Explanations on stdout: as trees, lines or JSON.

use core::fmt::Display;
use core::time::Duration;
use std::io::{self, BufWriter, Write};

use crate::explain::{Explanation, Kind, Mark, Overheard};
use serde::Serialize;

use crate::command::Failure;
use crate::command::args::Decode;

/// Where octets were found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Place {
    /// In the arguments.
    Nowhere,
    /// In a stream of raw octets.
    Stream,
    /// In a line of a text, from 1 on. A telegram over several is found in its last; one that broke off before the
    /// octet `from`, where this line begins, in the line `before`.
    Line { number: u64, from: u64, before: u64 },
    /// In a packet of a capture, from 1 on, at a time since 1970.
    Packet { number: u64, time: Duration },
}

/// Why reading ends early.
#[derive(Debug)]
pub(super) enum Stopped {
    /// Nothing can be written.
    Out(io::Error),
    /// Nothing more can be read.
    In(Failure),
}

impl From<io::Error> for Stopped {
    fn from(error: io::Error) -> Self {
        Self::Out(error)
    }
}

/// How explanations are written.
#[derive(Clone, Copy)]
enum Form {
    Tree,
    Brief,
    Json,
}

/// Writes explanations and counts what is wrong.
pub(super) struct Output<W: Write> {
    out: BufWriter<W>,
    form: Form,
    places: bool,
    explained: u64,
    invalid: u64,
    mistakes: u64,
    unreadable: u64,
    overheard: Overheard,
}

/// One line of `--json`.
#[derive(Serialize)]
struct Item<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    line: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    packet: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    time: Option<String>,
    at: u64,
    mark: Mark,
    hints: Vec<&'a str>,
    #[serde(flatten)]
    explanation: &'a Explanation,
}

impl<W: Write> Output<W> {
    pub(super) fn new(out: W, args: &Decode, places: bool) -> Self {
        let form = match (args.json, args.brief) {
            (true, _) => Form::Json,
            (false, true) => Form::Brief,
            (false, false) => Form::Tree,
        };
        let out = BufWriter::new(out);
        Self {
            out,
            form,
            places,
            explained: 0,
            invalid: 0,
            mistakes: 0,
            unreadable: 0,
            overheard: Overheard::default(),
        }
    }

    /// Writes what `decode` explains of octets found at `place`.
    pub(super) fn explain(
        &mut self,
        place: Place,
        decode: impl FnOnce(&mut dyn FnMut(u64, Explanation)),
    ) -> Result<(), Stopped> {
        let mut written = Ok(());
        decode(&mut |at, explanation| {
            if written.is_ok() {
                written = self.write(place, at, &explanation);
            }
        });
        Ok(written?)
    }

    /// Writes that a line of text holds something else than octets.
    pub(super) fn unreadable(&mut self, line: u64, error: &dyn Display) -> Result<(), Stopped> {
        self.unreadable += 1;
        match self.form {
            Form::Json => {
                let object = serde_json::json!({ "line": line, "error": error.to_string() });
                writeln!(self.out, "{object}")?;
            }
            Form::Tree | Form::Brief => writeln!(self.out, "{line}: cannot be read: {error}")?,
        }
        Ok(())
    }

    pub(super) fn flush(&mut self) -> Result<(), Stopped> {
        Ok(self.out.flush()?)
    }

    /// Flushes, and says whether all was valid.
    pub(super) fn verdict(mut self, strict: bool) -> Result<(), Failure> {
        match self.out.flush() {
            Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
                return Err(Failure::Other(format!("cannot write to stdout: {error}")));
            }
            Ok(()) | Err(_) => {}
        }
        let Self { explained, invalid, mistakes, unreadable, overheard, .. } = self;
        if explained == 0 && unreadable == 0 {
            return Err(Failure::Other(
                "there are no octets in the input: the master sent nothing, or nothing was recorded; check that it runs and uses \
                 the link of the recording; see 'profidrive decode --help'"
                    .into(),
            ));
        }
        let mut wrong = Vec::new();
        if invalid > 0 {
            wrong.push(format!(
                "{invalid} of {explained} {} invalid",
                if invalid == 1 { "is" } else { "are" }
            ));
        }
        if strict && mistakes > 0 {
            wrong.push(format!(
                "{mistakes} of {explained} {}",
                if mistakes == 1 { "is a mistake" } else { "are mistakes" }
            ));
        }
        if unreadable > 0 {
            wrong.push(format!("lines that cannot be read: {unreadable}"));
        }
        if let Some(foreign) = overheard.foreign() {
            wrong.push(format!("no DP master was heard: {foreign}; {}", foreign.cure()));
        }
        if wrong.is_empty() { Ok(()) } else { Err(Failure::Other(wrong.join("; "))) }
    }

    fn write(&mut self, place: Place, at: u64, explanation: &Explanation) -> io::Result<()> {
        self.explained += 1;
        match explanation.kind {
            Kind::Telegram | Kind::Noise if self.places => self.overheard.take(&explanation.octets),
            Kind::Telegram
            | Kind::Token
            | Kind::Noise
            | Kind::Ppo
            | Kind::Pkw
            | Kind::Pzd
            | Kind::Word
            | Kind::Frame
            | Kind::ErrorFrame => {}
        }
        let mark = explanation.mark();
        match mark {
            Mark::Plain | Mark::Trouble => {}
            Mark::Mistake => self.mistakes += 1,
            Mark::Invalid => self.invalid += 1,
        }
        let line = line_of(place, at, explanation);
        let label = match place {
            Place::Line { .. } if self.places => line.map(|line| format!("{line}: ")).unwrap_or_default(),
            Place::Packet { number, .. } => format!("{number}: "),
            Place::Stream => format!("{at}: "),
            Place::Line { .. } | Place::Nowhere => String::new(),
        };
        match self.form {
            Form::Tree => writeln!(self.out, "{label}{explanation}"),
            Form::Brief => {
                writeln!(self.out, "{label}{}", explanation.line())?;
                explanation.hints().into_iter().try_for_each(|hint| writeln!(self.out, "    ^ {hint}"))
            }
            Form::Json => {
                let item = item(place, at, mark, explanation);
                serde_json::to_writer(&mut self.out, &item)?;
                writeln!(self.out)
            }
        }
    }
}

/// The line of what ends before this place's octets or in them, if it is in a line.
fn line_of(place: Place, at: u64, explanation: &Explanation) -> Option<u64> {
    let end = at + u64::try_from(explanation.octets.len()).unwrap_or(0);
    match place {
        Place::Line { from, before, .. } if end <= from => Some(before),
        Place::Line { number, .. } => Some(number),
        Place::Nowhere | Place::Stream | Place::Packet { .. } => None,
    }
}

fn item(place: Place, at: u64, mark: Mark, explanation: &Explanation) -> Item<'_> {
    let hints = explanation.hints();
    let line = line_of(place, at, explanation);
    let item = Item { line, packet: None, time: None, at, mark, hints, explanation };
    match place {
        Place::Nowhere | Place::Stream | Place::Line { .. } => item,
        Place::Packet { number, time } => {
            let time = format!("{}.{:09}", time.as_secs(), time.subsec_nanos());
            Item { packet: Some(number), time: Some(time), ..item }
        }
    }
}
