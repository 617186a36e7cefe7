//! A station behind a UART: octets in, octets out.
//!
//! A [`Station`] takes whole telegrams, for hosts that frame the octets of many stations once. A firmware has one station
//! and one UART:
//!
//! ```
//! use profidrive::profibus::dp::{Description, Fixed, Framed, Station};
//! use profidrive::profibus::fdl::{Address, MAX_TELEGRAM_LEN, Resync};
//! use profidrive::time::{BaudRate, Instant};
//!
//! let description = Description { ident: 0x1234, ..Description::PLAIN };
//! let application = Fixed { configurations: &[&[0x20, 0x10]], ..Fixed::PLAIN };
//! let baud = BaudRate::K500;
//! let station = Station::new(Address::station(5)?, baud, None, description, application);
//! let mut slave = Framed::new(Resync::Idle(baud), station);
//!
//! // One octet after the other, as the interrupt of a UART has them: only the last one brings news.
//! let at = |micros| Instant::from_micros(micros);
//! for (number, octet) in (1..).zip([0x10, 0x05, 0x02, 0x49, 0x50]) {
//!     assert!(!slave.handle_bytes(at(22 * number), &[octet]));
//! }
//! assert!(slave.handle_bytes(at(132), &[0x16]));
//!
//! let mut buf = [0; MAX_TELEGRAM_LEN];
//! let due = slave.poll_timeout().expect("a reply waits for min T_SDR");
//! assert_eq!(slave.poll_transmit(due, &mut buf), Some(&[0x10, 0x02, 0x05, 0x00, 0x07, 0x16][..]));
//! # Ok::<(), profidrive::profibus::fdl::AddressError>(())
//! ```

use heapless::Deque;
use thiserror::Error;

use super::{Application, Event, Fixed, Station};
use crate::profibus::fdl::station::TooLate;
use crate::profibus::fdl::{FrameError, Framer, MAX_TELEGRAM_LEN, Resync, Telegram};
use crate::time::Instant;

/// How many news wait to be taken. What comes beyond them is counted.
const MAX_NEWS: usize = 4;

/// A [`Station`] that takes and gives octets.
///
/// After a call that says that something has come of it, set the inputs anew, take [`Framed::poll_transmit`] and
/// [`Framed::poll_news`], and ask [`Framed::poll_timeout`] when to call [`Framed::handle_timeout`].
#[derive(Clone, Debug)]
pub struct Framed<A = Fixed<'static>> {
    framer: Framer,
    part: Part<A>,
}

/// Everything behind the framer.
#[derive(Clone, Debug)]
struct Part<A> {
    station: Station<A>,
    news: Deque<News, MAX_NEWS>,
    lost: u32,
}

/// News of a station behind a UART.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum News {
    /// The slave says something; [`Station::explain`] adds the words of its application.
    #[error("{0}")]
    Dp(Event),
    /// Octets that are no telegram.
    #[error("octets refused: {0}")]
    Refused(FrameError),
    /// A reply was dropped because its time was over.
    #[error("a reply was not sent: ready {} us after the request, allowed are {} us", .0.after.as_micros(), .0.limit.as_micros())]
    TooLate(TooLate),
    /// So many news came when there was no room for them.
    #[error("{0} more events are lost: read them more often")]
    Lost(u32),
}

impl<A: Application> Framed<A> {
    /// This station, on a line that nothing was heard on yet. A UART sees the time of its octets: [`Resync::Idle`].
    pub const fn new(resync: Resync, station: Station<A>) -> Self {
        Self { framer: Framer::new(resync), part: Part { station, news: Deque::new(), lost: 0 } }
    }

    /// The station.
    pub const fn station(&self) -> &Station<A> {
        &self.part.station
    }

    /// The station, to set inputs and file a diagnosis.
    pub const fn station_mut(&mut self) -> &mut Station<A> {
        &mut self.part.station
    }

    /// Takes octets, the last of which ended at `now`. They may be cut anywhere. Never panics, never blocks.
    ///
    /// Returns whether something has come of it: `false` as long as a telegram is unfinished. Then there is nothing to
    /// take, and no deadline is earlier than before.
    pub fn handle_bytes(&mut self, now: Instant, octets: &[u8]) -> bool {
        let Self { framer, part } = self;
        let mut heard = false;
        framer.handle_bytes(now, octets, |at, result| {
            heard = true;
            part.hear(at, result);
        });
        heard
    }

    /// An octet that ended at `now` came damaged: wrong parity, no stop bit, or lost because nobody took it in time.
    /// The telegram around it is refused once. Returns as [`Framed::handle_bytes`].
    pub(crate) fn handle_damaged(&mut self, now: Instant) -> bool {
        let Self { framer, part } = self;
        let mut heard = false;
        framer.handle_damaged(now, |at, result| {
            heard = true;
            part.hear(at, result);
        });
        heard
    }

    /// Time has passed. Spurious calls are harmless.
    pub fn handle_timeout(&mut self, now: Instant) {
        let Self { framer, part } = self;
        if let Some(event) = part.station.handle_timeout(now) {
            part.push(News::Dp(event));
        }
        framer.handle_timeout(now, |at, result| part.hear(at, result));
    }

