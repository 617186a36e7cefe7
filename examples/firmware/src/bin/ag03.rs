//! The drive AG03/1 at address 5: parameter channel, state machine, plant.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use profidrive::devices::ag03::profibus::{Config, Device, DipSwitches};
use profidrive::time::{BaudRate, Instant};
use profidrive_firmware::board::{Board, TIMING};
use profidrive_firmware::say;

#[entry]
fn main() -> ! {
    let mut board = Board::start();
    let config = Config { baud: BaudRate::K1500, timing: TIMING, ..Config::new(DipSwitches::from_bits(5)) };
    // It lies in this frame, which is never left.
    let mut drive = Device::new(config, Instant::ZERO);
    say("ready\n");
    // A firmware with a log would write the events there.
    board.serve(&mut drive, |_, drive| while drive.poll_event().is_some() {})
}
