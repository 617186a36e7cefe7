//! A master that dies, hangs, floods, sends only noise or speaks another rate: each judgement ends, with a clear word.

use core::time::Duration;

use profidrive::bench::{Line, Master};
use profidrive::judge::{Ending, Report, Row, Verdict, simulated};
use profidrive::profibus::fdl::MAX_TELEGRAM_LEN;
use profidrive::time::Instant;

use crate::configured::setup;
use crate::test_master::mistakes::Mistake;
use crate::test_master::{BAUD, Settings, TestMaster};
use crate::virtual_time::{correct, failed, judged};

/// What a master becomes after some telegrams.
#[derive(Clone, Copy, Debug)]
enum Fate {
    /// It says nothing more.
    Hangs,
    /// It passes tokens and asks nobody.
    OnlyTokens,
    /// Octets without end.
    Floods,
    /// The right octets at half the rate.
    OtherRate,
    /// It asks again and again, and waits for nobody.
    Babbles,
}

/// The test master until `left` telegrams were sent.
#[derive(Debug)]
struct Doomed {
    master: TestMaster,
    fate: Fate,
    left: u32,
    next: Instant,
    state: u32,
}

impl Doomed {
    const fn lives(&self) -> bool {
        self.left > 0 || matches!(self.fate, Fate::OtherRate)
    }
}

impl Master for Doomed {
    fn handle_bytes(&mut self, now: Instant, octets: &[u8]) {
        // It is deaf to what has another rate.
        if !matches!(self.fate, Fate::OtherRate) {
            self.master.handle_bytes(now, octets);
        }
    }

    fn handle_sent(&mut self, now: Instant) {
        self.next = now + Duration::from_millis(1);
        self.master.handle_sent(now);
    }

    fn handle_timeout(&mut self, now: Instant) {
        self.master.handle_timeout(now);
    }

    fn poll_transmit(&mut self, now: Instant, buf: &mut [u8; MAX_TELEGRAM_LEN]) -> Option<usize> {
        if self.lives() {
            let len = self.master.poll_transmit(now, buf)?;
            self.left = self.left.saturating_sub(1);
            if matches!(self.fate, Fate::OtherRate) {
                let sent = at_half_the_rate(&buf[..len]);
                buf[..sent.len()].copy_from_slice(&sent);
                return Some(sent.len());
            }
            return Some(len);
        }
        if now < self.next {
            return None;
        }
        let octets: Vec<u8> = match self.fate {
            Fate::Hangs | Fate::OtherRate => return None,
            Fate::OnlyTokens => vec![0xDC, 2, 2],
            Fate::Babbles => vec![0x68, 5, 5, 0x68, 0x85, 0x82, 0x6D, 0x3C, 0x3E, 0xEE, 0x16],
            Fate::Floods => (0..200)
                .map(|_| {
                    self.state = self.state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    (self.state >> 24) as u8
                })
                .collect(),
        };
        buf[..octets.len()].copy_from_slice(&octets);
        Some(octets.len())
    }

    fn poll_timeout(&self) -> Option<Instant> {
        match self.fate {
            _ if self.lives() => self.master.poll_timeout(),
            Fate::Hangs | Fate::OtherRate => None,
            Fate::OnlyTokens | Fate::Babbles | Fate::Floods => Some(self.next),
        }
    }
}

/// What a receiver reads of octets that are sent at half its rate: each bit twice, a character begins at the next 0.
fn at_half_the_rate(octets: &[u8]) -> Vec<u8> {
    let mut bits = Vec::new();
    for octet in octets {
        let data = (0..8).map(|bit| octet >> bit & 1);
        let character = core::iter::once(0).chain(data).chain([(octet.count_ones() % 2) as u8, 1]);
        bits.extend(character.flat_map(|bit| [bit, bit]));
    }
    let (mut heard, mut at) = (Vec::new(), 0);
    while let Some(begin) = bits[at.min(bits.len())..].iter().position(|bit| *bit == 0) {
        let first = at + begin + 1;
        let Some(data) = bits.get(first..first + 8) else { break };
        heard.push(data.iter().rev().fold(0, |octet, bit| octet << 1 | bit));
        at = first + 10;
    }
    heard
}

fn doomed(fate: Fate, telegrams: u32) -> Report {
    let settings = Settings::new(&[5, 6], Duration::from_micros(600));
    let setup = setup(&settings, &[]);
    let slot = settings.slot;
    let master = TestMaster::new(settings, None);
    let mut line =
        Line::with(BAUD, Doomed { master, fate, left: telegrams, next: Instant::ZERO, state: telegrams });
    line.set_slot_time(slot);
    simulated(&mut line, setup, Row::ALL)
}

fn words(report: &Report) -> String {
    report.ending.to_string()
}