    /// The telegram to send at `now`, written to `buf`, if its time has come.
    #[must_use = "the octets are not offered again"]
    pub fn poll_transmit<'b>(
        &mut self,
        now: Instant,
        buf: &'b mut [u8; MAX_TELEGRAM_LEN],
    ) -> Option<&'b [u8]> {
        match self.part.station.poll_transmit(now) {
            Ok(octets) => {
                let octets = octets?;
                let out = buf.get_mut(..octets.len())?;
                out.copy_from_slice(octets);
                Some(out)
            }
            Err(too_late) => {
                self.part.push(News::TooLate(too_late));
                None
            }
        }
    }

    /// When to call [`Framed::handle_timeout`] and [`Framed::poll_transmit`] again; `None` = octets come first.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Instant> {
        Instant::first_of(self.part.station.poll_timeout(), self.framer.poll_timeout())
    }

    /// The oldest news not taken yet; behind the last one how many were lost, if any were.
    #[must_use]
    pub fn poll_news(&mut self) -> Option<News> {
        let Part { news, lost, .. } = &mut self.part;
        news.pop_front().or_else(|| (*lost > 0).then(|| News::Lost(core::mem::take(lost))))
    }
}

impl<A: Application> Part<A> {
    fn hear(&mut self, at: Instant, result: Result<Telegram<'_>, FrameError>) {
        match result {
            Ok(telegram) => {
                if let Some(event) = self.station.handle_telegram(at, &telegram).event {
                    self.push(News::Dp(event));
                }
            }
            Err(error) => self.push(News::Refused(error)),
        }
    }

    fn push(&mut self, news: News) {
        if self.news.push_back(news).is_err() {
            self.lost = self.lost.saturating_add(1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profibus::dp::{Description, State};
    use crate::profibus::fdl::Address;
    use crate::time::BaudRate;

    const BAUD: BaudRate = BaudRate::K500;
    /// Slave_Diag of master 2, as it is on the line.
    const SLAVE_DIAG: [u8; 11] = [0x68, 5, 5, 0x68, 0x85, 0x82, 0x6D, 0x3C, 0x3E, 0xEE, 0x16];
    const STATUS: [u8; 6] = [0x10, 5, 2, 0x49, 0x50, 0x16];
    const OCTET: u64 = 22_000;

    fn slave() -> Framed {
        let application = Fixed { configurations: &[&[0x20, 0x10]], ..Fixed::PLAIN };
        let description = Description { ident: 0x1234, ..Description::PLAIN };
        let max_tsdr = Some(BAUD.max_tsdr_bits());
        Framed::new(
            Resync::Idle(BAUD),
            Station::new(Address::station(5).unwrap(), BAUD, max_tsdr, description, application),
        )
    }

    /// Hears these octets one by one from `start` on: the time of the last one, and which of them brought news.
    fn hear(slave: &mut Framed, start: u64, octets: &[u8]) -> (Instant, std::vec::Vec<bool>) {
        let mut at = start;
        let heard = octets.iter().map(|octet| {
            at += OCTET;
            slave.handle_bytes(Instant::from_nanos(at), &[*octet])
        });
        let heard = heard.collect();
        (Instant::from_nanos(at), heard)
    }

    #[test]
    fn only_the_octet_that_ends_a_telegram_brings_news_and_the_reply_keeps_min_tsdr() {
        let mut slave = slave();
        let (end, heard) = hear(&mut slave, 1_000_000, &SLAVE_DIAG);
        assert_eq!(heard.iter().position(|news| *news), Some(SLAVE_DIAG.len() - 1));
        let due = slave.poll_timeout().unwrap();
        assert_eq!(due, end.saturating_add(BAUD.bit_times(11)));
        let mut buf = [0; MAX_TELEGRAM_LEN];
        assert_eq!(slave.poll_transmit(end, &mut buf), None);
        let reply = slave.poll_transmit(due, &mut buf).unwrap();
        assert_eq!(reply.get(..4), Some(&[0x68, 11, 11, 0x68][..]));
        assert_eq!(slave.station().slave().state(), State::WaitPrm);
        assert_eq!(slave.poll_news(), None);
    }

    #[test]
    fn a_damaged_octet_invalidates_its_telegram_once_and_no_other() {
        for place in 0..SLAVE_DIAG.len() {
            let mut slave = slave();
            let (end, _) = hear(&mut slave, 1_000_000, SLAVE_DIAG.get(..place).unwrap());
            let at = end.as_nanos() + OCTET;
            assert!(slave.handle_damaged(Instant::from_nanos(at)));
            let (end, heard) = hear(&mut slave, at, SLAVE_DIAG.get(place + 1..).unwrap());
            assert!(!heard.contains(&true), "octet {place}");
            assert_eq!(slave.poll_news(), Some(News::Refused(FrameError::Parity)));
            assert_eq!(slave.poll_news(), None);
            let mut buf = [0; MAX_TELEGRAM_LEN];
            assert_eq!(slave.poll_transmit(Instant::from_nanos(end.as_nanos() + 50_000), &mut buf), None);
            // The line was idle for T_SYN.
            let (end, heard) = hear(&mut slave, end.as_nanos() + 33 * 2000, &STATUS);
            assert_eq!(heard.last(), Some(&true));
            let due = end.saturating_add(BAUD.bit_times(11));
            assert!(slave.poll_transmit(due, &mut buf).is_some(), "octet {place}");
        }
    }

    #[test]
    fn a_reply_that_is_too_late_is_dropped_and_told_and_lost_news_are_counted() {
        let mut slave = slave();
        let mut buf = [0; MAX_TELEGRAM_LEN];
        for round in 1..=6 {
            let (end, _) = hear(&mut slave, round * 10_000_000, &STATUS);
            let late = end.saturating_add(BAUD.bit_times(1000));
            assert_eq!(slave.poll_transmit(late, &mut buf), None);
        }
        for _ in 0..MAX_NEWS {
            let news = slave.poll_news().unwrap();
            assert!(matches!(news, News::TooLate(_)));
            assert!(news.to_string().contains("ready 2000 us after the request"), "{news}");
        }
        assert_eq!(slave.poll_news(), Some(News::Lost(2)));
        assert_eq!(slave.poll_news(), None);
    }
}
