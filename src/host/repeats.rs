//! Events that come again and again: the first ones are told, the others are counted.

use core::fmt;
use core::fmt::Write as _;
use core::hash::{Hash, Hasher};
use core::time::Duration;
use std::hash::DefaultHasher;

use crate::face::Again;
use crate::time::Instant;

/// What comes after this time is told as something new.
const QUIET: Duration = Duration::from_secs(2);
/// As long as it goes on, the count is told this often.
const REPORT: Duration = Duration::from_secs(60);
/// Events that are looked after at the same time; others are told each time.
const KNOWN: usize = 256;

/// Events of one cause with other numbers: so many are told, the others are counted.
const NUMBERS: u32 = 5;

/// So many different complaints of one place are told while they follow each other without a pause; the others are counted.
const DIFFERENT: u32 = 8;

/// What was told: each event, its cause whatever the numbers in it are, and how many different ones of its place.
#[derive(Debug)]
pub(super) struct Told<E> {
    /// With its place; 0 of those that count for themselves.
    events: Repeats<(u64, E)>,
    /// With its key, and its place.
    causes: Repeats<(u64, (u64, E))>,
    places: Repeats<(u64, E)>,
}

impl<E> Default for Told<E> {
    fn default() -> Self {
        Self { events: Repeats::default(), causes: Repeats::default(), places: Repeats::default() }
    }
}

impl<E: Clone> Told<E> {
    /// Whether an event is to be told now; if not, it is counted. `same`: whether two events say the same; `each`: how
    /// often it is told before it is counted; `of`: its place, and its cause, which is what it is whatever the numbers in it
    /// are ([`cause`]).
    pub(super) fn is_new(
        &mut self,
        now: Instant,
        event: &E,
        same: impl Fn(&E, &E) -> bool,
        each: u32,
        of: impl FnOnce(&E) -> (u64, u64),
    ) -> bool {
        let is_of_event = |one: &(u64, E), other: &(u64, E)| same(&one.1, &other.1);
        let mut at = 0;
        if each == 1 && !self.events.knows(now, &(0, event.clone()), is_of_event) {
            let (place, cause) = of(event);
            at = place;
            let of_cause = (cause.wrapping_add(place), (place, event.clone()));
            let of_place = (place, event.clone());
            if !self.causes.is_new(now, &of_cause, |one, other| one.0 == other.0, NUMBERS)
                || !self.places.is_new(now, &of_place, |one, other| one.0 == other.0, DIFFERENT)
            {
                return false;
            }
        }
        self.events.is_new(now, &(at, event.clone()), is_of_event, each)
    }

    /// When a count is to be told; `None`: nothing repeats.
    pub(super) fn poll_timeout(&self) -> Option<Instant> {
        let by_key = Instant::first_of(self.causes.poll_timeout(), self.places.poll_timeout());
        Instant::first_of(self.events.poll_timeout(), by_key)
    }

    /// An event whose count is to be told now.
    pub(super) fn poll(&mut self, now: Instant) -> Option<(E, Again)> {
        let Self { events, causes, places } = self;
        events.hand_over(now, places, |(place, _)| *place);
        causes.hand_over(now, places, |(_, (place, _))| *place);
        let told = events.poll(now).or_else(|| causes.poll(now).map(|((_, event), again)| (event, again)));
        let of_place = |(event, again)| (event, Again { of_others: true, ..again });
        told.or_else(|| places.poll(now).map(of_place)).map(|((_, event), again)| (event, again))
    }
}

/// What an event is whatever the numbers in it are: its words without those that have a digit.
pub(super) fn cause(event: &dyn fmt::Display) -> u64 {
    let mut words = Words::default();
    // A hasher takes everything.
    let _ = write!(words, "{event} ");
    words.hasher.finish()
}

/// Hashes words as they come, without memory of its own: an event is looked at with each telegram.
#[derive(Default)]
struct Words {
    hasher: DefaultHasher,
    word: DefaultHasher,
    has_digit: bool,
}

impl fmt::Write for Words {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for octet in text.bytes() {
            self.has_digit |= octet.is_ascii_digit();
            if octet.is_ascii_alphanumeric() {
                octet.hash(&mut self.word);
                continue;
            }
            let word = core::mem::take(&mut self.word);
            if !core::mem::take(&mut self.has_digit) {
                word.finish().hash(&mut self.hasher);
            }
        }
        Ok(())
    }
}

/// The events that came a short time ago.
#[derive(Debug)]
struct Repeats<E> {
    known: Vec<Known<E>>,
    /// When the first of the counts is to be told: asked for with every telegram, changed only by events that repeat.
    due: Option<Instant>,
}

#[derive(Debug)]
struct Known<E> {
    event: E,
    told: Instant,
    last: Instant,
    /// How often it was told, each time it came.
    each: u32,
    /// How often it came since then.
    more: u32,
}

impl<E> Known<E> {
    /// When its count is to be told.
    fn due(&self) -> Option<Instant> {
        let report = self.told.saturating_add(REPORT);
        (self.more > 0).then(|| self.last.saturating_add(QUIET).min(report))
    }
}

impl<E> Default for Repeats<E> {
    fn default() -> Self {
        Self { known: Vec::new(), due: None }
    }
}

