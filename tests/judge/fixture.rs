//! A small correct DP-V0 master, and switches for its mistakes: what the judge must find and what it must not.
//!
//! Sans-I/O: on a [`bench::Line`](profidrive::bench::Line) in virtual time, or on any link with `serve`.

use core::time::Duration;
use std::collections::VecDeque;

use profidrive::bench::Master;
use profidrive::dp::{Diagnosis, IoLengths};
use profidrive::fdl::telegram::{Decoded, decode};
use profidrive::fdl::{
    Address, DataTelegram, FrameCount, Function, FunctionCode, MAX_TELEGRAM_LEN, ReplyStatus, Sap, Service,
    StationType, Telegram,
};
use profidrive::time::{BaudRate, Instant, SYN_BITS};

use crate::mistakes::Mistake;

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
    pub(crate) stations: Vec<Configured>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Diag1,
    Prm,
    Cfg,
    Diag2,
    Exchange,
}

#[derive(Debug)]
struct Slave {
    configured: Configured,
    lengths: IoLengths,
    state: State,
    count: Option<bool>,
    operational: bool,
    retries: u32,
    /// The request that has no reply yet.
    open: Option<Vec<u8>>,
    wants_diag: bool,
    not_ready: u32,
    spoilt: u32,
    forgotten: bool,
    restarts: bool,
    turns: u32,
    start_ups: u32,
    output: u8,
}

/// The master.
#[derive(Debug)]
pub(crate) struct TestMaster {
    settings: Settings,
    mistake: Option<Mistake>,
    slaves: Vec<Slave>,
    /// Whose turn it is.
    turn: usize,
    /// Controls to be sent in this cycle.
    controls: VecDeque<u8>,
    cycles: u32,
    operate: bool,
    common: bool,
    waits: Option<Wait>,
    /// Not before.
    next: Instant,
    heard: Vec<u8>,
    sent: u32,
    /// Telegrams beside the cycle.
    extras: u32,
    /// Octets since the last request that were no telegram.
    junk: usize,
    pub(crate) dead: bool,
    sending: bool,
}

#[derive(Clone, Copy, Debug)]
struct Wait {
    slave: usize,
    /// When the slot time is over; `None` while it is being sent.
    until: Option<Instant>,
}

impl TestMaster {
    pub(crate) fn new(settings: Settings, mistake: Option<Mistake>) -> Self {
        let slaves = settings
            .stations
            .iter()
            .map(|configured| Slave {
                configured: configured.clone(),
                lengths: IoLengths::of(&configured.cfg).unwrap(),
                state: State::Diag1,
                count: None,
                operational: false,
                retries: 0,
                open: None,
                wants_diag: false,
                not_ready: 0,
                spoilt: 0,
                forgotten: false,
                restarts: false,
                turns: 0,
                start_ups: 0,
                output: 0,
            })
            .collect();
        Self {
            next: match mistake {
                Some(Mistake::NoListening) => Instant::ZERO,
                _ => Instant::ZERO + settings.slot * (6 + 2 * u32::from(settings.address)),
            },
            settings,
            mistake,
            slaves,
            turn: 0,
            controls: VecDeque::from([0x02]),
            cycles: 0,
            operate: false,
            common: false,
            waits: None,
            heard: Vec::new(),
            sent: 0,
            extras: 0,
            junk: 0,
            dead: false,
            sending: false,
        }
    }

    fn does(&self, mistake: Mistake) -> bool {
        self.mistake == Some(mistake)
    }

    fn syn(&self) -> Duration {
        self.settings.baud.bit_times(SYN_BITS)
    }

    fn slot(&self) -> Duration {
        match self.mistake {
            Some(Mistake::DoesNotWait) => self.settings.slot / 100,
            Some(Mistake::ShortSlot) => self.settings.slot * 3 / 10,
            _ => self.settings.slot,
        }
    }

    fn address(&self) -> Address {
        Address::station(self.settings.address).unwrap()
    }

