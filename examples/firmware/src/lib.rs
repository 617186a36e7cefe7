//! What the firmwares share: the board, and how a program ends.
//!
//! | file | holds |
//! | --- | --- |
//! | `board` | [`Board`](board::Board): octets with their time, a clock, an alarm, sleep |
//! | `board/registers` | the registers of the chip; the only `unsafe` with `vectors` and the painted stack |
//! | `board/vectors` | the table of interrupts |
//! | `board/uart` | the UART between its interrupts and the program |
//! | `board/clock` | free-running ticks and an alarm |
//! | `bin/ag03` | the drive AG03/1 |
//! | `bin/io` | an I/O station of our own, `gsd/PDRV494F.GSD`, the one of `examples/own_station.rs` |
//! | `bin/dpv1` | an I/O station of DP-V1, `dpv1.gsd`: records, alarms, connections |
//! | `bin/canopen` | the drive AG03/1 on CANopen, an adapter of slcan in front of it |
//! | `bin/measure` | instructions and stack, for `measure.sh` |
#![no_std]
#![deny(missing_docs)]

pub mod board;

use core::panic::PanicInfo;

use cortex_m_semihosting::debug::{self, EXIT_FAILURE, EXIT_SUCCESS};
use cortex_m_semihosting::hio;

/// Nothing in these firmwares panics: `measure.sh` looks that the linker has found no way here.
#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    ended("panic\n")
}

/// The program cannot go on. Everybody sees it: the simulator ends with 1.
pub fn ended(why: &str) -> ! {
    say(why);
    loop {
        debug::exit(EXIT_FAILURE);
    }
}

/// The program has done its work: the simulator ends with 0.
pub fn done() -> ! {
    loop {
        debug::exit(EXIT_SUCCESS);
    }
}

/// Writes to the standard output of the simulator.
pub fn say(text: &str) {
    if let Ok(mut out) = hio::hstdout() {
        let _nobody_listens = out.write_all(text.as_bytes());
    }
}
