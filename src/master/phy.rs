//! profirust's physical layer on a link of ours.

use std::io;

use profirust::Baudrate;
use profirust::phy::ProfibusPhy;
use profirust::time::{Duration, Instant};

use crate::devices::ag03::profibus::MAX_TELEGRAM_LEN;
use crate::host::{Link, Received};
use crate::time::{BITS_PER_OCTET, BaudRate};

/// Octets kept for profirust at most. It takes whole telegrams and throws noise away, so this is plenty; octets
/// beyond it stay in the link until there is room.
const RECEIVE_LEN: usize = 4 * MAX_TELEGRAM_LEN;

/// SC, a telegram of one octet.
const SHORT_ACKNOWLEDGE: u8 = 0xE5;
/// SD4, which begins a token telegram.
const TOKEN: u8 = 0xDC;

/// Any [`Link`] as profirust's [`ProfibusPhy`].
///
/// Nothing here blocks. A telegram goes to the link at once and counts as being transmitted for as long as its
/// octets last on a line at the rate given. Received octets are kept until profirust drops them or sends again: as
/// in its own layers, what it has not understood by then is an answer to nothing.
///
/// A short acknowledge that no request of this master asks for is dropped: profirust 0.6.0 panics at one that comes
/// after it has passed the token on.
///
/// profirust's interface knows no errors: the first failure of the link is kept for [`LinkPhy::take_error`], and
/// from then on the line is silent.
#[derive(Debug)]
pub struct LinkPhy<L> {
    link: L,
    baudrate: Baudrate,
    /// When the last telegram has left.
    transmitting_until: Option<Instant>,
    received: Vec<u8>,
    /// The telegram sent last was no token, so that a short acknowledge may be its answer.
    awaits_answer: bool,
    error: Option<io::Error>,
    failed: bool,
}

impl<L: Link> LinkPhy<L> {
    /// profirust's view of `link`, which runs at `baud`.
    pub fn new(link: L, baud: BaudRate) -> Self {
        Self {
            link,
            baudrate: baudrate(baud),
            transmitting_until: None,
            received: Vec::with_capacity(RECEIVE_LEN),
            awaits_answer: false,
            error: None,
            failed: false,
        }
    }

    /// Why the link failed, once.
    pub fn take_error(&mut self) -> Option<io::Error> {
        self.error.take()
    }

    /// Whether the link has failed. It stays so.
    pub(crate) const fn is_lost(&self) -> bool {
        self.failed
    }

    /// The link, for what profirust does not do: sleeping in [`Link::wait`].
    pub fn link_mut(&mut self) -> &mut L {
        &mut self.link
    }

    fn fail(&mut self, error: io::Error) {
        self.failed = true;
        self.error.get_or_insert(error);
    }

    /// Short acknowledges at the front that answer nothing.
    fn stray_acknowledges(&self) -> usize {
        if self.awaits_answer {
            return 0;
        }
        self.received.iter().take_while(|octet| **octet == SHORT_ACKNOWLEDGE).count()
    }

    /// Takes over what has arrived.
    fn collect(&mut self) {
        let mut octets = [0; MAX_TELEGRAM_LEN];
        while !self.failed && self.received.len() + octets.len() <= RECEIVE_LEN {
            match self.link.receive(&mut octets) {
                Ok(Received::Octets(count)) => self.received.extend(octets.iter().take(count)),
                // No telegram is in them.
                Ok(Received::BrokenOff(_)) => {}
                // The other end was replaced: what it began to say is never finished.
                Ok(Received::Reset) => self.received.clear(),
                // A master decides the rate.
                Ok(Received::Rate(_)) => {}
                Ok(Received::Nothing) => return,
                Err(error) => self.fail(error),
            }
        }
    }
}

impl<L: Link> ProfibusPhy for LinkPhy<L> {
    fn poll_transmission(&mut self, now: Instant) -> bool {
        self.transmitting_until.is_some_and(|end| now < end)
    }

    fn transmit_data<F, R>(&mut self, now: Instant, f: F) -> R
    where
        F: FnOnce(&mut [u8]) -> (usize, R),
    {
        let mut buf = [0; MAX_TELEGRAM_LEN];
        let (len, result) = f(&mut buf);
        if let Some(telegram) = buf.get(..len).filter(|telegram| !telegram.is_empty()) {
            self.received.clear();
            self.awaits_answer = telegram.first() != Some(&TOKEN);
            self.transmitting_until = Some(now + transmission_time(self.baudrate, telegram.len()));
            if !self.failed
                && let Err(error) = self.link.send(telegram)
            {
                self.fail(error);
            }
        }
        result
    }

