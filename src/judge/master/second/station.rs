//! The station of the data link layer that the judge plays as a second master.
//!
//! ```text
//! Listening ─▶ Ready ─▶ InRing ◀──▶ Working ─▶ Passing ─▶ InRing …
//!                          │           ├──▶ Silent (it keeps the token)
//!                          │           └──▶ Strange, Doubled (somebody else's name)
//!                          └──▶ Ignoring (it no longer takes the token) ─▶ Over
//! ```

use core::time::Duration;
use std::collections::VecDeque;

use super::course::{Course, Duty};
use super::evidence::Evidence;
use super::owner::Owned;
use super::telegrams;
use crate::judge::master::findings::Weight;
use crate::judge::master::rows::Row;
use crate::judge::master::setup::Setup;
use crate::profibus::fdl::{Address, StationType};
use crate::time::Instant;

/// A token is passed so often at most.
pub(super) const ATTEMPTS: u32 = 3;

/// What a second master must know of the line.
#[derive(Clone, Copy, Debug)]
pub(in crate::judge) struct Surroundings {
    /// The address it has.
    pub(in crate::judge) own: Address,
    /// The master under test.
    pub(in crate::judge) master: Address,
    /// The slave it reads.
    pub(in crate::judge) slave: Address,
    /// A station that is not in the ring, or the third master.
    pub(in crate::judge) stranger: Address,
    /// T_SL.
    pub(in crate::judge) slot: Duration,
    /// Idle line before a request, and before a reply; zero where the link has no true timing.
    pub(in crate::judge) pause: Duration,
    /// T_TR, if it is known.
    pub(in crate::judge) ttr: Option<Duration>,
    /// Times are those of the line.
    pub(in crate::judge) exact: bool,
}

impl Surroundings {
    /// T_TO of the master under test: after so much silence it claims the token.
    pub(in crate::judge) fn time_out(&self) -> Duration {
        self.slot * (6 + 2 * u32::from(self.master.number()))
    }
}

/// A master on the line that the judge plays.
#[derive(Debug)]
pub(in crate::judge) struct Second {
    pub(super) line: Surroundings,
    pub(super) course: Course,
    duties: VecDeque<Duty>,
    /// Its slaves, which of them is asked, and how many tokens it has had for them.
    pub(super) owned: Vec<Owned>,
    pub(super) serving: Option<usize>,
    rounds: u32,
    pub(super) state: State,
    /// What it still does with the token.
    work: VecDeque<Work>,
    /// What it sends next, and not before.
    next: Option<(Instant, Vec<u8>)>,
    /// Until the end of what it sends is known.
    sending: bool,
    /// The token has come, and nothing was sent since: the end of that telegram.
    pub(super) taken: Option<Instant>,
    /// The judge itself was late: nothing is concluded until the next token.
    pub(super) shaky: bool,
    pub(super) evidence: VecDeque<Evidence>,
    /// It has read something of a slave.
    has_read: bool,
    /// Requests of the master under test since it got a token too late.
    pub(super) late_cycles: Option<u32>,
    pub(super) last_request: Vec<u8>,
    /// Requests for FDL status that got no answer, in a row.
    pub(super) unanswered: u32,
}

/// Where it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum State {
    /// Not in the ring: it waits for an FDL status request. Tokens that the master has passed since it said 'not ready'.
    Listening {
        refused: Option<u32>,
    },
    /// It has said that it is ready, so often, and the master has passed so many tokens to others since.
    Ready {
        asked: u32,
        tokens: u32,
    },
    /// In the ring without the token.
    InRing,
    /// It has the token, and sends or is about to.
    Working,
    /// It waits for a reply.
    Asking {
        whom: Address,
        until: Instant,
    },
    /// It has passed the token.
    Passing {
        attempt: u32,
        until: Instant,
    },
    /// It has passed the token in the name of a stranger.
    Strange {
        attempt: u32,
        until: Instant,
    },
    /// It has passed the token behind telegrams in the name of the master.
    Doubled {
        until: Instant,
    },
    /// It has the token and says nothing.
    Silent {
        since: Instant,
        until: Instant,
    },
    /// It takes no token: so many came.
    Ignoring {
        tokens: u32,
        until: Instant,
    },
    /// It passes the token to itself, so often by now, and asks the master between.
    Running {
        rounds: u32,
        asks: bool,
        until: Option<Instant>,
    },
    Over,
}

