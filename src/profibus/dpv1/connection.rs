//! What opens and ends a connection of a master of class 2: Initiate and Abort.
//!
//! ```text
//! Initiate.req   57 0 0 0  Send_Timeout(2)  features(2)  profile features(2)  profile number(2)
//!                S_Type S_Len D_Type D_Len  source address..  destination address..
//! Initiate.res   57 Max_Len_Data_Unit  features(2)  profile features(2)  profile number(2)
//!                S_Type S_Len D_Type D_Len  source address..  destination address..
//! Abort          58 subnet  b5..b4 instance, b3..b0 reason
//! ```
//!
//! Source: `dp-v1.md` 4.1.

use super::Function;
use super::pdu::{PduError, put, short};

/// A request for a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Initiate<'a> {
    /// The master sends something at least so often, times 10 ms.
    pub send_timeout: u16,
    /// What the master wants, and of whom.
    pub terms: Terms<'a>,
}

/// The answer of a slave that opens the connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InitiateResponse<'a> {
    /// Max_Len_Data_Unit: the most octets of data.
    pub max_len: u8,
    /// What the slave grants, and to whom.
    pub terms: Terms<'a>,
}

/// What either side says of the connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Terms<'a> {
    /// Features_Supported: [`READ_WRITE`].
    pub features: u16,
    /// What the profile offers.
    pub profile_features: u16,
    /// The number of the profile, 0: none, or none that the slave knows.
    pub profile_ident: u16,
    /// Who sends this.
    pub source: AdditionalAddress<'a>,
    /// Who gets it.
    pub destination: AdditionalAddress<'a>,
}

/// Features_Supported: Read and Write.
pub const READ_WRITE: u16 = 0x0100;

/// An address behind the station.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AdditionalAddress<'a> {
    /// S_Type or D_Type: 0 without, 1 with a network address.
    pub kind: u8,
    /// API, SCL, and with type 1 network and MAC address.
    pub octets: &'a [u8],
}

/// The octets before the terms.
const REQUEST_HEAD: usize = 6;
const RESPONSE_HEAD: usize = 2;
/// The octets of the terms before the addresses.
const TERMS_HEAD: usize = 10;

impl<'a> Initiate<'a> {
    pub(super) fn parse(octets: &'a [u8]) -> Result<Self, PduError> {
        let (head, terms) = Terms::behind::<REQUEST_HEAD>(octets)?;
        let [_, _, _, _, high, low] = *head;
        Ok(Self { send_timeout: u16::from_be_bytes([high, low]), terms })
    }

    pub(super) fn encode<'b>(&self, buf: &'b mut [u8]) -> Option<&'b [u8]> {
        let [high, low] = self.send_timeout.to_be_bytes();
        self.terms.encode(buf, &[Function::Initiate.number(), 0, 0, 0, high, low])
    }
}

impl<'a> InitiateResponse<'a> {
    pub(super) fn parse(octets: &'a [u8]) -> Result<Self, PduError> {
        let (head, terms) = Terms::behind::<RESPONSE_HEAD>(octets)?;
        let [_, max_len] = *head;
        Ok(Self { max_len, terms })
    }

    pub(super) fn encode<'b>(&self, buf: &'b mut [u8]) -> Option<&'b [u8]> {
        self.terms.encode(buf, &[Function::Initiate.number(), self.max_len])
    }
}

