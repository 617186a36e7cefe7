//! When the same hint is said again.

use core::time::Duration;

use crate::time::Instant;

/// The same kind of hint is not said again in this time, by a station or of a bus.
pub(crate) const PAUSE: Duration = Duration::from_secs(60);

/// Whether a hint that was said at `said` is to be said at `now`; it counts as said then.
pub(crate) fn is_due(said: &mut Option<Instant>, now: Instant) -> bool {
    let due = said.is_none_or(|said| now.saturating_since(said) >= PAUSE);
    if due {
        *said = Some(now);
    }
    due
}
