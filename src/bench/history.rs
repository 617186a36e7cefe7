//! What has passed on the line.

use core::fmt;
use std::collections::VecDeque;

use super::Breach;
use crate::profibus::dp;
use crate::profibus::fdl::telegram::{Decoded, decode};
use crate::profibus::fdl::{Address, FrameCount, Function, Telegram};
use crate::time::Instant;

/// So many sendings are kept unless [`Line::keep`](super::Line::keep) says otherwise.
const KEPT: usize = 256;

/// One sending on the line: a telegram, or octets that are none.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Passed {
    /// When its first octet began.
    pub at: Instant,
    /// When its last octet ended.
    pub end: Instant,
    /// Who sent it.
    pub sender: Sender,
    /// As they were on the line, after faults and disturbances.
    pub octets: Vec<u8>,
    /// What the octets do not show.
    pub damage: Damage,
    /// The rule that was broken by sending it, or by sending it then.
    pub breach: Option<Breach>,
}

/// Who sent something.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Sender {
    /// The master under test.
    Master,
    /// The test itself, as another master.
    Test,
    /// A station.
    Station,
}

impl fmt::Display for Sender {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Master => "master",
            Self::Test => "test",
            Self::Station => "station",
        })
    }
}

/// What is wrong with octets as such.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Damage {
    /// Nothing.
    #[default]
    None,
    /// The octet at this place, counted from 0, had wrong parity.
    Parity(usize),
    /// Somebody else sent at the same time: nobody understood it.
    Collision,
}

/// A request that passed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Request<'a> {
    /// Who is asked.
    pub to: Address,
    /// Who asks.
    pub from: Address,
    /// For which service of a DP slave; `None`: FDL status, for example.
    pub service: Option<dp::Service>,
    /// Frame count bit and whether it is valid.
    pub count: FrameCount,
    /// The data behind the SAPs.
    pub data: &'a [u8],
}

impl Passed {
    /// The telegram, if it is a whole and sound one.
    pub(crate) fn telegram(&self) -> Option<Telegram<'_>> {
        match (self.damage, decode(&self.octets)) {
            (Damage::None, Decoded::Telegram { telegram, len }) if len == self.octets.len() => Some(telegram),
            (_, Decoded::Telegram { .. } | Decoded::Incomplete | Decoded::Invalid { .. }) => None,
        }
    }

    /// The request, if it is one.
    pub fn request(&self) -> Option<Request<'_>> {
        let Some(Telegram::Data(data)) = self.telegram() else {
            return None;
        };
        let Function::Request(kind, count) = data.fc.function() else {
            return None;
        };
        let service = match dp::Service::of(data.dsap, data.ssap) {
            // FDL status has no SAPs and is no Data_Exchange.
            Some(dp::Service::DataExchange) if kind == crate::profibus::fdl::Service::FdlStatus => None,
            service => service,
        };
        Some(Request { to: data.da, from: data.sa, service, count, data: data.data })
    }
}

/// The last sendings.
#[derive(Debug)]
pub(super) struct History {
    passed: VecDeque<Passed>,
    most: usize,
    /// How many of the newest nobody has polled.
    unread: usize,
}

impl History {
    pub(super) const fn new() -> Self {
        Self { passed: VecDeque::new(), most: KEPT, unread: 0 }
    }

    pub(super) fn keep(&mut self, most: usize) {
        self.most = most.max(1);
        let over = self.passed.len().saturating_sub(self.most);
        self.passed.drain(..over);
        self.unread = self.unread.min(self.passed.len());
    }

    pub(super) fn push(&mut self, passed: Passed) {
        self.passed.push_back(passed);
        self.unread = (self.unread + 1).min(self.most);
    }

    /// Memory for octets, that of the oldest sending if there is no room for one more.
    pub(super) fn room(&mut self) -> Vec<u8> {
        let oldest = if self.passed.len() >= self.most { self.passed.pop_front() } else { None };
        let mut octets = oldest.map(|passed| passed.octets).unwrap_or_default();
        octets.clear();
        octets
    }

    pub(super) fn iter(&self) -> impl DoubleEndedIterator<Item = &Passed> + ExactSizeIterator {
        self.passed.iter()
    }

    pub(super) fn poll(&mut self) -> Option<Passed> {
        let at = self.passed.len().checked_sub(self.unread)?;
        let passed = self.passed.get(at)?.clone();
        self.unread -= 1;
        Some(passed)
    }
}
