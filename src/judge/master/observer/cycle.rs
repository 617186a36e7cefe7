//! A request that wants a reply, and what came back.

use crate::profibus::dp;
use crate::profibus::fdl::telegram::{Decoded, decode};
use crate::profibus::fdl::{
    Address, DataTelegram, FrameCount, FrameError, Function, ReplyStatus, Sap, Service, StationType, Telegram,
};
use crate::time::Instant;

/// One request of the master to a station, until its next telegram.
#[derive(Clone, Debug)]
pub(super) struct Cycle {
    /// The number of the telegram.
    pub(super) serial: u64,
    /// When its last octet ended.
    pub(super) end: Instant,
    pub(super) to: Address,
    pub(super) from: Address,
    pub(super) octets: Vec<u8>,
    pub(super) kind: Service,
    /// The service of DP; `None` for FDL status and what no slave offers.
    pub(super) service: Option<dp::Service>,
    pub(super) count: FrameCount,
    saps: (Option<Sap>, Option<Sap>),
    /// How often it was repeated before.
    pub(super) retry: u32,
    /// How many requests to the station before it got no good answer, one after the other.
    pub(super) tries: u32,
    pub(super) items: Vec<Item>,
    /// When the last item began.
    pub(super) answered_at: Option<Instant>,
    /// The reply was an SD3.
    pub(super) sd3: bool,
    /// The judge itself was late: nothing is concluded.
    pub(super) void: bool,
}

/// What came from stations while a request was open.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Item {
    ShortAck,
    /// A good reply.
    Data {
        high: bool,
        octets: Vec<u8>,
    },
    Status(ReplyStatus),
    Bad(Bad),
}

/// Why a reply must be rejected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Bad {
    Fcs,
    Truncated,
    Delimiters,
    /// From another station.
    WrongSource,
    /// To another master.
    WrongDestination,
    /// The request bit, or a function that is none.
    RequestBit,
    StationType,
    Saps,
    Noise,
    /// Octets with one that looks like SC.
    Ambiguous,
}

/// The short acknowledge.
const SC: u8 = 0xE5;

/// What a request led to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Answer {
    Silence,
    ShortAck,
    Data {
        high: bool,
        octets: Vec<u8>,
    },
    Status(ReplyStatus),
    Bad(Bad),
    /// Several things, the first of them bad: accepting and rejecting are both right.
    Mixed,
}

impl Cycle {
    pub(super) fn new(serial: u64, end: Instant, octets: &[u8], request: &DataTelegram<'_>) -> Option<Self> {
        let Function::Request(kind, count) = request.fc.function() else {
            return None;
        };
        let service = match kind {
            Service::SrdLow | Service::SrdHigh => dp::Service::of(request.dsap, request.ssap),
            Service::TimeEvent
            | Service::SdaLow
            | Service::SdaHigh
            | Service::SdnLow
            | Service::SdnHigh
            | Service::Msrd
            | Service::FdlStatus
            | Service::Ident
            | Service::LsapStatus => None,
        };
        Some(Self {
            serial,
            end,
            to: request.da,
            from: request.sa,
            octets: octets.to_vec(),
            kind,
            service,
            count,
            saps: (request.dsap, request.ssap),
            retry: 0,
            tries: 0,
            items: Vec::new(),
            answered_at: None,
            sd3: false,
            void: false,
        })
    }

    /// The SAP of the slave; `None`: there is none.
    pub(super) fn dsap(&self) -> Option<u8> {
        self.saps.0.map(Sap::number)
    }

    /// The SAP of the master; `None`: there is none.
    pub(super) fn ssap(&self) -> Option<u8> {
        self.saps.1.map(Sap::number)
    }

    /// The user data of the request.
    pub(super) fn data(&self) -> &[u8] {
        match decode(&self.octets) {
            Decoded::Telegram { telegram: Telegram::Data(data), .. } => data.data,
            Decoded::Telegram { .. } | Decoded::Incomplete | Decoded::Invalid { .. } => &[],
        }
    }

    /// Whether FCV is set.
    pub(super) const fn is_counted(&self) -> bool {
        matches!(self.count, FrameCount::Even | FrameCount::Odd)
    }

    /// The reply was sent more than once.
    pub(super) fn is_doubled(&self) -> bool {
        self.items.len() > 1 && self.items.iter().all(|item| !matches!(item, Item::Bad(_)))
    }

    /// Something came that is no reply to it.
    pub(super) fn has_bad_item(&self) -> bool {
        self.items.iter().any(|item| matches!(item, Item::Bad(_)))
    }