/// One thing that is done with the token.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Work {
    AskMaster,
    ReadDiagnosis,
    ReadInputs,
    /// Asks this one of its slaves.
    Serve(usize),
    /// Asks until then.
    HoldUntil(Instant),
    SendAsMaster,
    Pass,
    PassToThird,
    AskAsThird,
    PassAsStranger,
    PassAsDouble,
    Keep,
}

impl Second {
    pub(in crate::judge) fn new(course: Course, line: Surroundings, setup: &Setup) -> Self {
        let state = match course {
            Course::Runs => State::Running { rounds: 0, asks: false, until: None },
            Course::Works
            | Course::Third
            | Course::LeavesWithToken
            | Course::Listens
            | Course::Strange
            | Course::Slow
            | Course::Owns
            | Course::Double => State::Listening { refused: None },
        };
        Self {
            line,
            course,
            duties: course.duties().iter().copied().collect(),
            owned: setup.present().filter(|_| course == Course::Owns).map(Owned::new).collect(),
            serving: None,
            rounds: 0,
            state,
            work: VecDeque::new(),
            next: None,
            sending: false,
            taken: None,
            shaky: false,
            evidence: VecDeque::new(),
            has_read: false,
            late_cycles: None,
            last_request: Vec::new(),
            unanswered: 0,
        }
    }

    /// Whether it has done everything.
    pub(in crate::judge) fn is_over(&self) -> bool {
        self.state == State::Over && self.next.is_none() && !self.sending
    }

    /// Whether it is the master of class 1 that owns the slaves, which stays.
    pub(in crate::judge) fn is_owner(&self) -> bool {
        self.course == Course::Owns
    }

    /// Whether that one has exchanged data with each of them.
    pub(in crate::judge) fn is_settled(&self) -> bool {
        self.is_owner() && self.owned.iter().all(|owned| owned.exchanges >= SETTLED)
    }

    /// The slave it reads.
    pub(in crate::judge) const fn slave(&self) -> Address {
        self.line.slave
    }

    /// Whether it has read something of a slave.
    pub(in crate::judge) const fn has_read(&self) -> bool {
        self.has_read
    }

    /// The judge could not look at the line for a while.
    pub(in crate::judge) const fn paused(&mut self) {
        self.shaky = true;
    }

    /// Whether it waits for others, and sends nothing itself.
    pub(super) const fn is_waiting(&self) -> bool {
        !self.sending && self.next.is_none()
    }

    /// Whether it still has the token, which it passes next.
    pub(super) const fn is_about_to_pass(&self) -> bool {
        let first = match self.state {
            State::Passing { attempt, .. } | State::Strange { attempt, .. } => attempt == 1,
            State::Doubled { .. } => true,
            State::Listening { .. }
            | State::Ready { .. }
            | State::InRing
            | State::Working
            | State::Asking { .. }
            | State::Silent { .. }
            | State::Ignoring { .. }
            | State::Running { .. }
            | State::Over => false,
        };
        first && !self.is_waiting()
    }

    /// What it was about to repeat is no longer sent.
    pub(super) fn forget(&mut self) {
        self.next = None;
    }

    /// What it has seen.
    pub(in crate::judge) fn poll_evidence(&mut self) -> Option<Evidence> {
        self.evidence.pop_front()
    }

    /// What it sends now. It has sent it when it hears it ([`Second::sent`]).
    pub(in crate::judge) fn poll_transmit(&mut self, now: Instant) -> Option<Vec<u8>> {
        if self.sending || self.next.as_ref().is_none_or(|(due, _)| *due > now) {
            return None;
        }
        let (_, octets) = self.next.take()?;
        self.sending = true;
        Some(octets)
    }