impl<E: Clone> Repeats<E> {
    /// Hands the counts that are due over to their places, where those count: so much is wrong there that one count is told.
    fn hand_over<P: Clone>(
        &mut self,
        now: Instant,
        places: &mut Repeats<(u64, P)>,
        place_of: impl Fn(&E) -> u64,
    ) {
        if self.due.is_none_or(|due| now < due) {
            return;
        }
        for known in self.known.iter_mut().filter(|known| known.due().is_some_and(|due| due <= now)) {
            let key = place_of(&known.event);
            let of = |place: &&mut Known<(u64, P)>| place.event.0 == key && place.each >= DIFFERENT;
            if let Some(place) = places.known.iter_mut().find(of) {
                place.more = place.more.saturating_add(known.more);
                place.last = place.last.max(known.last);
                (known.told, known.more) = (now, 0);
            }
        }
        self.plan();
        places.plan();
    }
}

impl<E: Clone> Repeats<E> {
    /// Whether it came a short time ago.
    fn knows(&self, now: Instant, event: &E, same: impl Fn(&E, &E) -> bool) -> bool {
        let is_near = |known: &Known<E>| known.more > 0 || now.saturating_since(known.last) < QUIET;
        self.known.iter().any(|known| is_near(known) && same(&known.event, event))
    }

    /// Whether an event is to be told now; if not, it is counted. `same`: whether two events say the same; `each`: how
    /// often it is told before it is counted.
    fn is_new(&mut self, now: Instant, event: &E, same: impl Fn(&E, &E) -> bool, each: u32) -> bool {
        self.known.retain(|known| known.more > 0 || now.saturating_since(known.last) < QUIET);
        let Some(known) = self.known.iter_mut().find(|known| same(&known.event, event)) else {
            if self.known.len() < KNOWN {
                self.known.push(Known { event: event.clone(), told: now, last: now, each: 1, more: 0 });
            }
            return true;
        };
        known.last = now;
        let told = known.each < each;
        if told {
            (known.told, known.each) = (now, known.each.saturating_add(1));
        } else {
            known.more = known.more.saturating_add(1);
            self.plan();
        }
        told
    }

    fn plan(&mut self) {
        self.due = self.known.iter().filter_map(Known::due).min();
    }

    /// When a count is to be told; `None`: nothing repeats.
    const fn poll_timeout(&self) -> Option<Instant> {
        self.due
    }

    /// An event whose count is to be told now.
    fn poll(&mut self, now: Instant) -> Option<(E, Again)> {
        self.due.filter(|due| *due <= now)?;
        let known = self.known.iter_mut().find(|known| known.due().is_some_and(|due| due <= now))?;
        let within = known.last.saturating_since(known.told);
        let again = Again { times: known.more, within, of_others: false };
        (known.told, known.more) = (now, 0);
        let event = known.event.clone();
        self.plan();
        Some((event, again))
    }
}

#[cfg(test)]
mod tests {

    use super::*;

    fn at(milliseconds: u64) -> Instant {
        Instant::ZERO.saturating_add(Duration::from_millis(milliseconds))
    }

    #[test]
    fn the_same_event_is_told_once_and_then_counted() {
        let mut repeats = Repeats::<u8>::default();
        let same = |a: &u8, b: &u8| a == b;
        let mut told = 0;
        let mut counts = Vec::new();
        for time in (0..60_000).step_by(5) {
            told += u32::from(repeats.is_new(at(time), &7, same, 1));
            told += u32::from(time % 2500 == 0 && repeats.is_new(at(time), &8, same, 1));
            counts.extend(core::iter::from_fn(|| repeats.poll(at(time))));
        }
        assert_eq!(told, 1 + 24, "one that comes each 2.5 s is told each time");
        assert_eq!(counts, []);
        let last = repeats.poll(at(62_000)).map(|(event, again)| (event, again.to_string()));
        assert_eq!(last, Some((7, "11999 times more in 60.0 s".to_string())));
        assert!(repeats.poll(at(64_000)).is_none() && repeats.is_new(at(64_000), &7, same, 1));
    }

    #[test]
    fn of_one_cause_with_other_numbers_five_are_told_and_the_others_counted() {
        let mut told = Told::<String>::default();
        let (mut new, mut counts) = (0, Vec::new());
        for time in (0..10_000_u64).step_by(10) {
            let text = format!("travel to {time} inc refused: OFF1 is given (STW.0 = 0)");
            new += u32::from(told.is_new(at(time), &text, PartialEq::eq, 1, |text| (5, cause(text))));
            counts.extend(core::iter::from_fn(|| told.poll(at(time))));
        }
        counts.extend(core::iter::from_fn(|| told.poll(at(20_000))));
        let times: Vec<_> = counts.iter().map(|(_, again)| again.times).collect();
        assert_eq!((new, times), (5, vec![995]));
        let other = "inching refused: OFF1 is given (STW.0 = 0)".to_string();
        assert!(told.is_new(at(20_000), &other, PartialEq::eq, 1, |text| (5, cause(text))));
    }

    #[test]
    fn what_is_told_each_time_at_first_is_counted_when_it_goes_on() {
        let mut repeats = Repeats::<u8>::default();
        let told =
            (0..10).map(|time| repeats.is_new(at(100 * time), &7, PartialEq::eq, 3)).filter(|told| *told);
        assert_eq!(told.count(), 3);
        assert_eq!(repeats.poll_timeout(), Some(at(2900)), "2 s after the last");
        assert_eq!(repeats.poll(at(2899)), None);
        assert_eq!(
            repeats.poll(at(2900)),
            Some((7, Again { times: 7, within: Duration::from_millis(700), of_others: false }))
        );
        assert_eq!(repeats.poll_timeout(), None);
    }
}
