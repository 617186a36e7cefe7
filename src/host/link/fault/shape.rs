//! Faults that give a reply another shape: its function code, addresses, SAPs, delimiters, format, length or FCS.

use super::observed::Occasion;
use super::reply::{inputs, response_of};
use super::{data_telegram, encoded};
use crate::host::fault::{DiagOctets, FramePart};
use crate::profibus::dp::Service;
use crate::profibus::fdl::telegram::Format;
use crate::profibus::fdl::{Address, DataTelegram, Function, FunctionCode, ReplyStatus, Sap};

/// The short acknowledge.
const SC: u8 = 0xE5;

/// The most that LE can be.
const MAX_LE: u8 = 249;

/// The first octet of a telegram with LE.
const SD2: u8 = 0x68;

/// LE of a telegram without data, which SD2 does not have.
const EMPTY_LE: u8 = 3;

/// Data octets of SD3.
const SD3_LEN: usize = 8;

/// The most octets of a device-related block, and its head.
const BLOCK: u8 = 63;

/// What becomes of a reply. The table of kinds ([`Row`](crate::host::fault::Row)) says it in words.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ShapeFault {
    WrongFcs,
    WrongLength,
    /// Of which station; `None`: of the next one.
    WrongSource(Option<Address>),
    DiagAnnounced,
    FunctionCode(u8),
    ShortAck,
    InputLength(u8),
    /// Which master; `None`: the next address.
    WrongDestination(Option<Address>),
    NoSaps,
    WrongSaps,
    BrokenFrame(FramePart),
    Sd3,
    Diagnosis(DiagOctets),
    DiagLength(u8),
}

/// What becomes of these octets. `None`: the fault does not concern them.
pub(super) fn shaped(fault: ShapeFault, octets: &[u8], occasion: Occasion) -> Option<Vec<u8>> {
    let telegram = data_telegram(octets);
    match fault {
        ShapeFault::WrongFcs => {
            telegram?;
            let mut wrong = octets.to_vec();
            // FCS is the last octet but one.
            let fcs = wrong.iter_mut().nth_back(1)?;
            *fcs = fcs.wrapping_add(1);
            Some(wrong)
        }
        ShapeFault::WrongLength => {
            let mut wrong = octets.to_vec();
            let [SD2, le, ler, ..] = &mut wrong[..] else { return None };
            *le = if *le < MAX_LE { *le + 1 } else { *le - 1 };
            *ler = *le;
            Some(wrong)
        }
        ShapeFault::WrongSource(of) => {
            let telegram = telegram?;
            let sa = of.unwrap_or(next(telegram.sa));
            Some(encoded(&DataTelegram { sa, ..telegram }))
        }
        ShapeFault::DiagAnnounced => {
            let fc = FunctionCode::response(ReplyStatus::DataHigh);
            Some(encoded(&DataTelegram { fc, ..inputs(octets)? }))
        }
        ShapeFault::FunctionCode(octet) => {
            let fc = FunctionCode::from_octet(octet);
            Some(encoded(&with_function_code(telegram, fc, occasion)?))
        }
        ShapeFault::ShortAck => Some([SC].into()),
        ShapeFault::InputLength(len) => {
            let telegram = inputs(octets)?;
            let mut data = telegram.data.to_vec();
            data.resize(len.into(), 0);
            let format = DataTelegram::customary_format(None, None, &data);
            Some(encoded(&DataTelegram { format, data: &data, ..telegram }))
        }
        ShapeFault::WrongDestination(of) => {
            let telegram = telegram?;
            let da = of.unwrap_or(next(telegram.da));
            Some(encoded(&DataTelegram { da, ..telegram }))
        }
        ShapeFault::NoSaps => {
            let telegram = telegram.filter(|telegram| telegram.ssap.is_some())?;
            let format = DataTelegram::customary_format(None, None, telegram.data);
            Some(encoded(&DataTelegram { format, dsap: None, ssap: None, ..telegram }))
        }
        ShapeFault::WrongSaps => {
            let telegram = telegram?;
            let ssap = Sap::new(telegram.ssap?.number() ^ 1);
            Some(encoded(&DataTelegram { ssap, ..telegram }))
        }
        ShapeFault::BrokenFrame(part) => {
            telegram.filter(|telegram| telegram.format == Format::Sd2)?;
            let mut broken = octets.to_vec();
            let place = match part {
                FramePart::Length => {
                    *broken.get_mut(1)? = EMPTY_LE;
                    *broken.get_mut(2)? = EMPTY_LE;
                    return Some(broken);
                }
                FramePart::Repeated => 2,
                FramePart::Start => 3,
                FramePart::End => broken.len() - 1,
            };
            let octet = broken.get_mut(place)?;
            *octet = octet.wrapping_add(1);
            Some(broken)
        }
        ShapeFault::Sd3 => {
            let telegram = telegram
                .filter(|telegram| telegram.data.len() == SD3_LEN)
                .filter(|telegram| telegram.dsap.is_none() && telegram.ssap.is_none())?;
            Some(encoded(&DataTelegram { format: Format::Sd3, ..telegram }))
        }
        ShapeFault::Diagnosis(wanted) => {
            let telegram = response_of(octets, Service::SlaveDiag)?;
            let mut data = telegram.data.to_vec();
            for (octet, wanted) in data.iter_mut().zip(wanted) {
                *octet = wanted.unwrap_or(*octet);
            }
            Some(encoded(&DataTelegram { data: &data, ..telegram }))
        }
        ShapeFault::DiagLength(len) => {
            let telegram = response_of(octets, Service::SlaveDiag)?;
            let data = with_length(telegram.data, len.into());
            Some(encoded(&DataTelegram { data: &data, ..telegram }))
        }
    }
}

