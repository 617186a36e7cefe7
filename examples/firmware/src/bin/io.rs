//! The I/O station of our own at address 7.
#![no_std]
#![no_main]

#[path = "../../../own_station.rs"]
mod own_station;

use cortex_m_rt::entry;
use profidrive::time::BaudRate;
use profidrive_firmware::board::{Board, TIMING};
use profidrive_firmware::say;

const BAUD: BaudRate = BaudRate::K1500;

#[entry]
fn main() -> ! {
    let mut board = Board::start();
    // It lies in this frame, which is never left.
    let mut slave = own_station::slave(BAUD, TIMING.resync(BAUD));
    say("ready\n");
    board.serve(&mut slave, |now, slave| {
        // A log would take them.
        while slave.poll_news().is_some() {}
        own_station::application(now, slave);
    })
}
