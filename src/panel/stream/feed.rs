//! The end of the stream at the thread of the bus.

use core::sync::atomic::{AtomicU64, Ordering};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use super::super::bus_access::BusAccess;
use super::super::state::lengths;
use crate::devices::ag03::drive;
use crate::devices::ag03::drive::Mode;
use crate::devices::ag03::param::Model;
use crate::devices::ag03::profibus::Device;
use crate::explain::value::Lengths;
use crate::host::BusEvent;
use crate::host::link::tap::{Batch, Direction, Watchers};
use crate::profibus::fdl::{Address, MAX_TELEGRAM_LEN};
use crate::time::Instant;

/// Entries that wait in the ring at most; more are counted and lost.
pub(super) const RING: usize = 1024;

/// What the thread of the bus tells.
pub(super) enum Entry {
    News(Instant, BusEvent, Option<Arc<str>>),
    Telegram {
        at: Instant,
        direction: Direction,
        len: usize,
        octets: [u8; MAX_TELEGRAM_LEN],
    },
    /// In what the telegrams behind this one are to be read.
    Settings(Address, Settings),
}

/// What the words of a drive depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Settings {
    pub(super) model: Model,
    pub(super) mode: Mode,
    pub(super) lengths: Lengths,
}

impl Settings {
    /// By the parameters, as whoever reads them on the line knows it: the drive follows within a cycle.
    fn of(device: &Device) -> Self {
        Self {
            model: device.config().model,
            mode: drive::Settings::read(device.parameters()).mode,
            lengths: lengths(device),
        }
    }
}

/// What both ends know.
#[derive(Debug, Default)]
pub(super) struct Shared {
    /// Who watches telegrams.
    pub(super) watchers: Watchers,
    /// How often the settings of all drives were wanted anew.
    pub(super) settings_wanted: AtomicU64,
    pub(super) news_lost: AtomicU64,
    pub(super) telegrams_lost: AtomicU64,
}

/// The settings that were sent since all of them were wanted.
#[derive(Debug, Default)]
pub(in crate::panel) struct SentSettings {
    wanted: u64,
    drives: BTreeMap<u8, Settings>,
}

/// The end of the stream at the thread of the bus. Nothing here waits, and nothing of news and telegrams allocates.
#[derive(Clone, Debug)]
pub(in crate::panel) struct Feed {
    ring: SyncSender<Entry>,
    shared: Arc<Shared>,
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
        if self.ring.try_send(Entry::News(now, *event, words)).is_err() {
            self.shared.news_lost.fetch_add(1, Ordering::Relaxed);
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
                let entry =
                    Entry::Telegram { at: seen.at, direction: seen.direction, len: piece.len(), octets };
                if self.ring.try_send(entry).is_err() {
                    self.shared.telegrams_lost.fetch_add(1, Ordering::Relaxed);
                }
            }
        }
    }

    /// While telegrams are watched: what has changed of the settings, before the telegrams that come with them.
    pub(in crate::panel) fn settings(&self, bench: &BusAccess<'_>, sent: &mut SentSettings) {
        if !self.shared.watchers.any() {
            return;
        }
        let wanted = self.shared.settings_wanted.load(Ordering::Relaxed);
        if sent.wanted != wanted {
            *sent = SentSettings { wanted, drives: BTreeMap::new() };
        }
        for address in bench.bus.addresses() {
            let Some(device) = bench.drive(address) else { continue };
            let settings = Settings::of(device);
            let known = sent.drives.get(&address.number()) == Some(&settings);
            // Without room they are sent the next time.
            if !known && self.ring.try_send(Entry::Settings(address, settings)).is_ok() {
                sent.drives.insert(address.number(), settings);
            }
        }
    }
}
