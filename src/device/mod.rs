//! One emulated drive as one object (interface sketch; names fixed by agreement, bodies to come).
use crate::param::{Gear, Model};
use crate::time::{BaudRate, Instant};
use core::time::Duration;

/// Longest telegram on the wire.
pub const MAX_TELEGRAM_LEN: usize = 255;

/// What a device is made of.
#[derive(Clone, Debug)]
pub struct Config {
    /// Station address 0..=126 (will be `fdl::Address`).
    pub address: u8,
    /// Which drive.
    pub model: Model,
    /// Which gear.
    pub gear: Gear,
    /// The rate of the line, for bit times.
    pub baud: BaudRate,
    /// How often the drive part runs.
    pub application_cycle: Duration,
}

/// News for the host. `Display` is one line of plain English for the log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// (to come; non_exhaustive)
    Sketch,
}
impl core::fmt::Display for Event {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("sketch")
    }
}

/// One emulated drive.
pub struct Device {
    config: Config,
}

impl Device {
    /// A drive that has just been powered on at `now`.
    pub fn new(config: Config, _now: Instant) -> Self {
        Self { config }
    }
    /// Its station address.
    pub fn address(&self) -> u8 {
        self.config.address
    }
    /// The line has another rate now.
    pub fn set_baud(&mut self, baud: BaudRate) {
        self.config.baud = baud;
    }
    /// Octets that ended to arrive at `now`, cut anywhere.
    pub fn handle_bytes(&mut self, _now: Instant, _bytes: &[u8]) {}
    /// Time passed without octets. Spurious calls are harmless.
    pub fn handle_timeout(&mut self, _now: Instant) {}
    /// The octets to send now, if any.
    #[must_use]
    pub fn poll_transmit<'b>(
        &mut self,
        _now: Instant,
        _buf: &'b mut [u8; MAX_TELEGRAM_LEN],
    ) -> Option<&'b [u8]> {
        None
    }
    /// When to call `handle_timeout`/`poll_transmit` again; `None` = only after octets arrived.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Instant> {
        None
    }
    /// News.
    #[must_use]
    pub fn poll_event(&mut self) -> Option<Event> {
        None
    }
}
