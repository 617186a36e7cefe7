//! The EEPROM of an AG03 as an image.

use core::time::Duration;

use super::Stored;
use super::state_dir::{Images, Newest, StateDir, StateDirError};
use crate::devices::ag03::profibus::{
    Config, Device, Eeprom, Generation, IMAGE_LEN, NotStored, StoreRequest,
};
use crate::time::Instant;

/// How long a shaft may run out when the drive is dropped.
const LONGEST_RUN_OUT: Duration = Duration::from_secs(60);

impl StateDir {
    /// The drive of this model and address, as its newest image says; without an image a new one, whose image is written
    /// before this returns. Its file is named by the model and by the address that the DIP switches say now, and stays
    /// its own wherever they take it, until the drive is dropped.
    ///
    /// # Errors
    /// [`StateDirError::Owned`], [`StateDirError::File`], [`StateDirError::Refused`]; the file is as before.
    pub fn load(&self, config: Config, now: Instant) -> Result<Stored<Device>, StateDirError> {
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
        Ok(Stored::in_file(device, file, now))
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

    /// The shaft runs out at once, and where it stops is stored.
    fn switch_off(&mut self, now: Instant) {
        self.power_off(now);
        let end = now.saturating_add(LONGEST_RUN_OUT);
        while self.status().moving
            && let Some(due) = Self::poll_timeout(self).filter(|due| *due <= end)
        {
            Self::handle_timeout(self, due);
        }
    }
}
