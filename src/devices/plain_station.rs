//! A device on PROFIBUS that makes its inputs from its outputs: an application behind a slave.

use crate::face::Description;
use crate::profibus::dp;
use crate::profibus::dp::Fixed;
use crate::profibus::dp::chk_cfg::MAX_IO_LEN;
use crate::profibus::fdl::Address;
use crate::time::{BaudRate, Instant};

/// A device behind a slave.
pub trait SlaveDevice: Description + Send + 'static {
    /// Its name in the list of devices, and what people call it.
    fn product(&self) -> (&'static str, &str);

    /// Makes inputs of the outputs. Each has the octets that the configuration gives it; none before there is one. Comes
    /// after each telegram, and when it is [due](SlaveDevice::due).
    fn exchange(&mut self, now: Instant, outputs: &[u8], inputs: &mut [u8]);

    /// When it changes something by itself; `None`: a telegram comes first.
    fn due(&self) -> Option<Instant> {
        None
    }
}

/// A [`SlaveDevice`] and its slave.
#[derive(Clone, Debug)]
pub struct PlainStation<D> {
    pub(crate) station: dp::Station,
    pub(crate) device: D,
}

impl<D: SlaveDevice> PlainStation<D> {
    /// The device at an address, switched on.
    pub fn new(
        address: Address,
        baud: BaudRate,
        description: dp::Description,
        application: Fixed<'static>,
        device: D,
    ) -> Self {
        Self { station: dp::Station::new(address, baud, None, description, application), device }
    }

    /// New inputs from the newest outputs.
    pub(crate) fn exchange(&mut self, now: Instant) {
        let mut inputs = [0; MAX_IO_LEN];
        let slave = self.station.slave();
        let inputs = inputs.get_mut(..slave.inputs().len()).unwrap_or_default();
        inputs.copy_from_slice(slave.inputs());
        self.device.exchange(now, slave.outputs(), inputs);
        self.station.set_inputs(inputs);
    }
}
