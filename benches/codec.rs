//! Decoding and encoding of the same octets by our codec and by profirust's, in one process.
//!
//! Ours checks more (second SD2, LE up to 249, extension octets, token addresses, the end of a telegram before its
//! checksum) and tells what is wrong. First comes a table of ratios from alternating samples, so that whatever else the
//! machine does hits both; then criterion measures each row alone. `docs/performance.md` says what to expect:
//!
//! ```text
//! cargo bench --bench codec
//! cargo bench --bench codec --profile release-lto
//! ```
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::cast_possible_truncation,
    clippy::std_instead_of_core,
    clippy::wildcard_enum_match_arm,
    reason = "a bench may panic, and has std"
)]

use std::hint::black_box;
use std::time::Instant;

use criterion::{Criterion, criterion_group, criterion_main};
use profidrive::profibus::fdl::telegram::{Decoded, MAX_TELEGRAM_LEN, Telegram, decode};

/// Octets to decode, and to encode if they are a telegram.
struct Row {
    name: &'static str,
    octets: Vec<u8>,
    /// Whether it is a whole and correct telegram.
    correct: bool,
}

fn rows() -> Vec<Row> {
    let outputs = [0x05, 0x02, 0x7D, 0x13, 0xFA, 0, 0, 0, 0, 0, 0, 0x00, 0x7B, 0, 0, 0x13, 0x88];
    let set_prm = [0x85, 0x82, 0x5D, 0x3D, 0x3E, 0x80, 1, 1, 11, 0x0A, 0xC5, 0];
    let longest: Vec<u8> = [0x05, 0x02, 0x7D].into_iter().chain(0..=245).collect();
    let mut wrong_fcs = sd2(&outputs);
    let fcs = wrong_fcs.len() - 2;
    wrong_fcs[fcs] ^= 1;
    let row = |name, octets: &[u8]| Row { name, octets: octets.to_vec(), correct: true };
    vec![
        row("data_exchange_14", &sd2(&outputs)),
        row("set_prm_saps", &sd2(&set_prm)),
        row("slave_diag_saps", &sd2(&[0x85, 0x82, 0x6D, 0x3C, 0x3E])),
        row("longest_sd2", &sd2(&longest)),
        row("fdl_status_sd1", &[0x10, 0x05, 0x02, 0x49, 0x50, 0x16]),
        row("sd3", &[0xA2, 0x05, 0x02, 0x7D, 1, 2, 3, 4, 5, 6, 7, 8, 0xA8, 0x16]),
        row("token_sd4", &[0xDC, 0x02, 0x03]),
        row("short_acknowledge", &[0xE5]),
        Row { correct: false, ..row("wrong_fcs", &wrong_fcs) },
        Row { correct: false, ..row("incomplete", &sd2(&outputs)[..7]) },
    ]
}

fn sd2(counted: &[u8]) -> Vec<u8> {
    let le = u8::try_from(counted.len()).unwrap();
    let fcs = counted.iter().fold(0, |sum: u8, octet| sum.wrapping_add(*octet));
    [&[0x68, le, le, 0x68], counted, &[fcs, 0x16]].concat()
}

/// Nanoseconds of ours and of theirs for one call, and the ratio: medians of alternating samples.
fn paired(mut ours: impl FnMut(), mut theirs: impl FnMut()) -> (f64, f64, f64) {
    const SAMPLES: usize = 501;
    const CALLS: u32 = 2_000;
    fn sample(act: &mut impl FnMut()) -> f64 {
        let start = Instant::now();
        (0..CALLS).for_each(|_| act());
        start.elapsed().as_secs_f64() * 1e9 / f64::from(CALLS)
    }
    let median = |mut values: Vec<f64>| {
        values.sort_unstable_by(f64::total_cmp);
        values[values.len() / 2]
    };
    let samples: Vec<_> = (0..SAMPLES)
        .map(|number| {
            if number % 2 == 0 {
                let ours = sample(&mut ours);
                (ours, sample(&mut theirs))
            } else {
                let theirs = sample(&mut theirs);
                (sample(&mut ours), theirs)
            }
        })
        .collect();
    (
        median(samples.iter().map(|(ours, _)| *ours).collect()),
        median(samples.iter().map(|(_, theirs)| *theirs).collect()),
        median(samples.iter().map(|(ours, theirs)| ours / theirs).collect()),
    )
}

/// What both write, by the telegram itself and not by its kind: neither knows beforehand which it is.
#[inline(always)]
fn encode_theirs(telegram: &profirust::fdl::Telegram<'_>, buf: &mut [u8]) -> usize {
    use profirust::fdl::Telegram::{Data, ShortConfirmation, Token};
    match telegram {
        Data(data) => data.h.serialize(buf, data.pdu.len(), |pdu| pdu.copy_from_slice(data.pdu)),
        Token(token) => token.serialize(buf),
        ShortConfirmation(sc) => sc.serialize(buf),
    }
}

#[inline(always)]
fn encode_ours(telegram: &Telegram<'_>, buf: &mut [u8]) -> usize {
    telegram.encode(buf).map_or(0, <[u8]>::len)
}

