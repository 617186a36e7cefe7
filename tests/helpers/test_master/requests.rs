//! What the test master sends, mistakes included.

use core::time::Duration;

use profidrive::profibus::fdl::{
    Address, DataTelegram, FrameCount, FunctionCode, MAX_TELEGRAM_LEN, Sap, Service,
};

use super::mistakes::Mistake;
use super::slave::State;
use super::{Beside, CLEAR, Configured, Stop, TestMaster};

/// Slave_Diag, Get_Cfg, RD_Inp, RD_Outp.
const READ: [u8; 4] = [60, 59, 56, 57];

impl TestMaster {
    pub(super) fn ask(&mut self, turn: usize) -> Vec<u8> {
        let wants_diag = self.slaves[turn].wants_diag;
        let takes = self.does(Mistake::TakesOver) && self.slaves[turn].turns.is_multiple_of(50);
        let service = if self.stop == Stop::No { self.ask_service(turn) } else { None };
        let (sap, data) = match self.slaves[turn].state {
            _ if service.is_some() => service.map(|(sap, data)| (Some(sap), data)).unwrap(),
            _ if self.settings.class_2 && takes => (Some(61), self.prm(turn)),
            _ if self.settings.class_2 => (Some(READ[self.slaves[turn].reads % READ.len()]), Vec::new()),
            _ if self.stop == Stop::Releasing => (Some(61), self.release(turn)),
            State::Exchange if wants_diag => (Some(60), Vec::new()),
            // Every fiftieth time.
            State::Exchange
                if self.does(Mistake::SapsForData) && self.slaves[turn].turns.is_multiple_of(50) =>
            {
                (Some(57), self.outputs(turn))
            }
            State::Exchange
                if (self.does(Mistake::ReadsRecord) || self.does(Mistake::ReadsNothing))
                    && self.slaves[turn].turns.is_multiple_of(50) =>
            {
                (Some(51), vec![0x5E, 1, 1, u8::from(self.does(Mistake::ReadsRecord))])
            }
            State::Exchange => (None, self.outputs(turn)),
            State::Diag1 | State::Diag2 => (Some(60), Vec::new()),
            State::Prm if self.reads_cfg(turn) => (Some(59), Vec::new()),
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
            _ => self.data_service(),
        };
        let address = self.slaves[turn].configured.address;
        self.telegram(address, sap, FunctionCode::request(service, count), &data)
    }

    /// A telegram of the ring.
    pub(super) fn of_ring(&mut self, beside: Beside) -> Vec<u8> {
        let own = self.settings.address;
        match beside {
            Beside::Claim => vec![0xDC, own, own],
            Beside::Token => self.pass_token(),
            Beside::Noise => vec![0x33; 200],
            Beside::Poll => {
                self.ring.polling = true;
                short(self.ring.gap, own, 0x49)
            }
        }
    }

    pub(super) fn telegram(&self, to: u8, sap: Option<u8>, fc: FunctionCode, data: &[u8]) -> Vec<u8> {
        let mut ssap = sap.and_then(|sap| match sap {
            50 | 51 => Sap::new(51),
            0..=49 => Sap::new(50),
            _ => Sap::new(62),
        });
        if self.does(Mistake::NoSsap) && sap == Some(60) {
            ssap = None;
        }
        let dsap = sap.and_then(Sap::new);
        let format = DataTelegram::customary_format(dsap, ssap, data);
        let telegram =
            DataTelegram { format, da: Address::from_octet(to), sa: self.address(), dsap, ssap, fc, data };
        let mut buf = [0; MAX_TELEGRAM_LEN];
        telegram.encode(&mut buf).unwrap().to_vec()
    }

    pub(super) fn control(&self, command: u8, groups: u8) -> Vec<u8> {
        let command = if self.does(Mistake::ReservedControl) { command | 0x40 } else { command };
        let count = if self.does(Mistake::CountedControl) { FrameCount::First } else { FrameCount::Unused };
        let groups = if self.does(Mistake::OneGroup) && command & CLEAR == 0 { 0x80 } else { groups };
        let fc = FunctionCode::request(Service::SdnHigh, count);
        self.telegram(127, Some(58), fc, &[command, groups])
    }

