//! From the octets of a Data_Exchange to the octets of its reply, and one application cycle of a travelling drive.
//!
//! The budget of a reply at 12 Mbit/s is 917 ns: 11 bit times, the shortest min T_SDR. `cargo bench --bench cycle`
//! prints histograms of single replies and cycles, too, with the cost of looking at the clock taken off.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::cast_precision_loss,
    clippy::std_instead_of_core,
    clippy::wildcard_enum_match_arm,
    reason = "a bench may panic, and has std"
)]

use std::hint::black_box;
use std::time::{self, Duration};

use criterion::{Criterion, criterion_group, criterion_main};
use profidrive::device::{Config, Device, MAX_TELEGRAM_LEN, Timing};
use profidrive::fdl::{Address, DataTelegram, FunctionCode, Sap};
use profidrive::time::{BaudRate, Instant};

const FAR_AWAY: i32 = 900_000;

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

fn exchange(fc: u8, stw: u16) -> Vec<u8> {
    telegram(fc, None, &[&[0; 8], &stw.to_be_bytes()[..], &FAR_AWAY.to_be_bytes()].concat())
}

struct Bench {
    device: Device,
    now: Instant,
    buf: [u8; MAX_TELEGRAM_LEN],
}

impl Bench {
    /// A drive on its way to a target minutes away.
    fn travelling() -> Self {
        let address = Address::station(5).unwrap();
        let config = Config { baud: BaudRate::K12000, timing: Timing::True, ..Config::new(address) };
        let device = Device::new(config, Instant::ZERO);
        let mut bench = Self { device, now: Instant::ZERO, buf: [0; MAX_TELEGRAM_LEN] };
        bench.request(&telegram(0x6D, Some(61), &[0x80, 1, 1, 11, 0x0A, 0xC5, 0]));
        bench.request(&telegram(0x5D, Some(62), &[0xF3, 0xF2]));
        for (fc, stw) in [(0x7D, 0x0B), (0x5D, 0x0B), (0x7D, 0x3B), (0x5D, 0x3B), (0x7D, 0x7B), (0x5D, 0x7B)]
        {
            bench.request(&exchange(fc, stw));
        }
        bench.now = bench.now.saturating_add(Duration::from_secs(1));
        bench.device.handle_timeout(bench.now);
        assert!(bench.device.status().travelling);
        bench
    }

    fn request(&mut self, octets: &[u8]) {
        self.now = self.now.saturating_add(Duration::from_millis(1));
        assert_eq!(self.answer(octets), octets.len().min(23), "the reply is as long as its request, or SC");
        while self.device.poll_event().is_some() {}
    }

    /// Octets in, octets out. The time stands, so that no application cycle is in it.
    fn answer(&mut self, octets: &[u8]) -> usize {
        self.device.handle_bytes(self.now, octets);
        let due = self.now.saturating_add(Duration::from_nanos(917));
        let reply = self.device.poll_transmit(due, &mut self.buf).unwrap();
        if reply.len() == 1 { octets.len() } else { reply.len() }
    }
}

fn turnaround(criterion: &mut Criterion) {
    let mut bench = Bench::travelling();
    let requests = [exchange(0x7D, 0x7B), exchange(0x5D, 0x7B)];
    let mut turn = 0;
    criterion.bench_function("turnaround/data_exchange", |bencher| {
        bencher.iter(|| {
            turn ^= 1;
            bench.answer(black_box(&requests[turn]))
        });
    });
    distribution(&mut bench, &requests);
}

/// Every reply timed alone.
fn distribution(bench: &mut Bench, requests: &[Vec<u8>; 2]) {
    let times = Times::of(|number| {
        black_box(bench.answer(black_box(&requests[number & 1])));
    });
    println!("turnaround of single replies; 917 ns are 11 bit times at 12 Mbit/s");
    times.print();
}

/// Times of single calls in ns, sorted, the cost of looking at the clock taken off.
struct Times(Vec<u128>);

impl Times {
    const CALLS: usize = 1_000_000;

    fn of(work: impl FnMut(usize)) -> Self {
        let clock = Self::raw(|_| {}).percentile(50.0);
        Self(Self::raw(work).0.into_iter().map(|time| time.saturating_sub(clock)).collect())
    }

    fn raw(mut work: impl FnMut(usize)) -> Self {
        let mut times: Vec<u128> = (0..Self::CALLS)
            .map(|number| {
                let start = time::Instant::now();
                work(number);
                start.elapsed().as_nanos()
            })
            .collect();
        times.sort_unstable();
        Self(times)
    }

    fn percentile(&self, percent: f64) -> u128 {
        self.0[(self.0.len() as f64 * percent / 100.0) as usize]
    }

    /// A histogram, each bar a third longer than the one before, and percentiles.
    fn print(&self) {
        let (mut from, mut rest) = (0, self.0.as_slice());
        while !rest.is_empty() {
            let to = (from + from / 3).max(40);
            let (bar, behind) = rest.split_at(rest.partition_point(|time| *time < to));
            let share = bar.len() as f64 / self.0.len() as f64;
            println!(
                "  {from:>7} ns {:>8.4} % {}",
                share * 100.0,
                "#".repeat((share * 60.0).ceil() as usize)
            );
            (from, rest) = (to, behind);
        }
        for percent in [50.0, 90.0, 99.0, 99.9, 99.99] {
            println!("  {percent:>6} % within {:>6} ns", self.percentile(percent));
        }
    }
}

fn application_cycle(criterion: &mut Criterion) {
    let mut bench = Bench::travelling();
    criterion.bench_function("application_cycle/travelling", |bencher| {
        bencher.iter(|| {
            bench.now = bench.now.saturating_add(Duration::from_millis(1));
            bench.device.handle_timeout(black_box(bench.now));
            if !bench.device.status().travelling {
                bench = Bench::travelling();
            }
        });
    });
    let mut bench = Bench::travelling();
    let times = Times::of(|_| {
        bench.now = bench.now.saturating_add(Duration::from_millis(1));
        bench.device.handle_timeout(black_box(bench.now));
    });
    assert!(bench.device.status().travelling, "it travels for longer than is measured");
    println!("application cycle of a travelling drive");
    times.print();
}

criterion_group!(benches, turnaround, application_cycle);
criterion_main!(benches);
