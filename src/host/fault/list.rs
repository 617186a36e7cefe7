//! The faults that act, by number.

use core::fmt;

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

/// A fault as it is listed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Listed {
    /// Its number, with which it is removed.
    pub(crate) number: u32,
    pub(crate) rule: Rule,
    /// How often it was injected.
    pub(crate) injected: u32,
    /// Whether its times and its condition let it act now.
    pub(crate) may_act: bool,
}

/// A fault, and what it has seen and done.
#[derive(Debug)]
pub(crate) struct Active<S> {
    pub(crate) number: u32,
    pub(crate) rule: Rule,
    pub(crate) chance: Chance,
    /// Whether it might act when that was asked last; without times and condition always.
    open: bool,
    /// When its times change that next.
    change: Option<Instant>,
    pub(crate) seen: S,
}

impl<S> Default for List<S> {
    fn default() -> Self {
        Self { active: Vec::new(), last: 0 }
    }
}

impl<S> List<S> {
    /// Each fault with what has become of it.
    pub(crate) fn iter(&self) -> impl Iterator<Item = Listed> + '_ {
        self.active.iter().map(|active| Listed {
            number: active.number,
            rule: active.rule,
            injected: active.chance.injected(),
            may_act: active.open,
        })
    }

    /// Looks which may act now, without an occasion; `holds` says whether what one waits for is there.
    pub(crate) fn look(&mut self, now: Instant, holds: impl Fn(&Active<S>) -> bool) {
        for active in &mut self.active {
            let holds = holds(active);
            active.may_act(now, holds);
        }
    }

    /// When to look again.
    pub(crate) fn next_change(&self) -> Option<Instant> {
        self.active.iter().filter_map(|active| active.change).min()
    }

    /// Adds a fault behind the others. Returns its number, which is not given twice.
    pub(crate) fn add(&mut self, now: Instant, rule: Rule, seen: S) -> u32 {
        self.last = self.last.saturating_add(1);
        let open = rule.when.from.is_zero() && rule.while_input.is_none();
        let chance = Chance::new(rule.when, now);
        let change = chance.next_change(now);
        self.active.push(Active { number: self.last, rule, chance, open, change, seen });
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
    /// Counts an occasion, says whether the fault is injected now, and logs it: the first time, the second, the fourth and so
    /// on.
    pub(crate) fn strikes(&mut self) -> bool {
        let injected = self.chance.strikes();
        let times = self.chance.injected();
        if injected && times.is_power_of_two() {
            tracing::info!("fault on purpose: {}: {} time", self.rule, Ordinal(times));
        }
        injected
    }

    /// Whether it may act now: its times, and `holds` of what it waits for. Logs when that changes.
    pub(crate) fn may_act(&mut self, now: Instant, holds: bool) -> bool {
        let open = self.chance.is_open(now) && holds;
        self.change = self.chance.next_change(now);
        if core::mem::replace(&mut self.open, open) != open {
            let words = if open { "may act from now on" } else { "acts no longer" };
            tracing::info!("fault on purpose: {}: {words}", self.rule);
        }
        open
    }
}

/// `1st`, `2nd`, `11th`.
struct Ordinal(u32);

impl fmt::Display for Ordinal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ending = match (self.0 % 10, self.0 % 100) {
            (_, 11..=13) => "th",
            (1, _) => "st",
            (2, _) => "nd",
            (3, _) => "rd",
            _ => "th",
        };
        write!(f, "{}{ending}", self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_the_endings_of_ordinals() {
        let said =
            [1, 2, 3, 4, 11, 12, 13, 21, 22, 64, 111, 512, 1024].map(|number| Ordinal(number).to_string());
        let expected = [
            "1st", "2nd", "3rd", "4th", "11th", "12th", "13th", "21st", "22nd", "64th", "111th", "512th",
            "1024th",
        ];
        assert_eq!(said, expected);
    }
}
