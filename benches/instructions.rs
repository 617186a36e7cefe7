//! The paths whose instructions `benches/instructions.sh` counts under callgrind: each a function of its own, called a
//! thousand times. What this prints is nothing.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::std_instead_of_core,
    reason = "a bench may panic, and has std"
)]

mod travelling;
mod turning;

use core::time::Duration;
use std::hint::black_box;

use profidrive::devices::ag03::profibus::{Device, MAX_TELEGRAM_LEN};
use profidrive::profibus::fdl::Telegram;
use profidrive::profibus::fdl::telegram::{Decoded, decode};
use profidrive::time::Instant;
use travelling::{Travelling, exchange};

const CALLS: usize = 1_000;

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
    answer(device, now, octets, buf);
}

#[inline(always)]
fn answer(device: &mut Device, now: Instant, octets: &[u8], buf: &mut [u8; MAX_TELEGRAM_LEN]) {
    device.handle_bytes(now, octets);
    let due = now.saturating_add(Duration::from_nanos(917));
    assert!(device.poll_transmit(due, buf).is_some());
}

#[inline(never)]
fn application_cycle(device: &mut Device, now: Instant) {
    device.handle_timeout(now);
}

/// The same behind outputs that are not those of the cycle before.
#[inline(never)]
fn cycle_of_new_outputs(device: &mut Device, now: Instant) {
    // Not the same code as above, or the compiler makes one function of both.
    device.handle_timeout(black_box(now));
}

/// Nodes of CAN: an SDO request up to its answer, a SYNC up to its TPDO.
mod node {
    use super::turning::{Listed, SYNC};
    use super::{CALLS, black_box};

    #[inline(never)]
    fn sdo_answer(device: &mut Listed) -> usize {
        device.data(0x605, black_box(&[0x40, 0x18, 0x10, 1, 0, 0, 0, 0]))
    }

    #[inline(never)]
    fn sync_to_last_tpdo(device: &mut Listed) -> usize {
        device.data(SYNC, black_box(&[]))
    }

    pub(super) fn run(name: &str) {
        let mut device = Listed::named(name);
        for _ in 0..CALLS {
            assert_eq!(sdo_answer(&mut device), 1, "{name}");
            assert!(sync_to_last_tpdo(&mut device) >= 1, "{name}");
        }
    }
}

fn main() {
    if let Some(name) = std::env::args().nth(1) {
        return node::run(&name);
    }
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

    let Travelling { mut device, mut now, mut buf } = Travelling::new();
    let requests = [exchange(0x7D, 0x7B), exchange(0x5D, 0x7B)];
    for number in 0..CALLS {
        turnaround(&mut device, now, &requests[number & 1], &mut buf);
    }
    for _ in 0..CALLS {
        now = now.saturating_add(Duration::from_millis(1));
        application_cycle(&mut device, now);
    }
    // STW.2 means nothing to the drive.
    let requests = [exchange(0x7D, 0x7B), exchange(0x5D, 0x7F)];
    for number in 0..CALLS {
        answer(&mut device, now, &requests[number & 1], &mut buf);
        now = now.saturating_add(Duration::from_millis(1));
        cycle_of_new_outputs(&mut device, now);
    }
    assert!(device.status().travelling);
}
