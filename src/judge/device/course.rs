//! How a row stops before its end.

use super::Ending;
use crate::judge::moment::Telegram;

/// `Ok`: the row held.
pub(super) type Course<T = ()> = Result<T, Halt>;

/// Why a row stops before its end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Halt {
    /// It is broken, for this reason. What was sent and heard since it began shows it, unless something else does.
    Broken { why: String, shown: Option<Vec<Telegram>> },
    /// It could have been judged, and was not.
    Missed(String),
    /// It is about something that is not there: an option, a property of the device, a link that shows it.
    Inapplicable(String),
    /// Nothing more can be judged.
    Over(Ending),
}

/// The row is broken.
pub(super) fn broken<T>(why: impl Into<String>) -> Course<T> {
    Err(Halt::Broken { why: why.into(), shown: None })
}

/// The row needs something that is not there.
pub(super) fn inapplicable<T>(why: impl Into<String>) -> Course<T> {
    Err(Halt::Inapplicable(why.into()))
}

/// The row was not judged, and should have been.
pub(super) fn missed<T>(why: impl Into<String>) -> Course<T> {
    Err(Halt::Missed(why.into()))
}
