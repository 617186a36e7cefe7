//! A small correct DP-V0 master, and switches for its mistakes: what the judge must find and what it must not.
//!
//! Sans-I/O: on a [`bench::Line`](profidrive::bench::Line) in virtual time, or on any link with [`serve`].
//!
//! | file | holds |
//! | --- | --- |
//! | here | [`TestMaster`]: whose turn it is |
//! | `slave` | a slave as the master sees it |
//! | `requests` | what is sent |
//! | `replies` | what is made of replies |
//! | `acyclic` | the services of DP-V1 |
//! | `operator` | what a user asks of it |
//! | `ring` | the token, other masters, the GAP |
//! | `serve` | the master on a link |
//! | `habits` | what it can do otherwise, and rightly |
//! | `mistakes` | what it can do wrong |

#![allow(dead_code, reason = "each test program uses its part")]

use core::time::Duration;
use std::collections::VecDeque;

use profidrive::bench::Master;
use profidrive::profibus::fdl::telegram::{Decoded, decode};
use profidrive::profibus::fdl::{Address, MAX_TELEGRAM_LEN};
use profidrive::time::{BaudRate, Instant, SYN_BITS};

pub(crate) mod acyclic;
pub(crate) mod habits;
pub(crate) mod mistakes;
mod operator;
mod replies;
mod requests;
mod ring;
mod serve;
mod slave;

use acyclic::Uses;
use habits::Habit;
use mistakes::Mistake;
use ring::Ring;
pub(crate) use serve::serve;
use slave::{Slave, State};

/// A station as configured.
#[derive(Clone, Debug)]
pub(crate) struct Configured {
    pub(crate) address: u8,
    pub(crate) ident: u16,
    pub(crate) cfg: Vec<u8>,
    pub(crate) prm: Vec<u8>,
    pub(crate) groups: u8,
}

/// How the master is configured.
#[derive(Clone, Debug)]
pub(crate) struct Settings {
    pub(crate) address: u8,
    pub(crate) baud: BaudRate,
    pub(crate) slot: Duration,
    pub(crate) retries: u32,
    pub(crate) watchdog: Duration,
    /// Pause between two cycles.
    pub(crate) pause: Duration,
    /// It passes the token to itself and looks for stations in the GAP.
    pub(crate) token: bool,
    /// The highest address of the GAP, and how many rotations are between two polls.
    pub(crate) hsa: u8,
    pub(crate) gap_factor: u32,
    /// It is of class 2, and reads.
    pub(crate) class_2: bool,
    /// Data_Control_Time of Auto_Clear.
    pub(crate) auto_clear: Option<Duration>,
    /// T_TR; without it the token is held for a whole cycle.
    pub(crate) ttr: Option<Duration>,
    pub(crate) stations: Vec<Configured>,
    pub(crate) habits: Vec<Habit>,
    /// DP-V1, at every slave.
    pub(crate) uses: Uses,
}

/// The rate, unless another one is set.
pub(crate) const BAUD: BaudRate = BaudRate::K500;
/// A pause between two cycles with which as much time needs a third of the telegrams: for judgements of minutes.
pub(crate) const UNHURRIED: Duration = Duration::from_millis(8);

impl Settings {
    /// A master of stations with four octets each way.
    pub(crate) fn new(stations: &[u8], slot: Duration) -> Self {
        let configured = |address: &u8| Configured {
            address: *address,
            ident: 0x1234,
            cfg: vec![0x23, 0x13],
            prm: vec![0x01, 0x02],
            groups: 0x01,
        };
        Self {
            address: 2,
            baud: BAUD,
            slot,
            retries: 2,
            watchdog: Duration::from_millis(1000),
            pause: Duration::from_millis(2),
            token: false,
            hsa: 30,
            gap_factor: 5,
            class_2: false,
            auto_clear: None,
            ttr: None,
            stations: stations.iter().map(configured).collect(),
            habits: Vec::new(),
            uses: Uses::NOTHING,
        }
    }
}

