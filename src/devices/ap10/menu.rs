//! The parameter menu: node number, rate and code, one after the other, and the diagnosis (manual 4.3.1, 4.5.3).
//!
//! ```text
//! star held ─▶ ID ──star──▶ KBAUD ──star──▶ CODE ──star──▶ position
//!              left, up     up              left, up   └─ 200000 ─▶ list of errors ──star──▶ position
//! ```
//!
//! An illegal node number or code is not taken.

use core::fmt::Write;

use heapless::String;

use super::faults::Logged;
use super::indicator::Restore;
use super::keys::Key;
use super::settings::{Setting, Settings};

/// The longest text of a row.
pub(super) const ROW_LEN: usize = 8;

/// Rates by the number of 5F0Ah:3.
const RATES: [&str; 6] = ["AUTO", "125", "250", "500", "800", "1000"];

/// The codes.
const FACTORY_ALL: i32 = 11_100;
const FACTORY_ALL_BUT_BUS: i32 = 11_102;
const FACTORY_BUS: i32 = 11_105;
const DIAGNOSIS: i32 = 200_000;

/// Where a person is in the menu.
#[derive(Clone, Debug)]
pub(super) enum Menu {
    Id {
        entry: Digits<3>,
        rate: i32,
    },
    Rate(i32),
    Code(Digits<6>),
    /// The error at this place, 0 is the newest.
    Diagnosis(usize),
}

/// What a person chose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Choice {
    NodeId(i32),
    Rate(i32),
    Restore(Restore),
}

impl Menu {
    pub(super) fn open(settings: &Settings) -> Self {
        Self::Id {
            entry: Digits::of(settings.value(Setting::NodeId)),
            rate: settings.value(Setting::BaudRate),
        }
    }

    /// What a key does: the menu from now on and what was chosen. `errors` are in the list.
    pub(super) fn key(self, key: Key, errors: usize) -> (Option<Self>, Option<Choice>) {
        match (self, key) {
            (Self::Id { mut entry, rate }, Key::Left | Key::Up) => {
                entry.key(key);
                (Some(Self::Id { entry, rate }), None)
            }
            (Self::Id { entry, rate }, Key::Star) => {
                (Some(Self::Rate(rate)), Some(Choice::NodeId(entry.number())))
            }
            (Self::Rate(rate), Key::Up) => {
                let next = rate.saturating_add(1);
                (Some(Self::Rate(if Setting::BaudRate.accepts(next) { next } else { 0 })), None)
            }
            (Self::Rate(rate), Key::Left) => (Some(Self::Rate(rate)), None),
            (Self::Rate(rate), Key::Star) => (Some(Self::Code(Digits::of(0))), Some(Choice::Rate(rate))),
            (Self::Code(mut entry), Key::Left | Key::Up) => {
                entry.key(key);
                (Some(Self::Code(entry)), None)
            }
            (Self::Code(entry), Key::Star) => match entry.number() {
                FACTORY_ALL => (None, Some(Choice::Restore(Restore::All))),
                FACTORY_ALL_BUT_BUS => (None, Some(Choice::Restore(Restore::AllButBus))),
                FACTORY_BUS => (None, Some(Choice::Restore(Restore::Bus))),
                DIAGNOSIS => (Some(Self::Diagnosis(0)), None),
                i32::MIN..=i32::MAX => (None, None),
            },
            (Self::Diagnosis(place), Key::Up) => {
                (Some(Self::Diagnosis(if place + 1 < errors { place + 1 } else { 0 })), None)
            }
            (Self::Diagnosis(place), Key::Left) => (Some(Self::Diagnosis(place)), None),
            (Self::Diagnosis(_), Key::Star) => (None, None),
        }
    }

    /// The two rows.
    pub(super) fn rows(&self, log: &[Logged]) -> [String<ROW_LEN>; 2] {
        let mut rows = [const { String::new() }; 2];
        let [one, two] = &mut rows;
        // Nothing of this is longer than a row.
        let _ = match self {
            Self::Id { entry, .. } => write!(one, "ID").and(write!(two, "{:03}", entry.number())),
            Self::Rate(rate) => write!(one, "KBAUD").and(write!(two, "{}", rate_text(*rate))),
            Self::Code(entry) => write!(one, "CODE").and(write!(two, "{:06}", entry.number())),
            Self::Diagnosis(place) => match log.get(*place) {
                Some(error) => {
                    write!(one, "{} {}", place + 1, error.count).and(write!(two, "{}", error.fault.shown()))
                }
                None => write!(one, "0 0").and(write!(two, "---")),
            },
        };
        rows
    }
}

/// The text of a rate.
pub(super) fn rate_text(rate: i32) -> &'static str {
    usize::try_from(rate).ok().and_then(|rate| RATES.get(rate)).copied().unwrap_or("---")
}

/// A number while it is entered: up changes the digit, left goes to the next one on the left.
#[derive(Clone, Debug)]
pub(super) struct Digits<const N: usize> {
    /// The lowest first.
    digits: [u8; N],
    cursor: usize,
}

impl<const N: usize> Digits<N> {
    #[expect(clippy::cast_possible_truncation, reason = "a decimal digit")]
    fn of(number: i32) -> Self {
        let mut rest = number;
        let digits = core::array::from_fn(|_| {
            let digit = rest.rem_euclid(10) as u8;
            rest /= 10;
            digit
        });
        Self { digits, cursor: 0 }
    }

    fn number(&self) -> i32 {
        self.digits.iter().rev().fold(0, |number, digit| number * 10 + i32::from(*digit))
    }

    fn key(&mut self, key: Key) {
        match key {
            Key::Left => self.cursor = (self.cursor + 1) % N,
            Key::Up => {
                if let Some(digit) = self.digits.get_mut(self.cursor) {
                    *digit = (*digit + 1) % 10;
                }
            }
            Key::Star => {}
        }
    }
}
