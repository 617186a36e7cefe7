//! A tap: shows what passes on a link, in both directions, and changes nothing.
//!
//! ```text
//! master ──octets──▶ link ──▶ Tap ──▶ Faulty ──▶ drives
//!        ◀──────────      ◀──     ◀──        ◀──
//!                             └──Batch──▶ capture file, live stream
//! ```
//!
//! Next to the link, inside of [`Faulty`](super::fault::Faulty), it shows what is really on the line: corrupted replies as
//! they were corrupted, requests that the drives never hear. Octets are cut into telegrams as a
//! [`Framer`](crate::profibus::fdl::Framer) with [`Resync::SCAN`](crate::profibus::fdl::Resync::SCAN) does, for each direction by itself;
//! what is no telegram is shown too. Every octet is shown once.
//!
//! ```
//! use profidrive::host::link::memory::Wire;
//! use profidrive::host::link::tap::{Batch, Tap};
//! use profidrive::host::{Link, ManualClock};
//!
//! let wire = Wire::new();
//! let mut master = wire.end();
//! let mut seen = Vec::new();
//! let mut drives = Tap::new(wire.end(), ManualClock::new(), |batch: &Batch| {
//!     seen.extend(batch.iter().map(|seen| (seen.direction, seen.octets.to_vec(), seen.telegram.is_ok())));
//! });
//!
//! master.send(&[0xFF, 0x10, 0x05, 0x02, 0x49, 0x50, 0x16])?;
//! drives.receive(&mut [0; 16])?;
//! drives.send(&[0x10, 0x02, 0x05, 0x00, 0x07, 0x16])?;
//! drop(drives);
//!
//! use profidrive::host::link::tap::Direction::{Heard, Sent};
//! assert_eq!(
//!     seen,
//!     [
//!         (Heard, vec![0xFF], false),
//!         (Heard, vec![0x10, 0x05, 0x02, 0x49, 0x50, 0x16], true),
//!         (Sent, vec![0x10, 0x02, 0x05, 0x00, 0x07, 0x16], true),
//!     ]
//! );
//! # Ok::<(), std::io::Error>(())
//! ```

use core::sync::atomic::{AtomicUsize, Ordering};
use core::time::Duration;
use std::io;
use std::sync::Arc;

use super::pieces::{Piece, Pieces, broken_off};
use crate::host::{Clock, Link, Received, Stop};
use crate::profibus::fdl::telegram::{Decoded, decode};
use crate::profibus::fdl::{FrameError, Telegram};
use crate::time::{BaudRate, Instant};

/// A batch with so many octets is shown although more may come at once.
const FULL_BATCH: usize = 4096;

/// A link that shows what passes.
///
/// The observer is called on the thread of the link, on the path of a reply: it must be quick. It gets what was heard
/// before the drives sleep, and always **before** a reply is sent that reply and all that was heard before it: what a
/// master holds, the observer has seen. At the end it gets the rest.
pub struct Tap<L, C: Clock, F: FnMut(&Batch)> {
    link: L,
    clock: C,
    observer: F,
    heard: Pieces,
    sent: Pieces,
    batch: Batch,
    /// `None`: the observer always watches.
    watchers: Option<Watchers>,
}

impl<L: Link, C: Clock, F: FnMut(&Batch)> Tap<L, C, F> {
    /// Shows what passes on `link` to `observer`. `clock` is that of the drives.
    pub fn new(link: L, clock: C, observer: F) -> Self {
        let (heard, sent) = (Pieces::default(), Pieces::ended());
        Self { link, clock, observer, heard, sent, batch: Batch::default(), watchers: None }
    }

    /// Shows only what passes while there are `watchers`. Meanwhile a tap costs nothing.
    pub fn only_for(mut self, watchers: Watchers) -> Self {
        self.watchers = Some(watchers);
        self
    }
}

impl<L, C: Clock, F: FnMut(&Batch)> Tap<L, C, F> {
    /// Whether to show. What nobody watches is forgotten, also what was not shown yet.
    fn is_watched(&mut self) -> bool {
        let watched = self.watchers.as_ref().is_none_or(Watchers::any);
        if !watched {
            self.heard.clear();
            self.batch.clear();
        }
        watched
    }

