//! The board mps2-an386 as QEMU simulates it: an ARM Cortex-M4 at 25 MHz with UARTs and timers of ARM's CMSDK.
//!
//! For a chip of your own write these few files anew; the loop stays. `boards/` has an STM32F4 and an RP2040, with what others
//! have written for them.

mod clock;
mod registers;
mod stack;
mod uart;
mod vectors;

use core::time::Duration;

use cortex_m::asm;
use cortex_m::interrupt;
use profidrive::devices::ag03::profibus::Timing;
use profidrive::embedded::Slave;
use profidrive::profibus::fdl::MAX_TELEGRAM_LEN;
use profidrive::time::Instant;

use clock::Clock;

pub use clock::{NANOS_PER_TICK, ticks};
pub use stack::{paint, painted_depth};
pub use uart::{Heard, hear, holds_octet, is_sending, octets_taken};

/// What can be known of the time of octets: the simulator gets them when the host delivers them. On a chip: `Timing::True`.
pub const TIMING: Timing = Timing::Untrue;

/// The board, running.
pub struct Board {
    clock: Clock,
}

impl Board {
    /// Starts UART and timers. 8 data bits, even parity and the rate are the host's here; a chip sets them.
    pub fn start() -> Self {
        let clock = Clock::start();
        uart::start();
        vectors::enable();
        Self { clock }
    }

    /// The time since the start.
    pub fn now(&mut self) -> Instant {
        self.clock.now()
    }

    /// The next octet that the UART has heard, with the time of its interrupt.
    pub fn receive(&mut self) -> Option<(Instant, Heard)> {
        let (ticks, heard) = uart::receive()?;
        Some((self.clock.at(ticks), heard))
    }

    /// Sends 1 to 255 octets, each in the interrupt of the one before. What is still being sent is finished first.
    pub fn send(&mut self, octets: &[u8]) {
        while !uart::send(octets) {
            asm::nop();
        }
    }

    /// Sleeps until an interrupt, or until this time.
    pub fn sleep(&mut self, until: Option<Instant>) {
        let now = self.clock.now();
        // A limit, so that the clock is read before its ticks come round.
        let time = until.map_or(LONGEST_SLEEP, |until| until.saturating_since(now).min(LONGEST_SLEEP));
        if time.is_zero() {
            return;
        }
        // An octet or an alarm that comes between the look and the sleep ends the sleep.
        interrupt::free(|_| {
            self.clock.alarm_in(time);
            if uart::is_silent() {
                asm::wfi();
            }
        });
    }

    /// Serves a slave for ever. `turn` has the application's say whenever something has come of an octet or of time.
    pub fn serve<S: Slave>(&mut self, slave: &mut S, mut turn: impl FnMut(Instant, &mut S)) -> ! {
        let mut due = Some(Instant::ZERO);
        loop {
            if self.pass(slave, &mut turn, due) {
                due = slave.poll_timeout();
            }
            self.sleep(due);
        }
    }

    /// One pass: octets, time if it is `due`, a reply. Whether something has come of it.
    #[inline(never)]
    pub fn pass<S: Slave>(
        &mut self,
        slave: &mut S,
        turn: &mut impl FnMut(Instant, &mut S),
        due: Option<Instant>,
    ) -> bool {
        let mut news = false;
        while let Some((at, heard)) = self.receive() {
            news |= match heard {
                Heard::Octet(octet) => slave.handle_bytes(at, &[octet]),
                Heard::Damaged => slave.handle_damaged(at),
            };
        }
        let now = self.now();
        if due.is_some_and(|due| due <= now) {
            slave.handle_timeout(now);
            news = true;
        }
        // Most octets end no telegram: nothing to take, and no deadline comes nearer.
        if news {
            // The reply first: it was ready before its outputs are looked at.
            let mut buf = [0; MAX_TELEGRAM_LEN];
            if let Some(reply) = slave.poll_transmit(now, &mut buf) {
                self.send(reply);
            }
            turn(now, slave);
        }
        news
    }
}

const LONGEST_SLEEP: Duration = Duration::from_secs(10);