/// The master.
#[derive(Debug)]
pub(crate) struct TestMaster {
    settings: Settings,
    mistake: Option<Mistake>,
    slaves: Vec<Slave>,
    /// Whose turn it is.
    turn: usize,
    /// Controls to be sent in this cycle: command and groups.
    controls: VecDeque<(u8, u8)>,
    cycles: u32,
    operate: bool,
    /// The user wants CLEAR.
    cleared: bool,
    /// It is in CLEAR because a station is not in data exchange.
    auto_cleared: bool,
    /// So many were not, at most.
    most_gone: usize,
    stop: Stop,
    /// Telegrams of the ring, to be sent before the next cycle.
    beside: VecDeque<Beside>,
    ring: Ring,
    common: bool,
    waits: Option<Wait>,
    /// The cycle and the turn before which it has rested last.
    rested: (u32, usize),
    /// Not before.
    next: Instant,
    now: Instant,
    heard: Vec<u8>,
    sent: u32,
    /// Telegrams beside the cycle.
    extras: u32,
    /// Octets since the last request that were no telegram.
    junk: usize,
    /// Replies with a wrong sum.
    errors: u32,
    pub(crate) dead: bool,
    sending: bool,
}

/// On the way to STOP.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stop {
    No,
    /// Outputs are zero for a cycle.
    Clearing,
    /// Each slave is let go.
    Releasing,
    Stopped,
}

/// A telegram of the ring.
#[derive(Clone, Copy, Debug)]
enum Beside {
    Claim,
    Token,
    Poll,
    Noise,
}

/// Clear_Data of Global_Control.
const CLEAR: u8 = 0x02;

#[derive(Clone, Copy, Debug)]
struct Wait {
    slave: usize,
    /// When the slot time is over; `None` while it is being sent.
    until: Option<Instant>,
}

impl TestMaster {
    pub(crate) fn new(settings: Settings, mistake: Option<Mistake>) -> Self {
        let left_out = |at: usize| mistake == Some(Mistake::FewStations) && at == 10;
        let served = settings.stations.iter().enumerate().filter(|(at, _)| !left_out(*at));
        let slave = |configured| Slave::new(configured, settings.uses, mistake);
        let slaves = served.map(|(_, configured)| slave(configured)).collect();
        let beside = if settings.token { vec![Beside::Claim, Beside::Claim] } else { Vec::new() };
        Self {
            next: match mistake {
                Some(Mistake::NoListening) => Instant::ZERO,
                _ => Instant::ZERO + settings.slot * (6 + 2 * u32::from(settings.address)),
            },
            now: Instant::ZERO,
            ring: Ring::new(settings.address),
            controls: if settings.class_2 { VecDeque::new() } else { VecDeque::from([(CLEAR, 0)]) },
            settings,
            mistake,
            slaves,
            turn: 0,
            cycles: 0,
            operate: false,
            cleared: false,
            auto_cleared: false,
            most_gone: 0,
            stop: Stop::No,
            beside: beside.into(),
            common: false,
            waits: None,
            rested: (0, 0),
            heard: Vec::new(),
            sent: 0,
            extras: 0,
            junk: 0,
            errors: 0,
            dead: false,
            sending: false,
        }
    }

    fn does(&self, mistake: Mistake) -> bool {
        self.mistake == Some(mistake)
    }

    /// Whether it makes this mistake, at 12 Mbit/s only.
    fn does_at_top(&self, mistake: Mistake) -> bool {
        self.does(mistake) && self.settings.baud == BaudRate::K12000
    }

    fn syn(&self) -> Duration {
        if self.does(Mistake::IdleOfTop) {
            return BaudRate::K12000.bit_times(SYN_BITS);
        }
        self.settings.baud.bit_times(SYN_BITS)
    }

    fn slot(&self) -> Duration {
        match self.mistake {
            Some(Mistake::DoesNotWait) => self.settings.slot / 100,
            Some(Mistake::ShortSlot) => self.settings.slot * 3 / 10,
            _ => self.settings.slot,
        }
    }

    /// Between two cycles.
    fn pause(&self) -> Duration {
        match self.mistake {
            Some(Mistake::TooFast) => self.syn(),
            Some(Mistake::Pauses) if self.cycles.is_multiple_of(100) => self.settings.watchdog * 11 / 10,
            _ => self.usual_pause(),
        }
    }

