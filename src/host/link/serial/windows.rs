//! A serial port of Windows.

use std::io;

use rustix::event::PollFd;
use serial2::Parity;

use crate::host::Error;
use crate::host::link::com::Com;
use crate::time::BaudRate;

/// The device, open. Windows lets nobody else open it.
#[derive(Debug)]
pub(super) struct Port(Com);

impl Port {
    pub(super) fn open(device: &str, rate: BaudRate) -> Result<Self, Error> {
        Com::open(device, rate, Parity::Even).map(Self)
    }

    pub(super) fn prepare(&self, device: &str) {
        tracing::debug!("{device}: the adapter must switch the direction itself");
    }

    /// What has arrived, without waiting; 0: the device is gone.
    pub(super) fn read(&self, buf: &mut [u8]) -> io::Result<usize> {
        self.0.read(buf)
    }

    /// Takes as many octets as there is room for.
    pub(super) fn write(&self, octets: &[u8]) -> io::Result<usize> {
        self.0.write(octets)
    }

    /// What to sleep on until something arrives.
    pub(super) fn watch(&self) -> PollFd<'_> {
        self.0.watch()
    }

    /// What arrived at the rate before is forgotten.
    pub(super) fn set_rate(&mut self, rate: BaudRate) -> io::Result<()> {
        self.0.set_rate(rate)
    }
}
