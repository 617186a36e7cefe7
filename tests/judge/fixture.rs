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

/// What the master does wrong. One at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Mistake {
    /// A wrong sum in every fiftieth telegram.
    WrongFcs,
    /// Set_Prm as SDA.
    WrongFunction,
    /// FCB = 1 in Global_Control.
    CountedControl,
    /// The first request has FCV = 1.
    FirstCounted,
    /// The FCB never toggles.
    NoToggle,
    /// A retry toggles.
    RetryToggles,
    /// A retry carries newer outputs.
    RetryChanges,
    /// No retries.
    NoRetry,
    /// Retries without end.
    EndlessRetries,
    /// After the retries the FCB goes on.
    NoReset,
    /// One FCB for all stations.
    CommonBit,
    /// Replies with a wrong sum are believed.
    BelievesFcs,
    /// Replies of other stations are believed.
    BelievesSource,
    /// No diagnosis before Set_Prm.
    NoFirstDiag,
    /// No diagnosis behind Chk_Cfg.
    NoSecondDiag,
    /// Chk_Cfg before Set_Prm.
    CfgFirst,
    /// Data_Exchange though Station_Not_Ready.
    IgnoresNotReady,
    /// A new Set_Prm when the slave is not ready twice.
    Impatient,
    /// RS to Set_Prm is taken for SC.
    IgnoresRefusal,
    /// Stat_Diag is ignored.
    IgnoresStatDiag,
    /// Prm_Fault is ignored.
    IgnoresPrmFault,
    /// Cfg_Fault is ignored.
    IgnoresCfgFault,
    /// Another owner is ignored.
    IgnoresOwner,
    /// Short diagnoses are taken for good ones.
    TakesShortDiag,
    /// No Lock_Req.
    NoLock,
    /// A factor of the watchdog is 0.
    ZeroFactor,
    /// Reserved bits of Set_Prm.
    ReservedPrm,
    /// The ident number the other way round.
    SwappedIdent,
    /// min T_SDR of 5.
    ShortTsdr,
    /// One octet of user parameters too many.
    LongPrm,
    /// Other user parameters.
    OtherPrm,
    /// Other groups.
    OtherGroups,
    /// A watchdog ten times too short.
    ShortWatchdog,
    /// An octet of outputs too many.
    LongOutputs,
    /// The diagnosis is never read while data are exchanged.
    IgnoresHigh,
    /// Prm_Req is ignored while data are exchanged.
    IgnoresPrmReq,
    /// A diagnosis leads to a new start-up.
    RestartsOnDiag,
    /// No Global_Control at all.
    NoControl,
    /// Reserved bits in Global_Control.
    ReservedControl,
    /// Global_Control with Clear_Data when a slave is lost.
    ClearsOnLoss,
    /// Outputs while CLEAR is announced at the beginning.
    OutputsInClear,
    /// A lost reply leads to a new start-up.
    RestartsOnLoss,
    /// Data_Exchange goes on with a silent slave.
    StaysInExchange,
    /// RS is ignored.
    IgnoresRs,
    /// A lost slave is never asked again.
    Forgets,
    /// A lost slave stops the others.
    StopsOthers,
    /// Another slave's loss restarts every slave.
    RestartsAll,
    /// SC for data is ignored.
    IgnoresSc,
    /// Inputs of a wrong length are ignored.
    IgnoresLength,
    /// It ends when RS comes.
    DiesOnRs,
    /// It does not wait for replies.
    DoesNotWait,
    /// It waits only for a third of the slot time.
    ShortSlot,
    /// The second slave is asked every tenth time only.
    Unequal,
    /// It asks stations that nobody configured.
    Strangers,
}

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
                output: 0,
            })
            .collect();
        Self {
            next: Instant::ZERO + settings.slot * (6 + 2 * u32::from(settings.address)),
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
            self.next = now + self.settings.pause;
            if self.cycles == 20 {
                self.operate = true;
            }
            if self.cycles >= 20 && self.cycles.is_multiple_of(20) {
                self.controls.push_back(0x00);
            }
            if self.does(Mistake::Strangers) && self.cycles.is_multiple_of(7) {
                return Some(self.stranger());
            }
            return None;
        }
        if let Some(control) = self.controls.pop_front()
            && !self.does(Mistake::NoControl)
        {
            self.next = now
                + self.settings.baud.octet_times(13)
                + self.settings.baud.bit_times(self.settings.baud.max_tsdr_bits().into()).max(self.syn())
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
            State::Cfg => (Some(62), self.slaves[turn].configured.cfg.clone()),
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

    fn stranger(&self) -> Vec<u8> {
        let fc = FunctionCode::request(Service::SrdHigh, FrameCount::First);
        self.telegram(99, Some(61), fc, &[0x88, 1, 1, 11, 0, 1, 0])
    }

    fn outputs(&mut self, turn: usize) -> Vec<u8> {
        let clear = !self.operate && !self.does(Mistake::OutputsInClear);
        let long = usize::from(self.does(Mistake::LongOutputs));
        let slave = &mut self.slaves[turn];
        slave.output = slave.output.wrapping_add(1) | 1;
        let value = if clear { 0 } else { slave.output };
        vec![value; usize::from(slave.lengths.outputs) + long]
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
        self.next = now + self.syn();
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
                if mistake == Some(Mistake::CfgFirst) {
                    slave.state = State::Diag2;
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
        self.next = now;
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
        slave.restart(mistake);
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