    fn address(&self) -> Address {
        Address::station(self.settings.address).unwrap()
    }

    /// The next telegram, if it is time for one.
    fn next_telegram(&mut self, now: Instant) -> Option<Vec<u8>> {
        self.now = now;
        let silent = self.dead || self.stop == Stop::Stopped;
        if silent || self.sending || self.waits.is_some() {
            return None;
        }
        if !self.has_token() {
            return self.without_token(now);
        }
        if now < self.next {
            return None;
        }
        self.ring.polling = false;
        if let Some(beside) = self.beside.pop_front() {
            return Some(self.of_ring(beside));
        }
        if self.is_too_late() {
            return Some(self.of_ring(Beside::Token));
        }
        if self.turn >= self.slaves.len() {
            self.end_cycle();
            self.judge_auto_clear(now);
            self.next = now + self.pause();
            return if self.cycles.is_multiple_of(7) { self.extra() } else { None };
        }
        if let Some((control, groups)) = self.controls.pop_front()
            && !self.does(Mistake::NoControl)
            && !self.does_at_top(Mistake::NoControlAtTop)
        {
            self.ring.used += 1;
            self.next = now
                + self.settings.baud.octet_times(13)
                + if self.does(Mistake::ShortAfterControl) {
                    self.syn()
                } else {
                    self.settings.baud.bit_times(self.settings.baud.max_tsdr_bits().into()).max(self.syn())
                }
                + self.settings.baud.bit_times(2);
            return Some(self.control(control, groups));
        }
        let turn = self.turn;
        if self.rests_before(turn) {
            self.next = now + self.usual_pause();
            return None;
        }
        let mistake = self.mistake;
        let slave = &mut self.slaves[turn];
        slave.turns += 1;
        let every = match mistake {
            Some(Mistake::Unequal) => 10,
            Some(Mistake::SkipsCycles) => 3,
            _ => 1,
        };
        let skipped = turn == 1 && !slave.turns.is_multiple_of(every);
        let skipped = skipped || slave.forgotten;
        if skipped || self.lets_pass(turn) {
            self.turn += 1;
            return self.next_telegram(now);
        }
        let octets = match self.slaves[turn].open.clone() {
            Some(open) => self.again(turn, open),
            None => self.first_of_habit(turn).unwrap_or_else(|| self.ask(turn)),
        };
        self.slaves[turn].open = Some(octets.clone());
        self.ring.used += 1;
        self.waits = Some(Wait { slave: turn, until: None });
        Some(octets)
    }

    fn end_cycle(&mut self) {
        self.turn = 0;
        self.cycles += 1;
        self.stop = match self.stop {
            Stop::No => Stop::No,
            Stop::Clearing if self.does(Mistake::NoRelease) => Stop::Stopped,
            Stop::Clearing => Stop::Releasing,
            Stop::Releasing | Stop::Stopped => Stop::Stopped,
        };
        let clear = self.cycles_of_clear();
        if self.cycles == clear && !self.cleared && self.stop == Stop::No {
            self.operate = true;
        }
        let each = self.cycles_of_control();
        if self.cycles >= each && self.cycles.is_multiple_of(each) && !self.settings.class_2 {
            let undo = if self.does(Mistake::UndoesSync) { 0x10 } else { 0 };
            let silent = !self.operate && self.does(Mistake::NoClearData);
            let again = self.cycles > clear && self.does(Mistake::AnnouncesOnce);
            if !silent && !again {
                self.controls.push_back((if self.operate { undo } else { CLEAR }, 0));
            }
        }
        if self.does(Mistake::Babbles) && self.cycles.is_multiple_of(100) {
            self.beside.extend([Beside::Noise, Beside::Noise]);
        }
        if self.settings.token && !self.does(Mistake::NeverPasses) {
            let every = if self.does(Mistake::AlwaysAsksGap) { 1 } else { self.settings.gap_factor };
            if self.cycles.is_multiple_of(every) && self.next_gap() {
                self.beside.push_back(Beside::Poll);
            }
            self.beside.push_back(Beside::Token);
        }
    }

