//! The middle of the stream: takes what the bus tells and passes it on.

use core::sync::atomic::{AtomicUsize, Ordering};
use core::time::Duration;
use std::collections::BTreeMap;
use std::sync::mpsc::Receiver;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::SystemTime;

use tokio::sync::broadcast;
use tokio::time::{Instant as Moment, sleep};

use super::super::bus_access::Asking;
use super::super::history::{EVERY, History, Sampled};
use super::super::state::LastRefusal;
use super::event::{Item, Lost, NewsEvent, TelegramEvent, message_of};
use super::feed::{Entry, RING, Settings, Shared};
use crate::devices::StationEvent;
use crate::devices::ag03::profibus::Event;
use crate::explain;
use crate::host::BusEvent;
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

/// How often the settings of all drives are asked for while somebody watches telegrams: a drive may change them by
/// itself, and what a subscriber hears may be wrong.
const SETTLE: Duration = Duration::from_secs(1);

/// Takes what the bus tells and passes it on to subscribers.
#[derive(Clone)]
pub(in crate::panel) struct Hub(Arc<Inner>);

struct Inner {
    ring: Mutex<Ring>,
    shared: Arc<Shared>,
    news: broadcast::Sender<Item>,
    telegrams: broadcast::Sender<Item>,
    subscribers: AtomicUsize,
    started: SystemTime,
}

/// The ring, and what was learned from what was in it.
struct Ring {
    entries: Receiver<Entry>,
    last_refusals: BTreeMap<u8, LastRefusal>,
    /// Of stations from a GSD.
    station_refusals: BTreeMap<u8, String>,
    context: explain::Context,
    history: History,
}

impl Hub {
    /// With the end of the ring.
    pub(super) fn new(entries: Receiver<Entry>, shared: Arc<Shared>) -> Self {
        let ring = Ring {
            entries,
            last_refusals: BTreeMap::new(),
            station_refusals: BTreeMap::new(),
            context: explain::Context::default(),
            history: History::default(),
        };
        Self(Arc::new(Inner {
            ring: Mutex::new(ring),
            shared,
            news: broadcast::channel(BEHIND).0,
            telegrams: broadcast::channel(BEHIND).0,
            subscribers: AtomicUsize::new(0),
            started: SystemTime::now(),
        }))
    }

    /// Passes on what the bus tells and keeps samples, for ever.
    pub(in crate::panel) async fn run(self, asking: Asking) {
        tokio::join!(self.pass_on(&asking), self.sample(&asking));
    }

    async fn sample(&self, asking: &Asking) {
        loop {
            sleep(EVERY).await;
            // A bus without time is sampled the next time.
            if let Ok(sampled) = asking.ask(|bench| Sampled::of(bench)).await {
                self.drained().history.samples.keep(sampled);
            }
        }
    }

    /// Settings of drives that the line does not tell are asked for.
    async fn pass_on(&self, asking: &Asking) {
        let mut settled = Moment::now();
        loop {
            let idle = self.0.subscribers.load(Ordering::SeqCst) == 0;
            sleep(if idle { LOOK_IDLE } else { LOOK }).await;
            if self.0.shared.watchers.any() && settled.elapsed() >= SETTLE {
                settled = Moment::now();
                self.0.shared.settings_wanted.fetch_add(1, Ordering::Relaxed);
                asking.wake();
            }
            drop(self.drained());
        }
    }

    /// Somebody watches telegrams as long as what this returns lives. The next request to the bus brings the settings
    /// of all drives, before the telegrams behind it.
    pub(super) fn watch(&self) -> Watch {
        self.0.shared.settings_wanted.fetch_add(1, Ordering::Relaxed);
        self.0.shared.watchers.watch()
    }

    pub(super) fn news(&self) -> broadcast::Receiver<Item> {
        self.0.news.subscribe()
    }

    pub(super) fn telegrams(&self) -> broadcast::Receiver<Item> {
        self.0.telegrams.subscribe()
    }

    /// The newest request that a drive refused.
    pub(in crate::panel) fn last_refusal(&self, address: Address) -> Option<LastRefusal> {
        self.drained().last_refusals.get(&address.number()).cloned()
    }

    /// The newest request that a station from a GSD refused, in words.
    pub(in crate::panel) fn last_station_refusal(&self, address: Address) -> Option<String> {
        self.drained().station_refusals.get(&address.number()).cloned()
    }

    /// What `look` finds in what was.
    pub(in crate::panel) fn history<T>(&self, look: impl FnOnce(&History) -> T) -> T {
        look(&self.drained().history)
    }

    /// When the panel was started.
    pub(in crate::panel) fn started(&self) -> SystemTime {
        self.0.started
    }

    fn drained(&self) -> MutexGuard<'_, Ring> {
        let Inner { ring, shared, news, telegrams, .. } = &*self.0;
        let mut ring = ring.lock().unwrap_or_else(PoisonError::into_inner);
        // No more than there can be: the bus may go on telling.
        for _ in 0..RING {
            let Ok(entry) = ring.entries.try_recv() else { break };
            // Whether somebody hears it is not our concern.
            let _ = match entry {
                Entry::News(at, event, words) => {
                    ring.remember(at, &event);
                    if let (BusEvent::Station { address, .. }, Some(words)) = (&event, &words) {
                        ring.station_refusals.insert(address.number(), format!("{event}: {words}"));
                    }
                    let make = |number| (at, NewsEvent::of(number, at, &event, words.as_deref()));
                    let (_, told) = ring.history.events.keep(make);
                    news.send(told.item())
                }
                Entry::Telegram { at, direction, len, octets } => {
                    let octets = octets.get(..len).unwrap_or_default();
                    ring.history.recording.keep(at, direction, octets);
                    telegrams.send(TelegramEvent::item(at, direction, octets, &mut ring.context))
                }
                Entry::Settings(address, Settings { model, mode, lengths }) => {
                    ring.context.know(address, model, mode, lengths);
                    continue;
                }
            };
        }
        let lost = Lost {
            states: 0,
            news: shared.news_lost.swap(0, Ordering::Relaxed),
            telegrams: shared.telegrams_lost.swap(0, Ordering::Relaxed),
        };
        let message = |lost: &Lost| Item { message: message_of("lost", lost), about: [None, None] };
        if lost.news > 0 {
            let _ = news.send(message(&Lost { telegrams: 0, ..lost }));
        }
        if lost.telegrams > 0 {
            let _ = telegrams.send(message(&Lost { news: 0, ..lost }));
        }
        ring
    }
}

impl Ring {
    fn remember(&mut self, at: Instant, event: &BusEvent) {
        if let BusEvent::Station { address, event: StationEvent::Ag03(Event::CommandRefused(refusal)) } =
            event
        {
            self.last_refusals.insert(address.number(), LastRefusal::of(refusal, at));
        }
    }
}

/// One of the places for subscribers.
pub(super) struct Place(Hub);

impl Place {
    pub(super) fn take(hub: &Hub) -> Option<Self> {
        let taken = hub.0.subscribers.fetch_update(Ordering::SeqCst, Ordering::SeqCst, |count| {
            (count < MOST_SUBSCRIBERS).then_some(count + 1)
        });
        taken.ok().map(|_| Self(hub.clone()))
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.0.0.subscribers.fetch_sub(1, Ordering::SeqCst);
    }
}
