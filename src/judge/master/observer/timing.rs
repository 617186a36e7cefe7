//! Rows T and I: pauses, waiting, intervals.

use core::time::Duration;

use super::Observer;
use super::Sight;
use super::cycle::{Bad, Cycle, Item};
use super::view::View;
use crate::judge::master::findings::Weight;
use crate::judge::master::rows::Row;
use crate::judge::master::setup::Slave;
use crate::profibus::fdl::telegram::{Decoded, decode};
use crate::profibus::fdl::{Address, Function, Telegram};
use crate::time::{BaudRate, Instant, SYN_BITS};

/// Waiting longer than so many slot times after no reply is too long.
const MOST_SLOTS: u32 = 6;
/// And longer than this: a master may pause between two cycles.
const PAUSE: Duration = Duration::from_millis(20);
/// A slave may need so long for a reply on a link without true timing. A master that sends earlier did not wait for it.
const LEAST_WAIT: Duration = Duration::from_millis(2);
/// Telegrams nearer to each other were read at once.
const TOGETHER: Duration = Duration::from_micros(50);
/// Telegrams of one cycle: fewer exchanges of one station than a quarter of another's are not equal.
const LEAST_SHARE: u32 = 4;
/// Exchanges at least before stations are compared.
const LEAST_EXCHANGES: u32 = 40;

/// When things were.
#[derive(Debug, Default)]
pub(super) struct Timing {
    /// The end of the last octet of anybody.
    idle_since: Option<Instant>,
    /// The end of the last octet of a station.
    stations_until: Option<Instant>,
    /// The beginning of the last telegram of the master.
    begun: Option<Instant>,
    /// The end of the last telegram of the master.
    sent: Option<Instant>,
    /// The last was Global_Control.
    controlled: Option<Instant>,
    /// A station has sent though nobody asked.
    stray: bool,
    /// The judge could not look since the last telegram.
    paused: bool,
    was_paused: bool,
    /// The station whose reply was sent twice last.
    doubled: Option<Address>,
    /// Another master had the token last.
    away: Option<Instant>,
    /// A reply was sent twice at some time.
    ever_doubled: bool,
    /// Telegrams before the time of a reply that was held back.
    early: u32,
    /// The longest time before a request was repeated.
    usual_wait: Option<Duration>,
}

impl Timing {
    pub(super) const fn paused(&mut self) {
        self.paused = true;
    }

    /// Whether the judge could not look at some time before the last telegram.
    pub(super) const fn was_paused(&self) -> bool {
        self.was_paused
    }

    /// How long the master waits for a reply, as far as its repetitions have shown it.
    pub(super) const fn usual_wait(&self) -> Option<Duration> {
        self.usual_wait
    }

    /// Another master has the token.
    pub(super) const fn away(&mut self, now: Instant) {
        self.away = Some(now);
    }

    /// When another master had the token last.
    pub(super) const fn away_since(&self) -> Option<Instant> {
        self.away
    }

    /// Whether a station still sends.
    pub(super) fn is_heard_at(&self, now: Instant) -> bool {
        self.stations_until.is_some_and(|until| now < until)
    }

    /// A station has sent; `asked`: the master waited for a reply.
    pub(super) fn heard(&mut self, end: Instant, asked: bool) {
        self.idle_since = Some(end);
        self.stations_until = self.stations_until.max(Some(end));
        self.stray |= !asked;
    }

    pub(super) fn sent(&mut self, begin: Instant, end: Instant) {
        self.begun = Some(begin);
        self.idle_since = Some(end);
        self.sent = Some(end);
        self.was_paused = core::mem::take(&mut self.paused);
        self.controlled = None;
        self.stray = false;
    }

    pub(super) const fn controlled(&mut self, now: Instant) {
        self.controlled = Some(now);
    }
}

