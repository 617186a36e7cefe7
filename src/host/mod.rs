//! Everything that touches an operating system (interface sketch; names fixed by agreement, bodies to come).
use crate::time::Instant;
use core::time::Duration;
use std::io;

/// A byte transport to one bus: raw telegram octets in and out, no framing.
pub trait Link {
    /// Octets that have arrived, without waiting: how many were written to `buf`, 0 = none now.
    fn receive(&mut self, buf: &mut [u8]) -> io::Result<usize>;
    /// Sends one whole telegram. What nobody listens to is lost, as on a wire.
    fn send(&mut self, telegram: &[u8]) -> io::Result<()>;
    /// Sleeps until octets may have arrived or `timeout` has passed (`None`: only octets end the sleep).
    fn wait(&mut self, timeout: Option<Duration>) -> io::Result<()>;
}

/// Where time comes from.
pub trait Clock {
    /// The time now.
    fn now(&self) -> Instant;
}
