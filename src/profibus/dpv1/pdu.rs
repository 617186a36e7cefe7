//! The PDUs behind the service access points of DP-V1: what a master asks, and what a slave answers.
//!
//! ```text
//!                   request                          response
//! Read              5E slot index length             5E slot index n data
//! Write             5F slot index n data             5F slot index n
//! Data_Transport    51 slot index n data             51 slot index n data
//! Alarm_Ack         5C slot type specifier           5C slot type specifier
//! Initiate          57 ..                            57 ..
//! Idle              48                               48
//! Abort             58 subnet reason ..              58 subnet reason ..
//! RM                -                                56 SAP time-out
//! refused                                            function | 80h, Error_Decode, Error_Code_1, Error_Code_2
//! ```
//!
//! Source: `dp-v1.md` 2 to 4.

use thiserror::Error;

use super::connection::{Abort, Initiate, InitiateResponse};
use super::{AlarmHead, Failure, Function, MAX_DATA};

/// What a master asks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RequestPdu<'a> {
    /// Read a record.
    Read {
        /// 0: the station; 1..: its modules.
        slot: u8,
        /// Which record.
        index: u8,
        /// The most octets that are wanted.
        len: u8,
    },
    /// Write a record.
    Write {
        /// 0: the station; 1..: its modules.
        slot: u8,
        /// Which record.
        index: u8,
        /// Its new octets.
        data: &'a [u8],
    },
    /// Give octets to the application of the slave, and take its answer.
    DataTransport {
        /// 0: the station; 1..: its modules.
        slot: u8,
        /// Which record.
        index: u8,
        /// The octets.
        data: &'a [u8],
    },
    /// An alarm was understood.
    AlarmAck(AlarmHead),
    /// Open a connection.
    Initiate(Initiate<'a>),
    /// The connection is wanted still.
    Idle,
    /// End the connection.
    Abort(Abort),
}

/// What a slave answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResponsePdu<'a> {
    /// The octets of a record.
    Read {
        /// As asked.
        slot: u8,
        /// As asked.
        index: u8,
        /// What is in it.
        data: &'a [u8],
    },
    /// A record was written.
    Write {
        /// As asked.
        slot: u8,
        /// As asked.
        index: u8,
        /// How many octets.
        len: u8,
    },
    /// What the application answers.
    DataTransport {
        /// As asked.
        slot: u8,
        /// As asked.
        index: u8,
        /// The octets.
        data: &'a [u8],
    },
    /// The acknowledgement of an alarm was taken.
    AlarmAck(AlarmHead),
    /// Where the connection that was asked for listens.
    ResourceManager {
        /// The SAP of the connection, 0..=48.
        sap: u8,
        /// The least Send_Timeout of the slave, times 10 ms.
        send_timeout: u16,
    },
    /// The connection is open.
    Initiate(InitiateResponse<'a>),
    /// The slave is there still.
    Idle,
    /// The slave ends the connection.
    Abort(Abort),
    /// The service was not carried out.
    Negative {
        /// The function number asked for, without bit 7.
        function: u8,
        /// Why not.
        failure: Failure,
    },
}

/// Why octets are no PDU.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum PduError {
    /// No octets: a poll, which has no PDU.
    #[error("no octets")]
    Empty,
    /// No service has this function number here.
    #[error("function number {got:02X} is none of DP-V1 here")]
    Function {
        /// The function number.
        got: u8,
    },
    /// Too short or too long for its function.
    #[error("{} has {got} octets, expected {expected} or more", function.name())]
    Short {
        /// The function.
        function: Function,
        /// The fewest octets.
        expected: usize,
        /// Octets found.
        got: usize,
    },
    /// The length octet does not agree with the octets behind it.
    #[error("{}: the length octet says {said}, {got} octets follow", function.name())]
    Length {
        /// The function.
        function: Function,
        /// What the octet says.
        said: usize,
        /// Octets found.
        got: usize,
    },
}

