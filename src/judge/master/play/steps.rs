//! A scenario, step by step.

use super::{Judge, Phase};
use crate::host::Bus;
use crate::host::link::fault::Faults;
use crate::judge::master::rows::Row;
use crate::judge::master::scenario::{Check, Scenario};
use crate::judge::master::station::act;
use crate::time::Instant;

/// What a master may be asked for that leads to CLEAR, or through it.
const CLEARING: &[&str] = &["clear", "stop", "restart", "operate"];

impl Judge {
    pub(super) fn begin_scenario(
        &mut self,
        now: Instant,
        scenario: usize,
        bus: &mut Bus,
        faults: &mut Faults,
    ) {
        self.injected = 0;
        self.has_read = false;
        self.tell(scenario);
        self.remember();
        let played = self.scenarios.get(scenario);
        self.observer.held_back = played.is_some_and(|scenario| scenario.holds);
        let floods = |scenario: &Scenario| scenario.rows.iter().any(|row| matches!(row, Row::E16 | Row::E17));
        self.observer.blind = self.scenarios.get(scenario).is_some_and(floods);
        self.begin_step(now, scenario, 0, bus, faults);
    }

    fn begin_step(&mut self, now: Instant, scenario: usize, step: usize, bus: &mut Bus, faults: &mut Faults) {
        let Some(played) = self.scenarios.get(scenario) else { return };
        let Some(begun) = played.steps.get(step) else { return };
        if let (Some(wanted), Some(subject)) = (begun.act, played.subject(&self.observer.setup)) {
            act(wanted, &subject.clone(), bus, now);
        }
        let (ask, until) = (begun.ask.clone(), now + self.time(begun));
        // A master passes through CLEAR on its way from STOP to OPERATE, too.
        let may_clear = ask.as_deref().is_some_and(|ask| CLEARING.contains(&ask));
        self.observer.want_clear(may_clear);
        if let Some(action) = ask {
            self.observer.begin_asking();
            if let Some(Check::Outputs(wanted)) = &begun.check {
                self.observer.expect_outputs(wanted);
            }
            if action == "restart" || (action == "operate" && step > 0) {
                self.observer.expect_new_begin();
            }
            self.ask = Some(action);
            self.asking = true;
        }
        self.inject(now, scenario, step, faults);
        self.begin_second(scenario, step);
        self.phase = Phase::Playing { scenario, step, until };
    }

    pub(super) fn inject(&mut self, now: Instant, scenario: usize, step: usize, faults: &mut Faults) {
        let Some(played) = self.scenarios.get(scenario) else { return };
        let setup = &self.observer.setup;
        // The one that owns the slaves is not disturbed.
        faults.only_of(self.observer.master().filter(|_| setup.is_class_2()));
        let (Some(step), Some(subject)) = (played.steps.get(step), played.subject(setup)) else {
            return;
        };
        for fault in step.compiled(setup, subject.address).unwrap_or_default() {
            self.faults.push(faults.add(now, fault));
        }
    }

    pub(super) fn play(
        &mut self,
        now: Instant,
        scenario: usize,
        step: usize,
        until: Instant,
        bus: &mut Bus,
        faults: &mut Faults,
    ) {
        let Some(played) = self.scenarios.get(scenario) else {
            return self.go_on(now, bus, faults);
        };
        if self.stopped.is_some_and(|stopped| stopped <= now) {
            self.stopped = None;
            self.observer.count_requests();
        }
        if self.asking {
            return;
        }
        let until_injected = played.steps.get(step).is_some_and(|step| step.until_injected);
        let done = faults
            .iter()
            .filter(|(number, ..)| self.faults.contains(number))
            .all(|(_, fault, injected)| fault.when.count.is_some_and(|count| injected >= count));
        if now < until && !(until_injected && done && self.is_second_done()) {
            return;
        }
        let more = step + 1 < played.steps.len();
        self.end_second();
        self.end_faults(faults);
        self.step_ended(now, scenario, step);
        if more {
            return self.begin_step(now, scenario, step + 1, bus, faults);
        }
        self.begin_return(now, Some(scenario), self.return_limit(scenario), false);
    }

    fn end_faults(&mut self, faults: &mut Faults) {
        for (number, _, injected) in faults.iter() {
            if self.faults.contains(&number) {
                self.injected = self.injected.saturating_add(injected);
            }
        }
        for number in self.faults.drain(..) {
            faults.remove(number);
        }
        self.observer.held_back = false;
    }
}
