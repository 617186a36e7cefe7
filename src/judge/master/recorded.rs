//! The judgement of a recording of a bus: only what is seen without provoking anything.

use super::Report;
use super::observer::{Observer, Sight};
use super::play::Ending;
use super::rows::{Group, Row};
use super::setup::Setup;
use crate::judge::figures::Figures;
use crate::judge::moment::{Moment, Side, split};
use crate::profibus::fdl::telegram::{Decoded, decode};
use crate::profibus::fdl::{Address, Function, Telegram};
use crate::time::Instant;

/// Telegrams of a recording, one after the other.
#[derive(Debug)]
pub struct Recording {
    observer: Observer,
    origin: Option<Instant>,
    cut: Option<String>,
    untimed: bool,
}

impl Recording {
    /// Nothing yet. `setup` may be empty: then what is configured is not judged.
    pub fn new(setup: Setup) -> Self {
        Self { observer: Observer::new(setup, Sight::Recorded), origin: None, cut: None, untimed: false }
    }

    /// Takes a packet: telegrams or octets that are none. `from_master`: which way they passed, if that is known.
    pub fn take(&mut self, at: Instant, octets: &[u8], from_master: Option<bool>) {
        self.origin.get_or_insert(at);
        match from_master {
            Some(true) => self.observer.take(Moment::new(at, Side::Master, octets)),
            Some(false) => self.observer.take(Moment::new(at, Side::Station(None::<Address>), octets)),
            None => {
                for octets in split(octets) {
                    let of_master = is_of_master(octets);
                    if !of_master {
                        self.observer.overheard.take(octets);
                    }
                    let side = if of_master { Side::Master } else { Side::Station(None::<Address>) };
                    self.observer.take(Moment::new(at, side, octets));
                }
            }
        }
    }

    /// Nothing is known of the times: what depends on them is not judged.
    pub const fn without_times(&mut self) {
        self.untimed = true;
    }

    /// The recording ends before its time, for this reason.
    pub fn cut_off(&mut self, why: &str) {
        self.cut = Some(why.into());
    }

    /// The verdicts on these rows.
    pub fn report(mut self, wanted: &[Row]) -> Report {
        for row in Row::ALL {
            self.observer.findings.obstacle(*row, NOT_PROVOKED);
        }
        self.observer.finish();
        if self.untimed {
            for row in Row::ALL.iter().filter(|row| is_timed(**row)) {
                self.observer.findings.inapplicable(*row, "the lines have no times");
            }
        }
        // What the end of a session would have shown need not be in a recording.
        let judgements = wanted.iter().map(|row| self.observer.findings.judgement(*row)).collect();
        let overheard = &self.observer.overheard;
        let ending = match (overheard.foreign(), self.observer.telegrams(), self.cut) {
            (Some(foreign), ..) => Ending::Foreign(foreign),
            (None, 0, _) if overheard.has_noise() => Ending::Noise,
            (None, 0, _) => Ending::NoMaster,
            (None, _, Some(why)) => Ending::Cut { why },
            (None, _, None) => Ending::Read,
        };
        let configuration = self.observer.setup.words();
        let figures = if self.untimed { Figures::default() } else { self.observer.figures.clone() };
        Report {
            configuration,
            figures,
            ..Report::new(judgements, ending, self.origin.unwrap_or(Instant::ZERO))
        }
    }

    /// How many telegrams of the master there were.
    pub const fn telegrams(&self) -> u64 {
        self.observer.telegrams()
    }
}

const NOT_PROVOKED: &str = "the capture gives no occasion to judge it";

/// Whether a row is about times.
fn is_timed(row: Row) -> bool {
    row.about().group == Group::Timing || [Row::I01, Row::I03, Row::I07, Row::K05, Row::U06].contains(&row)
}

/// Requests and tokens are of a master; octets that are no telegram could be of anybody, and prove nothing.
fn is_of_master(octets: &[u8]) -> bool {
    match decode(octets) {
        Decoded::Telegram { telegram: Telegram::Data(data), .. } => {
            matches!(data.fc.function(), Function::Request(..))
        }
        Decoded::Telegram { telegram: Telegram::Token { .. }, .. } => true,
        Decoded::Telegram { telegram: Telegram::ShortAcknowledge, .. }
        | Decoded::Incomplete
        | Decoded::Invalid { .. } => false,
    }
}