    /// When to call [`Second::handle_timeout`] and [`Second::poll_transmit`].
    pub(in crate::judge) fn poll_timeout(&self) -> Option<Instant> {
        if self.sending {
            return None;
        }
        if let Some((due, _)) = &self.next {
            return Some(*due);
        }
        match self.state {
            State::Listening { .. } | State::Ready { .. } | State::InRing | State::Working | State::Over => {
                None
            }
            State::Asking { until, .. }
            | State::Passing { until, .. }
            | State::Strange { until, .. }
            | State::Doubled { until }
            | State::Silent { until, .. }
            | State::Ignoring { until, .. } => Some(until),
            State::Running { until, .. } => until,
        }
    }

    /// What it has sent has ended.
    pub(in crate::judge) fn sent(&mut self, end: Instant) {
        self.sending = false;
        if let Some(taken) = self.taken.take() {
            // The master may have passed the token again meanwhile, and is right.
            self.shaky |= end.saturating_since(taken) * 2 > self.line.slot && !self.line.exact;
        }
        let until = end + self.line.slot;
        match self.state {
            State::Asking { whom, .. } => self.state = State::Asking { whom, until },
            State::Passing { attempt, .. } => self.state = State::Passing { attempt, until },
            State::Strange { attempt, .. } => self.state = State::Strange { attempt, until },
            State::Doubled { .. } => self.state = State::Doubled { until: end + self.line.slot * 2 },
            State::Running { rounds, asks: false, .. } => {
                self.state = State::Running { rounds, asks: true, until: None };
                self.send(end, telegrams::status_request(self.line.master, self.line.own));
            }
            State::Running { rounds, asks: true, .. } => {
                self.state = State::Running { rounds, asks: true, until: Some(until) };
            }
            State::Working => self.go_on(end),
            State::Listening { .. }
            | State::Ready { .. }
            | State::InRing
            | State::Silent { .. }
            | State::Ignoring { .. }
            | State::Over => {}
        }
    }

    /// The token has come.
    pub(super) fn take_token(&mut self, now: Instant) {
        self.shaky = false;
        self.taken = Some(now);
        let endless = self.is_owner().then_some(Duty::Exchange);
        let Some(duty) = self.duties.pop_front().or(endless) else {
            self.state = State::Over;
            return;
        };
        self.work = match duty {
            Duty::AskMaster => [Work::AskMaster, Work::Pass].into(),
            Duty::Exchange => self.serve(),
            Duty::ReadDiagnosis => [Work::ReadDiagnosis, Work::Pass].into(),
            Duty::ReadInputs => [Work::ReadInputs, Work::Pass].into(),
            Duty::Hold => {
                let lasts = self.line.ttr.unwrap_or_default() * 2;
                [Work::HoldUntil(now + lasts), Work::Pass].into()
            }
            Duty::PassOn => {
                [Work::AskMaster, Work::PassToThird, Work::AskAsThird, Work::PassAsStranger].into()
            }
            Duty::PassAsStranger => [Work::AskMaster, Work::PassAsStranger].into(),
            Duty::SendAsMaster => {
                [Work::AskMaster, Work::SendAsMaster, Work::SendAsMaster, Work::PassAsDouble].into()
            }
            Duty::Keep => [Work::AskMaster, Work::Keep].into(),
            Duty::Ignore => {
                self.taken = None;
                let until = now + self.patience();
                self.state = State::Ignoring { tokens: 1, until };
                return;
            }
        };
        self.go_on(now);
    }

    /// Each of its slaves once, and now and then the master under test.
    fn serve(&mut self) -> VecDeque<Work> {
        if self.is_settled() {
            self.held(Row::R09);
        }
        self.rounds += 1;
        let asks = self.rounds.is_multiple_of(ASKS).then_some(Work::AskMaster);
        (0..self.owned.len()).map(Work::Serve).chain(asks).chain([Work::Pass]).collect()
    }

    /// A slave that it owns has answered, or has not.
    pub(super) fn served(&mut self, octets: &[u8]) {
        let served = self.serving.take().and_then(|number| self.owned.get_mut(number));
        if let Some(owned) = served
            && owned.answered(octets)
        {
            let reason = format!(
                "data exchange of the master of class 1 with station {} has ended: it answers with RS",
                owned.address
            );
            self.evidence.push_back(Evidence::Broken(Row::R09, Weight::Once, reason));
        }
    }

