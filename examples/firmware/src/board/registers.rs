//! The registers of the chip: ARM's application note AN386, CMSDK UART and timer.

use core::ptr;

/// One register.
#[derive(Clone, Copy)]
pub(super) struct Register(usize);

impl Register {
    pub(super) fn read(self) -> u32 {
        // SAFETY: only the constants below exist; each is a register of the board that may be read at any time.
        unsafe { ptr::read_volatile(self.0 as *const u32) }
    }

    pub(super) fn write(self, value: u32) {
        // SAFETY: as above; writing changes nothing in memory.
        unsafe { ptr::write_volatile(self.0 as *mut u32, value) }
    }
}

const UART0: usize = 0x4000_4000;
pub(super) const UART_DATA: Register = Register(UART0);
/// What the receiver and the transmitter hold; writing a 1 to an overrun clears it.
pub(super) const UART_STATE: Register = Register(UART0 + 0x04);
pub(super) const UART_CTRL: Register = Register(UART0 + 0x08);
/// Which interrupt is pending; writing a 1 clears it.
pub(super) const UART_INT: Register = Register(UART0 + 0x0C);
/// 25 MHz are divided by this; 16 at least.
pub(super) const UART_BAUDDIV: Register = Register(UART0 + 0x10);

pub(super) const RX_FULL: u32 = 1 << 1;
pub(super) const RX_OVERRUN: u32 = 1 << 3;
/// Transmitter, receiver, and an interrupt for each.
pub(super) const UART_ON: u32 = 0b1111;
pub(super) const TX_INT: u32 = 1 << 0;
pub(super) const RX_INT: u32 = 1 << 1;

const TIMER0: usize = 0x4000_0000;
const TIMER1: usize = 0x4000_1000;
pub(super) const ALARM_CTRL: Register = Register(TIMER0);
pub(super) const ALARM_VALUE: Register = Register(TIMER0 + 0x04);
pub(super) const ALARM_RELOAD: Register = Register(TIMER0 + 0x08);
pub(super) const ALARM_INT: Register = Register(TIMER0 + 0x0C);
pub(super) const CLOCK_CTRL: Register = Register(TIMER1);
/// Counts down.
pub(super) const CLOCK_VALUE: Register = Register(TIMER1 + 0x04);
pub(super) const CLOCK_RELOAD: Register = Register(TIMER1 + 0x08);

pub(super) const TIMER_ON: u32 = 1 << 0;
pub(super) const TIMER_INT: u32 = 1 << 3;
