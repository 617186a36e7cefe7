//! The drive AG03/1 at address 5 on an STM32F405: USART2 on PA2 and PA3, the direction of the RS-485 transceiver on PA1, events by
//! `defmt` over RTT.
//!
//! The receive interrupt of embassy's `BufferedUart` collects octets, its timer wakes the task for min T_SDR and application
//! cycles.
#![no_std]
#![no_main]

use defmt::{error, info};
use defmt_rtt as _;
use embassy_executor::Spawner;
use embassy_stm32::gpio::{Level, Output, Speed};
use embassy_stm32::usart::{
    BufferedInterruptHandler, BufferedUart, Config as UartConfig, DataBits, Parity, StopBits,
};
use embassy_stm32::{bind_interrupts, peripherals};
use embassy_time::Delay;
use panic_probe as _;
use profidrive::devices::ag03::profibus::{Config, Device, DipSwitches, Timing};
use profidrive::embedded::Rs485;
use profidrive::time::{BaudRate, Instant};

bind_interrupts!(struct Interrupts {
    USART2 => BufferedInterruptHandler<peripherals::USART2>;
});

const BAUD: BaudRate = BaudRate::K500;

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    let chip = embassy_stm32::init(embassy_stm32::Config::default());

    let mut settings = UartConfig::default();
    settings.baudrate = BAUD.bits_per_second();
    // The parity bit is the ninth of this UART's word.
    settings.data_bits = DataBits::DataBits9;
    settings.parity = Parity::ParityEven;
    settings.stop_bits = StopBits::STOP1;
    // A longest telegram each way.
    let (mut to_line, mut from_line) = ([0; 256], [0; 256]);
    let uart = BufferedUart::new(
        chip.USART2,
        chip.PA3,
        chip.PA2,
        &mut to_line,
        &mut from_line,
        Interrupts,
        settings,
    );
    let Ok(uart) = uart else { defmt::panic!("no such rate") };
    let Ok(mut port) = Rs485::new(uart, Output::new(chip.PA1, Level::Low, Speed::VeryHigh));

    let now = || Instant::from_micros(embassy_time::Instant::now().as_micros());
    let config = Config { baud: BAUD, timing: Timing::True, ..Config::new(DipSwitches::from_bits(5)) };
    let mut drive = Device::new(config, now());
    let log = |at: Instant, drive: &mut Device| {
        while let Some(event) = drive.poll_event() {
            info!("{}: {}", at, event);
        }
    };
    let Err(ended) = port.serve(&mut drive, &mut Delay, now, log).await;
    error!("{}", defmt::Debug2Format(&ended));
}