impl Observer {
    /// A request or token begins: how long the master has waited.
    pub(super) fn judge_pace(&mut self, serial: u64, at: Instant, octets: &[u8]) {
        self.judge_exact_pace(serial, at);
        let Some(open) = &self.open else { return };
        let (to, end, void) = (open.to, open.end, open.void || self.timing.paused);
        let doubled = open.is_doubled();
        let own = open.items.iter().any(|item| !matches!(item, Item::Bad(_)));
        let foreign = open.items.iter().any(|item| matches!(item, Item::Bad(Bad::WrongSource)));
        let other_bad = open.items.iter().any(|item| !matches!(item, Item::Bad(Bad::WrongSource))) && !own;
        let (repeats, is_diag) = (open.octets == octets, open.service.is_none());
        let from = open.serial;
        if own || other_bad || void {
            if own {
                let answered = open.answered_at;
                let after_double = self.timing.doubled == Some(to);
                if doubled {
                    self.timing.doubled = Some(to);
                } else if after_double {
                    self.timing.doubled = None;
                }
                self.timing.ever_doubled |= doubled;
                self.held(Row::T02);
                self.judge_held_back(to, end, answered, foreign, after_double);
                let until = self.timing.stations_until.unwrap_or(at);
                if !self.held_back && !doubled && !foreign {
                    let pause = at.saturating_since(until);
                    let view = self.view(to);
                    view.pause = pause;
                    view.longest_pause = view.longest_pause.max(pause);
                }
            }
            return;
        }
        let waited = at.saturating_since(end);
        if !foreign {
            self.judge_wait(waited, repeats);
        }
        let Some(slot) = self.setup.slot else {
            let reason = "needs --slot: how long the master waits for a reply";
            for row in [Row::T02, Row::T03, Row::T04, Row::I03, Row::E06, Row::E10] {
                self.findings.obstacle(row, reason);
            }
            return;
        };
        // It did not wait for the reply: what it sends next says nothing of a lost one.
        if !foreign
            && waited * 100 < slot * 45
            && let Some(open) = &mut self.open
        {
            open.void = true;
        }
        if foreign {
            if repeats {
                return;
            }
            if self.held_back && waited * 100 < slot * 45 {
                let reason = format!(
                    "the next telegram {} us after a request to {to}, whose reply was held back: the late reply of another \
                     station was taken for it",
                    waited.as_micros()
                );
                self.broken(Row::E10, Weight::Once, from.saturating_sub(4), None, reason);
            }
            return;
        }
        let after_double = self.timing.doubled == Some(to);
        if after_double {
            self.timing.doubled = None;
        }
        let early = waited * 100 < slot * 5;
        let within = waited * 100 < slot * 45;
        let exact = matches!(self.sight, Sight::Exact(_));
        let (is_early, is_within) = if exact { (early, waited < slot) } else { (early, within) };
        // Who took the second copy for the reply goes on; who repeats the request waited too short.
        if after_double && is_within && !is_diag && !repeats {
            let reason = format!(
                "the next telegram {} us after a request to {to}, whose reply was held back: the second copy of the reply \
                 before was taken for it",
                waited.as_micros()
            );
            self.broken(Row::E06, Weight::Once, from.saturating_sub(4), None, reason);
        } else if is_early {
            let reason =
                format!("a telegram {} us after a request to {to} that has no reply yet", waited.as_micros());
            self.judge_early(from, waited, exact, reason);
        } else if is_within && (self.held_back || exact) && !self.timing.ever_doubled {
            let reason = format!(
                "a telegram {} us after a request to {to}; a reply may come within the slot time of {} us",
                waited.as_micros(),
                slot.as_micros()
            );
            self.broken(Row::T03, Weight::Times(2), from, None, reason);
        } else if !is_within {
            self.judge_patience(from, to, waited, slot, octets);
        }
    }

    /// Whether it has waited so long that it missed a reply. How long it waits its repetitions show; a recording may have
    /// missed the reply itself.
    fn judge_wait(&mut self, waited: Duration, repeats: bool) {
        let usual = self.timing.usual_wait;
        let proved = match (self.sight, usual) {
            (Sight::Exact(_), _) => true,
            (Sight::Untimed | Sight::Recorded, Some(usual)) => waited * 4 >= usual,
            (Sight::Untimed, None) => waited >= LEAST_WAIT,
            (Sight::Recorded, None) => false,
        };
        if repeats {
            self.timing.usual_wait = usual.max(Some(waited));
        } else if !proved && let Some(open) = &mut self.open {
            open.void = true;
        }
    }

