//! The UART between its interrupts and the program: two rings without locks, one writer and one reader each.

use core::sync::atomic::{AtomicU8, AtomicU32, AtomicUsize, Ordering};

use super::clock::ticks;
use super::registers::{
    RX_FULL, RX_INT, RX_OVERRUN, TX_INT, UART_BAUDDIV, UART_CTRL, UART_DATA, UART_INT, UART_ON, UART_STATE,
};

/// What the receiver has heard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heard {
    /// An octet.
    Octet(u8),
    /// An octet that is not to be trusted, or that was lost. This UART sees overruns only; one with parity reports its errors
    /// here too.
    Damaged,
}

/// More than the longest telegram.
const ROOM: usize = 256;

/// Octets on their way, with their time: written by the receive interrupt, read by the program.
static RX: [AtomicU32; ROOM] = [const { AtomicU32::new(0) }; ROOM];
static RX_TICKS: [AtomicU32; ROOM] = [const { AtomicU32::new(0) }; ROOM];
/// How many were written and read, modulo 2³².
static RX_WRITTEN: AtomicUsize = AtomicUsize::new(0);
static RX_READ: AtomicUsize = AtomicUsize::new(0);

/// The telegram that is being sent: written by the program while nothing is, read by the transmit interrupt.
static TX: [AtomicU8; ROOM] = [const { AtomicU8::new(0) }; ROOM];
static TX_NEXT: AtomicUsize = AtomicUsize::new(0);
static TX_LEN: AtomicUsize = AtomicUsize::new(0);

/// In [`RX`]: the octet is damaged.
const DAMAGED: u32 = 1 << 8;

pub(super) fn start() {
    UART_BAUDDIV.write(16);
    UART_CTRL.write(UART_ON);
}

/// An octet has come. This UART holds one.
pub(super) extern "C" fn received() {
    let ticks = ticks();
    UART_INT.write(RX_INT);
    let mut heard = UART_DATA.read() & 0xFF;
    if UART_STATE.read() & RX_OVERRUN != 0 {
        UART_STATE.write(RX_OVERRUN);
        heard = DAMAGED;
    }
    put(heard, ticks);
}

/// Hands an octet over to the program.
#[inline(always)]
fn put(heard: u32, ticks: u32) {
    let written = RX_WRITTEN.load(Ordering::Relaxed);
    if written.wrapping_sub(RX_READ.load(Ordering::Acquire)) < ROOM {
        RX[written % ROOM].store(heard, Ordering::Relaxed);
        RX_TICKS[written % ROOM].store(ticks, Ordering::Relaxed);
        RX_WRITTEN.store(written.wrapping_add(1), Ordering::Release);
    } else {
        // Nobody has read 256 octets: the newest says that some are missing.
        RX[written.wrapping_sub(1) % ROOM].store(DAMAGED, Ordering::Relaxed);
    }
}

/// The last octet is on its way: the next one, if there is one. On a chip the direction pin falls behind the last.
pub(super) extern "C" fn sent() {
    UART_INT.write(TX_INT);
    let next = TX_NEXT.load(Ordering::Relaxed);
    if next < TX_LEN.load(Ordering::Acquire) {
        UART_DATA.write(u32::from(TX[next % ROOM].load(Ordering::Relaxed)));
        TX_NEXT.store(next + 1, Ordering::Release);
    } else {
        TX_LEN.store(0, Ordering::Release);
    }
}

/// The next octet and the ticks of its interrupt.
pub(super) fn receive() -> Option<(u32, Heard)> {
    let read = RX_READ.load(Ordering::Relaxed);
    if read == RX_WRITTEN.load(Ordering::Acquire) {
        return None;
    }
    let heard = RX[read % ROOM].load(Ordering::Relaxed);
    let ticks = RX_TICKS[read % ROOM].load(Ordering::Relaxed);
    RX_READ.store(read.wrapping_add(1), Ordering::Release);
    let heard = if heard & DAMAGED == 0 { Heard::Octet(heard as u8) } else { Heard::Damaged };
    Some((ticks, heard))
}

/// Whether nothing waits to be received.
pub(super) fn is_silent() -> bool {
    RX_READ.load(Ordering::Relaxed) == RX_WRITTEN.load(Ordering::Acquire)
}

/// Begins to send 1 to 256 octets; `false` while others are being sent.
pub(super) fn send(octets: &[u8]) -> bool {
    if is_sending() {
        return false;
    }
    let Some(first) = octets.first() else { return true };
    for (place, octet) in TX.iter().zip(octets) {
        place.store(*octet, Ordering::Relaxed);
    }
    TX_NEXT.store(1, Ordering::Relaxed);
    TX_LEN.store(octets.len(), Ordering::Release);
    UART_DATA.write(u32::from(*first));
    true
}

/// Whether a telegram is on its way out.
pub fn is_sending() -> bool {
    TX_LEN.load(Ordering::Acquire) != 0
}

/// Hands an octet over as the receive interrupt does, to measure with.
pub fn hear(octet: u8) {
    put(u32::from(octet), ticks());
}

/// How many octets the receive interrupt has taken, to measure with.
pub fn octets_taken() -> usize {
    RX_WRITTEN.load(Ordering::Acquire)
}

/// An octet waits in the UART, as while interrupts are masked, to measure with.
pub fn holds_octet() -> bool {
    UART_STATE.read() & RX_FULL != 0
}