    /// How long a master may say nothing before it is stuck.
    pub(super) fn patience(&self) -> Duration {
        (self.line.time_out() * 2).max(Duration::from_secs(1))
    }

    /// The next thing to be done with the token.
    pub(super) fn go_on(&mut self, now: Instant) {
        let Surroundings { own, master, slave, stranger, .. } = self.line;
        self.state = State::Working;
        let Some(work) = self.work.pop_front() else { return };
        let until = now;
        let octets = match work {
            Work::AskMaster => {
                self.state = State::Asking { whom: master, until };
                telegrams::status_request(master, own)
            }
            Work::ReadDiagnosis => {
                self.has_read = true;
                self.state = State::Asking { whom: slave, until };
                telegrams::slave_diag(slave, own)
            }
            Work::ReadInputs => {
                self.has_read = true;
                self.state = State::Asking { whom: slave, until };
                telegrams::rd_inp(slave, own)
            }
            Work::Serve(number) => {
                let Some(owned) = self.owned.get(number) else { return self.go_on(now) };
                self.serving = Some(number);
                self.state = State::Asking { whom: owned.address, until };
                owned.request(own)
            }
            Work::HoldUntil(end) if now < end => {
                self.work.push_front(work);
                self.state = State::Asking { whom: master, until };
                telegrams::status_request(master, own)
            }
            Work::HoldUntil(_) => {
                self.late_cycles = Some(0);
                return self.go_on(now);
            }
            Work::PassToThird => telegrams::token(stranger, own),
            Work::AskAsThird => {
                self.state = State::Asking { whom: master, until };
                telegrams::status_request(master, stranger)
            }
            Work::SendAsMaster => telegrams::token(own, master),
            Work::Pass => {
                self.state = State::Passing { attempt: 1, until };
                telegrams::token(master, own)
            }
            Work::PassAsStranger => {
                self.state = State::Strange { attempt: 1, until };
                telegrams::token(master, stranger)
            }
            Work::PassAsDouble => {
                self.state = State::Doubled { until };
                telegrams::token(master, own)
            }
            Work::Keep => {
                let until = now + (self.line.time_out() * 10).min(LONGEST_SILENCE);
                self.state = State::Silent { since: now, until };
                return;
            }
        };
        self.send(now, octets);
    }

    /// Begins a ring of its own when the line is silent, before the master may claim the token.
    pub(super) fn begin_ring(&mut self, now: Instant) {
        self.state = State::Running { rounds: 0, asks: false, until: Some(now + self.line.slot * 4) };
    }

    /// The token to itself.
    pub(super) fn go_round(&mut self, now: Instant, rounds: u32) {
        self.state = State::Running { rounds, asks: false, until: None };
        self.send(now, telegrams::token(self.line.own, self.line.own));
    }

    /// The master is let into the ring.
    pub(super) fn let_in(&mut self, now: Instant) {
        self.state = State::Passing { attempt: 1, until: now };
        self.repeat_token(now, self.line.own);
    }

    /// Passes the token to the master, and leaves the ring.
    pub(super) fn give_back(&mut self, now: Instant) {
        self.state = State::Over;
        self.send(now, telegrams::token(self.line.master, self.line.own));
    }

    pub(super) fn repeat_token(&mut self, now: Instant, sa: Address) {
        self.send(now, telegrams::token(self.line.master, sa));
    }

    pub(super) fn send(&mut self, now: Instant, octets: Vec<u8>) {
        self.next = Some((now + self.line.pause, octets));
    }

    /// Answers an FDL status request of the master.
    pub(super) fn answer(&mut self, now: Instant, state: StationType) {
        let octets = telegrams::status_response(self.line.master, self.line.own, state);
        // A reply may come after 11 T_bit.
        self.next = Some((now + self.line.pause / 2, octets));
    }

    pub(super) fn held(&mut self, row: Row) {
        self.evidence.push_back(Evidence::Held(row));
    }
}

/// So many exchanges with each slave, and the master of class 1 works.
const SETTLED: u32 = 10;
/// It asks the master under test with every so many tokens.
const ASKS: u32 = 8;
/// So long it keeps the token at most.
const LONGEST_SILENCE: Duration = Duration::from_secs(8);
