//! A slave in a microcontroller: what a loop between a UART, a timer and a slave needs, and ready loops for UARTs behind the
//! traits of `embedded-io`.
//!
//! | file | holds |
//! | --- | --- |
//! | `mod` | [`Slave`]: octets and time in, octets and a deadline out |
//! | `rs485` | [`Rs485`]: a UART and the direction pin of a transceiver (feature `embedded-io` or `embedded-io-async`) |
//! | `blocking` | one pass of a loop over `embedded_io::{Read, ReadReady, Write}` (feature `embedded-io`) |
//! | `log` | errors and events for `defmt` (feature `defmt`) |
//! | `asynchronous` | a loop over `embedded_io_async::{Read, Write}` (feature `embedded-io-async`) |
//!
//! A loop of your own, fed by the interrupt of a UART, is not longer: `examples/firmware.rs` shows it, and
//! `examples/firmware/` in the repository runs it with interrupts on a simulated Cortex-M4. `docs/firmware.md` says how fast it
//! is and how a transceiver is wired.

#[cfg(feature = "embedded-io-async")]
mod asynchronous;
#[cfg(feature = "embedded-io")]
mod blocking;
#[cfg(all(feature = "defmt", not(windows)))]
mod log;
#[cfg(any(feature = "embedded-io", feature = "embedded-io-async"))]
mod rs485;

use crate::devices::ag03::profibus::Device;
use crate::profibus::dp::{Application, Framed};
use crate::profibus::fdl::MAX_TELEGRAM_LEN;
use crate::time::Instant;

#[cfg(any(feature = "embedded-io", feature = "embedded-io-async"))]
pub use rs485::{NoPin, PortError, Rs485};

/// A slave that takes and gives octets: a drive ([`Device`]) or a station of your own ([`Framed`]).
pub trait Slave {
    /// Takes octets, the last of which ended at `now`. Whether something has come of it; while it is `false` there is
    /// nothing to take, and no deadline is earlier than before.
    fn handle_bytes(&mut self, now: Instant, octets: &[u8]) -> bool;

    /// An octet that ended at `now` came damaged: parity, stop bit, overrun. Returns as [`Slave::handle_bytes`].
    fn handle_damaged(&mut self, now: Instant) -> bool;

    /// Time has passed. Spurious calls are harmless.
    fn handle_timeout(&mut self, now: Instant);

    /// The telegram to send at `now`, written to `buf`, if its time has come.
    #[must_use = "the octets are not offered again"]
    fn poll_transmit<'b>(&mut self, now: Instant, buf: &'b mut [u8; MAX_TELEGRAM_LEN]) -> Option<&'b [u8]>;

    /// When to call [`Slave::handle_timeout`] and [`Slave::poll_transmit`] again; `None` = octets come first.
    #[must_use]
    fn poll_timeout(&self) -> Option<Instant>;
}

macro_rules! slave {
    () => {
        #[inline]
        fn handle_bytes(&mut self, now: Instant, octets: &[u8]) -> bool {
            Self::handle_bytes(self, now, octets)
        }

        #[inline]
        fn handle_damaged(&mut self, now: Instant) -> bool {
            Self::handle_damaged(self, now)
        }

        #[inline]
        fn handle_timeout(&mut self, now: Instant) {
            Self::handle_timeout(self, now);
        }

        #[inline]
        fn poll_transmit<'b>(
            &mut self,
            now: Instant,
            buf: &'b mut [u8; MAX_TELEGRAM_LEN],
        ) -> Option<&'b [u8]> {
            Self::poll_transmit(self, now, buf)
        }

        #[inline]
        fn poll_timeout(&self) -> Option<Instant> {
            Self::poll_timeout(self)
        }
    };
}

impl Slave for Device {
    slave!();
}

impl<A: Application> Slave for Framed<A> {
    slave!();
}
