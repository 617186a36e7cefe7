//! Writes of a master that are answered when the disk has them.

use crate::profibus::dpv1::identification::LEN;
use crate::profibus::dpv1::{Channel, Job};
use crate::time::Instant;

/// What was written and is not safe yet.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Storing {
    /// There is a disk.
    pub(super) on: bool,
    /// Something changed since the last image.
    changed: bool,
    waiting: Vec<Waiting>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct Waiting {
    channel: Channel,
    since: Instant,
    before: Before,
    /// Whether the disk has it; `None`: it does not say yet.
    stored: Option<bool>,
}

/// What was there before.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Before {
    Record { place: (u8, u8), data: Vec<u8> },
    Block { block: u16, octets: [u8; LEN] },
}

/// How far a job that writes is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// It was not carried out yet.
    New,
    /// The disk does not have it yet.
    Waits,
    /// The disk has it.
    Stored,
    /// The disk refused it.
    Failed,
}

impl Storing {
    /// How far a job is. What was asked before at the same place is forgotten.
    pub(super) fn step(&mut self, job: &Job) -> Step {
        let is_this = |waiting: &Waiting| (waiting.channel, waiting.since) == (job.channel, job.since);
        let found = self.waiting.iter().position(is_this);
        let step = match found.and_then(|place| self.waiting.get(place)).map(|waiting| waiting.stored) {
            Some(None) => return Step::Waits,
            Some(Some(true)) => Step::Stored,
            Some(Some(false)) => Step::Failed,
            None => Step::New,
        };
        self.waiting.retain(|waiting| waiting.channel != job.channel);
        step
    }

    /// A job was carried out. Whether its master waits for the disk.
    pub(super) fn wrote(&mut self, job: &Job, before: Before) -> bool {
        self.changed = true;
        if self.on {
            self.waiting.push(Waiting { channel: job.channel, since: job.since, before, stored: None });
        }
        self.on
    }

    /// The device changed a record, which no master waits for. It stays so, whatever becomes of what waits.
    pub(super) fn change(&mut self, changed: (u8, u8), octets: &[u8]) {
        self.changed = true;
        for waiting in &mut self.waiting {
            match &mut waiting.before {
                Before::Record { place, data } if *place == changed => *data = octets.to_vec(),
                Before::Record { .. } | Before::Block { .. } => {}
            }
        }
    }

    /// Whether an image is due.
    pub(super) const fn is_due(&self) -> bool {
        self.on && self.changed
    }

    /// Whether there is something to keep, and whether somebody waits for it.
    pub(super) fn take(&mut self) -> Option<bool> {
        let due = self.is_due();
        self.changed = false;
        due.then(|| self.waiting.iter().any(|waiting| waiting.stored.is_none()))
    }

    /// What became of everything that waits: of what the disk refused what was there before, the newest first.
    pub(super) fn settle(&mut self, stored: bool) -> Vec<Before> {
        let open = self.waiting.iter_mut().rev().filter(|waiting| waiting.stored.is_none());
        let settled = open.map(|waiting| {
            waiting.stored = Some(stored);
            waiting.before.clone()
        });
        let settled: Vec<_> = settled.collect();
        if stored { Vec::new() } else { settled }
    }
}
