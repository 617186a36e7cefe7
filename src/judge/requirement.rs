//! What a report needs to know of the requirements that it is about, whoever is judged.

use core::fmt::{Debug, Display};
use core::hash::Hash;

/// How sure the sources are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Confidence {
    /// A page of the standard was read.
    A,
    /// Two independent manuals, or one of a slave ASIC.
    B,
    /// One device, trace or master.
    C,
    /// The sources are silent or contradict each other: a breach is a warning.
    U,
}

/// A row of a table of requirements: of masters, of slaves, of nodes.
pub trait Requirement: Copy + Eq + Ord + Hash + Debug + 'static {
    /// How a judgement by such rows ends.
    type Ending: Conclusion;

    /// What is judged, as `master`.
    const SUBJECT: &'static str;

    /// Whether every row that could be judged must be, for a judgement to be complete.
    const EACH_COUNTS: bool = false;

    /// Every row, in the order of the table.
    fn all() -> Vec<Self>;

    /// `M-C03`.
    fn id(self) -> &'static str;

    /// The title of its group.
    fn group(self) -> &'static str;

    /// The requirement.
    fn text(self) -> &'static str;

    /// What the reference says, where that is more than the requirement.
    fn rule(self) -> Option<&'static str> {
        None
    }

    /// Whether a breach is a warning and no failure.
    fn only_warns(self) -> bool;

    /// The row of that name, as `M-C03`.
    fn named(id: &str) -> Option<Self> {
        Self::all().into_iter().find(|row| row.id().eq_ignore_ascii_case(id))
    }

    /// The rows of a name or the beginning of names, as `M-C03` or `M-E*`; none if there are none.
    fn matching(pattern: &str) -> Vec<Self> {
        let (prefix, open) = pattern.strip_suffix('*').map_or((pattern, false), |prefix| (prefix, true));
        let fits = |row: &Self| {
            let id = row.id();
            let front = id.get(..prefix.len()).is_some_and(|front| front.eq_ignore_ascii_case(prefix));
            front && (open || id.len() == prefix.len())
        };
        Self::all().into_iter().filter(fits).collect()
    }
}

/// How a judgement ended.
pub trait Conclusion: Clone + Debug + Display + Eq {
    /// How much may be said.
    fn standing(&self) -> Standing;

    /// Whether a row with this name failed only because the judgement ended so.
    fn explains(&self, id: &str) -> bool {
        let _ = id;
        false
    }
}

/// How far a judgement came.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standing {
    /// Everything was tried.
    Tried,
    /// Everything that was there was looked at; nothing was tried.
    Read,
    /// It ended early.
    Partial,
    /// Nobody came, or nothing could be judged.
    Nothing,
}
