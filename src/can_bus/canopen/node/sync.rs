//! SYNC: synchronous RPDOs act, then synchronous TPDOs are sampled and sent (`canopen-link.md` 6 and 7).

use core::time::Duration;

use super::Node;
use crate::can_bus::canopen::application::{Application, Notice};
use crate::time::Instant;

impl Node {
    /// A SYNC in OPERATIONAL. There is no counter in it; data are ignored.
    pub(super) fn sync(&mut self, now: Instant, app: &mut dyn Application) {
        self.sync_window_ends = match self.values.sync_window {
            0 => None,
            micros => Some(now.saturating_add(Duration::from_micros(micros.into()))),
        };
        self.take_synchronous_rpdos(now, app);
        app.notice(now, Notice::Sync);
        self.send_synchronous_tpdos(now, app);
    }

    /// Whether a synchronous RPDO is still in time for the next SYNC (1007h).
    pub(super) fn in_sync_window(&self, now: Instant) -> bool {
        self.sync_window_ends.is_none_or(|end| now <= end)
    }
}