    pub(super) fn answer(&self) -> Answer {
        match &self.items[..] {
            [] => Answer::Silence,
            [Item::Bad(Bad::Ambiguous)] => Answer::Mixed,
            [Item::Bad(bad)] => Answer::Bad(*bad),
            [Item::Bad(_), ..] => Answer::Mixed,
            [Item::ShortAck, ..] => Answer::ShortAck,
            [Item::Status(status), ..] => Answer::Status(*status),
            [Item::Data { high, octets }, ..] => Answer::Data { high: *high, octets: octets.clone() },
        }
    }

    /// What some octets of a station are, as the reply to this request.
    pub(super) fn classify(&self, octets: &[u8]) -> Item {
        let telegram = match decode(octets) {
            Decoded::Telegram { telegram, len } if len == octets.len() => telegram,
            Decoded::Telegram { .. } => return Item::Bad(Bad::Noise),
            // Who looks for telegrams in noise may find an acknowledge, and is right.
            Decoded::Incomplete | Decoded::Invalid { .. } if octets.contains(&SC) => {
                return Item::Bad(Bad::Ambiguous);
            }
            Decoded::Incomplete => return Item::Bad(Bad::Truncated),
            Decoded::Invalid { error, .. } => return Item::Bad(bad_frame(error)),
        };
        match telegram {
            Telegram::ShortAcknowledge => Item::ShortAck,
            Telegram::Token { .. } => Item::Bad(Bad::Noise),
            Telegram::Data(reply) => self.classify_reply(&reply),
        }
    }

    fn classify_reply(&self, reply: &DataTelegram<'_>) -> Item {
        let (station_type, status) = match reply.fc.function() {
            Function::Response(station_type, status) => (station_type, status),
            Function::Request(..) | Function::Reserved => return Item::Bad(Bad::RequestBit),
        };
        if reply.sa != self.to {
            return Item::Bad(Bad::WrongSource);
        }
        if reply.da != self.from {
            return Item::Bad(Bad::WrongDestination);
        }
        if self.kind != Service::FdlStatus && station_type != StationType::Slave {
            return Item::Bad(Bad::StationType);
        }
        let high = match status {
            ReplyStatus::DataLow => false,
            ReplyStatus::DataHigh => true,
            ReplyStatus::Ok
            | ReplyStatus::UserError
            | ReplyStatus::NoResource
            | ReplyStatus::NotActivated
            | ReplyStatus::NotReady
            | ReplyStatus::NoResourceDataLow
            | ReplyStatus::NoResourceDataHigh => return Item::Status(status),
        };
        let (dsap, ssap) = self.saps;
        if !reply.data.is_empty() && (reply.dsap, reply.ssap) != (ssap, dsap) {
            return Item::Bad(Bad::Saps);
        }
        Item::Data { high, octets: reply.data.to_vec() }
    }
}

const fn bad_frame(error: FrameError) -> Bad {
    match error {
        FrameError::Checksum { .. } => Bad::Fcs,
        FrameError::BrokenOff { .. } => Bad::Truncated,
        FrameError::Length { .. }
        | FrameError::RepeatedLength { .. }
        | FrameError::SecondStartDelimiter { .. }
        | FrameError::EndDelimiter { .. }
        | FrameError::ExtensionMissing
        | FrameError::Extension { .. } => Bad::Delimiters,
        FrameError::StartDelimiter { .. } | FrameError::TokenAddress { .. } | FrameError::Parity => {
            Bad::Noise
        }
    }
}

/// How a request follows on the one before to the same station.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Relation {
    /// FCV = 0, FCB = 1.
    First,
    /// The same octets.
    Repeated,
    /// FCV = 1, the FCB of before, other octets.
    SameBit,
    /// FCV = 1, the other FCB.
    Toggled,
    /// FCV = 0, FCB = 0.
    Uncounted,
}

impl Relation {
    pub(super) fn of(before: &Cycle, now: &Cycle) -> Self {
        let bit = |count: FrameCount| match count {
            FrameCount::First | FrameCount::Odd => true,
            FrameCount::Even | FrameCount::Unused => false,
        };
        match now.count {
            FrameCount::First => Self::First,
            FrameCount::Unused => Self::Uncounted,
            FrameCount::Even | FrameCount::Odd if now.octets == before.octets => Self::Repeated,
            FrameCount::Even | FrameCount::Odd if bit(now.count) == bit(before.count) => Self::SameBit,
            FrameCount::Even | FrameCount::Odd => Self::Toggled,
        }
    }
}
