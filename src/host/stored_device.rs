//! A drive and the file its EEPROM is kept in.

use core::time::Duration;

use super::eeprom_file::EepromFile;
use crate::device::{Device, Event, Generation, MAX_TELEGRAM_LEN};
use crate::time::{BaudRate, Instant};

/// How often it is looked whether an image is written, while one is. A write takes longer than that, and the master
/// waits for it.
const LOOK_AGAIN: Duration = Duration::from_millis(1);

/// How long a shaft may run out when the drive is dropped.
const LONGEST_RUN_OUT: Duration = Duration::from_secs(60);

/// A drive on a [`Bus`](super::Bus) whose EEPROM may be kept in a [`StateDir`](super::StateDir).
///
/// Used like a [`Device`], with the same contract; it hands images to the writer and its reports to the drive.
/// Dropped, it is switched off: the shaft runs out at once, and where it stops is stored.
#[derive(Debug)]
pub struct StoredDevice {
    device: Device,
    file: Option<EepromFile>,
    /// The newest image handed over, until its outcome is known.
    in_flight: Option<Generation>,
    /// When to look for the outcome.
    look_again: Option<Instant>,
    now: Instant,
}

impl From<Device> for StoredDevice {
    /// A drive whose EEPROM lives as long as it.
    fn from(device: Device) -> Self {
        Self { device, file: None, in_flight: None, look_again: None, now: Instant::ZERO }
    }
}

impl StoredDevice {
    pub(super) fn new(device: Device, file: EepromFile, now: Instant) -> Self {
        let mut stored = Self { device, file: Some(file), in_flight: None, look_again: None, now };
        stored.hand_over(now);
        stored
    }

    /// The drive itself.
    pub const fn device(&self) -> &Device {
        &self.device
    }

    /// The drive itself, to set its inputs. Counts as a `handle_*` call.
    pub const fn device_mut(&mut self) -> &mut Device {
        &mut self.device
    }

    /// See [`Device::set_baud`].
    pub fn set_baud(&mut self, baud: BaudRate) {
        self.device.set_baud(baud);
    }

    /// See [`Device::handle_bytes`].
    pub fn handle_bytes(&mut self, now: Instant, octets: &[u8]) {
        self.take_outcome(now);
        self.device.handle_bytes(now, octets);
        self.hand_over(now);
    }

    /// See [`Device::handle_timeout`].
    pub fn handle_timeout(&mut self, now: Instant) {
        self.take_outcome(now);
        self.device.handle_timeout(now);
        self.hand_over(now);
    }

    /// See [`Device::handle_line_reset`].
    pub fn handle_line_reset(&mut self) {
        self.device.handle_line_reset();
    }

    /// See [`Device::poll_transmit`].
    #[must_use = "the octets are not offered again"]
    pub fn poll_transmit<'b>(
        &mut self,
        now: Instant,
        buf: &'b mut [u8; MAX_TELEGRAM_LEN],
    ) -> Option<&'b [u8]> {
        self.device.poll_transmit(now, buf)
    }

    /// See [`Device::poll_timeout`]; earlier while an image is being written.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Instant> {
        [self.device.poll_timeout(), self.look_again].into_iter().flatten().min()
    }

    /// See [`Device::poll_event`].
    #[must_use]
    pub fn poll_event(&mut self) -> Option<Event> {
        self.device.poll_event()
    }

    fn take_outcome(&mut self, now: Instant) {
        self.now = now;
        if let (Some(file), Some(newest)) = (&self.file, self.in_flight)
            && let Some((generation, outcome)) = file.outcome()
        {
            self.in_flight = Some(newest).filter(|newest| *newest > generation);
            self.device.handle_stored(now, generation, outcome);
        }
    }

    fn hand_over(&mut self, now: Instant) {
        if let Some(file) = &self.file
            && let Some(request) = self.device.poll_image()
        {
            self.in_flight = Some(request.generation);
            file.store(request);
        }
        self.look_again = self.in_flight.map(|_| now.saturating_add(LOOK_AGAIN));
    }
}

impl Drop for StoredDevice {
    fn drop(&mut self) {
        if self.file.is_none() {
            return;
        }
        self.take_outcome(self.now);
        self.device.power_off(self.now);
        let end = self.now.saturating_add(LONGEST_RUN_OUT);
        while self.device.status().moving
            && let Some(due) = self.device.poll_timeout().filter(|due| *due <= end)
        {
            self.device.handle_timeout(due);
        }
        self.hand_over(self.now);
    }
}