    /// Cuts what was heard, as far as that is possible now.
    fn cut_heard(&mut self, now: Instant) {
        self.batch.take(&mut self.heard, now, Direction::Heard);
    }

    /// What comes next continues nothing.
    fn end_heard(&mut self, now: Instant) {
        self.heard.end();
        self.cut_heard(now);
        self.heard = Pieces::default();
    }

    fn show(&mut self) {
        if !self.batch.is_empty() {
            (self.observer)(&self.batch);
            self.batch.clear();
        }
    }
}

impl<L: Link, C: Clock, F: FnMut(&Batch)> Link for Tap<L, C, F> {
    fn receive(&mut self, buf: &mut [u8]) -> io::Result<Received> {
        let received = self.link.receive(buf)?;
        if !self.is_watched() {
            return Ok(received);
        }
        let now = self.clock.now();
        // The silence before these octets may have ended a telegram.
        self.cut_heard(now);
        match received {
            Received::Octets(count) => {
                self.heard.push(now, buf.get(..count).unwrap_or_default());
                self.cut_heard(now);
                if self.batch.octets.len() >= FULL_BATCH {
                    self.show();
                }
            }
            Received::BrokenOff(count) => {
                self.heard.push(now, buf.get(..count).unwrap_or_default());
                self.end_heard(now);
            }
            Received::Reset => self.end_heard(now),
            Received::Rate(_) | Received::Nothing => {}
        }
        Ok(received)
    }

    fn send(&mut self, telegram: &[u8]) -> io::Result<()> {
        if self.is_watched() {
            let now = self.clock.now();
            self.sent.push(now, telegram);
            self.batch.take(&mut self.sent, now, Direction::Sent);
            self.show();
        }
        self.link.send(telegram)
    }

    fn wait(&mut self, timeout: Option<Duration>, stop: &Stop) -> io::Result<()> {
        if !self.is_watched() {
            return self.link.wait(timeout, stop);
        }
        let now = self.clock.now();
        self.cut_heard(now);
        self.show();
        let own = self.heard.poll_timeout().map(|due| due.saturating_since(now));
        self.link.wait(own.into_iter().chain(timeout).min(), stop)
    }

    fn set_rate(&mut self, rate: BaudRate) -> io::Result<()> {
        self.link.set_rate(rate)
    }

    fn resolution(&self) -> Duration {
        self.link.resolution()
    }
}

impl<L, C: Clock, F: FnMut(&Batch)> Drop for Tap<L, C, F> {
    fn drop(&mut self) {
        if self.is_watched() {
            self.heard.end();
            self.cut_heard(self.clock.now());
            self.show();
        }
    }
}

/// How many want to see what passes now. Clones count together.
#[derive(Clone, Debug, Default)]
pub struct Watchers(Arc<AtomicUsize>);

/// Somebody who wants to see what passes, as long as this lives.
#[derive(Debug)]
pub struct Watch(Watchers);

impl Watchers {
    /// One more.
    pub fn watch(&self) -> Watch {
        self.0.fetch_add(1, Ordering::Relaxed);
        Watch(self.clone())
    }

    /// Whether there is one.
    pub(crate) fn any(&self) -> bool {
        self.0.load(Ordering::Relaxed) > 0
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        let Watchers(count) = &self.0;
        count.fetch_sub(1, Ordering::Relaxed);
    }
}

/// What passed since the observer was called last, oldest first, at least one telegram or run of octets.
#[derive(Clone, Debug, Default)]
pub struct Batch {
    octets: Vec<u8>,
    marks: Vec<Mark>,
}

/// Where one [`Seen`] ends in the octets of a batch.
#[derive(Clone, Copy, Debug)]
struct Mark {
    at: Instant,
    direction: Direction,
    end: usize,
    invalid: Option<FrameError>,
}

/// One telegram, or a run of octets that are none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Seen<'a> {
    /// When its last octet was heard, or when it was given to the link to be sent.
    pub at: Instant,
    /// Which way.
    pub direction: Direction,
    /// All of its octets.
    pub octets: &'a [u8],
    /// The telegram, or why the first octet begins none.
    pub telegram: Result<Telegram<'a>, FrameError>,
}

