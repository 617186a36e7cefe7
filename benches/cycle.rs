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

mod travelling;

use std::hint::black_box;
use std::time::{self, Duration};

use criterion::{Criterion, criterion_group, criterion_main};
use travelling::{Travelling, exchange};

fn turnaround(criterion: &mut Criterion) {
    let mut bench = Travelling::new();
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
fn distribution(bench: &mut Travelling, requests: &[Vec<u8>; 2]) {
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
    let mut bench = Travelling::new();
    criterion.bench_function("application_cycle/travelling", |bencher| {
        bencher.iter(|| {
            bench.now = bench.now.saturating_add(Duration::from_millis(1));
            bench.device.handle_timeout(black_box(bench.now));
            if !bench.device.status().travelling {
                bench = Travelling::new();
            }
        });
    });
    let mut bench = Travelling::new();
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