    /// The next telegram, if it is time for one.
    fn next_telegram(&mut self, now: Instant) -> Option<Vec<u8>> {
        if self.dead || self.sending || self.waits.is_some() || now < self.next {
            return None;
        }
        if self.turn >= self.slaves.len() {
            self.turn = 0;
            self.cycles += 1;
            self.next = now + if self.does(Mistake::TooFast) { self.syn() } else { self.settings.pause };
            if self.cycles == 20 {
                self.operate = true;
            }
            if self.cycles >= 20 && self.cycles.is_multiple_of(20) {
                self.controls.push_back(0x00);
            }
            return if self.cycles.is_multiple_of(7) { self.extra() } else { None };
        }
        if let Some(control) = self.controls.pop_front()
            && !self.does(Mistake::NoControl)
        {
            self.next = now
                + self.settings.baud.octet_times(13)
                + if self.does(Mistake::ShortAfterControl) {
                    self.syn()
                } else {
                    self.settings.baud.bit_times(self.settings.baud.max_tsdr_bits().into()).max(self.syn())
                }
                + self.settings.baud.bit_times(2);
            return Some(self.control(control));
        }
        let turn = self.turn;
        let mistake = self.mistake;
        let slave = &mut self.slaves[turn];
        slave.turns += 1;
        let skipped = mistake == Some(Mistake::Unequal) && turn == 1 && !slave.turns.is_multiple_of(10);
        if slave.forgotten || skipped {
            self.turn += 1;
            return self.next_telegram(now);
        }
        let octets = match slave.open.clone() {
            Some(open) => self.again(turn, open),
            None => self.ask(turn),
        };
        self.slaves[turn].open = Some(octets.clone());
        self.waits = Some(Wait { slave: turn, until: None });
        Some(octets)
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

    fn ask(&mut self, turn: usize) -> Vec<u8> {
        let wants_diag = self.slaves[turn].wants_diag;
        let (sap, data) = match self.slaves[turn].state {
            State::Exchange if wants_diag => (Some(60), Vec::new()),
            State::Exchange => (None, self.outputs(turn)),
            State::Diag1 | State::Diag2 => (Some(60), Vec::new()),
            State::Prm => (Some(61), self.prm(turn)),
            State::Cfg => (Some(62), self.cfg(turn)),
        };
        let first = match self.mistake {
            Some(Mistake::FirstCounted) if self.slaves[turn].turns == 1 => Some(false),
            _ => None,
        };
        let common = self.common;
        let common_bit = self.does(Mistake::CommonBit);
        let slave = &mut self.slaves[turn];
        let count = match (slave.operational, slave.count.or(first)) {
            (_, None) => FrameCount::First,
            (false, Some(_)) if first.is_none() => FrameCount::First,
            (_, Some(bit)) => {
                let bit = if common_bit { common } else { bit };
                if bit { FrameCount::Odd } else { FrameCount::Even }
            }
        };
        if common_bit && count != FrameCount::First {
            self.common = !self.common;
        }
        let service = match self.mistake {
            Some(Mistake::WrongFunction) if sap == Some(61) => Service::SdaHigh,
            _ => Service::SrdHigh,
        };
        let address = self.slaves[turn].configured.address;
        self.telegram(address, sap, FunctionCode::request(service, count), &data)
    }

    fn telegram(&self, to: u8, sap: Option<u8>, fc: FunctionCode, data: &[u8]) -> Vec<u8> {
        let (dsap, ssap) = (sap.and_then(Sap::new), sap.and(Sap::new(62)));
        let format = DataTelegram::customary_format(dsap, ssap, data);
        let telegram =
            DataTelegram { format, da: Address::from_octet(to), sa: self.address(), dsap, ssap, fc, data };
        let mut buf = [0; MAX_TELEGRAM_LEN];
        telegram.encode(&mut buf).unwrap().to_vec()
    }

    fn control(&self, command: u8) -> Vec<u8> {
        let command = if self.does(Mistake::ReservedControl) { command | 0x40 } else { command };
        let count = if self.does(Mistake::CountedControl) { FrameCount::First } else { FrameCount::Unused };
        let fc = FunctionCode::request(Service::SdnHigh, count);
        self.telegram(127, Some(58), fc, &[command, 0x00])
    }

    /// A telegram beside the cycle that is a mistake.
    fn extra(&mut self) -> Option<Vec<u8>> {
        self.extras += 1;
        let nth = self.extras;
        let own = self.settings.address;
        let short =
            |to: u8, from: u8, fc: u8| vec![0x10, to, from, fc, to.wrapping_add(from).wrapping_add(fc), 0x16];
        let poll = |to: u8| short(to, own, 0x49);
        let token = |to: u8| vec![0xDC, to, own];
        let spoilt = |at: usize| {
            let mut octets = self.control(0x00);
            octets[at] ^= 0x01;
            octets
        };
        let first = FunctionCode::request(Service::SrdHigh, FrameCount::First);
        let octets = match self.mistake? {
            Mistake::Strangers => self.telegram(99, Some(61), first, &[0x88, 1, 1, 11, 0, 1, 0]),
            Mistake::SendsSc => vec![0xE5],
            Mistake::BrokenLength => spoilt(2),
            Mistake::WrongEnd => spoilt(self.control(0x00).len() - 1),
            Mistake::EmptySd2 => {
                let sum = 99_u8.wrapping_add(own).wrapping_add(0x49);
                vec![0x68, 3, 3, 0x68, 99, own, 0x49, sum, 0x16]
            }
            Mistake::NoSsap => {
                // DSAP 60, and the extension bit of DA only.
                let inside = [99 | 0x80, own, first.octet(), 60];
                let sum = inside.iter().fold(0, |sum: u8, octet| sum.wrapping_add(*octet));
                [&[0x68, 4, 4, 0x68][..], &inside, &[sum, 0x16]].concat()
            }
            Mistake::OtherSource => short(99, own + 1, 0x49),
            Mistake::AsksItself => poll(own),
            Mistake::AsksEverybody => poll(127),
            Mistake::CountedPoll => short(99, own, 0x69),
            Mistake::TokenToSlave => token(self.slaves[0].configured.address),
            Mistake::GapRepeats | Mistake::GapTwice | Mistake::GapFalls | Mistake::GapAboveHsa
                if nth.is_multiple_of(if self.does(Mistake::GapTwice) { 3 } else { 2 }) =>
            {
                token(own)
            }
            Mistake::GapRepeats => poll(50),
            Mistake::GapTwice => poll(49 + (nth % 3) as u8),
            Mistake::GapFalls => poll(59 - (nth / 2 % 40) as u8),
            Mistake::GapAboveHsa => poll(99),
            Mistake::LongControl => {
                let fc = FunctionCode::request(Service::SdnHigh, FrameCount::Unused);
                self.telegram(127, Some(58), fc, &[0, 0, 0])
            }
            _ => return None,
        };
        Some(octets)
    }

    fn outputs(&mut self, turn: usize) -> Vec<u8> {
        let clear = !self.operate && !self.does(Mistake::OutputsInClear);
        let more = usize::from(self.does(Mistake::LongOutputs));
        let less = usize::from(self.does(Mistake::ShortOutputs));
        let slave = &mut self.slaves[turn];
        slave.output = slave.output.wrapping_add(1) | 1;
        let value = if clear { 0 } else { slave.output };
        vec![value; usize::from(slave.lengths.outputs) + more - less]
    }

    fn cfg(&self, turn: usize) -> Vec<u8> {
        let mut cfg = self.slaves[turn].configured.cfg.clone();
        if self.does(Mistake::OtherCfg) {
            cfg[0] ^= 0x01;
        }
        cfg
    }

    fn prm(&self, turn: usize) -> Vec<u8> {
        let Configured { ident, prm, groups, .. } = &self.slaves[turn].configured;
        let units = u8::try_from(self.settings.watchdog.as_millis() / 10).unwrap_or(255);
        let (mut status, mut factors, mut tsdr) = (0x88, [units, 1], 11);
        let [mut high, mut low] = ident.to_be_bytes();
        let (mut groups, mut user) = (*groups, prm.clone());
        match self.mistake {
            Some(Mistake::NoLock) => status = 0x08,
            Some(Mistake::ZeroFactor) => factors = [units, 0],
            Some(Mistake::ReservedPrm) => status |= 0x02,
            Some(Mistake::SwappedIdent) => core::mem::swap(&mut high, &mut low),
            Some(Mistake::ShortTsdr) => tsdr = 5,
            Some(Mistake::LongPrm) => user.push(0),
            Some(Mistake::OtherPrm) => user[0] ^= 1,
            Some(Mistake::OtherGroups) => groups ^= 1,
            Some(Mistake::WatchdogOff) => (status, factors) = (0x80, [0, 0]),
            Some(Mistake::Unlocks) => status |= 0x40,
            Some(Mistake::ChangesPrm) if self.slaves[turn].start_ups > 1 => user[0] ^= 1,
            Some(Mistake::ShortWatchdog) => factors = [units / 2, 1],
            _ => {}
        }
        [&[status, factors[0], factors[1], tsdr, high, low, groups][..], &user].concat()
    }

    /// A whole reply to the request that is open.
    fn take_reply(&mut self, now: Instant, octets: &[u8]) {
        let Some(Wait { slave: turn, .. }) = self.waits else { return };
        let expected = self.slaves[turn].configured.address;
        let reply = match decode(octets) {
            Decoded::Telegram { telegram, .. } => telegram,
            Decoded::Incomplete => return,
            Decoded::Invalid { .. } if self.does(Mistake::BelievesFcs) && octets.len() > 5 => {
                self.waits = None;
                self.confirm(turn);
                self.turn += 1;
                self.next = now + self.syn();
                return;
            }
            Decoded::Invalid { .. } => return,
        };
        let answer = match reply {
            Telegram::ShortAcknowledge => Some((None, Vec::new())),
            Telegram::Token { .. } => None,
            Telegram::Data(data) => match data.fc.function() {
                Function::Response(StationType::Slave, status)
                    if data.da == self.address()
                        && (data.sa.number() == expected || self.does(Mistake::BelievesSource)) =>
                {
                    let asked = self.slaves[turn].open.as_deref().map(decode);
                    let saps = match asked {
                        Some(Decoded::Telegram { telegram: Telegram::Data(asked), .. }) => {
                            data.data.is_empty() || (asked.dsap, asked.ssap) == (data.ssap, data.dsap)
                        }
                        _ => false,
                    };
                    saps.then(|| (Some(status), data.data.to_vec()))
                }
                _ => None,
            },
        };
        // What is no reply to this request does not end the waiting.
        let Some((status, data)) = answer else { return };
        self.waits = None;
        self.confirm(turn);
        self.react(turn, status, &data);
        self.turn += 1;
        self.next =
            now + if self.does(Mistake::ShortIdle) { self.settings.baud.bit_times(20) } else { self.syn() };
    }

    /// The request was answered.
    fn confirm(&mut self, turn: usize) {
        let stuck = self.does(Mistake::NoToggle);
        let slave = &mut self.slaves[turn];
        slave.open = None;
        slave.retries = 0;
        slave.count = Some(match slave.count {
            None => false,
            Some(_) if !slave.operational => false,
            Some(bit) => bit ^ !stuck,
        });
        slave.operational = true;
    }

    fn react(&mut self, turn: usize, status: Option<ReplyStatus>, data: &[u8]) {
        let own = self.settings.address;
        let mistake = self.mistake;
        let slave = &mut self.slaves[turn];
        match slave.state {
            State::Diag1 | State::Diag2 => {
                let diag = Diagnosis::parse(data).or((mistake == Some(Mistake::TakesShortDiag)).then(|| {
                    Diagnosis {
                        ident: slave.configured.ident,
                        master: Address::station(own).ok(),
                        ..Diagnosis::default()
                    }
                }));
                let Some(diag) = diag else { return };
                if mistake == Some(Mistake::DiesOnMasterBits) && data[0] & 0x80 != 0 {
                    self.dead = true;
                }
                let owned = diag.master.is_some_and(|owner| owner.number() != own);
                if owned && mistake != Some(Mistake::IgnoresOwner) {
                    slave.state = State::Diag1;
                } else if slave.state == State::Diag1 {
                    slave.state = if mistake == Some(Mistake::CfgFirst) { State::Cfg } else { State::Prm };
                    slave.not_ready = 0;
                } else {
                    slave.judge_second(diag, mistake);
                }
            }
            State::Prm if status.is_none() || mistake == Some(Mistake::IgnoresRefusal) => {
                slave.state = State::Cfg;
                slave.start_ups += 1;
                if mistake == Some(Mistake::CfgFirst) {
                    slave.state = State::Diag2;
                } else if mistake == Some(Mistake::NoCfg) {
                    slave.state = State::Exchange;
                }
            }
            State::Cfg if mistake == Some(Mistake::CfgFirst) => slave.state = State::Prm,
            State::Cfg if status.is_none() => {
                let next = mistake == Some(Mistake::NoSecondDiag);
                slave.state = if next { State::Exchange } else { State::Diag2 };
            }
            State::Prm | State::Cfg => slave.restart(mistake),
            State::Exchange if slave.wants_diag => {
                slave.wants_diag = false;
                if mistake == Some(Mistake::DiesOnMasterBits)
                    && data.first().is_some_and(|octet| octet & 0x80 != 0)
                {
                    self.dead = true;
                }
                let Some(diag) = Diagnosis::parse(data) else { return };
                let owned = diag.master.is_none_or(|owner| owner.number() != own);
                let asks =
                    diag.prm_req || diag.station_not_ready || diag.prm_fault || diag.cfg_fault || owned;
                if asks && mistake != Some(Mistake::IgnoresPrmReq) || mistake == Some(Mistake::RestartsOnDiag)
                {
                    slave.restart(mistake);
                }
            }
            State::Exchange => self.exchanged(turn, status, data.len()),
        }
    }

    fn exchanged(&mut self, turn: usize, status: Option<ReplyStatus>, len: usize) {
        let mistake = self.mistake;
        let slave = &mut self.slaves[turn];
        if core::mem::take(&mut slave.restarts) {
            return slave.restart(mistake);
        }
        let inputs = usize::from(slave.lengths.inputs);
        match status {
            Some(ReplyStatus::UserError) if mistake == Some(Mistake::DiesOnUserError) => self.dead = true,
            Some(ReplyStatus::NotActivated) if mistake == Some(Mistake::DiesOnRs) => self.dead = true,
            Some(ReplyStatus::NotActivated) if mistake == Some(Mistake::IgnoresRs) => {}
            Some(ReplyStatus::NotActivated | ReplyStatus::UserError | ReplyStatus::NoResource) => {
                slave.restart(mistake);
            }
            Some(ReplyStatus::DataHigh | ReplyStatus::NoResourceDataHigh) if len == inputs => {
                slave.wants_diag = mistake != Some(Mistake::IgnoresHigh);
                slave.spoilt = 0;
            }
            None if inputs == 0 => slave.spoilt = 0,
            None if mistake == Some(Mistake::IgnoresSc) => {}
            None => slave.spoil(),
            Some(_) if len == inputs => slave.spoilt = 0,
            Some(_) if mistake == Some(Mistake::IgnoresLength) => {}
            Some(_) => slave.spoil(),
        }
    }

    /// The slot time is over.
    fn timed_out(&mut self, now: Instant) {
        let Some(Wait { slave: turn, .. }) = self.waits.take() else { return };
        self.next = if self.does(Mistake::SlowAfterLoss) { now + self.settings.slot * 40 } else { now };
        self.heard.clear();
        let mistake = self.mistake;
        let slave = &mut self.slaves[turn];
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
        let was_there = slave.operational;
        slave.open = None;
        slave.retries = 0;
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
            self.controls.push_back(0x02);
        }
        if was_there && mistake == Some(Mistake::RestartsAll) {
            for slave in &mut self.slaves {
                slave.restart(mistake);
            }
        }
    }
}

