//! What came back.

use super::request::Request;
use crate::profibus::dp::DiagBit;
use crate::profibus::fdl::telegram::Format;
use crate::profibus::fdl::telegram::{Decoded, decode};
use crate::profibus::fdl::{DataTelegram, Function, ReplyStatus, Sap, StationType, Telegram};

/// The answer to a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Answer {
    /// Nothing.
    Silence,
    /// SC.
    Acknowledged,
    /// A status without data.
    Status(ReplyStatus),
    /// Data with their status.
    Data(ReplyStatus, Vec<u8>),
    /// No answer at all, for this reason.
    Wrong(String),
}

impl Answer {
    /// What these octets say.
    pub(super) fn of(octets: &[u8]) -> Self {
        match decode(octets) {
            Decoded::Telegram { len, .. } if len < octets.len() => {
                Self::Wrong(format!("{} octets behind the telegram", octets.len() - len))
            }
            Decoded::Telegram { telegram: Telegram::ShortAcknowledge, .. } => Self::Acknowledged,
            Decoded::Telegram { telegram: Telegram::Token { .. }, .. } => Self::Wrong("a token".into()),
            Decoded::Telegram { telegram: Telegram::Data(data), .. } => match data.fc.function() {
                Function::Response(_, status) if data.data.is_empty() && data.dsap.is_none() => {
                    Self::Status(status)
                }
                Function::Response(_, status) => Self::Data(status, data.data.to_vec()),
                Function::Request(..) => Self::Wrong("a request".into()),
                Function::Reserved => {
                    Self::Wrong(format!("the function code {:02X}, which is reserved", data.fc.octet()))
                }
            },
            Decoded::Incomplete => Self::Wrong(format!("{} octets of an unfinished telegram", octets.len())),
            Decoded::Invalid { error, .. } => Self::Wrong(format!("octets that are no telegram: {error}")),
        }
    }

    /// In a word.
    pub(super) fn words(&self) -> String {
        match self {
            Self::Silence => "no reply".into(),
            Self::Acknowledged => "SC".into(),
            Self::Status(status) => short(*status).into(),
            Self::Data(status, data) => format!("{} with {} octets", short(*status), data.len()),
            Self::Wrong(why) => why.clone(),
        }
    }

    /// Whether it is this status without data.
    pub(super) fn is_status(&self, expected: ReplyStatus) -> bool {
        *self == Self::Status(expected)
    }
}

/// The short name of a status.
pub(super) const fn short(status: ReplyStatus) -> &'static str {
    match status {
        ReplyStatus::Ok => "OK",
        ReplyStatus::UserError => "UE",
        ReplyStatus::NoResource => "RR",
        ReplyStatus::NotActivated => "RS",
        ReplyStatus::DataLow => "DL",
        ReplyStatus::NotReady => "NR",
        ReplyStatus::DataHigh => "DH",
        ReplyStatus::NoResourceDataLow => "RDL",
        ReplyStatus::NoResourceDataHigh => "RDH",
    }
}

/// What is wrong with the form of an answer to a request, whatever it says.
pub(super) fn misformed(request: &Request, octets: &[u8]) -> Option<String> {
    let Decoded::Telegram { telegram: Telegram::Data(reply), .. } = decode(octets) else { return None };
    let DataTelegram { da, sa, dsap, ssap, fc, .. } = reply;
    if (da.number(), sa.number()) != (request.sa, request.da) {
        return Some(format!("from {sa} to {da}, expected from {} to {}", request.da, request.sa));
    }
    if let Function::Response(kind, _) = fc.function()
        && kind != StationType::Slave
    {
        return Some("its station type is that of a master".into());
    }
    let saps = (dsap.map(Sap::number), ssap.map(Sap::number));
    // A status needs none, as SC has none.
    let has_data = !reply.data.is_empty() || dsap.is_some() || ssap.is_some();
    let mirrored = (request.ssap, request.dsap);
    (has_data && saps != mirrored).then(|| {
        let words = |sap: Option<u8>| sap.map_or("none".into(), |sap: u8| sap.to_string());
        format!(
            "DSAP {} and SSAP {}, expected {} and {}",
            words(saps.0),
            words(saps.1),
            words(mirrored.0),
            words(mirrored.1)
        )
    })
}

/// Whether a telegram has the format SD3.
pub(super) fn is_sd3(octets: &[u8]) -> bool {
    matches!(
        decode(octets),
        Decoded::Telegram { telegram: Telegram::Data(DataTelegram { format: Format::Sd3, .. }), .. }
    )
}

/// A diagnosis.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Diagnosis(pub(super) Vec<u8>);

/// Master_Add of a slave without owner.
pub(super) const NO_MASTER: u8 = 255;

impl Diagnosis {
    pub(super) fn is(&self, bit: DiagBit) -> bool {
        bit.is_set(&self.0)
    }

    /// Master_Add.
    pub(super) fn master(&self) -> u8 {
        self.0.get(3).copied().unwrap_or(NO_MASTER)
    }

    pub(super) fn ident(&self) -> u16 {
        match self.0[..] {
            [_, _, _, _, high, low, ..] => u16::from_be_bytes([high, low]),
            [..] => 0,
        }
    }

    /// The bits that are set, by name.
    pub(super) fn words(&self) -> String {
        let set: Vec<&str> = DiagBit::ALL
            .iter()
            .filter(|bit| **bit != DiagBit::Always1 && self.is(**bit))
            .map(|bit| bit.name())
            .collect();
        match (&set[..], self.master()) {
            ([], NO_MASTER) => "nothing".into(),
            ([], master) => format!("Master_Add {master}"),
            (_, NO_MASTER) => set.join(", "),
            (_, master) => format!("{}, Master_Add {master}", set.join(", ")),
        }
    }
}
