//! Faults on the way from the drives to the master.

use super::observed::Occasion;
use super::{Active, Kind, Outgoing, PkwFault, data_telegram, encoded};
use crate::profibus::dp::Service;
use crate::profibus::fdl::{Address, DataTelegram, Function, FunctionCode, ReplyStatus};
use crate::profibus::ppo::{PPO_LEN, Pke, Pkw};

/// The most that LE can be.
const MAX_LE: u8 = 249;

/// The first octet of a telegram with LE.
const SD2: u8 = 0x68;

impl Active {
    /// Corrupts what `station` says, if this is an occasion for this fault and it is due.
    pub(super) fn corrupt_reply(&mut self, reply: &mut Outgoing, occasion: Occasion) {
        if reply.octets.is_empty() || !self.concerns(occasion) {
            return;
        }
        match self.fault.kind {
            Kind::NoReply => {
                if self.is_due() {
                    reply.octets.clear();
                }
            }
            Kind::Late(delay) => {
                if self.is_due() {
                    reply.delay = reply.delay.saturating_add(delay);
                }
            }
            Kind::Duplicate => {
                if self.is_due() {
                    reply.copies += 1;
                }
            }
            Kind::Truncated => {
                if self.is_due() {
                    let left = self.chance.random.below(reply.octets.len());
                    reply.octets.truncate(left);
                }
            }
            Kind::BitErrors(bits) => {
                if self.is_due() {
                    self.flip_bits(&mut reply.octets, bits);
                }
            }
            Kind::WrongFcs => {
                if data_telegram(&reply.octets).is_some() && self.is_due() {
                    // FCS is the last octet but one.
                    if let Some(fcs) = reply.octets.iter_mut().nth_back(1) {
                        *fcs = fcs.wrapping_add(1);
                    }
                }
            }
            Kind::WrongLength => {
                if let [SD2, le, ler, ..] = &mut reply.octets[..]
                    && self.is_due()
                {
                    *le = if *le < MAX_LE { *le + 1 } else { *le - 1 };
                    *ler = *le;
                }
            }
            Kind::WrongSource(of) => {
                if let Some(telegram) = data_telegram(&reply.octets)
                    && self.is_due()
                {
                    let next = (telegram.sa.number() + 1) % Address::BROADCAST.number();
                    let sa = of.unwrap_or(Address::from_octet(next));
                    reply.octets = encoded(&DataTelegram { sa, ..telegram });
                }
            }
            Kind::Noise(octets) => {
                if self.is_due() {
                    reply.noise.extend((0..octets).map(|_| self.chance.random.octet()));
                }
            }
            Kind::DiagStorm => {
                if let Some(telegram) = inputs(&reply.octets)
                    && self.is_due()
                {
                    let fc = FunctionCode::response(ReplyStatus::DataHigh);
                    reply.octets = encoded(&DataTelegram { fc, ..telegram });
                }
            }
            Kind::FunctionCode(_)
            | Kind::ShortAck
            | Kind::InputLength(_)
            | Kind::WrongDestination(_)
            | Kind::NoSaps
            | Kind::WrongSaps
            | Kind::BrokenFrame(_)
            | Kind::Sd3
            | Kind::Diagnosis(_)
            | Kind::DiagLength(_) => self.reshape(reply, occasion),
            Kind::Pkw(fault) => {
                if let Some(telegram) = inputs(&reply.octets)
                    && telegram.data.len() == PPO_LEN
                    && let Some((pkw, pzd)) = telegram.data.split_first_chunk()
                {
                    let pkw = self.corrupt_pkw(fault, telegram.sa.number(), Pkw::from_octets(*pkw));
                    let data = [&pkw.to_octets()[..], pzd].concat();
                    reply.octets = encoded(&DataTelegram { data: &data, ..telegram });
                }
            }
            Kind::DropRequest
            | Kind::RefusePrm
            | Kind::RefuseCfg
            | Kind::NotReady(_)
            | Kind::LosePrm
            | Kind::Reject => {}
        }
    }

    /// The PKW words the master gets instead of `pkw` of `station`.
    fn corrupt_pkw(&mut self, fault: PkwFault, station: u8, pkw: Pkw) -> Pkw {
        let mut state = self.stations.get(&station).cloned().unwrap_or_default();
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
        self.stations.insert(station, state);
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
