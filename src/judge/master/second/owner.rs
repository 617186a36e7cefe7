//! The master of class 1 that owns the slaves, played while one of class 2 is judged: it starts each slave and exchanges data
//! with it, one request for each with every token.

use super::telegrams;
use crate::judge::master::setup::Slave;
use crate::profibus::dp::{Diagnosis, Service};
use crate::profibus::fdl::telegram::{Decoded, decode};
use crate::profibus::fdl::{Address, FrameCount, Function, ReplyStatus, Telegram};

/// Lock_Req, and no watchdog: the slaves stay in data exchange when the master has left the ring.
const LOCK: u8 = 0x80;

/// A slave of the master of class 1.
#[derive(Clone, Debug)]
pub(super) struct Owned {
    pub(super) address: Address,
    prm: Vec<u8>,
    cfg: Vec<u8>,
    outputs: usize,
    step: Step,
    count: FrameCount,
    /// Good exchanges.
    pub(super) exchanges: u32,
}

/// What it is asked for next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    Diagnosis,
    Parameters,
    Configuration,
    Check,
    Exchange,
}

impl Owned {
    pub(super) fn new(slave: &Slave) -> Self {
        let [high, low] = slave.ident.to_be_bytes();
        let user = slave.prm.clone().unwrap_or_default();
        Self {
            address: slave.address,
            prm: [&[LOCK, 1, 1, 0, high, low, slave.groups.unwrap_or(0)][..], &user].concat(),
            cfg: slave.cfg.clone().unwrap_or_default(),
            outputs: slave.lengths().map_or(0, |lengths| lengths.outputs.into()),
            step: Step::Diagnosis,
            count: FrameCount::First,
            exchanges: 0,
        }
    }

    /// The next request to it.
    pub(super) fn request(&self, own: Address) -> Vec<u8> {
        let (service, data) = match self.step {
            Step::Diagnosis | Step::Check => (Service::SlaveDiag, Vec::new()),
            Step::Parameters => (Service::SetPrm, self.prm.clone()),
            Step::Configuration => (Service::ChkCfg, self.cfg.clone()),
            Step::Exchange => (Service::DataExchange, vec![0; self.outputs]),
        };
        telegrams::request(self.address, own, service, self.count, &data)
    }

    /// Takes what it has answered, or that it has not. Whether data exchange has ended by what it says.
    pub(super) fn answered(&mut self, octets: &[u8]) -> bool {
        let exchanged = self.step == Step::Exchange;
        let next = match (self.step, reply(octets)) {
            (Step::Diagnosis, Some(Reply::Data(data))) if Diagnosis::parse(&data).is_some() => {
                Step::Parameters
            }
            (Step::Parameters, Some(Reply::Acknowledge)) => Step::Configuration,
            (Step::Configuration, Some(Reply::Acknowledge)) => Step::Check,
            (Step::Check, Some(Reply::Data(data))) => match Diagnosis::parse(&data) {
                Some(diag) if diag.prm_req || diag.prm_fault || diag.cfg_fault => Step::Diagnosis,
                Some(diag) if diag.station_not_ready => Step::Check,
                Some(_) => Step::Exchange,
                None => Step::Check,
            },
            (Step::Exchange, Some(Reply::Data(_) | Reply::Acknowledge)) => {
                self.exchanges = self.exchanges.saturating_add(1);
                Step::Exchange
            }
            (Step::Exchange, Some(Reply::Refused)) => {
                (self.step, self.count) = (Step::Diagnosis, FrameCount::First);
                return exchanged;
            }
            // It is asked again from the beginning; slaves of the judge answer.
            (_, None) => {
                (self.step, self.count) = (Step::Diagnosis, FrameCount::First);
                return false;
            }
            (step, Some(_)) => step,
        };
        self.step = next;
        self.count = match self.count {
            FrameCount::First | FrameCount::Odd => FrameCount::Even,
            FrameCount::Even | FrameCount::Unused => FrameCount::Odd,
        };
        false
    }
}

enum Reply {
    Acknowledge,
    Data(Vec<u8>),
    Refused,
}

fn reply(octets: &[u8]) -> Option<Reply> {
    let Decoded::Telegram { telegram, .. } = decode(octets) else { return None };
    match telegram {
        Telegram::ShortAcknowledge => Some(Reply::Acknowledge),
        Telegram::Token { .. } => None,
        Telegram::Data(data) => match data.fc.function() {
            Function::Response(_, ReplyStatus::DataLow | ReplyStatus::DataHigh) => {
                Some(Reply::Data(data.data.to_vec()))
            }
            Function::Response(..) => Some(Reply::Refused),
            Function::Request(..) | Function::Reserved => None,
        },
    }
}