#[test]
fn a_master_that_dies_ends_it_and_the_word_says_during_what() {
    let report = judged(Some(Mistake::DiesOnRs), Row::ALL);
    assert!(matches!(report.ending, Ending::Silent { .. }), "{report}");
    let said = words(&report);
    assert!(
        said.contains("the master said nothing more for ten seconds: a slave loses its parameters"),
        "{said}"
    );
    let rest = report.judgements.iter().filter(|judged| judged.reason.starts_with("not tried: "));
    assert!(rest.count() > 10, "{report}");
}

#[test]
fn a_master_that_hangs_ends_it() {
    let report = doomed(Fate::Hangs, 3000);
    assert!(matches!(report.ending, Ending::Silent { .. }), "{report}");
    // It may hang while only tokens pass.
    let report = doomed(Fate::OnlyTokens, 3000);
    assert!(words(&report).contains("data exchange with station 5 was not reached"), "{report}");
}

#[test]
fn a_flood_ends_it() {
    let report = doomed(Fate::Floods, 3000);
    assert_eq!(report.ending, Ending::Flood, "{report}");
    assert!(words(&report).contains("octets without end"), "{}", words(&report));
    let report = doomed(Fate::Babbles, 3000);
    assert!(words(&report).contains("data exchange with station"), "{report}");
}

#[test]
fn only_noise_ends_it_and_accuses_nobody_of_anything() {
    for report in [doomed(Fate::Floods, 0), doomed(Fate::OtherRate, 0)] {
        assert_eq!(report.ending, Ending::Noise, "{report}");
        assert!(words(&report).contains("another rate"), "{}", words(&report));
        assert_eq!(report.count(Verdict::NotJudged), Row::ALL.len(), "{report}");
    }
}

#[test]
fn nobody_there_ends_it() {
    let report = doomed(Fate::Hangs, 0);
    assert_eq!(report.ending, Ending::NoMaster, "{report}");
    assert_eq!(report.count(Verdict::NotJudged), Row::ALL.len(), "{report}");
    assert!(report.judgements.iter().all(|judged| !judged.reason.is_empty()));
}

/// Whatever a master dies of, the row of that scenario fails, with the last telegrams; and nothing is green.
#[test]
fn a_master_that_dies_in_a_scenario_fails_its_row() {
    for (mistake, row) in [
        (Mistake::DiesOnSilence, Row::C03),
        (Mistake::DiesOnFcs, Row::E01),
        (Mistake::DiesOnSource, Row::E05),
        (Mistake::DiesOnLongDiag, Row::D08),
        (Mistake::DiesOnOwner, Row::D07),
        (Mistake::DiesOnLength, Row::E04),
    ] {
        let report = judged(Some(mistake), &[row]);
        let judgement = &report.judgements[0];
        assert_eq!(judgement.verdict, Verdict::Fail, "{mistake:?}: {report}");
        assert!(!judgement.telegrams.is_empty(), "{mistake:?}: {report}");
        assert_eq!(report.outcome().status(), 4, "{mistake:?}: {report}");
    }
}

#[test]
fn only_a_complete_judgement_passes() {
    let status = |report: &Report| report.outcome().status();
    assert_eq!(status(correct()), 0);
    assert_eq!(status(failed()), 1);
    // It never asks anybody, or never at this rate.
    for (fate, telegrams, why) in [
        (Fate::OnlyTokens, 0, "the master passes the token and asks no station"),
        (Fate::OtherRate, 0, "another rate"),
        (Fate::Hangs, 0, "no master was heard"),
    ] {
        let report = doomed(fate, telegrams);
        assert_eq!(status(&report), 3, "{report}");
        assert!(words(&report).contains(why), "{report}");
    }
    assert_eq!(status(&doomed(Fate::Hangs, 60)), 4);
    // Nothing of what was wanted can be judged.
    let report = judged(None, &[Row::K02]);
    assert_eq!(report.outcome().trouble(), Some("no row was judged"), "{report}");
    let mut report = judged(None, &[Row::F01, Row::K02]);
    assert_eq!(status(&report), 0, "{report}");
    report.required = vec![Row::K02];
    assert_eq!(report.outcome().trouble(), Some("rows that must be judged were not: M-K02"), "{report}");
}

/// Why data exchange is not reached is said in the words of the field.
#[test]
fn no_data_exchange_has_its_reason() {
    for (mistake, why) in [
        (Mistake::SwappedIdent, "Set_Prm refused: ident 3412, configured 1234"),
        (Mistake::OtherCfg, "Chk_Cfg refused: 22 13, configured 23 13"),
        (Mistake::NoLock, "Set_Prm locks no slave: octets 08 64"),
    ] {
        let report = judged(Some(mistake), Row::ALL);
        assert_eq!(report.outcome().status(), 3, "{report}");
        assert!(words(&report).contains(why), "{report}");
    }
}