    fn receive_data<F, R>(&mut self, _now: Instant, f: F) -> R
    where
        F: FnOnce(&[u8]) -> (usize, R),
    {
        self.collect();
        self.received.drain(..self.stray_acknowledges());
        let (dropped, result) = f(&self.received);
        self.received.drain(..dropped.min(self.received.len()));
        result
    }
}

fn transmission_time(baudrate: Baudrate, octets: usize) -> Duration {
    // At most 255 octets.
    let bits = u32::try_from(octets).unwrap_or(u32::MAX).saturating_mul(BITS_PER_OCTET);
    baudrate.bits_to_time(bits)
}

/// The rate in profirust's words.
pub const fn baudrate(baud: BaudRate) -> Baudrate {
    match baud {
        BaudRate::K9_6 => Baudrate::B9600,
        BaudRate::K19_2 => Baudrate::B19200,
        BaudRate::K31_25 => Baudrate::B31250,
        BaudRate::K45_45 => Baudrate::B45450,
        BaudRate::K93_75 => Baudrate::B93750,
        BaudRate::K187_5 => Baudrate::B187500,
        BaudRate::K500 => Baudrate::B500000,
        BaudRate::K1500 => Baudrate::B1500000,
        BaudRate::K3000 => Baudrate::B3000000,
        BaudRate::K6000 => Baudrate::B6000000,
        BaudRate::K12000 => Baudrate::B12000000,
    }
}

/// A time of our clock in profirust's words: whole microseconds, rounded down.
pub fn instant(at: crate::time::Instant) -> Instant {
    let micros = at.as_nanos() / 1_000;
    Instant::from_micros(i64::try_from(micros).unwrap_or(i64::MAX))
}

#[cfg(test)]
mod tests {
    use core::time::Duration as StdDuration;

    use super::*;
    use crate::host::Stop;
    use crate::host::link::memory::{End, Wire};

    const FDL_STATUS: [u8; 6] = [0x10, 0x05, 0x02, 0x49, 0x50, 0x16];

    fn micros(micros: i64) -> Instant {
        Instant::from_micros(micros)
    }

    fn line() -> (LinkPhy<End>, End) {
        let wire = Wire::new();
        (LinkPhy::new(wire.end(), BaudRate::K500), wire.end())
    }

    #[test]
    fn a_telegram_is_sent_at_once_and_lasts_eleven_bits_per_octet() {
        let (mut phy, mut slave) = line();
        let result = phy.transmit_data(micros(1_000), |buf| {
            buf[..6].copy_from_slice(&FDL_STATUS);
            (6, "sent")
        });
        assert_eq!(result, "sent");
        let mut heard = [0; 16];
        assert_eq!(slave.receive(&mut heard).unwrap(), Received::Octets(6));
        assert_eq!(heard[..6], FDL_STATUS);
        // 66 bits at 500 kbit/s.
        assert!(phy.poll_transmission(micros(1_131)));
        assert!(!phy.poll_transmission(micros(1_132)));
    }

    #[test]
    fn a_closure_that_writes_nothing_sends_nothing() {
        let (mut phy, mut slave) = line();
        phy.transmit_data(micros(5), |_| (0, ()));
        assert!(!phy.poll_transmission(micros(5)));
        assert_eq!(slave.receive(&mut [0; 4]).unwrap(), Received::Nothing);
    }

    #[test]
    fn octets_wait_until_they_are_dropped() {
        let (mut phy, mut slave) = line();
        assert_eq!(phy.poll_pending_received_bytes(micros(0)), 0);
        slave.send(&[1, 2]).unwrap();
        assert_eq!(phy.poll_pending_received_bytes(micros(0)), 2);
        slave.send(&[3]).unwrap();
        assert_eq!(phy.poll_pending_received_bytes(micros(0)), 3);
        let heard = phy.receive_data(micros(0), |octets| (2, octets.to_vec()));
        assert_eq!(heard, [1, 2, 3]);
        phy.receive_data(micros(0), |octets| {
            assert_eq!(octets, [3]);
            (1, ())
        });
        assert_eq!(phy.poll_pending_received_bytes(micros(0)), 0);
    }