impl Slave {
    fn restart(&mut self, mistake: Option<Mistake>) {
        self.state = if mistake == Some(Mistake::NoFirstDiag) { State::Prm } else { State::Diag1 };
        self.wants_diag = false;
        self.not_ready = 0;
        self.spoilt = 0;
        self.restarts = false;
    }

    fn spoil(&mut self) {
        self.spoilt += 1;
        if self.spoilt >= 3 {
            self.spoilt = 0;
            self.wants_diag = true;
        }
    }

    /// The diagnosis behind Chk_Cfg.
    fn judge_second(&mut self, diag: Diagnosis, mistake: Option<Mistake>) {
        let faults = (diag.prm_fault && mistake != Some(Mistake::IgnoresPrmFault))
            || (diag.cfg_fault && mistake != Some(Mistake::IgnoresCfgFault));
        let prm_req = diag.prm_req
            && !(diag.prm_fault && mistake == Some(Mistake::IgnoresPrmFault))
            && !(diag.cfg_fault && mistake == Some(Mistake::IgnoresCfgFault));
        let not_ready = diag.station_not_ready
            && mistake != Some(Mistake::IgnoresNotReady)
            && !(diag.prm_fault && mistake == Some(Mistake::IgnoresPrmFault))
            && !(diag.cfg_fault && mistake == Some(Mistake::IgnoresCfgFault));
        let stat_diag = diag.stat_diag && mistake != Some(Mistake::IgnoresStatDiag);
        if faults || prm_req || diag.ident != self.configured.ident {
            self.restart(mistake);
        } else if not_ready || stat_diag {
            self.not_ready += 1;
            if mistake == Some(Mistake::Impatient) && self.not_ready > 2 {
                self.restart(mistake);
            }
        } else {
            self.state = State::Exchange;
        }
    }
}

impl Master for TestMaster {
    fn handle_bytes(&mut self, now: Instant, octets: &[u8]) {
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
            self.heard.clear();
        }
    }

    fn handle_sent(&mut self, now: Instant) {
        self.sending = false;
        self.heard.clear();
        self.junk = 0;
        let slot = self.slot();
        if let Some(wait) = &mut self.waits {
            wait.until = Some(now + slot);
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
        if self.dead {
            return None;
        }
        match self.waits {
            Some(wait) => wait.until,
            None => Some(self.next),
        }
    }
}
