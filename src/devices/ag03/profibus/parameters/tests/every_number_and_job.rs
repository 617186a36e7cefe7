//! Every parameter number with every job, against the manuals read by hand.

use super::*;

#[derive(Clone, Copy)]
enum Is {
    ReadWord,
    ReadDouble,
    Word,
    Double,
    Array,
    Command,
}
use Is::{Array, Command, Double, ReadDouble, ReadWord, Word};

/// What a parameter is, its least and greatest value, and what it reads as at first: from the manuals by hand.
type Row = (u16, Is, i64, i64, i64);

const BOTH: [Row; 28] = [
    (918, ReadWord, 0, 126, 5),
    (930, Word, 1, 2, 2),
    (945, Array, 0, 255, 0),
    (952, ReadWord, 0, 65_535, 7),
    (970, Command, 1, 5, 0),
    (1000, Word, 1, 500, 100),
    (1001, Word, 0, 500, 5),
    (1002, Word, 0, 500, 0),
    (1009, Word, 0, 1000, 10),
    (1010, Word, 1, 10_000, 1),
    (1011, Word, 1, 10_000, 1),
    (1012, Word, 0, 1000, 0),
    (1013, Word, 0, 1, 0),
    (1014, Word, 0, 2, 0),
    (1016, Double, -9_999_999, 9_999_999, 1_000_000),
    (1017, Double, -9_999_999, 9_999_999, -1_000_000),
    (1018, Double, -999_999, 999_999, 0),
    (1019, Double, -1_000_000, 1_000_000, 1600),
    (1020, ReadWord, 0, 65_535, 0x2948),
    (1021, Word, 0, 1, 0),
    (1022, Word, 0, 2, 0),
    (1023, Word, 0, 10_000, 800),
    (1031, ReadWord, 0, 65_535, 0x0010),
    (1032, Word, 20, 125, 125),
    (1033, ReadDouble, 0, 4_294_967_295, 1_234_567),
    (1034, ReadDouble, 0, 4_294_967_295, 0x1507_2009),
    (1035, Word, 10, 100, 100),
    (1036, ReadDouble, -2_147_483_648, 2_147_483_647, -5000),
];
const AG03: [Row; 4] = [
    (965, ReadWord, 0, 65_535, 0x0300),
    (1003, Word, 0, 100, 50),
    (1005, Word, 0, 100, 50),
    (1007, Word, 0, 100, 50),
];
const AG03_1: [Row; 10] = [
    (965, ReadWord, 0, 65_535, 0x0101),
    (1003, Word, 1, 100, 50),
    (1005, Word, 1, 100, 50),
    (1007, Word, 1, 100, 50),
    (1027, ReadWord, 0, 65_535, 0xFFE7),
    (1029, ReadWord, 0, 65_535, 1234),
    (1039, Word, 1, 101, 101),
    (1040, ReadWord, 0, 65_535, 240),
    (1041, ReadWord, 0, 65_535, 238),
    (1042, ReadWord, 0, 65_535, 361),
];
const GEAR_24: [Row; 3] = [(961, ReadWord, 2, 3, 2), (1004, Word, 1, 200, 30), (1008, Word, 1, 200, 30)];
const GEAR_48: [Row; 3] = [(961, ReadWord, 2, 3, 3), (1004, Word, 1, 100, 30), (1008, Word, 1, 100, 30)];

fn rows(model: Model, gear: Gear) -> Vec<Row> {
    let by_model = if model == Model::Ag03 { &AG03[..] } else { &AG03_1 };
    let by_gear = if gear == Gear::Ratio24 { &GEAR_24 } else { &GEAR_48 };
    [&BOTH[..], by_model, by_gear].concat()
}

/// Reply identification and PWE.
fn expected(model: Model, row: Option<Row>, job: u16, subindex: u16, pwe: u32) -> (u16, u32) {
    let refused = |number| (7, number);
    let Some((_, is, low, high, value)) = row else {
        return match job {
            0 => (0, 0),
            1..=9 => refused(0),
            10.. => refused(18),
        };
    };
    let pattern = (value & 0xFFFF_FFFF) as u32;
    let word = i64::from(pwe & 0xFFFF);
    let double = i64::from(pwe as i32);
    let within = |value, reply| {
        if (low..=high).contains(&value) { reply } else { refused(2) }
    };
    match (job, is) {
        (0, _) => (0, 0),
        (1, Word | ReadWord | Command) => (1, pattern),
        (1, Double | ReadDouble) => (2, pattern),
        (2, Word) => within(word, (1, pwe & 0xFFFF)),
        (2, Command) => within(word, (if model == Model::Ag03 { 1 } else { 2 }, 0)),
        (3, Double) => within(double, (2, pwe)),
        (2, Double) | (3, Word | Command) => refused(5),
        (2 | 3, ReadWord | ReadDouble) => refused(1),
        (1..=3, Array) => refused(5),
        (4, _) => refused(9),
        (5, _) => refused(7),
        (6, Array) if subindex > 9 => refused(3),
        (6, Array) => (4, u32::from(b"GFEABCD\0\0\0"[usize::from(subindex)])),
        (7 | 8, Array) => refused(1),
        (9, Array) => (6, 10),
        (6..=9, _) => refused(4),
        (_, _) => refused(18),
    }
}

#[test]
fn are_answered_as_the_manuals_say() {
    let mut cases = 0;
    for (model, gear) in Model::ALL.into_iter().flat_map(|model| Gear::ALL.map(|gear| (model, gear))) {
        let rows = rows(model, gear);
        for pnu in 0..=2047 {
            let row = rows.iter().copied().find(|row| row.0 == pnu);
            let values = row.map_or(std::vec![0], |(_, _, low, high, default)| {
                std::vec![default, low, low - 1, high, high + 1]
            });
            let indices = match row {
                Some((_, Array, ..)) => {
                    (0..=11).flat_map(|n: u8| [u16::from(n) << 8, u16::from(n)]).collect()
                }
                Some(_) | None => std::vec![0],
            };
            for (job, &value, &ind) in (0..16)
                .flat_map(|job| values.iter().map(move |value| (job, value)))
                .flat_map(|(job, value)| indices.iter().map(move |ind| (job, value, ind)))
            {
                let pwe = (value & 0xFFFF_FFFF) as u32;
                let request = Pkw::new(Pke::from_raw(job << 12 | pnu), Ind::from_raw(ind), pwe);
                let subindex = ind >> 8 | ind & 0xFF;
                let (id, pwe) = expected(model, row, job, subindex, pwe);
                let reply = match id {
                    0 => Pkw::ZERO,
                    1.. => Pkw::new(Pke::from_raw(id << 12 | pnu), Ind::from_raw(ind), pwe),
                };
                let outcome = Rig::new(model, gear).cycle(request);
                assert_eq!(outcome.reply, reply, "{model}, gear {gear}, request {request}");
                assert_eq!(outcome.refusal.is_some(), id == 7);
                cases += 1;
            }
        }
    }
    assert!(cases > 4 * 2048 * 16);
}
