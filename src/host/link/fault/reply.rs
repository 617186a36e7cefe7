//! Faults on the way from the drives to the master.

use core::time::Duration;

use super::observed::Occasion;
use super::shape::{ShapeFault, shaped};
use super::{Active, Outgoing, data_telegram, encoded};
use crate::host::fault::Kind;
use crate::profibus::dp::Service;
use crate::profibus::fdl::{DataTelegram, Function, ReplyStatus};
use crate::profibus::ppo::{PPO_LEN, Pke, Pkw};

/// What becomes of a reply. The table of kinds ([`Row`](crate::host::fault::Row)) says it in words.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ReplyFault {
    Lost,
    Late(Duration),
    Duplicate,
    Truncated,
    /// How many bits.
    BitErrors(u32),
    /// How many octets.
    Noise(u32),
    Shape(ShapeFault),
    Pkw(PkwFault),
}

/// What becomes of an answer of the parameter channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum PkwFault {
    /// By how many exchanges.
    Delay(u32),
    WrongAk,
    WrongPnu,
    Torn,
}

impl Active {
    /// Corrupts what `station` says, if this is an occasion for this fault and it is due.
    pub(super) fn corrupt_reply(&mut self, reply: &mut Outgoing, occasion: Occasion) {
        let Kind::Reply(fault) = self.rule.kind else { return };
        if reply.octets.is_empty() || !self.concerns(occasion) {
            return;
        }
        match fault {
            ReplyFault::Pkw(fault) => self.corrupt_pkw_in(reply, fault),
            ReplyFault::Shape(fault) => {
                if let Some(shaped) = shaped(fault, &reply.octets, occasion)
                    && self.is_due()
                {
                    reply.octets = shaped;
                }
            }
            // Every reply is an occasion for the others.
            _ if !self.is_due() => {}
            ReplyFault::Lost => reply.octets.clear(),
            ReplyFault::Late(delay) => reply.delay = reply.delay.saturating_add(delay),
            ReplyFault::Duplicate => reply.copies += 1,
            ReplyFault::Truncated => {
                let left = self.chance.random.below(reply.octets.len());
                reply.octets.truncate(left);
            }
            ReplyFault::BitErrors(bits) => self.flip_bits(&mut reply.octets, bits),
            ReplyFault::Noise(octets) => {
                reply.noise.extend((0..octets).map(|_| self.chance.random.octet()));
            }
        }
    }

    /// Corrupts the PKW words of inputs that have some.
    fn corrupt_pkw_in(&mut self, reply: &mut Outgoing, fault: PkwFault) {
        if let Some(telegram) = inputs(&reply.octets)
            && telegram.data.len() == PPO_LEN
            && let Some((pkw, pzd)) = telegram.data.split_first_chunk()
        {
            let pkw = self.corrupt_pkw(fault, telegram.sa.number(), Pkw::from_octets(*pkw));
            let data = [&pkw.to_octets()[..], pzd].concat();
            reply.octets = encoded(&DataTelegram { data: &data, ..telegram });
        }
    }

    /// The PKW words the master gets instead of `pkw` of `station`.
    fn corrupt_pkw(&mut self, fault: PkwFault, station: u8, pkw: Pkw) -> Pkw {
        let mut state = self.seen.stations.get(&station).cloned().unwrap_or_default();
        let changed = (pkw.pke, pkw.ind) != (state.sent.pke, state.sent.ind);
        if changed {
            state.corrupted = pkw.pke.ak() != 0 && self.is_due();
            state.exchanges = 0;
        }
        let corrupted = match fault {
            _ if !state.corrupted => pkw,
            PkwFault::Delay(exchanges) if state.exchanges < exchanges => state.shown,
            PkwFault::Delay(_) => pkw,
            PkwFault::WrongAk => with_pke(pkw, pkw.pke.raw() ^ wrong_ak(pkw.pke.ak())),
            PkwFault::WrongPnu => with_pke(pkw, pkw.pke.raw() ^ 1),
            PkwFault::Torn if changed => Pkw { pke: state.sent.pke, ind: state.sent.ind, ..pkw },
            PkwFault::Torn => pkw,
        };
        state.exchanges = state.exchanges.saturating_add(1);
        state.sent = pkw;
        state.shown = corrupted;
        self.seen.stations.insert(station, state);
        corrupted
    }

    /// Turns so many different bits the other way round, or all if there are not so many.
    fn flip_bits(&mut self, octets: &mut [u8], bits: u32) {
        let mut left: std::vec::Vec<usize> = (0..octets.len() * 8).collect();
        for _ in 0..bits {
            if left.is_empty() {
                return;
            }
            let bit = left.swap_remove(self.chance.random.below(left.len()));
            if let Some(octet) = octets.get_mut(bit / 8) {
                *octet ^= 1 << (bit % 8);
            }
        }
    }
}

fn with_pke(pkw: Pkw, raw: u16) -> Pkw {
    Pkw { pke: Pke::from_raw(raw), ..pkw }
}

/// The bits of PKE to turn round so that AK is another one that a master could take for an answer.
const fn wrong_ak(ak: u8) -> u16 {
    let bits = match ak {
        // Word for double word.
        1 | 2 => 3,
        // Refused for no right to change parameters.
        7 | 8 => 15,
        _ => 1,
    };
    bits << 12
}

/// A reply to Data_Exchange with inputs.
pub(super) fn inputs(octets: &[u8]) -> Option<DataTelegram<'_>> {
    response_of(octets, Service::DataExchange).filter(|telegram| !telegram.data.is_empty())
}

/// A reply with data whose SAPs are those of `service`, the other way round than in its request.
pub(super) fn response_of(octets: &[u8], service: Service) -> Option<DataTelegram<'_>> {
    let telegram = data_telegram(octets)?;
    let data =
        matches!(telegram.fc.function(), Function::Response(_, ReplyStatus::DataLow | ReplyStatus::DataHigh));
    (data && Service::of(telegram.ssap, telegram.dsap) == Some(service)).then_some(telegram)
}
