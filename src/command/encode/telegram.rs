//! Telegrams of any service.

use crate::explain::Mode;
use crate::profibus::dp;
use crate::profibus::dp::{ControlBit, PrmBit};
use crate::profibus::fdl;
use crate::profibus::fdl::telegram::Format;
use crate::profibus::fdl::{
    Address, DataTelegram, FrameCount, FunctionCode, MAX_TELEGRAM_LEN, Sap, Telegram,
};
use crate::profibus::ppo::{Outputs, Pkw, Stw};

use super::words::word_of;
use super::{octets_of, pkw_of, words_of_list};
use crate::command::Failure;
use crate::command::args::{self, Control, Fcb, Service};

/// The octets of the telegram.
pub(super) fn build(args: &args::Telegram, mode: Mode) -> Result<Vec<u8>, Failure> {
    let (slave, master) = (Address::from_octet(args.address), Address::from_octet(args.master));
    let content = match content(args, mode)? {
        Carries::Data(content) => content,
        Carries::Token => return written(Telegram::Token { da: slave, sa: master }, None),
        Carries::ShortAcknowledge => return written(Telegram::ShortAcknowledge, None),
    };
    let Content { fc, dsap, ssap, data } = content;
    let format = match args.sd3 {
        true => Format::Sd3,
        false => DataTelegram::customary_format(dsap, ssap, &data),
    };
    let telegram = DataTelegram { format, da: slave, sa: master, dsap, ssap, fc, data: &data };
    written(Telegram::Data(telegram), args.fcs)
}

/// A telegram apart from its addresses.
struct Content {
    fc: FunctionCode,
    dsap: Option<Sap>,
    ssap: Option<Sap>,
    data: Vec<u8>,
}

enum Carries {
    Data(Content),
    Token,
    ShortAcknowledge,
}

fn content(args: &args::Telegram, mode: Mode) -> Result<Carries, Failure> {
    let count = match args.fcb {
        Fcb::First => FrameCount::First,
        Fcb::Zero => FrameCount::Even,
        Fcb::One => FrameCount::Odd,
        Fcb::None => FrameCount::Unused,
    };
    let (srd, sdn) = match args.low {
        true => (fdl::Service::SrdLow, fdl::Service::SdnLow),
        false => (fdl::Service::SrdHigh, fdl::Service::SdnHigh),
    };
    let carry = |fc, service: dp::Service, data| {
        let dsap = service.sap();
        Carries::Data(Content { fc, dsap, ssap: dsap.and(dp::MASTER_SAP), data })
    };
    let request = |service, data| carry(FunctionCode::request(srd, count), service, data);
    Ok(match &args.service {
        Service::FdlStatus => {
            let fc = FunctionCode::request(fdl::Service::FdlStatus, FrameCount::Unused);
            Carries::Data(Content { fc, dsap: None, ssap: None, data: Vec::new() })
        }
        Service::RdInp => request(dp::Service::RdInp, Vec::new()),
        Service::RdOutp => request(dp::Service::RdOutp, Vec::new()),
        Service::GetCfg => request(dp::Service::GetCfg, Vec::new()),
        Service::Diag => request(dp::Service::SlaveDiag, Vec::new()),
        Service::SetPrm { .. } => request(dp::Service::SetPrm, set_prm(&args.service)?),
        Service::ChkCfg { identifiers } if identifiers.is_empty() => {
            request(dp::Service::ChkCfg, Vec::from([0xF3, 0xF2]))
        }
        Service::ChkCfg { identifiers } => request(dp::Service::ChkCfg, octets_of(identifiers)?),
        Service::SetSlaveAdd { new, ident, no_change } => {
            let [high, low] = ident.to_be_bytes();
            request(dp::Service::SetSlaveAdd, Vec::from([*new, high, low, if *no_change { 0xFF } else { 0 }]))
        }
        Service::GlobalControl { commands, groups } => {
            let command = commands.iter().fold(0, |octet, command| octet | bit_of(*command).mask());
            let fc = FunctionCode::request(sdn, FrameCount::Unused);
            let data = Vec::from([command, mask_of(groups)]);
            carry(fc, dp::Service::GlobalControl, data)
        }
        Service::DataExchange { data, pkw, stw, setpoint } => {
            let data = match data.is_empty() {
                false => octets_of(data)?,
                true => {
                    let pkw = pkw.as_deref().map_or(Ok(Pkw::ZERO), pkw_of)?;
                    let stw = Stw::from_raw(word_of(&words_of_list()?.stw, stw, mode)?);
                    Outputs::octets(pkw, stw, *setpoint).into()
                }
            };
            request(dp::Service::DataExchange, data)
        }
        Service::Token => Carries::Token,
        Service::ShortAcknowledge => Carries::ShortAcknowledge,
        Service::Raw { fc, dsap, ssap, data } => {
            let fc = FunctionCode::from_octet(*fc);
            let (dsap, ssap) = (dsap.and_then(Sap::new), ssap.and_then(Sap::new));
            Carries::Data(Content { fc, dsap, ssap, data: octets_of(data)? })
        }
    })
}