/// Which way octets pass a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "panel", derive(serde::Serialize), serde(rename_all = "snake_case"))]
#[cfg_attr(all(test, feature = "panel"), derive(utoipa::ToSchema))]
pub enum Direction {
    /// From the line: of a master, or of another station.
    Heard,
    /// To the line: of a station of ours.
    Sent,
}

impl Batch {
    /// Adds one sending that ended at `at`: one telegram, or as many pieces as it has.
    pub(crate) fn push(&mut self, at: Instant, direction: Direction, octets: &[u8]) {
        let mut pieces = Pieces::ended();
        pieces.push(at, octets);
        self.take(&mut pieces, at, direction);
    }

    /// What passed, oldest first.
    pub fn iter(&self) -> impl Iterator<Item = Seen<'_>> {
        let mut begin = 0;
        self.marks.iter().map(move |mark| {
            let octets = self.octets.get(begin..mark.end).unwrap_or_default();
            begin = mark.end;
            let telegram = match (mark.invalid, decode(octets)) {
                (Some(error), _) | (None, Decoded::Invalid { error, .. }) => Err(error),
                (None, Decoded::Telegram { telegram, .. }) => Ok(telegram),
                (None, Decoded::Incomplete) => Err(broken_off(octets)),
            };
            Seen { at: mark.at, direction: mark.direction, octets, telegram }
        })
    }

    /// Takes from `pieces` what is whole.
    fn take(&mut self, pieces: &mut Pieces, now: Instant, direction: Direction) {
        while let Some(piece) = pieces.pop(now) {
            let (octets, invalid) = match piece {
                Piece::Telegram(octets) => (octets, None),
                Piece::Noise(octets, error) => (octets, Some(error)),
            };
            self.octets.extend_from_slice(&octets);
            self.marks.push(Mark { at: pieces.last(), direction, end: self.octets.len(), invalid });
        }
    }

    fn is_empty(&self) -> bool {
        self.marks.is_empty()
    }

    fn clear(&mut self) {
        self.octets.clear();
        self.marks.clear();
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::Direction::{Heard, Sent};
    use super::*;
    use core::cell::RefCell;
    use proptest::prelude::*;
    use std::collections::VecDeque;
    use std::rc::Rc;

    use crate::host::ManualClock;
    use crate::host::link::memory::Wire;

    const ASK: [u8; 6] = [0x10, 0x05, 0x02, 0x49, 0x50, 0x16];
    const ANSWER: [u8; 6] = [0x10, 0x02, 0x05, 0x00, 0x07, 0x16];

    /// Time in milliseconds, direction, octets, why they are no telegram.
    type Owned = (u64, Direction, Vec<u8>, Option<FrameError>);
    /// What the observer got, one entry for each call.
    type Shown = Rc<RefCell<Vec<Vec<Owned>>>>;
    /// What was sent, each with how much was shown before.
    type Sends = Rc<RefCell<Vec<(Vec<u8>, usize)>>>;

    /// A link that plays what the other end did, and writes down what is sent, with how much was shown before.
    struct Script {
        plays: VecDeque<(Vec<u8>, Received)>,
        sent: Sends,
        timeouts: Rc<RefCell<Vec<Option<Duration>>>>,
        shown: Shown,
    }

    impl Link for Script {
        fn receive(&mut self, buf: &mut [u8]) -> io::Result<Received> {
            let Some((octets, received)) = self.plays.pop_front() else {
                return Ok(Received::Nothing);
            };
            buf.iter_mut().zip(octets).for_each(|(to, octet)| *to = octet);
            Ok(received)
        }
        fn send(&mut self, telegram: &[u8]) -> io::Result<()> {
            let shown = self.shown.borrow().iter().map(Vec::len).sum();
            self.sent.borrow_mut().push((telegram.to_vec(), shown));
            Ok(())
        }
        fn wait(&mut self, timeout: Option<Duration>, _: &Stop) -> io::Result<()> {
            self.timeouts.borrow_mut().push(timeout);
            Ok(())
        }
    }

    fn octets(octets: &[u8]) -> (Vec<u8>, Received) {
        (octets.to_vec(), Received::Octets(octets.len()))
    }

    struct Setup {
        tap: Box<dyn Link>,
        clock: ManualClock,
        shown: Shown,
        sent: Sends,
        timeouts: Rc<RefCell<Vec<Option<Duration>>>>,
    }

    fn setup(plays: &[(Vec<u8>, Received)]) -> Setup {
        let (clock, shown) = (ManualClock::new(), Shown::default());
        let (sent, timeouts) = (Rc::default(), Rc::default());
        let script = Script {
            plays: plays.iter().cloned().collect(),
            sent: Rc::clone(&sent),
            timeouts: Rc::clone(&timeouts),
            shown: Rc::clone(&shown),
        };
        let observed = Rc::clone(&shown);
        let tap = Tap::new(script, clock.clone(), move |batch: &Batch| {
            let owned = batch.iter().map(|seen| {
                (seen.at.as_nanos() / 1_000_000, seen.direction, seen.octets.to_vec(), seen.telegram.err())
            });
            observed.borrow_mut().push(owned.collect());
        });
        Setup { tap: Box::new(tap), clock, shown, sent, timeouts }
    }

    #[test]
    fn a_reply_is_shown_before_it_is_sent_together_with_what_was_heard() {
        let Setup { mut tap, clock, shown, sent, .. } = setup(&[octets(&ASK)]);
        clock.advance_to(Instant::from_millis(3));
        assert_eq!(tap.receive(&mut [0; 8]).unwrap(), Received::Octets(6));
        assert_eq!(*shown.borrow(), Vec::<Vec<Owned>>::new(), "not on its way to the drives");
        clock.advance_to(Instant::from_millis(4));
        tap.send(&ANSWER).unwrap();
        let expected = vec![vec![(3, Heard, ASK.to_vec(), None), (4, Sent, ANSWER.to_vec(), None)]];
        assert_eq!(*shown.borrow(), expected);
        assert_eq!(*sent.borrow(), [(ANSWER.to_vec(), 2)]);
    }

    #[test]
    fn what_was_heard_is_shown_before_a_sleep_which_ends_when_half_a_telegram_is_given_up() {
        let stop = Stop::new().unwrap();
        let half = &[0x68, 0x05, 0x05][..];
        let Setup { mut tap, clock, shown, timeouts, .. } = setup(&[octets(&[&ASK, half].concat())]);
        tap.receive(&mut [0; 16]).unwrap();
        tap.wait(None, &stop).unwrap();
        clock.advance_to(Instant::from_millis(20));
        tap.wait(Some(Duration::from_millis(1)), &stop).unwrap();
        clock.advance_to(Instant::from_millis(50));
        tap.receive(&mut [0; 16]).unwrap();
        tap.wait(None, &stop).unwrap();
        let broken = FrameError::BrokenOff { octets: 3 };
        let expected = [vec![(0, Heard, ASK.to_vec(), None)], vec![(0, Heard, half.to_vec(), Some(broken))]];
        assert_eq!(*shown.borrow(), expected);
        assert_eq!(
            *timeouts.borrow(),
            [Some(Duration::from_millis(50)), Some(Duration::from_millis(1)), None]
        );
    }

    #[test]
    fn what_passes_is_shown_only_while_somebody_watches() {
        let (wire, watchers) = (Wire::new(), Watchers::default());
        let (mut master, shown) = (wire.end(), Rc::new(RefCell::new(Vec::new())));
        let observed = Rc::clone(&shown);
        let observer = move |batch: &Batch| {
            observed.borrow_mut().extend(batch.iter().map(|seen| (seen.direction, seen.octets.to_vec())));
        };
        let mut tap = Tap::new(wire.end(), ManualClock::new(), observer).only_for(watchers.clone());
        let mut pass = |request: &[u8]| {
            master.send(request).unwrap();
            assert_eq!(tap.receive(&mut [0; 16]).unwrap(), Received::Octets(request.len()));
            tap.send(&ANSWER).unwrap();
            assert_eq!(master.receive(&mut [0; 16]).unwrap(), Received::Octets(ANSWER.len()));
        };
        let both = [(Heard, ASK.to_vec()), (Sent, ANSWER.to_vec())];

        pass(&ASK);
        assert_eq!(*shown.borrow(), [], "nobody watches");
        let (first, second) = (watchers.watch(), watchers.watch());
        pass(&ASK);
        assert_eq!(*shown.borrow(), both);
        drop(first);
        pass(&ASK[..3]);
        assert_eq!(shown.borrow_mut().split_off(2), [(Sent, ANSWER.to_vec())], "half a telegram waits");
        drop(second);
        pass(&ASK);
        let _third = watchers.watch();
        pass(&ASK);
        assert_eq!(shown.borrow_mut().split_off(2), both, "of before nothing is left");
    }

    #[test]
    fn octets_of_two_masters_are_not_mixed() {
        let plays = [octets(&ASK[..4]), (vec![], Received::Reset), octets(&ASK[4..]), octets(&ASK)];
        let Setup { mut tap, shown, .. } = setup(&plays);
        for _ in &plays {
            tap.receive(&mut [0; 16]).unwrap();
        }
        drop(tap);
        let expected = vec![
            (0, Heard, ASK[..4].to_vec(), Some(FrameError::BrokenOff { octets: 4 })),
            (0, Heard, ASK[4..].to_vec(), Some(FrameError::StartDelimiter { got: 0x50 })),
            (0, Heard, ASK.to_vec(), None),
        ];
        assert_eq!(shown.borrow().concat(), expected);
    }

    #[test]
    fn a_corrupted_reply_is_shown_with_the_reason() {
        let Setup { mut tap, shown, .. } = setup(&[]);
        let mut wrong = ANSWER;
        wrong[4] = 8;
        tap.send(&wrong).unwrap();
        tap.send(&ANSWER[..5]).unwrap();
        let checksum = FrameError::Checksum { expected: 7, got: 8 };
        let expected = vec![
            (0, Sent, wrong.to_vec(), Some(checksum)),
            (0, Sent, ANSWER[..5].to_vec(), Some(FrameError::BrokenOff { octets: 5 })),
        ];
        assert_eq!(shown.borrow().concat(), expected);
    }

    proptest! {
        /// Whatever is heard and sent, every octet is shown once, in its direction and order, in bounded batches.
        #[test]
        fn every_octet_is_shown_once(
            chunks in prop::collection::vec((any::<bool>(), prop::collection::vec(prop_oneof![
                4 => any::<u8>(), 1 => Just(0x10), 1 => Just(0xE5), 1 => Just(0x68)
            ], 1..300)), 0..12),
        ) {
            let plays: Vec<_> =
                chunks.iter().filter(|(heard, _)| *heard).map(|(_, chunk)| octets(chunk)).collect();
            let Setup { mut tap, shown, sent, .. } = setup(&plays);
            let mut buf = [0; 300];
            for (heard, chunk) in &chunks {
                if *heard {
                    tap.receive(&mut buf).unwrap();
                    prop_assert_eq!(&buf[..chunk.len()], &chunk[..]);
                } else {
                    tap.send(chunk).unwrap();
                }
            }
            drop(tap);
            for (direction, passed) in [(Heard, true), (Sent, false)] {
                let expected: Vec<u8> =
                    chunks.iter().filter(|(heard, _)| *heard == passed).flat_map(|(_, chunk)| chunk.clone()).collect();
                let all = shown.borrow().concat();
                let found: Vec<u8> =
                    all.into_iter().filter(|seen| seen.1 == direction).flat_map(|seen| seen.2).collect();
                prop_assert_eq!(found, expected);
            }
            let unchanged: Vec<_> = sent.borrow().iter().map(|(octets, _)| octets.clone()).collect();
            let given: Vec<_> =
                chunks.iter().filter(|(heard, _)| !heard).map(|(_, chunk)| chunk.clone()).collect();
            prop_assert_eq!(unchanged, given);
        }
    }
}
