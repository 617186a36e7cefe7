//! Requests and responses of parameters by record 47, at the master's end.

use core::fmt;

use heapless::Vec;
use thiserror::Error;

use crate::profibus::dpv1::MAX_DATA;
use crate::profibus::dpv1::base_mode::{
    Format, HEAD_LEN, Head, MAX_PARAMETERS, ParameterAddress, ParameterError, Service, Values,
};

/// A request: what to write to record 47.
///
/// ```
/// use profidrive::client::ParameterRequest;
/// use profidrive::profibus::dpv1::base_mode::{Attribute, ParameterAddress};
///
/// let identification = ParameterAddress { attribute: Attribute::Value, elements: 6, pnu: 964, subindex: 0 };
/// let request = ParameterRequest::read(1, 0, &[identification]).expect("one of up to 39");
/// assert_eq!(request.octets(), [1, 1, 0, 1, 0x10, 6, 3, 0xC4, 0, 0]);
/// let mut values = request.results(&[1, 1, 0, 1, 6, 6, 0, 42, 0, 1, 0, 100, 7, 0xEA, 11, 22, 0, 1])?;
/// assert_eq!(values.next().map(|value| value.map(|value| value.octets[1])), Some(Ok(42)));
/// # Ok::<(), profidrive::client::NoResponse>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ParameterRequest {
    head: Head,
    octets: Vec<u8, { MAX_DATA as usize }>,
}

/// Why a parameter was not read or changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub struct ParameterRefused {
    /// The error.
    pub error: ParameterError,
    /// What it is about: mostly a sub-index; 0 if nothing is said.
    pub info: u16,
}

impl fmt::Display for ParameterRefused {
    /// `no such sub-index (error 03, sub-index 9): ...`
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { error, info } = *self;
        write!(f, "{} (error {:02X}", error.words(), error.0)?;
        if error.names_subindex() {
            write!(f, ", sub-index {info}")?;
        } else if info != 0 {
            write!(f, ", {info:04X}")?;
        }
        f.write_str(")")
    }
}

/// Why octets are no response to a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum NoResponse {
    /// Fewer than four octets.
    #[error("the response has {got} octets, expected 4 or more")]
    Short {
        /// Octets.
        got: usize,
    },
    /// It is a response to another request.
    #[error("the response is one to another request: {got:02X?}, expected {expected:02X?}")]
    Other {
        /// Reference, service, axis, number of parameters.
        got: [u8; HEAD_LEN],
        /// The same as asked.
        expected: [u8; HEAD_LEN],
    },
    /// The values are cut off, or of an unknown format.
    #[error("the values of parameter {place} of the response cannot be read")]
    Values {
        /// Which, from 1.
        place: usize,
    },
}

impl ParameterRequest {
    /// Reads values, descriptions or texts; `None` if there are no addresses or too many.
    pub fn read(reference: u8, axis: u8, addresses: &[ParameterAddress]) -> Option<Self> {
        Self::new(Service::Read, (reference, axis), addresses.iter().map(|address| (address, None)))
    }

