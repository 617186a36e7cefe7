//! SYNC: synchronous RPDOs act, then synchronous TPDOs are sampled and sent (`canopen-link.md` 6 and 7).

use core::time::Duration;

use super::Node;
use crate::can_bus::can::Frame;
use crate::can_bus::canopen::application::{Application, Notice};
use crate::can_bus::canopen::cob_id::CobId;
use crate::can_bus::canopen::nmt::NmtState;
use crate::can_bus::canopen::policy::SyncProducer;
use crate::time::Instant;

/// A node does not fill the bus with SYNC, whatever 1006h says.
const SHORTEST_PERIOD: Duration = Duration::from_micros(100);

impl Node {
    /// A SYNC in OPERATIONAL. What it carries is a counter, if it has one (1019h).
    pub(super) fn sync(&mut self, now: Instant, counter: Option<u8>, app: &mut dyn Application) {
        self.sync_window_ends = match self.values.sync_window {
            0 => None,
            micros => Some(now.saturating_add(Duration::from_micros(micros.into()))),
        };
        self.take_synchronous_rpdos(now, app);
        app.notice(now, Notice::Sync);
        self.send_synchronous_tpdos(now, counter, app);
    }

    /// 1005h, 1006h or 1019h was written, the node booted or left STOPPED: the first SYNC of its own comes one period later,
    /// with the counter 1.
    pub(super) fn restart_sync(&mut self, now: Instant) {
        self.syncs_sent = 0;
        self.sync_due = self.sync_period().map(|period| now.saturating_add(period));
    }

    /// The period of the SYNCs that the node produces.
    fn sync_period(&self) -> Option<Duration> {
        match (self.policy.sync_producer, self.values.sync_period) {
            (SyncProducer::Produced, micros @ 1..) if CobId(self.values.sync_id).bit_30() => {
                Some(Duration::from_micros(micros.into()).max(SHORTEST_PERIOD))
            }
            (SyncProducer::Produced | SyncProducer::Refused | SyncProducer::Dropped, _) => None,
        }
    }

    pub(super) fn sync_timeout(&mut self, now: Instant, app: &mut dyn Application) {
        let (Some(due), Some(period), Some(state), Some(id)) =
            (self.sync_due, self.sync_period(), self.state, CobId(self.values.sync_id).id())
        else {
            return;
        };
        if now < due || !state.serves_sdo() {
            return;
        }
        // Counted from when it was due, as heartbeats.
        let next = due.saturating_add(period);
        self.sync_due = Some(if next <= now { now.saturating_add(period) } else { next });
        let counter = match self.values.sync_counter {
            0 => None,
            highest => {
                self.syncs_sent =
                    if self.syncs_sent >= highest { 1 } else { self.syncs_sent.saturating_add(1) };
                Some(self.syncs_sent)
            }
        };
        if let Ok(frame) = Frame::data(id, counter.as_slice()) {
            self.send(frame);
        }
        // A node does not hear itself.
        if state == NmtState::Operational {
            self.sync(now, counter, app);
        }
    }

    /// Whether a synchronous RPDO is still in time for the next SYNC (1007h).
    pub(super) fn in_sync_window(&self, now: Instant) -> bool {
        self.sync_window_ends.is_none_or(|end| now <= end)
    }
}
