//! What the second master makes of telegrams and of silence.

use super::course::Course;
use super::evidence::Evidence;
use super::station::{ATTEMPTS, Second, State};
use crate::judge::master::findings::Weight;
use crate::judge::master::rows::Row;
use crate::profibus::fdl::telegram::{Decoded, decode};
use crate::profibus::fdl::{DataTelegram, Function, Service, StationType, Telegram};
use crate::time::Instant;

/// More tokens than this to a station that takes none: the master is stuck.
const MOST_TOKENS: u32 = 8;
/// So many tokens to others prove that a station that is ready gets none, and that one that is not ready gets none.
const PASSED_OVER: u32 = 25;
const NOT_READY_TOKENS: u32 = 4;
/// So many rotations a master hears before it is ready, and more than so many it does not need.
const ROTATIONS: u32 = 2;
const MOST_ROUNDS: u32 = 40;

impl Second {
    /// A telegram of the master under test that ended now.
    pub(in crate::judge) fn hear_master(&mut self, now: Instant, octets: &[u8]) {
        let Decoded::Telegram { telegram, .. } = decode(octets) else { return };
        match telegram {
            Telegram::Token { da, .. } if da == self.line.own => self.token_for_us(now),
            Telegram::Token { .. } => {
                self.count_late(None);
                self.token_for_others(now);
            }
            Telegram::ShortAcknowledge => {}
            Telegram::Data(data) => match data.fc.function() {
                Function::Request(Service::FdlStatus, _) if data.da == self.line.own => self.asked(now),
                Function::Request(kind, _) => {
                    self.count_late((kind != Service::FdlStatus).then_some(octets));
                    self.master_works(now);
                }
                Function::Response(kind, _) => self.master_answers(now, kind, &data),
                Function::Reserved => {}
            },
        }
    }

    /// A telegram of a station that ended now.
    pub(in crate::judge) fn hear_station(&mut self, now: Instant, octets: &[u8]) {
        if matches!(self.state, State::Asking { whom, .. } if whom != self.line.master) {
            self.served(octets);
            self.go_on(now);
        }
    }

    /// Nothing was heard until now.
    pub(in crate::judge) fn handle_timeout(&mut self, now: Instant) {
        if matches!(self.state, State::Running { rounds: 0, until: None, .. }) && self.is_waiting() {
            return self.begin_ring(now);
        }
        if !self.is_waiting() || self.poll_timeout().is_none_or(|due| due > now) {
            return;
        }
        match self.state {
            State::Asking { whom, .. } if whom == self.line.master => {
                self.unanswered += 1;
                let reason = "an FDL status request by another master that has the token gets no answer";
                self.broken(Row::R01, Weight::Times(2), reason);
                self.go_on(now);
            }
            State::Asking { .. } => {
                self.served(&[]);
                self.go_on(now);
            }
            State::Passing { attempt, .. } if attempt < ATTEMPTS => {
                self.state = State::Passing { attempt: attempt + 1, until: now };
                self.repeat_token(now, self.line.own);
            }
            // The master may be off for a while, and asks again.
            State::Passing { .. } if self.is_owner() => self.state = State::Listening { refused: None },
            State::Passing { .. } => {
                let row = self.course.row();
                let reason = "the master did not take the token back from the second master";
                self.evidence.push_back(Evidence::Missed(row, reason.into()));
                self.state = State::Over;
            }
            State::Strange { attempt: 1, .. } => {
                self.state = State::Strange { attempt: 2, until: now };
                self.repeat_token(now, self.line.stranger);
            }
            State::Strange { .. } => {
                // Taken or not: with its own name it goes on.
                self.state = State::Passing { attempt: 1, until: now };
                self.repeat_token(now, self.line.own);
            }
            State::Doubled { .. } => {
                self.held(Row::R06);
                self.state = State::Over;
            }
            State::Running { rounds, .. } if rounds >= MOST_ROUNDS => {
                let reason = format!("the master did not say that it is ready in {rounds} rotations");
                self.evidence.push_back(Evidence::Missed(Row::R10, reason));
                self.state = State::Over;
            }
            State::Running { rounds, .. } => self.go_round(now, rounds + 1),
            State::Silent { since, until } => {
                let reason = format!(
                    "{} ms after the last telegram nobody has claimed the token; T_TO is {} ms",
                    until.saturating_since(since).as_millis(),
                    self.line.time_out().as_millis()
                );
                self.broken(Row::R07, Weight::Once, &reason);
                self.give_back(now);
            }
            State::Ignoring { tokens, .. } => {
                let reason =
                    format!("the master says nothing more after {tokens} tokens that were not taken");
                self.broken(Row::R04, Weight::Once, &reason);
                self.give_back(now);
            }
            State::Listening { .. } | State::Ready { .. } | State::InRing | State::Working | State::Over => {}
        }
    }

