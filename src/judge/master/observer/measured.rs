//! The traffic in figures, as the telegrams show it.

use super::Observer;
use super::cycle::{Answer, Cycle};
use super::view::Loss;
use crate::profibus::dp;

impl Observer {
    /// A request: one that is repeated, or the time since the Data_Exchange before it.
    pub(super) fn measure_cycle(&mut self, cycle: &Cycle) {
        let now = cycle.end;
        if cycle.retry > 0 {
            self.figures.repeated(now);
        }
        let exchanges = cycle.service == Some(dp::Service::DataExchange) && cycle.retry == 0;
        let asked = exchanges.then_some(now);
        let before = core::mem::replace(&mut self.view(cycle.to).exchange_asked, asked);
        let calm = |before| self.trouble.is_none_or(|trouble| trouble < before);
        if let Some(before) = before.filter(|before| exchanges && calm(*before)) {
            self.figures.took(now, now.saturating_since(before));
        }
    }

    /// A request that got no good answer, or a late one: the cycle that it was in takes longer. To a station that is never there
    /// that is as usual.
    pub(super) fn note_trouble(&mut self, cycle: &Cycle, answer: &Answer) {
        let absent = self.setup.slave(cycle.to).is_some_and(|slave| slave.absent);
        let good = matches!(answer, Answer::ShortAck | Answer::Data { .. });
        if cycle.void || self.held_back || !(good || absent) {
            self.trouble = Some(cycle.end);
        }
    }

    /// The master has given up a station that had answered.
    pub(super) fn note_loss(&mut self, cycle: &Cycle) {
        let view = self.view(cycle.to);
        if view.answered && view.loss == Loss::None {
            self.figures.lost(cycle.end);
        }
    }
}