    /// Changes values; `None` if there are none, or too many for one request, or a value does not fit its format.
    pub fn change(reference: u8, axis: u8, changes: &[(ParameterAddress, Values<'_>)]) -> Option<Self> {
        let changes = changes.iter().map(|(address, values)| (address, Some(values)));
        Self::new(Service::Change, (reference, axis), changes)
    }

    fn new<'a>(
        service: Service,
        (reference, axis): (u8, u8),
        parts: impl Iterator<Item = (&'a ParameterAddress, Option<&'a Values<'a>>)> + Clone,
    ) -> Option<Self> {
        let count =
            u8::try_from(parts.clone().count()).ok().filter(|count| (1..=MAX_PARAMETERS).contains(count))?;
        let head = Head { reference, service, failed: false, axis, parameters: count };
        let mut octets = Vec::from_slice(&head.octets()).ok()?;
        for (address, _) in parts.clone() {
            octets.extend_from_slice(&address.octets()).ok()?;
        }
        for values in parts.filter_map(|(_, values)| values) {
            let mut buf = [0; MAX_DATA as usize];
            octets.extend_from_slice(values.encode(&mut buf)?).ok()?;
        }
        Some(Self { head, octets })
    }

    /// What to write to record 47.
    pub fn octets(&self) -> &[u8] {
        &self.octets
    }

    /// What a response says of each parameter, in the order in which they were asked. Of a change that went well the values are
    /// of [`Format::ZERO`].
    ///
    /// # Errors
    /// [`NoResponse`]
    pub fn results<'a>(
        &self,
        response: &'a [u8],
    ) -> Result<impl Iterator<Item = Result<Values<'a>, ParameterRefused>> + use<'a>, NoResponse> {
        let short = NoResponse::Short { got: response.len() };
        let (head, mut rest) = Head::of_response(response).ok_or(short)?;
        let expected = self.head;
        if (Head { failed: false, ..head }) != expected {
            return Err(NoResponse::Other { got: head.octets(), expected: expected.octets() });
        }
        const DONE: Values<'static> = Values { format: Format::ZERO, count: 0, octets: &[] };
        let all_done = head.service == Service::Change && !head.failed;
        let mut found: Vec<_, { MAX_PARAMETERS as usize }> = Vec::new();
        for place in 1..=usize::from(expected.parameters) {
            let values = if all_done {
                DONE
            } else {
                let (values, behind) = Values::split(rest).ok_or(NoResponse::Values { place })?;
                rest = behind;
                values
            };
            let result = match values.error() {
                Some((error, info)) => Err(ParameterRefused { error, info }),
                None => Ok(values),
            };
            found.push(result).map_err(|_| NoResponse::Values { place })?;
        }
        Ok(found.into_iter())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::profibus::dpv1::base_mode::Attribute;

    fn value(pnu: u16, subindex: u16) -> ParameterAddress {
        ParameterAddress { attribute: Attribute::Value, elements: 0, pnu, subindex }
    }

    #[test]
    fn requests_and_responses_are_those_of_the_reference() {
        let word = |octets| Values { format: Format::WORD, count: 1, octets };
        let change = ParameterRequest::change(3, 0, &[(value(965, 0), word(&[0, 1]))]).unwrap();
        assert_eq!(change.octets(), [3, 2, 0, 1, 0x10, 0, 3, 0xC5, 0, 0, 0x42, 1, 0, 1]);
        let mut refused = change.results(&[3, 0x82, 0, 1, 0x44, 2, 0, 1, 0, 0]).unwrap();
        let error = refused.next().unwrap().unwrap_err();
        assert_eq!(std::format!("{error}"), "not changeable (error 01, sub-index 0)");
        assert_eq!(change.results(&[3, 2, 0, 1]).unwrap().filter(Result::is_ok).count(), 1);
        let mixed = ParameterRequest::read(4, 0, &[value(922, 0), value(1, 0)]).unwrap();
        let mut results = mixed.results(&[4, 0x81, 0, 2, 0x42, 1, 0, 1, 0x44, 1, 0, 0]).unwrap();
        assert_eq!(results.next(), Some(Ok(word(&[0, 1]))));
        assert_eq!(results.next(), Some(Err(ParameterRefused { error: ParameterError(0), info: 0 })));
        assert_eq!(results.next(), None);
    }

    #[test]
    fn what_is_no_response_to_this_request_is_refused() {
        let request = ParameterRequest::read(4, 0, &[value(922, 0)]).unwrap();
        let words = |octets: &[u8]| match request.results(octets) {
            Ok(_) => panic!("{octets:02X?}"),
            Err(error) => std::format!("{error}"),
        };
        assert_eq!(words(&[4, 1]), "the response has 2 octets, expected 4 or more");
        assert_eq!(
            words(&[5, 1, 0, 1, 0x42, 1, 0, 1]),
            "the response is one to another request: [05, 01, 00, 01], expected [04, 01, 00, 01]"
        );
        assert_eq!(
            words(&[4, 1, 0, 1, 0x42, 2, 0, 1]),
            "the values of parameter 1 of the response cannot be read"
        );
        assert!(ParameterRequest::read(1, 0, &[]).is_none());
        assert!(ParameterRequest::read(1, 0, &[value(1, 0); 40]).is_none());
        assert!(ParameterRequest::read(1, 0, &[value(1, 0); 39]).is_some());
    }

    proptest! {
        #[test]
        fn whatever_a_slave_answers_is_taken_or_refused(octets in proptest::collection::vec(any::<u8>(), 0..245), count in 1..39_usize) {
            let addresses = [value(1, 0); 39];
            let request = ParameterRequest::read(1, 0, &addresses[..count]).unwrap();
            let mut octets = octets;
            for (place, octet) in octets.iter_mut().zip(&request.octets()[..4]) {
                *place = *octet;
            }
            if let Ok(results) = request.results(&octets) {
                prop_assert_eq!(results.count(), count);
            }
        }
    }
}
