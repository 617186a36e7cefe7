//! The I/O station of our own at address 7.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use profidrive::dp::Framed;
use profidrive_firmware::board::Board;
use profidrive_firmware::{ended, io_station, say};
use static_cell::StaticCell;

static SLAVE: StaticCell<Framed> = StaticCell::new();

#[entry]
fn main() -> ! {
    let mut board = Board::start();
    let Some(slave) = SLAVE.try_init_with(io_station::slave) else { ended("main was called twice\n") };
    say("ready\n");
    board.serve(slave, io_station::application)
}
