//! Decoding and encoding of the same octets by our codec and by profirust's, in one process.
//!
//! Ours checks more (second SD2, LE up to 249, extension octets, token addresses). Compare medians of the two rows
//! of a group, not nanoseconds of different machines: `cargo bench --bench codec`.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::cast_possible_truncation,
    clippy::std_instead_of_core,
    clippy::wildcard_enum_match_arm,
    reason = "a test may panic, and has std"
)]

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use profidrive::fdl::telegram::{Decoded, MAX_TELEGRAM_LEN, decode};

const TELEGRAMS: [(&str, &[u8]); 8] = [
    (
        "data_exchange_14",
        &[
            0x68, 0x11, 0x11, 0x68, 0x05, 0x02, 0x7D, 0x13, 0xFA, 0, 0, 0, 0, 0, 0, 0x00, 0x7B, 0, 0, 0x13,
            0x88, 0xA7, 0x16,
        ],
    ),
    ("fdl_status_sd1", &[0x10, 0x05, 0x02, 0x49, 0x50, 0x16]),
    ("slave_diag_saps", &[0x68, 0x05, 0x05, 0x68, 0x85, 0x82, 0x6D, 0x3C, 0x3E, 0xEE, 0x16]),
    ("sd3", &[0xA2, 0x05, 0x02, 0x7D, 1, 2, 3, 4, 5, 6, 7, 8, 0xA8, 0x16]),
    ("token_sd4", &[0xDC, 0x02, 0x03]),
    ("short_acknowledge", &[0xE5]),
    ("wrong_fcs", &[0x68, 0x05, 0x05, 0x68, 0x85, 0x82, 0x6D, 0x3C, 0x3E, 0xEF, 0x16]),
    ("incomplete", &[0x68, 0x11, 0x11, 0x68, 0x05, 0x02, 0x7D]),
];

fn decoding(criterion: &mut Criterion) {
    for (name, octets) in TELEGRAMS {
        // Both must judge the octets as the bench's name says, or the comparison says nothing.
        let accepted = !matches!(name, "wrong_fcs" | "incomplete");
        assert_eq!(
            matches!(decode(octets), Decoded::Telegram { .. }),
            accepted,
            "{name}: {:?}",
            decode(octets)
        );
        assert_eq!(matches!(profirust::fdl::Telegram::deserialize(octets), Some(Ok(_))), accepted, "{name}");

        let mut group = criterion.benchmark_group(format!("decode/{name}"));
        group.bench_function("profidrive", |bench| bench.iter(|| black_box(decode(black_box(octets)))));
        group.bench_function("profirust", |bench| {
            bench.iter(|| black_box(profirust::fdl::Telegram::deserialize(black_box(octets))));
        });
        group.finish();
    }
}

fn encoding(criterion: &mut Criterion) {
    for (name, octets) in TELEGRAMS {
        let Decoded::Telegram { telegram: ours, len } = decode(octets) else { continue };
        let Some(Ok((profirust::fdl::Telegram::Data(theirs), _))) =
            profirust::fdl::Telegram::deserialize(octets)
        else {
            continue;
        };
        let mut buf = [0; MAX_TELEGRAM_LEN];
        assert_eq!(ours.encode(&mut buf).map(<[u8]>::len), Ok(len), "{name}");
        let written = theirs.h.serialize(&mut buf, theirs.pdu.len(), |pdu| pdu.copy_from_slice(theirs.pdu));
        assert_eq!(&buf[..written], octets, "{name}");

        let mut group = criterion.benchmark_group(format!("encode/{name}"));
        group.bench_function("profidrive", |bench| {
            bench.iter(|| black_box(&ours).encode(black_box(&mut buf)).map(<[u8]>::len));
        });
        group.bench_function("profirust", |bench| {
            bench.iter(|| {
                let theirs = black_box(&theirs);
                theirs
                    .h
                    .serialize(black_box(&mut buf), theirs.pdu.len(), |pdu| pdu.copy_from_slice(theirs.pdu))
            });
        });
        group.finish();
    }
}

criterion_group!(benches, decoding, encoding);
criterion_main!(benches);
