//! Listening before taking part: does somebody else have this address?
//!
//! Two stations at one address answer at the same time and destroy each other's replies, which looks like a bad cable.
//! So a station that joins a line first listens. The address is **live** if a telegram comes from it, if a master
//! there takes part in the token ring, or if a request to it is answered with SC, which names no address. It is
//! **free** once a master has asked it twice in vain, or once [`LISTEN_TIME`] is over without a sign.

use core::fmt;
use core::time::Duration;

use crate::profibus::fdl::{Address, Function, Telegram};
use crate::time::Instant;

/// How long a station listens at most before it takes part: a master has gone once around 125 slaves with the longest
/// telegrams at 500 kbit/s by then (1.4 s), and around thirty drives at 9600 bit/s.
pub const LISTEN_TIME: Duration = Duration::from_secs(2);

/// So many requests in vain show that nobody is there: one may be damaged.
const REQUESTS_IN_VAIN: u8 = 2;

/// How it is known that somebody else has an address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Evidence {
    /// A request from it: a master.
    Asks,
    /// It sent or was sent a token: a master.
    InTokenRing,
    /// It answered a request.
    Answers,
}

impl fmt::Display for Evidence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Asks => "a master that sends requests",
            Self::InTokenRing => "a master in the token ring",
            Self::Answers => "which answers",
        })
    }
}

/// What a telegram says about the address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    Undecided,
    Free,
    Live(Evidence),
}

/// A station that listens.
#[derive(Clone, Copy, Debug)]
pub(super) struct Joining {
    since: Instant,
    /// The last telegram asked our address.
    asked: bool,
    in_vain: u8,
}

impl Joining {
    pub(super) const fn from(now: Instant) -> Self {
        Self { since: now, asked: false, in_vain: 0 }
    }

    pub(super) const fn ends(&self) -> Instant {
        self.since.saturating_add(LISTEN_TIME)
    }

    pub(super) fn hear(&mut self, address: Address, telegram: &Telegram<'_>) -> Verdict {
        let asked = core::mem::take(&mut self.asked);
        let asks = match telegram {
            Telegram::ShortAcknowledge if asked => return Verdict::Live(Evidence::Answers),
            Telegram::ShortAcknowledge => return Verdict::Undecided,
            Telegram::Token { da, sa } if *da == address || *sa == address => {
                return Verdict::Live(Evidence::InTokenRing);
            }
            Telegram::Token { .. } => false,
            Telegram::Data(data) => match data.fc.function() {
                Function::Response(..) if data.sa == address => return Verdict::Live(Evidence::Answers),
                Function::Response(..) | Function::Reserved => return Verdict::Undecided,
                Function::Request(..) if data.sa == address => return Verdict::Live(Evidence::Asks),
                Function::Request(service, _) => data.da == address && service.wants_reply(),
            },
        };
        // A master speaks again: the request before had no answer.
        self.in_vain += u8::from(asked);
        self.asked = asks;
        if self.in_vain >= REQUESTS_IN_VAIN { Verdict::Free } else { Verdict::Undecided }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profibus::fdl::telegram::{Decoded, decode};

    /// What station 5 concludes from telegrams.
    fn verdict(telegrams: &[&[u8]]) -> Verdict {
        let mut joining = Joining::from(Instant::ZERO);
        let mut last = Verdict::Undecided;
        for octets in telegrams {
            assert_eq!(last, Verdict::Undecided);
            let Decoded::Telegram { telegram, .. } = decode(octets) else { panic!("{octets:02X?}") };
            last = joining.hear(Address::from_octet(5), &telegram);
        }
        last
    }

    const ASKS_5: &[u8] = &[0x10, 5, 2, 0x49, 0x50, 0x16];
    const ASKS_6: &[u8] = &[0x10, 6, 2, 0x49, 0x51, 0x16];
    const ANSWER_OF_5: &[u8] = &[0x10, 2, 5, 0, 7, 0x16];
    const ANSWER_OF_6: &[u8] = &[0x10, 2, 6, 0, 8, 0x16];
    const SC: &[u8] = &[0xE5];

    #[test]
    fn an_answer_from_the_address_shows_that_it_is_live() {
        assert_eq!(verdict(&[ANSWER_OF_5]), Verdict::Live(Evidence::Answers));
        assert_eq!(verdict(&[ASKS_5, SC]), Verdict::Live(Evidence::Answers));
        assert_eq!(verdict(&[ASKS_5, ASKS_5, ANSWER_OF_5]), Verdict::Live(Evidence::Answers));
    }

    #[test]
    fn the_traffic_of_others_shows_nothing() {
        assert_eq!(verdict(&[ASKS_6, ANSWER_OF_6, ASKS_6, SC, SC, &[0xDC, 1, 2]]), Verdict::Undecided);
    }

    #[test]
    fn a_master_at_the_address_is_live_too() {
        assert_eq!(verdict(&[&[0x10, 9, 5, 0x49, 0x57, 0x16]]), Verdict::Live(Evidence::Asks));
        assert_eq!(verdict(&[&[0xDC, 5, 2]]), Verdict::Live(Evidence::InTokenRing));
        assert_eq!(verdict(&[&[0xDC, 2, 5]]), Verdict::Live(Evidence::InTokenRing));
    }

    #[test]
    fn an_address_asked_twice_in_vain_is_free() {
        assert_eq!(verdict(&[ASKS_5, ASKS_6, ANSWER_OF_6, ASKS_5]), Verdict::Undecided);
        assert_eq!(verdict(&[ASKS_5, ASKS_6, ANSWER_OF_6, ASKS_5, &[0xDC, 2, 3]]), Verdict::Free);
        assert_eq!(verdict(&[ASKS_5, ASKS_5, ASKS_5]), Verdict::Free);
    }
}
