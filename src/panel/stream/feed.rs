//! The end of the stream at the thread of a line.

use crate::map::Map;
use core::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::super::line::OnLine;
use crate::can_bus::can::{ErrorState, Frame};
use crate::can_bus::canopen;
use crate::can_bus::canopen::NodeId;
use crate::devices::{CanopenEvent, Vocabulary};
use crate::explain::Known;
use crate::host::BusEvent;
use crate::host::can::bus::Tuned;
use crate::host::can::{BusHint, Event, Seat};
use crate::host::link::tap::{Batch, Direction, Watchers};
use crate::profibus::fdl::MAX_TELEGRAM_LEN;
use crate::time::Instant;

/// Entries that wait in the ring at most; more are counted and lost.
pub(super) const RING: usize = 1024;

/// What the thread of a line tells.
pub(super) enum Entry {
    News(Instant, Told),
    Telegram {
        at: Instant,
        direction: Direction,
        len: usize,
        octets: [u8; MAX_TELEGRAM_LEN],
    },
    Frame {
        at: Instant,
        direction: Direction,
        frame: Frame,
    },
    /// In what the telegrams behind this one are to be read.
    Known(u8, Known),
    /// In which words the frames behind this one are to be read.
    Words(u8, &'static Vocabulary),
}

/// What has happened.
pub(super) enum Told {
    /// On a line of PROFIBUS, with words that stand behind what the event says itself.
    Line(BusEvent, Option<Arc<str>>),
    /// At a node.
    Node(Option<u8>, CanopenEvent),
    /// To the error counters of a node.
    State(Option<u8>, ErrorState),
    /// To the rate of a node or of its bus.
    Tuned(Option<u8>, Tuned),
    /// On a bus of CAN.
    Hint(BusHint),
    /// So many events of a bus of CAN were too many.
    Lost(u64),
    /// In the program itself, to its line.
    #[cfg(feature = "emulator")]
    Trouble(String),
}

/// What both ends know.
#[derive(Debug, Default)]
pub(super) struct Shared {
    /// Who watches telegrams.
    pub(super) watchers: Watchers,
    /// How often the settings of all stations were wanted anew.
    pub(super) settings_wanted: AtomicU64,
    pub(super) news_lost: AtomicU64,
    pub(super) telegrams_lost: AtomicU64,
    /// Which node is at which seat.
    seats: Mutex<Map<Seat, NodeId>>,
}

/// The settings that were sent since all of them were wanted.
#[derive(Debug, Default)]
pub(in crate::panel) struct SentSettings {
    wanted: u64,
    known: Map<u8, Known>,
    words: Map<u8, &'static str>,
}

/// The end of the stream at the thread of a line. Nothing here waits, and nothing of news and telegrams allocates.
#[derive(Clone, Debug)]
pub(in crate::panel) struct Feed {
    ring: SyncSender<Entry>,
    shared: Arc<Shared>,
}

impl core::fmt::Debug for Entry {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("Entry")
    }
}

impl Feed {
    /// And the other end of the ring.
    pub(super) fn new(shared: Arc<Shared>) -> (Self, Receiver<Entry>) {
        let (ring, entries) = sync_channel(RING);
        (Self { ring, shared }, entries)
    }

    pub(in crate::panel) fn watchers(&self) -> &Watchers {
        &self.shared.watchers
    }

    pub(in crate::panel) fn tell(&self, now: Instant, event: &BusEvent, words: Option<Arc<str>>) {
        self.news(now, Told::Line(event.clone(), words));
    }

    pub(in crate::panel) fn hint(&self, now: Instant, hint: BusHint) {
        self.news(now, Told::Hint(hint));
    }

    #[cfg(feature = "emulator")]
    pub(in crate::panel) fn warn(&self, now: Instant, text: String) {
        self.news(now, Told::Trouble(text));
    }

    /// What happens on a bus of CAN; frames only while somebody watches.
    pub(in crate::panel) fn tell_can(&self, now: Instant, event: &Event<CanopenEvent>) {
        match event {
            Event::Participant { seat, event } => {
                if let CanopenEvent::Node(canopen::Event::BootUp { node, .. }) = event {
                    self.seats().insert(*seat, *node);
                }
                self.news(now, Told::Node(self.number(*seat), event.clone()));
            }
            Event::State { at, seat, state } => self.news(*at, Told::State(self.number(*seat), *state)),
            Event::Tuned(tuned) => self.news(tuned.at, Told::Tuned(self.number(tuned.seat), *tuned)),
            Event::Passed { at, by_port, frame, .. } if self.shared.watchers.any() => {
                let direction = if *by_port { Direction::Heard } else { Direction::Sent };
                self.telegram(Entry::Frame { at: *at, direction, frame: *frame });
            }
            // Nobody watches; of a damaged one the bus keeps count, and it comes again.
            Event::Passed { .. } | Event::Damaged { .. } => {}
            Event::Lost { events } => self.news(now, Told::Lost(*events)),
        }
    }

    fn seats(&self) -> MutexGuard<'_, Map<Seat, NodeId>> {
        self.shared.seats.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn number(&self, seat: Seat) -> Option<u8> {
        self.seats().get(&seat).map(|node| node.number())
    }

    /// Learns which node is at which seat.
    pub(in crate::panel) fn know(&self, numbers: impl Iterator<Item = (Seat, NodeId)>) {
        self.seats().extend(numbers);
    }

    fn news(&self, at: Instant, told: Told) {
        if self.ring.try_send(Entry::News(at, told)).is_err() {
            self.shared.news_lost.fetch_add(1, Ordering::Relaxed);
        }
    }

    fn telegram(&self, entry: Entry) {
        if self.ring.try_send(entry).is_err() {
            self.shared.telegrams_lost.fetch_add(1, Ordering::Relaxed);
        }
    }

    pub(in crate::panel) fn show(&self, batch: &Batch) {
        if !self.shared.watchers.any() {
            return;
        }
        for seen in batch.iter() {
            for piece in seen.octets.chunks(MAX_TELEGRAM_LEN) {
                let mut octets = [0; MAX_TELEGRAM_LEN];
                for (to, octet) in octets.iter_mut().zip(piece) {
                    *to = *octet;
                }
                let len = piece.len();
                self.telegram(Entry::Telegram { at: seen.at, direction: seen.direction, len, octets });
            }
        }
    }

    /// While telegrams are watched: what has changed of the settings, before the telegrams that come with them.
    pub(in crate::panel) fn settings(&self, lent: &dyn OnLine, sent: &mut SentSettings) {
        if !self.shared.watchers.any() {
            return;
        }
        let wanted = self.shared.settings_wanted.load(Ordering::Relaxed);
        if sent.wanted != wanted {
            *sent = SentSettings { wanted, ..SentSettings::default() };
        }
        for address in lent.addresses() {
            // Without room they are sent the next time.
            if let Some(known) = lent.known(address)
                && sent.known.get(&address) != Some(&known)
                && self.ring.try_send(Entry::Known(address, known)).is_ok()
            {
                sent.known.insert(address, known);
            }
            if let Some(words) = lent.words(address)
                && sent.words.get(&address) != Some(&words.name)
                && self.ring.try_send(Entry::Words(address, words)).is_ok()
            {
                sent.words.insert(address, words.name);
            }
        }
    }
}
