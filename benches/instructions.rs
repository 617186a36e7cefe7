//! The paths whose instructions `benches/instructions.sh` counts under callgrind: each a function of its own, called a
//! thousand times. What this prints is nothing.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::std_instead_of_core,
    reason = "a bench may panic, and has std"
)]

use core::time::Duration;
use std::hint::black_box;

use profidrive::device::{Config, Device, MAX_TELEGRAM_LEN, Timing};
use profidrive::fdl::telegram::{Decoded, decode};
use profidrive::fdl::{Address, DataTelegram, FunctionCode, Sap, Telegram};
use profidrive::time::{BaudRate, Instant};

const CALLS: usize = 1_000;

fn telegram(fc: u8, sap: Option<u8>, data: &[u8]) -> Vec<u8> {
    let (dsap, ssap) = (sap.and_then(Sap::new), sap.and(Sap::new(62)));
    let telegram = DataTelegram {
        format: DataTelegram::customary_format(dsap, ssap, data),
        da: Address::from_octet(5),
        sa: Address::from_octet(2),
        dsap,
        ssap,
        fc: FunctionCode::from_octet(fc),
        data,
    };
    telegram.encode(&mut [0; MAX_TELEGRAM_LEN]).unwrap().to_vec()
}

#[inline(never)]
fn decode_profidrive(octets: &[u8]) {
    black_box(&decode(black_box(octets)));
}

#[inline(never)]
fn decode_profirust(octets: &[u8]) {
    black_box(&profirust::fdl::Telegram::deserialize(black_box(octets)));
}

#[inline(never)]
fn encode_profidrive(telegram: &Telegram<'_>, buf: &mut [u8]) {
    black_box(black_box(telegram).encode(buf).map_or(0, <[u8]>::len));
}

#[inline(never)]
fn encode_profirust(telegram: &profirust::fdl::Telegram<'_>, buf: &mut [u8]) {
    if let profirust::fdl::Telegram::Data(data) = black_box(telegram) {
        black_box(data.h.serialize(buf, data.pdu.len(), |pdu| pdu.copy_from_slice(data.pdu)));
    }
}

#[inline(never)]
fn turnaround(device: &mut Device, now: Instant, octets: &[u8], buf: &mut [u8; MAX_TELEGRAM_LEN]) {
    device.handle_bytes(now, octets);
    let due = now.saturating_add(Duration::from_nanos(917));
    assert!(device.poll_transmit(due, buf).is_some());
}

#[inline(never)]
fn application_cycle(device: &mut Device, now: Instant) {
    device.handle_timeout(now);
}

fn main() {
    let exchange = |fc: u8, stw: u16| {
        telegram(fc, None, &[&[0; 8], &stw.to_be_bytes()[..], &900_000_i32.to_be_bytes()].concat())
    };
    let octets = exchange(0x7D, 0x7B);
    let Decoded::Telegram { telegram: ours, .. } = decode(&octets) else { panic!() };
    let (theirs, _) = profirust::fdl::Telegram::deserialize(&octets).unwrap().unwrap();
    let mut buf = [0; MAX_TELEGRAM_LEN];
    for _ in 0..CALLS {
        decode_profidrive(&octets);
        decode_profirust(&octets);
        encode_profidrive(&ours, &mut buf);
        encode_profirust(&theirs, &mut buf);
    }

    let config =
        Config { baud: BaudRate::K12000, timing: Timing::True, ..Config::new(Address::station(5).unwrap()) };
    let mut device = Device::new(config, Instant::ZERO);
    let mut now = Instant::ZERO;
    let start = [
        telegram(0x6D, Some(61), &[0x80, 1, 1, 11, 0x0A, 0xC5, 0]),
        telegram(0x5D, Some(62), &[0xF3, 0xF2]),
        exchange(0x7D, 0x0B),
        exchange(0x5D, 0x0B),
        exchange(0x7D, 0x3B),
        exchange(0x5D, 0x7B),
    ];
    for octets in &start {
        now = now.saturating_add(Duration::from_millis(2));
        device.handle_bytes(now, octets);
        assert!(device.poll_transmit(now.saturating_add(Duration::from_nanos(917)), &mut buf).is_some());
        while device.poll_event().is_some() {}
    }
    now = now.saturating_add(Duration::from_secs(1));
    device.handle_timeout(now);
    assert!(device.status().travelling);
    let requests = [exchange(0x7D, 0x7B), exchange(0x5D, 0x7B)];
    for number in 0..CALLS {
        turnaround(&mut device, now, &requests[number & 1], &mut buf);
    }
    for _ in 0..CALLS {
        now = now.saturating_add(Duration::from_millis(1));
        application_cycle(&mut device, now);
    }
    assert!(device.status().travelling);
}