    /// Its time is over: what was not seen.
    pub(in crate::judge) fn end(&mut self) {
        if self.is_settled() {
            return;
        }
        let (row, own) = (self.course.row(), self.line.own);
        let reason = match self.state {
            State::Over => return,
            State::Listening { refused: None } => None,
            State::Ready { tokens, .. } if tokens >= PASSED_OVER => return self.passed_over(tokens),
            State::Listening { .. }
            | State::Ready { .. }
            | State::InRing
            | State::Working
            | State::Asking { .. }
            | State::Passing { .. }
            | State::Strange { .. }
            | State::Doubled { .. }
            | State::Silent { .. }
            | State::Running { .. }
            | State::Ignoring { .. } => Some("the time was over before the second master was done"),
        };
        let rows: &[Row] = match self.course {
            Course::Works => &[Row::R01, Row::R02, Row::R03, Row::R04, Row::R09],
            Course::Owns => &[Row::R01, Row::R02, Row::R03, Row::R09],
            Course::Runs
            | Course::Third
            | Course::LeavesWithToken
            | Course::Listens
            | Course::Strange
            | Course::Slow
            | Course::Double => &[row],
        };
        self.evidence.extend(rows.iter().map(|row| match reason {
            Some(reason) => Evidence::Missed(*row, reason.into()),
            None => {
                let reason =
                    format!("the master did not ask address {own} of its GAP in the time of the scenario");
                Evidence::NoOccasion(*row, reason)
            }
        }));
    }

    fn passed_over(&mut self, tokens: u32) {
        let reason = format!(
            "address {} said that it is a master and ready, and {tokens} tokens went to others since",
            self.line.own
        );
        self.broken(Row::R02, Weight::Once, &reason);
        self.state = State::Over;
    }

    fn token_for_us(&mut self, now: Instant) {
        self.count_late(None);
        match self.state {
            State::Ready { .. } => {
                self.held(Row::R02);
                self.take_token(now);
            }
            State::InRing => self.take_token(now),
            // With the token goes all that was still to be waited for.
            State::Passing { .. } => {
                self.held(Row::R03);
                self.take_token(now);
            }
            State::Strange { attempt, .. } => {
                self.judge_stranger(attempt);
                self.take_token(now);
            }
            State::Doubled { .. } => {
                self.doubled_goes_on();
            }
            State::Ignoring { tokens, .. } if tokens >= MOST_TOKENS => {
                let reason = format!("{tokens} tokens in a row to a station that does not take them");
                self.broken(Row::R04, Weight::Once, &reason);
                self.state = State::Over;
            }
            State::Ignoring { tokens, .. } => {
                let until = now + self.patience();
                self.state = State::Ignoring { tokens: tokens + 1, until };
            }
            State::Silent { since, .. } => self.judge_claim(now, since),
            // The judge was late, and the master passes it again.
            State::Running { .. } => self.master_works(now),
            State::Working | State::Asking { .. } => self.shaky = true,
            // That it gets a token at all the observer judges (K02).
            State::Listening { .. } | State::Over => {}
        }
    }

    fn token_for_others(&mut self, now: Instant) {
        match self.state {
            State::Listening { refused: Some(tokens) } if tokens >= NOT_READY_TOKENS => {
                self.state = State::Over
            }
            State::Listening { refused: Some(tokens) } => {
                self.state = State::Listening { refused: Some(tokens + 1) };
            }
            State::Ready { tokens, .. } if tokens >= PASSED_OVER => self.passed_over(tokens),
            State::Ready { asked, tokens } => self.state = State::Ready { asked, tokens: tokens + 1 },
            State::Listening { refused: None }
            | State::InRing
            | State::Working
            | State::Asking { .. }
            | State::Passing { .. }
            | State::Strange { .. }
            | State::Doubled { .. }
            | State::Silent { .. }
            | State::Running { .. }
            | State::Ignoring { .. }
            | State::Over => self.master_works(now),
        }
    }

    /// The master asks for the FDL status of this station.
    fn asked(&mut self, now: Instant) {
        match self.state {
            State::Listening { .. } if self.course == Course::Listens => {
                self.state = State::Listening { refused: Some(0) };
                self.answer(now, StationType::MasterNotReady);
            }
            State::Listening { .. } => {
                self.state = State::Ready { asked: 1, tokens: 0 };
                self.answer(now, StationType::MasterReady);
            }
            State::Ready { asked, tokens } => {
                if asked > 1 {
                    let reason =
                        "a station that says that it is a master and ready is asked again, and gets no token";
                    self.broken(Row::R02, Weight::Times(2), reason);
                }
                self.state = State::Ready { asked: asked + 1, tokens };
                self.answer(now, StationType::MasterReady);
            }
            State::InRing => self.answer(now, StationType::MasterInRing),
            State::Working
            | State::Asking { .. }
            | State::Passing { .. }
            | State::Strange { .. }
            | State::Doubled { .. }
            | State::Running { .. }
            | State::Silent { .. } => self.master_works(now),
            State::Ignoring { .. } | State::Over => {}
        }
    }

