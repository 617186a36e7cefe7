//! Rows V about alarms: which acknowledgement belongs to which (`dp-v1.md` 6).

use core::time::Duration;

use super::Observer;
use super::cycle::Cycle;
use crate::judge::master::findings::Weight;
use crate::judge::master::rows::Row;
use crate::profibus::dp::{ext_diag, slave_diag};
use crate::profibus::dpv1::{AlarmHead, TypedBlock};
use crate::time::Instant;

/// Data_Exchange at most, and for how long, before an alarm is acknowledged.
const MOST_EXCHANGES: u32 = 200;
const MOST_TIME: Duration = Duration::from_secs(2);

/// The alarms that a master has read and that are not over.
#[derive(Clone, Debug, Default)]
pub(super) struct Alarms {
    shown: Vec<Shown>,
}

#[derive(Clone, Copy, Debug)]
struct Shown {
    head: AlarmHead,
    serial: u64,
    since: Instant,
    exchanges: u32,
    /// It is too late, or an acknowledgement is under way.
    told: bool,
}

impl Alarms {
    pub(super) fn forget(&mut self) {
        self.shown.clear();
    }

    /// The slave has taken an acknowledgement. Whether the alarm was there.
    pub(super) fn acknowledged(&mut self, head: AlarmHead) -> bool {
        let before = self.shown.len();
        self.shown.retain(|shown| !head.means(shown.head));
        self.shown.len() < before
    }
}

impl Observer {
    /// What a diagnosis reports while data are exchanged.
    pub(super) fn note_alarms(&mut self, cycle: &Cycle, octets: &[u8]) {
        let offers = self.setup.slave(cycle.to).is_none_or(|slave| slave.offer().alarms.types != 0);
        let view = self.view(cycle.to);
        if !offers || !view.exchanging || !view.enables_dpv1() {
            return;
        }
        for block in ext_diag::blocks(octets.get(slave_diag::LEN..).unwrap_or_default()) {
            let Some(TypedBlock::Alarm { head, .. }) = TypedBlock::of_block(block) else { continue };
            let known = view.services.alarms.shown.iter().any(|shown| shown.head.means(head));
            if !known {
                let shown = Shown { head, serial: cycle.serial, since: cycle.end, exchanges: 0, told: false };
                view.services.alarms.shown.push(shown);
            }
        }
    }

    /// An acknowledgement.
    pub(super) fn judge_acknowledgement(&mut self, cycle: &Cycle, head: AlarmHead) {
        let begun = self.view(cycle.to).prm_data.is_some();
        if self.is_recorded() && !begun {
            return;
        }
        let shown = &mut self.view(cycle.to).services.alarms.shown;
        let found = shown.iter_mut().find(|shown| head.means(shown.head));
        let reason = match found {
            Some(shown) => {
                shown.told = true;
                None
            }
            None => Some(match shown.first() {
                None => format!("{head} is acknowledged, and no diagnosis has shown it, or it is over"),
                Some(other) => format!("{head} is acknowledged; the diagnosis has shown {}", other.head),
            }),
        };
        self.verdict_of(cycle, Row::V11, reason);
    }

    /// A Data_Exchange, while alarms wait.
    pub(super) fn judge_alarms(&mut self, cycle: &Cycle) {
        let mut late = None;
        for shown in &mut self.view(cycle.to).services.alarms.shown {
            shown.exchanges += 1;
            let waited = cycle.end.saturating_since(shown.since);
            if shown.exchanges > MOST_EXCHANGES && waited > MOST_TIME && !shown.told {
                shown.told = true;
                late = Some((shown.serial, shown.head, waited));
            }
        }
        if let Some((serial, head, waited)) = late {
            let reason = format!("{head} is not acknowledged {} ms after the diagnosis", waited.as_millis());
            self.broken(Row::V12, Weight::Once, serial, Some(cycle.to), reason);
        }
    }
}