impl<'a> RequestPdu<'a> {
    /// Reads the octets of a request.
    ///
    /// # Errors
    /// [`PduError`]
    pub fn parse(octets: &'a [u8]) -> Result<Self, PduError> {
        let (function, rest) = head(octets)?;
        Ok(match function {
            Function::Read => match *rest {
                [slot, index, len] => Self::Read { slot, index, len },
                [_, _, said, ref data @ ..] => return Err(disagree(function, said, data)),
                [..] => return Err(short(function, 4, octets)),
            },
            Function::Write => {
                let (slot, index, data) = sized(function, octets, rest)?;
                Self::Write { slot, index, data }
            }
            Function::DataTransport => {
                let (slot, index, data) = sized(function, octets, rest)?;
                Self::DataTransport { slot, index, data }
            }
            Function::AlarmAck => Self::AlarmAck(acknowledged(octets, rest)?),
            Function::Initiate => Self::Initiate(Initiate::parse(octets)?),
            Function::Idle => Self::Idle,
            Function::Abort => Self::Abort(Abort::parse(octets)?),
            Function::ResourceManager => return Err(PduError::Function { got: function.number() }),
        })
    }

    /// Writes the octets to `buf`; `None` if they do not fit or have no length octet for so much.
    pub fn encode<'b>(&self, buf: &'b mut [u8]) -> Option<&'b [u8]> {
        match self {
            Self::Read { slot, index, len } => put(buf, &[&[Function::Read.number(), *slot, *index, *len]]),
            Self::Write { slot, index, data } => put_sized(buf, Function::Write, *slot, *index, data),
            Self::DataTransport { slot, index, data } => {
                put_sized(buf, Function::DataTransport, *slot, *index, data)
            }
            Self::AlarmAck(head) => put(buf, &[&[Function::AlarmAck.number()], &head.acknowledged()]),
            Self::Initiate(initiate) => initiate.encode(buf),
            Self::Idle => put(buf, &[&[Function::Idle.number()]]),
            Self::Abort(abort) => put(buf, &[&abort.octets()]),
        }
    }
}

impl<'a> ResponsePdu<'a> {
    /// Reads the octets of a response.
    ///
    /// # Errors
    /// [`PduError`]
    pub fn parse(octets: &'a [u8]) -> Result<Self, PduError> {
        if let [number @ 0x80..=0xFF, ref rest @ ..] = *octets {
            let number = number & !Function::NEGATIVE;
            let function = Function::numbered(number).ok_or(PduError::Function { got: number })?;
            return match *rest {
                [decode, code, detail] => {
                    let failure = Failure::from_octets([decode, code, detail]);
                    Ok(Self::Negative { function: number, failure })
                }
                [..] => Err(short(function, 4, octets)),
            };
        }
        let (function, rest) = head(octets)?;
        Ok(match function {
            Function::Read => {
                let (slot, index, data) = sized(function, octets, rest)?;
                Self::Read { slot, index, data }
            }
            Function::Write => match *rest {
                [slot, index, len] => Self::Write { slot, index, len },
                [_, _, said, ref data @ ..] => return Err(disagree(function, said, data)),
                [..] => return Err(short(function, 4, octets)),
            },
            Function::DataTransport => {
                let (slot, index, data) = sized(function, octets, rest)?;
                Self::DataTransport { slot, index, data }
            }
            Function::AlarmAck => Self::AlarmAck(acknowledged(octets, rest)?),
            Function::ResourceManager => match *rest {
                [sap, high, low] => {
                    Self::ResourceManager { sap, send_timeout: u16::from_be_bytes([high, low]) }
                }
                [..] => return Err(short(function, 4, octets)),
            },
            Function::Initiate => Self::Initiate(InitiateResponse::parse(octets)?),
            Function::Idle => Self::Idle,
            Function::Abort => Self::Abort(Abort::parse(octets)?),
        })
    }

    /// Writes the octets to `buf`; `None` if they do not fit or have no length octet for so much.
    pub fn encode<'b>(&self, buf: &'b mut [u8]) -> Option<&'b [u8]> {
        match self {
            Self::Read { slot, index, data } => put_sized(buf, Function::Read, *slot, *index, data),
            Self::Write { slot, index, len } => put(buf, &[&[Function::Write.number(), *slot, *index, *len]]),
            Self::DataTransport { slot, index, data } => {
                put_sized(buf, Function::DataTransport, *slot, *index, data)
            }
            Self::AlarmAck(head) => put(buf, &[&[Function::AlarmAck.number()], &head.acknowledged()]),
            Self::ResourceManager { sap, send_timeout } => {
                put(buf, &[&[Function::ResourceManager.number(), *sap], &send_timeout.to_be_bytes()])
            }
            Self::Initiate(response) => response.encode(buf),
            Self::Idle => put(buf, &[&[Function::Idle.number()]]),
            Self::Abort(abort) => put(buf, &[&abort.octets()]),
            Self::Negative { function, failure } => {
                put(buf, &[&[function | Function::NEGATIVE], &failure.octets()])
            }
        }
    }
}