    #[test]
    fn half_a_reply_does_not_corrupt_the_one_to_the_next_request() {
        let (mut phy, mut slave) = line();
        slave.send(&[0x68, 0x05]).unwrap();
        assert_eq!(phy.poll_pending_received_bytes(micros(0)), 2);
        phy.transmit_data(micros(0), |_| (3, ()));
        slave.send(&[0xE5]).unwrap();
        assert_eq!(phy.receive_data(micros(0), |octets| (0, octets.to_vec())), [0xE5]);
    }

    #[test]
    fn a_short_acknowledge_is_an_answer_to_a_request_and_to_nothing_else() {
        let (mut phy, mut slave) = line();
        slave.send(&[0xE5, 0xE5, 0x10]).unwrap();
        assert_eq!(phy.receive_data(micros(0), |octets| (0, octets.to_vec())), [0x10]);
        for (sent, heard) in [([0x10, 5, 2], &[0xE5, 0xE5][..]), ([0xDC, 5, 2], &[])] {
            phy.transmit_data(micros(0), |buf| {
                buf[..3].copy_from_slice(&sent);
                (3, ())
            });
            slave.send(&[0xE5, 0xE5]).unwrap();
            assert_eq!(phy.receive_data(micros(0), |octets| (0, octets.to_vec())), heard);
        }
    }

    #[test]
    fn a_flood_is_kept_in_bounds() {
        let (mut phy, mut slave) = line();
        slave.send(&[0x55; 2 * RECEIVE_LEN]).unwrap();
        let pending = phy.poll_pending_received_bytes(micros(0));
        assert!((RECEIVE_LEN - MAX_TELEGRAM_LEN..=RECEIVE_LEN).contains(&pending), "{pending}");
        let mut total = 0;
        while phy.poll_pending_received_bytes(micros(0)) > 0 {
            total += phy.receive_data(micros(0), |octets| (octets.len(), octets.len()));
        }
        assert_eq!(total, 2 * RECEIVE_LEN);
    }

    /// A link on which these things happen, one per call.
    struct Scripted(Vec<io::Result<(Received, u8)>>);

    impl Link for Scripted {
        fn receive(&mut self, buf: &mut [u8]) -> io::Result<Received> {
            if self.0.is_empty() {
                return Ok(Received::Nothing);
            }
            let (received, octet) = self.0.remove(0)?;
            buf[0] = octet;
            Ok(received)
        }

        fn send(&mut self, _: &[u8]) -> io::Result<()> {
            Err(io::ErrorKind::BrokenPipe.into())
        }

        fn wait(&mut self, _: Option<StdDuration>, _: &Stop) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn what_came_before_a_reset_is_forgotten() {
        let script = vec![
            Ok((Received::Octets(1), 7)),
            Ok((Received::Reset, 0)),
            Ok((Received::Rate(BaudRate::K500), 0)),
            Ok((Received::Octets(1), 8)),
        ];
        let mut phy = LinkPhy::new(Scripted(script), BaudRate::K500);
        assert_eq!(phy.receive_data(micros(0), |octets| (0, octets.to_vec())), [8]);
    }

    #[test]
    fn a_dead_link_is_silent_and_says_why_once() {
        let script = vec![Err(io::ErrorKind::NotConnected.into()), Ok((Received::Octets(1), 7))];
        let mut phy = LinkPhy::new(Scripted(script), BaudRate::K500);
        assert_eq!(phy.poll_pending_received_bytes(micros(0)), 0);
        assert_eq!(phy.poll_pending_received_bytes(micros(0)), 0);
        phy.transmit_data(micros(0), |_| (3, ()));
        assert_eq!(phy.take_error().map(|error| error.kind()), Some(io::ErrorKind::NotConnected));
        assert!(phy.take_error().is_none());
        assert!(phy.is_lost());

        let mut phy = LinkPhy::new(Scripted(Vec::new()), BaudRate::K500);
        phy.transmit_data(micros(0), |_| (3, ()));
        assert_eq!(phy.take_error().map(|error| error.kind()), Some(io::ErrorKind::BrokenPipe));
    }

    #[test]
    fn rates_and_times_keep_their_values() {
        for baud in BaudRate::ALL {
            assert_eq!(baudrate(baud).to_rate(), u64::from(baud.bits_per_second()));
        }
        assert_eq!(instant(crate::time::Instant::from_nanos(1_999)), micros(1));
        assert_eq!(
            instant(crate::time::Instant::from_nanos(u64::MAX)).total_micros(),
            18_446_744_073_709_551
        );
    }
}