    /// The master sends what only the holder of the token sends.
    fn master_works(&mut self, now: Instant) {
        if self.is_about_to_pass() {
            return self.intruded();
        }
        match self.state {
            // What was sent before it was switched off.
            State::Running { rounds: 0, .. } => self.begin_ring(now),
            State::Running { .. } => self.intruded(),
            State::Working | State::Asking { .. } => self.intruded(),
            State::Passing { .. } => {
                self.held(Row::R03);
                self.forget();
                self.state = State::InRing;
            }
            State::Strange { attempt, .. } => {
                self.judge_stranger(attempt);
                self.forget();
                self.state = State::InRing;
            }
            State::Doubled { .. } => self.doubled_goes_on(),
            State::Silent { since, .. } => self.judge_claim(now, since),
            State::Ignoring { tokens, .. } => {
                if tokens > 1 {
                    self.held(Row::R04);
                } else {
                    let reason = "a token that was not taken is passed only once";
                    self.broken(Row::R04, Weight::Once, reason);
                }
                self.state = State::Over;
            }
            State::Listening { .. } | State::Ready { .. } | State::InRing | State::Over => {}
        }
    }

    /// The master sends without the token.
    fn intruded(&mut self) {
        let reason = "a telegram of the master while another master has the token";
        let weight = if self.line.exact { Weight::Once } else { Weight::Times(2) };
        self.broken(Row::R03, weight, reason);
        // What follows until the next token says nothing more.
        self.shaky = true;
    }

    fn master_answers(&mut self, now: Instant, kind: StationType, data: &DataTelegram<'_>) {
        if let State::Running { rounds, .. } = self.state {
            return self.newcomer_answers(now, kind, rounds);
        }
        let asked = matches!(self.state, State::Asking { whom, .. } if whom == self.line.master);
        if !asked || (data.da != self.line.own && data.da != self.line.stranger) {
            return;
        }
        self.unanswered = 0;
        match kind {
            StationType::Slave => {
                let reason = "the master answers an FDL status request as a slave";
                self.broken(Row::R01, Weight::Once, reason);
            }
            StationType::MasterNotReady | StationType::MasterReady | StationType::MasterInRing => {
                self.held(Row::R01);
            }
        }
        self.go_on(now);
    }

    /// A master that was switched on while the ring ran.
    fn newcomer_answers(&mut self, now: Instant, kind: StationType, rounds: u32) {
        match kind {
            StationType::Slave | StationType::MasterNotReady => {
                self.state = State::Running { rounds, asks: true, until: Some(now) };
            }
            StationType::MasterReady | StationType::MasterInRing => {
                if rounds >= ROTATIONS {
                    self.held(Row::R10);
                } else {
                    let reason =
                        format!("the master says that it is ready after {rounds} rotations of the token");
                    self.broken(Row::R10, Weight::Once, &reason);
                }
                self.let_in(now);
            }
        }
    }

    fn judge_stranger(&mut self, attempt: u32) {
        if self.course == Course::Third {
            // From the second time on it is known.
            self.held(Row::R03);
        } else if attempt > 1 {
            self.held(Row::R05);
        } else {
            let reason =
                format!("the token of {}, which is not in the ring, is taken at once", self.line.stranger);
            self.broken(Row::R05, Weight::Once, &reason);
        }
    }

    fn doubled_goes_on(&mut self) {
        let reason = "two telegrams had the address of the master as SA, and it stays in the ring";
        self.broken(Row::R06, Weight::Once, reason);
        self.state = State::Over;
    }

    /// The master speaks after silence.
    fn judge_claim(&mut self, now: Instant, since: Instant) {
        let (waited, least) = (now.saturating_since(since), self.line.time_out());
        if self.line.exact && waited * 10 < least * 9 {
            let reason = format!(
                "a telegram of the master {} us after the last one of the master that has the token; T_TO is {} us",
                waited.as_micros(),
                least.as_micros()
            );
            self.broken(Row::R07, Weight::Once, &reason);
        } else {
            self.held(Row::R07);
        }
        self.state = State::Over;
    }

    /// A token that came too late: one cycle, retries apart. `None`: the master passes the token.
    fn count_late(&mut self, request: Option<&[u8]>) {
        let Some(cycles) = self.late_cycles else { return };
        match request {
            Some(octets) if octets == self.last_request => {}
            Some(octets) => {
                self.last_request = octets.to_vec();
                self.late_cycles = Some(cycles + 1);
            }
            None if matches!(self.state, State::InRing | State::Passing { .. }) => {
                self.late_cycles = None;
                if cycles > 1 {
                    let reason = format!(
                        "{cycles} message cycles after a token that came later than the target rotation time"
                    );
                    self.broken(Row::R08, Weight::Once, &reason);
                } else {
                    self.held(Row::R08);
                }
            }
            None => {}
        }
    }

    fn broken(&mut self, row: Row, weight: Weight, reason: &str) {
        if !self.shaky {
            self.evidence.push_back(Evidence::Broken(row, weight, reason.into()));
        }
    }
}