impl<'a> Terms<'a> {
    /// The terms and the octets before them.
    fn behind<const HEAD: usize>(octets: &'a [u8]) -> Result<(&'a [u8; HEAD], Self), PduError> {
        let parts = octets.split_first_chunk::<HEAD>();
        let Some((head, &[f1, f0, p1, p0, i1, i0, s_type, s_len, d_type, d_len, ref rest @ ..])) = parts
        else {
            return Err(short(Function::Initiate, HEAD + TERMS_HEAD, octets));
        };
        let expected = HEAD + TERMS_HEAD + usize::from(s_len) + usize::from(d_len);
        if octets.len() != expected {
            return Err(short(Function::Initiate, expected, octets));
        }
        let (source, destination) = rest.split_at_checked(s_len.into()).unwrap_or((rest, &[]));
        let terms = Self {
            features: u16::from_be_bytes([f1, f0]),
            profile_features: u16::from_be_bytes([p1, p0]),
            profile_ident: u16::from_be_bytes([i1, i0]),
            source: AdditionalAddress { kind: s_type, octets: source },
            destination: AdditionalAddress { kind: d_type, octets: destination },
        };
        Ok((head, terms))
    }

    fn encode<'b>(&self, buf: &'b mut [u8], head: &[u8]) -> Option<&'b [u8]> {
        put(
            buf,
            &[
                head,
                &self.features.to_be_bytes(),
                &self.profile_features.to_be_bytes(),
                &self.profile_ident.to_be_bytes(),
                &self.source.head()?,
                &self.destination.head()?,
                self.source.octets,
                self.destination.octets,
            ],
        )
    }
}

impl AdditionalAddress<'_> {
    /// The station itself: type 0, API 0, SCL 0.
    pub const STATION: AdditionalAddress<'static> = AdditionalAddress { kind: 0, octets: &[0, 0] };

    fn head(&self) -> Option<[u8; 2]> {
        Some([self.kind, u8::try_from(self.octets.len()).ok()?])
    }
}

/// Why and where a connection ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Abort {
    /// Where it was decided.
    pub subnet: Subnet,
    /// Which layer decided it.
    pub instance: Instance,
    /// Why.
    pub reason: AbortReason,
}

impl Abort {
    pub(super) fn parse(octets: &[u8]) -> Result<Self, PduError> {
        let [_, subnet, reason, ..] = *octets else {
            return Err(short(Function::Abort, 3, octets));
        };
        Ok(Self {
            subnet: match subnet {
                0 => Subnet::None,
                1 => Subnet::Local,
                2.. => Subnet::Remote,
            },
            instance: match reason >> 4 & 3 {
                0 => Instance::Fdl,
                1 => Instance::Msac2,
                2 => Instance::User,
                3.. => Instance::Reserved,
            },
            reason: AbortReason(reason & 0x0F),
        })
    }

    pub(super) const fn octets(self) -> [u8; 3] {
        [Function::Abort.number(), self.subnet as u8, (self.instance as u8) << 4 | self.reason.0 & 0x0F]
    }
}

/// Where an Abort comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Subnet {
    /// It says nothing.
    None = 0,
    /// The bus of the slave.
    Local = 1,
    /// Another one.
    Remote = 2,
}

/// Which layer aborts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Instance {
    /// Layer 2.
    Fdl = 0,
    /// The protocol of the connection.
    Msac2 = 1,
    /// Its user.
    User = 2,
    /// None.
    Reserved = 3,
}

/// The reason of an Abort, 0..=15.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct AbortReason(pub u8);

impl AbortReason {
    /// SE: a PDU that is out of place.
    pub const SEQUENCE: Self = Self(1);
    /// FE: a request that is none.
    pub const INVALID_REQUEST: Self = Self(2);
    /// TO: nothing came in time.
    pub const TIME_OUT: Self = Self(3);
    /// STO: the Send_Timeout asked for is too small.
    pub const SEND_TIMEOUT: Self = Self(6);
    /// IA: an additional address that the slave does not have.
    pub const ADDRESS: Self = Self(7);

    /// What it says.
    pub(crate) const fn words(self) -> &'static str {
        match self.0 {
            1 => "a PDU out of place",
            2 => "an invalid request",
            3 => "a time-out",
            4 => "an invalid response",
            5 => "an invalid service of the user",
            6 => "the Send_Timeout asked for is too small",
            7 => "an additional address that is not there",
            8 => "layer 2 was still at work",
            15 => "no resource",
            _ => "no reason said",
        }
    }
}
