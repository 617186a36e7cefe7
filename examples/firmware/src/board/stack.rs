//! How deep the stack has been: it is painted, and later the paint that is left tells.

use core::ptr;

use cortex_m::register::msp;

const PAINT: u32 = 0xA5A5_5A5A;

/// Paints so many octets under the stack. Returns where the paint begins, for [`painted_depth`].
#[inline(never)]
pub fn paint(octets: u32) -> u32 {
    // Nothing is called below, so nothing below this is in use.
    let top = msp::read() & !3;
    let mut place = top - octets;
    while place < top {
        // SAFETY: RAM between statics and stack that nobody uses: the statics end far below (memory.x).
        unsafe { ptr::write_volatile(place as *mut u32, PAINT) };
        place += 4;
    }
    top
}

/// How many of the octets painted under `top` were used since.
#[inline(never)]
pub fn painted_depth(top: u32, octets: u32) -> u32 {
    let mut place = top - octets;
    // SAFETY: as above, only read.
    while place < top && unsafe { ptr::read_volatile(place as *const u32) } == PAINT {
        place += 4;
    }
    top - place
}
