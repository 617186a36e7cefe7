//! Frames of CAN as text of an slcan adapter, both ways, and their bits on the wire.
#![allow(clippy::unwrap_used, clippy::std_instead_of_core, reason = "a bench may panic, and has std")]

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use profidrive::can::slcan::{Adapter, FrameLine, parse_frame};
use profidrive::can::{Frame, Id, timing};

fn frames(criterion: &mut Criterion) {
    let base = Frame::with(Id::base(0x605).unwrap(), [0x40, 0x00, 0x10, 0x00, 0, 0, 0, 0]);
    let extended = Frame::with(Id::extended(0x0605_0001).unwrap(), [0x5A; 8]);
    for (name, frame) in [("base", base), ("extended", extended)] {
        let line = FrameLine::new(&frame, None);
        let text = line.as_octets().split_last().unwrap().1;
        criterion.bench_function(&format!("slcan_decode_{name}"), |bencher| {
            bencher.iter(|| parse_frame(black_box(text)));
        });
        criterion.bench_function(&format!("slcan_encode_{name}"), |bencher| {
            bencher.iter(|| FrameLine::new(black_box(&frame), None));
        });
        criterion.bench_function(&format!("bits_{name}"), |bencher| {
            bencher.iter(|| timing::bits(black_box(&frame)));
        });
        criterion.bench_function(&format!("adapter_{name}"), |bencher| {
            let mut adapter = Adapter::new();
            for octet in b"O\r" {
                adapter.receive(*octet, true);
            }
            bencher.iter(|| {
                let octets = black_box(line.as_octets());
                octets.iter().filter_map(|octet| adapter.receive(*octet, true)).count()
            });
        });
    }
}

criterion_group!(benches, frames);
criterion_main!(benches);
