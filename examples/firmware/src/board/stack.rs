//! How deep the stack has been: it is painted, and later the paint that is left tells.

use core::ptr;

use cortex_m::register::msp;

const PAINT: u32 = 0xA5A5_5A5A;

/// Under the frame of whoever calls, which may still push.
const MARGIN: u32 = 256;

/// Paints so many octets under the stack of the caller. Returns where the paint begins, for [`painted_depth`].
#[inline(never)]
pub fn paint(octets: u32) -> u32 {
    let top = (msp::read() - MARGIN) & !3;
    for place in (top - octets..top).step_by(4) {
        // SAFETY: RAM between statics and stack that nobody uses: the statics end far below (memory.x).
        unsafe { ptr::write_volatile(place as *mut u32, PAINT) };
    }
    top
}

/// How many of the octets painted under `top` were used since, the margin included.
#[inline(never)]
pub fn painted_depth(top: u32, octets: u32) -> u32 {
    let mut place = top - octets;
    // SAFETY: as above, only read.
    while place < top && unsafe { ptr::read_volatile(place as *const u32) } == PAINT {
        place += 4;
    }
    top - place + MARGIN
}