/// The telegram of both, if the octets are one both write alike: profirust chooses the format itself.
fn decoded(row: &Row) -> Option<(Telegram<'_>, profirust::fdl::Telegram<'_>)> {
    let ours = match decode(&row.octets) {
        Decoded::Telegram { telegram, len } if len == row.octets.len() => Some(telegram),
        Decoded::Telegram { .. } | Decoded::Incomplete | Decoded::Invalid { .. } => None,
    };
    let theirs = profirust::fdl::Telegram::deserialize(&row.octets).and_then(Result::ok);
    // Both must judge the octets as the row says, or the comparison says nothing.
    assert_eq!((ours.is_some(), theirs.is_some()), (row.correct, row.correct), "{}", row.name);
    let (ours, (theirs, _)) = (ours?, theirs?);
    let mut buf = [0; MAX_TELEGRAM_LEN];
    let written = encode_ours(&ours, &mut buf);
    assert_eq!(&buf[..written], row.octets, "{}", row.name);
    let written = encode_theirs(&theirs, &mut buf);
    assert_eq!(&buf[..written], row.octets, "{}", row.name);
    Some((ours, theirs))
}

/// What a program does with what was decoded: the compiler may leave out what is not used, and has to copy what is moved.
type Theirs<'a> = Option<Result<(profirust::fdl::Telegram<'a>, usize), ()>>;

/// The uses, each of a decoder that the compiler may inline into it and of one that it may not.
macro_rules! uses {
    ($print:ident, $row:ident) => {{
        let octets = $row.octets.as_slice();
        uses!(@ $print, $row, octets, "inline", decode, profirust::fdl::Telegram::deserialize);
        uses!(@ $print, $row, octets, "called", decode_called, deserialize_called);
    }};
    (@ $print:ident, $row:ident, $octets:ident, $how:literal, $ours:path, $theirs:path) => {{
        let by_reference = paired(
            || { black_box(&$ours(black_box($octets))); },
            || { black_box(&$theirs(black_box($octets))); },
        );
        let moved = paired(
            || { black_box($ours(black_box($octets))); },
            || { black_box($theirs(black_box($octets))); },
        );
        let length = paired(
            || { black_box(length_of_ours($ours(black_box($octets)))); },
            || { black_box(length_of_theirs($theirs(black_box($octets)))); },
        );
        for (use_, times) in [("by reference", by_reference), ("moved", moved), ("only the length", length)] {
            $print(format!("decode {} {use_}, {}", $row.name, $how), times);
        }
    }};
}

#[inline(never)]
fn decode_called(octets: &[u8]) -> Decoded<'_> {
    decode(octets)
}

#[inline(never)]
fn deserialize_called(octets: &[u8]) -> Theirs<'_> {
    profirust::fdl::Telegram::deserialize(octets)
}

#[inline(always)]
fn length_of_ours(decoded: Decoded<'_>) -> usize {
    match decoded {
        Decoded::Telegram { len, .. } => len,
        Decoded::Incomplete | Decoded::Invalid { .. } => 0,
    }
}

#[inline(always)]
fn length_of_theirs(decoded: Theirs<'_>) -> usize {
    match decoded {
        Some(Ok((_, len))) => len,
        Some(Err(())) | None => 0,
    }
}

fn ratios(_: &mut Criterion) {
    println!("{:<50}{:>12}{:>12}{:>8}", "alternating samples", "profidrive", "profirust", "ratio");
    let print = |name: String, (ours, theirs, ratio): (f64, f64, f64)| {
        println!("{name:<50}{ours:>9.2} ns{theirs:>9.2} ns{ratio:>8.2}");
    };
    for row in &rows() {
        uses!(print, row);
    }
    for row in &rows() {
        let Some((ours, theirs)) = decoded(row) else { continue };
        let (mut one, mut other) = ([0; MAX_TELEGRAM_LEN], [0; MAX_TELEGRAM_LEN]);
        let times = paired(
            || {
                black_box(encode_ours(black_box(&ours), black_box(&mut one)));
            },
            || {
                black_box(encode_theirs(black_box(&theirs), black_box(&mut other)));
            },
        );
        print(format!("encode {}", row.name), times);
    }
}

fn decoding(criterion: &mut Criterion) {
    for row in &rows() {
        let octets = row.octets.as_slice();
        let mut group = criterion.benchmark_group(format!("decode/{}", row.name));
        group.bench_function("profidrive", |bench| {
            bench.iter(|| {
                black_box(&decode(black_box(octets)));
            });
        });
        group.bench_function("profirust", |bench| {
            bench.iter(|| {
                black_box(&profirust::fdl::Telegram::deserialize(black_box(octets)));
            });
        });
        group.finish();
    }
}

fn encoding(criterion: &mut Criterion) {
    for row in &rows() {
        let Some((ours, theirs)) = decoded(row) else { continue };
        let mut buf = [0; MAX_TELEGRAM_LEN];
        let mut group = criterion.benchmark_group(format!("encode/{}", row.name));
        group.bench_function("profidrive", |bench| {
            bench.iter(|| encode_ours(black_box(&ours), black_box(&mut buf)));
        });
        group.bench_function("profirust", |bench| {
            bench.iter(|| encode_theirs(black_box(&theirs), black_box(&mut buf)));
        });
        group.finish();
    }
}

criterion_group!(benches, ratios, decoding, encoding);
criterion_main!(benches);