    /// A telegram long before the slot time is over. While a reply is held back the judge looks often and two are proof.
    /// At other times two may have been read late; after a reply that came twice the master may have taken the second
    /// copy for it, which is another row.
    fn judge_early(&mut self, from: u64, waited: Duration, exact: bool, reason: String) {
        if self.timing.ever_doubled {
            return;
        }
        if self.held_back || exact {
            self.timing.early += 1;
        }
        let proven = self.timing.early >= 2;
        if proven || waited >= TOGETHER {
            let weight = if proven { Weight::Once } else { Weight::Share(20, 300) };
            self.broken(Row::T02, weight, from, None, reason);
        }
    }

    /// A reply was held back, and the master has waited for it.
    fn judge_held_back(
        &mut self,
        to: Address,
        end: Instant,
        answered: Option<Instant>,
        foreign: bool,
        after_double: bool,
    ) {
        let (Some(slot), Some(answered)) = (self.setup.slot, answered) else {
            return;
        };
        // Who took something else for the reply would have gone on by now, if it pauses no longer than usual.
        let pause = self.view(to).pause;
        let until = self.timing.stations_until.unwrap_or(answered);
        let row = if foreign { Row::E10 } else { Row::E06 };
        let is_shown = until.saturating_since(if foreign { answered } else { end }) > pause * 2;
        if (foreign || after_double) && !is_shown {
            let reason = format!(
                "the master pauses for {} us behind the reply of station {to}, in which the reply that is held back comes",
                pause.as_micros()
            );
            self.findings.default_missed(row, &reason);
        }
        if foreign {
            if is_shown {
                self.held(Row::E10);
            }
        } else if answered.saturating_since(end) * 100 >= slot * 40 {
            self.held(Row::T02);
            self.held(Row::T03);
            if after_double && is_shown {
                self.held(Row::E06);
            }
        }
    }

    /// A request was not answered: how soon the master goes on with the telegram `next`.
    fn judge_patience(&mut self, from: u64, to: Address, waited: Duration, slot: Duration, next: &[u8]) {
        let Some(absent) = self.setup.slave(to).map(|slave| slave.absent) else { return };
        let row = if absent { Row::I03 } else { Row::T04 };
        self.held(Row::T02);
        // Some masters pause between two cycles, and some behind each station.
        let pause = self.longest_pause(to, absent).max(PAUSE);
        if waited <= slot * MOST_SLOTS || waited <= slot + pause {
            self.held(row);
            return;
        }
        // A station that never answers hides how long the pause is behind it.
        if absent && !self.goes_on_behind(to, next) {
            let reason = format!(
                "{} us of silence after a request to {to}, which may be the pause between two cycles; give a station with \
                 a higher address",
                waited.as_micros()
            );
            self.findings.default_missed(row, &reason);
            return;
        }
        let reason = format!(
            "{} us of silence after a request to {to} without reply; the slot time is {} us",
            waited.as_micros(),
            slot.as_micros()
        );
        self.broken(row, Weight::Share(3, 500), from, None, reason);
    }

    /// The longest pause behind a good reply: of this station, or of any if it never answers.
    fn longest_pause(&self, station: Address, absent: bool) -> Duration {
        let of = |(number, view): &(u8, View)| {
            (absent || *number == station.number()).then_some(view.longest_pause)
        };
        self.views.iter().filter_map(of).max().unwrap_or_default()
    }

    /// Whether a telegram belongs to the cycle in which a station was asked: it asks one of a higher address, which is not
    /// the first one of a cycle.
    fn goes_on_behind(&self, station: Address, next: &[u8]) -> bool {
        let Decoded::Telegram { telegram: Telegram::Data(next), .. } = decode(next) else {
            return false;
        };
        // A recording may begin in the middle of a cycle.
        let is_first = self.sight == Sight::Recorded || self.first_asked == Some(next.da);
        next.da > station && self.setup.slave(next.da).is_some() && !is_first
    }

