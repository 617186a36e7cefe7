//! A drive on a microcontroller: the loop between a UART, a timer and the drive, without `std` and without an allocator.
//!
//! For a chip of your own implement [`Board`] and call [`pass`] for ever. `tests/small-target` links this file for a
//! Cortex-M4F; here, `cargo run --example firmware` runs it on a board in memory, which asks for the FDL status once.

use profidrive::devices::ag03::profibus::{Config, Device, MAX_TELEGRAM_LEN, Timing};
use profidrive::profibus::fdl::Address;
use profidrive::time::{BaudRate, Instant};

/// What the loop needs of a chip.
pub(crate) trait Board {
    /// The time since power-on.
    fn now(&mut self) -> Instant;
    /// The next octet that the UART has received.
    fn receive(&mut self) -> Option<u8>;
    /// Sends all these octets without a gap.
    fn send(&mut self, octets: &[u8]);
}

/// The drive at this address on a line of 1.5 MBd. On a chip it lies in a static: it is larger than most stacks.
pub(crate) fn drive(address: Address, now: Instant) -> Device {
    Device::new(Config { baud: BaudRate::K1500, timing: Timing::True, ..Config::new(address) }, now)
}

/// One pass of the loop. A chip may sleep between two of them until an octet comes or [`Device::poll_timeout`].
pub(crate) fn pass(board: &mut impl Board, device: &mut Device) {
    let now = board.now();
    while let Some(octet) = board.receive() {
        device.handle_bytes(now, &[octet]);
    }
    device.handle_timeout(now);
    let mut reply = [0; MAX_TELEGRAM_LEN];
    if let Some(reply) = device.poll_transmit(now, &mut reply) {
        board.send(reply);
    }
    // A firmware with a log would write them there.
    while device.poll_event().is_some() {}
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!("drive 5 answers {:02X?}", on_a_board_in_memory());
}

/// The reply to an FDL status request.
#[cfg(not(target_os = "none"))]
fn on_a_board_in_memory() -> Vec<u8> {
    struct InMemory {
        micros: u64,
        received: std::collections::VecDeque<u8>,
        sent: Vec<u8>,
    }
    impl Board for InMemory {
        fn now(&mut self) -> Instant {
            self.micros += 10;
            Instant::from_nanos(1000 * self.micros)
        }
        fn receive(&mut self) -> Option<u8> {
            // The line is idle before.
            if self.micros < 1000 { None } else { self.received.pop_front() }
        }
        fn send(&mut self, octets: &[u8]) {
            self.sent.extend(octets);
        }
    }
    let request = [0x10, 0x05, 0x02, 0x49, 0x50, 0x16];
    let mut board = InMemory { micros: 0, received: request.into(), sent: Vec::new() };
    let mut device = drive(Address::from_octet(5), Instant::ZERO);
    for _ in 0..200 {
        pass(&mut board, &mut device);
    }
    board.sent
}

#[cfg(test)]
#[test]
fn the_drive_answers() {
    assert_eq!(on_a_board_in_memory(), [0x10, 0x02, 0x05, 0x00, 0x07, 0x16]);
}
