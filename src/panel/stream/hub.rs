//! The middle of the stream: takes what a line tells and passes it on to the readers of all lines.

use crate::map::Map;
use core::sync::atomic::{AtomicUsize, Ordering};
use core::time::Duration;
use std::sync::mpsc::Receiver;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::SystemTime;

use tokio::sync::broadcast;
use tokio::time::{Instant as Moment, sleep};

use super::super::history::{EVERY, History, Newest, Sampled};
use super::super::line::Asking;
use super::event::{Item, LastRefusal, Lost, NewsEvent, TelegramEvent, message_of};
use super::feed::{Entry, RING, Shared};
use crate::can_bus::canopen::NodeId;
use crate::explain;
use crate::explain::canopen::Network;
use crate::host::capture;
use crate::host::link::tap::Watch;
use crate::profibus::fdl::Address;
use crate::time::Instant;

/// Items a subscriber may be behind at most.
const BEHIND: usize = 1024;

/// Subscribers at most.
pub(in crate::panel) const MOST_SUBSCRIBERS: usize = 16;

/// How often the ring is looked at while somebody subscribes, and while nobody does.
const LOOK: Duration = Duration::from_millis(25);
const LOOK_IDLE: Duration = Duration::from_millis(250);

/// How often the settings of all stations are asked for while somebody watches telegrams: a station may change them by
/// itself, and what a subscriber hears may be wrong.
const SETTLE: Duration = Duration::from_secs(1);

/// What the readers of all lines share.
pub(in crate::panel) struct Readers {
    pub(super) news: broadcast::Sender<Item>,
    pub(super) telegrams: broadcast::Sender<Item>,
    subscribers: AtomicUsize,
    started: SystemTime,
    events: Mutex<Newest<(Instant, NewsEvent)>>,
}

impl Default for Readers {
    fn default() -> Self {
        Self {
            news: broadcast::channel(BEHIND).0,
            telegrams: broadcast::channel(BEHIND).0,
            subscribers: AtomicUsize::new(0),
            started: SystemTime::now(),
            events: Mutex::default(),
        }
    }
}

