//! A second master on the line: when it is there, what it hears, and what it has seen.

use core::time::Duration;

use super::{Judge, SILENCE};
use crate::judge::master::findings::Weight;
use crate::judge::master::observer::Sight;
use crate::judge::master::rows::Row;
use crate::judge::master::scenario::{Course, SLOT, Scenario};
use crate::judge::master::second::{Evidence, Second, Surroundings};
use crate::judge::moment::{Moment, Side};
use crate::profibus::fdl::Address;
use crate::time::{Instant, SYN_BITS};

/// So long a master may be without the token when another one leaves the ring.
const SLOTS_AWAY: u32 = 8;

impl Judge {
    /// The address of the second master that is on the line, or was last.
    pub(in crate::judge) const fn second_address(&self) -> Option<Address> {
        self.second_at
    }

    /// Whether a second master is on the line.
    pub(in crate::judge) const fn has_second(&self) -> bool {
        self.second.is_some()
    }

    /// When to call [`Judge::speak`] although nothing was heard; not while somebody sends.
    pub(in crate::judge) fn second_due(&self) -> Option<Instant> {
        self.second.as_ref()?.poll_timeout()
    }

    /// What the second master sends now. Whoever sends it tells the judge by [`Judge::hear`].
    pub(in crate::judge) fn speak(&mut self, now: Instant) -> Option<Vec<u8>> {
        let second = self.second.as_mut()?;
        second.handle_timeout(now);
        let octets = second.poll_transmit(now);
        self.take_evidence();
        octets
    }

    pub(super) fn second_hears(&mut self, moment: &Moment) {
        let Some(second) = &mut self.second else { return };
        match moment.side {
            Side::Master => second.hear_master(moment.end, &moment.octets),
            Side::Other(_) => second.sent(moment.end),
            Side::Station(_) => second.hear_station(moment.end, &moment.octets),
        }
        self.take_evidence();
        self.judge_reading();
    }

    /// Goes on to the next scenario that can be played with what is known of the master by now.
    pub(super) fn skip_impossible(&mut self) {
        while let Some(scenario) = self.scenarios.get(self.next)
            && let Some(course) = scenario.course()
            && let Err(reason) = self.surroundings(course, scenario)
        {
            for row in &scenario.rows {
                self.observer.findings.default_obstacle(*row, reason);
            }
            self.next += 1;
        }
    }

    pub(super) fn begin_second(&mut self, scenario: usize, step: usize) {
        let Some(played) = self.scenarios.get(scenario) else { return };
        let Some(course) = played.steps.get(step).and_then(|step| step.second) else { return };
        let Ok(line) = self.surroundings(course, played) else { return };
        self.observer.begin_ring();
        self.second_at = Some(line.own);
        self.second = Some(Second::new(course, line, &self.observer.setup));
    }

    pub(super) fn is_second_done(&self) -> bool {
        self.second.as_ref().is_none_or(|second| second.is_over() || second.is_settled())
    }

    pub(super) fn end_second(&mut self) {
        let Some(second) = &mut self.second else { return };
        second.end();
        let stays = second.is_owner();
        self.take_evidence();
        if stays {
            return;
        }
        self.second = None;
        self.observer.end_ring();
    }

    /// What a second master must know of the line, or why there can be none.
    fn surroundings(&self, course: Course, scenario: &Scenario) -> Result<Surroundings, &'static str> {
        let setup = &self.observer.setup;
        let master = self.observer.ring_master().ok_or("needs a master that passes the token")?;
        let (own, stranger) =
            self.observer.free_addresses().ok_or("needs a free address in the GAP of the master")?;
        let rate = match self.observer.sight() {
            Sight::Exact(rate) => Some(rate),
            Sight::Untimed | Sight::Recorded => None,
        };
        let line = Surroundings {
            own,
            master,
            slave: scenario.subject(setup).ok_or("needs a station that is present")?.address,
            stranger,
            slot: setup.slot.unwrap_or(SLOT),
            pause: rate.map_or(Duration::ZERO, |rate| rate.bit_times(SYN_BITS + 2)),
            ttr: setup.ttr,
            exact: rate.is_some(),
        };
        // A master that is silent for longer counts as gone.
        let is_soon = line.time_out() * 3 < SILENCE * 2;
        if stranger == own && matches!(course, Course::Third | Course::Strange) {
            return Err("needs two free addresses");
        }
        if is_soon || course != Course::LeavesWithToken {
            Ok(line)
        } else {
            Err("the master waits for longer than 6.7 s, its T_TO, until it claims the token")
        }
    }

    fn take_evidence(&mut self) {
        while let Some(evidence) = self.second.as_mut().and_then(Second::poll_evidence) {
            match evidence {
                Evidence::Held(row) => self.observer.findings.held(row),
                Evidence::Broken(row, weight, reason) => self.observer.show(row, weight, reason),
                Evidence::Missed(row, reason) => self.observer.findings.missed(row, reason),
                Evidence::NoOccasion(row, reason) => self.observer.findings.obstacle(row, reason),
            }
        }
    }

    /// What the second master reads of a slave does not concern the master.
    fn judge_reading(&mut self) {
        let is_read = |second: &&Second| second.has_read() && !self.observer.setup.is_class_2();
        let Some(slave) = self.second.as_ref().filter(is_read).map(Second::slave) else { return };
        self.has_read = true;
        if self.is_started_anew(slave) {
            self.break_reading(slave);
        }
    }

    /// Data are exchanged again behind it. A start-up of several rotations may end only now.
    pub(super) fn judge_after_reading(&mut self, slave: Address) {
        if !core::mem::take(&mut self.has_read) {
            return;
        }
        let setup = &self.observer.setup;
        let watchdogs = self.observer.watchdogs();
        let expires = watchdogs.iter().any(|(_, time)| *time < setup.slot.unwrap_or(SLOT) * SLOTS_AWAY);
        match (self.is_started_anew(slave), self.observer.sight()) {
            (false, _) => self.observer.findings.held(Row::R09),
            (true, Sight::Exact(_)) if !expires => self.break_reading(slave),
            (true, _) => {
                let reason =
                    format!("station {slave} was started anew when the second master had left the ring");
                self.observer.findings.missed(Row::R09, reason);
            }
        }
    }

    fn is_started_anew(&self, slave: Address) -> bool {
        let before = self.before.get(&slave.number()).copied().unwrap_or_default();
        self.counts(slave).start_ups != before.start_ups
    }

    fn break_reading(&mut self, slave: Address) {
        if !self.observer.findings.has_failed(Row::R09) {
            let reason = format!(
                "station {slave} is started anew after another master has read its diagnosis and inputs"
            );
            self.observer.show(Row::R09, Weight::Once, reason);
        }
    }
}
