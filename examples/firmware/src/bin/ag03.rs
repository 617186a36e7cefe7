//! The drive AG03/1 at address 5: parameter channel, state machine, plant.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use profidrive::device::{Config, Device, DipSwitches};
use profidrive::time::{BaudRate, Instant};
use profidrive_firmware::board::{Board, TIMING};
use static_cell::StaticCell;

static DRIVE: StaticCell<Device> = StaticCell::new();

#[entry]
fn main() -> ! {
    let mut board = Board::start();
    let config = Config { baud: BaudRate::K1500, timing: TIMING, ..Config::new(DipSwitches::from_bits(5)) };
    let drive = DRIVE.init_with(|| Device::new(config, Instant::ZERO));
    board.say("ready\n");
    // A firmware with a log would write the events there.
    board.serve(drive, |_, drive| while drive.poll_event().is_some() {})
}