/// The address behind this one.
const fn next(address: Address) -> Address {
    Address::from_octet((address.number() + 1) % Address::BROADCAST.number())
}

/// The reply with another function code. In the place of SC a telegram of the station that was asked.
fn with_function_code(
    telegram: Option<DataTelegram<'_>>,
    fc: FunctionCode,
    occasion: Occasion,
) -> Option<DataTelegram<'_>> {
    let carries_data = match fc.function() {
        Function::Response(
            _,
            ReplyStatus::DataLow
            | ReplyStatus::DataHigh
            | ReplyStatus::NoResourceDataLow
            | ReplyStatus::NoResourceDataHigh,
        )
        | Function::Request(..)
        | Function::Reserved => true,
        Function::Response(
            _,
            ReplyStatus::Ok
            | ReplyStatus::UserError
            | ReplyStatus::NoResource
            | ReplyStatus::NotActivated
            | ReplyStatus::NotReady,
        ) => false,
    };
    match telegram {
        Some(telegram) if carries_data => Some(DataTelegram { fc, ..telegram }),
        Some(DataTelegram { da, sa, .. }) => Some(status(da, sa, fc)),
        None => Some(status(occasion.master?, occasion.station?, fc)),
    }
}

const fn status(da: Address, sa: Address, fc: FunctionCode) -> DataTelegram<'static> {
    DataTelegram { format: Format::Sd1, da, sa, dsap: None, ssap: None, fc, data: &[] }
}

/// A diagnosis of `len` octets: cut off, or with device-related blocks behind it.
fn with_length(data: &[u8], len: usize) -> Vec<u8> {
    let mut data = data.to_vec();
    while data.len() + 1 < len {
        // A block of one octet does not exist: the last but one leaves room for two.
        let room = len - data.len();
        let block = if room == usize::from(BLOCK) + 1 { BLOCK - 1 } else { BLOCK };
        let block = u8::try_from(room).map_or(block, |room| room.min(block));
        data.push(block);
        data.resize(data.len() + usize::from(block) - 1, 0xAA);
    }
    // One octet more is a revision.
    data.resize(len.max(data.len()), 0xC0);
    data.truncate(len);
    data
}
