//! A firmware as small as can be around one slave, one drive or nothing: octets of a UART in, octets out, a timer.
//!
//! The registers are no real chip's; the point is what the linker keeps.
#![no_std]
#![no_main]

use core::ptr::{read_volatile, write_volatile};

use cortex_m_rt::entry;

#[cfg(feature = "drive")]
#[path = "../../../examples/firmware.rs"]
mod firmware;

/// Where a chip would have its receiver, transmitter and a timer in ns.
const RECEIVED: *const u32 = 0x4000_0000 as *const u32;
const SEND: *mut u32 = 0x4000_0004 as *mut u32;
const NANOS: *const u64 = 0x4000_0008 as *const u64;

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {}
}

fn received() -> u8 {
    // SAFETY: stands for a register; this program is linked, never run.
    unsafe { read_volatile(RECEIVED) as u8 }
}

fn send(octet: u8) {
    // SAFETY: as above.
    unsafe { write_volatile(SEND, u32::from(octet)) }
}

fn nanos() -> u64 {
    // SAFETY: as above.
    unsafe { read_volatile(NANOS) }
}

#[entry]
fn main() -> ! {
    run()
}

#[cfg(not(any(feature = "slave", feature = "drive")))]
fn run() -> ! {
    loop {
        send(received().wrapping_add(nanos() as u8));
    }
}

/// A slave with two octets in and two out.
#[cfg(feature = "slave")]
fn run() -> ! {
    use core::mem::MaybeUninit;

    use profidrive::dp::{Description, Fixed, Station};
    use profidrive::fdl::{Address, Framer, Resync};
    use profidrive::time::{BaudRate, Instant};

    static mut SLAVE: MaybeUninit<(Framer, Station)> = MaybeUninit::uninit();

    let baud = BaudRate::K1500;
    let description = Description { ident: 0x1234, ..Description::default() };
    let application = Fixed { configurations: &[&[0x11, 0x21]], ..Fixed::PLAIN };
    let max_tsdr = Some(baud.max_tsdr_bits());
    let station = Station::new(Address::from_octet(5), baud, max_tsdr, description, application);
    // SAFETY: the only use of this static.
    let (framer, station) = unsafe { (*&raw mut SLAVE).write((Framer::new(Resync::Idle(baud)), station)) };
    loop {
        let now = Instant::from_nanos(nanos());
        framer.receive(now, &[received()], |at, result| {
            if let Ok(telegram) = result {
                station.receive(at, &telegram);
            }
        });
        station.handle_timeout(now);
        station.set_inputs(&[received(), received()]);
        if let Ok(Some(octets)) = station.poll_transmit(now) {
            octets.iter().for_each(|octet| send(*octet));
        }
        station.slave().outputs().iter().for_each(|octet| send(*octet));
    }
}

/// A drive: the loop of `examples/firmware.rs`.
#[cfg(feature = "drive")]
fn run() -> ! {
    use core::mem::MaybeUninit;

    use profidrive::device::Device;
    use profidrive::fdl::Address;
    use profidrive::time::Instant;

    struct Chip;

    impl firmware::Board for Chip {
        fn now(&mut self) -> Instant {
            Instant::from_nanos(nanos())
        }
        fn receive(&mut self) -> Option<u8> {
            Some(received()).filter(|octet| *octet != 0)
        }
        fn send(&mut self, octets: &[u8]) {
            octets.iter().for_each(|octet| send(*octet));
        }
    }

    static mut DRIVE: MaybeUninit<Device> = MaybeUninit::uninit();

    let Ok(address) = Address::station(5) else { loop {} };
    // SAFETY: the only use of this static.
    let device = unsafe { (*&raw mut DRIVE).write(firmware::drive(address, Instant::from_nanos(nanos()))) };
    loop {
        firmware::pass(&mut Chip, device);
        send(device.status().position as u8);
    }
}