/// The function of octets and what is behind its number.
fn head(octets: &[u8]) -> Result<(Function, &[u8]), PduError> {
    let (number, rest) = octets.split_first().ok_or(PduError::Empty)?;
    let function = Function::numbered(*number).ok_or(PduError::Function { got: *number })?;
    Ok((function, rest))
}

/// Slot, index and the octets that the length octet announces.
fn sized<'a>(function: Function, octets: &[u8], rest: &'a [u8]) -> Result<(u8, u8, &'a [u8]), PduError> {
    match *rest {
        [slot, index, said, ref data @ ..] if usize::from(said) == data.len() => Ok((slot, index, data)),
        [_, _, said, ref data @ ..] => Err(disagree(function, said, data)),
        [..] => Err(short(function, 4, octets)),
    }
}

fn acknowledged(octets: &[u8], rest: &[u8]) -> Result<AlarmHead, PduError> {
    match *rest {
        [slot, kind, specifier] => Ok(AlarmHead::of(kind, slot, specifier)),
        [..] => Err(short(Function::AlarmAck, 4, octets)),
    }
}

pub(super) const fn short(function: Function, expected: usize, octets: &[u8]) -> PduError {
    PduError::Short { function, expected, got: octets.len() }
}

fn disagree(function: Function, said: u8, data: &[u8]) -> PduError {
    PduError::Length { function, said: said.into(), got: data.len() }
}

fn put_sized<'b>(
    buf: &'b mut [u8],
    function: Function,
    slot: u8,
    index: u8,
    data: &[u8],
) -> Option<&'b [u8]> {
    let len = u8::try_from(data.len()).ok().filter(|len| *len <= MAX_DATA)?;
    put(buf, &[&[function.number(), slot, index, len], data])
}

