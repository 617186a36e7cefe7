//! What the firmwares share: the board, and the end of a program that panics.
//!
//! | file | holds |
//! | --- | --- |
//! | `board` | [`Board`](board::Board): octets with their time, a clock, an alarm, sleep |
//! | `board/registers` | the registers of the chip; the only `unsafe` with `vectors` and the painted stack |
//! | `board/vectors` | the table of interrupts |
//! | `board/uart` | the UART between its interrupts and the program |
//! | `board/clock` | free-running ticks and an alarm |
//! | `bin/ag03` | the drive AG03/1 |
//! | `bin/io` | an I/O station of our own, `gsd/PDRV4601.GSD` |
//! | `bin/canopen` | the drive AG03/1 on CANopen, an adapter of slcan in front of it |
//! | `bin/measure` | instructions and stack, for `measure.sh` |
#![no_std]
#![deny(missing_docs)]

pub mod board;

use core::panic::PanicInfo;

use cortex_m_semihosting::debug::{self, EXIT_FAILURE};
use cortex_m_semihosting::hio;

/// Octets that no firmware sends are no reason to panic; should it happen, everybody sees it: the simulator ends with 1.
#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    if let (Ok(mut out), Some(at)) = (hio::hstdout(), info.location()) {
        let _nobody_left_to_tell = out
            .write_all(b"panic in ")
            .and_then(|()| out.write_all(at.file().as_bytes()))
            .and_then(|()| out.write_all(b" line "))
            .and_then(|()| out.write_all(&decimal(at.line())))
            .and_then(|()| out.write_all(b"\n"));
    }
    loop {
        debug::exit(EXIT_FAILURE);
    }
}

/// Five digits.
fn decimal(number: u32) -> [u8; 5] {
    [10_000, 1000, 100, 10, 1].map(|place| b'0' + (number / place % 10) as u8)
}
