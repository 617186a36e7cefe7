//! SYNC: synchronous RPDOs act, then synchronous TPDOs are sampled and sent (`canopen-link.md` 6 and 7).

use core::time::Duration;

use super::Node;
use crate::can_bus::can::{Frame, Id};
use crate::can_bus::canopen::application::{Application, Notice};
use crate::can_bus::canopen::cob_id::CobId;
use crate::can_bus::canopen::event::{AwaitsSync, NoEffect};
use crate::can_bus::canopen::nmt::NmtState;
use crate::can_bus::canopen::policy::SyncProducer;
use crate::time::Instant;

/// A node does not fill the bus with SYNC, whatever 1006h says.
const SHORTEST_PERIOD: Duration = Duration::from_micros(100);

/// SYNC is missed when none came for so long, or for two of its periods (1006h).
const MISSED: Duration = Duration::from_secs(3);

/// What is known of the SYNCs of a master since OPERATIONAL was entered.
#[derive(Clone, Copy, Debug)]
pub(super) struct SyncWatch {
    /// When the next one is missed.
    due: Option<Instant>,
    /// One came since then.
    heard: bool,
    /// A master uses PDOs: it has set one up, or has sent one. That lasts until a reset.
    used: bool,
    /// What waits in vain.
    missing: Option<AwaitsSync>,
}

impl SyncWatch {
    pub(super) const NONE: Self = Self { due: None, heard: false, used: false, missing: None };

    pub(super) const fn due(&self) -> Option<Instant> {
        self.due
    }
}

impl Node {
    /// Which PDO waits for SYNC where none comes.
    pub(crate) const fn sync_missing(&self) -> Option<AwaitsSync> {
        self.sync_watch.missing
    }

    /// The NMT state changed.
    pub(super) fn watch_sync(&mut self, now: Instant, state: NmtState) {
        let used = self.sync_watch.used;
        self.sync_watch = SyncWatch { used, ..SyncWatch::NONE };
        if state == NmtState::Operational {
            self.await_sync(now);
        }
    }

    /// A master sets a PDO up, or sends one.
    pub(super) fn pdos_are_used(&mut self, now: Instant) {
        if !core::mem::replace(&mut self.sync_watch.used, true) && self.state == Some(NmtState::Operational) {
            self.await_sync(now);
        }
    }

    fn await_sync(&mut self, now: Instant) {
        let periods = Duration::from_micros(self.values.sync_period.into()) * 2;
        self.sync_watch.due = Some(now.saturating_add(periods.max(MISSED)));
    }

    /// No SYNC came for long: a TPDO may wait for one.
    pub(super) fn sync_watch_timeout(&mut self, now: Instant, app: &mut dyn Application) {
        if self.sync_watch.due.is_none_or(|due| now < due) {
            return;
        }
        let is_expected = core::mem::take(&mut self.sync_watch.heard) || self.sync_watch.used;
        self.sync_watch.due = None;
        if let Some(pdo) = self.synchronous_tpdo().filter(|_| is_expected) {
            self.miss_sync(now, AwaitsSync::Tpdo(pdo), app);
        }
    }

    pub(super) fn miss_sync(&mut self, now: Instant, pdo: AwaitsSync, app: &mut dyn Application) {
        self.sync_watch.missing = Some(pdo);
        let sync = CobId(self.values.sync_id).id().map_or(0, Id::number);
        self.no_effect(NoEffect::SyncMissing { pdo, sync });
        app.notice(now, Notice::SyncMissing(pdo));
    }

    /// A SYNC in OPERATIONAL. What it carries is a counter, if it has one (1019h).
    pub(super) fn sync(&mut self, now: Instant, counter: Option<u8>, app: &mut dyn Application) {
        self.sync_window_ends = match self.values.sync_window {
            0 => None,
            micros => Some(now.saturating_add(Duration::from_micros(micros.into()))),
        };
        (self.sync_watch.heard, self.sync_watch.missing) = (true, None);
        self.await_sync(now);
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
