//! The I/O station of our own at address 7.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use profidrive_firmware::board::Board;
use profidrive_firmware::{io_station, say};

#[entry]
fn main() -> ! {
    let mut board = Board::start();
    // It lies in this frame, which is never left.
    let mut slave = io_station::slave();
    say("ready\n");
    board.serve(&mut slave, io_station::application)
}
