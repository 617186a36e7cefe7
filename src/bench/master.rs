//! [`Master`]: what a master under test must implement to be on the simulated line.

use crate::profibus::fdl::MAX_TELEGRAM_LEN;
use crate::time::Instant;

/// A master without a port: octets and time in, octets and a deadline out.
///
/// After each `handle_*` the line asks [`Master::poll_transmit`] once, and again when what it gave has been sent. Then it
/// waits for octets, for [`Master::poll_timeout`], or for the end of the sending. The master knows neither the line nor
/// the stations, and the line does not know what it is about to do.
pub trait Master {
    /// Whether the line brings it octets at all. Only [`NoMaster`] says no, which spares the line some work.
    const LISTENS: bool = true;

    /// Octets that others sent, the last of which ended at `now`: at first one, then up to eight at once. A telegram may
    /// come in several calls, but octets of two senders never come in one.
    fn handle_bytes(&mut self, now: Instant, octets: &[u8]);

    /// An octet with wrong parity ended at `now`. A port that cannot tell would drop it.
    fn handle_damaged(&mut self, now: Instant) {
        let _ = now;
    }

    /// The last octet of what it sent ended at `now`: its slot time begins.
    fn handle_sent(&mut self, now: Instant);

    /// Time has passed. Spurious calls must be harmless.
    fn handle_timeout(&mut self, now: Instant);

    /// Writes what it sends from `now` on to `buf`, and says how many octets that is. `None`: nothing now.
    fn poll_transmit(&mut self, now: Instant, buf: &mut [u8; MAX_TELEGRAM_LEN]) -> Option<usize>;

    /// When to call [`Master::handle_timeout`]; `None`: octets come first. If the time is past, it is called one T_bit
    /// after the last call.
    fn poll_timeout(&self) -> Option<Instant>;
}

/// No master: only the test sends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NoMaster;

impl Master for NoMaster {
    const LISTENS: bool = false;

    fn handle_bytes(&mut self, _: Instant, _: &[u8]) {}

    fn handle_sent(&mut self, _: Instant) {}

    fn handle_timeout(&mut self, _: Instant) {}

    fn poll_transmit(&mut self, _: Instant, _: &mut [u8; MAX_TELEGRAM_LEN]) -> Option<usize> {
        None
    }

    fn poll_timeout(&self) -> Option<Instant> {
        None
    }
}