    /// A telegram beside the cycle that is a mistake.
    pub(super) fn extra(&mut self) -> Option<Vec<u8>> {
        self.extras += 1;
        let nth = self.extras;
        let own = self.settings.address;
        let poll = |to: u8| short(to, own, 0x49);
        let token = |to: u8| vec![0xDC, to, own];
        let broken = |at: usize| {
            let mut octets = self.control(0, 0);
            octets[at] ^= 0x01;
            octets
        };
        let first = FunctionCode::request(Service::SrdHigh, FrameCount::First);
        let octets = match self.mistake? {
            Mistake::Strangers => self.telegram(99, Some(61), first, &[0x88, 1, 1, 11, 0, 1, 0]),
            // 126 to 99.
            Mistake::SetsAddress => self.telegram(126, Some(55), first, &[99, 0x12, 0x34, 0]),
            Mistake::SendsSc => vec![0xE5],
            Mistake::BrokenLength => broken(2),
            Mistake::WrongEnd => broken(self.control(0, 0).len() - 1),
            Mistake::EmptySd2 => {
                let sum = 99_u8.wrapping_add(own).wrapping_add(0x49);
                vec![0x68, 3, 3, 0x68, 99, own, 0x49, sum, 0x16]
            }
            Mistake::HugeLength => [&[0x68, 250, 250, 0x68][..], &[own; 20], &[0x16]].concat(),
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
        if clear && self.does(Mistake::EmptyInClear) {
            return Vec::new();
        }
        let to_inputs = self.does(Mistake::OutputsToInputs) && self.slaves[turn].lengths.outputs == 0;
        let more = usize::from(self.does(Mistake::LongOutputs) || to_inputs);
        let less = usize::from(self.does(Mistake::ShortOutputs));
        let slave = &mut self.slaves[turn];
        slave.output = slave.output.wrapping_add(1) | 1;
        if let Some(outputs) = slave.user_outputs.clone().filter(|_| !clear) {
            if core::mem::take(&mut slave.torn) {
                let half = outputs.len() / 2;
                return [&outputs[..half], &slave.sent_outputs[half..]].concat();
            }
            slave.sent_outputs.clone_from(&outputs);
            return outputs;
        }
        let value = if clear { 0 } else { slave.output };
        slave.sent_outputs = vec![value; usize::from(slave.lengths.outputs) + more - less];
        slave.sent_outputs.clone()
    }

    /// Set_Prm that lets a slave go: Unlock_Req.
    fn release(&self, turn: usize) -> Vec<u8> {
        let [high, low] = self.slaves[turn].configured.ident.to_be_bytes();
        vec![0x40, 0, 0, 0, high, low, 0]
    }

    fn cfg(&self, turn: usize) -> Vec<u8> {
        let mut cfg = self.slaves[turn].configured.cfg.clone();
        match self.mistake {
            Some(Mistake::OtherCfg) => cfg[0] ^= 0x01,
            Some(Mistake::OtherSpecial) => cfg[1] ^= 0x01,
            _ => {}
        }
        cfg
    }

    fn prm(&self, turn: usize) -> Vec<u8> {
        let Configured { ident, prm, groups, .. } = &self.slaves[turn].configured;
        let watchdog = self.watchdog_of(&self.slaves[turn].configured);
        let [units, times] = watchdog_factors(watchdog);
        let prepared = !self.does(Mistake::SyncUntold);
        let (mut status, mut factors, mut tsdr) =
            (if prepared { 0xB8 } else { 0x88 }, [units, times], self.least_tsdr());
        let [mut high, mut low] = ident.to_be_bytes();
        let (mut groups, mut user) = (*groups, prm.clone());
        match self.mistake {
            Some(Mistake::NoLock) => status = 0x08,
            Some(Mistake::ZeroFactor) => factors = [units, 0],
            Some(Mistake::ReservedPrm) => status |= 0x02,
            Some(Mistake::SwappedIdent) => core::mem::swap(&mut high, &mut low),
            Some(Mistake::ShortTsdr) => tsdr = 5,
            Some(Mistake::LongTsdr) => tsdr = 200,
            Some(Mistake::LongPrm) => user.push(0),
            Some(Mistake::Dpv1Octets) => user.extend([0, 0, 0]),
            Some(Mistake::ReservedStatus) => user[0] |= 0x10,
            Some(Mistake::RequiredOff) => user[1] &= !0x40,
            Some(Mistake::EnablesEveryAlarm) => user[1] = 0xFC,
            Some(Mistake::LongBlock) => user[3] += 1,
            Some(Mistake::OtherPrm) => user[0] ^= 1,
            Some(Mistake::OtherGroups) => groups ^= 1,
            Some(Mistake::WatchdogOff) => (status, factors) = (0x80, [0, 0]),
            Some(Mistake::Unlocks) => status |= 0x40,
            Some(Mistake::ChangesPrm) if self.slaves[turn].start_ups > 1 => user[0] ^= 1,
            Some(Mistake::WatchdogOfTop) if self.does_at_top(Mistake::WatchdogOfTop) => {
                factors = [units, times * 2]
            }
            Some(Mistake::ShortWatchdog) => factors = [units / 2, times],
            _ if watchdog.is_zero() => (status, factors) = (status & !0x08, [0, 0]),
            _ => {}
        }
        [&[status, factors[0], factors[1], tsdr, high, low, groups][..], &user].concat()
    }
}

/// WD_Fact_1 and WD_Fact_2 of a time, rounded up to what both can say.
fn watchdog_factors(time: Duration) -> [u8; 2] {
    let steps = u32::try_from(time.as_millis().div_ceil(10)).unwrap();
    let second = steps.div_ceil(255).max(1);
    [steps.div_ceil(second), second].map(|factor| u8::try_from(factor).unwrap())
}

/// SD1.
pub(super) fn short(to: u8, from: u8, fc: u8) -> Vec<u8> {
    vec![0x10, to, from, fc, to.wrapping_add(from).wrapping_add(fc), 0x16]
}
