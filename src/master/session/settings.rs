//! The settings of a master on a line: address, rate, times, watchdog.

use core::time::Duration;

use profirust::fdl::ParametersBuilder;

use crate::master::phy::baudrate;
use crate::profibus::fdl::Address;
use crate::time::BaudRate;

/// How a master takes part in a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// The address of the master, 0 to 125.
    pub master: Address,
    /// The rate of the line.
    pub baud: BaudRate,
    /// How long an answer is waited for. Brought to what the rate allows at least and 65535 T_bit hold at most.
    pub slot_time: Duration,
    /// How often an unanswered request is repeated, 1 to 15.
    pub retry_limit: u8,
    /// The target token rotation time: what all masters together may take.
    pub token_rotation: Duration,
    /// From one exchange to the next.
    pub cycle: Duration,
    /// DP watchdog time (Set_Prm), 10 ms to 650 s; the drive releases the motor when it expires.
    pub watchdog: Duration,
}

impl Settings {
    /// For a line whose octets have no time of their own: a pseudo-terminal, TCP. Answers are waited for as long as a
    /// busy machine may take.
    pub const fn untimed(master: Address, baud: BaudRate) -> Self {
        Self {
            master,
            baud,
            slot_time: Duration::from_millis(50),
            retry_limit: 15,
            token_rotation: Duration::from_millis(500),
            cycle: Duration::from_millis(1),
            watchdog: Duration::from_secs(1),
        }
    }

    /// For an RS-485 line behind an adapter that may hold octets back for some milliseconds. Other masters get the
    /// token soon.
    pub const fn on_wire(master: Address, baud: BaudRate) -> Self {
        Self {
            slot_time: Duration::from_millis(20),
            retry_limit: 3,
            token_rotation: Duration::from_millis(100),
            ..Self::untimed(master, baud)
        }
    }

    pub(super) fn bits(self, time: Duration) -> u32 {
        let bits = time.as_nanos().saturating_mul(self.baud.bits_per_second().into()) / 1_000_000_000;
        u32::try_from(bits).unwrap_or(u32::MAX)
    }

    /// profirust's form, within the bounds it insists on.
    pub(super) fn parameters(self) -> profirust::fdl::Parameters {
        let baud = baudrate(self.baud);
        let mut parameters = ParametersBuilder::new(self.master.number().min(125), baud);
        let least = parameters.build().slot_bits;
        let slot_bits = u16::try_from(self.bits(self.slot_time)).unwrap_or(u16::MAX).max(least);
        // A reply that is longer than the slot time is seen arriving.
        let rotation = self.bits(self.token_rotation).max(4 * u32::from(slot_bits));
        parameters
            .slot_bits(slot_bits)
            .max_retry_limit(self.retry_limit.clamp(1, 15))
            .token_rotation_bits(rotation.clamp(32_436, 16_777_960))
            .watchdog_timeout(
                self.watchdog.clamp(Duration::from_millis(10), Duration::from_secs(650)).into(),
            );
        parameters.build()
    }
}