/// The parts, one behind the other.
pub(super) fn put<'b>(buf: &'b mut [u8], parts: &[&[u8]]) -> Option<&'b [u8]> {
    let mut len = 0;
    for part in parts {
        buf.get_mut(len..len + part.len())?.copy_from_slice(part);
        len += part.len();
    }
    buf.get(..len)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::profibus::dpv1::connection::{AbortReason, AdditionalAddress, Instance, Subnet, Terms};
    use crate::profibus::dpv1::{AlarmType, ErrorCode, Specifier};

    const TERMS: Terms<'static> = Terms {
        features: 0x0100,
        profile_features: 0,
        profile_ident: 0,
        source: AdditionalAddress { kind: 0, octets: &[0, 0] },
        destination: AdditionalAddress { kind: 0, octets: &[0, 0] },
    };

    #[test]
    fn requests_are_the_octets_of_the_reference() {
        let head = AlarmHead {
            kind: AlarmType::Process,
            slot: 1,
            sequence: 0,
            additional_ack: false,
            specifier: Specifier::Appears,
        };
        let initiate = Initiate { send_timeout: 100, terms: TERMS };
        let by_user = Abort { subnet: Subnet::None, instance: Instance::User, reason: AbortReason(0) };
        for (pdu, octets) in [
            (RequestPdu::Read { slot: 1, index: 10, len: 8 }, &[0x5E, 0x01, 0x0A, 0x08][..]),
            (
                RequestPdu::Write { slot: 1, index: 10, data: &[0xAA, 0xBB, 0xCC, 0xDD] },
                &[0x5F, 0x01, 0x0A, 0x04, 0xAA, 0xBB, 0xCC, 0xDD],
            ),
            (RequestPdu::DataTransport { slot: 0, index: 1, data: &[7] }, &[0x51, 0x00, 0x01, 0x01, 0x07]),
            (RequestPdu::AlarmAck(head), &[0x5C, 0x01, 0x02, 0x01]),
            (
                RequestPdu::Initiate(initiate),
                &[0x57, 0, 0, 0, 0, 0x64, 1, 0, 0, 0, 0, 0, 0, 2, 0, 2, 0, 0, 0, 0],
            ),
            (RequestPdu::Idle, &[0x48]),
            (RequestPdu::Abort(by_user), &[0x58, 0x00, 0x20]),
        ] {
            assert_eq!(pdu.encode(&mut [0; 244]), Some(octets), "{pdu:?}");
            assert_eq!(RequestPdu::parse(octets), Ok(pdu));
        }
    }

    #[test]
    fn responses_are_the_octets_of_the_reference() {
        let accepted = InitiateResponse { max_len: 240, terms: TERMS };
        let time_out =
            Abort { subnet: Subnet::Local, instance: Instance::Msac2, reason: AbortReason::TIME_OUT };
        let failure = Failure::of(ErrorCode::INVALID_INDEX);
        for (pdu, octets) in [
            (
                ResponsePdu::Read { slot: 1, index: 10, data: &[0x11, 0x22, 0x33, 0x44] },
                &[0x5E, 0x01, 0x0A, 0x04, 0x11, 0x22, 0x33, 0x44][..],
            ),
            (ResponsePdu::Write { slot: 1, index: 10, len: 4 }, &[0x5F, 0x01, 0x0A, 0x04]),
            (ResponsePdu::Negative { function: 0x5E, failure }, &[0xDE, 0x80, 0xB0, 0x00]),
            (ResponsePdu::ResourceManager { sap: 48, send_timeout: 10 }, &[0x56, 0x30, 0x00, 0x0A]),
            (ResponsePdu::Initiate(accepted), &[0x57, 0xF0, 1, 0, 0, 0, 0, 0, 0, 2, 0, 2, 0, 0, 0, 0]),
            (ResponsePdu::Idle, &[0x48]),
            (ResponsePdu::Abort(time_out), &[0x58, 0x01, 0x13]),
        ] {
            assert_eq!(pdu.encode(&mut [0; 244]), Some(octets), "{pdu:?}");
            assert_eq!(ResponsePdu::parse(octets), Ok(pdu));
        }
    }

    #[test]
    fn what_is_cut_off_is_refused_at_each_octet() {
        for whole in [
            &[0x5E, 0x01, 0x0A, 0x08][..],
            &[0x5F, 0x01, 0x0A, 0x02, 1, 2],
            &[0x5C, 0x01, 0x02, 0x01],
            &[0x57, 0, 0, 0, 0, 0x64, 1, 0, 0, 0, 0, 0, 0, 2, 0, 2, 0, 0, 0, 0],
            &[0x58, 0, 0x20],
        ] {
            assert!(RequestPdu::parse(whole).is_ok());
            for len in 0..whole.len() {
                assert!(RequestPdu::parse(&whole[..len]).is_err(), "{:02X?}", &whole[..len]);
            }
        }
        assert_eq!(RequestPdu::parse(&[]), Err(PduError::Empty));
        assert_eq!(RequestPdu::parse(&[0x56, 0, 0, 0]), Err(PduError::Function { got: 0x56 }));
        let error = RequestPdu::parse(&[0x5F, 1, 10, 3, 1, 2]).unwrap_err();
        assert_eq!(error.to_string(), "Write: the length octet says 3, 2 octets follow");
        assert!(RequestPdu::Write { slot: 0, index: 0, data: &[0; 241] }.encode(&mut [0; 300]).is_none());
    }

    proptest! {
        #[test]
        fn whatever_is_parsed_is_written_back_the_same(octets in proptest::collection::vec(any::<u8>(), 0..250),
            number in prop_oneof![Just(0x5E), Just(0x5F), Just(0x51), Just(0x5C), Just(0x57), Just(0xDE), any::<u8>()],
            agree in any::<bool>()) {
            let mut octets = octets;
            let data_len = octets.len().saturating_sub(4);
            if let [function, _, _, len, ..] = &mut octets[..] {
                *function = number;
                if let (true, Ok(data_len @ ..=240)) = (agree, u8::try_from(data_len)) {
                    *len = data_len;
                }
            }
            if let Ok(pdu) = RequestPdu::parse(&octets) {
                let mut buf = [0; 255];
                if let Some(again) = pdu.encode(&mut buf) {
                    prop_assert_eq!(RequestPdu::parse(again), Ok(pdu));
                }
            }
            if let Ok(pdu) = ResponsePdu::parse(&octets) {
                let mut buf = [0; 255];
                if let Some(again) = pdu.encode(&mut buf) {
                    prop_assert_eq!(ResponsePdu::parse(again), Ok(pdu));
                }
            }
        }
    }
}
