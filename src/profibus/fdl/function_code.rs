//! The FC octet: what a telegram asks or answers.
//!
//! ```text
//! request   b7 = 0  b6 = 1  b5 = FCB  b4 = FCV   b3..b0 = service
//! response  b7 = 0  b6 = 0  b5..b4 = station type  b3..b0 = status
//! ```
//!
//! Source: `dp-v0.md` 2.2.

/// The FC octet as it is on the wire. Reserved values survive a decode and encode unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FunctionCode(u8);

impl FunctionCode {
    /// The code in `octet`.
    pub const fn from_octet(octet: u8) -> Self {
        Self(octet)
    }

    /// A request for `service`.
    pub const fn request(service: Service, frame_count: FrameCount) -> Self {
        Self(0x40 | frame_count.bits() | service as u8)
    }

    /// The answer of a slave with `status`.
    pub const fn response(status: ReplyStatus) -> Self {
        Self(status as u8)
    }

    /// The octet on the wire.
    pub const fn octet(self) -> u8 {
        self.0
    }

    /// What the code means.
    pub const fn function(self) -> Function {
        match (self.0 & 0xC0, self.0 & 0x0F) {
            (0x40, code) => match Service::from_code(code) {
                Some(service) => Function::Request(service, FrameCount::from_bits(self.0)),
                None => Function::Reserved,
            },
            (0x00, code) => match ReplyStatus::from_code(code) {
                Some(status) => Function::Response(StationType::from_bits(self.0), status),
                None => Function::Reserved,
            },
            (0x80.., _) | (0x01..=0x3F, _) | (0x41..=0x7F, _) => Function::Reserved,
        }
    }
}

/// The meaning of a function code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Function {
    /// b6 = 1: somebody asks.
    Request(Service, FrameCount),
    /// b6 = 0: somebody answers.
    Response(StationType, ReplyStatus),
    /// A code the standard keeps for itself, or the clock telegram of DP-V2 (b7 = 1).
    Reserved,
}

/// Services of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Service {
    /// Time event (DP-V2).
    TimeEvent = 0x0,
    /// Send Data with Acknowledge, low priority.
    SdaLow = 0x3,
    /// Send Data with No acknowledge, low priority.
    SdnLow = 0x4,
    /// Send Data with Acknowledge, high priority.
    SdaHigh = 0x5,
    /// Send Data with No acknowledge, high priority.
    SdnHigh = 0x6,
    /// Multicast Send and Request Data (DP-V2).
    Msrd = 0x7,
    /// Request FDL status.
    FdlStatus = 0x9,
    /// Send and Request Data, low priority.
    SrdLow = 0xC,
    /// Send and Request Data, high priority.
    SrdHigh = 0xD,
    /// Request identification.
    Ident = 0xE,
    /// Request LSAP status.
    LsapStatus = 0xF,
}

impl Service {
    /// What it is called.
    #[cfg(feature = "std")]
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::TimeEvent => "time event (DP-V2)",
            Self::SdaLow => "SDA low: send, acknowledge",
            Self::SdnLow => "SDN low: send, no acknowledge",
            Self::SdaHigh => "SDA high: send, acknowledge",
            Self::SdnHigh => "SDN high: send, no acknowledge",
            Self::Msrd => "MSRD: send and request data, multicast reply (DP-V2)",
            Self::FdlStatus => "request FDL status",
            Self::SrdLow => "SRD low: send and request data",
            Self::SrdHigh => "SRD high: send and request data",
            Self::Ident => "request ident",
            Self::LsapStatus => "request LSAP status",
        }
    }

    /// Whether a station answers this request.
    pub const fn wants_reply(self) -> bool {
        match self {
            Self::SdaLow
            | Self::SdaHigh
            | Self::Msrd
            | Self::FdlStatus
            | Self::SrdLow
            | Self::SrdHigh
            | Self::Ident
            | Self::LsapStatus => true,
            Self::TimeEvent | Self::SdnLow | Self::SdnHigh => false,
        }
    }

    const fn from_code(code: u8) -> Option<Self> {
        Some(match code {
            0x0 => Self::TimeEvent,
            0x3 => Self::SdaLow,
            0x4 => Self::SdnLow,
            0x5 => Self::SdaHigh,
            0x6 => Self::SdnHigh,
            0x7 => Self::Msrd,
            0x9 => Self::FdlStatus,
            0xC => Self::SrdLow,
            0xD => Self::SrdHigh,
            0xE => Self::Ident,
            0xF => Self::LsapStatus,
            0x1 | 0x2 | 0x8 | 0xA | 0xB | 0x10.. => return None,
        })
    }
}

