//! Faults on the way from the drives to the master.

use super::{Active, Kind, Outgoing, PkwFault, data_telegram, encoded};
use crate::dp::Service;
use crate::fdl::{Address, DataTelegram, Function, FunctionCode, ReplyStatus};
use crate::ppo::{PPO_LEN, Pke, Pkw};
use crate::time::Instant;

/// Octet 1 of Slave_Diag, b1.
const STATION_NOT_READY: u8 = 0x02;

/// The most that LE can be.
const MAX_LE: u8 = 249;

/// The first octet of a telegram with LE.
const SD2: u8 = 0x68;

impl Active {
    /// Spoils what `station` says, if this is an occasion for this fault and it strikes.
    pub(super) fn spoil_reply(&mut self, reply: &mut Outgoing, station: Option<Address>, now: Instant) {
        if reply.octets.is_empty() || !self.concerns(station) {
            return;
        }
        match self.fault.kind {
            Kind::NoReply => {
                if self.strikes() {
                    reply.octets.clear();
                }
            }
            Kind::Late(delay) => {
                if self.strikes() {
                    reply.delay = reply.delay.saturating_add(delay);
                }
            }
            Kind::Duplicate => {
                if self.strikes() {
                    reply.copies += 1;
                }
            }
            Kind::Truncated => {
                if self.strikes() {
                    let left = self.chance.random.below(reply.octets.len());
                    reply.octets.truncate(left);
                }
            }
            Kind::BitErrors(bits) => {
                if self.strikes() {
                    self.flip_bits(&mut reply.octets, bits);
                }
            }
            Kind::WrongFcs => {
                if data_telegram(&reply.octets).is_some() && self.strikes() {
                    // FCS is the last octet but one.
                    if let Some(fcs) = reply.octets.iter_mut().nth_back(1) {
                        *fcs = fcs.wrapping_add(1);
                    }
                }
            }
            Kind::WrongLength => {
                if let [SD2, le, ler, ..] = &mut reply.octets[..]
                    && self.strikes()
                {
                    *le = if *le < MAX_LE { *le + 1 } else { *le - 1 };
                    *ler = *le;
                }
            }
            Kind::WrongSource => {
                if let Some(telegram) = data_telegram(&reply.octets)
                    && self.strikes()
                {
                    let next = (telegram.sa.number() + 1) % Address::BROADCAST.number();
                    reply.octets = encoded(&DataTelegram { sa: Address::from_octet(next), ..telegram });
                }
            }
            Kind::Noise(octets) => {
                if self.strikes() {
                    reply.noise.extend((0..octets).map(|_| self.chance.random.octet()));
                }
            }
            Kind::DiagStorm => {
                if let Some(telegram) = inputs(&reply.octets)
                    && self.strikes()
                {
                    let fc = FunctionCode::response(ReplyStatus::DataHigh);
                    reply.octets = encoded(&DataTelegram { fc, ..telegram });
                }
            }
            Kind::NotReady(_) => {
                if let Some(telegram) = diagnosis(&reply.octets)
                    && self.is_not_ready(telegram.sa.number(), now)
                {
                    let mut data = telegram.data.to_vec();
                    if let Some(status_1) = data.first_mut() {
                        *status_1 |= STATION_NOT_READY;
                    }
                    reply.octets = encoded(&DataTelegram { data: &data, ..telegram });
                }
            }
            Kind::Pkw(fault) => {
                if let Some(telegram) = inputs(&reply.octets)
                    && telegram.data.len() == PPO_LEN
                    && let Some((pkw, pzd)) = telegram.data.split_first_chunk()
                {
                    let pkw = self.spoil_pkw(fault, telegram.sa.number(), Pkw::from_octets(*pkw));
                    let data = [&pkw.to_octets()[..], pzd].concat();
                    reply.octets = encoded(&DataTelegram { data: &data, ..telegram });
                }
            }
            Kind::DropRequest | Kind::RefusePrm | Kind::RefuseCfg | Kind::LosePrm => {}
        }
    }

    /// The PKW words the master gets instead of `pkw` of `station`.
    fn spoil_pkw(&mut self, fault: PkwFault, station: u8, pkw: Pkw) -> Pkw {
        let mut state = self.stations.get(&station).copied().unwrap_or_default();
        let changed = (pkw.pke, pkw.ind) != (state.sent.pke, state.sent.ind);
        if changed {
            state.spoilt = pkw.pke.ak() != 0 && self.strikes();
            state.exchanges = 0;
        }
        let spoilt = match fault {
            _ if !state.spoilt => pkw,
            PkwFault::Delay(exchanges) if state.exchanges < exchanges => state.shown,
            PkwFault::Delay(_) => pkw,
            PkwFault::WrongAk => with_pke(pkw, pkw.pke.raw() ^ wrong_ak(pkw.pke.ak())),
            PkwFault::WrongPnu => with_pke(pkw, pkw.pke.raw() ^ 1),
            PkwFault::Torn if changed => Pkw { pke: state.sent.pke, ind: state.sent.ind, ..pkw },
            PkwFault::Torn => pkw,
        };
        state.exchanges = state.exchanges.saturating_add(1);
        state.sent = pkw;
        state.shown = spoilt;
        self.stations.insert(station, state);
        spoilt
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
fn inputs(octets: &[u8]) -> Option<DataTelegram<'_>> {
    response_of(octets, Service::DataExchange).filter(|telegram| !telegram.data.is_empty())
}

/// A reply to Slave_Diag.
fn diagnosis(octets: &[u8]) -> Option<DataTelegram<'_>> {
    response_of(octets, Service::SlaveDiag)
}

/// A reply with data whose SAPs are those of `service`, the other way round than in its request.
fn response_of(octets: &[u8], service: Service) -> Option<DataTelegram<'_>> {
    let telegram = data_telegram(octets)?;
    let data =
        matches!(telegram.fc.function(), Function::Response(_, ReplyStatus::DataLow | ReplyStatus::DataHigh));
    (data && Service::of(telegram.ssap, telegram.dsap) == Some(service)).then_some(telegram)
}