impl Readers {
    /// The events that are kept, each with the time on the clock of its line, oldest first.
    pub(in crate::panel) fn events<T>(&self, look: impl FnOnce(&Newest<(Instant, NewsEvent)>) -> T) -> T {
        look(&self.events.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// When the process was started.
    pub(in crate::panel) const fn started(&self) -> SystemTime {
        self.started
    }

    fn tell(&self, make: impl FnOnce(u64) -> (Instant, NewsEvent)) {
        let mut events = self.events.lock().unwrap_or_else(PoisonError::into_inner);
        let (_, told) = events.keep(make, |(_, event)| event.weight());
        // In the order of their numbers. Whether somebody hears it is not our concern.
        let _ = self.news.send(told.item());
    }
}

/// Takes what a line tells and passes it on to subscribers.
#[derive(Clone)]
pub(in crate::panel) struct Hub(Arc<Inner>);

struct Inner {
    line: Arc<str>,
    ring: Mutex<Ring>,
    shared: Arc<Shared>,
    readers: Arc<Readers>,
}

/// The ring, and what was learned from what was in it.
struct Ring {
    entries: Receiver<Entry>,
    last_refusals: Map<u8, LastRefusal>,
    context: explain::Context,
    network: Network,
    history: History,
}

impl Hub {
    /// With the end of the ring.
    pub(super) fn new(
        line: Arc<str>,
        entries: Receiver<Entry>,
        shared: Arc<Shared>,
        readers: Arc<Readers>,
    ) -> Self {
        let ring = Ring {
            entries,
            last_refusals: Map::new(),
            context: explain::Context::default(),
            network: Network::default(),
            history: History::default(),
        };
        Self(Arc::new(Inner { line, ring: Mutex::new(ring), shared, readers }))
    }

    /// Passes on what the line tells and keeps samples, for ever.
    pub(in crate::panel) async fn run(self, asking: Asking) {
        tokio::join!(self.pass_on(&asking), self.sample(&asking));
    }

    async fn sample(&self, asking: &Asking) {
        loop {
            sleep(EVERY).await;
            // A line without time is sampled the next time.
            if let Ok(sampled) = asking.ask(|lent| Sampled::of(lent)).await {
                self.drained().history.samples.keep(sampled);
            }
        }
    }

    /// Settings of stations that the line does not tell are asked for.
    async fn pass_on(&self, asking: &Asking) {
        let mut settled = Moment::now();
        loop {
            let idle = self.0.readers.subscribers.load(Ordering::SeqCst) == 0;
            sleep(if idle { LOOK_IDLE } else { LOOK }).await;
            if self.0.shared.watchers.any() && settled.elapsed() >= SETTLE {
                settled = Moment::now();
                self.0.shared.settings_wanted.fetch_add(1, Ordering::Relaxed);
                asking.wake();
            }
            drop(self.drained());
        }
    }

    /// Somebody watches telegrams as long as what this returns lives. The next request to the line brings the settings
    /// of all stations, before the telegrams behind it.
    pub(super) fn watch(&self) -> Watch {
        self.0.shared.settings_wanted.fetch_add(1, Ordering::Relaxed);
        self.0.shared.watchers.watch()
    }

    /// The newest request that a station refused; one of its slave only while no data is exchanged.
    pub(in crate::panel) fn last_refusal(&self, address: u8, exchanging: bool) -> Option<LastRefusal> {
        let refusal = self.drained().last_refusals.get(&address).cloned();
        refusal.filter(|refusal| !(refusal.of_slave && exchanging))
    }

    /// What `look` finds in what was.
    pub(in crate::panel) fn history<T>(&self, look: impl FnOnce(&History) -> T) -> T {
        look(&self.drained().history)
    }

    /// Takes what waits, so that events that were told are among the recent ones.
    pub(in crate::panel) fn drain(&self) {
        drop(self.drained());
    }

    fn drained(&self) -> MutexGuard<'_, Ring> {
        let Inner { line, ring, shared, readers } = &*self.0;
        let mut ring = ring.lock().unwrap_or_else(PoisonError::into_inner);
        // No more than there can be: the line may go on telling.
        for _ in 0..RING {
            let Ok(entry) = ring.entries.try_recv() else { break };
            ring.take(line, readers, entry);
        }
        let lost = Lost {
            states: 0,
            news: shared.news_lost.swap(0, Ordering::Relaxed),
            telegrams: shared.telegrams_lost.swap(0, Ordering::Relaxed),
        };
        let message =
            |lost: &Lost| Item { message: message_of("lost", lost), line: line.clone(), about: [None, None] };
        if lost.news > 0 {
            let _ = readers.news.send(message(&Lost { telegrams: 0, ..lost }));
        }
        if lost.telegrams > 0 {
            let _ = readers.telegrams.send(message(&Lost { news: 0, ..lost }));
        }
        ring
    }
}

impl Ring {
    fn take(&mut self, line: &Arc<str>, readers: &Readers, entry: Entry) {
        match entry {
            Entry::News(at, told) => {
                if let Some((address, refusal)) = told.refusal(at) {
                    self.last_refusals.insert(address, refusal);
                }
                readers.tell(|number| (at, NewsEvent::of(number, at, line, &told)));
            }
            Entry::Telegram { at, direction, len, octets } => {
                let octets = octets.get(..len).unwrap_or_default();
                self.history.recording.keep(at, direction, octets);
                let explanation = self.context.telegram(octets);
                let item = TelegramEvent::item(line.clone(), (at, direction), octets, &explanation);
                let _ = readers.telegrams.send(TelegramEvent::of_profibus(item));
            }
            Entry::Frame { at, direction, frame } => {
                self.history.recording.keep(at, direction, &capture::can::octets(&frame));
                let explanation = self.network.frame(&frame);
                let item = TelegramEvent::item(line.clone(), (at, direction), frame.octets(), &explanation);
                let _ = readers.telegrams.send(item);
            }
            Entry::Known(address, known) => self.context.know_station(Address::from_octet(address), known),
            Entry::Words(address, words) => {
                if let Ok(node) = NodeId::new(address) {
                    self.network.know(node, words);
                }
            }
        }
    }
}

/// One of the places for subscribers.
pub(super) struct Seat(Arc<Readers>);

impl Seat {
    pub(super) fn take(readers: &Arc<Readers>) -> Option<Self> {
        let taken = readers.subscribers.fetch_update(Ordering::SeqCst, Ordering::SeqCst, |count| {
            (count < MOST_SUBSCRIBERS).then_some(count + 1)
        });
        taken.ok().map(|_| Self(Arc::clone(readers)))
    }
}

impl Drop for Seat {
    fn drop(&mut self) {
        self.0.subscribers.fetch_sub(1, Ordering::SeqCst);
    }
}