/// The frame count of a request: FCV says whether FCB counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FrameCount {
    /// FCV = 0, FCB = 0: not counted (SDN, FDL status).
    Unused,
    /// FCV = 0, FCB = 1: the first cycle to a station.
    First,
    /// FCV = 1, FCB = 0.
    Even,
    /// FCV = 1, FCB = 1.
    Odd,
}

impl FrameCount {
    const fn from_bits(octet: u8) -> Self {
        match (octet & 0x10 != 0, octet & 0x20 != 0) {
            (false, false) => Self::Unused,
            (false, true) => Self::First,
            (true, false) => Self::Even,
            (true, true) => Self::Odd,
        }
    }

    const fn bits(self) -> u8 {
        match self {
            Self::Unused => 0x00,
            Self::First => 0x20,
            Self::Even => 0x10,
            Self::Odd => 0x30,
        }
    }
}

/// The kind of station that answers. A slave is always [`StationType::Slave`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StationType {
    /// A passive station.
    Slave,
    /// A master that is not ready for the token ring.
    MasterNotReady,
    /// A master that is ready but not in the ring.
    MasterReady,
    /// A master in the ring.
    MasterInRing,
}

impl StationType {
    const fn from_bits(octet: u8) -> Self {
        match (octet & 0x20 != 0, octet & 0x10 != 0) {
            (false, false) => Self::Slave,
            (false, true) => Self::MasterNotReady,
            (true, false) => Self::MasterReady,
            (true, true) => Self::MasterInRing,
        }
    }
}

/// The status of an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum ReplyStatus {
    /// OK: positive acknowledge.
    Ok = 0x0,
    /// UE: user error.
    UserError = 0x1,
    /// RR: no resource for the data.
    NoResource = 0x2,
    /// RS: service or SAP not activated.
    NotActivated = 0x3,
    /// DL: data, low priority.
    DataLow = 0x8,
    /// NR: no reply data ready.
    NotReady = 0x9,
    /// DH: data, high priority: a diagnosis is pending.
    DataHigh = 0xA,
    /// RDL: data low, the request's data were not taken.
    NoResourceDataLow = 0xC,
    /// RDH: data high, the request's data were not taken.
    NoResourceDataHigh = 0xD,
}

impl ReplyStatus {
    const fn from_code(code: u8) -> Option<Self> {
        Some(match code {
            0x0 => Self::Ok,
            0x1 => Self::UserError,
            0x2 => Self::NoResource,
            0x3 => Self::NotActivated,
            0x8 => Self::DataLow,
            0x9 => Self::NotReady,
            0xA => Self::DataHigh,
            0xC => Self::NoResourceDataLow,
            0xD => Self::NoResourceDataHigh,
            0x4..=0x7 | 0xB | 0xE.. => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_octet_keeps_its_value_and_has_one_meaning() {
        for octet in 0..=u8::MAX {
            let code = FunctionCode::from_octet(octet);
            assert_eq!(code.octet(), octet);
            match code.function() {
                Function::Request(service, count) => {
                    assert_eq!(FunctionCode::request(service, count), code);
                }
                Function::Response(StationType::Slave, status) => {
                    assert_eq!(FunctionCode::response(status), code);
                }
                Function::Response(..) => assert!((0x10..0x40).contains(&octet)),
                Function::Reserved => {}
            }
        }
    }

    #[test]
    fn the_codes_seen_on_real_buses() {
        use FrameCount::{Even, First, Odd, Unused};
        for (octet, service, count) in [
            (0x49, Service::FdlStatus, Unused),
            (0x6D, Service::SrdHigh, First),
            (0x5D, Service::SrdHigh, Even),
            (0x7D, Service::SrdHigh, Odd),
            (0x6C, Service::SrdLow, First),
            (0x46, Service::SdnHigh, Unused),
        ] {
            assert_eq!(FunctionCode::from_octet(octet).function(), Function::Request(service, count));
        }
        for (octet, status) in
            [(0x00, ReplyStatus::Ok), (0x03, ReplyStatus::NotActivated), (0x0A, ReplyStatus::DataHigh)]
        {
            assert_eq!(
                FunctionCode::from_octet(octet).function(),
                Function::Response(StationType::Slave, status)
            );
        }
        assert_eq!(FunctionCode::from_octet(0x80).function(), Function::Reserved);
    }
}