    /// Auto_Clear: CLEAR while a station was not in data exchange for Data_Control_Time.
    fn judge_auto_clear(&mut self, now: Instant) {
        let Some(time) = self.settings.auto_clear else { return };
        let is_gone = |slave: &&Slave| now.saturating_since(slave.exchanged) > time;
        let gone = self.slaves.iter().filter(is_gone).count();
        self.most_gone = if gone == 0 { 0 } else { self.most_gone.max(gone) };
        let enough = gone == 0 || self.does(Mistake::OperatesWithOne) && gone < self.most_gone;
        if self.operate && gone > 0 && !self.auto_cleared {
            (self.operate, self.auto_cleared) = (false, true);
            self.controls.push_back((CLEAR, 0));
        } else if self.auto_cleared && enough && !self.operate {
            (self.operate, self.auto_cleared) = (true, gone > 0);
            self.controls.push_back((0, 0));
        } else if gone == 0 {
            self.auto_cleared = false;
        }
    }

    /// The same request again.
    fn again(&mut self, turn: usize, open: Vec<u8>) -> Vec<u8> {
        let slave = &mut self.slaves[turn];
        match self.mistake {
            Some(Mistake::RetryToggles) => {
                slave.count = slave.count.map(|bit| !bit);
                self.ask(turn)
            }
            Some(Mistake::RetryChanges) if slave.state == State::Exchange && !slave.wants_diag => {
                slave.output = slave.output.wrapping_add(1);
                self.ask(turn)
            }
            _ => open,
        }
    }

    /// How long it is silent after no reply.
    fn rest_after_loss(&self, turn: usize) -> Duration {
        let absent = self.slaves[turn].start_ups == 0 && !self.slaves[turn].operational;
        match self.mistake {
            Some(Mistake::SlowAfterLoss) => self.settings.slot * 40,
            Some(Mistake::SlowForAbsent) if absent => self.settings.slot * 40,
            Some(Mistake::SleepsForAbsent) if absent && self.slaves[turn].first_asks % 40 == 39 => {
                self.settings.watchdog * 11 / 10
            }
            _ => Duration::ZERO,
        }
    }

    /// The slot time is over.
    fn timed_out(&mut self, now: Instant) {
        let Some(Wait { slave: turn, .. }) = self.waits.take() else { return };
        let was_answered = self.slaves[turn].state == State::Exchange;
        self.dead |= was_answered && self.does(Mistake::DiesOnSilence);
        self.next = now + self.rest_after_loss(turn);
        let cut_off = self.heard.first() == Some(&0x68);
        self.heard.clear();
        let mistake = self.mistake;
        if cut_off && mistake == Some(Mistake::BelievesTruncated) {
            self.confirm(turn);
            self.turn += 1;
            return;
        }
        let slave = &mut self.slaves[turn];
        slave.plain = 0;
        slave.is_there = false;
        let limit = match mistake {
            Some(Mistake::NoRetry) => 0,
            Some(Mistake::EndlessRetries) => u32::MAX,
            _ => self.settings.retries,
        };
        if slave.operational && slave.retries < limit {
            slave.retries += 1;
            slave.restarts = mistake == Some(Mistake::RestartsOnLoss) && slave.state == State::Exchange;
            return;
        }
        let stops = mistake == Some(Mistake::StopsOthers) && slave.configured.address != 9;
        if stops && slave.operational {
            slave.retries = 0;
            slave.operational = false;
            slave.state = State::Diag1;
            slave.open = None;
            return;
        }
        if stops && slave.turns > 1 {
            slave.open = None;
            return;
        }
        if let Some(services) = &mut slave.services {
            services.silence(now, mistake);
        }
        let was_there = slave.operational;
        if !was_there {
            slave.first_asks += 1;
            let nth = slave.first_asks;
            if (mistake == Some(Mistake::RepeatsFirst) && nth == 1)
                || (mistake == Some(Mistake::RepeatsLost) && nth > 1 && !nth.is_multiple_of(4))
            {
                return;
            }
            slave.forgotten |= mistake == Some(Mistake::ForgetsAbsent) && slave.start_ups == 0 && nth == 50;
        }
        slave.lost |= was_there && slave.state == State::Exchange;
        slave.open = None;
        slave.retries = 0;
        slave.reads += 1;
        slave.wants_diag = false;
        if mistake != Some(Mistake::NoReset) {
            slave.operational = false;
        }
        if mistake == Some(Mistake::Forgets) && was_there {
            slave.forgotten = true;
        }
        if mistake == Some(Mistake::StaysInExchange) && slave.state == State::Exchange {
            self.turn += 1;
            return;
        }
        if mistake == Some(Mistake::IgnoresSilence) && slave.state == State::Prm {
            slave.state = State::Cfg;
        } else {
            slave.restart(mistake);
        }
        self.turn += 1;
        if was_there && mistake == Some(Mistake::ClearsOnLoss) {
            self.controls.push_back((CLEAR, 0));
        }
        if was_there && mistake == Some(Mistake::RestartsAll) {
            for slave in &mut self.slaves {
                slave.restart(mistake);
            }
        }
    }
}

