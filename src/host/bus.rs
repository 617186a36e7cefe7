//! Several drives on one line.

use std::vec::Vec;

use super::{Error, StoredDevice};
use crate::device::{Event, MAX_TELEGRAM_LEN};
use crate::time::{BaudRate, Instant};

/// The drives on one line. Each hears every octet on it: the master's and the other drives', not its own.
///
/// Used like one [`Device`](crate::device::Device), with the same contract: after every `handle_*`, drain [`Bus::poll_transmit`] and
/// [`Bus::poll_event`] to `None`, then wait for octets or [`Bus::poll_timeout`].
#[derive(Default)]
pub struct Bus {
    devices: Vec<StoredDevice>,
    /// The master changed and has not said anything yet: what a drive still sends answers the one before.
    silenced: bool,
}

impl Bus {
    /// A line without drives.
    pub fn new() -> Self {
        Self::default()
    }

    /// Connects a drive.
    ///
    /// # Errors
    /// [`Error::AddressTaken`] if another drive has its address; the line is as before.
    pub fn add(&mut self, device: impl Into<StoredDevice>) -> Result<(), Error> {
        let device = device.into();
        let address = device.device().address();
        if self.devices.iter().any(|other| other.device().address() == address) {
            return Err(Error::AddressTaken { address: address.number() });
        }
        self.devices.push(device);
        Ok(())
    }

    /// The addresses of the drives, in the order in which they were connected.
    pub fn addresses(&self) -> impl Iterator<Item = u8> + '_ {
        self.devices.iter().map(address)
    }

    /// The line has another rate now.
    pub fn set_baud(&mut self, baud: BaudRate) {
        for device in &mut self.devices {
            device.set_baud(baud);
        }
    }

    /// Octets that ended to arrive at `now`, cut anywhere.
    pub fn handle_bytes(&mut self, now: Instant, bytes: &[u8]) {
        self.silenced = false;
        for device in &mut self.devices {
            device.handle_bytes(now, bytes);
        }
    }

    /// The master has gone: half a telegram is forgotten, and until octets arrive again nothing is sent. It would
    /// reach somebody who did not ask.
    pub fn handle_reset(&mut self) {
        self.silenced = true;
        for device in &mut self.devices {
            device.handle_line_reset();
        }
    }

    /// Time passed without octets. Only the drives whose deadline is reached are told.
    pub fn handle_timeout(&mut self, now: Instant) {
        for device in &mut self.devices {
            if device.poll_timeout().is_some_and(|deadline| deadline <= now) {
                device.handle_timeout(now);
            }
        }
    }

    /// The octets to send now, if any. The other drives have heard them when this returns.
    ///
    /// The answer can change after every `handle_*` and after every `Some`.
    #[must_use]
    pub fn poll_transmit<'b>(
        &mut self,
        now: Instant,
        buf: &'b mut [u8; MAX_TELEGRAM_LEN],
    ) -> Option<&'b [u8]> {
        loop {
            let (sender, len) = self
                .devices
                .iter_mut()
                .enumerate()
                .find_map(|(index, device)| Some((index, device.poll_transmit(now, buf)?.len())))?;
            if self.silenced {
                continue;
            }
            let telegram = buf.get(..len)?;
            for (index, device) in self.devices.iter_mut().enumerate() {
                if index != sender {
                    device.handle_bytes(now, telegram);
                }
            }
            return Some(telegram);
        }
    }

    /// When to call `handle_timeout` and `poll_transmit` again; `None`: only after octets arrived.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Instant> {
        self.devices.iter().filter_map(StoredDevice::poll_timeout).min()
    }

    /// News of a drive, and its address.
    #[must_use]
    pub fn poll_event(&mut self) -> Option<(u8, Event)> {
        self.devices.iter_mut().find_map(|device| device.poll_event().map(|event| (address(device), event)))
    }
}

/// The station address as a number.
fn address(device: &StoredDevice) -> u8 {
    device.device().address().number()
}
