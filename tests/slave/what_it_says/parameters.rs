//! The parameter channel.

use profidrive::devices::ag03::param::Value;

use super::row;
use crate::drive_log::{CYCLE, Told};
use crate::sentences::compare;

/// What the drive says to one PKW job: PKE, IND, PWE.
fn job(pke: u16, ind: u16, pwe: u32) -> Vec<String> {
    job_of(Told::exchanging(), pke, ind, pwe)
}

fn job_of(mut told: Told, pke: u16, ind: u16, pwe: u32) -> Vec<String> {
    told.pkw[..2].copy_from_slice(&pke.to_be_bytes());
    told.pkw[2..4].copy_from_slice(&ind.to_be_bytes());
    told.pkw[4..].copy_from_slice(&pwe.to_be_bytes());
    told.say(0x003B, 16_000, CYCLE * 2);
    told.texts()
}

/// The same of a drive that is not enabled.
fn standing(pke: u16, pwe: u32) -> Vec<String> {
    let mut told = Told::exchanging();
    told.pkw[..2].copy_from_slice(&pke.to_be_bytes());
    told.pkw[4..].copy_from_slice(&pwe.to_be_bytes());
    told.say(0, 0, CYCLE * 20);
    told.texts()
}

const fn pke(ak: u16, pnu: u16) -> u16 {
    ak << 12 | pnu
}

#[test]
fn parameters() {
    let travelling = || {
        let mut told = Told::enabled();
        told.say(0x007B, 16_000, CYCLE * 5);
        told.line.events.clear();
        told
    };
    compare(
        "Parameter channel",
        vec![
            row("P-01", "read PNU 1", || job(pke(1, 1), 0, 0)),
            row("P-02", "change PNU 1004 (v-Pos) to 101 with gear 48:1", || job(pke(2, 1004), 0, 101)),
            row("P-03", "change PNU 1004 (v-Pos) as a double word", || job(pke(3, 1004), 0, 50)),
            row("P-04", "change PNU 1016 (limit) as a word", || job(pke(2, 1016), 0, 50)),
            row("P-05", "change PNU 1029 (motor current)", || job(pke(2, 1029), 0, 5)),
            row("P-06", "read PNU 945 (array) with job 1", || job(pke(1, 945), 0, 0)),
            row("P-07", "read element 99 of PNU 945", || job(pke(6, 945), 99 << 8, 0)),
            row("P-08", "read an element of PNU 1004", || job(pke(6, 1004), 0, 0)),
            row("P-09", "read the description of PNU 1004", || job(pke(4, 1004), 0, 0)),
            row("P-10", "change the description of PNU 1004", || job(pke(5, 1004), 0, 0)),
            row("P-11", "job 11", || job(pke(11, 1004), 0, 0)),
            row("P-12", "change PNU 930 (operating mode) to 3", || job(pke(2, 930), 0, 3)),
            row("P-13", "change PNU 1012 (spindle pitch) during a travel job", || {
                job_of(travelling(), pke(2, 1012), 0, 400)
                    .into_iter()
                    .filter(|text| text.starts_with("job "))
                    .collect()
            }),
            row("P-14", "change PNU 1004 to 50", || {
                job(pke(2, 1004), 0, 50).into_iter().filter(|text| text.starts_with("PNU ")).collect()
            }),
            row("P-15", "change PNU 1016 to 800 with a spindle pitch of 4 mm", || {
                let mut told = Told::exchanging();
                told.write(1012, Value::Word(400));
                told.line.events.clear();
                job_of(told, pke(3, 1016), 0, 800)
                    .into_iter()
                    .filter(|text| text.starts_with("PNU "))
                    .collect()
            }),
            row("P-16", "PWE is changed first and PKE one exchange later", || {
                let mut told = Told::exchanging();
                told.pkw = [0x23, 0xEC, 0, 0, 0, 0, 0, 50];
                told.say(0, 0, CYCLE * 3);
                told.line.events.clear();
                told.pkw[7] = 7;
                told.exchange(0, 0);
                told.line.wait(CYCLE);
                told.pkw[1] = 0xED;
                told.exchange(0, 0);
                told.line.wait(CYCLE);
                told.texts()
            }),
            row("P-17", "change PNU 1004 to 0", || job(pke(2, 1004), 0, 0)),
            row("P-18", "change PNU 1012 (spindle pitch) to 10.01 mm", || standing(pke(2, 1012), 1001)),
            row("P-19", "change PNU 1016 to 2147483647", || job(pke(3, 1016), 0, 0x7FFF_FFFF)),
            row("P-20", "job 7 instead of job 6 to read an element", || job(pke(7, 945), 0, 0)),
            row("P-21", "change PNU 970 to 9", || standing(pke(2, 970), 9)),
            row("P-22", "read the number of elements of PNU 1004", || job(pke(9, 1004), 0, 0)),
            row("P-23", "change PNU 918 (address)", || job(pke(2, 918), 0, 9)),
            row("P-24", "change PNU 1009 (position window) to 5000", || job(pke(2, 1009), 0, 5000)),
            row("P-25", "read PNU 1004 with the octets of PKE exchanged", || {
                job(pke(1, 1004).swap_bytes(), 0, 0)
            }),
        ],
    );
}