    /// Virtual time: T_SYN, T_ID1 and T_ID2 to the bit.
    fn judge_exact_pace(&mut self, serial: u64, at: Instant) {
        let Sight::Exact(rate) = self.sight else {
            return;
        };
        let Some(idle_since) = self.timing.idle_since else {
            self.judge_first_telegram(serial, at);
            return;
        };
        // Behind octets that the master had no reason to expect it cannot know when the line is idle.
        let unclear = |open: &Cycle| open.items.len() != 1 || open.has_bad_item();
        // Nobody answers Global_Control: what is heard since is noise, and the same is true of it.
        let noise = self.timing.controlled.is_some() && self.timing.stations_until > self.timing.begun;
        let stray = noise || self.timing.stray;
        if stray || self.open.as_ref().is_some_and(unclear) || at < idle_since {
            return;
        }
        let idle = at.saturating_since(idle_since);
        let bits = |time: Duration| {
            u64::from(rate.bits_per_second()) * u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
                / 1_000_000_000
        };
        let judge = |observer: &mut Self, row: Row, least: Duration, name: &str| {
            if idle < least {
                let reason =
                    format!("{} T_bit of idle line, expected {name}, {} T_bit", bits(idle), bits(least));
                observer.broken(row, Weight::Once, serial.saturating_sub(2), None, reason);
            } else {
                observer.held(row);
            }
        };
        let syn = rate.bit_times(SYN_BITS);
        judge(self, Row::T01, syn, "T_SYN");
        if self.timing.controlled.is_some() {
            let least = rate.bit_times(self.longest_tsdr(rate).into()).max(syn);
            judge(self, Row::T06, least, "T_ID2 with max T_SDR");
        } else if self.open.as_ref().is_some_and(|open| !open.items.is_empty()) {
            let bits = self.setup.master_gsd.as_ref().and_then(|gsd| gsd.idle_bits(rate));
            let least = bits.map_or(syn, |bits| rate.bit_times(bits));
            judge(self, Row::T05, least, "T_ID1");
        }
    }

    /// Virtual time: the master listens before it begins.
    fn judge_first_telegram(&mut self, serial: u64, at: Instant) {
        let (Some(slot), Some(moment)) = (self.setup.slot, self.recent.last()) else {
            return;
        };
        let sa = match decode(&moment.octets) {
            Decoded::Telegram { telegram: Telegram::Data(data), .. } => match data.fc.function() {
                Function::Request(..) => data.sa,
                Function::Response(..) | Function::Reserved => return,
            },
            Decoded::Telegram { telegram: Telegram::Token { sa, .. }, .. } => sa,
            Decoded::Telegram { telegram: Telegram::ShortAcknowledge, .. }
            | Decoded::Incomplete
            | Decoded::Invalid { .. } => return,
        };
        let least = slot * (6 + 2 * u32::from(sa.number()));
        let listened = at.saturating_since(Instant::ZERO);
        if listened < least {
            let reason = format!(
                "the first telegram after {} us; expected T_TO, {} us",
                listened.as_micros(),
                least.as_micros()
            );
            self.broken(Row::K07, Weight::Once, serial, None, reason);
        } else {
            self.held(Row::K07);
        }
    }

    /// Virtual time: Min_Slave_Interval.
    pub(super) fn judge_exact_interval(&mut self, cycle: &Cycle, interval: Duration, before: usize) {
        let (Sight::Exact(rate), Some(least)) = (self.sight, self.setup.min_interval(cycle.to)) else {
            return;
        };
        // From end to end, or from beginning to beginning: telegrams have different lengths.
        let octets = |len: usize| rate.octet_times(u32::try_from(len).unwrap_or(u32::MAX));
        let begins = (interval + octets(before)).saturating_sub(octets(cycle.octets.len()));
        let interval = interval.max(begins);
        if interval < least {
            let reason = format!(
                "two requests to station {} within {} us; expected Min_Slave_Interval, {} us",
                cycle.to,
                interval.as_micros(),
                least.as_micros()
            );
            self.broken(Row::I01, Weight::Once, cycle.serial.saturating_sub(4), Some(cycle.to), reason);
        } else {
            self.held(Row::I01);
        }
    }

    /// How long it usually is from one request to a station to the next: the median.
    fn usual_interval(&self, station: Address) -> Option<Duration> {
        median(self.views.get(&station.number())?.intervals.clone())
    }

    /// The same of the newest so many requests that were kept.
    pub(in crate::judge) fn newest_interval(&self, station: Address, count: u32) -> Option<Duration> {
        let intervals = &self.views.get(&station.number())?.intervals;
        let count = usize::try_from(count).unwrap_or(usize::MAX);
        median(intervals.iter().rev().take(count).copied().collect())
    }

