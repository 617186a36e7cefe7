//! Several drives on one line.

use std::vec::Vec;

use super::Error;
use crate::device::{Device, Event, MAX_TELEGRAM_LEN};
use crate::time::{BaudRate, Instant};

/// The drives on one line. Each hears every octet on it: the master's and the other drives', not its own.
///
/// Used like one [`Device`], with the same contract: after every `handle_*`, drain [`Bus::poll_transmit`] and
/// [`Bus::poll_event`] to `None`, then wait for octets or [`Bus::poll_timeout`].
#[derive(Default)]
pub struct Bus {
    devices: Vec<Device>,
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
    pub fn add(&mut self, device: Device) -> Result<(), Error> {
        let address = device.address();
        if self.devices.iter().any(|other| other.address() == address) {
            return Err(Error::AddressTaken { address });
        }
        self.devices.push(device);
        Ok(())
    }

    /// The addresses of the drives, in the order in which they were connected.
    pub fn addresses(&self) -> impl Iterator<Item = u8> + '_ {
        self.devices.iter().map(Device::address)
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

    /// The master has gone. Until octets arrive again, nothing is sent: it would reach somebody who did not ask.
    pub fn handle_reset(&mut self) {
        self.silenced = true;
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
        self.devices.iter().filter_map(Device::poll_timeout).min()
    }

    /// News of a drive, and its address.
    #[must_use]
    pub fn poll_event(&mut self) -> Option<(u8, Event)> {
        self.devices.iter_mut().find_map(|device| device.poll_event().map(|event| (device.address(), event)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::Config;
    use crate::param::{Gear, Model};
    use core::time::Duration;
    use std::string::ToString;

    fn drive(address: u8) -> Device {
        let config = Config {
            address,
            model: Model::Ag03_1,
            gear: Gear::Ratio48,
            baud: BaudRate::K500,
            application_cycle: Duration::from_millis(1),
        };
        Device::new(config, Instant::ZERO)
    }

    #[test]
    fn a_second_drive_on_one_address_is_refused_by_name_and_the_first_stays() {
        let mut bus = Bus::new();
        bus.add(drive(5)).unwrap();
        bus.add(drive(6)).unwrap();
        let error = bus.add(drive(5)).unwrap_err();
        assert_eq!(error.to_string(), "two drives have address 5; give each drive its own");
        assert_eq!(bus.addresses().collect::<Vec<_>>(), [5, 6]);
    }
}