/// `dp::set_prm` draws the octets.
fn set_prm(service: &Service) -> Result<Vec<u8>, Failure> {
    let Service::SetPrm { ident, watchdog, min_tsdr, groups, unlock, no_lock, sync, freeze, user } = service
    else {
        return Ok(Vec::new());
    };
    let factors = match watchdog {
        0 => (0, 0),
        1..10 => {
            return Err(Failure::Usage(format!(
                "a watchdog of {watchdog} ms is too short; the shortest is 10 ms, and 0 turns it off"
            )));
        }
        millis => factors(millis.div_ceil(10)).ok_or_else(|| {
            Failure::Usage(format!("a watchdog of {millis} ms is too long; the longest is 650250 ms"))
        })?,
    };
    let bits = [
        (PrmBit::LockReq, !no_lock && !unlock),
        (PrmBit::UnlockReq, *unlock),
        (PrmBit::SyncReq, *sync),
        (PrmBit::FreezeReq, *freeze),
        (PrmBit::WdOn, *watchdog > 0),
    ];
    let status = bits.iter().fold(0, |octet, (bit, set)| octet | if *set { bit.mask() } else { 0 });
    let [high, low] = ident.to_be_bytes();
    let mut data = Vec::from([status, factors.0, factors.1, *min_tsdr, high, low, mask_of(groups)]);
    data.extend(octets_of(user)?);
    Ok(data)
}

/// WD_Fact_1 and WD_Fact_2 whose product is the smallest that is not below `product`, as near to each other as can be.
fn factors(product: u32) -> Option<(u8, u8)> {
    let pairs = (1..=u8::MAX).filter_map(|first| {
        let second = u8::try_from(product.div_ceil(first.into())).ok()?;
        Some((first, second.max(1)))
    });
    pairs.min_by_key(|(first, second)| (u32::from(*first) * u32::from(*second), first.abs_diff(*second)))
}

const fn bit_of(command: Control) -> ControlBit {
    match command {
        Control::Clear => ControlBit::ClearData,
        Control::Unfreeze => ControlBit::Unfreeze,
        Control::Freeze => ControlBit::Freeze,
        Control::Unsync => ControlBit::Unsync,
        Control::Sync => ControlBit::Sync,
    }
}

/// The octet with a bit for each of the groups 1 to 8.
fn mask_of(groups: &[u8]) -> u8 {
    groups.iter().fold(0, |mask, group| mask | 1_u8.checked_shl(u32::from(*group) - 1).unwrap_or(0))
}

fn written(telegram: Telegram<'_>, fcs: Option<u8>) -> Result<Vec<u8>, Failure> {
    let mut buf = [0; MAX_TELEGRAM_LEN];
    let octets = telegram.encode(&mut buf).map_err(|error| Failure::Usage(error.to_string()))?;
    let mut octets = Vec::from(octets);
    if let (Some(fcs), [.., place, _]) = (fcs, octets.as_mut_slice()) {
        *place = fcs;
    }
    Ok(octets)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn watchdog_factors_make_the_time_or_the_next_longer_one() {
        for (product, factors_of) in [
            (1, Some((1, 1))),
            (20, Some((4, 5))),
            (100, Some((10, 10))),
            (65_025, Some((255, 255))),
            (65_026, None),
        ] {
            assert_eq!(factors(product), factors_of, "{product}");
        }
        for product in 1..=65_025 {
            let (first, second) = factors(product).unwrap();
            let made = u32::from(first) * u32::from(second);
            assert!(made >= product && made <= product + 255, "{product}: {made}");
        }
    }

    #[test]
    fn groups_are_bits() {
        assert_eq!(mask_of(&[]), 0);
        assert_eq!(mask_of(&[1, 8]), 0x81);
    }
}
