//! A UART with an RS-485 transceiver, whose direction pin is set while it sends.

use core::convert::Infallible;

use embedded_hal::digital::{self, OutputPin};
use thiserror::Error;

/// A UART at an RS-485 transceiver whose driver a pin enables: high while sending, low while listening.
///
/// The UART is to be set to the rate of the line, 8 data bits, **even parity**, 1 stop bit.
#[derive(Debug)]
pub struct Rs485<U, P = NoPin> {
    pub(super) uart: U,
    pub(super) direction: P,
}

/// The port cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum PortError<E, P> {
    /// The UART refused to send.
    #[error("the UART does not send")]
    Send(E),
    /// The direction pin could not be set.
    #[error("the direction pin cannot be set")]
    Direction(P),
}

impl<U, P: OutputPin> Rs485<U, P> {
    /// Listens: the direction pin is low.
    ///
    /// # Errors
    /// That of the pin.
    pub fn new(uart: U, mut direction: P) -> Result<Self, P::Error> {
        direction.set_low()?;
        Ok(Self { uart, direction })
    }
}

/// For transceivers that find the direction by themselves, and UARTs that set the pin in hardware.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoPin;

impl digital::ErrorType for NoPin {
    type Error = Infallible;
}

impl OutputPin for NoPin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

/// So many octets are taken from the UART at once.
pub(super) const CHUNK: usize = 32;
