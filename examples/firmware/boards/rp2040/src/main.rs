//! The I/O station of `gsd/PDRV494F.GSD` on an RP2040: UART0 on GP0 and GP1, the direction of the RS-485 transceiver on GP2.
//!
//! The UART has a buffer of 32 octets, so a loop that never sleeps is enough: the timer of 1 us keeps min T_SDR.

#![no_std]
#![no_main]

#[path = "../../../../own_station.rs"]
mod own_station;

use panic_halt as _;
use profidrive::embedded::Rs485;
use profidrive::profibus::fdl::Resync;
use profidrive::time::{BaudRate, Instant};
use rp2040_hal::clocks::init_clocks_and_plls;
use rp2040_hal::fugit::RateExtU32;
use rp2040_hal::gpio::{FunctionSioOutput, FunctionUart, Pins, PullDown};
use rp2040_hal::uart::{DataBits, Parity, StopBits, UartConfig, UartPeripheral};
use rp2040_hal::{Clock, Sio, Timer, Watchdog, pac};

#[unsafe(link_section = ".boot2")]
#[used]
static BOOT2: [u8; 256] = rp2040_boot2::BOOT_LOADER_GENERIC_03H;

const BAUD: BaudRate = BaudRate::K500;
const CRYSTAL_HZ: u32 = 12_000_000;
#[rp2040_hal::entry]
fn main() -> ! {
    let Some(mut chip) = pac::Peripherals::take() else { panic!("main was called twice") };
    let mut watchdog = Watchdog::new(chip.WATCHDOG);
    let Ok(clocks) = init_clocks_and_plls(
        CRYSTAL_HZ,
        chip.XOSC,
        chip.CLOCKS,
        chip.PLL_SYS,
        chip.PLL_USB,
        &mut chip.RESETS,
        &mut watchdog,
    ) else {
        panic!("no clock")
    };
    let timer = Timer::new(chip.TIMER, &mut chip.RESETS, &clocks);
    let pins = Pins::new(chip.IO_BANK0, chip.PADS_BANK0, Sio::new(chip.SIO).gpio_bank0, &mut chip.RESETS);

    let line = (pins.gpio0.into_function::<FunctionUart>(), pins.gpio1.into_function::<FunctionUart>());
    let settings =
        UartConfig::new(BAUD.bits_per_second().Hz(), DataBits::Eight, Some(Parity::Even), StopBits::One);
    let Ok(mut uart) = UartPeripheral::new(chip.UART0, line, &mut chip.RESETS)
        .enable(settings, clocks.peripheral_clock.freq())
    else {
        panic!("no such rate")
    };
    uart.set_fifos(true);
    let direction = pins.gpio2.into_function::<FunctionSioOutput>().into_pull_type::<PullDown>();
    let Ok(mut port) = Rs485::new(uart, direction);

    // Whatever is no telegram is ignored until the line was silent.
    let mut slave = own_station::slave(BAUD, Resync::Idle(BAUD));
    let clock = || Instant::from_micros(timer.get_counter().ticks());
    loop {
        // Neither the UART nor the pin of this chip has errors of its own.
        if let Ok(true) = port.pass(&mut slave, clock) {
            while slave.poll_news().is_some() {}
            own_station::application(clock(), &mut slave);
        }
    }
}
