//! A drive and the file its EEPROM is kept in.

use core::time::Duration;
use std::path::PathBuf;

use super::state_dir::{ImageFile, Images, Newest, StateDir, StateDirError};
use crate::devices::StationEvent;
use crate::devices::ag03::profibus::{
    Config, Device, Eeprom, Generation, IMAGE_LEN, MAX_TELEGRAM_LEN, NotStored, StoreRequest,
};
use crate::profibus::fdl::Telegram;
use crate::time::{BaudRate, Instant};

/// How long a shaft may run out when the drive is dropped.
const LONGEST_RUN_OUT: Duration = Duration::from_secs(60);

/// A drive on a [`Bus`](super::Bus) whose EEPROM may be kept in a [`StateDir`].
///
/// Used like a [`Device`], with the same contract; it hands images to the writer and its reports to the drive.
/// Dropped, it is switched off: the shaft runs out at once, and where it stops is stored.
#[derive(Debug)]
pub struct StoredDevice {
    device: Device,
    file: Option<ImageFile<Generation>>,
    now: Instant,
}

impl From<Device> for StoredDevice {
    /// A drive whose EEPROM lives as long as it.
    fn from(device: Device) -> Self {
        Self { device, file: None, now: Instant::ZERO }
    }
}

impl StateDir {
    /// The drive of this model and address, as its newest image says; without an image a new one, whose image is written
    /// before this returns. Its file is named by the model and by the address that the DIP switches say now, and stays
    /// its own wherever they take it, until the drive is dropped.
    ///
    /// # Errors
    /// [`StateDirError::Owned`], [`StateDirError::File`], [`StateDirError::Refused`]; the file is as before.
    pub fn load(&self, config: Config, now: Instant) -> Result<StoredDevice, StateDirError> {
        let config = Config { eeprom: Eeprom::Host, ..config };
        let name = format!("{}-{:03}", config.model, config.switches.address().number());
        let (file, newest) = self.file::<Generation>(&name, IMAGE_LEN)?;
        let device = match newest {
            Some(Newest { octets, safe }) => {
                tracing::info!("EEPROM from {}", file.path().display());
                let restore = if safe { Device::restore } else { Device::restore_unstored };
                restore(config, &octets, now)
                    .map_err(|cause| StateDirError::Refused { path: file.path(), cause: Box::new(cause) })?
            }
            None => {
                tracing::info!("a new EEPROM in {}", file.path().display());
                let mut device = Device::new(config, now);
                if let Some(StoreRequest { generation, octets }) = device.poll_image() {
                    file.store_first(&octets)?;
                    device.handle_stored(now, generation, Ok(()));
                }
                device
            }
        };
        let mut stored = StoredDevice { device, file: Some(file), now };
        stored.hand_over(now);
        Ok(stored)
    }
}

impl Images for Device {
    type Generation = Generation;

    fn poll_image(&mut self) -> Option<(Generation, Vec<u8>)> {
        let StoreRequest { generation, octets } = Self::poll_image(self)?;
        Some((generation, octets.to_vec()))
    }

    fn handle_stored(&mut self, now: Instant, generation: Generation, stored: bool) {
        Self::handle_stored(self, now, generation, if stored { Ok(()) } else { Err(NotStored) });
    }
}

impl StoredDevice {
    /// The file of its EEPROM.
    pub(crate) fn path(&self) -> Option<PathBuf> {
        Some(self.file.as_ref()?.path())
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
    pub(crate) fn set_baud(&mut self, baud: BaudRate) {
        self.device.set_baud(baud);
    }

    /// See [`Device::handle_bytes`].
    pub fn handle_bytes(&mut self, now: Instant, octets: &[u8]) {
        self.take_outcome(now);
        self.device.handle_bytes(now, octets);
        self.hand_over(now);
    }

    /// See [`Device::handle_telegram`].
    pub(crate) fn handle_telegram(&mut self, now: Instant, telegram: &Telegram<'_>) {
        self.take_outcome(now);
        self.device.handle_telegram(now, telegram);
        self.hand_over(now);
    }

    /// See [`Device::handle_timeout`].
    pub fn handle_timeout(&mut self, now: Instant) {
        self.take_outcome(now);
        self.device.handle_timeout(now);
        self.hand_over(now);
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
        Instant::first_of(self.device.poll_timeout(), self.file.as_ref().and_then(ImageFile::poll_timeout))
    }

    /// See [`Device::poll_event`].
    #[must_use]
    pub fn poll_event(&mut self) -> Option<StationEvent> {
        self.device.poll_event()
    }

    fn take_outcome(&mut self, now: Instant) {
        self.now = now;
        if let Some(file) = &mut self.file {
            file.report_to(now, &mut self.device);
        }
    }

    fn hand_over(&mut self, now: Instant) {
        if let Some(file) = &mut self.file {
            file.take_from(now, &mut self.device);
        }
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
