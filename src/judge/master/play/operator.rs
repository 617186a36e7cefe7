//! Who operates the master is asked for what a scenario needs, and says when it is done.

use core::time::Duration;

use super::{Judge, Phase};
use crate::judge::master::scenario::Check;
use crate::time::Instant;

impl Judge {
    /// What the master is to be asked for now, as `--ask` takes it.
    #[must_use]
    pub(crate) fn poll_ask(&mut self) -> Option<String> {
        self.ask.take()
    }

    /// Whether an action is under way.
    pub const fn is_asking(&self) -> bool {
        self.asking
    }

    /// The action is done, or could not be.
    pub fn asked(&mut self, now: Instant, done: bool) {
        self.asking = false;
        let Phase::Playing { scenario, step, .. } = self.phase else { return };
        let Some(played) = self.scenarios.get_mut(scenario) else { return };
        let Some(begun) = played.steps.get_mut(step) else { return };
        if !done {
            begun.check = None;
            let reason = format!("the command of --ask failed: {}", begun.ask.clone().unwrap_or_default());
            for row in &played.rows {
                self.observer.findings.default_missed(*row, &reason);
            }
        }
        let lasts = if done { begun.lasts } else { Duration::ZERO };
        self.stopped = (begun.check == Some(Check::Stop)).then(|| now + Duration::from_secs(1));
        self.phase = Phase::Playing { scenario, step, until: now + lasts };
    }
}
