//! A table of rows: groups of entries, each with the function that judges it.

use core::cmp::Ordering;
use core::fmt;
use core::hash::{Hash, Hasher};

use super::Ending;
use super::course::Course;
use crate::judge::requirement::{Confidence, Requirement};

/// What the rows of a table are judged with.
pub trait Table: Sized + 'static {
    /// What is judged, as `slave`.
    const SUBJECT: &'static str;

    /// The groups of the table.
    #[doc(hidden)]
    fn groups() -> Vec<Group<Self>>;
}

/// Rows under one title.
#[doc(hidden)]
#[derive(Debug)]
pub struct Group<P: 'static> {
    pub(super) title: &'static str,
    pub(super) rows: &'static [Entry<P>],
}

/// A row of a table.
#[derive(Debug)]
pub(super) struct Entry<P: 'static> {
    /// `S-C03`.
    pub(super) id: &'static str,
    /// 1: mandatory, 2: expected of any device, 3: good practice.
    pub(super) priority: u8,
    /// How sure the sources are.
    pub(super) confidence: Confidence,
    /// What must come of what is sent.
    pub(super) text: &'static str,
    /// The sentence of the reference.
    pub(super) rule: &'static str,
    /// Rows without which nothing can be said of this one.
    pub(super) needs: &'static [&'static str],
    /// How it is judged.
    pub(super) by: By<P>,
}

impl<P> Entry<P> {
    /// The same row, of this priority and as sure as this.
    pub(super) const fn rated(self, priority: u8, confidence: Confidence) -> Self {
        let Self { id, text, rule, needs, by, .. } = self;
        Self { id, priority, confidence, text, rule, needs, by }
    }
}

/// How a row is judged.
pub(super) enum By<P: 'static> {
    /// By what this function sends and hears.
    Trial(Judge<P>),
    /// In the end, by everything that was heard.
    Watching(Judge<P>),
    /// Not from outside, for this reason.
    Nothing(&'static str),
}

impl<P> fmt::Debug for By<P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Trial(_) => "Trial",
            Self::Watching(_) => "Watching",
            Self::Nothing(_) => "Nothing",
        })
    }
}

/// A requirement of a table of devices.
pub struct Row<P: Table> {
    pub(super) entry: &'static Entry<P>,
    group: &'static str,
    /// Its place in the table.
    number: usize,
}

/// A function that judges.
pub(super) type Judge<P> = fn(&mut P) -> Course;

impl<P: Table> Row<P> {
    /// 1: mandatory, 2: expected of any device, 3: good practice.
    pub const fn priority(self) -> u8 {
        self.entry.priority
    }

    /// How sure the sources are.
    pub const fn confidence(self) -> Confidence {
        self.entry.confidence
    }

    /// Why it is never judged from outside; `None`: it is.
    pub const fn unseen(self) -> Option<&'static str> {
        match self.entry.by {
            By::Nothing(why) => Some(why),
            By::Trial(_) | By::Watching(_) => None,
        }
    }

    /// Rows without which nothing can be said of it.
    pub const fn needs(self) -> &'static [&'static str] {
        self.entry.needs
    }
}

impl<P: Table> Requirement for Row<P> {
    type Ending = Ending;

    const SUBJECT: &'static str = P::SUBJECT;
    const EACH_COUNTS: bool = true;

    fn all() -> Vec<Self> {
        let entries = P::groups().into_iter().flat_map(|group| {
            let title = group.title;
            group.rows.iter().map(move |entry| (title, entry))
        });
        entries.enumerate().map(|(number, (group, entry))| Self { entry, group, number }).collect()
    }

    fn id(self) -> &'static str {
        self.entry.id
    }

    fn group(self) -> &'static str {
        self.group
    }

    fn text(self) -> &'static str {
        self.entry.text
    }

    fn rule(self) -> Option<&'static str> {
        Some(self.entry.rule)
    }

    fn only_warns(self) -> bool {
        matches!(self.entry.confidence, Confidence::U) || self.entry.priority == 3
    }
}

impl<P: Table> Clone for Row<P> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<P: Table> Copy for Row<P> {}

impl<P: Table> PartialEq for Row<P> {
    fn eq(&self, other: &Self) -> bool {
        self.number == other.number
    }
}

impl<P: Table> Eq for Row<P> {}

impl<P: Table> PartialOrd for Row<P> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<P: Table> Ord for Row<P> {
    fn cmp(&self, other: &Self) -> Ordering {
        self.number.cmp(&other.number)
    }
}

impl<P: Table> Hash for Row<P> {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.number.hash(state);
    }
}

impl<P: Table> fmt::Debug for Row<P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.entry.id)
    }
}