    pub(super) fn finish_timing(&mut self) {
        use crate::judge::Verdict;
        let fails = |row| self.findings.judgement(row).verdict == Verdict::Fail;
        if fails(Row::T02) || fails(Row::T03) {
            for row in [Row::T01, Row::T05] {
                self.findings.void(row, "void: the master does not wait for replies (M-T02, M-T03)");
            }
        }
        self.finish_slot();
        self.finish_min_interval();
        self.finish_equality();
        for (number, view) in &self.views {
            let median = self.usual_interval(Address::from_octet(*number));
            let (Some(median), Some(watchdog)) = (median, view.watchdog) else {
                continue;
            };
            let row = Row::T09;
            if watchdog < median * 3 {
                let reason = format!(
                    "the watchdog time of station {number} is {} ms, less than three cycles of {} ms",
                    watchdog.as_millis(),
                    median.as_millis()
                );
                let last: Vec<_> = self.recent.backwards().take(4).rev().cloned().collect();
                self.findings.broken(row, Weight::Once, reason, last);
            } else {
                self.findings.held(row);
            }
        }
    }

    /// The longest max T_SDR of the stations, in T_bit.
    fn longest_tsdr(&self, rate: BaudRate) -> u16 {
        let max_tsdr = |slave: &Slave| match &slave.gsd {
            Some(gsd) => gsd.rates.max_tsdr(rate),
            None => Some(rate.max_tsdr_bits()),
        };
        self.setup.stations.iter().filter_map(max_tsdr).max().unwrap_or(rate.max_tsdr_bits())
    }

    /// The slot time beside max T_SDR of the slaves.
    fn finish_slot(&mut self) {
        let (Sight::Exact(rate), Some(slot)) = (self.sight, self.setup.slot) else {
            return;
        };
        let least = rate.bit_times(u32::from(self.longest_tsdr(rate)) + 15);
        if slot < least {
            let reason =
                format!("the slot time is {} us, expected {} us", slot.as_micros(), least.as_micros());
            self.show(Row::T07, Weight::Once, reason);
        } else if self.findings.is_judged(Row::T03) {
            self.held(Row::T07);
        }
    }

    /// Without true timing the fastest quarter tells.
    fn finish_min_interval(&mut self) {
        if matches!(self.sight, Sight::Exact(_)) {
            return;
        }
        if self.setup.stations.iter().all(|slave| self.setup.min_interval(slave.address).is_none()) {
            self.findings.obstacle(Row::I01, "needs --min-interval, or min-interval=MS of a station");
            return;
        }
        let stations: Vec<Address> = self.setup.present().map(|slave| slave.address).collect();
        for station in stations {
            let (Some(least), Some(view)) =
                (self.setup.min_interval(station), self.views.get(&station.number()))
            else {
                continue;
            };
            let mut intervals = view.intervals.clone();
            intervals.sort_unstable();
            if intervals.len() < usize::try_from(LEAST_EXCHANGES).unwrap_or(usize::MAX) {
                continue;
            }
            let quarter = intervals.get(intervals.len() / 4).copied().unwrap_or_default();
            if quarter * 10 < least * 6 {
                let reason = format!(
                    "a quarter of the requests to station {station} come within {} us; Min_Slave_Interval is {} us",
                    quarter.as_micros(),
                    least.as_micros()
                );
                self.broken(
                    Row::I01,
                    Weight::Once,
                    self.recent.newest().saturating_sub(8),
                    Some(station),
                    reason,
                );
            } else {
                self.held(Row::I01);
            }
        }
    }

    fn finish_equality(&mut self) {
        let counts: Vec<u32> = self
            .setup
            .present()
            .filter_map(|slave| self.views.get(&slave.address.number()))
            .map(|view| view.undisturbed)
            .collect();
        let (Some(least), Some(most)) = (counts.iter().min(), counts.iter().max()) else {
            return;
        };
        if counts.len() < 2 {
            let reason = "needs two stations in data exchange";
            self.findings.obstacle(Row::I04, reason);
        } else if *most < LEAST_EXCHANGES {
            self.findings.obstacle(Row::I04, "too few undisturbed exchanges were seen");
        } else if least * LEAST_SHARE <= *most {
            let reason = format!("undisturbed, one station had {most} Data_Exchange and another {least}");
            self.broken(Row::I04, Weight::Once, self.recent.newest().saturating_sub(12), None, reason);
        } else {
            self.held(Row::I04);
        }
    }
}

fn median(mut times: Vec<Duration>) -> Option<Duration> {
    times.sort_unstable();
    times.get(times.len() / 2).copied()
}
