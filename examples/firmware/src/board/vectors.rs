//! The table of interrupts, and which of them are on.

use cortex_m::peripheral::NVIC;
use cortex_m_rt::exception;

use super::{clock, uart};
use crate::ended;

const UART_RX: u16 = 0;
const UART_TX: u16 = 1;
const TIMER0: u16 = 8;

/// How many interrupts the chip has.
const COUNT: usize = 32;

#[derive(Clone, Copy)]
struct Interrupt(u16);

// SAFETY: the numbers are those of the chip's table.
unsafe impl cortex_m::interrupt::InterruptNumber for Interrupt {
    fn number(self) -> u16 {
        self.0
    }
}

#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
static __INTERRUPTS: [extern "C" fn(); COUNT] = {
    let mut table: [extern "C" fn(); COUNT] = [unexpected; COUNT];
    table[UART_RX as usize] = uart::received;
    table[UART_TX as usize] = uart::sent;
    table[TIMER0 as usize] = clock::alarm;
    table
};

/// Lets octets and the alarm interrupt the program.
pub(super) fn enable() {
    for number in [UART_RX, UART_TX, TIMER0] {
        // SAFETY: no program relies on an interrupt being masked.
        unsafe { NVIC::unmask(Interrupt(number)) };
    }
}

/// Nobody has enabled it.
extern "C" fn unexpected() {
    ended("an interrupt that nobody has enabled\n");
}

#[exception]
unsafe fn HardFault(_: &cortex_m_rt::ExceptionFrame) -> ! {
    ended("hard fault\n")
}