impl Master for TestMaster {
    fn handle_bytes(&mut self, now: Instant, octets: &[u8]) {
        self.hear_ring(now, octets);
        let Some(wait) = &mut self.waits else {
            self.next = self.next.max(now + self.settings.baud.bit_times(SYN_BITS));
            return;
        };
        // What has begun is heard to its end.
        wait.until = wait.until.map(|until| until.max(now + self.settings.slot));
        self.heard.extend_from_slice(octets);
        loop {
            let (len, whole) = match decode(&self.heard) {
                Decoded::Telegram { len, .. } => (len, true),
                Decoded::Incomplete => break,
                Decoded::Invalid { .. } if self.believes(self.heard[0]) => {
                    self.take_anything(now);
                    break;
                }
                Decoded::Invalid { skip, .. } => (skip, skip > 5),
            };
            if !whole {
                self.junk += len;
                self.dead |= self.junk > 200 && self.does(Mistake::DiesOnFlood);
            }
            let telegram: Vec<u8> = self.heard.drain(..len).collect();
            if whole {
                self.take_reply(now, &telegram);
            }
            if self.heard.is_empty() || self.waits.is_none() {
                break;
            }
        }
        if self.waits.is_none() {
            if !self.heard.is_empty() && self.does(Mistake::KeepsReplies) && self.turn > 0 {
                self.slaves[self.turn - 1].kept = true;
            }
            self.heard.clear();
        }
    }

    fn handle_sent(&mut self, now: Instant) {
        self.sending = false;
        self.heard.clear();
        self.junk = 0;
        self.ring_sent(now);
        let slot = self.slot();
        if let Some(wait) = &mut self.waits {
            wait.until = Some(now + slot);
            self.take_kept(now);
        } else if self.ring.polling {
            self.next = self.next.max(now + slot);
        } else {
            self.next = self.next.max(now + self.syn());
        }
    }

    fn handle_timeout(&mut self, now: Instant) {
        let over = self.waits.is_some_and(|wait| wait.until.is_some_and(|until| until <= now));
        if over {
            self.timed_out(now);
        }
    }

    fn poll_transmit(&mut self, now: Instant, buf: &mut [u8; MAX_TELEGRAM_LEN]) -> Option<usize> {
        let mut octets = self.next_telegram(now)?;
        self.sent += 1;
        if self.does(Mistake::WrongFcs) && self.sent.is_multiple_of(50) && octets.len() > 5 {
            let fcs = octets.len() - 2;
            octets[fcs] ^= 0x01;
        }
        self.sending = true;
        buf[..octets.len()].copy_from_slice(&octets);
        Some(octets.len())
    }

    fn poll_timeout(&self) -> Option<Instant> {
        if self.dead || self.stop == Stop::Stopped {
            return None;
        }
        match self.waits {
            Some(wait) => wait.until,
            None if !self.has_token() => self.ring_due(),
            None => Some(self.next),
        }
    }
}
