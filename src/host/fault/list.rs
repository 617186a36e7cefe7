//! The faults that act, by number.

use super::Rule;
use crate::chance::Chance;
use crate::time::Instant;

/// Faults in the order in which they act, each with what it has seen (`S`).
#[derive(Debug)]
pub(crate) struct List<S> {
    pub(crate) active: Vec<Active<S>>,
    /// The number of the newest.
    last: u32,
}

/// A fault, and what it has seen and done.
#[derive(Debug)]
pub(crate) struct Active<S> {
    pub(crate) number: u32,
    pub(crate) rule: Rule,
    pub(crate) chance: Chance,
    pub(crate) seen: S,
}

impl<S> Default for List<S> {
    fn default() -> Self {
        Self { active: Vec::new(), last: 0 }
    }
}

impl<S> List<S> {
    /// Each fault with its number and how often it was injected.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (u32, Rule, u32)> + '_ {
        self.active.iter().map(|active| (active.number, active.rule, active.chance.injected()))
    }

    /// Adds a fault behind the others. Returns its number, which is not given twice.
    pub(crate) fn add(&mut self, now: Instant, rule: Rule, seen: S) -> u32 {
        self.last = self.last.saturating_add(1);
        self.active.push(Active { number: self.last, rule, chance: Chance::new(rule.when, now), seen });
        self.last
    }

    /// Ends a fault. `None`: there is none of this number.
    pub(crate) fn remove(&mut self, number: u32) -> Option<Rule> {
        let place = self.active.iter().position(|active| active.number == number)?;
        Some(self.active.remove(place).rule)
    }

    /// Ends every fault.
    pub(crate) fn clear(&mut self) {
        self.active.clear();
    }
}

impl<S> Active<S> {
    /// Counts an occasion, says whether the fault is injected now, and logs it if it is.
    pub(crate) fn strikes(&mut self) -> bool {
        let injected = self.chance.strikes();
        if injected {
            tracing::debug!("fault on purpose: {} has happened {} times", self.rule, self.chance.injected());
        }
        injected
    }
}
