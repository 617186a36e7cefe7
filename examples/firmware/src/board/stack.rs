//! How deep the stack has been: it is painted, and later the paint that is left tells.

use core::ptr;

use cortex_m::register::msp;

const PAINT: u32 = 0xA5A5_5A5A;

/// Under the stack pointer, for the registers that the painter itself saves there.
const MARGIN: u32 = 32;

/// Paints so many octets under the stack. Returns where the paint begins, for [`painted_depth`].
#[inline(never)]
pub fn paint(octets: u32) -> u32 {
    let top = (msp::read() & !3) - MARGIN;
    let mut place = top - octets;
    while place < top {
        // SAFETY: RAM between statics and stack that nobody uses: the statics end far below (memory.x).
        unsafe { ptr::write_volatile(place as *mut u32, PAINT) };
        place += 4;
    }
    top
}

/// How deep the stack was since, in octets under the painter's caller.
#[inline(never)]
pub fn painted_depth(top: u32, octets: u32) -> u32 {
    let mut place = top - octets;
    // SAFETY: as above, only read.
    while place < top && unsafe { ptr::read_volatile(place as *const u32) } == PAINT {
        place += 4;
    }
    if place == top { 0 } else { top - place + MARGIN }
}
