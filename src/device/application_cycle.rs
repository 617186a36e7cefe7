//! How often the drive part runs.

use core::time::Duration;

use thiserror::Error;

/// How often the drive part runs unless told otherwise. The manuals state no time.
pub const DEFAULT_APPLICATION_CYCLE: Duration = Duration::from_millis(1);

/// How often the drive part runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ApplicationCycle(Duration);

impl ApplicationCycle {
    /// Every [`DEFAULT_APPLICATION_CYCLE`].
    pub const DEFAULT: Self = Self(DEFAULT_APPLICATION_CYCLE);

    /// Once after each Data_Exchange, for tests that count exchanges. [`DEFAULT_APPLICATION_CYCLE`] passes for the drive
    /// each time.
    pub const EACH_EXCHANGE: Self = Self(Duration::ZERO);

    /// The shortest: a device that is called late makes up for up to 60 s, so in 600 000 cycles at most, which take well
    /// under a second on a computer.
    pub const SHORTEST: Duration = Duration::from_micros(100);

    /// A cycle of this time.
    ///
    /// # Errors
    /// [`CycleTooShort`] below [`ApplicationCycle::SHORTEST`].
    pub const fn every(time: Duration) -> Result<Self, CycleTooShort> {
        if time.as_nanos() < Self::SHORTEST.as_nanos() {
            return Err(CycleTooShort { got: time });
        }
        Ok(Self(time))
    }

    /// From one cycle to the next; `None`: the cycle comes with Data_Exchange.
    pub(super) const fn period(self) -> Option<Duration> {
        if self.0.is_zero() { None } else { Some(self.0) }
    }

    /// How much time passes for the drive in one cycle.
    pub(super) const fn step(self) -> Duration {
        if self.0.is_zero() { DEFAULT_APPLICATION_CYCLE } else { self.0 }
    }
}

/// An application cycle that no computer keeps up with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("the application cycle is {got:?}, expected {:?} or more", ApplicationCycle::SHORTEST)]
pub struct CycleTooShort {
    /// The time found.
    pub got: Duration,
}

#[cfg(test)]
mod tests {
    use std::string::ToString;

    use super::*;
    use crate::device::{Config, Device};
    use crate::fdl::Address;
    use crate::time::Instant;

    #[test]
    fn a_cycle_below_the_shortest_is_refused() {
        for nanos in [0, 1, 99_999] {
            let got = Duration::from_nanos(nanos);
            assert_eq!(ApplicationCycle::every(got), Err(CycleTooShort { got }));
        }
        let error = ApplicationCycle::every(Duration::from_nanos(1)).unwrap_err();
        assert_eq!(error.to_string(), "the application cycle is 1ns, expected 100µs or more");
        assert!(ApplicationCycle::every(ApplicationCycle::SHORTEST).is_ok());
        assert!(ApplicationCycle::every(Duration::MAX).is_ok());
    }

    #[test]
    fn a_late_device_comes_back_with_the_shortest_and_the_longest_cycle() {
        for time in [ApplicationCycle::SHORTEST, Duration::MAX] {
            let application_cycle = ApplicationCycle::every(time).unwrap();
            let address = Address::station(5).unwrap();
            let mut device = Device::new(Config { application_cycle, ..Config::new(address) }, Instant::ZERO);
            // Inputs that are set wake the drive part.
            let inputs = *device.inputs();
            device.set_inputs(Instant::from_millis(1), inputs);
            device.handle_timeout(Instant::from_nanos(u64::MAX / 2));
            assert!(device.poll_timeout().is_none_or(|due| due > Instant::from_millis(1)));
        }
    }
}
